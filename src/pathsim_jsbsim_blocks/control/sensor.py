"""`Sensor`: a measurement with lag, bias, noise and quantisation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from .._core.checks import integer, number, positive
from .._core.noise import WhiteNoise
from .._core.parameters import parameter
from .._core.sampling import SampledLaw


@dataclass(eq=False, repr=False)
class Sensor(SampledLaw):
    """Sampled measurement with lag, bias, noise and quantisation.

    .. math::
        \\tau \\dot x + x = u, \\qquad
        y_k = \\Delta \\, \\mathrm{round}\\left(\\frac{x(t_k) + b + \\sigma n_k}{\\Delta}\\right)

    sampled at T and held; n are independent standard normal numbers. The lag is exact for an input
    that is linear between samples, and settled at the first sample. With all parameters at 0 the
    output is the sampled input. The same seed gives the same noise; use different seeds for
    independent sensors.

    Parameters
    ----------
    bias : float
        b, added to the measured value, in its unit
    noise : float
        standard deviation sigma of each sample, in the unit of the input
    lag : float
        time constant tau in s; 0 for none
    quantum : float
        step Delta between the values of the output, in its unit; 0 for none
    seed : int
        of the random numbers, 0 or more
    T : float
        sample period in s; a new one acts at the next reset

    Inputs
    ------
    u
        quantity to measure

    Outputs
    -------
    y
        measured value, in the unit of u

    Raises
    ------
    ParameterError
        for a negative noise, lag or quantum, a seed that is not a whole number, and values that
        are not finite
    """

    bias: float = parameter(0.0, number)
    noise: float = parameter(0.0, number, low=0.0)
    lag: float = parameter(0.0, number, low=0.0)
    quantum: float = parameter(0.0, number, low=0.0)
    seed: int = parameter(0, integer, low=0)
    T: float = parameter(1 / 120, positive)

    measured = ("u",)
    input_port_labels = {"u": 0}
    output_port_labels = {"y": 0}

    def build(self) -> None:
        c = self._checked
        self._bias, self._sigma, self._quantum = c.bias, c.noise, c.quantum
        self._noise = WhiteNoise(c.seed, 1)
        # x[k+1] = a x[k] + b u[k] + c u[k+1]
        self._a, self._b, self._c = 0.0, 0.0, 1.0
        if c.lag:
            periods = self.clock.period / c.lag
            mean = -math.expm1(-periods) / periods
            self._a = math.exp(-periods)
            self._b, self._c = mean - self._a, 1 - mean

    def initial_state(self) -> tuple[Any, ...]:
        return (0,)

    def law(self, u: list[float], state: tuple[Any, ...]) -> tuple[list[float], tuple[Any, ...]]:
        value = u[0]
        k, x, last = state if len(state) > 1 else (0, value, value)
        x = self._a * x + self._b * last + self._c * value if k else value
        y = x + self._bias
        if self._sigma:
            y += self._sigma * self._noise.row(k)[0]
        if self._quantum and math.isfinite(steps := y / self._quantum):
            y = self._quantum * round(steps)
        return [y], (k + 1, x, value)
