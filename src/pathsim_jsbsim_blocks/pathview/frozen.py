"""Make two processes draw the same random numbers, read the same clock and take the same order."""

from __future__ import annotations

import itertools
import random
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

import numpy as np
import numpy.random.bit_generator as bit_generator

from .._core.pathsim_internals import in_listed_order

_ENTROPY = 20260101
_TICK = 1e-3  # s; the clock moves at each look, so that a loop that waits for it ends


class Frozen:
    """Randomness, time and order that do not depend on the process, within `applied`.

    Generators that are not given a seed all start from the same entropy. `time.time` starts at
    ``now``, in seconds since the epoch, and advances by a millisecond at each call.
    """

    def __init__(self, now: float):
        self.now = now
        self.seeded = False
        self._looks = itertools.count()

    @contextmanager
    def applied(self) -> Iterator[None]:
        """Context in which they hold; the global generators continue from before afterwards."""
        before = random.getstate(), np.random.get_state()  # noqa: NPY002
        seed = random.Random.seed

        def same(generator: random.Random, a: Any = None, version: int = 2) -> None:
            seed(generator, _ENTROPY if a is None else a, version)

        with ExitStack() as stack:
            stack.enter_context(in_listed_order())
            # where numpy takes the entropy of every generator without a seed
            stack.enter_context(patch.object(bit_generator, "randbits", lambda bits: _ENTROPY))
            stack.enter_context(patch.object(random.Random, "seed", same))
            seeds = ((random, ("seed", "setstate")), (np.random, ("seed", "set_state")))
            for module, name in ((module, name) for module, names in seeds for name in names):
                recording = self._recording_seeds(getattr(module, name))
                stack.enter_context(patch.object(module, name, recording))
            stack.enter_context(patch.object(time, "time", self._time))
            stack.enter_context(patch.object(time, "time_ns", lambda: int(self._time() * 1e9)))
            try:
                self.seeded = False
                self.begin()
                yield
            finally:
                random.setstate(before[0])
                np.random.set_state(before[1])  # noqa: NPY002

    def begin(self) -> None:
        """Start the clock, and the global generators unless they have been seeded."""
        self._looks = itertools.count()
        if not self.seeded:
            random._inst.seed(_ENTROPY)  # type: ignore[attr-defined]
            np.random.mtrand._rand.seed(_ENTROPY)

    def _recording_seeds(self, usual: Callable[..., Any]) -> Callable[..., Any]:
        def seed(*args: Any, **kwargs: Any) -> Any:
            given = [*args, *kwargs.values()]
            self.seeded = bool(given) and given[0] is not None
            return usual(*args, **kwargs) if self.seeded else usual(_ENTROPY)

        return seed

    def _time(self) -> float:
        return self.now + _TICK * next(self._looks)
