"""The continuous equivalent of sampled laws: their z-transforms at z = (2 + s T) / (2 - s T)."""

from typing import NamedTuple

import numpy as np
import pytest
from pathsim.exceptions import LinearizationError

from pathsim_jsbsim_blocks._core.continuous import at_limit, continuous_equivalent

T = 0.02


class Memory(NamedTuple):
    total: float
    unused: tuple
    name: str


def response(law, u, state, s):
    A, B, C, D = continuous_equivalent(law, u, state, T, "law")
    return C @ np.linalg.solve(s * np.eye(len(A)) - A, B) + D


@pytest.mark.parametrize("s", [0.5j, 20j, -1.0 + 3j])
def test_a_sum_and_a_difference(s):
    z = (2 + s * T) / (2 - s * T)

    def law(u, state):
        last, memory = state
        total = memory.total + T * u[0]
        return [memory.total, (u[1] - last) / T], (
            u[1],
            Memory(total, memory.unused, memory.name),
        )

    found = response(law, [3.0, -2.0], (1.0, Memory(5.0, (), "on")), s)
    assert found == pytest.approx(np.diag([T / (z - 1), (z - 1) / (z * T)]), rel=1e-6)


@pytest.mark.parametrize("s", [0.5j, 20j])
def test_two_lags_in_series(s):
    # the first state is not shown, and the second not moved, but through the other
    z = (2 + s * T) / (2 - s * T)

    def law(u, state):
        a, b = state
        return [b], (0.9 * a + 0.1 * u[0], 0.8 * b + 0.2 * a)

    A, *_ = continuous_equivalent(law, [0.0], (0.0, 0.0), T, "law")
    assert sorted(np.linalg.eigvals(A)) == pytest.approx([-2 / T * 0.2 / 1.8, -2 / T * 0.1 / 1.9])
    found = response(law, [0.0], (0.0, 0.0), s)
    assert found == pytest.approx(np.array([[0.02 / ((z - 0.9) * (z - 0.8))]]), rel=1e-6)


def test_states_that_nothing_moves_or_shows_are_left_out():
    def law(u, state):
        moved, shown = state
        return [2.0 * u[0] + shown], (moved + u[0], shown)

    A, _, _, D = continuous_equivalent(law, [1.0], (0.0, 0.0), T, "law")
    assert A.shape == (0, 0)
    assert pytest.approx(np.array([[2.0]])) == D


@pytest.mark.parametrize(
    ("law", "at", "slope"),
    [
        (lambda x: x * x, 3.0, 6.0),
        (lambda x: x * x, 1e6, 2e6),
        (lambda x: max(x, 0.0), 0.0, 0.0),  # 0 to one side and 1 to the other
        (lambda x: max(x, 0.5 * x), 0.0, 0.0),
        (lambda x: max(x, 0.9 * x), 0.0, 0.95),  # within a fifth of each other
        (lambda x: float(x != 0.0), 0.0, 0.0),
        (lambda x: float(x > 0.0), 0.0, 0.0),
        (lambda x: min(x, 2.0), 2.5, 0.0),
        (lambda x: min(x, 2.0), 1.5, 1.0),
    ],
)
def test_smooth_laws_have_slopes_and_switches_none(law, at, slope):
    _, _, _, D = continuous_equivalent(lambda u, x: ([law(u[0])], x), [at], (), T, "law")
    assert pytest.approx(np.array([[slope]]), rel=1e-6, abs=1e-9) == D


def test_what_has_no_equivalent_is_an_error():
    # a pole at z = -1 is at infinity in s
    with pytest.raises(LinearizationError, match="my law has no continuous equivalent"):
        continuous_equivalent(lambda u, x: ([x], u[0] - x), [1.0], 1.0, T, "my law")


@pytest.mark.parametrize(
    ("act", "at", "idle"),
    [
        (lambda x: min(max(x, -2.0), 2.0), 2.5, True),
        (lambda x: min(max(x, -2.0), 2.0), -300.0, True),
        (lambda x: 0.5 * round(x / 0.5), 0.1, True),  # a quantum
        (lambda x: min(max(x, -2.0), 2.0), 1.5, False),
        (lambda x: float(x != 0.0), 0.0, False),  # a switch
        (lambda x: 3.0, 0.0, False),
        (lambda x: x * x, 0.0, False),
    ],
)
def test_a_law_at_its_limit_acts_farther_off(act, at, idle):
    def law(u, state):
        return [act(u[0]) + u[1], u[1]], state

    model, ports = continuous_equivalent(law, [at, 0.0], (), T, "law"), {"a": 0, "b": 1}
    assert at_limit(law, [at, 0.0], (), model, ports, ports) == (["a"] if idle else [])
    # with nothing beside it the output stands still
    alone = lambda u, state: ([act(u[0])], state)  # noqa: E731
    model = continuous_equivalent(alone, [at], (), T, "law")
    assert at_limit(alone, [at], (), model, {}, {"y": 0}) == (["y"] if idle else [])
