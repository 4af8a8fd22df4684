"""`NamedFunction`: base of the blocks without a state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pathsim.optim.operator import Operator

from .parameters import Parametric
from .pathsim_types import Function

# step of a derivative, relative to an input's value and at least this
_STEP = 1e-6


class NamedFunction(Parametric, Function):
    """Base of the blocks without a state: ``function`` is called with the inputs as floats."""

    function: Callable[..., Any]

    def _begin(self) -> None:
        # directly, because the constructors of pathsim-flight's classes do not accept a function
        Function.__init__(self, self.function)
        # Function's own operator returns a tuple, which PathSim cannot differentiate
        self.op_alg = Operator(self._values, self._slopes)

    def _values(self, u: np.ndarray) -> np.ndarray:
        return np.atleast_1d(self.function(*u.tolist()))

    def _slopes(self, u: np.ndarray) -> np.ndarray:
        # PathSim's relative steps of 1e-3 are too wide, for instance for a latitude
        steps = _STEP * np.maximum(np.abs(u), 1.0)
        changes = [self._values(u + step) - self._values(u - step) for step in np.diag(steps)]
        return np.column_stack(changes) / (2 * steps)
