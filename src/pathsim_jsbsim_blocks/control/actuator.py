"""`Actuator`: second-order dynamics with limits of rate and position."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from .._core.checks import check_range, number, positive, refuse
from .._core.parameters import parameter
from .._core.sampling import SampledLaw
from .pid import clip


class ActuatorState(NamedTuple):
    """State of an `Actuator`; ``has_value`` is False before the first sample."""

    has_value: bool = False
    y: float = 0.0
    rate: float = 0.0


@dataclass(eq=False, repr=False)
class Actuator(SampledLaw):
    """Second-order actuator with limits of rate and position.

    .. math::
        \\ddot y = \\omega^2 (u - y) - 2 \\zeta \\omega \\dot y, \\qquad
        |\\dot y| \\le \\dot y_\\mathrm{max}, \\quad y_\\mathrm{low} \\le y \\le y_\\mathrm{high}

    The command is held over each period T, and the motion within it is exact while no limit is
    active. The limits apply at the samples, so reaching or leaving one is late by less than T. If a
    limit is moved past the position, the actuator moves back to it as to a command. The output at
    t_k follows from the commands before t_k.

    Parameters
    ----------
    frequency : float
        natural frequency omega, rad/s
    damping : float
        damping ratio zeta
    max_rate : float
        maximum rate, in the unit of the command per s; default: no limit
    low : float
        minimum position
    high : float
        maximum position
    initial : float
        position at the start, at rest
    T : float
        sample period in s; a new one acts at the next reset

    Inputs
    ------
    u
        commanded position

    Outputs
    -------
    y
        position, in the unit of u
    rate
        its rate, per s
    sat
        command less the command within the limits of position: feedback against wind-up, as for
        the ``sat`` of a ``DiscretePID``

    Raises
    ------
    ParameterError
        for a frequency or rate that is not positive, a negative damping, and inconsistent limits or
        initial position
    """

    frequency: float = parameter(30.0, positive)
    damping: float = parameter(0.7, number, low=0.0)
    max_rate: float = parameter(math.inf, number, above=0.0, infinite=True)
    low: float = -1.0
    high: float = 1.0
    initial: float = 0.0
    T: float = parameter(1 / 120, positive)

    measured = ("u",)
    input_port_labels = {"u": 0}
    output_port_labels = {"y": 0, "rate": 1, "sat": 2}

    def build(self) -> None:
        omega, zeta = self._checked.frequency, self._checked.damping
        self._max_rate = self._checked.max_rate
        self._low, self._high = check_range(self.low, self.high)
        self._initial = number("initial", self.initial, low=self._low, high=self._high)
        # states: distance from the command, and rate
        motion = [[0.0, 1.0], [-omega * omega, -2 * zeta * omega]]
        period = self.clock.period
        transition = expm([[period * x for x in row] for row in motion])
        if not np.isfinite(transition).all():
            refuse(
                "frequency",
                self.frequency,
                f"frequency {omega:g} with damping {zeta:g} is too large to compute the motion",
            )
        self._transition = transition.tolist()
        self._farthest = self._max_rate * period

    def initial_state(self) -> ActuatorState:
        return ActuatorState()

    def law(self, u: list[float], state: ActuatorState) -> tuple[list[float], ActuatorState]:
        has_value, y, rate = state
        if not has_value:
            y = self._initial
        command = clip(u[0], self._low, self._high)
        (a, b), (c, d) = self._transition
        distance = y - command
        target = command + a * distance + b * rate
        target = clip(target, y - self._farthest, y + self._farthest)
        new_rate = clip(c * distance + d * rate, -self._max_rate, self._max_rate)
        # a limit moved past the position acts as a command, not as a jump
        position = clip(target, min(self._low, y), max(self._high, y))
        if position != target:
            new_rate = 0.0
        return [y, rate, u[0] - command], ActuatorState(True, position, new_rate)
