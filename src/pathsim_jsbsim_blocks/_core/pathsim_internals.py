"""All uses of PathSim's internals, in one place: private names, and the methods that are replaced.

`tests/core/test_pathsim_seam.py` has a test for each name here, which shows what a new version of
PathSim has changed. `tests/core/test_pathsim_patches.py` shows each fault below in PathSim alone;
it fails once PathSim has cured it, and the patch can go. At import this module replaces

- ``Subsystem.events``, because a block in a subsystem samples its input of the step before
  (`Settling`);
- ``Simulation._run_loop``, because a run with a negative ``dt`` never ends and runs inside each
  other are accepted (`Steps`), and blocks are not told that a run begins (`before_runs`);
- ``LoggerManager._setup_root_logger``, because it sends all warnings to a log without a handler
  (`keep_warnings_visible`).

Two modules replace more through functions here:

- `wiring`, the methods of ``Simulation``, ``Subsystem``, ``Connection`` and ``Graph`` that take
  blocks and connections, because their errors name neither (`check_diagrams`);
- `checkpoint`, ``Simulation.save_checkpoint`` and ``load_checkpoint``, because a damaged
  checkpoint is loaded (`replace_checkpoints`).
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import logging
import math
import threading
import warnings
import weakref
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from operator import itemgetter
from typing import Any, NoReturn
from unittest.mock import patch
from weakref import WeakKeyDictionary

from pathsim import Connection, Simulation, Subsystem
from pathsim.blocks import Block, PinkNoise, WhiteNoise
from pathsim.events import Event
from pathsim.solvers._solver import Solver
from pathsim.utils.graph import Graph
from pathsim.utils.logger import LoggerManager
from pathsim.utils.progresstracker import ProgressTracker
from pathsim.utils.register import Register

from .checks import did_you_mean, nearest_ports, number, positive, refuse

# names in a block, for who compares two: whether it is on, and what a run changes
ON = "_active"
OF_A_RUN = {"graph", "inputs", "outputs", "engine", "_solver_args"}


def values(register: Register) -> list[float]:
    """The values in a block's inputs or outputs."""
    return register._data.tolist()


def show(register: Register, y: Sequence[float]) -> None:
    """Put values into the first ports."""
    register._data[: len(y)] = y


def port_names(register: Register) -> dict[str, int]:
    """Name and number of each named port."""
    return register._mapping


def port_reader(register: Register, number: int) -> Callable[[], float]:
    """A function that reads a port, whatever array the register then has."""
    return lambda: register._data.item(number)


def port_number(register: Register, port: str | int) -> int:
    """Number of a port that is given by name or number."""
    return register._map(port)


def own_events(subsystem: Subsystem) -> list[Event]:
    """Events of a subsystem itself, without those of the blocks inside."""
    return subsystem._events


class NamedRegister(Register):
    """Values by name; a name that does not exist is refused, where PathSim reads 0."""

    __slots__ = ()

    @classmethod
    def of(cls, *names: Iterable[str]) -> NamedRegister:
        """A register with a port for each name, those of several lists one after the other."""
        ports = [*itertools.chain(*names)]
        return cls(len(ports), {name: i for i, name in enumerate(ports)})

    def __getitem__(self, key: Any) -> Any:
        return super().__getitem__(self._number(key))

    def __setitem__(self, key: Any, value: Any) -> None:
        super().__setitem__(self._number(key), value)

    def _number(self, key: Any) -> Any:
        if not isinstance(key, str):
            return key
        if key not in self._mapping:
            close = nearest_ports(key, self._mapping)
            known = did_you_mean(close) if close else f"; there is {', '.join(self._mapping)}"
            refuse("port", key, f"no port {key!r}{known}")
        return self._mapping[key]

    def _ipython_key_completions_(self) -> list[str]:
        return [*self._mapping]

    def __str__(self) -> str:
        """A line for each port: name, or number without one, and value."""
        names = {number: name for name, number in self._mapping.items()}
        width, rows = max(map(len, self._mapping), default=0), enumerate(values(self))
        return "\n".join(f"  {names.get(i, str(i)):<{width}} {x:14.8g}" for i, x in rows)


