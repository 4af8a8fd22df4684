"""Save the figures and signals of a run."""

from __future__ import annotations

import contextlib
import csv
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from ..errors import FileError, ParameterError


def save(
    figure: Path | None, csv_file: Path | None, scopes: Sequence[Any], until: str = ""
) -> None:
    """Write the open figures and the signals; a failure of one does not prevent the other.

    ``until``, if given, is the title of a further figure of all that was recorded.
    """
    with contextlib.ExitStack() as last:
        if csv_file is not None:
            last.callback(_write_csv, scopes, csv_file)
        if figure is not None:
            _save_open_figures()
            if until:
                from ..plots import show, time_histories

                show(time_histories(*scopes, title=until), "")


def _save_open_figures() -> None:
    """Save the figures that a script left open, as ``sim.plot()`` does."""
    import matplotlib.pyplot as plt

    from ..plots import show

    for n in plt.get_fignums():
        show(plt.figure(n), "")


def csv_path(path: Path) -> Path:
    """``path`` if a table can be written there; without an ending it may be a pipe.

    Raises
    ------
    ParameterError
        for an ending that promises another format, and for a file that cannot be written
    """
    from .._core.checks import ending, writable

    return ending("csv", writable("csv", path), ".csv", "")


def saving_figures(path: Path | None) -> contextlib.AbstractContextManager[None]:
    from ..plots import saving_to

    return contextlib.nullcontext() if path is None else saving_to(path.absolute())


def recording_scopes(objects: Iterable[Any]) -> list[Any]:
    """Scopes with a recording, of all simulations among ``objects``."""
    from pathsim import Simulation, Subsystem
    from pathsim.blocks import Scope

    def scopes(blocks: Iterable[Any]) -> Iterator[Scope]:
        for block in blocks:
            if isinstance(block, Scope):
                yield block
            elif isinstance(block, Subsystem):
                yield from scopes(block.blocks)

    simulations = {id(x): x for x in objects if isinstance(x, Simulation)}
    return [
        scope
        for simulation in simulations.values()
        for scope in scopes(simulation.blocks)
        if scope.read()[0] is not None
    ]


def _write_csv(scopes: Sequence[Any], path: Path) -> None:
    from .._core.files import replacing
    from .._core.scopes import recording, signal_label

    if not scopes:
        raise ParameterError(
            "the script has no simulation that a Scope recorded", parameter="csv", value=str(path)
        )
    columns: list[tuple[str, dict[float, float]]] = []
    for scope in scopes:
        time, data = recording(scope)
        for i, values in enumerate(data):
            column = dict(zip(time.tolist(), values.tolist(), strict=True))
            columns.append((signal_label(scope, i), column))
    times = sorted({t for _, column in columns for t in column})
    try:
        with replacing(path) as part, part.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["time [s]", *(label for label, _ in columns)])
            writer.writerows([t, *(column.get(t, "") for _, column in columns)] for t in times)
    except OSError as error:
        raise FileError("write", path, error) from None
    print(f"signals saved: {path}")
