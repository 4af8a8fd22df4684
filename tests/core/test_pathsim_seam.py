"""What this package takes from inside PathSim: each failure here says what a new PathSim changed.

A diagram of PathSim's own blocks must go on to work then; the last tests run one.
"""

import ast
import logging
import re
import warnings
from pathlib import Path

import numpy as np
import pathsim
import pytest
from package_source import nodes
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Adder, Amplifier, Block, Constant, Integrator, Scope, Source
from pathsim.events import Condition, Event, ZeroCrossing
from pathsim.solvers import EUB, EUF, RK4, SSPRK22
from pathsim.utils.logger import LoggerManager
from pathsim.utils.register import Register

from pathsim_jsbsim_blocks import DiscretePID
from pathsim_jsbsim_blocks._core import pathsim_internals as seam
from pathsim_jsbsim_blocks._core import running
from pathsim_jsbsim_blocks.scripts import runs

pytestmark = pytest.mark.matrix


def private_names():
    """All that PathSim keeps to itself; `_port_labels` is also how public names end."""
    trees = (
        ast.parse(path.read_text(encoding="utf-8"))
        for path in Path(pathsim.__file__).parent.rglob("*.py")
    )
    used = {
        node.attr if isinstance(node, ast.Attribute) else node.name
        for tree in trees
        for node in ast.walk(tree)
        if isinstance(node, (ast.Attribute, ast.FunctionDef))
    }
    return {name for name in used if re.match("_(?!port_labels$)[a-z]", name)}


def test_registers_keep_their_values_in_data():
    register = Register(3)
    assert hasattr(register, "_data"), (
        "Register._data is gone: pathsim_internals.values and show need it"
    )
    seam.show(register, [1.0, 2.0])
    assert seam.values(register) == [1.0, 2.0, 0.0] == register.to_array().tolist()
    assert all(type(value) is float for value in seam.values(register))


def test_registers_keep_their_names_in_mapping():
    register = Register(2, {"a": 0, "b": 1})
    assert hasattr(register, "_mapping"), (
        "Register._mapping is gone: pathsim_internals.port_names needs it"
    )
    assert list(seam.port_names(register).items()) == [("a", 0), ("b", 1)]


def test_registers_find_ports_by_name_and_number():
    register = Register(2, {"a": 0, "b": 1})
    assert hasattr(register, "_map"), (
        "Register._map is gone: pathsim_internals.port_number needs it"
    )
    assert [seam.port_number(register, port) for port in ("b", 1, "a")] == [1, 1, 0]


def test_a_connection_asks_the_register_for_the_port_that_it_leads_to():
    pid, source, scope = DiscretePID(T=0.1), Source(lambda t: 1.0), Scope()
    sim = Simulation(
        [pid, source, scope],
        [Connection(source, pid["y"]), Connection(pid, scope)],
        dt=0.1,
        log=False,
    )
    sim.run(0.1)
    assert pid.inputs.wired == {1}, "connections no longer look ports up by Register._map"


class Stages(Event):
    """Notes, at the end of a step, whether it had stages."""

    def __init__(self, engine):
        super().__init__()
        self.engine, self.without = engine, []

    def buffer(self, t):
        seam.step_begins(self.engine)

    def detect(self, t):
        self.without.append(seam.without_stages(self.engine))
        return super().detect(t)


@pytest.mark.parametrize("solver", [SSPRK22, RK4, EUF, EUB])
@pytest.mark.parametrize("states", [0, 1])
def test_the_engine_counts_the_stages_of_a_step(solver, states):
    sim = Simulation(
        [Source(lambda t: t), Scope(), *(Integrator() for _ in range(states))],
        dt=0.1,
        Solver=solver,
        log=False,
    )
    stages = Stages(sim.engine)
    sim.add_event(stages)
    sim.run(0.5)
    steps = stages.without[1:]
    assert len(steps) == 5
    # an implicit solver counts from the start of the step, which is the safe answer
    expected = not states and solver is not EUB
    assert steps == [expected] * 5, "Solver.stage no longer counts from 0 within a step"


def test_blocks_are_given_the_engine_of_the_simulation():
    pid = DiscretePID(T=0.1)
    interface = Interface()
    inner = Subsystem([interface, pid], [Connection(interface, pid), Connection(pid, interface)])
    sim = Simulation([inner], dt=0.1, log=False)
    assert pid._engine is sim.engine, "set_solver is no longer given the simulation's engine"


