"""Quality of a step response: settling, overshoot, rise, steady error."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._core.checks import finite, must_be, number, positive, refuse

# relative to the reference; a smaller step counts as none
_NO_STEP = 1e-9


@dataclass(frozen=True)
class ResponseQuality:
    """Results of `response_quality`.

    Parameters
    ----------
    step : float
        final reference less the value at the start, unit of y
    settling : float
        s from the start until y stays within the tolerance; nan if it is outside at the end
    overshoot : float
        maximum excess over the final reference in the direction of the step, unit of y; 0 without
        overshoot, nan without a step
    rise : float
        s from the first crossing of the lower to that of the upper fraction of the step; nan if y
        does not reach it, and without a step
    steady_error : float
        maximum distance from the final reference at the end, unit of y
    """

    step: float
    settling: float
    overshoot: float
    rise: float
    steady_error: float

    @property
    def overshoot_percent(self) -> float:
        """Overshoot in percent of the step; nan without a step."""
        return 100.0 * self.overshoot / abs(self.step) if self.step else math.nan


def response_quality(
    time: ArrayLike,
    y: ArrayLike,
    reference: ArrayLike,
    *,
    tolerance: float | None = None,
    share: float = 0.02,
    rise: tuple[float, float] = (0.1, 0.9),
    last: float | None = None,
) -> ResponseQuality:
    """Settling time, overshoot, rise time and steady error of a response to a step or a ramp.

    The response starts at the first change of the reference, or with the first sample if it does
    not change, and is compared with the last value of the reference. Times are interpolated between
    samples. Unwrap an angle that passes through 360 deg first (``numpy.unwrap(psi, period=360)``).

    Parameters
    ----------
    time : array_like, shape (n,)
        s, not decreasing, n >= 2
    y : array_like, shape (n,)
        the response, any unit
    reference : float or array_like, shape (n,)
        the value to reach, or the reference at every sample, unit of y
    tolerance : float, optional
        half width of the band in which y has settled, unit of y; default ``share`` of the step
    share : float
        the same as a fraction of the step
    rise : (float, float)
        fractions of the step between which the rise time is measured
    last : float, optional
        length of the final interval for the steady error, s; default the last tenth of the response

    Returns
    -------
    ResponseQuality

    Raises
    ------
    ParameterError
        for arrays of different shapes, values that are not finite, time that decreases or is
        constant, a ``tolerance``, ``share``, ``rise`` or ``last`` out of range, and a response
        without a step and without ``tolerance``

    References
    ----------
    Ogata: *Modern Control Engineering*, 5th ed., 2010, section 5-3. The interpretation is that of
    python-control's ``step_info``, which does not interpolate.

    Examples
    --------
    >>> import numpy as np
    >>> time = np.linspace(0.0, 10.0, 1001)
    >>> quality = response_quality(time, 1 - np.exp(-time), 1.0)
    >>> round(quality.settling, 2), round(quality.rise, 2), quality.overshoot
    (3.91, 2.2, 0.0)
    """
    t, y, reference = _signals(time, y, reference)
    low, high = _shares(rise)
    share = number("share", share, above=0.0, high=1.0)
    if tolerance is not None:
        tolerance = positive("tolerance", tolerance)
    last = None if last is None else positive("last", last)

    goal = float(reference[-1])
    changes = np.flatnonzero(np.diff(reference))
    # the response starts at the first sample with the new reference
    first = int(changes[0]) + 1 if len(changes) else 0
    t, y = t[first:], y[first:]
    if t[-1] == t[0]:
        refuse("reference", goal, "the reference changes at the last sample: no response follows")
    start = float(t[0])
    step = goal - float(y[0])
    if abs(step) <= _NO_STEP * max(1.0, abs(goal)):
        step = 0.0
    if not step and tolerance is None:
        refuse(
            "tolerance",
            None,
            f"y starts at the reference, {goal:g}: without a step, tolerance is required",
        )
    error = y - goal
    end = t >= (t[-1] - last if last is not None else start + 0.9 * (t[-1] - start))
    band = share * abs(step) if tolerance is None else tolerance
    return ResponseQuality(
        step=step,
        settling=_settling(t, np.abs(error), band) - start,
        overshoot=max(float(np.max(error * math.copysign(1.0, step))), 0.0) if step else math.nan,
        rise=_reaches(t, error / step + 1.0, high) - _reaches(t, error / step + 1.0, low)
        if step
        else math.nan,
        steady_error=float(np.max(np.abs(error[end]))),
    )


def _signals(time: Any, y: Any, reference: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    # one by one: their shapes are compared below
    t, y, reference = (
        np.asarray(finite(**{name: x})[0])
        for name, x in (("time", time), ("y", y), ("reference", reference))
    )
    if t.ndim != 1 or len(t) < 2:
        refuse(
            "time", time, f"time must have at least two samples in one row, not the shape {t.shape}"
        )
    for name, x in (("y", y), ("reference", reference)):
        if x.shape != t.shape and not (name == "reference" and x.ndim == 0):
            refuse(name, x, f"{name} must have the shape of time, {t.shape}, not {x.shape}")
    back = np.flatnonzero(np.diff(t) < 0.0)
    if len(back) or t[-1] == t[0]:
        where = f"{t[back[0] + 1]:g} s after {t[back[0]]:g} s" if len(back) else "one instant"
        refuse("time", time, f"time must go forward, not {where}")
    return t, y, np.broadcast_to(reference, t.shape)


def _shares(rise: Any) -> tuple[float, float]:
    if not isinstance(rise, (list, tuple)) or len(rise) != 2:
        must_be("rise", rise, "two fractions of the step, such as (0.1, 0.9)")
    low, high = (number("rise", x, low=0.0, high=1.0) for x in rise)
    if not low < high:
        refuse("rise", rise, f"the first fraction of rise must be below the second, not {rise!r}")
    return low, high


def _settling(t: np.ndarray, error: np.ndarray, band: float) -> float:
    """Time from which the error stays within the band."""
    # with a tolerance for rounding at the band's edge
    outside = np.flatnonzero(error > band * (1.0 + 1e-9))
    if not len(outside):
        return float(t[0])
    k = int(outside[-1])
    if k + 1 == len(t):
        return math.nan
    return _between(t, error, k, band)


def _reaches(t: np.ndarray, share: np.ndarray, level: float) -> float:
    """Time at which the response first reaches a fraction of its step."""
    indices = np.flatnonzero(share >= level)
    if not len(indices):
        return math.nan
    k = int(indices[0])
    return float(t[0]) if k == 0 else _between(t, share, k - 1, level)


def _between(t: np.ndarray, y: np.ndarray, k: int, level: float) -> float:
    """Time at which the line from sample k to the next crosses a level."""
    return float(t[k] + (t[k + 1] - t[k]) * (level - y[k]) / (y[k + 1] - y[k]))