class WiredRegister(NamedRegister):
    """Inputs that record which ports are connected: PathSim looks up their numbers."""

    __slots__ = ["wired"]

    def __init__(self, size: int | None = None, mapping: dict[str, int] | None = None):
        super().__init__(size, mapping)
        self.wired: set[int] = set()

    def _map(self, key: Any) -> Any:
        port = super()._map(key)
        self.wired.add(port)
        return port


# PathSim counts the stages of a step from 0
_BEFORE_STAGES = -1


def step_begins(engine: Solver) -> None:
    """Mark the start of a step in the engine of the simulation."""
    engine._stage = _BEFORE_STAGES


def without_stages(engine: Solver) -> bool:
    """Whether no solver stage was evaluated since the start of the step.

    A diagram without continuous states has none: its first evaluation in a step is that of the
    step's end. (The buffers of implicit solvers start counting at once; the answer is no then.)
    """
    return engine._stage == _BEFORE_STAGES


def show_without_stages(engine: Solver, register: Register, y: Sequence[float]) -> bool:
    """`show`, if no solver stage was evaluated since the start of the step; tells whether."""
    if engine._stage != _BEFORE_STAGES:
        return False
    register._data[: len(y)] = y
    return True


class ClockEvent(Event):
    """Event of a sampled block, which marks when values are still propagating to it."""

    def __init__(self) -> None:
        super().__init__()
        self.settling = False
        # inside a subsystem
        self.nested = False


class Settling(Event):
    """One more pass through the graph after a block in a subsystem has acted.

    A subsystem without direct feed-through is evaluated before its surroundings, so what enters it
    needs another pass to reach the blocks inside. It is resolved last, so that changes by other
    events at that time reach them too.
    """

    def __init__(self) -> None:
        super().__init__()
        self.clocks: list[ClockEvent] = []

    def detect(self, t: float) -> tuple[bool, bool, float]:
        settling = any(clock.settling and bool(clock) for clock in self.clocks)
        return settling, settling, math.inf

    def resolve(self, t: float) -> None:
        """No action; resolving any event triggers the graph pass we need."""


_events_of_blocks = Subsystem.events.fget
_settling: WeakKeyDictionary[Subsystem, Settling] = WeakKeyDictionary()


def _events(subsystem: Subsystem) -> list[Event]:
    """Events of the blocks inside and, where blocks sample there, the pass that they need.

    `Subsystem.events` is the only call that sees a subsystem with the blocks at any depth in it.
    """
    events = _events_of_blocks(subsystem)
    clocks = [event for event in events if isinstance(event, ClockEvent)]
    if clocks:
        for clock in clocks:
            clock.nested = True
        settling = _settling.setdefault(subsystem, Settling())
        settling.clocks = clocks
        events.append(settling)
    return events


Subsystem.events = property(_events, doc=Subsystem.events.__doc__)


# the latest run of a simulation, or of the clock of a sampled block, while anything continues it
_latest: WeakKeyDictionary[Simulation | Event, weakref.ref[Steps]] = WeakKeyDictionary()
_beginning = threading.Lock()


