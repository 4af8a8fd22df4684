"""`fly` against `Simulation.run`: the same flight, bit for bit, in counted steps."""

import io
import logging
import subprocess
import sys
from contextlib import redirect_stderr

import numpy as np
import pytest
from pathsim import Connection, Simulation, StopSimulation
from pathsim.blocks import (
    Adder,
    Amplifier,
    Constant,
    Function,
    Integrator,
    SampleHold,
    Scope,
    SinusoidalSource,
    Source,
    StepSource,
    WhiteNoise,
)
from pathsim.events import Condition, Schedule, ZeroCrossing
from pathsim.solvers import RKCK54, RKDP54, SSPRK22
from pathsim.utils.diagnostics import Diagnostics

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


def at(t, act):
    """An event that acts once."""
    return Schedule(t_start=t, t_period=100.0, func_act=lambda t: act())


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


class Parts:
    """Some blocks in a chain, which a change during the run acts on."""

    def __init__(self):
        self.wave, self.noise = SinusoidalSource(frequency=0.7), WhiteNoise(seed=3)
        self.step, self.gain = StepSource(tau=0.3), Amplifier(2.0)
        self.sum, self.hold, self.scope = Adder(), SampleHold(T=0.2), Scope()
        self.pair = Function(lambda a, b: (a + b, a * b))
        self.spare = Constant(5.0)
        self.side = Connection(self.wave, self.scope[0])
        blocks = [self.wave, self.noise, self.step, self.gain, self.sum, self.hold, self.pair]
        wires = [
            self.side,
            Connection(self.step, self.gain, self.scope[1]),
            Connection(self.gain, self.sum[0]),
            Connection(self.noise, self.sum[1]),
            Connection(self.sum, self.pair[1], self.scope[2]),
            # port 5 is for what is added during the run
            Connection(self.wave, self.pair[0], self.scope[6]),
            Connection(self.pair[0, 1], self.scope[4, 3], self.scope[8, 9]),
            Connection(self.pair[1, 0], self.scope[10, 11]),
            Connection(self.wave, self.hold),
            Connection(self.hold, self.scope[7]),
        ]
        self.sim = Simulation([*blocks, self.scope], wires, dt=0.05, log=False)


def nothing(parts):
    pass


def block_off(parts):
    parts.gain.off()


def connection_off(parts):
    parts.side.off()


def parameter_set(parts):
    parts.gain.gain = -3.0
    # PathSim builds these again, with new registers and events
    parts.wave.set(frequency=0.9, amplitude=2.0)
    parts.hold.set(T=0.15)


def block_added(parts):
    parts.sim.add_block(parts.spare)
    parts.sim.add_connection(Connection(parts.spare, parts.scope[5]))


def state_added(parts):
    integral = Integrator()
    parts.sim.add_block(integral)
    parts.sim.add_connection(Connection(parts.sum, integral))
    parts.sim.add_connection(Connection(integral, parts.scope[5]))


def loop_closed(parts):
    back = Amplifier(0.1)
    parts.sim.add_block(back)
    parts.sim.add_connection(Connection(parts.pair[0], back))
    parts.sim.add_connection(Connection(back, parts.sum[2]))


def event_added(parts):
    parts.sim.add_event(
        ZeroCrossing(lambda t: parts.wave.outputs[0], lambda t: setattr(parts.gain, "gain", t))
    )


@pytest.mark.parametrize(
    "change",
    [
        nothing,
        block_off,
        connection_off,
        parameter_set,
        block_added,
        state_added,
        loop_closed,
        event_added,
    ],
)
def test_a_diagram_that_changes_during_the_run_goes_on_as_with_run(change):
    scopes = []
    for run in (Simulation.run, fly):
        parts = Parts()
        parts.sim.add_event(at(0.72, lambda parts=parts: change(parts)))
        assert run(parts.sim, 1.0)["total_steps"] == 20
        assert run(parts.sim, 1.0)["total_steps"] == 20
        scopes.append(parts.scope)
    expected, flown = map(recorded, scopes)
    assert np.array_equal(flown, expected)
    assert flown.shape[1] == 41


def test_a_diagram_that_a_block_changes_as_it_is_evaluated_goes_on_as_with_run():
    scopes = []
    for run in (Simulation.run, fly):
        parts, changed = Parts(), []

        def wave(t, parts=parts, changed=changed):
            if t > 0.82 and not changed:  # the SampleHold acts at 1 s again
                changed.append(t)
                block_added(parts)
            return t

        parts.sim.add_block(Source(wave))
        run(parts.sim, 1.0)
        scopes.append(parts.scope)
    expected, flown = map(recorded, scopes)
    assert np.array_equal(flown, expected)
    assert flown[1 + 5, -1] == 5.0  # below the time


def test_a_step_set_while_it_runs_is_that_of_the_next_run():
    for t in (0.0, 0.05, 0.5):
        times = []
        for run in (Simulation.run, fly):
            parts = Parts()
            parts.sim.add_event(at(t, lambda sim=parts.sim: setattr(sim, "dt", 0.025)))
            assert run(parts.sim, 1.0)["total_steps"] == 20
            assert run(parts.sim, 1.0)["total_steps"] == 40
            times.append(parts.scope.recording_time)
        assert times[0] == times[1]


