"""Modes and flying qualities: against the flight itself, textbook matrices and the standard."""

import math

import numpy as np
import pytest
from how_many import first
from test_model import flown, plane

from pathsim_jsbsim_blocks import Aircraft, ParameterError
from pathsim_jsbsim_blocks.linear import LinearModel, Mode, flying_qualities


def model(A, states, B=None, inputs=(), V=500.0):
    """A linear model with given matrices."""
    n, m = len(states), len(inputs)
    x0 = [V if name == "vt" else 0.0 for name in states]
    return LinearModel(
        aircraft="textbook", condition="", method="flown", A=A, B=np.zeros((n, m)) if B is None else B,
        C=np.zeros((0, n)), D=np.zeros((0, m)), states=states, inputs=inputs, outputs=(),
        units={}, x0=x0, u0=np.zeros(m), y0=[], dt=1 / 120, latency=np.zeros(m),
        kinks=np.zeros((0, m)), fit=np.zeros((0, m)),
    )  # fmt: skip


# beta, p, r, phi in rad: signs and sizes of an airliner at low speed; its poles follow from the
# characteristic polynomial
LATERAL = np.array(
    [
        [-0.0999, 0.0, -1.0, 0.1153],
        [-1.63, -1.10, 0.198, 0.0],
        [0.247, -0.125, -0.229, 0.0],
        [0.0, 1.0, 0.0, 0.0],
    ]
)


def test_a_lateral_matrix_has_its_three_modes():
    found = {m.name: m for m in model(LATERAL, ("beta", "p", "r", "phi")).modes()}
    assert set(found) == {"Dutch roll", "roll", "spiral"}
    poles = np.roots(np.poly(LATERAL))
    dutch = next(pole for pole in poles if pole.imag > 0)
    assert found["Dutch roll"].pole == pytest.approx(dutch)
    assert found["Dutch roll"].frequency == pytest.approx(abs(dutch))
    assert found["Dutch roll"].period == pytest.approx(2 * math.pi / dutch.imag)
    real = sorted(pole.real for pole in poles if pole.imag == 0)
    assert found["roll"].pole.real == pytest.approx(real[0])
    assert found["spiral"].pole.real == pytest.approx(real[1])


def test_units_do_not_change_the_shares():
    names = ("beta", "p", "r", "phi")
    scale = np.array([1.0, 57.3, 0.01, 1000.0])
    one = model(LATERAL, names).modes()
    other = model(scale[:, None] * LATERAL / scale, names).modes()
    for a, b in zip(one, other, strict=True):
        assert (a.name, a.pole) == (b.name, pytest.approx(b.pole))
        assert a.participation == pytest.approx(b.participation, abs=1e-9)
        assert sum(a.participation.values()) == pytest.approx(1.0)


def test_integrals_of_the_motion_are_told_apart():
    A = np.zeros((6, 6))
    A[:4, :4] = LATERAL
    A[4, 2] = 1.0  # heading
    A[5, 4] = 500.0  # and the position that it leads to: two poles at 0 in a chain
    found = model(A, ("beta", "p", "r", "phi", "psi", "lat")).modes()
    assert {m.name for m in found[-2:]} == {"heading", "position"}
    assert {m.name for m in found} >= {"Dutch roll", "roll", "spiral"}


@pytest.mark.parametrize(
    ("poles", "names"),
    [
        ([-1 + 2j, -0.01 + 0.1j], {"short period", "phugoid"}),
        ([-3.0, -0.7, -0.01 + 0.1j], {"short period", "phugoid"}),
    ],
)
def test_longitudinal_modes_with_their_own_states(poles, names):
    # alpha and q make the fast modes, vt and theta the slow one
    A = np.zeros((4, 4))
    i = 0
    for pole in poles:
        if pole.imag:
            A[i : i + 2, i : i + 2] = [[pole.real, pole.imag], [-pole.imag, pole.real]]
            i += 2
        else:
            A[i, i] = pole.real
            i += 1
    assert {m.name for m in model(A, ("alpha", "q", "vt", "theta")).modes()} == names