class Steps(Iterator[dict[str, Any]]):
    """The steps of a run, as PathSim's loop makes them.

    Two runs at once of a simulation, or of two simulations that share a sampled block, would each
    make a part of the steps: where one begins inside a step of the other, in an event or in another
    thread, both end with an error. A run that is left unfinished blocks no other.
    """

    def __init__(self, sim: Simulation, loop: Generator[dict[str, Any], None, None]):
        self._sim, self._loop = sim, loop
        # the run that began meanwhile
        self._other: Steps | None = None
        self._inside = False
        events = (event for block in sim.blocks for event in block.events)
        parts = [sim, *(event for event in events if isinstance(event, ClockEvent))]
        with _beginning:
            earlier = [steps for part in parts if (steps := _latest.get(part, lambda: None)())]
            for steps in earlier:
                # set before `_inside` is read; a step of another thread does it the other way
                # round, so that one of them sees the other
                steps._other = self
            if any(steps._inside for steps in earlier):
                self._refuse()
            _latest.update(dict.fromkeys(parts, weakref.ref(self)))

    def __next__(self) -> dict[str, Any]:
        with self:
            self.go_on()
            return next(self._loop)

    def close(self) -> None:
        """End PathSim's loop; more steps may be made inside ``with``, after a `go_on` each."""
        self._loop.close()

    def go_on(self) -> bool:
        """Whether nothing has stopped the run; refused where another run has begun."""
        if self._other is not None:
            self._other._other = self
            self._refuse()
        return self._sim._active

    def _refuse(self) -> NoReturn:
        why = "two runs at once of a simulation, or of a block that two simulations share: one "
        why += "began inside an event of the other, or in another thread. Both end here; build a "
        refuse("sim", self._sim, f"{why}diagram for each")

    def __enter__(self) -> Steps:
        self._inside = True
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: Any) -> None:
        try:
            # PathSim's loop ends quietly where a block or event has raised StopSimulation
            ended = kind is not None and (kind is not StopIteration or not is_running(self._sim))
            if ended and not (self._other and self._other._inside):
                _show_again(self._sim, self._sim.time)
        finally:
            self._inside = False


def _show_again(diagram: Simulation | Subsystem, t: float) -> None:
    """Show the values at ``t`` again, the start of a step that an exception has ended.

    Which blocks the step had reached varies: PathSim orders the blocks of a level by address. A
    block that fails again keeps its last values.
    """
    for _, blocks, connections in diagram.graph.dag():
        for block in filter(None, blocks):
            if isinstance(block, Subsystem):
                _show_again(block, t)
            else:
                with contextlib.suppress(Exception):
                    block.update(t)
        for connection in filter(None, connections):
            connection.update()
    if diagram.graph.has_loops:
        with contextlib.suppress(Exception):
            diagram._loops(t)


# called when a run begins, of any kind, with the simulation and whether the run resets it
before_runs: list[Callable[[Simulation, bool], None]] = []


def _announce_runs() -> None:
    loop = Simulation._run_loop
    if hasattr(loop, "__wrapped__"):  # the package was imported again
        loop = loop.__wrapped__

    @functools.wraps(loop)
    def announced(self: Simulation, duration: float, reset: bool, *args: Any, **kwargs: Any) -> Any:
        # PathSim's loop never ends without
        number("dt", positive("dt", self.dt))
        steps = Steps(self, loop(self, duration, reset, *args, **kwargs))
        for call in before_runs:
            call(self, reset)
        return steps

    Simulation._run_loop = announced


_announce_runs()


def check_diagrams(
    part: Callable[[Any, type], None],
    ends: Callable[..., None],
    wire: Callable[[Connection], None],
    wires: Callable[[Sequence[Connection]], None],
) -> None:
    """Have blocks and connections checked before PathSim takes them, and fails elsewhere.

    ``part`` is called with each part of a diagram and what it must be, a Block or a Connection;
    ``ends`` with a connection that is to be made and what it is to join; ``wire`` with one that is
    made; ``wires`` with all those of a diagram.
    """

    def inside(subsystem: Subsystem) -> None:
        for kind, found in ((Block, subsystem.blocks), (Connection, subsystem.connections)):
            for x in found:
                part(x, kind)

    _before(Simulation, "add_block", lambda sim, block: part(block, Block))
    _before(Simulation, "add_connection", lambda sim, connection: part(connection, Connection))
    _before(Subsystem, "_assemble_graph", inside)
    _before(Connection, "__init__", ends)
    _before(Connection, "_validate_dimensions", wire)
    _before(Graph, "_validate_connections", lambda graph: wires(graph.connections))


def _before(owner: type, name: str, check: Callable[..., None]) -> None:
    """Call ``check`` with the arguments of a method, and then the method."""
    method = getattr(owner, name)
    method = getattr(method, "__wrapped__", method)  # the package was imported again

    @functools.wraps(method)
    def checked(*args: Any, **kwargs: Any) -> Any:
        check(*args, **kwargs)
        return method(*args, **kwargs)

    setattr(owner, name, checked)


