"""A linear model from pulse responses: eigensystem realisation, then least squares.

The method is that of Juang and Pappa, "An Eigensystem Realization Algorithm for Modal Parameter
Identification and Model Reduction", Journal of Guidance, Control, and Dynamics 8(5), 1985, with
two additions. B and D are fitted to whole responses after A and C are known, and signals that only
integrate others (heading, position) are kept out of the realisation and appended as integrators:
several poles at the origin are not separable by numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import expm, logm, qr, schur

from ..errors import LinearisationError

# rows of blocks in the Hankel matrix: the outputs show nearly all states at once
_ROWS = 3

# relative rms error of the worst signal with which the search for the order ends
_GOOD = 3e-3

_ORDERS = range(4, 21)

# each further state is worth it if it lowers the error at least by this factor
_WORTH = 0.8

# singular values below this fraction of the largest are noise
_NOISE = 1e-7

# a mode that decays to this within one interval is faster than the data can show
_FASTEST = 0.15

# fraction of its peak from which on a signal reacts, and of its largest peak from which on it does
_REACTION, _RELEVANT = 1e-4, 1e-2

# part of a signal's peak that the states may leave unexplained while the pulse acts
_UNSEEN = 0.1

# smallest independent part of a signal, relative to its rms, that makes it a further state
_INDEPENDENT = 0.05


@dataclass(frozen=True)
class Realisation:
    """A continuous model with inputs held over each sample, in the signals' units."""

    A: np.ndarray  # shape (n, n)
    B: np.ndarray  # shape (n, m)
    C: np.ndarray  # shape (p, n): a row for each signal
    D: np.ndarray  # shape (p, m)
    signals: list[int]  # signal that is the state of that number; -1 for a state without one
    latency: list[int]  # periods by which each input acts late
    error: np.ndarray  # shape (p, m): rms over the signal's largest rms response to any input


def realise(
    g: np.ndarray,
    T: float,
    width: int,
    *,
    rigid: list[int],  # used as states, as far as they are independent; they show the latency
    engines: list[int],  # used as states too
    integrals: list[int],  # of others and those before them in the list; nothing depends on them
    abrupt: list[int],  # may jump with an input; they do not decide on the order
) -> Realisation:
    """Identify a linear model from the responses to one pulse on each input.

    ``g`` of shape (m, n, p) has the responses of p signals to a pulse of height 1 on each of m
    inputs, at n samples that are T s apart; the pulse acts over the first ``width`` periods.
    """
    scale = np.sqrt((g**2).mean(axis=1)).max(axis=0)
    scale[scale == 0.0] = 1.0
    latency = _latency(g / scale, rigid)
    kept = g.shape[1] - max(latency)
    g = np.array([y[late : late + kept] for y, late in zip(g, latency, strict=True)])
    flown = _Pulses(g / scale, T, width)
    m, _, p = flown.g.shape
    core = [i for i in range(p) if i not in integrals and np.any(flown.g[:, :, i])]
    part = flown.of(core)
    A, B, C = _search(part, [row for row, i in enumerate(core) if i not in abrupt])
    D = np.zeros((p, m))
    D[core] = _feedthrough(part, A, B, C, np.isin(core, abrupt))
    rows = {i: C[row] for row, i in enumerate(core)}
    for i in integrals:
        A, B, rows = _append_integral(A, B, rows, i, flown)
    C = np.array([rows.get(i, np.zeros(len(A))) for i in range(p)])
    change, signals = _coordinates(C, [*rigid, *engines, *integrals])
    inverse = np.linalg.inv(change)
    A, B, C = change @ A @ inverse, change @ B, C @ inverse
    error = np.sqrt((flown.missed(A, B, C, flown.after) ** 2).mean(axis=0))
    # back to the signals' own units
    size = np.array([scale[i] if i >= 0 else 1.0 for i in signals])
    return Realisation(
        size[:, None] * A / size,
        size[:, None] * B,
        scale[:, None] * C / size,
        scale[:, None] * D,
        signals,
        latency,
        error,
    )


