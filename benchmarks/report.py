"""One row of the benchmarks' table: ours, a peer measured in the same run, their ratio."""

import statistics

HEADER = f"{'what':<46} {'peer':<28} {'ours':>10} {'peer':>10} {'ours/peer':>10} {'target':>8}"


def row(what, peer, ours, others, unit, most=None):
    """Print a row.

    Parameters
    ----------
    what, peer : str
    ours, others : sequences of float
        times in s, measured in turn: one ratio is formed from each pair
    unit : str
        "s", "ms" or "us"
    most : float, optional
        the ratio that is the target
    """
    scale = {"s": 1.0, "ms": 1e3, "us": 1e6}[unit]
    ratio = statistics.median(a / b for a, b in zip(ours, others, strict=True))
    target = "" if most is None else f"<= {most:.2f}"
    print(
        f"{what:<46} {peer:<28} {scale * statistics.median(ours):>7.2f} {unit:<2} "
        f"{scale * statistics.median(others):>7.2f} {unit:<2} {ratio:>10.2f} {target:>8}",
        flush=True,
    )
