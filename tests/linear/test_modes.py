"""Modes and flying qualities: against the flight itself, textbook matrices and the standard."""

import csv
import itertools
import math
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from how_many import first
from test_model import flown, plane

from pathsim_jsbsim_blocks import Aircraft, ParameterError
from pathsim_jsbsim_blocks.linear import LinearModel, Mode, flying_qualities

DATA = Path(__file__).parents[1] / "data"


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
    return {q.name: q for q in flying_qualities(model(A, states), **keywords)}[name].level


def anticipating(parameter):
    """A short period of that control anticipation parameter, rad2/s2 per g."""
    # n/alpha = V / g (-Z_alpha / V) where the elevator gives no lift; V = 500 ft/s
    z, m_q = -0.5, -0.1
    m_alpha = z * m_q - parameter * 500.0 / 32.174 * -z
    return [[z, 1.0, 0.0], [m_alpha, m_q, 0.0], [-3.0, 0.0, -0.01]]


# by requirement: the states of a model, its matrix for a value x, and what else it has
SHAPES = {
    "phugoid damping ratio": (("alpha", "q", "vt", "theta"), lambda x: with_phugoid(x), {}),
    "phugoid time to double": (
        ("alpha", "q", "vt", "theta"),
        lambda x: with_phugoid(-math.log(2) / x / 0.1),
        {},
    ),
    "control anticipation parameter": (
        ("alpha", "q", "vt"),
        anticipating,
        {"B": [[0.0], [-6.0], [0.0]], "inputs": ("elevator",)},
    ),
    "short-period damping ratio": (("alpha", "q"), lambda x: pair(2.0, x), {}),
    "Dutch roll damping ratio": (("beta", "r"), lambda x: pair(3.0, x), {}),
    "Dutch roll damping times frequency": (("beta", "r"), lambda x: pair(1.5, x / 1.5), {}),
    "Dutch roll frequency": (("beta", "r"), lambda x: pair(x, 0.5), {}),
    "roll mode time constant": (("p",), lambda x: [[-1 / x]], {}),
    "spiral time to double": (("phi",), lambda x: [[math.log(2) / x]], {}),
}


def with_phugoid(damping):
    A = np.zeros((4, 4))
    A[:2, :2], A[2:, 2:] = pair(2.0, 0.5), pair(0.1, damping)
    return A


def printed():
    """Limits of the standard by requirement, category and class: paragraph, limits by level."""
    table = defaultdict(lambda: ("", {}))
    with (DATA / "mil_f_8785c.csv").open() as file:
        for row in csv.DictReader(file):
            classes = "I II-L II-C III IV" if row["classes"] == "all" else row["classes"]
            for where in itertools.product(row["categories"].split(), classes.split()):
                _, levels = table[(row["requirement"], *where)]
                levels[int(row["level"])] = (
                    float(row["lowest"] or -math.inf),
                    float(row["highest"] or math.inf),
                )
                table[(row["requirement"], *where)] = row["paragraph"], levels
    return table


def test_each_level_ends_where_the_standard_has_it():
    table = printed()
    assert {name for name, *_ in table} == set(SHAPES)
    assert len(table) == len(SHAPES) * 3 * 5
    for (name, category, aircraft_class), (paragraph, levels) in table.items():
        states, matrix, more = SHAPES[name]
        for limit in {x for limits in levels.values() for x in limits}:
            # an oscillation has a damping ratio below 1
            if math.isinf(limit) or (name.endswith("damping ratio") and limit > 1.0):
                continue
            for x in (limit - 0.004 * abs(limit or 1.0), limit + 0.004 * abs(limit or 1.0)):
                met = [i for i, (low, high) in sorted(levels.items()) if low <= x <= high]
                # a level without a limit is met by any value
                expected = met[0] if met else 4 if 3 in levels else 3
                found = {
                    q.name: q
                    for q in flying_qualities(
                        model(matrix(x), states, **more),
                        category=category,
                        aircraft_class=aircraft_class,
                    )
                }[name.replace("phugoid time to double", "phugoid damping ratio")]
                place = (name, category, aircraft_class, x)
                assert (found.level, found.paragraph) == (expected, paragraph), place


@pytest.mark.parametrize("category", ["A", "B", "C"])
def test_a_stable_spiral_is_of_level_1(category):
    assert level([[-0.1]], ("phi",), "spiral time to double", category=category) == 1


@pytest.mark.parametrize(("category", "expected"), [("A", 2), ("B", 1), ("C", 2)])
def test_a_short_period_of_two_real_poles_has_a_damping_ratio(category, expected):
    # a Concorde at 24,000 ft and 300 kt: (6.57 + 1.00) / (2 sqrt(6.57 1.00)) is 1.477
    A = [[-1.3, 1.0], [-(6.57 - 1.3) * (1.0 - 1.3), -6.27]]
    built = model(A, ("alpha", "q"))
    assert sorted(m.pole.real for m in built.modes()) == pytest.approx([-6.57, -1.0], abs=1e-9)
    (found,) = flying_qualities(built, category=category)
    assert found.name == "short-period damping ratio"
    assert found.value == pytest.approx(1.477, abs=1e-3)
    assert found.level == expected


def test_bad_input():
    built = model(LATERAL, ("beta", "p", "r", "phi"))
    with pytest.raises(ParameterError) as error:
        flying_qualities(built, category="D")
    assert (error.value.parameter, error.value.value) == ("category", "D")
    with pytest.raises(ParameterError) as error:
        flying_qualities(built, aircraft_class="V")
    assert (error.value.parameter, error.value.value) == ("aircraft_class", "V")


def prony(y, dt, order, slowest=0.1):
    """Natural frequency and damping ratio of the oscillation in a sum of exponentials."""
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
        "phugoid": prony(swings[::240], 2.0, 4, slowest=0.02),
        "Dutch roll": prony(slip, 0.1, 4),
        # the phugoid is in the data too
        "short period": prony(rate, 0.1, 4, slowest=0.5),
    }
    for mode, (frequency, damping) in flights.items():
        period = 2 * math.pi / (frequency * math.sqrt(1 - damping**2))
        assert found[mode].period == pytest.approx(period, rel=0.03), mode
        assert found[mode].damping == pytest.approx(damping, rel=0.10), mode