def replace_checkpoints(save: Callable[..., None], load: Callable[..., None]) -> None:
    """Have every simulation save and load its checkpoints with these functions."""
    Simulation.save_checkpoint, Simulation.load_checkpoint = save, load


def tracker(sim: Simulation, duration: float) -> ProgressTracker:
    """The tracker with which `Simulation.run` logs progress and counts steps."""
    return ProgressTracker(duration, "TRANSIENT", logger=sim.logger, log=sim.log)


def run_loop(
    sim: Simulation, duration: float, reset: bool, adaptive: bool, progress: ProgressTracker
) -> Steps:
    """The loop of `Simulation.run`, which yields after every step."""
    return sim._run_loop(duration, reset, adaptive, tracker=progress)


def each_sample(
    sim: Simulation, take: Callable[[float], None]
) -> contextlib.AbstractContextManager[Any]:
    """Context in which ``take(t)`` is called when ``sim`` has sampled.

    It samples when a run begins and after every step that is not rejected.
    """
    usual = Simulation._sample

    def sample(self: Simulation, t: float, dt: float) -> None:
        usual(self, t, dt)
        if self is sim:
            take(t)

    return patch.object(Simulation, "_sample", sample)


def in_listed_order() -> contextlib.AbstractContextManager[Any]:
    """Context in which a graph orders the blocks of a level as its diagram lists them.

    PathSim orders them by address, which matters to functions that share state.
    """
    assemble, process_loops = Graph._assemble, Graph._process_loops

    def ordered(graph: Graph) -> None:
        place = {block: i for i, block in enumerate(graph.blocks)}

        def listed(blocks: Iterable[Block]) -> dict[Block, None]:
            return dict.fromkeys(sorted(blocks, key=lambda b: place.get(b, len(place))))

        graph._alg_blocks, graph._dyn_blocks = listed(graph._alg_blocks), listed(graph._dyn_blocks)
        for neighbours in (graph._upst_blk_blk_map, graph._dnst_blk_blk_map):
            neighbours.update({block: listed(others) for block, others in neighbours.items()})
        assemble(graph)

    def process(graph: Graph, blocks: set[Block]) -> None:
        process_loops(graph, [block for block in graph.blocks if block in blocks])

    return patch.multiple(Graph, _assemble=ordered, _process_loops=process)


def show_edited(sim: Simulation, dt: float) -> None:
    """Evaluate and sample a diagram that has stopped, as PathSim's loop does when a run begins."""
    sim._update(sim.time)
    for event, *_ in sim._detected_events(sim.time):
        event.resolve(sim.time)
        sim._update(sim.time)
    sim._sample(sim.time, dt)


def fixed_step(sim: Simulation, dt: float) -> Callable[[], bool]:
    """A function that makes a step of ``dt`` as `Simulation.timestep` does, and tells success.

    In a diagram without continuous states and algebraic loops it calls the same methods of the same
    events, blocks and solver in the same order and moves the same values, but takes the order and
    the ports from lists that are made once per graph. Whatever else a diagram has, `timestep` does,
    also the assembly of a diagram that was changed.
    """
    graph = None
    levels: list[tuple[Any, Any]] | None = None
    sampled: list[Block] = []

    def step() -> bool:
        nonlocal graph, levels, sampled
        if graph is not sim.graph:
            graph, levels, sampled = sim.graph, _levels(sim), _sampled(sim)
        if levels is None or sim._graph_dirty or sim._blocks_dyn or sim.diagnostics is not None:
            success, *_ = sim.timestep(dt, adaptive=False)
            return success
        t = sim.time
        # the truth value of an event, a block and a connection is its `_active`
        for event in sim.events:
            if event._active:
                event.buffer(t)
        for block in sim._blocks_evt:
            for event in block.events:
                if event._active:
                    event.buffer(t)
        sim.engine.buffer(dt)
        t += dt
        if sim._graph_dirty:
            # the function of an event, evaluated above, has changed the diagram
            sim._update(t)
        else:
            for blocks, connections in levels:
                for block in blocks:
                    if block._active:
                        block.update(t)
                for connection, transfers in connections:
                    if connection._active:
                        for source, i, target, j in transfers:
                            target.inputs._data[j] = source.outputs._data[i]
        detected = []
        for event in sim.events:
            if event._active:
                found, _, ratio = event.detect(t)
                if found:
                    detected.append((ratio, event))
        for block in sim._blocks_evt:
            for event in block.events:
                if event._active:
                    found, _, ratio = event.detect(t)
                    if found:
                        detected.append((ratio, event))
        if detected:
            for ratio, event in sorted(detected, key=itemgetter(0)):
                event.resolve(sim.time + ratio * dt)
                sim._update(t)
        if sim._graph_dirty or graph is not sim.graph:
            sim._sample(t, dt)
        elif sim._sampling_enabled:
            for block in sampled:
                if block._active:
                    block.sample(t, dt)
        sim.time = t
        return True

    return step


