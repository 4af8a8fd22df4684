"""Natural modes of a linear model, named by the participating states."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eig

_LONGITUDINAL = ("vt", "alpha", "q", "theta", "h")
_LATERAL = ("beta", "p", "r", "phi")

# modes of states that only integrate others
_INTEGRALS = {"h": "altitude", "psi": "heading", "lat": "position", "lon": "position"}

# maximum rate of these, 1/s: the density gradient moves them slightly off the origin
_SLOW = 5e-3

# maximum rate of a spiral, 1/s
_SPIRAL = 1.0

# minimum participation of a mode's own states, and of the sideslip in the Dutch roll
_DOMINANT, _SLIP = 0.5, 0.2


@dataclass(frozen=True)
class Mode:
    """One natural mode: a real pole, or a pair of complex ones.

    Attributes
    ----------
    name : str
        "short period" (also of each of two real poles), "phugoid", "third oscillatory", "Dutch
        roll", "roll", "spiral", "lateral phugoid", "engine", "altitude", "heading", "position",
        or "unnamed" if none of these fits
    pole : complex
        1/s; for a pair, the pole with the positive imaginary part
    participation : dict[str, float]
        participation factor of each state, the largest first; their sum is 1
    """

    name: str
    pole: complex
    participation: dict[str, float]

    @property
    def oscillatory(self) -> bool:
        """Whether the mode is a pair of complex poles."""
        return self.pole.imag != 0.0

    @property
    def frequency(self) -> float:
        """Natural frequency in rad/s; the magnitude of a real pole."""
        return abs(self.pole)

    @property
    def damping(self) -> float:
        """Damping ratio; 1 or -1 for a real pole, NaN at 0."""
        return -self.pole.real / abs(self.pole) if self.pole else math.nan

    @property
    def period(self) -> float:
        """Period in s; NaN for a real pole."""
        return 2 * math.pi / self.pole.imag if self.oscillatory else math.nan

    @property
    def time_constant(self) -> float:
        """-1 / real part in s: negative if the mode grows, infinite at 0."""
        return -1.0 / self.pole.real if self.pole.real else math.inf

    @property
    def time_to_half(self) -> float:
        """Time to half amplitude in s; NaN if the mode does not decay."""
        return math.log(2) * self.time_constant if self.pole.real < 0.0 else math.nan

    @property
    def time_to_double(self) -> float:
        """Time to double amplitude in s; NaN if the mode does not grow."""
        return -math.log(2) * self.time_constant if self.pole.real > 0.0 else math.nan

    def __str__(self) -> str:
        parts = [f"{self.frequency:.4g} rad/s"] if self.pole else ["at the origin"]
        if self.oscillatory:
            parts += [f"damping ratio {self.damping:.3f}", f"period {self.period:.3g} s"]
        if self.pole.real:
            time = math.log(2) * abs(self.time_constant)
            parts.append(f"{'halves' if self.pole.real < 0.0 else 'doubles'} in {time:.3g} s")
        states = (name for name, factor in self.participation.items() if factor > 0.1)
        return f"{self.name}: {', '.join(parts)} ({', '.join(states)})"


def natural_modes(A: np.ndarray, states: Sequence[str]) -> list[Mode]:
    """Natural modes of a linear system, the fastest first.

    The participation factor of a state, the product of its entries in the right and the left
    eigenvector, is independent of units. States that only integrate others (heading, position)
    are removed first, because repeated poles at 0 lack independent eigenvectors.

    Perez-Arriaga, Verghese, Schweppe, "Selective Modal Analysis with Applications to Electric
    Power Systems", IEEE Transactions on Power Apparatus and Systems PAS-101, 1982.
    """
    core = list(range(len(states)))
    integrals = []
    while outer := [i for i in core if not np.any(np.delete(A[core, i], core.index(i)))]:
        integrals += outer
        core = [i for i in core if i not in outer]
    modes = [Mode("", complex(A[i, i]), {states[i]: 1.0}) for i in integrals]
    if core:
        poles, left, right = eig(A[np.ix_(core, core)], left=True, right=True)
        factors = np.abs(left.conj() * right)
        factors /= factors.sum(axis=0)
        for pole, column in zip(poles, factors.T, strict=True):
            if pole.imag >= 0.0:
                order = np.argsort(-column)
                participation = {states[core[i]]: float(column[i]) for i in order}
                modes.append(Mode("", complex(pole), participation))
    result = [replace(mode, name=name) for name, mode in zip(_names(modes), modes, strict=True)]
    return sorted(result, key=lambda mode: -mode.frequency)


def _weight(mode: Mode, *states: str) -> float:
    return sum(mode.participation.get(state, 0.0) for state in states)


def _names(modes: list[Mode]) -> list[str]:
    names = ["unnamed"] * len(modes)
    free = set(range(len(modes)))

    def name(i: int, text: str) -> None:
        names[i] = text
        free.discard(i)

    for i, mode in enumerate(modes):
        first = next(iter(mode.participation))
        if not mode.oscillatory and mode.frequency < _SLOW and first in _INTEGRALS:
            name(i, _INTEGRALS[first])
        elif sum(s for state, s in mode.participation.items() if "[" in state) > _DOMINANT:
            name(i, "engine")

    def family(*states: str, oscillatory: bool) -> list[int]:
        """Modes dominated by some states, the fastest first."""
        kind = (i for i in free if modes[i].oscillatory == oscillatory)
        members = (i for i in kind if _weight(modes[i], *states) > _DOMINANT)
        return sorted(members, key=lambda i: -modes[i].frequency)

    oscillations = family(*_LATERAL, oscillatory=True)
    if oscillations:
        dutch = max(oscillations, key=lambda i: _weight(modes[i], "beta", "r"))
        # a pair that has merged with the roll is not a Dutch roll
        if _weight(modes[dutch], "beta", "r") > _DOMINANT and _weight(modes[dutch], "beta") > _SLIP:
            name(dutch, "Dutch roll")
    for i in family("p", "phi", oscillatory=True):
        name(i, "lateral phugoid")
    lateral = family(*_LATERAL, oscillatory=False)
    rolls = [i for i in lateral if _weight(modes[i], "p") > _DOMINANT]
    if rolls:
        name(rolls[0], "roll")
    candidates = (i for i in lateral if i in free and modes[i].frequency < _SPIRAL)
    spirals = [i for i in candidates if _weight(modes[i], "phi") > _weight(modes[i], "p")]
    if spirals:
        name(spirals[-1], "spiral")

    oscillations = family(*_LONGITUDINAL, oscillatory=True)
    real = family(*_LONGITUDINAL, oscillatory=False)
    fast_real = [i for i in real if _weight(modes[i], "alpha", "q") > _DOMINANT]
    fast = [i for i in oscillations if _weight(modes[i], "alpha", "q") > _DOMINANT]
    if fast:
        name(fast[0], "short period")
    elif len(fast_real) >= 2:
        for i in fast_real[:2]:
            name(i, "short period")
    pairs = [i for i in oscillations if i in free]
    slow_pair = max(pairs, key=lambda i: _weight(modes[i], "vt", "theta"), default=None)
    if slow_pair is not None and "short period" in names:
        name(slow_pair, "phugoid")
    elif slow_pair is not None and len(real) >= 2:
        # a root of the short period and one of the phugoid have merged
        name(slow_pair, "third oscillatory")
    return names
