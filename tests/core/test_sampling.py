"""Sampled blocks: each acts once at each instant, whatever happens in a step or between two."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Constant, Integrator, Scope, Source
from pathsim.events import Condition, Event, ZeroCrossing
from pathsim.exceptions import LinearizationError
from pathsim.solvers import RKBS32, RKDP54, SSPRK22

from pathsim_jsbsim_blocks._core.pathsim_internals import values
from pathsim_jsbsim_blocks._core.sampling import SampledLaw, SampledPlant

pytestmark = pytest.mark.matrix

T = 0.1


@dataclass(eq=False)
class Total(SampledLaw):
    """y[k] = u[0] + ... + u[k]"""

    T: float

    def initial_state(self):
        return 0.0

    def law(self, u, state):
        return [state + u[0]], state + u[0]


class Rejection(Event):
    """Refuses a step to ``time`` once, and acts before it is retried."""

    def __init__(self, time, action):
        super().__init__()
        self.time, self.action = time, action
        self.rejected = 0

    def detect(self, t):
        rejects = not self.rejected and abs(t - self.time) < 1e-9
        self.rejected += rejects
        return rejects, False, 1.0

    def buffer(self, t):
        if self.rejected == 1:
            self.rejected = 2
            self.action()


def flown(law, source, dt, states=0, events=(), **more):
    scope = Scope()
    integrators = [Integrator(0.0) for _ in range(states)]
    sim = Simulation(
        [source, law, scope, *integrators],
        [Connection(source, law), Connection(law, scope, *integrators)],
        list(events),
        dt=dt,
        log=False,
        **more,
    )
    sim.run(1.0)
    time, (y,) = scope.read()
    at = {
        round(t / T): value
        for t, value in zip(time, y, strict=True)
        if abs(t / T - round(t / T)) < 1e-6
    }
    return law, at


def test_a_law_acts_once_at_an_instant_whose_step_was_rejected():
    # what the law computed in the rejected step is forgotten, and computed again in the next one
    value = [1.0]
    rejection = Rejection(0.5, lambda: value.__setitem__(0, 10.0))
    _, at = flown(
        Total(T),
        Source(lambda t: value[0]),
        T / 2,
        states=1,
        events=[rejection],
        Solver=RKBS32,
        dt_max=T / 2,
    )
    assert rejection.rejected == 2
    assert [at[k] for k in range(11)] == [1, 2, 3, 4, 5, 15, 25, 35, 45, 55, 65]


@pytest.mark.parametrize("states", [0, 1])
def test_a_law_counts_the_instants_that_a_step_jumps_over_and_warns(states):
    with pytest.warns(RuntimeWarning, match=r"Total samples every 0.1 s, .* jumps over") as said:
        _, at = flown(Total(T), Source(lambda t: 1.0), 2 * T, states)
    assert len([w for w in said if "jumps over" in str(w.message)]) == 1
    # the samples 2 k - 1 and 2 k both act at 2 k
    assert np.allclose([at[k] for k in (0, 2, 4, 6, 8, 10)], [1, 3, 5, 7, 9, 11])


def test_a_step_that_divides_T_does_not_warn(recwarn):
    _, at = flown(Total(T), Source(lambda t: 1.0), T / 4)
    assert [at[k] for k in range(11)] == list(range(1, 12))
    assert not [w for w in recwarn if "jumps over" in str(w.message)]


class Count(SampledPlant):
    """y[k] = k, and what was latched for each period; one step of its own per advance."""

    def __init__(self, T=T):
        super().__init__(T)
        self.latched, self.interrupt = [], None
        self.start_from([0.0])

    def latch(self, t):
        return values(self.inputs)

    def advance(self, index, u):
        if self.interrupt == index:
            self.interrupt = None
            raise KeyboardInterrupt
        self.latched.append((index, u[0]))
        return [float(index)]


def counting(source, *others, connections=(), **more):
    plant, scope = Count(), Scope()
    more = {"dt": T, "log": False, **more}
    sim = Simulation(
        [source, plant, scope, *others],
        [Connection(source, plant, scope[0]), Connection(plant, scope[1]), *connections],
        **more,
    )
    return plant, scope, sim


def ramp():
    return Source(lambda t: t)


def clock_in_a_step_from(t):
    clock = counting(ramp())[0].clock
    clock.join(t)
    clock.step_start, clock.in_step = t, True
    clock.start = 0.0
    clock.go_to(1)
    return clock


def test_a_plant_latches_at_the_instant_and_shows_at_the_next():
    plant, scope, sim = counting(ramp())
    sim.run(1.0)
    assert [u for _, u in plant.latched] == pytest.approx([k * T for k in range(10)])
    _, (_, y) = scope.read()
    assert y.tolist() == list(range(11))
    assert plant.samples == 10


@pytest.mark.parametrize("dt", [T, T / 2])
@pytest.mark.parametrize("states", [0, 1])
def test_a_long_run_keeps_no_results_of_old_instants(states, dt):
    plant, _, sim = counting(ramp(), *(Integrator() for _ in range(states)), dt=dt)
    sim.run(10.0)
    assert plant.samples == 100
    assert plant.clock.ahead is None
    assert len(plant.clock) == 0  # PathSim's Schedule keeps a list of all instants


@pytest.mark.parametrize("states", [0, 1])
def test_the_first_instant_is_one_period_after_the_start(states):
    # `begin_at` counts from the instant before the first one
    integrators = [Integrator() for _ in range(states)]
    plant, _, sim = counting(ramp(), *integrators)
    assert plant.clock.index == 1
    assert plant.clock.next() == T
    assert plant.clock.at_latest(0.0)
    sim.run(T)
    assert plant.samples == 1


def test_a_law_waits_for_the_instant_of_the_start():
    law = Total(T)
    assert law.clock.index == 0
    assert law.clock.next() == 0.0


def test_a_run_that_begins_elsewhere_counts_on_from_there():
    clock = Count().clock
    clock.now = 4, [3.0], [0.0]
    clock.join(5.03)
    assert clock.index == 4
    assert clock.next() == pytest.approx(5.03 + T)
    assert clock.count(5.03 + T) == 1
    assert clock.count(5.03 + 3 * T) == 3


def test_an_instant_counts_from_a_hundredth_of_a_period_before_it_at_most():
    # the diagram's clock accumulates its error; far from the start, 1e-9 of the time is more than
    # 1 % of a period of 1e-4 s
    clock = Count(1e-4).clock
    assert clock.next() - clock.due_from == pytest.approx(1e-13 + 1e-13, rel=1e-2)
    clock.go_to(10**9)
    time = clock.next()
    assert time - clock.due_from == pytest.approx(1e-6, rel=1e-3)
    assert clock.slack == pytest.approx(1e-6, rel=1e-3)
    assert not clock.at_latest(time - 1e-4 + 1.01e-6)
    assert clock.at_latest(time - 1e-4 + 0.99e-6)


def test_the_very_time_at_which_an_instant_is_due_counts():
    clock = clock_in_a_step_from(0.0)
    assert clock.count(clock.due_from) == 1
    assert clock.detect(clock.due_from)[0]
    assert not clock.detect(math.nextafter(clock.due_from, 0.0))[0]
    # the late end of the window is on time, what comes after it is a jump
    late = clock.next() + clock.slack
    assert clock.detect(late)[1]
    assert not clock.detect(math.nextafter(late, 1.0))[1]


def test_an_adaptive_step_is_cut_at_the_instant():
    # from 0.04 to 0.14 s, the instant at 0.1 s is at 60 % of the step
    clock = clock_in_a_step_from(0.04)
    assert clock.detect(0.14) == (True, False, pytest.approx(0.6))


def test_other_events_at_the_same_time_come_after_the_sample():
    clock = clock_in_a_step_from(0.0)
    detected, close, ratio = clock.detect(T)
    assert detected
    assert close
    assert 1.0 - 1e-15 < ratio < 1.0


def test_a_sample_at_a_repeated_instant_is_taken_once():
    # PathSim evaluates a diagram at the start of a run at the time at which the last one ended
    plant, _, sim = counting(ramp())
    for _ in range(10):
        sim.run(T)
    assert [index for index, _ in plant.latched] == list(range(1, 11))
    assert [u for _, u in plant.latched] == pytest.approx([k * T for k in range(10)])


@pytest.mark.parametrize("depth", [0, 1, 2])
@pytest.mark.parametrize("states", [0, 1])
def test_a_look_shows_and_does_not_act(depth, states):
    plant, law, inputs = Count(), Total(T), ramp()
    system = inside(plant, depth)
    integrators = [Integrator() for _ in range(states)]
    sim = Simulation(
        [inputs, system, law, *integrators],
        [Connection(inputs, system, law, *integrators)],
        dt=T,
        log=False,
    )
    sim.run(0.5)
    seen = plant.outputs.to_array(), law.outputs.to_array()
    for t in (None, 0.5, 0.5 + T, 0.5 + 3 * T, 1e6, 0.0):
        with pytest.raises(LinearizationError):
            sim.to_statespace([system[0]], [system[0]], t=t)
        with pytest.raises(LinearizationError):
            sim.linearize()
        sim.plot()
        type(plant).info()
    sim.delinearize()
    if not states:
        sim.steadystate()
    assert len(plant.latched) == plant.samples == 5
    assert law.clock.index == 6
    sim._update(sim.time)
    assert np.array_equal(plant.outputs.to_array(), seen[0])
    assert np.array_equal(law.outputs.to_array(), seen[1])
    sim.run(0.5)
    assert [u for _, u in plant.latched] == pytest.approx([k * T for k in range(10)])
    assert law.outputs[0] == pytest.approx(sum(k * T for k in range(11)))


def inside(block, depth):
    for _ in range(depth):
        interface = Interface()
        block = Subsystem(
            [interface, block], [Connection(interface, block), Connection(block, interface)]
        )
    return block


@pytest.mark.parametrize("moved", [False, True], ids=["as it is", "call moved into a helper"])
@pytest.mark.parametrize("depth", [1, 2, 3])
def test_depth_is_found_however_pathsim_hands_the_solver_down(depth, moved, monkeypatch):
    if moved:

        def set_solver(system, Solver, parent, **more):
            def each(blocks):
                for block in blocks:
                    block.set_solver(Solver, parent, **more)
                    if block.engine:
                        system._blocks_dyn.append(block)

            system._blocks_dyn = []
            each(system.blocks)

        monkeypatch.setattr(Subsystem, "set_solver", set_solver)
    plant, source, scope = Count(), ramp(), Scope()
    system = inside(plant, depth)
    sim = Simulation(
        [source, system, scope],
        [Connection(source, system), Connection(system, scope)],
        dt=T,
        log=False,
    )
    sim.run(1.0)
    assert [u for _, u in plant.latched] == pytest.approx([k * T for k in range(10)])
    assert scope.read()[1][0].tolist() == list(range(11))


@pytest.mark.parametrize("depth", [0, 1, 2])
@pytest.mark.parametrize("crossings", [0, 1])
@pytest.mark.parametrize("states", [0, 1])
def test_a_rejected_step_does_not_change_what_was_latched(depth, crossings, states):
    # stages and rejected steps leave other values on the way into a subsystem
    plant, source = Count(0.01), Source(lambda t: 0.05 * math.sin(3 * t))
    system = inside(plant, depth)
    integrators = [Integrator() for _ in range(states)]
    sim = Simulation(
        [source, system, *integrators],
        [Connection(source, system, *integrators)],
        [ZeroCrossing(lambda t: math.sin(47 * t + 1))] * crossings,
        dt=0.01,
        Solver=RKDP54,
        log=False,
    )
    sim.run(0.5)
    expected = [0.05 * math.sin(3 * k * 0.01) for k in range(50)]
    assert [u for _, u in plant.latched] == pytest.approx(expected, rel=0, abs=1e-9)


class Fault(Source):
    """Raises once at a time, at one of the calls that PathSim makes in a step."""

    def __init__(self, time, method, error=RuntimeError):
        super().__init__(lambda t: t)
        self.time, self.method, self.error = time, method, error

    def _maybe(self, method, t):
        if method == self.method and self.time is not None and t >= self.time - 1e-9:
            self.time = None
            raise self.error("on purpose")

    def update(self, t):
        self._maybe("update", t)
        super().update(t)

    def sample(self, t, dt):
        self._maybe("sample", t)


@pytest.mark.parametrize("method", ["update", "sample"])
@pytest.mark.parametrize("last", [False, True], ids=["before the plant", "after it"])
@pytest.mark.parametrize("depth", [0, 1])
@pytest.mark.parametrize("states", [0, 1])
def test_after_an_exception_the_next_run_goes_on_exactly(method, last, depth, states):
    plant, law, source, fault, scope = Count(), Total(T), ramp(), Fault(0.5, method), Scope()
    system = inside(plant, depth)
    integrators = [Integrator() for _ in range(states)]
    blocks = [source, system, law, scope, *integrators]
    sim = Simulation(
        [*blocks, fault] if last else [fault, *blocks],
        [
            Connection(source, system, law, *integrators),
            Connection(system, scope[0]),
            Connection(law, scope[1]),
        ],
        dt=T,
        log=False,
    )
    with pytest.raises(RuntimeError, match="on purpose"):
        sim.run(1.0)
    assert plant.samples in (4, 5)
    assert sim.time == pytest.approx(0.4)
    with pytest.raises(LinearizationError):
        sim.to_statespace([system[0]], [system[0]], t=0.5)
    assert len(plant.latched) in (4, 5)
    sim.run(0.6)
    assert plant.samples == 10
    assert [index for index, _ in plant.latched] == list(range(1, 11))
    assert [u for _, u in plant.latched] == pytest.approx([k * T for k in range(10)])
    time, (y, total) = scope.read()
    expected = {k: sum(i * T for i in range(k + 1)) for k in range(11)}
    for t, y_k, total_k in zip(time, y, total, strict=True):
        assert y_k == round(t / T)
        assert total_k == pytest.approx(expected[round(t / T)])


def test_a_plant_acts_in_the_step_that_ends_at_its_instant():
    plant, _, sim = counting(ramp(), dt=T / 4)
    acted = []
    for _ in range(8):
        sim.run(T / 4)
        acted.append(len(plant.latched))
    assert acted == [0, 0, 0, 1, 1, 1, 1, 2]


@pytest.mark.parametrize("method", ["update", "sample"])
def test_shorter_steps_after_an_exception_change_nothing(method):
    fault = Fault(0.5, method)
    plant, scope, sim = counting(ramp(), fault)
    with pytest.raises(RuntimeError, match="on purpose"):
        sim.run(1.0)
    sim.dt = T / 4
    sim.run(0.6)
    assert [u for _, u in plant.latched] == pytest.approx([k * T for k in range(10)])
    time, (_, y) = scope.read()
    assert y.tolist() == [int(t / T + 1e-6) for t in time]


@pytest.mark.parametrize("states", [0, 1])
def test_an_interrupted_advance_is_done_again(states):
    plant, _, sim = counting(ramp(), *(Integrator() for _ in range(states)))
    plant.interrupt = 5
    with pytest.raises(KeyboardInterrupt):
        sim.run(1.0)
    assert plant.samples == 4
    sim.run(0.6)
    assert [index for index, _ in plant.latched] == list(range(1, 11))


def test_a_dynamic_block_may_come_between_two_runs():
    plant, _, sim = counting(source := ramp())
    sim.run(0.3)
    sim.add_block(integrator := Integrator())
    sim.add_connection(Connection(plant, integrator))
    sim.run(0.3)
    # the plant's output is held over each step, in its stages too: 0.3 + 0.4 + 0.5
    assert integrator.outputs[0] == pytest.approx((3 + 4 + 5) * T, abs=1e-12)
    sim.remove_connection(sim.connections[-1])
    sim.remove_block(integrator)
    sim.run(0.4)
    assert [u for _, u in plant.latched] == pytest.approx([k * T for k in range(10)])
    assert source in sim


def test_values_edited_between_two_runs_count_at_the_instant_only():
    for pieces, expected in (([0.3, 0.3], [0, 0, 0, 1, 1, 1]), ([0.25, 0.35], [0, 0, 0, 1, 1, 1])):
        constant = Constant(0.0)
        plant, _, sim = counting(constant, dt=0.05)
        sim.run(pieces[0])
        constant.value = 1.0
        sim.run(pieces[1])
        assert [u for _, u in plant.latched] == expected


def test_another_simulation_of_a_block_that_flew_one_step_flies_on():
    plant, source = Count(), ramp()

    def simulation():
        return Simulation([source, plant], [Connection(source, plant)], dt=T, log=False)

    simulation().run(T)
    again = simulation()
    again.run(0.5)
    assert [index for index, _ in plant.latched] == list(range(1, 7))
    assert plant.outputs[0] == 6.0


@pytest.mark.parametrize(
    ("blocks", "solver", "seen"), [(0, SSPRK22, True), (1, SSPRK22, False), (1, RKDP54, False)]
)
def test_where_a_zero_crossing_sees_the_output_of_a_sampled_block(blocks, solver, seen):
    # a failure of the last two is good news: PathSim sees jumps there, and conventions.md can go on
    plant, _, sim = counting(ramp(), *(Integrator() for _ in range(blocks)), Solver=solver)
    crossed, held = [], []
    sim.add_event(ZeroCrossing(lambda t: plant.outputs[0] - 3.5, crossed.append))
    sim.add_event(Condition(lambda t: plant.outputs[0] > 3.5, held.append))
    sim.run(0.6)
    assert bool(crossed) is seen
    assert held
