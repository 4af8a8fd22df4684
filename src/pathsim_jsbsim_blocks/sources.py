"""Test inputs with events at their edges: doublet, multistep (3-2-1-1) and ramp.

Each edge is an event, as in PathSim's own StepSource: an adaptive solver lands on it and a fixed
step sees it at the step's end, so no part of an input is lost between two steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from pathsim.events import ScheduleList

from ._core.checks import number, positive
from ._core.ports import NamedPorts
from .errors import ParameterError


class _EdgeSource(NamedPorts):
    """Source whose output changes at scheduled times, its edges."""

    input_port_labels: dict[str, int] = {}
    output_port_labels = {"out": 0}

    def __init__(self) -> None:
        super().__init__()
        self.edges = ScheduleList(self._edges_apart(), func_act=self._at_edge)
        self.events = [self.edges]

    def __len__(self) -> int:
        return 0

    def reset(self) -> None:
        super().reset()
        self.edges.times_evt = self._edges_apart()

    @property
    def passed(self) -> int:
        """Number of edges passed."""
        return len(self.edges)

    def _put(self, values: dict[str, Any]) -> None:
        super()._put(values)
        self._edges_apart()

    def _edge_times(self) -> list[float]:
        raise NotImplementedError

    def _at_edge(self, t: float) -> None:
        # parameters may have been edited since the last edge
        self.edges.times_evt = self._edges_apart()

    def _edges_apart(self) -> list[float]:
        times = self._edge_times()
        for time, after in pairwise(times):
            if not time < after < math.inf:
                raise ParameterError(
                    f"the edges of {type(self).__name__} at {time:.9g} s and {after:.9g} s cannot "
                    "be told apart",
                    parameter="start",
                    value=times,
                )
        return times


class _StepsSource(_EdgeSource):
    """Source of constant levels between its edges."""

    def _pulses(self) -> list[tuple[float, float]]:
        """(duration in s, level) of each pulse from ``start`` on."""
        raise NotImplementedError

    def _edge_times(self) -> list[float]:
        start = number("start", getattr(self, "start", None), low=0.0)
        durations = [duration for duration, _ in self._pulses()]
        return [start + sum(durations[:i]) for i in range(len(durations) + 1)]

    def _at_edge(self, t: float) -> None:
        super()._at_edge(t)
        levels = [level for _, level in self._pulses()]
        self.outputs[0] = [*levels, 0.0][self.passed - 1]


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

    def __init__(
        self,
        amplitude: float = 0.1,
        start: float = 1.0,
        width: float = 1.0,
        gap: float = 0.0,
        polarity: float = 1,
    ) -> None:
        self.amplitude = amplitude
        self.start = start
        self.width = width
        self.gap = gap
        self.polarity = polarity
        super().__init__()

    def _pulses(self) -> list[tuple[float, float]]:
        level = _sign(self.polarity) * number("amplitude", self.amplitude)
        width, gap = positive("width", self.width), number("gap", self.gap, low=0.0)
        return [(width, level), *([(gap, 0.0)] if gap else []), (width, -level)]


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

    def __init__(
        self,
        amplitude: float = 0.1,
        start: float = 1.0,
        step: float = 1.0,
        widths: Sequence[float] = (3, 2, 1, 1),
        signs: Sequence[float] = (1, -1, 1, -1),
    ) -> None:
        self.amplitude = amplitude
        self.start = start
        self.step = step
        self.widths = widths
        self.signs = signs
        super().__init__()

    def _pulses(self) -> list[tuple[float, float]]:
        widths = [positive(f"widths[{i}]", w) for i, w in enumerate(_list("widths", self.widths))]
        signs = [number(f"signs[{i}]", s) for i, s in enumerate(_list("signs", self.signs))]
        if len(widths) != len(signs) or not widths:
            raise ParameterError(
                f"widths and signs must have the same length, at least 1, not {len(widths)} and "
                f"{len(signs)}",
                parameter="signs",
                value=self.signs,
            )
        step, amplitude = positive("step", self.step), number("amplitude", self.amplitude)
        return [(step * width, amplitude * sign) for width, sign in zip(widths, signs, strict=True)]


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

    def __init__(
        self,
        final: float = 1.0,
        start: float = 1.0,
        rise_time: float = 1.0,
        hold: float = 0.0,
    ) -> None:
        self.final = final
        self.start = start
        self.rise_time = rise_time
        self.hold = hold
        super().__init__()

    def _edge_times(self) -> list[float]:
        number("final", self.final)
        start = number("start", self.start, low=0.0)
        top = start + positive("rise_time", self.rise_time)
        hold = number("hold", self.hold, low=0.0)
        return [start, top, top + hold] if hold else [start, top]

    def update(self, t: float) -> None:
        if self.passed == 1:
            y = self.final * min((t - self.start) / self.rise_time, 1.0)
        else:
            y = self.final if self.passed == 2 else 0.0
        self.outputs[0] = y


def _sign(polarity: Any) -> Any:
    if polarity not in (1, -1):
        raise ParameterError(
            f"polarity must be 1 or -1, not {polarity!r}", parameter="polarity", value=polarity
        )
    return polarity


def _list(name: str, value: Any) -> list:
    if isinstance(value, (list, tuple)) or (isinstance(value, np.ndarray) and value.ndim):
        return list(value)
    raise ParameterError(
        f"{name} must be a list of numbers, not {value!r}", parameter=name, value=value
    )