@dataclass(frozen=True)
class _Pulses:
    """Responses to a pulse on each input, scaled and without their latency."""

    g: np.ndarray  # shape (m, n, p), as in `realise`
    T: float  # sample period in s
    width: int  # samples of the pulse

    @property
    def after(self) -> np.ndarray:
        """Sample instants after the pulse; what it feeds through may come a sample late."""
        return np.arange(2 * self.width, self.g.shape[1], self.width)

    def of(self, signals: list[int]) -> _Pulses:
        """The responses of some signals."""
        return _Pulses(self.g[:, :, signals], self.T, self.width)

    def states(self, A: np.ndarray, instants: np.ndarray) -> np.ndarray:
        """States at sample instants, for B = 1: shape (instants, n, n)."""
        step, held = _held(A, self.T)
        x = np.zeros((len(instants), *A.shape))
        state, now = np.zeros_like(A), 0
        powers: dict[int, np.ndarray] = {}
        for i, instant in enumerate(instants):
            while now < min(instant, self.width):
                state, now = step @ state + held, now + 1
            if ahead := instant - now:
                if ahead not in powers:
                    powers[ahead] = np.linalg.matrix_power(step, ahead)
                state, now = powers[ahead] @ state, instant
            x[i] = state
        return x

    def missed(
        self, A: np.ndarray, B: np.ndarray, C: np.ndarray, instants: np.ndarray
    ) -> np.ndarray:
        """What the states do not explain at sample instants: shape (instants, p, m)."""
        return self.g[:, instants].transpose(1, 2, 0) - C @ self.states(A, instants) @ B


def _latency(g: np.ndarray, rigid: list[int]) -> list[int]:
    """Whole periods by which the motion answers to each input later than by one sample."""
    late = []
    size = np.abs(g[:, :, rigid])
    for y in size:
        peak = y.max(axis=0)
        reacts = (y > _REACTION * peak) & (peak > _RELEVANT * size.max(axis=(0, 1)))
        late.append(max(int(np.argmax(reacts.any(axis=1))) - 1, 0))
    return late


