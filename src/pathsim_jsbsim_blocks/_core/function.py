"""`NamedFunction`: base of the blocks without a state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pathsim.optim.operator import Operator

from .parameters import Parametric
from .pathsim_types import Function

# relative to an input's value, and the least
_STEP = 1e-6


class NamedFunction(Parametric, Function):
    """Base of the blocks without a state: ``function`` of the inputs, given as floats."""

    function: Callable[..., Any]

    def _begin(self) -> None:
        # past the constructors of pathsim-flight's classes, which take no function
        Function.__init__(self, self.function)
        # Function's own operator gives a tuple, which PathSim cannot differentiate
        self.op_alg = Operator(self._values, self._slopes)

    def _values(self, u: np.ndarray) -> np.ndarray:
        return np.atleast_1d(self.function(*u.tolist()))

    def _slopes(self, u: np.ndarray) -> np.ndarray:
        # PathSim's steps are of a thousandth: too wide for a latitude
        steps = _STEP * np.maximum(np.abs(u), 1.0)
        changes = [self._values(u + step) - self._values(u - step) for step in np.diag(steps)]
        return np.column_stack(changes) / (2 * steps)
