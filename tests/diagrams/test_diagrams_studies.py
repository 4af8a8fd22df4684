"""The diagrams rudder_kick, scheduled_climb and fixed_trim_climb against plain JSBSim loops.

The loops write their inputs after a step and read their outputs before, so that an input takes
effect at the instant at which the diagram's does: outputs can be compared at equal times. The
loops record a command one step late, as the one that was flown.
"""

from pathlib import Path

import numpy as np
import pandas as pd
import plain_jsbsim
import pytest
from test_diagrams_flight import flown

from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.studies import climb_schedule

DATA = Path(__file__).parents[1] / "data" / "studies"
DT = 1 / 120

# the tables hold 12 digits; the atol is for angles that start at zero, in deg
SAME = {"rtol": 1e-11, "atol": 1e-9}

ALPHA_LIMITS = {"aero/alpha-min-rad": np.radians(-4.0), "aero/alpha-max-rad": np.radians(12.0)}


def at(times, scope):
    """The samples of a scope at given times."""
    recorded, data = scope.read()
    index = np.searchsorted(recorded, np.asarray(times) - DT / 2)
    np.testing.assert_allclose(recorded[index], times, rtol=0, atol=1e-9)
    return data[:, index]


def test_rudder_kick():
    diagram = flown("rudder_kick", 20.0)
    table = pd.read_csv(DATA / "07_rudder_kick.csv")
    assert diagram.sim.time == pytest.approx(table.t_s.iloc[-1])
    beta, phi = at(table.t_s, diagram.response)
    np.testing.assert_allclose(beta, table["aero/beta-deg"], **SAME)
    np.testing.assert_allclose(phi, table["attitude/phi-deg"], **SAME)
    [psi] = at(table.t_s, diagram.heading)
    # where JSBSim says 360 deg, the port says 0
    away = (psi - table["attitude/psi-deg"] + 180.0) % 360.0 - 180.0
    np.testing.assert_allclose(away, 0.0, atol=1e-8)
    later = table[1:]
    aileron, rudder = at(later.t_s - DT, diagram.commands)
    np.testing.assert_allclose(aileron, later["fcs/aileron-cmd-norm"], **SAME)
    np.testing.assert_allclose(rudder, later["fcs/rudder-cmd-norm"], **SAME)
    # the rest of the flight: the bank levels out and the heading turns back
    diagram.sim.run(diagram.DURATION - 20.0)
    time, (beta, phi) = diagram.response.read()
    assert beta[time > 10.0] == pytest.approx(13.5, abs=0.3)
    assert phi[-1] == pytest.approx(23.3, abs=0.05)
    assert np.unwrap(diagram.heading.read()[1][0], period=360.0).min() + 360.0 == pytest.approx(
        338.7, abs=0.05
    )


def compare_climb(diagram, table):
    altitude, speed, gamma = at(table.t_s, diagram.flight)
    np.testing.assert_allclose(altitude, table["position/h-sl-ft"], **SAME)
    np.testing.assert_allclose(speed, table["velocities/vc-kts"], **SAME)
    np.testing.assert_allclose(gamma, table["flight-path/gamma-deg"], **SAME)


@pytest.mark.long
def test_scheduled_climb():
    diagram = flown("scheduled_climb")
    table = pd.read_csv(DATA / "10_climb_scheduled_trim.csv")
    compare_climb(diagram, table)

    # the table ends with the last whole second; the loop itself tells when it reached 20,000 ft
    fdm = plain_jsbsim.trimmed("A4", 1000.0, 300.0, gamma=5.0, setup=ALPHA_LIMITS)
    schedule = pd.read_csv(DATA / "10_climb_schedule.csv")
    steps = 0
    while fdm["position/h-sl-ft"] < 20000.0:
        h = fdm["position/h-sl-ft"]
        fdm["fcs/throttle-cmd-norm"] = np.interp(h, schedule.h_ft, schedule.throttle_norm)
        fdm["fcs/pitch-trim-cmd-norm"] = np.interp(h, schedule.h_ft, schedule.pitch_trim_norm)
        fdm.run()
        steps += 1
    assert diagram.sim.time == pytest.approx(steps * DT, abs=DT / 10)
    assert diagram.sim.time == pytest.approx(406.3, abs=0.05)
    assert diagram.fdm.outputs["position/h-sl-ft"] == pytest.approx(
        fdm["position/h-sl-ft"], rel=1e-11
    )


def test_the_tables_of_the_scheduled_climb_are_those_of_the_study():
    diagram = load_diagram("scheduled_climb")
    table = climb_schedule(jobs=1, progress=False)
    np.testing.assert_array_equal(diagram.ALTITUDE, table.requested_altitude_ft)
    # printed with 12 digits
    np.testing.assert_allclose(diagram.THROTTLE, table.throttle_norm, rtol=1e-11)
    np.testing.assert_allclose(diagram.PITCH_TRIM, table.pitch_trim_norm, rtol=1e-11)


def test_fixed_trim_climb():
    diagram = flown("fixed_trim_climb", 150.0)
    table = pd.read_csv(DATA / "10_climb_fixed_trim.csv")
    compare_climb(diagram, table[table.t_s <= 150.0])
    trim = diagram.aircraft.trim
    np.testing.assert_allclose(
        [trim.throttle[0], trim.pitch_trim],
        table.iloc[0][["fcs/throttle-cmd-norm", "fcs/pitch-trim-cmd-norm"]],
        rtol=1e-11,
    )


@pytest.mark.parametrize("name", ["rudder_kick", "scheduled_climb", "fixed_trim_climb"])
def test_figures_show_every_recorded_signal(name):
    diagram = load_diagram(name)
    diagram.sim.run(1.0)
    figure = diagram.figure()
    scopes = [b for b in diagram.sim.blocks if type(b).__name__ == "Scope"]
    curves = [line for ax in figure.axes for line in ax.lines if line.get_label() != "reference"]
    assert len(curves) == sum(len(s.labels) for s in scopes)
