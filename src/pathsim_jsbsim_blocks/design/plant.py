"""A linear aircraft, sampled with its loops: difference equations with named signals."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..linear.model import LinearModel, sampled

OMEGA = np.geomspace(0.02, 300.0, 220)  # frequencies of the margins, rad/s


def integral(omega: np.ndarray, T: float) -> np.ndarray:
    """Frequency response of a sampled law's integral."""
    return T / (np.exp(1j * omega * T) - 1.0)


@dataclass(frozen=True)
class Law:
    """Linear feedback law; gains are numbers, or columns of numbers for many laws.

    .. math::
        u = -\\sum_i \\left(P_i + \\frac{I_i T}{z - 1}
        + W_i \\frac{z - 1}{z - e^{-T / \\tau}}\\right) y_i

    Attributes
    ----------
    gains : dict
        maps the name of an output to P, or P and I, or P, I and W
    tau : float
        time constant of the wash-out, s; 0 without one
    """

    gains: Mapping[str, tuple[Any, ...]]
    tau: float = 0.0

    def of(self, y: Mapping[str, np.ndarray], T: float) -> np.ndarray:
        """Feedback from the responses ``y`` at `OMEGA`; with the responses to its own input, L."""
        parts: list[Any] = [1.0, integral(OMEGA, T)]
        if self.tau:
            z = np.exp(1j * OMEGA * T)
            parts.append((z - 1.0) / (z - math.exp(-T / self.tau)))
        return sum(
            sum(gain * part for gain, part in zip(gains, parts, strict=False)) * y[name]
            for name, gains in self.gains.items()
        )


