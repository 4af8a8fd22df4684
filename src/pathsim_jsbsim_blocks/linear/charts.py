"""Figures of linear models: poles, step responses, root loci, Bode and Nyquist diagrams.

Each returns a matplotlib Figure; `plots.show` displays it.
"""

from __future__ import annotations

import math
import reprlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import MultipleLocator

from .._core.checks import finite, number, positive, refuse
from ..plots import axis_label, readable, subplots
from .model import LinearModel
from .modes import Mode
from .stability import Margins

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike


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
            beside: Any = {"xytext": (5, 5), "textcoords": "offset points", "fontsize": "small"}
            ax.annotate(mode.name, place, **beside)


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


def root_locus(
    models: Sequence[LinearModel], values: ArrayLike, label: str = "", title: str = ""
) -> Figure:
    """Poles of linear models over a trim sweep, coloured by the swept quantity.

    Parameters
    ----------
    models : list of LinearModel
        one for each point of the sweep
    values : array, shape (n,)
        swept quantity, such as the airspeed
    label : str
        its name and unit, such as ``"airspeed [kt]"``
    title : str
        headline

    Raises
    ------
    ParameterError
        without models, for an object that is not a LinearModel, or if the number of values differs
    """
    swept = np.asarray(finite(values=values)[0])
    if not len(models) or swept.shape != (len(models),):
        expected = f"one number for each of the {len(models)} models (at least one)"
        refuse("values", values, f"values must have {expected}, not the shape {swept.shape}")
    modes = [_checked(model).modes() for model in models]
    points = [(m.pole, value) for group, value in zip(modes, swept, strict=True) for m in group]
    poles, colours = np.array([pole for pole, _ in points]), [value for _, value in points]
    figure, axes = _pole_axes(poles, title)
    for ax, size in axes:
        drawn = ax.scatter(poles.real, poles.imag, c=colours, s=18, cmap="viridis")
        _name_modes(ax, modes[0], size)
    figure.colorbar(drawn, ax=[ax for ax, _ in axes], label=label)
    return figure


def bode(
    model: LinearModel | Margins,
    output: str | None = None,
    input: str | None = None,
    title: str = "",
) -> Figure:
    """Bode diagram: gain in dB and phase in deg over the frequency in rad/s, sampled as flown.

    The margins of a loop are marked.

    Parameters
    ----------
    model : LinearModel or Margins
        of an aircraft, or a loop of `margins`
    output, input : str, optional
        names, required if the model has several
    title : str
        headline; default names the signals, such as "c172p: elevator to theta"

    Raises
    ------
    ParameterError
        for any other object; for an unknown name, naming the nearest; without a name if there are
        several, naming them
    """
    figure, (gain, phase) = subplots(2, 1, sharex=True, figsize=(8, 6), layout="constrained")
    if isinstance(model, Margins):
        omega, response, unit, label = model.omega, model.response, "dB", model.loop
        angle = _mark_margins(model, gain, phase)
    else:
        part = _one_path(_checked(model), output, input)
        (y,), (u,) = part.outputs, part.inputs
        label = f"{part.aircraft}: {u} to {y}"
        unit = f"dB re {' '.join(filter(None, ('1', part.units[y])))}/{part.units[u]}"
        rates = [mode.frequency for mode in part.modes() if mode.frequency > 1e-4]
        # the response of a sampled system ends at pi / T
        high = min(10 * max(rates, default=10.0), math.pi / part.dt)
        omega = np.geomspace(min([0.1 * high, *(0.1 * rate for rate in rates)]), high, 600)
        response = part.frequency_response(omega)[:, 0, 0]
        angle = np.degrees(np.unwrap(np.angle(response)))
    gain.semilogx(omega, 20 * np.log10(np.abs(response)))
    phase.semilogx(omega, angle)
    gain.set_ylabel(f"gain [{unit}]")
    phase.set(ylabel="phase [deg]", xlabel="frequency [rad/s]")
    phase.yaxis.set_major_locator(MultipleLocator(90.0 if np.ptp(angle) > 270.0 else 45.0))
    for ax in (gain, phase):
        ax.grid(alpha=0.4, which="both")
    figure.suptitle(title or label)
    return figure


def _one_path(model: LinearModel, output: str | None, input: str | None) -> LinearModel:
    """The model from one input to one output."""
    chosen = {}
    for side, name in (("inputs", input), ("outputs", output)):
        names = getattr(model, side)
        if name is None and len(names) != 1:
            refuse(side[:-1], None, f"name one of the model's {side}: {', '.join(names) or 'none'}")
        chosen[side] = [names[0] if name is None else name]
    return model.select(**chosen)


def _mark_margins(loop: Margins, gain: Axes, phase: Axes) -> np.ndarray:
    """Mark a loop's margins; return its phase in deg, shifted to put the margin above -180."""
    angle = np.degrees(np.unwrap(np.angle(loop.response)))
    if math.isfinite(loop.phase_margin):
        at = float(np.interp(loop.crossover, loop.omega, angle))
        angle += round((loop.phase_margin - 180.0 - at) / 360.0) * 360.0
    for ax, level, x, margin, text, away in (
        (gain, 0.0, loop.phase_crossover, loop.gain_margin, "gain margin {:.1f} dB", -1.0),
        (phase, -180.0, loop.crossover, loop.phase_margin, "phase margin {:.1f} deg", 1.0),
    ):
        ax.axhline(level, color="0.3", linewidth=0.8)
        if math.isfinite(margin):
            ax.plot([x, x], [level, level + away * margin], "o-", color="C1", markersize=4)
            ax.set_title(f"{text.format(margin)} at {x:.3g} rad/s", fontsize="small", loc="right")
    return angle


def nyquist(loop: Margins, title: str = "") -> Figure:
    """Nyquist diagram of a loop, with the point -1, the unit circle and the disk of its margin.

    Parameters
    ----------
    loop : Margins
        of `margins`; dashed at negative frequencies
    title : str
        headline; default is the name of the loop

    Raises
    ------
    ParameterError
        for an object that is not a loop of `margins`
    """
    if not isinstance(loop, Margins):
        refuse("loop", loop, f"loop must be a result of margins(), not {reprlib.repr(loop)}")
    figure, ax = subplots(figsize=(7, 6), layout="constrained")
    x, y, alpha = loop.response.real, loop.response.imag, loop.disk_margin
    ax.plot(x, y, label="L")
    ax.plot(x, -y, "--", color="C0")
    around = np.exp(1j * np.linspace(0.0, 2 * np.pi, 200))
    ax.plot(around.real, around.imag, ":", color="0.4", linewidth=0.9)
    if alpha < 2.0:
        low, high = (2 - alpha) / (2 + alpha), (2 + alpha) / (2 - alpha)
        disk = -(low + high) / 2 + (high - low) / 2 * around
        ax.fill(disk.real, disk.imag, color="C1", alpha=0.3, label=f"disk margin {alpha:.2f}")
    ax.plot(-1.0, 0.0, "+", color="C3", markersize=12)
    ax.axhline(0.0, color="0.3", linewidth=0.8)
    ax.axvline(0.0, color="0.3", linewidth=0.8)
    ax.set(xlim=(-3.5, 1.5), ylim=(-2.5, 2.5), aspect="equal", xlabel="real part")
    ax.set_ylabel("imaginary part")
    ax.grid(alpha=0.4)
    ax.legend()
    figure.suptitle(title or loop.loop)
    return figure
