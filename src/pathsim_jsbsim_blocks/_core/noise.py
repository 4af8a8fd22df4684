"""White noise for sampled laws: reproducible, and a function of the sample's number."""

from __future__ import annotations

from typing import Any

import numpy as np

from .checks import integer

_ROWS = 1024


class WhiteNoise:
    """Independent standard normal numbers, a row of them for each sample.

    A law may be evaluated several times at one instant, so a row depends only on the seed (0 or
    more) and its number, not on earlier draws.
    """

    def __init__(self, seed: Any, width: int):
        self._seed = integer("seed", seed, low=0)
        self._width = width
        # number of a stretch of rows, and the rows
        self._drawn: tuple[int, list[list[float]]] = (-1, [])

    def row(self, k: int) -> list[float]:
        """The numbers of sample ``k``."""
        number, place = divmod(k, _ROWS)
        stretch, rows = self._drawn
        if stretch != number:
            random = np.random.default_rng([self._seed, number])
            rows = random.standard_normal((_ROWS, self._width)).tolist()
            self._drawn = number, rows
        return rows[place]