@pytest.mark.parametrize(
    ("pole", "text"),
    [
        (-0.6 + 0.8j, "m: 1 rad/s, damping ratio 0.600, period 7.85 s, halves in 1.16 s (q)"),
        (0.01 + 0j, "m: 0.01 rad/s, doubles in 69.3 s (q)"),
        (0j, "m: at the origin (q)"),
    ],
)
def test_a_mode_is_printed_in_one_line(pole, text):
    assert str(Mode("m", pole, {"q": 0.95, "theta": 0.05})) == text


def test_time_to_half_and_to_double():
    (stable,) = model([[-0.5]], ("phi",)).modes()
    (unstable,) = model([[0.5]], ("phi",)).modes()
    assert stable.time_to_half == pytest.approx(math.log(2) / 0.5)
    assert math.isnan(stable.time_to_double)
    assert unstable.time_to_double == pytest.approx(math.log(2) / 0.5)
    assert (stable.damping, unstable.damping) == (1.0, -1.0)


def pair(frequency, damping):
    re, im = -damping * frequency, frequency * math.sqrt(1 - damping**2)
    return [[re, im], [-im, re]]


def level(A, states, name, **keywords):
    found = {
        q.name: q
        for q in flying_qualities(model(A, states, **keywords.pop("more", {})), **keywords)
    }
    return found[name].level


# limits as printed in MIL-F-8785C, approached from both sides
@pytest.mark.parametrize(
    ("damping", "category", "expected"),
    [
        (0.36, "A", 1), (0.34, "A", 2), (0.24, "A", 3), (0.14, "A", 4),
        (0.31, "B", 1), (0.29, "B", 2), (0.19, "B", 3), (0.36, "C", 1),
    ],
)  # fmt: skip
def test_short_period_damping(damping, category, expected):
    A = pair(2.0, damping)
    assert level(A, ("alpha", "q"), "short-period damping ratio", category=category) == expected


@pytest.mark.parametrize(("damping", "expected"), [(0.05, 1), (0.03, 2), (-0.05, 3), (-0.3, 4)])
def test_phugoid_damping(damping, expected):
    # 0.1 rad/s: a damping ratio of -0.126 doubles in 55 s
    A = np.zeros((4, 4))
    A[:2, :2], A[2:, 2:] = pair(2.0, 0.5), pair(0.1, damping)
    assert level(A, ("alpha", "q", "vt", "theta"), "phugoid damping ratio") == expected


@pytest.mark.parametrize(
    ("frequency", "damping", "category", "aircraft_class", "expected"),
    [
        (2.0, 0.20, "A", "IV", 1), (2.0, 0.18, "A", "IV", 2), (2.0, 0.09, "B", "III", 1),
        (2.0, 0.07, "B", "III", 2), (2.0, 0.01, "B", "III", 3), (2.0, -0.01, "B", "III", 4),
    ],
)  # fmt: skip
def test_dutch_roll_damping(frequency, damping, category, aircraft_class, expected):
    A = pair(frequency, damping)
    options = {"category": category, "aircraft_class": aircraft_class}
    assert level(A, ("beta", "r"), "Dutch roll damping ratio", **options) == expected


@pytest.mark.parametrize(
    ("T", "category", "aircraft_class", "expected"),
    [
        (0.9, "A", "I", 1), (1.1, "A", "I", 2), (1.3, "B", "I", 1), (2.9, "B", "III", 2),
        (3.1, "C", "III", 3), (1.1, "C", "II-C", 2), (1.1, "C", "II-L", 1), (11.0, "B", "I", 4),
    ],
)  # fmt: skip
def test_roll_mode(T, category, aircraft_class, expected):
    options = {"category": category, "aircraft_class": aircraft_class}
    assert level([[-1 / T]], ("p",), "roll mode time constant", **options) == expected


