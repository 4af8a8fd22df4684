"""One row of the benchmarks' table: ours, a peer measured in the same run, their ratio."""

import datetime
import math
import os
import platform
import statistics
from importlib.metadata import version
from pathlib import Path


def processor_name():
    """Name of the processor."""
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor_name() or platform.machine()


def _machine():
    """Where and when: processor, cores, Python, date, and whether other programs run."""
    cores = os.cpu_count()
    now = datetime.datetime.now(datetime.timezone.utc)
    line = (
        f"{processor_name()}, {cores} cores, {platform.system()}, "
        f"Python {platform.python_version()}, {now:%Y-%m-%d %H:%M} UTC"
    )
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    return line + (f", loaded machine (load {load:.1f})" if load > 0.5 * cores else "")


HEADER = (
    f"{_machine()}\n"
    f"{'what':<50} {'peer':<44} {'ours':>10} {'peer':>10} {'ours/peer':>10} {'target':>10}"
)


def row(what, peer, ours, others, unit, most=None, package=None):
    """Print a row, with a star if the ratio is above its target.

    Parameters
    ----------
    what, peer : str
    ours, others : sequences of float
        times in s, measured in turn: one ratio is formed from each pair
    unit : str
        "s", "ms" or "us"
    most : float or (float, float), optional
        the ratio that is the target; a pair where it depends on the machine: the range measured
    package : str, optional
        the package that the peer comes from; its version is shown
    """
    scale = {"s": 1.0, "ms": 1e3, "us": 1e6}[unit]
    ratio = statistics.median(a / b for a, b in zip(ours, others, strict=True))
    if isinstance(most, tuple):
        target, limit = f"{most[0]:.1f} to {most[1]:.1f}", most[1]
    else:
        target, limit = ("", math.inf) if most is None else (f"<= {most:.2f}", most)
    if package is not None:
        release = f"{package} {version(package)}"
        peer = release if peer == package else f"{peer} ({release})"
    star = " *" if ratio > limit else ""
    print(
        f"{what:<50} {peer:<44} {scale * statistics.median(ours):>7.2f} {unit:<2} "
        f"{scale * statistics.median(others):>7.2f} {unit:<2} {ratio:>10.2f} {target:>10}{star}",
        flush=True,
    )
