"""Figures of flights: time histories from scopes, ground tracks, phase portraits.

Every function returns a matplotlib Figure without showing it; `show` opens a window if there is a
display, draws into the notebook in Jupyter, and otherwise writes a file.
"""

from __future__ import annotations

import contextlib
import itertools
import math
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ._core.checks import did_you_mean, mapping, nearest, one_of, refuse
from ._core.files import replacing, writable
from ._core.scopes import name_and_unit, recording, signal_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike
    from pathsim.blocks import Scope

__all__ = [
    "ground_track",
    "phase_portrait",
    "saving_to",
    "settling",
    "show",
    "signal",
    "subplots",
    "time_histories",
]

_save_to: list[Iterator[Path]] = []

_DASHES = ("-", "--", "-.", ":")

# quantity by unit, for signals whose labels have no word in common
_QUANTITIES = {
    "deg": "angle",
    "deg/s": "angular rate",
    "ft": "distance",
    "ft/s": "velocity",
    "kt": "airspeed",
    "g": "load factor",
    "lbf": "force",
    "-": "value",
}


class _Exact(Figure):
    """A figure that draws its curves exactly, and wraps a headline that is too wide.

    PathSim sets matplotlib's ``path.simplify_threshold`` to 1 when it is imported, which moves the
    corners of a curve by pixels.
    """

    def suptitle(self, t: str, **options: Any) -> Any:
        return super().suptitle(t, **{"wrap": True, **options})

    def draw(self, renderer: Any) -> None:
        with matplotlib.rc_context({"path.simplify_threshold": 1 / 9}):  # matplotlib's own
            for line in self.findobj(Line2D):
                line.recache(always=True)  # a cached path keeps the threshold of its creation
            super().draw(renderer)


def subplots(*args: Any, title: str = "", **options: Any) -> tuple[Figure, Any]:
    """``plt.subplots`` with the labels of the y axes aligned, and each figure drawn only once.

    A notebook cell draws each figure that pyplot holds, and again a figure in its last line, so
    in a notebook the figure is removed from pyplot.

    Parameters
    ----------
    *args, **options
        as in ``plt.subplots``
    title : str
        headline of the figure

    Returns
    -------
    figure : matplotlib.figure.Figure
    axes : matplotlib.axes.Axes or array of them
    """
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(*args, FigureClass=_Exact, **options)
    figure.align_ylabels()
    if title:
        figure.suptitle(title)
    if _inline():
        plt.close(figure)
    return figure, axes


def _inline() -> bool:
    """Whether figures are drawn into a notebook."""
    import matplotlib.pyplot as plt

    return plt.get_backend().lower().removeprefix("module://") in (
        "inline",
        "matplotlib_inline.backend_inline",
    )


def time_histories(
    *scopes: Scope,
    title: str = "",
    references: Mapping[str, float | Callable[[np.ndarray], ArrayLike]] | None = None,
) -> Figure:
    """Time histories of scopes, one panel for each unit.

    Parameters
    ----------
    *scopes : pathsim.blocks.Scope
        with recorded data and labels of the form ``"pitch angle [deg]"``; consecutive signals of
        one scope with the same unit share a panel. Headings are unwrapped: a turn through north
        continues above 360 deg or below 0
    title : str
        headline of the figure
    references : dict, optional
        reference values by the label of a signal, with or without its unit, in the same unit: a
        number, or a function of the times (array) in s. Drawn dotted, in the signal's panel

    Raises
    ------
    ParameterError
        for no scope, a scope without recording, a reference for a signal that no scope has, naming
        the nearest, and a reference that is not a number for each time
    """
    if not scopes:
        refuse("scopes", scopes, "time_histories needs at least one scope")
    references = mapping("references", references)
    panels: list[tuple[str, list]] = []
    for scope in scopes:
        time, data = recording(scope)
        for i, y in enumerate(data):
            label, unit = _label(scope, i)
            if i == 0 or panels[-1][0] != unit:
                panels.append((unit, []))
            panels[-1][1].append((time, _unwound(y) if unit == "deg" else y, label))
    names = [label for _, signals in panels for _, _, label in signals]
    reference_curves = {names[_index(names, label)]: y for label, y in references.items()}
    size, n = (8, 1.2 + 1.7 * len(panels)), len(panels)
    figure, axes = subplots(
        n, 1, sharex=True, squeeze=False, layout="constrained", figsize=size, title=title
    )
    for ax, (unit, signals) in zip(axes[:, 0], panels, strict=True):
        # dashes keep coinciding curves apart
        for (time, y, label), dashes in zip(signals, itertools.cycle(_DASHES), strict=False):
            ax.plot(time, y, dashes, label=label, linewidth=1.3)
        readable(ax, np.concatenate([y for _, y, _ in signals]))
        for time, _, label in signals:
            if label in reference_curves:
                values = _reference(label, time, reference_curves.pop(label))
                name = "reference" if len(signals) == 1 else f"{label}: reference"
                ax.plot(time, values, "k:", label=name, linewidth=1.1)
        quantity = textwrap.fill(_quantity([label for *_, label in signals], unit), 20)
        ax.set_ylabel("\n".join(filter(None, (quantity, unit and f"[{unit}]"))))
        curves = ax.lines[1 if len(signals) == 1 else 0 :]  # the label of the axis names the first
        if curves:
            ax.legend(handles=curves, loc="best", fontsize="small")
        ax.grid(alpha=0.4)
    axes[-1, 0].set_xlabel("time [s]")
    return figure