def _search(flown: _Pulses, judged: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, B and C of the lowest adequate order."""
    g, after = flown.g, flown.after
    m, _, p = g.shape
    # the first interval after the pulse may still show what it feeds through
    h = g[:, 2 * flown.width :: flown.width]
    columns = h.shape[1] - _ROWS
    hankel = np.vstack(
        [np.hstack([h[j, i : columns + i].T for j in range(m)]) for i in range(_ROWS + 1)]
    )
    U, S, Vt = np.linalg.svd(hankel[:-p], full_matrices=False)
    wanted = g[:, after].reshape(m, -1).T
    best: tuple[float, np.ndarray, np.ndarray, np.ndarray] | None = None
    for order in _ORDERS:
        if order > len(S) or S[order - 1] < _NOISE * S[0]:
            break
        discrete = U[:, :order].T @ hankel[p:] @ Vt[:order].T / S[:order]
        discrete, C = _slow_part(discrete, U[:p, :order])
        if not len(discrete):
            continue
        A = np.real(logm(discrete)) / (flown.width * flown.T)
        observed = (C @ flown.states(A, after)).reshape(-1, len(A))
        B = np.linalg.lstsq(observed, wanted, rcond=None)[0]
        missed = (wanted - observed @ B).T.reshape(m, len(after), p)
        error = float(np.sqrt((missed**2).mean(axis=1))[:, judged].max(initial=0.0))
        worth = best is None or error < _WORTH ** (len(A) - len(best[1])) * best[0]
        if worth or error < _GOOD:
            best = error, A, B, C
        if error < _GOOD:
            break
    if best is None:
        raise LinearisationError(
            f"no linear model: the responses have fewer than {_ORDERS[0]} independent parts",
            reason="no fit",
        )
    return best[1:]


def _feedthrough(
    flown: _Pulses, A: np.ndarray, B: np.ndarray, C: np.ndarray, jumping: np.ndarray
) -> np.ndarray:
    """D from what the states leave unexplained until the search begins.

    Signals that jump have their mean over the pulse. Others have motion that has decayed by then:
    it follows the input at once, with the same integral.
    """
    missed = flown.missed(A, B, C, np.arange(1, 2 * flown.width + 1))
    peak = np.abs(flown.g).max(axis=1).T
    fast = np.abs(missed).max(axis=0) > _UNSEEN * peak
    fast &= ~jumping[:, None] & (peak > _RELEVANT * peak.max(axis=1, keepdims=True))
    D = np.where(jumping[:, None], missed[: flown.width].mean(axis=0), 0.0)
    return D + np.where(fast, missed.sum(axis=0) / flown.width, 0.0)


def _slow_part(A: np.ndarray, C: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The modes of a discrete system that have a continuous counterpart within its bandwidth."""

    def slow(real: float, imaginary: float) -> bool:
        return np.hypot(real, imaginary) > _FASTEST and not (real < 0.0 and imaginary == 0.0)

    R, Z, kept = schur(A, sort=slow)
    return R[:kept, :kept], C @ Z[:, :kept]


def respond(found: Any, u: np.ndarray, T: float) -> np.ndarray:
    """Responses of a realisation or model to each input alone, held over each period of T s.

    ``u`` has the shape (n, m), the responses at the sample instants (m, n + 1, p).
    """
    step, held = _held(found.A, T)
    into = held @ found.B
    late = np.zeros_like(u)
    for j, periods in enumerate(map(int, found.latency)):
        late[periods:, j] = u[: max(len(u) - periods, 0), j]
    x = np.zeros((len(u) + 1, *found.B.shape))
    for k, now in enumerate(late):
        x[k + 1] = step @ x[k] + into * now
    y = found.C @ x
    y[1:] += found.D * late[:, None, :]
    return y.transpose(2, 0, 1)


def _held(A: np.ndarray, T: float) -> tuple[np.ndarray, np.ndarray]:
    """Transition over one period, and the effect of a constant input over it."""
    n = len(A)
    both = expm(np.block([[A, np.eye(n)], [np.zeros((n, 2 * n))]]) * T)
    return both[:n, :n], both[:n, n:]


def _append_integral(
    A: np.ndarray, B: np.ndarray, rows: dict[int, np.ndarray], signal: int, flown: _Pulses
) -> tuple[np.ndarray, np.ndarray, dict[int, np.ndarray]]:
    """The model with a signal as one more state, an integral of those before it."""
    n, m = B.shape
    integrator = np.block([[A, np.zeros((n, n))], [np.eye(n), np.zeros((n, n))]])
    x = flown.states(integrator, flown.after)[:, n:, :n] @ B
    observed = x.transpose(2, 0, 1).reshape(-1, n)
    wanted = flown.g[:, flown.after, signal].reshape(-1)
    row = np.linalg.lstsq(observed, wanted, rcond=1e-9)[0]
    A = np.block([[A, np.zeros((n, 1))], [row[None], np.zeros((1, 1))]])
    B = np.vstack([B, np.zeros((1, m))])
    rows = {i: np.append(r, 0.0) for i, r in rows.items()}
    rows[signal] = np.append(np.zeros(n), 1.0)
    return A, B, rows


def _coordinates(C: np.ndarray, states: list[int]) -> tuple[np.ndarray, list[int]]:
    """Rows of C that make good states, completed by orthogonal ones; and their signals."""
    n = C.shape[1]
    rows, signals = np.zeros((0, n)), []
    for i in states:
        if len(rows) == n or not np.any(C[i]):
            continue
        basis = qr(rows.T, mode="economic")[0] if len(rows) else np.zeros((n, 0))
        rest = C[i] - basis @ (basis.T @ C[i])
        if np.linalg.norm(rest) > _INDEPENDENT * np.linalg.norm(C[i]):
            rows = np.vstack([rows, C[i]])
            signals.append(i)
    if len(rows) < n:
        complement = qr(rows.T)[0][:, len(rows) :].T if len(rows) else np.eye(n)
        rows = np.vstack([rows, complement])
    return rows, signals + [-1] * (n - len(signals))
