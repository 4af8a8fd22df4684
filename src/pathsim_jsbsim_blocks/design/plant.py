"""A linear aircraft as the sampled loops see it: difference equations with names."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.linalg import expm

from ..linear.model import LinearModel


class Plant:
    """Difference equations of an aircraft and of the loops closed so far.

    .. math::
        x_{k+1} = A x_k + B u_k, \\qquad y_k = C x_k

    in increments about the trim. Inputs are held over each period.

    Parameters
    ----------
    A, B, C : array
        shapes (n, n), (n, m), (p, n)
    inputs, outputs : list of str
        names of the m inputs and the p outputs
    T : float
        sample period in s
    """

    def __init__(
        self,
        A: np.ndarray,
        B: np.ndarray,
        C: np.ndarray,
        inputs: Sequence[str],
        outputs: Sequence[str],
        T: float,
    ):
        self.A, self.B, self.C = A, B, C
        self.inputs, self.outputs = list(inputs), list(outputs)
        self.T = T

    @classmethod
    def of(cls, model: LinearModel) -> Plant:
        """The sampled aircraft with its latency.

        Angles, rates and speeds have no direct feedthrough; what the identification finds of it
        is left out.
        """
        n, m = model.B.shape
        both = np.zeros((n + m, n + m))
        both[:n, :n], both[:n, n:] = model.A, model.B
        both = expm(both * model.dt)
        late = model.latency.astype(int)
        size = n + int(late.sum())
        A, B = np.zeros((size, size)), np.zeros((size, m))
        C = np.hstack([model.C, np.zeros((len(model.C), size - n))])
        A[:n, :n] = both[:n, :n]
        end = n
        for j, k in enumerate(late):
            effect = both[:n, n + j]
            if not k:
                B[:n, j] = effect
                continue
            # a shift register: the command enters at its last place and acts from the first
            A[:n, end] = effect
            A[range(end, end + k - 1), range(end + 1, end + k)] = 1.0
            B[end + k - 1, j] = 1.0
            end += k
        return cls(A, B, C, model.inputs, model.outputs, model.dt)

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
        *,
        law: np.ndarray,
        read: Mapping[str, np.ndarray],
        through: Mapping[str, float],
        reference: str | None = None,
        command: str | None = None,
    ) -> Plant:
        """The plant with a law of its own states around one input.

        .. math::
            x^c_{k+1} = F x^c_k + \\sum_i g_i y_i, \\qquad u = h x^c + \\sum_i d_i y_i

        Parameters
        ----------
        input_ : str
            the input that the law moves
        law : array, shape (c + 1, c)
            F, and h as the last row
        read : dict
            from the name of an output or of the reference to g, shape (c,)
        through : dict
            from the name of an output or of the reference to d
        reference : str, optional
            name of the new input that takes the place of ``input_``
        command : str, optional
            name of a new output: what the law moves the input to without the reference
        """
        n, c = len(self.A), law.shape[1]
        F, h = law[:-1], law[-1]
        b = self.column(input_)
        g, d = np.zeros((c, n)), np.zeros(n)
        for name, gain in read.items():
            if name != reference:
                g += np.outer(gain, self.row(name))
        for name, direct in through.items():
            if name != reference:
                d += direct * self.row(name)
        A = np.block([[self.A + np.outer(b, d), np.outer(b, h)], [g, F]])
        B = np.vstack([self.B, np.zeros((c, self.B.shape[1]))])
        C = np.hstack([self.C, np.zeros((len(self.C), c))])
        j = self.inputs.index(input_)
        inputs = list(self.inputs)
        if reference is None:
            B = np.delete(B, j, axis=1)
            del inputs[j]
        else:
            B[:, j] = np.concatenate(
                [b * through.get(reference, 0.0), read.get(reference, np.zeros(c))]
            )
            inputs[j] = reference
        outputs = list(self.outputs)
        if command is not None:
            C = np.vstack([C, np.concatenate([d, h])])
            outputs.append(command)
        return Plant(A, B, C, inputs, outputs, self.T)

    def steps(
        self,
        input_: str,
        outputs: Sequence[str],
        law: Callable[[int, np.ndarray], np.ndarray | float],
        loops: int,
        seconds: float,
    ) -> np.ndarray:
        """Outputs of many loops at once over time, shape (samples, outputs, loops).

        Parameters
        ----------
        input_ : str
            what the laws move
        outputs : list of str
        law : callable
            the commands of all loops, from the number of the sample and the outputs
        loops : int
        seconds : float
        """
        rows = np.array([self.row(name) for name in outputs])
        moves = np.column_stack([self.A, self.column(input_)])
        # the command is the last row of the state
        n, x = len(self.A), np.zeros((len(self.A) + 1, loops))
        y = np.empty((round(seconds / self.T), len(rows), loops))
        with np.errstate(over="ignore", invalid="ignore"):
            for k in range(len(y)):
                y[k] = rows @ x[:n]
                x[n] = law(k, y[k])
                x[:n] = moves @ x
        return y

    def slower(self, n: int) -> Plant:
        """The same with inputs held over ``n`` periods."""
        A, B = self.A, self.B
        for _ in range(n - 1):
            B = self.A @ B + self.B
            A = self.A @ A
        return Plant(A, B, self.C, self.inputs, self.outputs, n * self.T)

    def growth(self) -> float:
        """Real part of the least stable pole, 1/s, without the integrals (heading, altitude)."""
        poles = np.linalg.eigvals(self.A)
        rate = np.log(np.maximum(np.abs(poles), 1e-12)) / self.T
        return float(rate[np.abs(poles - 1.0) > 2e-6].max())