def _quantity(labels: list[str], unit: str) -> str:
    """The words that all labels have before a comma, or else the unit's quantity."""
    words = [label.partition(",")[0].split() for label in labels]
    common = [word for word in words[0] if all(word in label_words for label_words in words)]
    return " ".join(common) or _QUANTITIES.get(unit, "")


def _reference(label: str, time: np.ndarray, reference: Any) -> np.ndarray:
    """A reference at the times of a signal."""
    values = reference(time) if callable(reference) else reference
    try:
        return np.broadcast_to(np.asarray(values, dtype=float), time.shape)
    except (TypeError, ValueError):
        wrong = "must be a number, or a function that returns one for each of the"
        wrong = f"the reference of {label!r} {wrong} {len(time)} times, not {values!r}"
        refuse("references", reference, wrong)


def signal(scope: Scope, label: str) -> tuple[np.ndarray, np.ndarray]:
    """Time and values of one recorded signal, by its label with or without the unit.

    Raises
    ------
    ParameterError
        if the scope has no such label; the message names the nearest
    """
    time, data = recording(scope)
    names = [_label(scope, i)[0] for i in range(len(data))]
    return time, data[_index(names, label)]


def settling(
    time: np.ndarray,
    y: np.ndarray,
    target: float,
    tolerance: float,
    unit: str,
    after: float | None = None,
) -> str:
    """Text with the time from which a recorded signal stays within a tolerance of a value.

    Parameters
    ----------
    time, y : arrays, shape (n,)
        s, and the signal, as `signal` returns them
    target, tolerance : float
        the value and the half width of the band around it, in the unit of the signal
    unit : str
        the signal's unit
    after : float, optional
        s; time from which to count, such as that of a step

    Returns
    -------
    str
        such as ``"within 0.5 deg of 10 deg from 12.6 s on"``, with ``after`` ``"within 10 ft of
        5500 ft 51.4 s after t = 5 s"``, or ``"not within 10 ft of 5500 ft by the end"``
    """
    band = f"within {tolerance:g} {unit} of {target:g} {unit}"
    misses = np.flatnonzero(~(np.abs(y - target) <= tolerance))  # nan is outside
    first = int(misses[-1]) + 1 if misses.size else 0
    if first == len(time):
        return f"not {band} by the end"
    if after is None or time[first] < after:
        return f"{band} from {time[first]:.1f} s on"
    return f"{band} {time[first] - after:.1f} s after t = {after:g} s"


def ground_track(
    time: ArrayLike, latitude: ArrayLike, longitude: ArrayLike, title: str = "ground track"
) -> Figure:
    """Ground track in longitude and latitude, coloured by time, with start and end marked.

    Parameters
    ----------
    time : array, shape (n,)
        s
    latitude, longitude : arrays, shape (n,)
        deg; drawn with equal distances north and east
    title : str
        headline of the figure
    """
    from matplotlib.collections import LineCollection
    from matplotlib.ticker import MaxNLocator

    time, latitude, longitude = map(np.asarray, (time, latitude, longitude))
    points = np.column_stack([longitude, latitude])
    pieces = list(np.stack([points[:-1], points[1:]], axis=1))
    track = LineCollection(pieces, array=time[:-1], linewidths=2.5)
    # a straight track must not become a sliver: its shorter side is at least a third of the longer
    shrink = math.cos(math.radians(latitude[0]))  # of a degree of longitude
    size = max(np.ptp(longitude) * shrink, np.ptp(latitude), 1e-8)
    sides = ((longitude, shrink), (latitude, 1.0))
    half = [0.55 * max(np.ptp(values), size / 3 / scale) for values, scale in sides]
    # in the proportion of the track, plus room for labels and colour bar
    height = 5.3 * min(half[1] / (half[0] * shrink), 1.0)
    figure, ax = subplots(figsize=(6.5, height + 1.8), layout="constrained")
    limits = ax.set_xlim, ax.set_ylim
    for values, extent, limit in zip((longitude, latitude), half, limits, strict=True):
        centre = (values.min() + values.max()) / 2
        limit(centre - extent, centre + extent)
    ax.set(aspect=1 / shrink, title=title, xlabel="longitude [deg]", ylabel="latitude [deg]")
    ax.add_collection(track)
    ax.plot(*points[0], "ko", label="start")
    ax.plot(*points[-1], "rs", label="end")
    ax.ticklabel_format(useOffset=False, style="plain")
    ax.xaxis.set_major_locator(MaxNLocator(5))
    ax.grid(alpha=0.4)
    ax.legend(loc="best")
    figure.colorbar(track, label="time [s]", location="bottom", shrink=0.6)
    return figure