@dataclass(frozen=True)
class Plant:
    """Difference equations of an aircraft and of the loops closed so far.

    .. math::
        x_{k+1} = A x_k + B u_k, \\qquad y_k = C x_k

    in increments about the trim. Inputs are held over each period T, in s.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    inputs: Sequence[str]
    outputs: Sequence[str]
    T: float

    @classmethod
    def of(cls, model: LinearModel) -> Plant:
        """The sampled aircraft with its latency.

        Angles, rates and speeds have no direct feedthrough, so the identified one is omitted.
        """
        n, m = model.B.shape
        transition, effects = sampled(model)
        late = model.latency.astype(int)
        size = n + int(late.sum())
        A, B = np.zeros((size, size)), np.zeros((size, m))
        C = np.hstack([model.C, np.zeros((len(model.C), size - n))])
        A[:n, :n] = transition
        end = n
        for j, k in enumerate(late):
            effect = effects[:, j]
            if not k:
                B[:n, j] = effect
                continue
            # a shift register delays the command by k periods: it enters last and acts first
            A[:n, end] = effect
            A[range(end, end + k - 1), range(end + 1, end + k)] = 1.0
            B[end + k - 1, j] = 1.0
            end += k
        return cls(A, B, C, list(model.inputs), list(model.outputs), model.dt)

    def row(self, output: str) -> np.ndarray:
        """The row of C of an output."""
        return self.C[self.outputs.index(output)]

    def column(self, input_: str) -> np.ndarray:
        """The column of B of an input."""
        return self.B[:, self.inputs.index(input_)]

    def response(self, omega: np.ndarray, input_: str) -> dict[str, np.ndarray]:
        """Frequency responses of all outputs to one input at ``omega``, rad/s."""
        z = np.exp(1j * omega * self.T)
        b = np.broadcast_to(self.column(input_)[:, None], (len(omega), len(self.A), 1))
        x = np.linalg.solve(z[:, None, None] * np.eye(len(self.A)) - self.A, b)[..., 0]
        return dict(zip(self.outputs, (x @ self.C.T).T, strict=True))

    def close(
        self,
        input_: str,
        law: Law,
        reference: tuple[str, float, float] | None = None,
        command: str | None = None,
    ) -> Plant:
        """The plant with a law around one input.

        ``reference`` names the input that replaces it, with the law's P and I for that reference.
        ``command`` names a further output: the law's command without the reference.
        """
        n, T, b = len(self.A), self.T, self.column(input_)
        direct, integral, washout = rows = np.zeros((3, n))
        for name, gains in law.gains.items():
            for row, gain in zip(rows, gains, strict=False):
                row += gain * self.row(name)
        # further states: the integral, and the lag of the wash-out
        fade = math.exp(-T / law.tau) if law.tau else 0.0
        size = n + (2 if law.tau else 1)
        u = np.concatenate([-direct - washout, [-1.0, 1.0]])[:size]
        A, B = np.zeros((n + 2, size)), np.zeros((n + 2, len(self.inputs)))
        A[:n, :n], B[:n] = self.A, self.B
        A[:n] += np.outer(b, u)
        A[n, :n], A[n, n] = T * integral, 1.0
        A[n + 1, :n], A[n + 1, -1] = (1.0 - fade) * washout, fade
        j, inputs = self.inputs.index(input_), list(self.inputs)
        if reference is None:
            B = np.delete(B, j, axis=1)
            del inputs[j]
        else:
            inputs[j], p, i = reference
            B[:n, j], B[n, j] = p * b, -T * i
        C, outputs = np.hstack([self.C, np.zeros((len(self.C), size - n))]), list(self.outputs)
        if command is not None:
            C, outputs = np.vstack([C, u]), [*outputs, command]
        return Plant(A[:size], B[:size], C, inputs, outputs, T)

    def lagged(self, input_: str, output: str, tau: float) -> Plant:
        """The plant with a further input and, behind a lag of ``tau`` s, a further output of it."""
        n, m, k = *self.B.shape, len(self.C)
        A, B, C = np.zeros((n + 1, n + 1)), np.zeros((n + 1, m + 1)), np.zeros((k + 1, n + 1))
        A[:n, :n], B[:n, :m], C[:k, :n] = self.A, self.B, self.C
        A[n, n], C[k, n] = math.exp(-self.T / tau), 1.0
        B[n, m] = 1.0 - A[n, n]
        return Plant(A, B, C, [*self.inputs, input_], [*self.outputs, output], self.T)

    def steps(
        self,
        inputs: str | tuple[str, ...],
        outputs: Sequence[str],
        law: Callable[[int, np.ndarray], np.ndarray | float],
        loops: int,
        seconds: float,
    ) -> np.ndarray:
        """Outputs of many loops over time, shape (samples, outputs, loops).

        ``law`` returns the commands of all loops from the sample number and the outputs: an array
        of shape (loops,), or (inputs, loops) for several inputs.
        """
        rows = np.array([self.row(name) for name in outputs])
        names = [inputs] if isinstance(inputs, str) else inputs
        moves = np.column_stack([self.A, *(self.column(name) for name in names)])
        # the commands are the last rows of the state, so that one product advances all loops
        n, x = len(self.A), np.zeros((len(self.A) + len(names), loops))
        y = np.empty((round(seconds / self.T), len(rows), loops))
        with np.errstate(over="ignore", invalid="ignore"):
            for k in range(len(y)):
                y[k] = rows @ x[:n]
                x[n:] = law(k, y[k])
                x[:n] = moves @ x
        return y

    def slower(self, n: int) -> Plant:
        """The same plant with inputs held over ``n`` periods."""
        A, B = self.A, self.B
        for _ in range(n - 1):
            B = self.A @ B + self.B
            A = self.A @ A
        return replace(self, A=A, B=B, T=n * self.T)

    def growth(self) -> float:
        """Real part of the least stable pole, 1/s, without the integrals (heading, altitude)."""
        poles = np.linalg.eigvals(self.A)
        rate = np.log(np.maximum(np.abs(poles), 1e-12)) / self.T
        return float(rate[np.abs(poles - 1.0) > 2e-6].max())
