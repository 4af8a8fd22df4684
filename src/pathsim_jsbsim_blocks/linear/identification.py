"""A linear model from pulse responses: eigensystem realisation, then least squares.

The method is that of Juang and Pappa, "An Eigensystem Realization Algorithm for Modal Parameter
Identification and Model Reduction", Journal of Guidance, Control, and Dynamics 8(5), 1985, with
two additions. B and D are fitted to complete responses once A and C are identified. Signals that
only integrate others (heading, position) are left out of the realisation and appended as
integrators, because repeated poles at the origin cannot be separated numerically.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import expm, logm, qr, schur

from ..errors import LinearisationError

# block rows of the Hankel matrix: few, because the outputs contain nearly all states
_ROWS = 3

# relative rms error of the worst signal at which the search for the order ends
_GOOD = 3e-3

_ORDERS = range(4, 21)

# factor by which each additional state must reduce the error
_WORTH = 0.8

# singular values below this fraction of the maximum are noise
_NOISE = 1e-7

# a mode that decays to this fraction within one interval cannot be resolved
_FASTEST = 0.15

# fraction of its peak at which a signal reacts, and of its maximum peak at which a response counts
_REACTION, _RELEVANT = 1e-4, 1e-2

# maximum unexplained fraction of a signal's peak while the pulse acts
_UNEXPLAINED = 0.1

# minimum independent part of a signal, relative to its rms, for it to become a state
_INDEPENDENT = 0.05


@dataclass(frozen=True)
class Realisation:
    """A continuous model with inputs held over each sample, in the signals' units."""

    A: np.ndarray  # shape (n, n)
    B: np.ndarray  # shape (n, m)
    C: np.ndarray  # shape (p, n): a row for each signal
    D: np.ndarray  # shape (p, m)
    signals: list[int]  # signal of each state; -1 without one
    latency: list[int]  # periods by which each input acts late
    error: np.ndarray  # shape (p, m): rms over the signal's maximum rms response to any input


def realise(
    g: np.ndarray,
    T: float,
    width: int,
    *,
    rigid: list[int],  # states, if independent; they determine the latency
    engines: list[int],  # also states
    integrals: list[int],  # of other signals and of earlier integrals; ignorable
    abrupt: list[int],  # may jump with an input; ignored in the choice of order
) -> Realisation:
    """Identify a linear model from the responses to one pulse on each input.

    ``g`` of shape (m, n, p) has the responses of p signals to a pulse of height 1 on each of m
    inputs, at n samples that are T s apart; the pulse acts over the first ``width`` periods.
    """
    scale = np.sqrt((g**2).mean(axis=1)).max(axis=0)
    scale[scale == 0.0] = 1.0
    latency = _latency(g / scale, rigid)
    length = g.shape[1] - max(latency)
    g = np.array([y[late : late + length] for y, late in zip(g, latency, strict=True)])
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
    error = np.sqrt((flown.residuals(A, B, C, flown.after) ** 2).mean(axis=0))
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
        """Sample instants after the pulse; its feedthrough may come a sample late."""
        return np.arange(2 * self.width, self.g.shape[1], self.width)

    def of(self, signals: list[int]) -> _Pulses:
        """The responses of some signals."""
        return _Pulses(self.g[:, :, signals], self.T, self.width)

    def states(self, A: np.ndarray, instants: np.ndarray) -> np.ndarray:
        """States at sample instants, for B = 1: shape (instants, n, n)."""
        step, effect = _held(A, self.T)
        x = np.zeros((len(instants), *A.shape))
        state, k = np.zeros_like(A), 0
        powers: dict[int, np.ndarray] = {}
        for i, instant in enumerate(instants):
            while k < min(instant, self.width):
                state, k = step @ state + effect, k + 1
            if gap := instant - k:
                if gap not in powers:
                    powers[gap] = np.linalg.matrix_power(step, gap)
                state, k = powers[gap] @ state, instant
            x[i] = state
        return x

    def residuals(
        self, A: np.ndarray, B: np.ndarray, C: np.ndarray, instants: np.ndarray
    ) -> np.ndarray:
        """Responses minus those of the states at sample instants, shape (instants, p, m)."""
        return self.g[:, instants].transpose(1, 2, 0) - C @ self.states(A, instants) @ B


def _latency(g: np.ndarray, rigid: list[int]) -> list[int]:
    """Whole periods of delay of the motion beyond one sample, for each input."""
    late = []
    size = np.abs(g[:, :, rigid])
    for y in size:
        peak = y.max(axis=0)
        reacts = (y > _REACTION * peak) & (peak > _RELEVANT * size.max(axis=(0, 1)))
        late.append(max(int(np.argmax(reacts.any(axis=1))) - 1, 0))
    return late