def test_diagnostics_switched_on_during_the_run_are_kept():
    parts = Parts()
    parts.sim.add_event(at(0.5, lambda: setattr(parts.sim, "diagnostics", Diagnostics())))
    fly(parts.sim, 1.0)
    assert parts.sim.diagnostics.time == parts.sim.time


def test_the_steps_of_a_plain_diagram_are_not_those_of_timestep(monkeypatch):
    timestep, taken = Simulation.timestep, []

    def counted(self, *args, **options):
        taken.append(self.time)
        return timestep(self, *args, **options)

    monkeypatch.setattr(Simulation, "timestep", counted)
    parts = Parts()
    fly(parts.sim, 2.0)
    # the first is a part of PathSim's start; in 10 to 12 the SampleHold acts, in one the StepSource
    assert 12 <= len(taken) <= 14
    taken.clear()
    state_added(parts)
    fly(parts.sim, 2.0)
    assert len(taken) == 40


class Watched(Simulation):
    """A subclass that takes its own steps."""

    steps = 0

    def timestep(self, *args, **options):
        self.steps += 1
        return super().timestep(*args, **options)


def test_a_subclass_takes_its_own_steps():
    source, scope = Source(lambda t: t), Scope()
    sim = Watched([source, scope], [Connection(source, scope)], dt=0.1, log=False)
    fly(sim, 1.0)
    assert sim.steps == 10


def test_steps_are_counted():
    # run adds its steps up to a duration and overshoots by one
    source, scope = SinusoidalSource(), Scope()

    def sim():
        return Simulation([source, scope], [Connection(source, scope)], dt=T, log=False)

    assert fly(sim(), 60.0)["total_steps"] == 7200
    assert fly(sim(), 10 * T)["total_steps"] == 10
    assert fly(sim(), 10.4 * T)["total_steps"] == 11
    assert fly(sim(), 0.3 * T)["total_steps"] == 1


def stopped_by_event(sim):
    sim.add_event(Condition(lambda t=None: sim.time > 0.2, func_act=lambda t: sim.stop()))


def stop():
    raise StopSimulation("far enough")


def stopped_by_exception(sim):
    sim.add_event(at(0.2, stop))


def stopped_at_the_start(sim):
    sim.add_event(at(0.0, stop))


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


@pytest.mark.parametrize("stopped_at", [None, 0.5, 1.0])
def test_it_logs_what_run_logs(caplog, stopped_at):
    def lines(run):
        sim, _ = pitch_hold(log=True)
        if stopped_at is not None:
            sim.add_event(at(stopped_at, sim.stop))
        caplog.clear()
        sim.logger.addHandler(caplog.handler)
        try:
            run(sim)
        finally:
            sim.logger.removeHandler(caplog.handler)
        return [r.message.partition("runtime")[0].partition("|")[0] for r in caplog.records]

    with caplog.at_level(logging.INFO):
        assert lines(lambda sim: fly(sim, 1.0)) == lines(lambda sim: sim.run(1.0))
        assert lines(lambda sim: (sim.run(0.2), fly(sim, 1.0, reset=True))) == lines(
            lambda sim: (sim.run(0.2), sim.run(1.0, reset=True))
        )


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


def test_without_a_console_it_flies_without_a_bar(monkeypatch):
    sim = Parts().sim
    monkeypatch.setattr("sys.stderr", None)
    assert fly(sim, 1.0, progress=True)["total_steps"] == 20


BAR = """
import threading
from pathsim import Simulation
from pathsim.blocks import Constant
from pathsim_jsbsim_blocks import fly
fly(Simulation([Constant()], dt=0.1, log=False), 1.0, progress=True)
print(threading.active_count())
"""


@pytest.mark.long
def test_its_bar_starts_no_thread_that_an_interrupt_could_block():
    done = subprocess.run([sys.executable, "-c", BAR], capture_output=True, text=True, check=True)
    assert done.stdout == "1\n"


@pytest.mark.parametrize("value", [0, -1.0, float("nan"), float("inf"), "10", None])
def test_a_duration_or_a_step_without_which_a_flight_never_ends_is_refused(value):
    sim = Simulation([Scope()], dt=0.1, log=False)
    with pytest.raises(ParameterError) as error:
        fly(sim, value)
    assert error.value.parameter == "duration"
    if value is not None:  # PathSim's choice
        sim.dt = value
        with pytest.raises(ParameterError) as error:
            fly(sim, 0.2)
        assert error.value.parameter == "dt"
        sim.dt = 0.1
    fly(sim, 0.2)
    assert sim.time == pytest.approx(0.2)


def test_a_diagram_of_another_aircraft_may_fly_in_an_event():
    sim, _ = pitch_hold()
    other, scope = pitch_hold()
    sim.add_event(at(0.2, lambda: fly(other, 0.1)))
    fly(sim, 0.5)
    assert len(scope.read()[0]) == 13
