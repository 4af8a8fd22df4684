"""What this package takes from inside PathSim: each failure here says what a new PathSim changed.

A diagram of PathSim's own blocks must go on to work then; the last tests run one.
"""

import ast
import re
from pathlib import Path

import pathsim
import pytest
from package_source import nodes
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Amplifier, Constant, Scope, Source
from pathsim.events import Event, ZeroCrossing
from pathsim.utils.register import Register

from pathsim_jsbsim_blocks import DiscretePID
from pathsim_jsbsim_blocks._core import pathsim_internals as seam
from pathsim_jsbsim_blocks._core.clock import Settling
from pathsim_jsbsim_blocks.scripts import runs

pytestmark = pytest.mark.matrix


def private_names():
    """All that PathSim keeps to itself; `_port_labels` is also how public names end."""
    files = Path(pathsim.__file__).parent.rglob("*.py")
    text = "".join(path.read_text(encoding="utf-8") for path in files)
    return {*re.findall(r"(?:\.|\bdef )(_(?!port_labels\b)[a-z]\w*)", text)}


def test_registers_keep_values_and_names_and_find_ports():
    register = Register(3, {"a": 0, "b": 1})
    for name, users in (
        ("_data", "values and show"),
        ("_mapping", "port_names"),
        ("_map", "port_number"),
    ):
        assert hasattr(register, name), f"Register.{name} is gone: {users} of the seam need it"
    seam.show(register, [1.0, 2.0])
    assert seam.values(register) == [1.0, 2.0, 0.0] == register.to_array().tolist()
    assert all(type(value) is float for value in seam.values(register))
    assert list(seam.port_names(register).items()) == [("a", 0), ("b", 1)]
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
    assert pid.inputs.wired == {"y"}, "connections no longer look ports up by Register._map"


def test_blocks_are_given_the_engine_of_the_simulation():
    pid = DiscretePID(T=0.1)
    interface = Interface()
    inner = Subsystem([interface, pid], [Connection(interface, pid), Connection(pid, interface)])
    sim = Simulation([inner], dt=0.1, log=False)
    assert pid._engine is sim.engine, "set_solver is no longer given the simulation's engine"


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
    assert not seam.is_dirty(sim)
    sim.add_block(Scope())
    assert seam.is_dirty(sim), "Simulation._graph_dirty no longer says that the diagram was changed"


def test_the_truth_value_of_what_a_diagram_has_is_whether_it_is_active():
    for thing in (Event(), Scope(), Connection(Scope(), Scope())):
        assert thing
        thing._active = False
        assert not thing, f"{type(thing).__name__}._active no longer says whether it is on"


def test_a_first_step_by_hand_begins_as_a_run_does():
    source, scope, times = Source(lambda t: 1.0), Scope(), []
    crossing = ZeroCrossing(lambda t: source.outputs[0] - 0.5, times.append)
    sim = Simulation([source, scope], [Connection(source, scope)], [crossing], dt=0.5, log=False)
    assert not sim.engine.history, "Solver.history no longer tells that no step was made"
    sim._buffer(0.0, 0.5)
    assert sim.engine.history
    seam.begin_stepping(sim)
    assert times == []
    assert [*map(list, scope.read())] == [[0.0], [[1.0]]]
    sim._sampling_enabled = False
    seam.begin_stepping(sim)
    assert len(scope.read()[0]) == 1, "Simulation._sampling_enabled no longer stops sampling"


def test_private_names_of_pathsim_are_in_the_seam_only():
    found, private = set(), private_names()
    for file, node in nodes():
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
            found.add(f"{file}: {name}")
        # the runner looks for the line of a script that it runs; blocks look at no frames
        if not file.startswith("scripts/") and name in ("_getframe", "currentframe"):
            found.add(f"{file}: {name}")
    assert {f for f in found if not f.startswith("_core/pathsim_internals.py: ")} == set()


def test_runs_that_pathsim_makes_itself_are_told_from_the_users():
    begun, inner = [], []
    sim = Simulation([Constant()], dt=0.1, log=False)
    with runs.intercepted_runs(lambda run: begun.append(run.method), "timestep", "steadystate"):
        with runs.intercepted_runs(inner.append):  # a context within, which has ended
            pass
        sim.run(0.3)
        sim.steadystate()
        sim.timestep()
    assert (begun, inner) == (["run", "steadystate", "timestep"], [])


def test_a_block_in_subsystems_is_told_the_solver_by_each_of_them():
    pid = wrapped = DiscretePID(T=0.1)
    for depth in (1, 2, 3):
        interface = Interface()
        wires = [Connection(interface, wrapped), Connection(wrapped, interface)]
        wrapped = Subsystem([interface, wrapped], wires)
        Simulation([wrapped], dt=0.1, log=False)
        found = [event for event in pid.events if isinstance(event, Settling)]
        assert len(found) == depth, "set_solver is no longer handed down by the subsystems"
    alone = DiscretePID(T=0.1)
    Simulation([alone], dt=0.1, log=False)
    assert alone.events == [alone.clock]
