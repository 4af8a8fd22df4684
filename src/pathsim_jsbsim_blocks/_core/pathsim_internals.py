"""All uses of PathSim's private names, in one place.

`tests/core/test_pathsim_seam.py` has a test for each, which fails if a new version of PathSim
changes it.
"""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Generator, Iterable, Sequence
from functools import partial
from typing import Any
from unittest.mock import patch

from pathsim import Connection, Simulation, Subsystem
from pathsim.blocks import Block, PinkNoise, StateSpace, WhiteNoise
from pathsim.events import Event, Schedule
from pathsim.utils.progresstracker import ProgressTracker
from pathsim.utils.register import Register

from .checks import did_you_mean, nearest_ports, refuse

# attribute of a block or a simulation: whether it is active
ON = "_active"


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
    """A function that reads a port, even after the register has got a new array."""
    return lambda: register._data.item(number)


def port_number(register: Register, port: str | int) -> int:
    """Number of a port that is given by name or number."""
    return register._map(port)


def own_events(subsystem: Subsystem) -> list[Event]:
    """Events of a subsystem itself, without those of the blocks inside."""
    return subsystem._events


def flies_matrices(block: Block) -> bool:
    """Whether a StateSpace is described by its matrices, unlike its subclass AntiWindupPID."""
    return isinstance(block, StateSpace) and (
        block.op_dyn._func.__code__ in StateSpace.__init__.__code__.co_consts
    )


class NamedRegister(Register):
    """Values by name; an unknown name is refused (PathSim would read 0)."""

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
            hint = did_you_mean(close) if close else f"; there is {', '.join(self._mapping)}"
            refuse("port", key, f"no port {key!r}{hint}")
        return self._mapping[key]

    def _ipython_key_completions_(self) -> list[str]:
        return [*self._mapping]

    def __str__(self) -> str:
        """A line for each port: name, or number without one, and value."""
        names = {number: name for name, number in self._mapping.items()}
        width, rows = max(map(len, self._mapping), default=0), enumerate(values(self))
        return "\n".join(f"  {names.get(i, str(i)):<{width}} {x:14.8g}" for i, x in rows)


class WiredRegister(NamedRegister):
    """Inputs that record which names are connected, when PathSim looks up their numbers."""

    __slots__ = ["wired"]

    def __init__(self, size: int | None = None, mapping: dict[str, int] | None = None):
        super().__init__(size, mapping)
        self.wired: set[str] = set()

    def _map(self, key: Any) -> Any:
        port = super()._map(key)
        self.wired.update(name for name, number in self._mapping.items() if number == port)
        return port


def tracker(sim: Simulation, duration: float) -> ProgressTracker:
    """The tracker with which `Simulation.run` logs progress and counts steps."""
    return ProgressTracker(duration, "TRANSIENT", logger=sim.logger, log=sim.log)


def run_loop(
    sim: Simulation, duration: float, reset: bool, adaptive: bool, progress: ProgressTracker
) -> Generator[dict[str, Any], None, None]:
    """The loop of `Simulation.run`, which yields after every step."""
    return sim._run_loop(duration, reset, adaptive, tracker=progress)


def is_dirty(sim: Simulation) -> bool:
    """Whether blocks or connections have changed since the graph was built."""
    return sim._graph_dirty


# blocks of a level of the graph, and its signals: connection, source, outputs, target, inputs
Level = tuple[list[Block], list[tuple[Connection, Block, Any, Block, Any]]]


def levels(sim: Simulation) -> list[Level]:
    """The evaluation of a diagram without loops, in order."""

    def acts(block: Block) -> bool:
        has_update = getattr(block.update, "__func__", None) is not Block.update
        return has_update or block.op_alg is not None

    return [
        (
            [block for block in blocks if acts(block)],
            [move for wire in wires for move in _moves(wire)],
        )
        for _, blocks, wires in sim.graph.dag()
    ]


def evaluate(levels: Sequence[Level], t: float) -> None:
    """Evaluate a diagram at ``t`` as PathSim does."""
    # `_active` directly: bool(block), which returns it, costs a call
    for blocks, moves in levels:
        for block in blocks:
            if block._active:
                block.update(t)
        for wire, source, i, target, j in moves:
            if wire._active:
                target.inputs._data[j] = source.outputs._data[i]


def sample(recorders: Sequence[Block], t: float, dt: float) -> None:
    """Let blocks record the end of a step as PathSim does."""
    for block in recorders:
        if block._active:
            block.sample(t, dt)


def _moves(wire: Connection) -> list[tuple[Connection, Block, Any, Block, Any]]:
    """The values that a connection copies: consecutive ports as a slice, others one by one."""
    source = wire.source
    moves: list[tuple[Connection, Block, Any, Block, Any]] = []
    i = [int(port_number(source.block.outputs, port)) for port in source.ports]
    for target in wire.targets:
        j = [int(port_number(target.block.inputs, port)) for port in target.ports]
        if len(i) > 1 and all(x == [*range(x[0], x[0] + len(x))] for x in (i, j)):
            rows = slice(i[0], i[-1] + 1), slice(j[0], j[-1] + 1)
            moves.append((wire, source.block, rows[0], target.block, rows[1]))
        else:
            moves += [(wire, source.block, a, target.block, b) for a, b in zip(i, j, strict=True)]
    return moves


def each_sample(
    sim: Simulation, take: Callable[[float], None]
) -> contextlib.AbstractContextManager[Any]:
    """Context in which ``take(t)`` is called after ``sim`` has sampled.

    It samples at the start of a run and after every accepted step.
    """
    usual = Simulation._sample

    def sample(self: Simulation, t: float, dt: float) -> None:
        usual(self, t, dt)
        if self is sim:
            take(t)

    return patch.object(Simulation, "_sample", sample)


def show_edited(sim: Simulation, dt: float, levels: Sequence[Level]) -> None:
    """Evaluate and sample a stopped diagram, as PathSim does at the start of a run."""
    update = partial(evaluate, levels) if levels else sim._update
    update(sim.time)
    for event, *_ in sim._detected_events(sim.time):
        event.resolve(sim.time)
        update(sim.time)
    sim._sample(sim.time, dt)


def begin_stepping(sim: Simulation) -> None:
    """In the first step of a diagram that is stepped by hand, do what a run does at its start."""
    if not sim._sampling_enabled:
        return
    monitors = [event for event in sim._get_active_events() if not isinstance(event, Schedule)]
    # the step has buffered these events before any evaluation: evaluate, and buffer them again
    sim._update(sim.time)
    for event in monitors:
        event.buffer(sim.time)
    show_edited(sim, sim.dt, [])
    for event in monitors:
        event.buffer(sim.time)


def draw_first(block: Block) -> None:
    """Repeat the draws that PathSim's noise sources make when they are built."""
    if isinstance(block, PinkNoise):
        block.reset()
    if isinstance(block, (PinkNoise, WhiteNoise)) and block.sampling_period is not None:
        block.events[0].func_act(0.0)
