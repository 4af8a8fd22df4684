"""`fly` against `Simulation.run`: the same flight, bit for bit, in counted steps."""

import io
import logging
from contextlib import redirect_stderr

import numpy as np
import pytest
from pathsim import Connection, Simulation, StopSimulation
from pathsim.blocks import Function, Integrator, Scope, SinusoidalSource
from pathsim.events import Condition, Schedule
from pathsim.solvers import RKCK54, RKDP54, SSPRK22

from pathsim_jsbsim_blocks import Aircraft, ParameterError, PitchHold, fly

pytestmark = pytest.mark.matrix

T = 1 / 120


def pitch_hold(continuous=False, **options):
    """A Cessna under its pitch hold, with a continuous state beside it if asked for."""
    plane = Aircraft("c172p", altitude=5000, speed=90)
    hold = PitchHold(gains="c172p", theta_ref=3.0)
    scope = Scope()
    blocks = [plane, hold, scope]
    wires = [
        Connection(plane["theta"], hold["theta"], scope[0]),
        Connection(plane["q"], hold["q"], scope[1]),
        Connection(hold["elevator"], plane["elevator"], scope[2]),
    ]
    if continuous:
        integral = Integrator()
        blocks.append(integral)
        wires.append(Connection(plane["q"], integral))
        wires.append(Connection(integral, scope[3]))
    return Simulation(blocks, wires, **{"dt": T, "log": False, **options}), scope


def recorded(scope):
    time, data = scope.read()
    return np.vstack([time, data])


@pytest.mark.parametrize(
    ("continuous", "options"),
    [
        (False, {}),
        (False, {"dt": T / 2}),
        (False, {"dt": 2 * T}),
        (True, {}),
        (True, {"Solver": SSPRK22}),
        (True, {"Solver": RKCK54, "dt_max": T}),
        (False, {"Solver": RKDP54, "dt_max": T}),
    ],
    ids=str,
)
@pytest.mark.filterwarnings("ignore:.*jumps over a sample instant")
def test_the_flight_is_that_of_run(continuous, options):
    ran, expected = pitch_hold(continuous, **options)
    flown, scope = pitch_hold(continuous, **options)
    for duration in (0.5, 0.3, 0.05):
        # pieces so short that run makes no step too many
        assert fly(flown, duration)["total_steps"] == ran.run(duration)["total_steps"]
    assert np.array_equal(recorded(scope), recorded(expected))
    assert flown.time == ran.time
    assert (
        fly(flown, 0.5, reset=True)["successful_steps"]
        == ran.run(0.5, reset=True)["successful_steps"]
    )
    assert np.array_equal(recorded(scope), recorded(expected))


def test_steps_are_counted():
    # run adds its steps up to a duration and overshoots by one
    source, scope = SinusoidalSource(), Scope()

    def sim():
        return Simulation([source, scope], [Connection(source, scope)], dt=T, log=False)

    assert fly(sim(), 600.0)["total_steps"] == 72_000
    assert fly(sim(), 10 * T)["total_steps"] == 10
    assert fly(sim(), 10.4 * T)["total_steps"] == 11
    assert fly(sim(), 0.3 * T)["total_steps"] == 1


def stopped_by_event(sim):
    sim.add_event(Condition(lambda t=None: sim.time > 0.2, func_act=lambda t: sim.stop()))


def stopped_by_exception(sim):
    def stop(t):
        raise StopSimulation("far enough")

    sim.add_event(Schedule(t_start=0.2, t_period=10.0, func_act=stop))


def stopped_at_the_start(sim):
    def stop(t):
        raise StopSimulation("not at all")

    sim.add_event(Schedule(t_start=0.0, t_period=10.0, func_act=stop))


@pytest.mark.parametrize(
    "condition", [stopped_by_event, stopped_by_exception, stopped_at_the_start]
)
def test_stop_conditions_end_it_as_they_end_run(condition):
    ran, expected = pitch_hold()
    flown, scope = pitch_hold()
    for sim in (ran, flown):
        condition(sim)
    assert fly(flown, 1.0)["total_steps"] == ran.run(1.0)["total_steps"]
    assert flown.time == ran.time < 0.5
    if ran.time:
        assert np.array_equal(recorded(scope), recorded(expected))


def test_it_logs_what_run_logs(caplog):
    def lines(run):
        sim, _ = pitch_hold(log=True)
        caplog.clear()
        sim.logger.addHandler(caplog.handler)
        try:
            run(sim)
        finally:
            sim.logger.removeHandler(caplog.handler)
        return [r.message.partition("runtime")[0].partition("|")[0] for r in caplog.records]

    with caplog.at_level(logging.INFO):
        assert lines(lambda sim: fly(sim, 2.0)) == lines(lambda sim: sim.run(2.0))


def test_after_an_exception_it_goes_on():
    fails = {"now": False}

    def law(u):
        if fails["now"]:
            raise OSError("sensor lost")
        return u

    plane, sensor, scope = Aircraft("c172p", altitude=5000, speed=90), Function(law), Scope()
    sim = Simulation(
        [plane, sensor, scope],
        [Connection(plane["theta"], sensor), Connection(sensor, scope)],
        dt=T,
        log=False,
    )
    fly(sim, 0.5)
    fails["now"] = True
    with pytest.raises(OSError, match="sensor lost"):
        fly(sim, 0.5)
    fails["now"] = False
    fly(sim, 0.5)
    assert plane.samples == 120


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_the_bar_shows_simulated_time_and_its_ratio_to_real_time():
    sim, _ = pitch_hold()
    with redirect_stderr(io.StringIO()) as stderr:
        fly(sim, 2.0, progress=True)
        assert "/2.0 s in" in stderr.getvalue()
        assert " s/s" in stderr.getvalue()
    with redirect_stderr(Terminal()) as stderr:
        fly(sim, 2.0)  # done in less than the 2 s after which a bar appears
        assert stderr.getvalue() == ""
    with redirect_stderr(io.StringIO()) as stderr:
        fly(sim, 2.0)  # not a terminal
        fly(sim, 2.0, progress=False)
        assert stderr.getvalue() == ""


@pytest.mark.parametrize("duration", [0, -1.0, float("nan"), float("inf"), "10", None])
def test_a_duration_that_cannot_be_is_refused(duration):
    sim, _ = pitch_hold()
    with pytest.raises(ParameterError, match="duration"):
        fly(sim, duration)
    assert sim.time == 0.0