@pytest.mark.parametrize(
    ("double", "category", "expected"),
    [
        (13, "A", 1),
        (11, "A", 2),
        (7, "C", 3),
        (3, "C", 4),
        (21, "B", 1),
        (19, "B", 2),
        (-9, "B", 1),
    ],
)
def test_spiral(double, category, expected):
    A = [[math.log(2) / double]]
    assert level(A, ("phi",), "spiral time to double", category=category) == expected


# lowest damping ratio, product (rad/s) and frequency (rad/s) of levels 1 to 3, as printed
DUTCH_ROLL = {
    ("A", "I IV"): ((0.19, 0.35, 1.0), (0.02, 0.05, 0.4), (0.0, 0.0, 0.4)),
    ("A", "II-L II-C III"): ((0.19, 0.35, 0.4), (0.02, 0.05, 0.4), (0.0, 0.0, 0.4)),
    ("B", "I II-L II-C III IV"): ((0.08, 0.15, 0.4), (0.02, 0.05, 0.4), (0.0, 0.0, 0.4)),
    ("C", "I II-C IV"): ((0.08, 0.15, 1.0), (0.02, 0.05, 0.4), (0.0, 0.0, 0.4)),
    ("C", "II-L III"): ((0.08, 0.10, 0.4), (0.02, 0.05, 0.4), (0.0, 0.0, 0.4)),
}
# longest time constant in s
ROLL = {
    ("A", "I IV"): (1.0, 1.4, 10.0),
    ("A", "II-L II-C III"): (1.4, 3.0, 10.0),
    ("B", "I II-L II-C III IV"): (1.4, 3.0, 10.0),
    ("C", "I II-C IV"): (1.0, 1.4, 10.0),
    ("C", "II-L III"): (1.4, 3.0, 10.0),
}
SHORT_PERIOD = {"A": (0.35, 0.25, 0.15), "B": (0.30, 0.20, 0.15), "C": (0.35, 0.25, 0.15)}
SPIRAL = {"A": (12.0, 8.0, 4.0), "B": (20.0, 8.0, 4.0), "C": (12.0, 8.0, 4.0)}


def printed():
    """Requirement, category, class, limits of levels 1 to 3, and a model with the value x."""
    for category, limits in SHORT_PERIOD.items():
        yield (
            ("short-period damping ratio", category, "I", limits),
            (("alpha", "q"), lambda x: pair(2.0, x)),
        )
    for category, limits in SPIRAL.items():
        yield (
            ("spiral time to double", category, "I", limits),
            (("phi",), lambda x: [[math.log(2) / x]]),
        )
    shapes = (
        ("ratio", lambda x: pair(3.0, x)),
        ("times frequency", lambda x: pair(1.5, x / 1.5)),
        ("frequency", lambda x: pair(x, 0.5)),
    )
    for (category, classes), rows in DUTCH_ROLL.items():
        for aircraft_class in classes.split():
            for (name, shape), limits in zip(shapes, zip(*rows, strict=True), strict=True):
                full = (
                    "Dutch roll frequency" if name == "frequency" else f"Dutch roll damping {name}"
                )
                yield (full, category, aircraft_class, limits), (("beta", "r"), shape)
    for (category, classes), limits in ROLL.items():
        for aircraft_class in classes.split():
            yield (
                ("roll mode time constant", category, aircraft_class, limits),
                (("p",), lambda x: [[-1 / x]]),
            )


@pytest.mark.parametrize(
    ("row", "shape"), [pytest.param(*x, id=" ".join(x[0][:3])) for x in printed()]
)
def test_each_level_ends_where_the_standard_has_it(row, shape):
    (name, category, aircraft_class, limits), (states, matrix) = row, shape
    longest = name.startswith("roll mode")
    for limit in limits:
        for x in (0.996 * limit, 1.004 * limit) if limit else ():
            within = [x <= bound if longest else x >= bound for bound in limits]
            expected = within.index(True) + 1 if any(within) else 4
            options = {"category": category, "aircraft_class": aircraft_class}
            assert level(matrix(x), states, name, **options) == expected, x


