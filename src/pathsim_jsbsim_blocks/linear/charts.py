"""Figures of linear models: poles, step responses, Bode diagrams of loops.

Each returns a matplotlib Figure; `plots.show` displays it.
"""

from __future__ import annotations

import math
import reprlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import MultipleLocator

from .._core.checks import number, positive, refuse
from ..plots import axis_label, readable, subplots
from .model import LinearModel
from .modes import Mode
from .stability import Margins

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def pole_map(*models: LinearModel, title: str = "") -> Figure:
    """Poles of linear models, one colour each, with lines of constant damping ratio.

    Two panels: all poles, and those of the slow modes near the origin. The modes of the first
    model are named.

    Parameters
    ----------
    *models : LinearModel
        of one aircraft over a sweep, or of several aircraft
    title : str
        headline

    Raises
    ------
    ParameterError
        for an object that is not a LinearModel
    """
    modes = [_checked(model).modes() for model in models]
    figure, axes = _pole_axes(np.array([mode.pole for group in modes for mode in group]), title)
    for ax, size in axes:
        for i, group in enumerate(modes):
            points = np.array([mode.pole for mode in group])
            ax.plot(points.real, points.imag, "x", color=f"C{i % 10}", clip_on=True)
        _name_modes(ax, modes[0] if modes else [], size)
    return figure


def _checked(model: LinearModel) -> LinearModel:
    if not isinstance(model, LinearModel):
        why = f"model must be a LinearModel (plane.linear_model()), not {reprlib.repr(model)}"
        refuse("model", model, why)
    return model


def _pole_axes(poles: np.ndarray, title: str) -> tuple[Figure, list[tuple[Axes, float]]]:
    """Panels of all poles and of the slow ones, with damping lines, and their sizes in 1/s."""
    figure, axes = subplots(1, 2, figsize=(11, 5), layout="constrained", title=title)
    sizes = np.abs(poles)
    fast = max(float(sizes.max(initial=0.0)), 1e-3)
    slow = float(sizes[sizes < 0.1 * fast].max(initial=0.0)) or 0.1 * fast
    for ax, size in zip(axes, (fast, slow), strict=True):
        for ratio in (0.1, 0.2, 0.4, 0.6, 0.8):
            end = 1.6 * size * np.array([-ratio, math.sqrt(1 - ratio**2)])
            ax.plot([0, end[0]], [0, end[1]], ":", color="0.6", linewidth=0.9)
            ax.annotate(f"{ratio:g}", 0.66 * end, color="0.4", fontsize="x-small", ha="center")
        ax.axvline(0.0, color="0.3", linewidth=0.8)
        ax.set(xlim=(-1.1 * size, 0.4 * size), ylim=(-0.05 * size, 1.1 * size))
        ax.set(xlabel="real part [1/s]", ylabel="imaginary part [rad/s]")
        ax.grid(alpha=0.4)
    axes[0].set_title("all modes")
    axes[1].set_title("slow modes")
    return figure, list(zip(axes, (fast, slow), strict=True))


def _name_modes(ax: Axes, modes: Sequence[Mode], size: float) -> None:
    """Label the modes in a panel of this size."""
    for mode in modes:
        if 0.1 * size < abs(mode.pole) <= size:
            place = mode.pole.real, mode.pole.imag
            style: Any = {"xytext": (5, 5), "textcoords": "offset points", "fontsize": "small"}
            ax.annotate(mode.name, place, **style)


def step_response(
    model: LinearModel,
    plane: Any,
    input: str,
    output: str,
    amplitude: float,
    duration: float = 10.0,
    title: str = "",
) -> Figure:
    """Step response of a linear model and of its aircraft.

    A separate aircraft is flown, so ``plane`` is unchanged.

    Parameters
    ----------
    model : LinearModel
        of ``plane``
    plane : Aircraft or JSBSimFDM
        the block
    input, output : str
        names of ports of both
    amplitude : float
        height of the step, in the input's unit
    duration : float
        s
    title : str
        headline

    Raises
    ------
    ParameterError
        for an object that is not a LinearModel; for an unknown name, naming the nearest; for an
        invalid duration or amplitude
    FlightError
        if the aircraft cannot continue to fly
    """
    part = _checked(model).select([input], [output])
    n = max(round(positive("duration", duration) / part.dt), 1)
    u = np.full((n, 1), number("amplitude", amplitude))
    linear = part.simulate(part.u0 + u)[:, 0]
    nonlinear = plane.response(input, u[:, 0], output)
    time = part.dt * np.arange(n + 1)
    figure, ax = subplots(figsize=(8, 4.5), layout="constrained")
    ax.plot(time, nonlinear, label="aircraft")
    ax.plot(time, linear, "--", label="linear model")
    ax.set_xlabel("time [s]")
    ax.set_ylabel(axis_label(output, part.units[output]))
    readable(ax, np.concatenate([linear, nonlinear]))
    ax.grid(alpha=0.4)
    ax.legend()
    step = f"step of {amplitude:g} {part.units[input]}"
    figure.suptitle(title or f"{model.aircraft}: {input} to {output}, {step}")
    return figure


def bode(loop: Margins, title: str = "") -> Figure:
    """Bode diagram of a loop with its margins: gain in dB and phase in deg over rad/s.

    Parameters
    ----------
    loop : Margins
        of `margins`
    title : str
        headline; default is the name of the loop

    Raises
    ------
    ParameterError
        for an object that is not a loop of `margins`
    """
    if not isinstance(loop, Margins):
        why = f"loop must be a result of margins(), not {reprlib.repr(loop)}"
        if isinstance(loop, LinearModel):
            why += "; control.bode_plot(model.to_control()) draws a linear model"
        refuse("loop", loop, why)
    figure, (gain, phase) = subplots(2, 1, sharex=True, figsize=(8, 6), layout="constrained")
    angle = _mark_margins(loop, gain, phase)
    gain.semilogx(loop.omega, 20 * np.log10(np.abs(loop.response)))
    phase.semilogx(loop.omega, angle)
    gain.set_ylabel("gain [dB]")
    phase.set(ylabel="phase [deg]", xlabel="frequency [rad/s]")
    phase.yaxis.set_major_locator(MultipleLocator(90.0 if np.ptp(angle) > 270.0 else 45.0))
    for ax in (gain, phase):
        ax.grid(alpha=0.4, which="both")
    figure.suptitle(title or loop.loop)
    return figure


def _mark_margins(loop: Margins, gain: Axes, phase: Axes) -> np.ndarray:
    """Mark a loop's margins; return its phase in deg, shifted to put the margin above -180."""
    angle = np.degrees(np.unwrap(np.angle(loop.response)))
    if math.isfinite(loop.phase_margin):
        at = float(np.interp(loop.crossover, loop.omega, angle))
        angle += round((loop.phase_margin - 180.0 - at) / 360.0) * 360.0
    for ax, level, x, margin, text, side in (
        (gain, 0.0, loop.phase_crossover, loop.gain_margin, "gain margin {:.1f} dB", -1.0),
        (phase, -180.0, loop.crossover, loop.phase_margin, "phase margin {:.1f} deg", 1.0),
    ):
        ax.axhline(level, color="0.3", linewidth=0.8)
        if math.isfinite(margin):
            ax.plot([x, x], [level, level + side * margin], "o-", color="C1", markersize=4)
            ax.set_title(f"{text.format(margin)} at {x:.3g} rad/s", fontsize="small", loc="right")
    return angle
