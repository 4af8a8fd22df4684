"""Test inputs with events at their edges: doublet, multistep (3-2-1-1) and ramp.

Each edge is an event, as in PathSim's own StepSource: an adaptive solver lands on it and a fixed
step sees it at the step's end, so no part of an input is lost between two steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from pathsim.events import ScheduleList

from ._core.checks import must_be, number, numbers, positive, refuse
from ._core.parameters import Parametric, parameter


def polarity_of(name: str, value: Any) -> float:
    """1 or -1."""
    if number(name, value) not in (1.0, -1.0):
        must_be(name, value, "1 or -1")
    return float(value)


class _EdgeSource(Parametric):
    """Source whose output changes at scheduled times, its edges."""

    input_port_labels = {}
    output_port_labels = {"out": 0}

    def __len__(self) -> int:
        return 0

    def _begin(self) -> None:
        super()._begin()
        self.edges = ScheduleList([], func_act=self._at_edge)
        self.events = [self.edges]

    def build(self) -> None:
        self._times = self._edge_times()
        for time, end in pairwise(self._times):
            if not time < end < math.inf:
                edges = f"the edges of {type(self).__name__} at {time:.9g} s and {end:.9g} s"
                refuse("start", self._times, f"{edges} are too close to be distinguished")
        if not self.passed:
            self.edges.times_evt = self._times

    def reset(self) -> None:
        super().reset()
        self.edges.times_evt = self._times

    @property
    def passed(self) -> int:
        """Number of edges passed."""
        return len(self.edges)

    def _edge_times(self) -> list[float]:
        raise NotImplementedError

    def _at_edge(self, t: float) -> None:
        # parameters may have been edited since the last edge
        self.edges.times_evt = self._times


class _StepsSource(_EdgeSource):
    """Source of constant levels between its edges."""

    def _pulses(self) -> list[tuple[float, float]]:
        """(duration in s, level) of each pulse from ``start`` on."""
        raise NotImplementedError

    def _edge_times(self) -> list[float]:
        durations, levels = zip(*self._pulses(), strict=True)
        self._levels = [*levels, 0.0]
        return [self._checked.start + sum(durations[:i]) for i in range(len(durations) + 1)]

    def _at_edge(self, t: float) -> None:
        super()._at_edge(t)
        self.outputs[0] = self._levels[self.passed - 1]


@dataclass(eq=False, repr=False)
class DoubletSource(_StepsSource):
    """Doublet: two pulses of opposite sign, with an optional gap between them.

    Parameters
    ----------
    amplitude : float
        height of the pulses
    start : float
        time of the first edge in s
    width : float
        duration of each pulse in s
    gap : float
        time at zero between the pulses in s
    polarity : float
        sign of the first pulse, 1 or -1

    Outputs
    -------
    out
        0, then ``polarity * amplitude``, 0 in the gap, ``-polarity * amplitude``, 0
    """

    amplitude: float = parameter(0.1, number)
    start: float = parameter(1.0, number, low=0.0)
    width: float = parameter(1.0, positive)
    gap: float = parameter(0.0, number, low=0.0)
    polarity: float = parameter(1, polarity_of)

    def _pulses(self) -> list[tuple[float, float]]:
        c = self._checked
        level = c.polarity * c.amplitude
        return [(c.width, level), *([(c.gap, 0.0)] if c.gap else []), (c.width, -level)]


@dataclass(eq=False, repr=False)
class MultistepSource(_StepsSource):
    """Multistep: pulses of given widths and signs; a 3-2-1-1 by default.

    The 3-2-1-1 spreads its energy over a wider band than a doublet, as identification of flight
    dynamics requires (Jategaonkar, *Flight Vehicle System Identification*, AIAA, 2006).

    Parameters
    ----------
    amplitude : float
        height of the pulses
    start : float
        time of the first edge in s
    step : float
        duration of a pulse of width 1 in s
    widths : list of float
        width of each pulse in units of ``step``
    signs : list of float
        factor on the amplitude for each pulse, usually 1, -1 or 0

    Outputs
    -------
    out
        0, then each pulse in turn, then 0
    """

    amplitude: float = parameter(0.1, number)
    start: float = parameter(1.0, number, low=0.0)
    step: float = parameter(1.0, positive)
    widths: Sequence[float] = parameter((3, 2, 1, 1), numbers, above=0.0)
    signs: Sequence[float] = parameter((1, -1, 1, -1), numbers)

    def _pulses(self) -> list[tuple[float, float]]:
        c = self._checked
        if len(c.widths) != len(c.signs) or not c.widths:
            lengths = f"{len(c.widths)} and {len(c.signs)}"
            why = f"widths and signs must have the same length, at least 1, not {lengths}"
            refuse("signs", self.signs, why)
        pulses = zip(c.widths, c.signs, strict=True)
        return [(c.step * width, c.amplitude * sign) for width, sign in pulses]


@dataclass(eq=False, repr=False)
class RampSource(_EdgeSource):
    """Ramp from 0 to a final value, held for a time or indefinitely.

    .. math::
        y(t) = y_\\mathrm{final} \\, \\frac{t - t_\\mathrm{start}}{t_\\mathrm{rise}}

    Parameters
    ----------
    final : float
        value at the end of the ramp
    start : float
        time at which the ramp begins in s
    rise_time : float
        duration of the ramp in s
    hold : float
        time for which the final value is held in s, then the output drops to 0; 0 holds it
        indefinitely

    Outputs
    -------
    out
        0, the ramp, the final value, and 0 again after ``hold``
    """

    final: float = parameter(1.0, number)
    start: float = parameter(1.0, number, low=0.0)
    rise_time: float = parameter(1.0, positive)
    hold: float = parameter(0.0, number, low=0.0)

    def _edge_times(self) -> list[float]:
        c = self._checked
        top = c.start + c.rise_time
        return [c.start, top, top + c.hold] if c.hold else [c.start, top]

    def update(self, t: float) -> None:
        if self.passed == 1:
            y = self.final * min((t - self.start) / self.rise_time, 1.0)
        else:
            y = self.final if self.passed == 2 else 0.0
        self.outputs[0] = y
