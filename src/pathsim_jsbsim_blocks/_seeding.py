"""Seeds for the blocks of a diagram that draw random numbers."""

from __future__ import annotations

import contextlib
import functools
import os
import pickle
import random
import sys
import types
from collections.abc import Collection, Iterator, Sequence
from typing import Any
from unittest.mock import patch

import numpy as np
from pathsim import Simulation
from pathsim.blocks import (
    Block,
    ChirpPhaseNoiseSource,
    RandomNumberGenerator,
    SinusoidalPhaseNoiseSource,
)

from ._core.noise import WhiteNoise
from ._core.pathsim_internals import draw_first
from ._core.wiring import contents


class Seeding:
    """Context in which one seed determines all random numbers of a diagram.

    Python's and NumPy's global generators, from which blocks of PathSim draw, are seeded with it
    and restored at the end. Blocks with their own seed or generator are seeded by `seed_blocks`. At
    the end ``used`` tells whether any random number was drawn.
    """

    def __init__(self, seed: int):
        self.seed, self.used = seed, False
        self._blocks: list[Block] = []

    def __enter__(self) -> Seeding:
        self._usual = random.getstate(), np.random.get_state()  # noqa: NPY002
        random.seed(self.seed)
        # words of 32 bits, because a seed may be larger than NumPy accepts
        words = np.random.SeedSequence(self.seed).generate_state(4)
        np.random.seed(words)  # noqa: NPY002
        self._before = self._state()
        return self

    def __exit__(self, *_: Any) -> None:
        self._look()
        random.setstate(self._usual[0])
        np.random.set_state(self._usual[1])  # noqa: NPY002

    @contextlib.contextmanager
    def alone(self) -> Iterator[None]:
        """Context in which other code cannot seed the global generators."""

        def ignored(*_: Any, **__: Any) -> None: ...

        with patch.object(random, "seed", ignored), patch.object(np.random, "seed", ignored):
            yield

    def seed_blocks(self, sim: Simulation, fixed: Collection[Any] = ()) -> None:
        """Give each block except ``fixed`` its own seed, in the diagram's order."""
        self._look()
        self._blocks += seed_blocks(random_blocks(sim), self.seed, fixed)
        self._before = self._state()

    def _look(self) -> None:
        self.used = self.used or self._state() != self._before

    def _state(self) -> bytes:
        global_states = random.getstate(), np.random.get_state()  # noqa: NPY002
        return pickle.dumps((global_states, [_sources(block) for block in self._blocks]))


_SHARED = (RandomNumberGenerator, SinusoidalPhaseNoiseSource, ChirpPhaseNoiseSource)
_KINDS = (np.random.Generator, np.random.RandomState, random.Random, WhiteNoise)


def _sources(block: Block) -> list[Any]:
    """The generators that a block holds."""
    return [x for x in vars(block).values() if isinstance(x, _KINDS)]


def random_blocks(sim: Simulation) -> list[Block]:
    """The blocks of a diagram that have a seed or a generator, those in subsystems included."""
    return [b for b in contents(sim)[0] if hasattr(b, "seed") or _sources(b)]


def is_random(block: Any) -> bool:
    """Whether a block has a seed or a generator, or draws from NumPy's global one."""
    return isinstance(block, Block) and bool(
        hasattr(block, "seed") or _sources(block) or draws_from_shared(block)
    )


def draws_from_shared(block: Any) -> bool:
    """Whether a block draws from NumPy's global generator."""
    return isinstance(block, _SHARED)


def seed_blocks(blocks: Sequence[Block], seed: int, fixed: Collection[Any] = ()) -> list[Block]:
    """Give each block except ``fixed`` its own seed; return the seeded blocks."""
    result = []
    children = np.random.SeedSequence(seed).spawn(len(blocks))
    for block, child in zip(blocks, children, strict=True):
        if not any(block is x for x in fixed):
            _seed(block, int(child.generate_state(1)[0]))
            result.append(block)
    return result


def _seed(block: Block, seed: int) -> None:
    if hasattr(block, "seed"):
        block.seed = seed
    for source in _sources(block):
        if isinstance(source, np.random.Generator):
            bits = source.bit_generator
            bits.state = type(bits)(seed).state
        elif not isinstance(source, WhiteNoise):
            source.seed(seed)
    draw_first(block)


_LASTING = (
    np.random.Generator,
    np.random.RandomState,
    np.random.BitGenerator,
    np.random.SeedSequence,
    random.Random,
)


def outside_generators(function: Any) -> dict[str, Any]:
    """Generators that a function has from one call to the next, by name.

    They are those of its module, of other modules imported from its folder, of bound arguments,
    defaults, the closure, and the object whose method it is; those in dicts, classes and objects
    there; and those of which a method is there (``draw = rng.normal``).
    """
    objects: dict[str, Any] = {}
    while isinstance(function, functools.partial):
        bound = {**{str(i): value for i, value in enumerate(function.args)}, **function.keywords}
        objects |= {f"argument {name}": value for name, value in bound.items()}
        function = function.func
    owner = getattr(function, "__self__", function)
    attributes = getattr(owner, "__dict__", {})
    objects |= {f"attribute {name}": value for name, value in attributes.items()}
    if not hasattr(function, "__globals__"):  # an object that is called
        function = getattr(type(function).__call__, "__func__", type(function).__call__)
    function = getattr(function, "__func__", function)
    code = getattr(function, "__code__", None)
    if code is not None:
        defaults = [*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()]
        objects |= {f"default {i}": value for i, value in enumerate(defaults)}
        cells = zip(code.co_freevars, function.__closure__ or (), strict=False)
        objects |= {name: cell.cell_contents for name, cell in cells}
        objects |= function.__globals__
        folder = os.path.join(os.path.dirname(os.path.abspath(code.co_filename)), "")
        for name, module in list(sys.modules.items()):
            file = getattr(module, "__file__", None) or ""
            if file.startswith(folder) and "site-packages" not in file[len(folder) :]:
                objects |= {f"{name}.{x}": value for x, value in vars(module).items()}
    parts = [(name, x, part) for name, value in objects.items() for x, part in _parts(value)]
    objects |= {f"{name}.{x}": part for name, x, part in parts}
    for name, value in objects.items():
        if isinstance(value, (types.BuiltinMethodType, types.MethodType)):
            objects[name] = value.__self__
    return {
        name: value
        for name, value in objects.items()
        if isinstance(value, _LASTING) and not isinstance(value, random.SystemRandom)
    }


def _parts(value: Any) -> list[tuple[Any, Any]]:
    """Items of a dict, or attributes of a class or object, by name."""
    if isinstance(value, types.ModuleType):
        return []
    return list((value if isinstance(value, dict) else getattr(value, "__dict__", {})).items())
