"""Sampled blocks: each acts once at each instant, whatever happens in a step or between two."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Constant, Integrator, Scope, Source
from pathsim.events import Condition, Event, ZeroCrossing
from pathsim.exceptions import LinearizationError
from pathsim.solvers import ESDIRK43, EUB, RK4, RKBS32, RKDP54, SSPRK22

from pathsim_jsbsim_blocks._core.clock import STEP
from pathsim_jsbsim_blocks._core.pathsim_internals import values
from pathsim_jsbsim_blocks._core.sampling import SampledLaw, SampledPlant

pytestmark = pytest.mark.matrix

T = 0.1


def wave(t):
    return math.sin(3.0 * t)


@dataclass(eq=False)
class Total(SampledLaw):
    """y[k] = u[0] + ... + u[k]"""

    T: float

    def initial_state(self):
        return 0.0

    def law(self, u, state):
        return [state + u[0]], state + u[0]


@dataclass(eq=False)
class Area(Total):
    """y[k] = T (u[0] + ... + u[k-1])"""

    def build(self):
        self.step = self.clock.period

    def law(self, u, state):
        return [state], state + self.step * u[0]


class Count(SampledPlant):
    """y[k] = k, and what was latched for each period; one step of its own per advance."""

    def __init__(self, T=T):
        super().__init__(T)
        self.latched = []
        self.start_from([0.0])

    def latch(self, t):
        return values(self.inputs)

    def advance(self, index, u):
        self.latched.append((index, u[0]))
        return [float(index)]


class Fault(Source):
    """Raises once at a time, at one of the calls that PathSim makes in a step."""

    def __init__(self, method, time=0.5):
        super().__init__(lambda t: t)
        self.time, self.method = time, method

    def _maybe(self, method, t):
        if method == self.method and self.time is not None and t >= self.time - 1e-9:
            self.time = None
            raise RuntimeError("on purpose")

    def update(self, t):
        self._maybe("update", t)
        super().update(t)

    def sample(self, t, dt):
        self._maybe("sample", t)


def inside(block, depth):
    for _ in range(depth):
        interface = Interface()
        block = Subsystem(
            [interface, block], [Connection(interface, block), Connection(block, interface)]
        )
    return block


class Diagram:
    """A plant and a law, in subsystems, on one wave; more blocks before or after them."""

    def __init__(self, depth=0, states=0, crossings=0, before=(), after=(), **options):
        self.plant, self.law, self.scope = Count(), Total(T), Scope()
        self.source = Source(wave)
        self.system, law = inside(self.plant, depth), inside(self.law, depth)
        integrators = [Integrator() for _ in range(states)]
        blocks = [*before, self.source, self.system, law, self.scope, *integrators, *after]
        wires = [
            Connection(self.source, self.system, law, *integrators),
            Connection(self.system, self.scope[0]),
            Connection(law, self.scope[1]),
        ]
        # stages and rejected steps leave other values on the way into a subsystem
        events = [ZeroCrossing(lambda t: math.sin(47 * t + 1))] * crossings
        options = {"dt": T, "log": False, **options}
        self.sim = Simulation(blocks, wires, events, **options)

    def check(self, until=1.0):
        """Ten instants, each with the wave at it; the law has added them up."""
        count = round(until / T)
        assert [index for index, _ in self.plant.latched] == list(range(1, count + 1))
        assert self.plant.samples == count
        expected = [wave(k * T) for k in range(count + 1)]
        assert [u for _, u in self.plant.latched] == pytest.approx(expected[:-1], abs=1e-9)
        time, (y, total) = self.scope.read()
        k = [int(t / T + 1e-6) for t in time]
        assert {*range(count + 1)} <= {*k}
        on_grid = np.abs(time - np.array(k) * T) < 1e-9
        assert y[on_grid].tolist() == np.array(k, dtype=float)[on_grid].tolist()
        assert total[on_grid] == pytest.approx(np.cumsum(expected)[k][on_grid], abs=1e-9)


# how a diagram is built and stepped: nesting, solver stages, rates, adaptive steps
DIAGRAMS = {
    "plain": {},
    "two steps a period": {"dt": T / 2},
    "four steps a period": {"dt": T / 4},
    "in a subsystem": {"depth": 1},
    "three deep": {"depth": 3},
    "a state": {"states": 1},
    "a state, four stages": {"states": 1, "Solver": RK4, "dt": T / 2},
    "a state, implicit": {"states": 1, "Solver": EUB},
    "a state, in a subsystem": {"states": 1, "depth": 1},
    "a state, two deep, half steps": {"states": 1, "depth": 2, "dt": T / 2},
    "adaptive": {"Solver": RKBS32},
    "adaptive, a state": {"states": 1, "Solver": RKDP54},
    "adaptive, implicit": {"states": 1, "Solver": ESDIRK43, "dt_max": T},
    "adaptive, crossings": {"states": 1, "crossings": 1, "Solver": RKDP54},
    "adaptive, crossings, two deep": {"states": 1, "crossings": 1, "depth": 2, "Solver": RKDP54},
}


def whole(diagram):
    diagram.sim.run(1.0)


def pieces(diagram):
    # PathSim evaluates a diagram at the start of a run at the time at which the last one ended
    for _ in range(10):
        diagram.sim.run(T)


def looked_at(diagram):
    sim, plant, law, system = diagram.sim, diagram.plant, diagram.law, diagram.system
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
    if len(sim.blocks) == 4:  # no continuous states
        sim.steadystate()
    assert len(plant.latched) == plant.samples == 5
    assert law.clock.latest[0] == 6
    sim._update(sim.time)
    assert np.array_equal(plant.outputs.to_array(), seen[0])
    assert np.array_equal(law.outputs.to_array(), seen[1])
    sim.run(0.5)


@pytest.mark.parametrize("flown", [whole, pieces, looked_at], ids=lambda f: f.__name__)
@pytest.mark.parametrize("options", DIAGRAMS.values(), ids=DIAGRAMS)
def test_samples_are_those_of_the_instants(options, flown):
    diagram = Diagram(**options)
    flown(diagram)
    diagram.check()


def test_samples_go_on_with_a_state_for_a_while():
    diagram = Diagram()
    sim, plant = diagram.sim, diagram.plant
    sim.run(0.3)
    sim.add_block(integrator := Integrator())
    sim.add_connection(Connection(plant, integrator))
    sim.run(0.3)
    # the plant's output is held over each step, in its stages too: 0.3 + 0.4 + 0.5
    assert integrator.outputs[0] == pytest.approx((3 + 4 + 5) * T, abs=1e-12)
    sim.remove_connection(sim.connections[-1])
    sim.remove_block(integrator)
    sim.run(0.4)
    diagram.check()


@pytest.mark.parametrize("dt", [T, T / 4], ids=["the same steps", "shorter steps"])
@pytest.mark.parametrize("options", [{}, {"depth": 1, "states": 1}], ids=str)
@pytest.mark.parametrize("place", ["before", "after"])
@pytest.mark.parametrize("method", ["update", "sample"])
def test_after_an_exception_the_next_run_goes_on_exactly(method, place, options, dt):
    diagram = Diagram(**{place: [Fault(method)]}, **options)
    with pytest.raises(RuntimeError, match="on purpose"):
        diagram.sim.run(1.0)
    assert diagram.plant.samples in (4, 5)
    assert diagram.sim.time == pytest.approx(0.4)
    with pytest.raises(LinearizationError):
        diagram.sim.to_statespace([diagram.system[0]], [diagram.system[0]], t=0.5)
    assert len(diagram.plant.latched) in (4, 5)
    diagram.sim.dt = dt
    diagram.sim.run(0.6)
    diagram.check()


def test_a_law_of_an_interrupted_step_goes_on_in_another_diagram_without_that_step():
    one, law = Constant(1.0), Total(T)
    with pytest.raises(RuntimeError, match="on purpose"):
        Simulation([Fault("sample"), one, law], [Connection(one, law)], dt=T, log=False).run(1.0)
    Simulation([one, law], [Connection(one, law)], dt=T, log=False).run(3 * T)
    # five instants to 0.4 s, and three
    assert law.outputs[0] == 8.0


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


def totals(source, dt, states=0, events=(), **more):
    """What a law shows at each instant."""
    law, scope = Total(T), Scope()
    integrators = [Integrator(0.0) for _ in range(states)]
    wires = [Connection(source, law), Connection(law, scope, *integrators)]
    blocks = [source, law, scope, *integrators]
    Simulation(blocks, wires, [*events], dt=dt, log=False, **more).run(1.0)
    time, (y,) = scope.read()
    k = np.rint(time / T)
    return {int(n): v for t, n, v in zip(time, k, y, strict=True) if abs(t / T - n) < 1e-6}


def test_a_law_acts_once_at_an_instant_whose_step_was_rejected():
    # what the law computed in the rejected step is forgotten, and computed again in the next one
    value = [1.0]
    rejection = Rejection(0.5, lambda: value.__setitem__(0, 10.0))
    source = Source(lambda t: value[0])
    at = totals(source, T / 2, 1, [rejection], Solver=RKBS32, dt_max=T / 2)
    assert rejection.rejected == 2
    assert [at[k] for k in range(11)] == [1, 2, 3, 4, 5, 15, 25, 35, 45, 55, 65]


@pytest.mark.parametrize("states", [0, 1])
def test_a_law_counts_the_instants_that_a_step_jumps_over_and_warns(states):
    with pytest.warns(RuntimeWarning, match=r"Total samples every 0.1 s, .* jumps over") as said:
        at = totals(Source(lambda t: 1.0), 2 * T, states)
    assert len([w for w in said if "jumps over" in str(w.message)]) == 1
    # the samples 2 k - 1 and 2 k both act at 2 k
    assert np.allclose([at[k] for k in (0, 2, 4, 6, 8, 10)], [1, 3, 5, 7, 9, 11])


def counting(source, *others, **more):
    plant, scope = Count(), Scope()
    wires = [Connection(source, plant, scope[0]), Connection(plant, scope[1])]
    more = {"dt": T, "log": False, **more}
    return plant, Simulation([source, plant, scope, *others], wires, **more)


def ramp():
    return Source(lambda t: t)


def clock_in_a_step_from(t):
    clock = counting(ramp())[0].clock
    clock.now = 1, [0.0], [0.0]
    clock.join(t)
    clock.reached, clock.phase = t, STEP
    return clock


@pytest.mark.parametrize("dt", [T, T / 2])
@pytest.mark.parametrize("states", [0, 1])
def test_a_long_run_keeps_no_results_of_old_instants(states, dt):
    plant, sim = counting(ramp(), *(Integrator() for _ in range(states)), dt=dt)
    sim.run(10.0)
    assert plant.samples == 100
    assert plant.clock.latest[0] == 101
    assert len(plant.clock) == 0  # PathSim's Schedule keeps a list of all instants


def test_a_new_period_is_that_of_the_next_reset():
    one, area = Constant(1.0), Area(T)
    sim = Simulation([one, area], [Connection(one, area)], dt=T, log=False)
    for period in (T, 2 * T):
        sim.run(1.0)
        assert (area.clock.period, area.clock.latest[0]) == (period, round(1.0 / period) + 1)
        assert area.outputs[0] == pytest.approx(1.0)
        area.T = 2 * T
        assert area.clock.period == period
        sim.reset()


def test_a_time_that_is_set_by_hand_is_that_of_the_latest_instant():
    plant, sim = counting(ramp())
    sim.run(3 * T)
    sim.time = 1000.0
    sim.run(2 * T)
    assert [index for index, _ in plant.latched] == [1, 2, 3, 4, 5]
    assert plant.latched[3] == (4, pytest.approx(1000.0))


def test_an_instant_counts_from_a_hundredth_of_a_period_before_it_at_most():
    # the diagram's clock accumulates its error; far from the start, 1e-9 of the time is more than
    # 1 % of a period of 1e-4 s
    clock = Count(1e-4).clock
    clock.now = 1, [0.0], [0.0]
    clock.join(0.0)
    assert clock.next() - clock.due == pytest.approx(1e-13 + 1e-13, rel=1e-2)
    clock.now = 10**9, [0.0], [0.0]
    clock.join(1e5)
    time = clock.next()
    assert time - clock.due == pytest.approx(1e-6, rel=1e-3)
    assert clock.slack == pytest.approx(1e-6, rel=1e-3)
    assert not clock.at_latest(time - 1e-4 + 1.01e-6)
    assert clock.at_latest(time - 1e-4 + 0.99e-6)


def test_the_very_time_at_which_an_instant_is_due_counts():
    clock = clock_in_a_step_from(0.0)
    assert clock.count(clock.due) == 1
    assert clock.detect(clock.due)[0]
    assert not clock.detect(math.nextafter(clock.due, 0.0))[0]
    # other events at the same time come after the sample
    _, _, ratio = clock.detect(T)
    assert 1.0 - 1e-15 < ratio < 1.0
    # the late end of the window is on time, what comes after it is a jump
    late = clock.next() + clock.slack
    assert clock.detect(late)[1]
    assert not clock.detect(math.nextafter(late, 1.0))[1]


def test_values_edited_between_two_runs_count_at_the_instant_only():
    for before, states in ((0.3, 0), (0.25, 0), (0.3, 1)):
        constant = Constant(0.0)
        plant, sim = counting(constant, *(Integrator() for _ in range(states)), dt=0.05)
        sim.run(before)
        constant.value = 1.0
        sim.run(0.6 - before)
        assert [u for _, u in plant.latched] == [0, 0, 0, 1, 1, 1]


@pytest.mark.parametrize(
    ("blocks", "solver", "seen"), [(0, SSPRK22, True), (1, SSPRK22, False), (1, RKDP54, False)]
)
def test_where_a_zero_crossing_sees_the_output_of_a_sampled_block(blocks, solver, seen):
    # a failure of the last two is good news: PathSim sees jumps there, and conventions.md can go on
    plant, sim = counting(ramp(), *(Integrator() for _ in range(blocks)), Solver=solver)
    crossed, held = [], []
    sim.add_event(ZeroCrossing(lambda t: plant.outputs[0] - 3.5, crossed.append))
    sim.add_event(Condition(lambda t: plant.outputs[0] > 3.5, held.append))
    sim.run(0.6)
    assert bool(crossed) is seen
    assert held


def beside_a_state(count, dt, start=0.0, **solver):
    """A law beside a state whose derivative is constant: an adaptive step is as long as it may."""
    constant, state, scope = Constant(1.0), Integrator(0.0), Scope()
    sim = Simulation(
        [constant, state, count, scope],
        [Connection(constant, state, count), Connection(count, scope)],
        dt=dt,
        log=False,
        **solver,
    )
    sim.reset(start)
    return sim, scope


@pytest.mark.parametrize("solver", [RKBS32, RKDP54])
@pytest.mark.parametrize("T", [0.1, 0.03])
@pytest.mark.parametrize("start", [0.0, 2.5])
def test_an_adaptive_step_is_cut_to_end_at_the_instant(solver, T, start):
    sim, scope = beside_a_state(Total(T), 0.25, start, Solver=solver, dt_max=10.0)
    sim.run(12 * T)
    time, (y,) = scope.read()
    # no step ends anywhere else: a cut is right at once
    assert time == pytest.approx(start + T * np.arange(13), abs=1e-9)
    assert y.tolist() == list(range(1, 14))


@pytest.mark.parametrize("start", [0.0, 2.5])
def test_a_step_beyond_the_instant_is_refused_with_the_part_up_to_it(start):
    # `run` never tries it, it asks for the next instant first; a diagram stepped by hand does
    sim, _ = beside_a_state(Total(0.1), 0.25, start, Solver=RKDP54)
    for dt, part in ((0.07, None), (0.12, 0.25), (0.03, None), (0.3, 1 / 3)):
        success, _, scale, *_ = sim.timestep(dt)
        assert success is (part is None)
        assert part is None or scale == pytest.approx(part, rel=1e-9)


@pytest.mark.parametrize(("T", "start"), [(1e-5, 2e4), (1e-6, 5e3), (0.01, 1e6), (0.1, 0.0)])
@pytest.mark.parametrize("parts", [1, 3])
def test_far_from_0_instants_are_still_told_apart(T, start, parts):
    # there the diagram's own clock is off by more than a short period's share
    count = Total(T)
    sim, _ = beside_a_state(count, T / parts, start)
    for _ in range(40 * parts):
        sim.timestep(T / parts)
    assert count.outputs[0] == 41.0