def _search(flown: _Pulses, rigid: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, B and C of the lowest adequate order."""
    g, instants = flown.g, flown.after
    m, _, p = g.shape
    # the first interval after the pulse may still contain feedthrough
    h = g[:, 2 * flown.width :: flown.width]
    columns = h.shape[1] - _ROWS
    hankel = np.vstack(
        [np.hstack([h[j, i : columns + i].T for j in range(m)]) for i in range(_ROWS + 1)]
    )
    U, S, Vt = np.linalg.svd(hankel[:-p], full_matrices=False)
    target = g[:, instants].reshape(m, -1).T
    best: tuple[float, np.ndarray, np.ndarray, np.ndarray] | None = None
    for order in _ORDERS:
        if order > len(S) or S[order - 1] < _NOISE * S[0]:
            break
        discrete = U[:, :order].T @ hankel[p:] @ Vt[:order].T / S[:order]
        discrete, C = _slow_part(discrete, U[:p, :order])
        if not len(discrete):
            continue
        # SciPy's norm estimate draws from NumPy's global generator, which is the caller's
        generator = np.random.get_state()  # noqa: NPY002
        A = np.real(logm(discrete)) / (flown.width * flown.T)
        np.random.set_state(generator)  # noqa: NPY002
        regressors = (C @ flown.states(A, instants)).reshape(-1, len(A))
        B = np.linalg.lstsq(regressors, target, rcond=None)[0]
        residuals = (target - regressors @ B).T.reshape(m, len(instants), p)
        error = float(np.sqrt((residuals**2).mean(axis=1))[:, rigid].max(initial=0.0))
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
    """D from the residuals up to the instants that the search uses.

    For signals that jump, D is the mean residual over the pulse. In the others it stands for
    motion too fast for the search, with the same integral.
    """
    residuals = flown.residuals(A, B, C, np.arange(1, 2 * flown.width + 1))
    peak = np.abs(flown.g).max(axis=1).T
    fast = np.abs(residuals).max(axis=0) > _UNEXPLAINED * peak
    fast &= ~jumping[:, None] & (peak > _RELEVANT * peak.max(axis=1, keepdims=True))
    D = np.where(jumping[:, None], residuals[: flown.width].mean(axis=0), 0.0)
    return D + np.where(fast, residuals.sum(axis=0) / flown.width, 0.0)


def _slow_part(A: np.ndarray, C: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The modes of a discrete system that have a continuous counterpart within its bandwidth."""

    def slow(real: float, imaginary: float) -> bool:
        return np.hypot(real, imaginary) > _FASTEST and not (real < 0.0 and imaginary == 0.0)

    R, Z, order = schur(A, sort=slow)
    return R[:order, :order], C @ Z[:, :order]


def respond(system: Any, u: np.ndarray, T: float) -> np.ndarray:
    """Responses of a realisation or model to each input alone, held over each period of T s.

    ``u`` has the shape (n, m), the responses at the sample instants (m, n + 1, p).
    """
    step, effect = _held(system.A, T)
    into = effect @ system.B
    late = np.zeros_like(u)
    for j, periods in enumerate(map(int, system.latency)):
        late[periods:, j] = u[: max(len(u) - periods, 0), j]
    x = np.zeros((len(u) + 1, *system.B.shape))
    for k, inputs in enumerate(late):
        x[k + 1] = step @ x[k] + into * inputs
    y = system.C @ x
    y[1:] += system.D * late[:, None, :]
    return y.transpose(2, 0, 1)


def _held(A: np.ndarray, T: float) -> tuple[np.ndarray, np.ndarray]:
    """Transition over one period, and the effect of a constant input over it."""
    n = len(A)
    step = expm(np.block([[A, np.eye(n)], [np.zeros((n, 2 * n))]]) * T)
    return step[:n, :n], step[:n, n:]


def _append_integral(
    A: np.ndarray, B: np.ndarray, rows: dict[int, np.ndarray], signal: int, flown: _Pulses
) -> tuple[np.ndarray, np.ndarray, dict[int, np.ndarray]]:
    """The model with a signal as an additional state, an integral of the previous ones."""
    n, m = B.shape
    integrator = np.block([[A, np.zeros((n, n))], [np.eye(n), np.zeros((n, n))]])
    x = flown.states(integrator, flown.after)[:, n:, :n] @ B
    regressors = x.transpose(2, 0, 1).reshape(-1, n)
    target = flown.g[:, flown.after, signal].reshape(-1)
    row = np.linalg.lstsq(regressors, target, rcond=1e-9)[0]
    A = np.block([[A, np.zeros((n, 1))], [row[None], np.zeros((1, 1))]])
    B = np.vstack([B, np.zeros((1, m))])
    rows = {i: np.append(r, 0.0) for i, r in rows.items()}
    rows[signal] = np.append(np.zeros(n), 1.0)
    return A, B, rows


def _coordinates(C: np.ndarray, states: list[int]) -> tuple[np.ndarray, list[int]]:
    """Independent rows of C as states, completed by orthogonal ones; and their signals."""
    n = C.shape[1]
    rows, signals = np.zeros((0, n)), []
    for i in states:
        if len(rows) == n or not np.any(C[i]):
            continue
        basis = qr(rows.T, mode="economic")[0] if len(rows) else np.zeros((n, 0))
        remainder = C[i] - basis @ (basis.T @ C[i])
        if np.linalg.norm(remainder) > _INDEPENDENT * np.linalg.norm(C[i]):
            rows = np.vstack([rows, C[i]])
            signals.append(i)
    if len(rows) < n:
        complement = qr(rows.T)[0][:, len(rows) :].T if len(rows) else np.eye(n)
        rows = np.vstack([rows, complement])
    return rows, signals + [-1] * (n - len(signals))
