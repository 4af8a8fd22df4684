"""Wherever a step ends, nothing of it is left to the next flight, and the flight can go on."""

import contextlib
import math
import sys

import pytest
from how_many import first
from pathsim import Connection, Simulation, StopSimulation
from pathsim.blocks import Amplifier, Block, Constant, Integrator, Source
from pathsim.events import Condition, Schedule, ZeroCrossing
from pathsim.solvers import RK4, RKCK54, RKDP54, SSPRK22
from sampled_blocks import Integral, Mass, nested

from pathsim_jsbsim_blocks import ParameterError, fly

T = 0.125  # s; sums of it and of its parts are exact
COUNT = 8  # instants of a flight


class Record(Block):
    """Its inputs at each instant, as they were sampled last."""

    def __init__(self):
        super().__init__()
        self.rows = {}

    def reset(self):
        super().reset()
        self.rows = {}

    def sample(self, t, dt):
        k = t / T
        if abs(k - round(k)) < 1e-9:
            self.rows[round(k)] = self.inputs.to_array().tolist()


class Loop:
    """A mass under two laws of two periods, a reference and, beside them, continuous states."""

    def __init__(self, depth=0, states=0, parts=1, events=(), **options):
        self.reference = Source(lambda t: math.sin(round(8.0 * t / T)))
        self.calls = Source(self.called)
        self.first, self.second, self.record = Integral(T), Integral(2 * T), Record()
        self.mass = Mass(T)
        mass, first = nested(self.mass, 2, depth), nested(self.first, 2, max(depth - 1, 0))
        integrators = [Integrator() for _ in range(states)]
        self.action, added = lambda t: None, Amplifier(0.7)
        blocks = [self.calls, first, mass, self.second, self.reference, self.record, added]
        wires = [
            Connection(self.reference, first[0], self.second[0], self.record[3]),
            Connection(mass, first[1], self.second[1], self.record[0], *integrators),
            Connection(first, added, self.record[1]),
            Connection(added, mass),
            Connection(self.second, self.record[2]),
        ]
        options = {"dt": T / parts, "log": False, **options}
        self.sim = Simulation([*blocks, *integrators], wires, [*events], **options)

    def called(self, t):
        self.action(t)
        return 0.0


DIAGRAMS = {
    "flat": {},
    "half steps": {"parts": 2},
    "in a subsystem": {"depth": 1},
    "two deep": {"depth": 2},
    "two deep, half steps": {"depth": 2, "parts": 2},
    "stages": {"states": 1, "Solver": SSPRK22},
    "stages, two deep": {"states": 1, "depth": 2, "Solver": RK4},
    "adaptive": {"Solver": RKDP54, "dt_max": T},
    "adaptive, stages": {"states": 1, "Solver": RKCK54, "dt_max": T / 1.5},
    "adaptive, stages, two deep": {"states": 1, "depth": 2, "Solver": RKDP54},
}


@contextlib.contextmanager
def interrupted_after(most):
    """Ctrl-C after so many calls: Python looks for it where one begins and where one in C ends."""
    calls = [0]

    def count(frame, event, argument):
        calls[0] += event in ("call", "c_return")
        if calls[0] >= most:
            sys.setprofile(None)
            raise KeyboardInterrupt

    sys.setprofile(count)
    try:
        yield calls
    finally:
        sys.setprofile(None)


def rows(loop):
    return {k: loop.record.rows[k] for k in range(COUNT + 1)}


def go_on(loop, run):
    """Fly to the end, where an end was in sight."""
    if (left := COUNT * T - loop.sim.time) > 0:
        run(loop.sim, left)


RUNS = [
    *(("flat", Simulation.run), ("two deep", fly), ("adaptive, stages", Simulation.run)),
    *((name, Simulation.run) for name in DIAGRAMS if name not in ("flat", "adaptive, stages")),
    *((name, fly) for name in ("flat", "half steps", "adaptive")),
]


# an interrupt that comes while Python frees an object is lost, as Ctrl-C is there
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize(("name", "run"), first(RUNS, 3))
def test_forty_interrupts_leave_nothing_to_the_next_flight_and_it_goes_on(name, run):
    run(Loop(**DIAGRAMS[name]).sim, T)  # imports
    whole, evaluations = Loop(**DIAGRAMS[name]), []
    whole.action = lambda t: evaluations.append(calls[0])
    with interrupted_after(math.inf) as calls:
        run(whole.sim, COUNT * T)
    expected, hits = rows(whole), 0
    for place in range(40):
        loop = Loop(**DIAGRAMS[name])
        for again in (False, True):
            most = int(calls[0] * (place + 0.5) / 40)
            # in the first evaluation PathSim sizes registers, which an interrupt may split
            most = most if again else max(most, evaluations[1])
            try:
                with interrupted_after(most):
                    run(loop.sim, COUNT * T, reset=again)
            except KeyboardInterrupt:
                hits += 1
            if again:
                run(loop.sim, COUNT * T, reset=True)
            else:
                go_on(loop, run)
            assert rows(loop) == expected, (place, again)
    assert hits > 60


