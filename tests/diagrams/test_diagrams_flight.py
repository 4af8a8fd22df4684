"""The introductory flight diagrams against plain JSBSim loops.

The tables in tests/data/studies carry 12 digits, so rtol 1e-11 is their rounding; the atol of 1e-9
covers values that are zero but for rounding.
"""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pathsim_jsbsim_blocks import fly
from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.plots import signal

pytestmark = pytest.mark.matrix

DATA = Path(__file__).parents[1] / "data" / "studies"


def flown(name, duration=None):
    module = load_diagram(name)
    fly(module.sim, duration or module.DURATION)
    return module


def at(time, values, wanted):
    k = np.round(wanted * 120).astype(int)
    assert np.abs(time[k] - wanted).max() < 1e-9
    return values[k]


def close(values, expected):
    np.testing.assert_allclose(values, expected, rtol=1e-11, atol=1e-9)


# diagram, table, and the property of the table that each recorded signal is
FLIGHTS = {
    "trimmed_flight": (
        "02_trimmed_flight.csv",
        {
            "flight altitude": "position/h-sl-ft",
            "flight calibrated airspeed": "velocities/vc-kts",
            "attitude angle of attack": "aero/alpha-deg",
            "attitude pitch angle": "attitude/theta-deg",
            "attitude roll angle": "attitude/phi-deg",
            "heading heading": "attitude/psi-deg",
            "load load factor nx": "accelerations/Nx",
            "load load factor nz": "accelerations/Nz",
            "track latitude": "position/lat-geod-deg",
            "track longitude": "position/long-gc-deg",
        },
    ),
    "aileron_turn": (
        "02_aileron_turn.csv",
        {
            "scope roll angle": "attitude/phi-deg",
            "scope heading": "attitude/psi-deg",
            "scope altitude": "position/h-sl-ft",
            "flow angle of attack": "aero/alpha-deg",
            "flow sideslip angle": "aero/beta-deg",
        },
    ),
}


def compared(name):
    """The diagram, flown as its table."""
    file, signals = FLIGHTS[name]
    module, expected = flown(name), pd.read_csv(DATA / file)
    for place, prop in signals.items():
        scope, _, label = place.partition(" ")
        time, values = signal(getattr(module, scope), label)
        close(at(time, values, expected["t_s"]), expected[prop])
    return module


def test_trimmed_flight():
    compared("trimmed_flight")


def test_hello_jsbsim():
    module = flown("hello_jsbsim")
    expected = pd.read_csv(DATA / "01_hello_world.csv").set_index(["when", "property"]).value
    trim = module.aircraft.trim
    close(trim.throttle[0], expected["trim", "fcs/throttle-cmd-norm[0]"])
    close(trim.pitch_trim, expected["trim", "fcs/pitch-trim-cmd-norm"])
    close(trim.alpha, expected["trim", "aero/alpha-deg"])
    for label, name in (
        ("altitude", "position/h-sl-ft"),
        ("true airspeed", "velocities/vt-fps"),
        ("pitch angle", "attitude/theta-deg"),
        ("roll angle", "attitude/phi-deg"),
        ("heading", "attitude/psi-deg"),
    ):
        close(signal(module.scope, label)[1][-1], expected["t=1s", name])


def test_elevator_doublet():
    module = flown("elevator_doublet")
    expected = pd.read_csv(DATA / "04_elevator_doublet.csv")
    time, command = signal(module.scope, "elevator command")
    _, alpha = signal(module.scope, "angle of attack")
    t = expected["t_s"]
    # the table shows the property after the step that ended at t, so the input of that step
    close(at(time, command, t[1:] - 1 / 120), 100 * expected["fcs/elevator-cmd-norm"][1:])
    close(at(time, alpha, t), expected["aero/alpha-deg"])
    # what the docstring says
    assert (alpha[0], alpha.max(), alpha.min()) == pytest.approx((4.32, 6.4, 1.8), abs=0.05)
    assert np.abs(alpha - alpha[0])[time > 17.0].max() < 0.1


@pytest.mark.long
def test_doublet_linear_nonlinear():
    module = flown("doublet_linear_nonlinear")
    expected = pd.read_csv(DATA / "04_elevator_doublet.csv")
    time, linear = signal(module.attack, "angle of attack, linear")
    # the published flight, whose doublet begins at 10 s instead of 1 s
    t = expected["t_s"]
    t, alpha = t[t > 9.0], expected["aero/alpha-deg"][t > 9.0]
    seen = t - 9.0 < module.DURATION
    apart = at(time, linear, t[seen] - 9.0) - alpha[seen]
    assert np.abs(apart).max() < 0.09
    _, difference = signal(module.missed, "difference in angle of attack")
    assert 0.05 < np.abs(difference).max() < 0.09


def test_aileron_turn_is_no_ten_degree_turn():
    module = compared("aileron_turn")
    # what the docstring says: roll angle at 5, 15 and 28 s, its extremes afterwards, turn, loss
    time, phi = signal(module.scope, "roll angle")
    assert at(time, phi, np.array([5.0, 15.0, 28.0])) == pytest.approx([-57, -43, -60], abs=0.5)
    late = time > 10.0
    assert time[late][phi[late].argmax()] == pytest.approx(15.0, abs=0.5)
    assert time[late][phi[late].argmin()] == pytest.approx(28.0, abs=0.5)
    _, psi = signal(module.scope, "heading")
    assert np.unwrap(psi, period=360.0)[-1] - 90.0 == pytest.approx(-286, abs=0.5)
    _, h = signal(module.scope, "altitude")
    assert h[0] - h[-1] == pytest.approx(808, abs=0.5)


@pytest.mark.long
def test_dutch_roll():
    module = flown("dutch_roll")
    system = module.sim.to_statespace(
        inputs=[module.gain_0["pulse"]], outputs=[module.gain_0["beta"]]
    )
    poles = np.linalg.eigvals(system.A)
    _, slips = module.slip.read()
    for expected, beta in zip((0.16, 0.37, 0.58), slips, strict=True):
        # least squares of a sum of four exponentials (Prony) at 10 Hz after the pulse
        y = beta[204:984:12] - beta[0]
        past = np.column_stack([y[3 - i : len(y) - 1 - i] for i in range(4)])
        weights = np.linalg.lstsq(past, y[4:], rcond=None)[0]
        roots = np.log(np.roots([1.0, *-weights]).astype(complex)) / 0.1
        pole = max((x for x in roots if x.imag > 0.5), key=lambda x: x.real)
        assert -pole.real / abs(pole) == pytest.approx(expected, abs=0.01)
        # the linear model of the diagram has that pair too: the delay of sampling is a lag there
        assert np.abs(poles - pole).min() < 0.01 * abs(pole)
