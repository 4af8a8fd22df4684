"""Save the figures and signals of a run."""

from __future__ import annotations

import contextlib
import csv
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

SignalsWriter: TypeAlias = Callable[[Sequence[Any]], None]


def save(
    figure: Path | None, signals: SignalsWriter | None, scopes: Sequence[Any], until: str = ""
) -> None:
    """Write the open figures and the signals; a failure of one does not prevent the other.

    ``until``, if not empty, is the title of a further figure with all recorded signals.
    """
    with contextlib.ExitStack() as last:
        if signals is not None:
            last.callback(signals, scopes)
        if figure is not None:
            import matplotlib.pyplot as plt

            from ..plots import show, time_histories

            for n in plt.get_fignums():  # left open, as by ``sim.plot()``
                show(plt.figure(n), "")
            if until:
                show(time_histories(*scopes, title=until), "")


def check_file(option: str, path: Path | None, *endings: str) -> None:
    """Refuse a file that cannot be written, or whose ending is that of another format."""
    from .._core.files import ending, writable

    if path is not None:
        writable(option, path)
        if endings:
            ending(option, path, *endings)


def signals_writer(path: Path | None, rate: float | None) -> SignalsWriter | None:
    """A function that writes scopes' recordings as CSV, with at most ``rate`` rows per second."""
    from .._core.checks import positive, refuse

    if rate is not None:
        positive("csv-rate", rate)
        if path is None:
            refuse("csv-rate", rate, "--csv-rate requires --csv FILE")
    check_file("csv", path, ".csv", "")  # a pipe has no ending
    return None if path is None else partial(_write_csv, path.absolute(), rate)


def saving_figures(path: Path | None) -> contextlib.AbstractContextManager[None]:
    from ..plots import saving_to

    return contextlib.nullcontext() if path is None else saving_to(path.absolute())


def recording_scopes(objects: Iterable[Any]) -> list[Any]:
    """Scopes with a recording, of all simulations among ``objects``."""
    from pathsim import Simulation
    from pathsim.blocks import Scope

    from .._core.wiring import contents

    simulations = {id(x): x for x in objects if isinstance(x, Simulation)}
    blocks = [block for sim in simulations.values() for block in contents(sim)[0]]
    return [x for x in blocks if isinstance(x, Scope) and x.read()[0] is not None]


def _write_csv(path: Path, rate: float | None, scopes: Sequence[Any]) -> None:
    import numpy as np

    from .._core.checks import refuse
    from .._core.files import replacing
    from .._core.scopes import recording, signal_label

    if not scopes:
        refuse("csv", str(path), "no Scope has recorded a signal")
    columns: list[tuple[str, dict[float, float]]] = []
    for scope in scopes:
        time, data = recording(scope)
        if rate is not None:
            # the first sample of each period, with a tolerance for accumulated rounding of times
            periods = np.floor(time * rate + 1e-6)
            first = np.flatnonzero(np.diff(periods, prepend=-1.0))
            time, data = time[first], data[:, first]
        for i, values in enumerate(data):
            column = dict(zip(time.tolist(), values.tolist(), strict=True))
            columns.append((signal_label(scope, i), column))
    times = sorted({t for _, column in columns for t in column})
    with replacing(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["time [s]", *(label for label, _ in columns)])
        writer.writerows([t, *(column.get(t, "") for _, column in columns)] for t in times)
    print(f"signals saved: {path}")
