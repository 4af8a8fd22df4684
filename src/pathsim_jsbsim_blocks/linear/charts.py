"""Figures of linear models: poles, steps beside the aircraft, root loci, Bode diagrams.

Each returns a matplotlib Figure; `plots.show` shows it.
"""

from __future__ import annotations

import math
import reprlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.checks import finite, number, positive, refuse
from ..plots import axis_label, readable, subplots
from .model import LinearModel
from .modes import Mode

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike


def pole_map(*models: LinearModel, title: str = "") -> Figure:
    """Poles of linear models, one colour each, with lines of constant damping ratio.

    Two panels: all poles, and those near the origin, where the slow modes are. The modes of the
    first model are named.

    Parameters
    ----------
    *models : LinearModel
        of one aircraft over a sweep, or of several
    title : str
        headline

    Raises
    ------
    ParameterError
        for what is not a linear model
    """
    found = [_checked(model).modes() for model in models]
    figure, axes = _pole_axes(np.array([mode.pole for modes in found for mode in modes]), title)
    for ax, size in axes:
        for i, modes in enumerate(found):
            points = np.array([mode.pole for mode in modes])
            ax.plot(points.real, points.imag, "x", color=f"C{i % 10}", clip_on=True)
        _name_modes(ax, found[0] if found else [], size)
    return figure


def _checked(model: LinearModel) -> LinearModel:
    if not isinstance(model, LinearModel):
        why = f"a LinearModel is needed, such as plane.linear_model(), not {reprlib.repr(model)}"
        refuse("model", model, why)
    return model


def _pole_axes(poles: np.ndarray, title: str) -> tuple[Figure, list[tuple[Axes, float]]]:
    """Panels of all poles and of the slow ones, with lines of damping, and their sizes in 1/s."""
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
    axes[1].set_title("the slow ones")
    return figure, list(zip(axes, (fast, slow), strict=True))


def _name_modes(ax: Axes, modes: Sequence[Mode], size: float) -> None:
    """The names of the modes in a panel of this size."""
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
    """Step response of a linear model and of the aircraft that it stands for.

    Another aircraft is flown: ``plane`` is not touched.

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
        for what is not a linear model; for a name that it does not have, naming the nearest; for a
        duration or an amplitude that cannot be
    FlightError
        if the aircraft cannot be flown on
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
    unit = part.units[input].replace("norm", "of full travel")
    figure.suptitle(title or f"{model.aircraft}: step of {amplitude:g} {unit} on {input}")
    return figure


def root_locus(
    models: Sequence[LinearModel], values: ArrayLike, label: str = "", title: str = ""
) -> Figure:
    """Poles of linear models over a trim sweep, coloured by what was swept.

    Parameters
    ----------
    models : list of LinearModel
        one for each point of the sweep
    values : array, shape (n,)
        what was swept, such as the airspeeds
    label : str
        its name and unit, such as ``"airspeed [kt]"``
    title : str
        headline

    Raises
    ------
    ParameterError
        without models, for what is not a linear model, or for another number of values
    """
    swept = np.asarray(finite(values=values)[0])
    if not len(models) or swept.shape != (len(models),):
        wanted = f"one number for each of the {len(models)} models (at least one)"
        refuse("values", values, f"values must have {wanted}, not the shape {swept.shape}")
    found = [_checked(model).modes() for model in models]
    points = [(m.pole, value) for modes, value in zip(found, swept, strict=True) for m in modes]
    poles, colours = np.array([pole for pole, _ in points]), [value for _, value in points]
    figure, axes = _pole_axes(poles, title)
    for ax, size in axes:
        drawn = ax.scatter(poles.real, poles.imag, c=colours, s=18, cmap="viridis")
        _name_modes(ax, found[0], size)
    figure.colorbar(drawn, ax=[ax for ax, _ in axes], label=label)
    return figure


def bode(model: LinearModel, output: str, input: str, title: str = "") -> Figure:
    """Gain and phase from one input of a linear model to one output, its latency included.

    Parameters
    ----------
    model : LinearModel
    output, input : str
        names
    title : str
        headline; default is what it shows

    Raises
    ------
    ParameterError
        for what is not a linear model; for a name that it does not have, naming the nearest
    """
    part = _checked(model).select([input], [output])
    rates = [mode.frequency for mode in part.modes() if mode.frequency > 1e-4]
    omega = np.geomspace(0.1 * min(rates, default=1e-2), 10 * max(rates, default=1e2), 600)
    response = part.frequency_response(omega)[:, 0, 0]
    figure, (gain, phase) = subplots(2, 1, sharex=True, figsize=(8, 6), layout="constrained")
    gain.loglog(omega, np.abs(response))
    unit = "/".join(filter(None, (part.units[output], part.units[input].replace("norm", "1"))))
    gain.set_ylabel(f"gain [{unit}]")
    phase.semilogx(omega, np.degrees(np.unwrap(np.angle(response))))
    phase.set(ylabel="phase [deg]", xlabel="frequency [rad/s]")
    for ax in (gain, phase):
        ax.grid(alpha=0.4, which="both")
    figure.suptitle(title or f"{model.aircraft}: {output} to {input}")
    return figure
