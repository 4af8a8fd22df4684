"""Margins of whole systems against the poles of their closed loops."""

import control
import numpy as np
import pytest
from how_many import first

from pathsim_jsbsim_blocks.linear import bode, margins

s = control.tf("s")


def z(T):
    return control.tf([1.0, 0.0], [1.0], T)


def is_unstable(loop, factor):
    """Whether the loop with its response times a complex factor has poles on the wrong side."""
    num, den = (np.atleast_1d(np.squeeze(x[0][0])) for x in (loop.num, loop.den))
    poles = np.roots(np.polyadd(den, factor * num))
    # a pole of a loop at its margin is found to some 1e-9
    if loop.isdtime(strict=True):
        return (np.abs(poles) > 1 + 1e-9).any()
    return (poles.real > 1e-9 * np.abs(poles)).any()


def check(loop):
    """Compare with closed-loop poles at gains and phases within the margins and beyond."""
    own = margins(loop)
    assert own.stable
    assert not is_unstable(loop, 1.0)
    gain = own.gain_margin
    nearest = min(abs(gain), 80.0)
    for change in np.linspace(-0.999, 0.999, 99) * nearest:
        assert not is_unstable(loop, 10 ** (change / 20))
    if np.isfinite(gain):
        assert is_unstable(loop, 10 ** ((gain + 0.02 * np.sign(gain)) / 20))
    phase = own.phase_margin
    for angle in np.linspace(-0.999, 0.999, 99) * min(abs(phase), 180.0):
        assert not is_unstable(loop, np.exp(1j * np.radians(angle)))
    if np.isfinite(phase):
        assert is_unstable(loop, np.exp(-1j * np.radians(phase + 0.05 * np.sign(phase))))
    T = loop.dt if loop.isdtime(strict=True) else 0
    dense = np.unique([*own.omega, *np.geomspace(own.omega[0], own.omega[-1], 20_000)])
    S = 1 / (1 + loop(np.exp(1j * dense * T) if T else 1j * dense))
    assert own.Ms == pytest.approx(np.abs(S).max(), rel=1e-3)
    assert own.disk_margin == pytest.approx(1 / np.abs(S - 0.5).max(), rel=1e-3)
    if np.isfinite(own.delay_margin):
        # the delayed loop passes through -1, at a frequency of gain 1
        w = dense[np.abs(np.abs(loop(np.exp(1j * dense * T) if T else 1j * dense)) - 1) < 0.02]
        late = loop(np.exp(1j * w * T) if T else 1j * w) * np.exp(-1j * w * own.delay_margin)
        assert np.abs(1 + late).min() < 0.05
    return own


NAMED = {
    "mode of damping 0.001": (
        (s**2 + 0.2 * s + 25) / (s * (s + 1) * (s**2 + 0.01 * s + 25)), 2.30),
    "mode of damping 0.0001": (
        (s**2 + 0.02 * s + 25) / (s * (s + 1) * (s**2 + 0.001 * s + 25)), None),
    "undamped mode of 0.1 rad/s": (0.005 * s * (s + 0.1) / ((s + 1) * (s**2 + 0.01)), np.inf),
    "least gain": (6 / ((s - 1) * (0.1 * s + 1)), -20 * np.log10(6)),
    "gain 2 at infinity": ((1 - 0.5 * s) / (s + 1), 20 * np.log10(2)),
    "0.5 / (z - 1), T = 0.02": (0.5 / (z(0.02) - 1), 20 * np.log10(4)),
    "0.5 / (z - 1), T = 1": (0.5 / (z(1.0) - 1), 20 * np.log10(4)),
    "0.25 / (z + 0.7)": (0.25 / (z(0.02) + 0.7), 20 * np.log10(0.3 / 0.25)),
    "0.5 / (z - 1), no period": (0.5 / (z(True) - 1), 20 * np.log10(4)),
    "least gain, sampled": (0.4 / (z(0.1) - 1.2), -20 * np.log10(2)),
}  # fmt: skip


@pytest.mark.parametrize("name", NAMED)
def test_margins_of_a_system_are_where_its_poles_cross(name):
    loop, gain = NAMED[name]
    own = check(loop)
    if gain is not None:
        assert own.gain_margin == pytest.approx(gain, abs=0.005)


def random_loop(rng, sampled):
    """A loop of up to 5 states with modes of any damping, some unstable, stable when closed."""
    while True:
        roots = {"poles": [], "zeros": []}
        count = rng.integers(1, 5)
        for kind, number in (("poles", count), ("zeros", rng.integers(0, count + 1))):
            while len(roots[kind]) < number:
                w, damping = 10 ** rng.uniform(-1, 1.5), 10 ** rng.uniform(-3, 0)
                if number - len(roots[kind]) > 1 and rng.random() < 0.5:
                    root = w * (-damping + 1j * np.sqrt(1 - damping**2))
                    roots[kind] += [root, root.conjugate()]
                else:
                    roots[kind].append(rng.choice([-w, -w, -w, 0.0 if kind == "poles" else w, w]))
        T, poles, zeros = None, np.array(roots["poles"]), np.array(roots["zeros"])
        if sampled:
            T = 10 ** rng.uniform(-2, 0)
            poles, zeros = np.exp(poles * T), np.exp(zeros * T)
            if rng.random() < 0.4:
                poles = np.append(poles, rng.uniform(-0.98, -0.2))
        num, den = (np.atleast_1d(np.real(np.poly(x))) for x in (zeros, poles))
        for gain in rng.permutation([*np.geomspace(1e-3, 1e3, 40), *-np.geomspace(1e-3, 1e3, 20)]):
            loop = control.tf(gain * num, den, *([T] if sampled else []))
            # the gain at infinity leaves as many poles in the closed loop
            leading = np.polyadd(den, gain * num)[0]
            if leading > 0.1 and not is_unstable(loop, 1.0):
                return loop


@pytest.mark.parametrize(("seed", "count", "least"), first([(5, 4, 0), (70, 30, 3)]))
@pytest.mark.parametrize("sampled", [False, True])
def test_margins_of_random_systems(sampled, seed, count, least):
    rng = np.random.default_rng(seed)
    reduced = sum(check(random_loop(rng, sampled)).gain_margin < 0 for _ in range(count))
    assert sampled or reduced >= least  # of some the gain may only fall


@pytest.mark.parametrize("gain", [0.5, -0.5, 0.0])
def test_a_loop_without_dynamics_has_a_gain_margin_if_it_is_negative(gain):
    own = margins(control.tf([gain], [1.0]))
    assert own.gain_margin == (pytest.approx(20 * np.log10(2)) if gain < 0 else np.inf)
    assert own.Ms == pytest.approx(1 / (1 + gain))


@pytest.mark.parametrize("name", ["least gain", "gain 2 at infinity"])
def test_the_bode_diagram_names_a_crossover_at_the_ends(name):
    own = margins(NAMED[name][0])
    assert own.phase_crossover in (0.0, np.inf)
    axes = bode(own).axes[0]
    assert f"at {own.phase_crossover:.3g} rad/s" in axes.get_title(loc="right")