def phase_portrait(x: ArrayLike, y: ArrayLike, labels: tuple[str, str], title: str = "") -> Figure:
    """One signal against another, with the start marked.

    Parameters
    ----------
    x, y : arrays, shape (n,)
    labels : (str, str)
        axis labels with units
    title : str
        headline of the figure
    """
    figure, ax = subplots(figsize=(6, 5), layout="constrained")
    ax.plot(x, y, linewidth=1.3)
    ax.plot(np.asarray(x)[0], np.asarray(y)[0], "ko", label="start")
    ax.set(xlabel=labels[0], ylabel=labels[1], title=title)
    ax.grid(alpha=0.4)
    ax.legend(loc="best")
    return figure


def show(figure: Figure, name: str) -> None:
    """Show a figure in a window or in a notebook; otherwise write ``name.png`` here.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    name : str
        name of the file without its extension
    """
    import matplotlib.pyplot as plt
    from matplotlib.backends import backend_registry
    from matplotlib.backends.registry import BackendFilter

    interactive = plt.get_backend().lower() in {
        b.lower() for b in backend_registry.list_builtin(BackendFilter.INTERACTIVE)
    }
    if interactive and not _save_to:
        plt.show()
        return
    if _inline() and not _save_to:
        from IPython.display import display

        display(figure)
        plt.close(figure)
        return
    target = next(_save_to[-1]) if _save_to else Path(f"{name}.png")
    try:
        with replacing(target) as file:
            figure.savefig(file, dpi=100)
    finally:
        plt.close(figure)
    print(f"figure saved: {target}")


@contextlib.contextmanager
def saving_to(path: str | Path) -> Iterator[None]:
    """Within this context `show` writes to ``path``, with or without a display.

    A path without an extension gets ``.png``; the second figure goes to ``NAME_2.png``, and so on.

    Raises
    ------
    ParameterError
        on entry, if figures cannot be written there; on exit, if none was shown
    """
    from matplotlib.backend_bases import FigureCanvasBase

    path = writable("save", path)
    path = path if path.suffix else path.with_suffix(".png")
    formats = FigureCanvasBase.get_supported_filetypes()
    one_of("the ending of save", path.suffix[1:].lower(), formats)
    more = (path.with_stem(f"{path.stem}_{n}") for n in itertools.count(2))
    targets = itertools.chain([path], more)
    _save_to.append(targets)
    try:
        yield
    finally:
        _save_to.pop()
    if next(targets) == path:
        advice = '; plots.show(plots.time_histories(scope), "flight") shows one'
        refuse(
            "save", str(path), f"no figure was shown that could be saved as {str(path)!r}{advice}"
        )


def _label(scope: Scope, i: int) -> tuple[str, str]:
    """Name and unit of a scope's signal."""
    return name_and_unit(signal_label(scope, i))


def _index(names: list[str], label: str) -> int:
    """Number of a scope's signal, by its label with or without the unit."""
    name = label if label in names else re.sub(r"\s*\[.*\]$", "", label)
    if name not in names:
        hint = did_you_mean(nearest(label, names))
        refuse("label", label, f"the scope has no signal {label!r}" + hint)
    return names.index(name)


def axis_label(name: str, unit: str) -> str:
    """``"name [unit]"``; the name alone without a unit."""
    return f"{name} [{unit}]" if unit else name


def _unwound(y: np.ndarray) -> np.ndarray:
    """An angle in deg without jumps at 360 deg."""
    y = np.array(y, dtype=float)
    finite = np.isfinite(y)
    y[finite] = np.unwrap(y[finite], period=360.0)
    return y


def readable(ax: Axes, y: np.ndarray) -> None:
    """Plain tick labels, and no zoom into rounding noise."""
    ax.ticklabel_format(useOffset=False, style="plain")
    extent, size = float(np.ptp(y)), float(np.max(np.abs(y)))
    if extent < 1e-4 * size:
        centre = float(np.mean([y.min(), y.max()]))
        ax.set_ylim(centre - 5e-5 * size, centre + 5e-5 * size)
