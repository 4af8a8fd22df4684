"""The linear equivalents of a sampled law about its operating point, sampled and continuous."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pathsim.exceptions import LinearizationError

# step of a derivative, relative to a value and at least this: within a ramp's limit per sample
_STEP = 1e-6

# relative difference of two slopes beyond which a law is not smooth
_BROKEN = 0.2

# changes of an input with which a limit is searched for, in its unit; none leads to 0: a switch
_FAR = [sign * 10.0**k for k in range(-1, 5) for sign in (3.0, -3.0)]

# samples after which a law's state is complete
_ENGAGING = 4

Law = Callable[[list[float], Any], tuple[list[float], Any]]
Ports = dict[str, int]
Matrices = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def sampled_equivalent(law: Law, u: list[float], state: Any, name: str) -> Matrices:
    """A, B, C, D of a law y[k], x[k+1] = f(u[k], x[k]), as difference equations.

    Switches (inputs compared with 0) keep their values: they have no slope.

    Raises
    ------
    LinearizationError
        if the law has no linear equivalent
    """
    x, rebuild = _flat(state)
    for _ in range(_ENGAGING):
        successor = law(u, state)[1]
        x_next, x_rebuild = _flat(successor)
        if len(x_next) == len(x):
            break
        # the state of a law that has just engaged is not complete
        state, x, rebuild = successor, x_next, x_rebuild
    else:
        raise _no_equivalent(name)

    def step(values: np.ndarray) -> np.ndarray:
        y, successor = law(values[: len(u)].tolist(), rebuild(values[len(u) :].tolist()))
        return np.array([*y, *_flat(successor)[0]], dtype=float)

    point = np.array([*u, *x], dtype=float)
    jacobian = np.array([_slope(step, point, i) for i in range(len(point))]).T
    if not np.all(np.isfinite(jacobian)):
        raise _no_equivalent(name)
    p, m = len(step(point)) - len(x), len(u)
    C, D = jacobian[:p, m:], jacobian[:p, :m]
    A, B = jacobian[p:, m:], jacobian[p:, :m]
    relevant = _that_matter(A, B, C)
    return A[np.ix_(relevant, relevant)], B[relevant], C[:, relevant], D


def continuous_equivalent(law: Law, u: list[float], state: Any, T: float, name: str) -> Matrices:
    """A, B, C, D of a law's continuous equivalent, by Tustin's transformation.

    .. math::
        s = \\frac{2}{T} \\frac{z - 1}{z + 1}

    Up to a frequency omega gain and phase are those of the law within (omega T)^2 / 12. The hold
    between samples is not part of it.

    Raises
    ------
    LinearizationError
        if the law has no continuous equivalent
    """
    A, B, C, D = sampled_equivalent(law, u, state, name)
    one = np.eye(len(A))
    if np.any(np.abs(np.linalg.eigvals(A + one)) < 1e-9):
        raise _no_equivalent(name)
    inverse = np.linalg.inv(one + A)
    return (
        2.0 / T * inverse @ (A - one),
        4.0 / T * inverse @ inverse @ B,
        C,
        D - C @ inverse @ B,
    )


def _no_equivalent(name: str) -> LinearizationError:
    return LinearizationError(f"{name} has no continuous equivalent in this state")


def at_limit(
    law: Law, u: list[float], state: Any, model: Matrices, inputs: Ports, outputs: Ports
) -> list[str]:
    """Inputs and outputs that respond only to large changes, because of a ramp or a limit."""
    _, B, C, D = model

    def after(i: int, distance: float) -> np.ndarray:
        v = [x + distance * (j == i) for j, x in enumerate(u)]
        # the second sample: a rate limit has no effect on the first
        return np.array(law(v, law(v, state)[1])[0])

    names = []
    for i in range(len(u)):
        output = after(i, 0.0)
        # no limit if the smallest step has an effect: a switch acts immediately
        hidden = np.any([after(i, x) != output for x in _FAR], 0) & (after(i, _STEP) == output)
        idle = hidden.any() and not (B[:, i].any() or D[:, i].any())
        names += [n for n, k in inputs.items() if k == i and idle]
        names += [n for n, k in outputs.items() if hidden[k] and not (C[k].any() or D[k].any())]
    return list(dict.fromkeys(names))


def _slope(step: Callable[[np.ndarray], np.ndarray], point: np.ndarray, i: int) -> np.ndarray:
    """Derivatives with respect to one value; 0 for a switch."""

    def beside(distance: float) -> np.ndarray:
        values = point.copy()
        values[i] += distance
        return step(values)

    h = _STEP * max(1.0, abs(point[i]))
    high, middle, low = beside(h), step(point), beside(-h)
    if not high.shape == middle.shape == low.shape:
        # a switch that resets the law's state
        return np.zeros_like(middle)
    wide = (high - low) / (2 * h)
    narrow = (beside(h / 2) - beside(-h / 2)) / h
    smooth = np.abs(wide - narrow) <= _BROKEN * np.maximum(np.abs(wide), np.abs(narrow)) + 1e-9
    # equal jumps to both sides cancel in a central difference
    up, down = high - middle, middle - low
    smooth &= np.abs(up - down) <= _BROKEN * (np.abs(up) + np.abs(down)) + 1e-9 * h
    return np.where(smooth, wide, 0.0)


def _that_matter(A: np.ndarray, B: np.ndarray, C: np.ndarray) -> list[int]:
    """Structurally controllable and observable states, directly or through others."""

    def reached(edges: np.ndarray, first: np.ndarray) -> np.ndarray:
        nodes = first.copy()
        for _ in range(len(nodes)):
            nodes |= edges @ nodes
        return nodes

    links = A != 0.0
    controllable = reached(links, np.any(B != 0.0, axis=1))
    observable = reached(links.T, np.any(C != 0.0, axis=0))
    return np.flatnonzero(controllable & observable).tolist()


def _flat(state: Any) -> tuple[list[float], Callable[[list[float]], Any]]:
    """The floats of a state of nested tuples, and a function that rebuilds it from others."""
    if isinstance(state, tuple):
        parts = [_flat(part) for part in state]
        sizes = [len(values) for values, _ in parts]

        def rebuild(values: list[float]) -> Any:
            ends = np.cumsum(sizes)
            rebuilt = [
                build(values[end - size : end])
                for (_, build), size, end in zip(parts, sizes, ends, strict=True)
            ]
            return type(state)(*rebuilt) if hasattr(state, "_fields") else tuple(rebuilt)

        return [x for values, _ in parts for x in values], rebuild
    if isinstance(state, float):
        return [state], lambda values: values[0]
    return [], lambda values: state