def test_a_subsystem_adds_one_pass_for_the_blocks_inside_it():
    pid, wrapped = DiscretePID(T=0.1), None
    wrapped = pid
    for depth in (1, 2, 3):
        interface = Interface()
        wrapped = Subsystem(
            [interface, wrapped], [Connection(interface, wrapped), Connection(wrapped, interface)]
        )
        settling = [e for e in wrapped.events if isinstance(e, seam.Settling)]
        assert len(settling) == depth, "Subsystem.events no longer collects those of its blocks"
        assert all(e.clocks == [pid.clock] for e in settling)
    assert pid.clock.nested


def test_a_subsystem_without_sampled_blocks_is_left_alone():
    crossing = ZeroCrossing(lambda t: t - 0.5)
    interface, amplifier = Interface(), Amplifier(2.0)
    system = Subsystem(
        [interface, amplifier],
        [Connection(interface, amplifier), Connection(amplifier, interface)],
        [crossing],
    )
    assert system.events == [crossing]
    assert hasattr(system, "_events"), (
        "Subsystem._events is gone: pathsim_internals.own_events needs it"
    )
    assert seam.own_events(system) == [crossing]


def test_the_loop_of_run_yields_after_every_step():
    assert hasattr(Simulation, "_run_loop"), "Simulation._run_loop is gone: fly needs it"
    sim = Simulation([Scope()], [], dt=0.5, log=False)
    progress = seam.tracker(sim, 2.0)
    progress.start()
    loop = seam.run_loop(sim, 2.0, False, False, progress)
    next(loop)
    assert sim.time == 0.5, "Simulation._run_loop no longer yields after each step"
    assert seam.is_running(sim)
    sim.stop()
    assert not seam.is_running(sim), "Simulation._active no longer says whether a run goes on"


class Calls(Block):
    """Notes the calls of a step, and raises an event in some of them."""

    def __init__(self, name, calls, period=None):
        super().__init__()
        self.name, self.calls = name, calls
        event = Event()
        event.buffer = lambda t: calls.append((name, "buffer", t))
        event.detect = lambda t: (calls.append((name, "detect", t)) or self.due(t), True, 0.5)
        event.resolve = lambda t: calls.append((name, "resolve", t))
        self.period, self.events = period, [event]

    def due(self, t):
        return self.period is not None and abs(t / self.period - round(t / self.period)) < 1e-9

    def update(self, t):
        self.calls.append((self.name, "update", t, self.inputs.to_array().tolist()))
        self.outputs.update_from_array([t, 2.0 * t + self.inputs[0], 3.0])

    def sample(self, t, dt):
        self.calls.append((self.name, "sample", t, dt, self.inputs.to_array().tolist()))


def test_a_step_makes_the_calls_of_timestep():
    def steps(step_of):
        calls = []
        a, b, c = (Calls(n, calls, p) for n, p in (("a", 0.3), ("b", None), ("c", 0.2)))
        sim = Simulation(
            [a, b, c],
            [Connection(a[0], b[0], c[1]), Connection(b[0, 1, 2], c[2, 0, 4])],
            dt=0.1,
            log=False,
        )
        sim.engine.buffer = lambda dt: calls.append(("engine", dt))
        step = step_of(sim)
        for _ in range(12):
            step()
        assert sim.time == pytest.approx(1.2)
        return calls

    expected = steps(lambda sim: lambda: sim.timestep(sim.dt, adaptive=False))
    found = steps(lambda sim: seam.fixed_step(sim, sim.dt))
    assert any(call[1] == "resolve" for call in found)
    assert found == expected, (
        "Simulation.timestep has changed: pathsim_internals.fixed_step must follow it"
    )


def test_the_truth_value_of_what_a_diagram_has_is_whether_it_is_active():
    for thing in (Event(), Scope(), Connection(Scope(), Scope())):
        assert thing
        thing._active = False
        assert not thing, f"{type(thing).__name__}._active no longer says whether it is on"


def test_a_piece_of_a_run_begins_as_a_run_does():
    def diagram():
        source, scope, calls = Source(lambda t: t), Scope(), []
        event = Condition(lambda t: source.outputs[0] >= 0.5, lambda t: calls.append(t))
        sim = Simulation([source, scope], [Connection(source, scope)], [event], dt=0.25, log=False)
        return sim, scope, calls

    (sim, scope, calls), (other, again, late) = diagram(), diagram()
    pieces = running.Pieces(other)
    for count in (1, 2, 3):
        sim.run(count * 0.25)
        assert pieces.run(count)
    assert other.time == sim.time == 1.5
    assert calls == late
    assert len(calls) > 0
    for one, two in zip(scope.read(), again.read(), strict=True):
        assert np.array_equal(one, two)