def _levels(sim: Simulation) -> list[tuple[Any, Any]] | None:
    """Blocks and transfers of each level of the graph; None for what only `timestep` can do."""
    if (
        type(sim) is not Simulation
        or sim.graph.has_loops
        or any(type(connection) is not Connection for connection in sim.connections)
    ):
        return None
    return [
        (blocks, [(connection, _transfers(connection)) for connection in connections])
        for _, blocks, connections in sim.graph.dag()
    ]


def _sampled(sim: Simulation) -> list[Block]:
    """Blocks that have a method `sample` of their own."""
    return [
        block for block in sim.blocks if getattr(block.sample, "__func__", None) is not Block.sample
    ]


def _transfers(connection: Connection) -> list[tuple[Any, Any, Any, Any]]:
    """Source block and port, target block and port, for each target of a connection."""

    def ports(indices: Any) -> Any:
        # numpy takes a fifth of the time for one number instead of an array with one, and a third
        # for a slice
        first = int(indices[0])
        if len(indices) == 1:
            return first
        row = slice(first, first + len(indices))
        return row if list(indices) == list(range(row.start, row.stop)) else indices

    source = connection.source
    i = ports(source._get_output_indices())
    return [
        (source.block, i, target.block, ports(target._get_input_indices()))
        for target in connection.targets
    ]


def in_step(sim: Simulation) -> bool:
    """Whether a run is making a step just now."""
    steps = _latest.get(sim, lambda: None)()
    return steps is not None and steps._inside


def is_running(sim: Simulation) -> bool:
    """Whether the run is still active: `Simulation.stop` has not been called."""
    return sim._active


def draw_first(block: Block) -> None:
    """Repeat what PathSim's noise sources draw when they are built."""
    if isinstance(block, PinkNoise):
        block.octave_values = block._rng.normal(0, 1, block.num_octaves)
        block.n_samples = 0
    if isinstance(block, (PinkNoise, WhiteNoise)) and block.sampling_period is not None:
        block._current_sample = block._generate_sample(block.sampling_period)
        block.outputs[0] = block._current_sample


def keep_warnings_visible() -> None:
    """Stop PathSim from redirecting Python's warnings.

    The first `Simulation` redirects all warnings into `logging`, where no handler shows them.
    """
    redirect = getattr(LoggerManager, "_setup_root_logger", None)
    if redirect is None or hasattr(redirect, "__wrapped__"):
        return
    if LoggerManager._initialized and _lost():
        logging.captureWarnings(False)

    @functools.wraps(redirect)
    def without_redirection(self: LoggerManager) -> None:
        shown = warnings.showwarning
        redirect(self)
        if warnings.showwarning is not shown:
            logging.captureWarnings(False)

    LoggerManager._setup_root_logger = without_redirection


def _lost() -> bool:
    """Whether warnings are redirected to `logging` and no handler shows them."""
    loggers = (logging.Logger.manager.loggerDict.get("py.warnings"), logging.root)
    return warnings.showwarning.__module__ == logging.__name__ and all(
        isinstance(handler, logging.NullHandler)
        for logger in loggers
        for handler in getattr(logger, "handlers", ())
    )


keep_warnings_visible()
