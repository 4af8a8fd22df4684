"""Invariants of physics: values of a performance table that break one are marked as faults."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

_ACCURACY = 1.005  # ratio of two values, above that of the searches
GAVE_UP = "no convergence"  # reason of a search that ends without a limit of the aircraft

_HEAVY = "the stall speed falls with the weight"
_FLAPS = "the stall speed rises with the flaps"
_CLIMB = "the climb of engines without a supercharger rises with the altitude"
_LIFT = "the airspeed at the lift limit falls with the load factor"


def mark_faults(table: pd.DataFrame, unsupercharged: bool = False) -> pd.DataFrame:
    """Set the column ``fault`` of a performance table: the invariant that a value breaks, or "".

    Stall speed grows with the weight and falls with the flaps, the airspeed at the lift limit grows
    with the load factor, pulled or pushed, no glide climbs with the throttle closed, the best rate
    of climb of piston engines without a supercharger falls with the altitude, and load factors are
    within the limit of the same table. A value that breaks one where its search gave up is removed.
    Of values that contradict each other the fault is the one that contradicts most, or else the one
    whose search gave up, or else both.

    Parameters
    ----------
    table : pandas.DataFrame
        of `performance_table`, changed in place
    unsupercharged : bool
        whether all engines are piston engines without a supercharger
    """
    texts = dict.fromkeys(table.index, "")
    numbers = table.dropna(subset=["value"])
    stall = numbers[numbers.quantity == "stall speed"]
    pairs = {pair: _HEAVY for pair in _falls(stall, "flaps_norm", "weight_lb")}
    pairs |= {pair: _FLAPS for pair in _falls(stall, "weight_lb", "flaps_norm", -1.0)}
    if unsupercharged:
        climbs = numbers[numbers.quantity == "best rate of climb"]
        pairs |= {pair: _CLIMB for pair in _falls(climbs, "weight_lb", "altitude_ft", -1.0)}
    limits = table[table.quantity == "speed at the lift limit"]
    for sign in (-1.0, 1.0):
        side = limits[sign * limits.load_factor > 0.0].dropna(subset=["value"])
        pairs |= {pair: _LIFT for pair in _falls(side, "weight_lb", "load_factor", sign)}
    gave_up = table.reason == GAVE_UP
    while pairs:
        count = Counter(row for pair in pairs for row in pair)
        rank = {row: (count[row], bool(gave_up[row])) for row in count}
        worst = {row for row in rank if rank[row] == max(rank.values())}
        for pair, text in pairs.items():
            texts.update(dict.fromkeys(worst.intersection(pair), text))
        pairs = {pair: text for pair, text in pairs.items() if not worst.intersection(pair)}
    sinks = numbers[numbers.quantity.isin(["sink rate", "least sink rate"])]
    for row in sinks.index[sinks.value < 0.0]:
        texts[row] = "it climbs with the throttle closed"
    limit = limits.load_factor.astype(float).max()
    turns = numbers[numbers.quantity.isin(["sustained load factor", "instantaneous load factor"])]
    for row in turns.index[turns.value > limit + 1e-6]:
        texts[row] = f"above the limit load factor, {limit:.2g} g"
    table["fault"] = [*texts.values()]
    table.loc[gave_up & (table.fault != ""), ["value", "flown", "difference_percent"]] = math.nan
    return table


def _falls(rows: pd.DataFrame, group: str, order: str, sign: float = 1.0) -> Iterator[tuple]:
    """Pairs of rows of a group of which the second is lower than the first, or higher (-1)."""
    for _, part in rows.groupby(group):
        part = part.sort_values(order)
        values = zip(part.index, part.value, strict=True)
        for (i, one), (j, two) in combinations(values, 2):
            high, low = (one, two) if sign > 0.0 else (two, one)
            if high > max(low * _ACCURACY, low):
                yield i, j