def test_a_step_samples_as_pathsim_does():
    kept = []
    own, switched, last = Calls("own", kept), Calls("switched off", kept), Scope()
    sim = Simulation([own, switched, Amplifier(), last], [Connection(own, last)], dt=0.1, log=False)
    last.sample = lambda t, dt: kept.append(("set on the block", "sample"))
    step = seam.fixed_step(sim, 0.1)

    def sampled():
        kept.clear()
        step()
        return [name for name, call, *_ in kept if call == "sample"]

    assert sampled() == ["own", "switched off", "set on the block"]
    switched.off()
    assert sampled() == ["own", "set on the block"]
    added = Calls("added", kept)
    sim.add_block(added)
    assert sampled() == ["own", "set on the block", "added"]
    # as while PathSim searches a periodic solution
    sim._sampling_enabled = False
    assert sampled() == []


@pytest.mark.parametrize("nested", [False, True], ids=["simulation", "subsystem"])
def test_loops_are_solved_after_the_levels_of_the_graph(nested):
    one, total, half = Source(lambda t: 1.0 + t), Adder(), Amplifier(0.5)
    blocks = [one, total, half]
    wires = [Connection(one, total[0]), Connection(total, half), Connection(half, total[1])]
    diagram = Subsystem([Interface(), *blocks], wires) if nested else Simulation(blocks, wires)
    assert diagram.graph.has_loops
    sim = Simulation([diagram], dt=0.1, log=False) if nested else diagram
    sim.run(0.1)
    assert total.outputs[0] == pytest.approx(2.0 * (1.0 + sim.time))
    seam._show_again(sim, 1.0)
    assert total.outputs[0] == pytest.approx(4.0)


def test_pathsim_redirects_warnings_in_one_method():
    assert hasattr(LoggerManager, "_setup_root_logger"), (
        "LoggerManager._setup_root_logger is gone: keep_warnings_visible wraps it"
    )
    assert hasattr(LoggerManager, "_initialized")


@pytest.mark.parametrize("by_pathsim", [True, False])
def test_warnings_are_given_back_where_pathsim_took_them(by_pathsim, monkeypatch):
    monkeypatch.setattr(LoggerManager, "_setup_root_logger", lambda self: None)
    monkeypatch.setattr(LoggerManager, "_initialized", by_pathsim)
    for logger in (logging.root, logging.getLogger("py.warnings")):
        monkeypatch.setattr(logger, "handlers", [])
    shown = warnings.showwarning
    logging.captureWarnings(True)
    try:
        taken = warnings.showwarning
        assert taken is not shown
        seam.keep_warnings_visible()
        assert warnings.showwarning is (shown if by_pathsim else taken)
    finally:
        logging.captureWarnings(False)


def test_a_diagram_of_scopes_runs():
    source, scope = Source(lambda t: 2.0 * t), Scope()
    sim = Simulation([source, scope], [Connection(source, scope)], dt=0.1, log=False)
    sim.run(1.0)
    time, data = scope.read()
    assert np.allclose(data[0], 2.0 * time)


def test_private_names_of_pathsim_are_in_the_seam_only():
    found, private = set(), private_names()
    for file, node in nodes():
        path = Path(file)
        if isinstance(node, ast.Attribute):
            own = isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")
            name = "" if own else node.attr
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            name = node.value
        elif isinstance(node, ast.ImportFrom):
            name = re.search(r"^pathsim\..*\b_\w+|$", node.module or "")[0]
        else:
            continue
        if name in private or (isinstance(node, ast.ImportFrom) and name):
            found.add(f"{path.parent.name}/{path.name}: {name}")
        # the runner looks for the line of a script that it runs; blocks look at no frames
        if path.parent.name != "scripts" and name in ("_getframe", "currentframe"):
            found.add(f"{path.name}: {name}")
    assert {f for f in found if not f.startswith("_core/pathsim_internals.py: ")} == set()


def test_runs_that_pathsim_makes_itself_are_told_from_the_users():
    begun = []
    sim = Simulation([Constant()], dt=0.1, log=False)
    with runs.intercepted_runs(lambda run: begun.append(run.method), "timestep", "steadystate"):
        sim.run(0.3)
        sim.steadystate()
        sim.timestep()
    assert begun == ["run", "steadystate", "timestep"]


def test_the_blocks_of_a_level_come_as_the_diagram_lists_them():
    blocks = [Constant(float(i)) for i in range(20)][::-1]  # not by address
    with seam.in_listed_order():
        sim = Simulation(blocks, log=False)
    assert [b for _, level, _ in sim.graph.dag() for b in level] == blocks