def test_control_anticipation_of_the_short_period_approximation():
    # n/alpha = V / g (-Z_alpha / V) where the elevator gives no lift
    z, m_alpha, m_q, V = -1.2, -4.0, -1.5, 500.0
    A, B = [[z, 1.0], [m_alpha, m_q]], [[0.0], [-6.0]]
    A = np.block([[np.array(A), np.zeros((2, 1))], [np.zeros((1, 3))]])
    A[2, 2], A[2, 0] = -0.01, -3.0
    built = model(A, ("alpha", "q", "vt"), np.vstack([B, [0.0]]), ("elevator",), V)
    found = {q.name: q.value for q in flying_qualities(built)}
    frequency2 = z * m_q - m_alpha
    assert found["control anticipation parameter"] == pytest.approx(
        frequency2 / (V / 32.174 * -z), rel=1e-6
    )


def test_bad_input():
    built = model(LATERAL, ("beta", "p", "r", "phi"))
    with pytest.raises(ParameterError, match="category must be one of"):
        flying_qualities(built, category="D")
    with pytest.raises(ParameterError, match="aircraft_class must be one of"):
        flying_qualities(built, aircraft_class="V")


def decrement(y):
    """Natural frequency and damping ratio from the extrema of a decaying oscillation."""
    turns = np.flatnonzero(np.diff(np.sign(np.diff(y))) != 0) + 1
    # parabolas through three samples give the extrema between them
    times, values = [], []
    for k in turns:
        a, b = (y[k + 1] + y[k - 1]) / 2 - y[k], (y[k + 1] - y[k - 1]) / 2
        times.append(k - b / (2 * a))
        values.append(y[k] - b**2 / (4 * a))
    swings = np.abs(np.diff(values))
    half = np.mean(np.diff(times)) / 120
    delta = np.mean(np.log(swings[:-1] / swings[1:]))
    damping = delta / math.hypot(math.pi, delta)
    return math.pi / half / math.sqrt(1 - damping**2), damping


def prony(y, dt, order, slowest=0.1):
    """Natural frequency and damping ratio of the oscillation in a sum of exponentials.

    A decrement needs more swings than a Dutch roll with a damping ratio of 0.5 has.
    """
    past = np.column_stack([y[order - 1 - i : len(y) - 1 - i] for i in range(order)])
    weights = np.linalg.lstsq(past, y[order:], rcond=None)[0]
    poles = np.log(np.roots([1.0, *-weights]).astype(complex)) / dt
    pole = max((x for x in poles if slowest < x.imag < 9.0), key=lambda x: x.real)
    return abs(pole), -pole.real / abs(pole)


def flight_of(name, port, size, seconds, output):
    """An output after a pulse of 0.5 s, less that of the untouched aircraft."""
    u = np.zeros((int(120 * seconds), 4))
    still = flown(name, u)
    u[:60, port] = size
    return (flown(name, u) - still)[:, Aircraft.output_port_labels[output]]


@pytest.mark.parametrize("name", first(["c172p", "737", "global5000"], count=1))
def test_modes_are_those_of_the_flight(name):
    found = {m.name: m for m in plane(name).linear_model().modes()}
    # the phugoid long after the short period, the Dutch roll with the other lateral modes
    swings = flight_of(name, 0, 0.02, 80 if name == "c172p" else 220, "vt")[1200:]
    slip = flight_of(name, 2, 0.05, 8, "beta")[84::12]
    rate = flight_of(name, 0, 0.02, 6, "q")[70:550:12]
    flights = {
        "phugoid": decrement(swings),
        "Dutch roll": prony(slip, 0.1, 4),
        # the phugoid is in the data too
        "short period": prony(rate, 0.1, 4, slowest=0.5),
    }
    for mode, (frequency, damping) in flights.items():
        period = 2 * math.pi / (frequency * math.sqrt(1 - damping**2))
        assert found[mode].period == pytest.approx(period, rel=0.03), mode
        assert found[mode].damping == pytest.approx(damping, rel=0.10), mode