def stop(t):
    raise StopSimulation("on purpose")


@pytest.mark.parametrize("run", [Simulation.run, fly])
@pytest.mark.parametrize("where", ["block", "event", "exception"])
@pytest.mark.parametrize("name", DIAGRAMS)
def test_a_flight_that_was_stopped_leaves_nothing_to_the_next_and_it_goes_on(name, where, run):
    armed = []

    def ends(t):
        return armed and t > 0.4 * COUNT * T

    def action(t):
        if ends(t):
            stop(t) if where == "block" else {}[t]

    end = Condition(lambda t: ends(t) and where == "event", stop)
    loop, whole = Loop(events=[end], **DIAGRAMS[name]), Loop(**DIAGRAMS[name])
    if where != "event":
        loop.action = action
    run(whole.sim, COUNT * T)
    for again in (False, True):
        armed.append(True)
        with pytest.raises(KeyError) if where == "exception" else contextlib.nullcontext():
            run(loop.sim, COUNT * T, reset=again)
        assert loop.sim.time < 0.5 * COUNT * T
        armed.clear()
        if again:
            run(loop.sim, COUNT * T, reset=True)
        else:
            go_on(loop, run)
        assert rows(loop) == rows(whole)


def test_a_look_after_an_interrupt_flies_at_most_the_period_that_was_interrupted():
    loop = Loop()
    loop.action = lambda t: {}[t] if t > 3.5 * T else None
    with pytest.raises(KeyError):
        loop.sim.run(COUNT * T)
    loop.action = lambda t: None
    for t in (1e6, 100 * T, 0.0):
        loop.sim._update(t)
    assert len(loop.mass.states) <= 5
    assert loop.mass.samples == 3


@pytest.mark.parametrize("how", ["timestep", "step", "reset"])
@pytest.mark.parametrize("name", DIAGRAMS)
def test_a_diagram_that_is_stepped_by_hand_flies_as_in_a_run(name, how):
    ran, stepped = (Loop(**DIAGRAMS[name]) for _ in range(2))
    ran.sim.run(COUNT * T)
    if how == "reset":
        stepped.sim.run(0.3 * COUNT * T)
        stepped.sim.reset()
    step = stepped.sim.step if how == "step" else stepped.sim.timestep
    while stepped.sim.time < COUNT * T - 1e-9:
        step(stepped.sim.dt)
    assert rows(stepped) == rows(ran)


def test_a_first_step_by_hand_finds_no_crossing_of_what_nothing_has_evaluated():
    found = []
    for by_hand in (False, True):
        # the output is 0 before the first evaluation, and 1 from then on
        one, law, times = Constant(1.0), Integral(T), []
        crossing = ZeroCrossing(lambda t, one=one: one.outputs[0] - 0.5, times.append)
        met = Condition(lambda t, law=law: law.outputs[0] > 0.0, times.append)
        wires = [Connection(one, law["r"])]
        sim = Simulation([one, law], wires, [crossing, met], dt=T, log=False)
        if by_hand:
            sim.timestep()
        else:
            sim.run(T)
        found.append(times)
    assert found[0] == found[1]


@pytest.mark.parametrize("run", [Simulation.run, fly])
def test_a_plant_and_a_law_that_are_switched_off_and_on_in_a_run_begin_there(run):
    loop = Loop()
    for k, block, method in ((2, "first", "off"), (4, "first", "on"), (5, "mass", "off")):
        switch = getattr(getattr(loop, block), method)
        loop.sim.add_event(Schedule(k * T, None, 100.0, lambda t, switch=switch: switch()))
    loop.sim.add_event(Schedule(6 * T, None, 100.0, lambda t: loop.mass.on()))
    run(loop.sim, COUNT * T)
    assert (loop.first.clock.start, loop.first.clock.latest[0]) == (4 * T, 5)
    assert (loop.mass.clock.start, loop.mass.samples) == (6 * T, 2)
    u = 0.7 * loop.record.rows[6][1]
    assert Mass(T).advance(1, [u, 0.0]) == [loop.record.rows[7][0]]


@pytest.mark.parametrize("reset", [False, True])
@pytest.mark.parametrize("flown", [0, 2])
def test_a_periodic_steady_state_of_a_sampled_block_is_refused(flown, reset):
    loop = Loop(states=1)
    if flown:
        loop.sim.run(flown * T)
    mass = loop.mass
    with pytest.raises(ParameterError) as error:
        loop.sim.pss(1.0, reset=reset)
    assert error.value.parameter == "pss"
    assert any(name in str(error.value) for name in ("mass", "first", "Mass", "Integral"))
    loop.sim.run(COUNT * T, reset=True)
    whole = Loop(states=1)
    whole.sim.run(COUNT * T)
    assert rows(loop) == rows(whole)
    assert mass.samples == COUNT
