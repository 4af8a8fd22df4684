"""Margins of loops against python-control and closed forms."""

import sys
from dataclasses import dataclass, replace

import control
import numpy as np
import pytest
from test_plots_of_models import lag

from pathsim_jsbsim_blocks import (
    Aircraft,
    Autopilot,
    CourseHold,
    DiscretePID,
    HeadingHold,
    ParameterError,
    PitchHold,
    RollHold,
)
from pathsim_jsbsim_blocks.errors import MissingExtraError
from pathsim_jsbsim_blocks.linear import margins
from pathsim_jsbsim_blocks.linear.stability import loop_margins
from pathsim_jsbsim_blocks.sampling import SampledLaw

T = 1 / 120

OMEGA = np.geomspace(0.005, 500.0, 4000)

LOOPS = {
    "third order": ([4.0], [1.0, 3.0, 3.0, 1.0]),
    "integrator with lags": ([3.0], [0.02, 0.3, 1.0, 0.0]),
    # unstable without the loop: the gain may also fall too low
    "unstable": ([6.0, 12.0, 6.0], [0.001, 0.11, 0.89, -1.0, 0.0]),
}


@pytest.mark.parametrize("name", LOOPS)
def test_margins_are_those_of_python_control(name):
    loop = control.tf(*LOOPS[name])
    found = loop_margins(OMEGA, loop(1j * OMEGA)[None])
    one = margins(loop)
    gain, phase, _, _, crossover, _ = control.stability_margins(loop, returnall=True)
    if len(gain):
        assert found.gain[0] == pytest.approx(np.abs(20 * np.log10(gain)).min(), abs=0.05)
    else:
        assert found.gain[0] == np.inf
    assert found.phase[0] == pytest.approx(np.abs(phase).min(), abs=0.1)
    assert found.crossover[0] == pytest.approx(crossover.max(), rel=1e-3)
    assert one.phase_margin == pytest.approx(found.phase[0], abs=0.1)
    assert abs(one.gain_margin) == pytest.approx(found.gain[0], abs=0.05)
    assert one.Ms == pytest.approx(found.Ms[0], rel=1e-3)


def test_sensitivity_of_a_delayed_integrator():
    # |1 + L| is least near the crossover; a delay of 50 ms turns L by 0.05 omega
    a, b = 2.0, 5.0
    L = np.array([a / (1j * OMEGA), b / (1j * OMEGA)])
    found = loop_margins(OMEGA, L)
    assert found.Ms == pytest.approx([1.0, 1.0], abs=1e-3)
    for i, gain in enumerate((a, b)):
        late = gain * np.exp(-0.05j * OMEGA) / (1j * OMEGA)
        assert found.Ms_delayed[i] == pytest.approx(np.max(1 / np.abs(1 + late)))
        assert found.crossover[i] == pytest.approx(gain, rel=1e-3)
        assert found.phase[i] == pytest.approx(90.0, abs=0.01)


def test_a_loop_without_crossover_has_no_margins():
    found = loop_margins(OMEGA, np.full((1, len(OMEGA)), 0.1 + 0j))
    assert (found.crossover[0], found.gain[0], found.phase[0]) == (0.0, np.inf, np.inf)


@dataclass(eq=False, repr=False)
class Roller(SampledLaw):
    """Aileron from roll rate, proportional and integral."""

    T: float = T
    Kp: float = 3.0
    Ki: float = 8.0

    measured = ("p",)
    input_port_labels = {"p": 0}
    output_port_labels = {"aileron": 0}

    def initial_state(self):
        return (0.0,)

    def law(self, u, state):
        return [-self.Kp * u[0] - state[0]], (state[0] + self.Ki * self.T * u[0],)


@pytest.mark.parametrize("late", [0, 1, 6])
def test_a_sampled_loop_has_the_margins_of_its_difference_equation(late):
    z = control.tf([1.0, 0.0], [1.0], T)
    law = Roller.Kp + Roller.Ki * T / (z - 1)
    loop = control.c2d(control.tf([2.0], [0.5, 1.0]), T, "zoh") * law / z**late
    gains, (phase,), _, at_phases, (at_gain,), _ = control.stability_margins(loop, returnall=True)
    # without a latency the phase crosses at pi / T, where z = -1; its polynomials miss that
    crossings = [x for x in zip(gains, at_phases, strict=True) if x[1] > 1e-3]
    gain, at_phase = min(crossings, default=(1 / abs(loop(-1.0)), np.pi / T))
    omega = np.geomspace(1e-2, np.pi / T, 4000)
    disk, disk_gain, disk_phase = control.disk_margins(control.ss(loop), omega)
    labels = {"inputs": "p", "outputs": "aileron"}
    named = control.tf(-law, **labels)
    for own in (margins(lag(late), Roller()), margins(lag(late), named)):
        assert own.gain_margin == pytest.approx(20 * np.log10(gain), abs=0.01)
        assert own.phase_crossover == pytest.approx(at_phase, rel=1e-3)
        assert own.phase_margin == pytest.approx(phase, abs=0.01)
        assert own.crossover == pytest.approx(at_gain, rel=1e-3)
        assert own.delay_margin == pytest.approx(np.radians(phase) / at_gain, rel=1e-3)
        assert own.disk_margin == pytest.approx(disk, rel=1e-3)
        assert own.disk_gain_margin == pytest.approx(disk_gain, rel=1e-2)
        assert own.disk_phase_margin == pytest.approx(disk_phase, rel=1e-3)


def test_a_closed_loop_is_within():
    # L / (1 + inner), as it is written out
    own = margins(lag(), control.ss([], [], [], [[-1.0]]), Roller())
    inner = margins(lag(), Roller()).response
    alone = margins(lag(), control.ss([], [], [], [[-1.0]])).response
    assert own.response == pytest.approx(alone / (1 + inner))


def late_lag(pole):
    """The aircraft ``lag(6)`` with another pole, sampled."""
    return control.c2d(control.tf([4.0], [1.0, -pole]), T, "zoh") * control.tf(
        [1], [1, *[0] * 6], T
    )


def is_stable(loop):
    return abs(control.feedback(loop).poles()).max() < 1.0


@pytest.mark.parametrize("pole", [-2.0, 0.5])
@pytest.mark.parametrize("gain", [-2.0, -0.3, 0.1, 0.2, 8.0, 12.0])
def test_a_loop_is_stable_where_its_poles_are(pole, gain):
    aircraft, late = replace(lag(6), A=[[pole]]), late_lag(pole)
    stable = is_stable(gain * late)
    law = {"inputs": "p", "outputs": "aileron"}
    quick = control.tf([-gain * 1e6], [1.0, 1e6], **law)
    for own in (control.ss([], [], [], [[-gain]], **law), quick):
        assert margins(aircraft, own).stable == stable
    assert margins(gain * late).stable == stable
    assert margins(control.frd([0.5, 0.3, 0.1], [1.0, 2.0, 3.0])).stable is None


@pytest.mark.parametrize("pole", [-2.0, 0.5])
@pytest.mark.parametrize("inner", [-0.3, 0.5, 12.0])
@pytest.mark.parametrize("outer", [-11.5, -0.3, 0.5])
def test_a_loop_around_another_is_stable_where_the_poles_of_both_are(pole, inner, outer):
    laws = (control.ss([], [], [], [[-x]], inputs="p", outputs="aileron") for x in (outer, inner))
    own = margins(replace(lag(6), A=[[pole]]), *laws)
    assert own.stable == is_stable((inner + outer) * late_lag(pole))


def two():
    """A model of which one input and one output are not what a law has."""
    return Aircraft("c172p", altitude=5000, speed=90).linear_model(
        "algebraic", outputs=["p", "r", "phi", "psi", "lat", "lon"]
    )


def test_positions_that_nothing_moves_are_stable():
    # the aircraft's latitude, longitude and heading are integrators beside the loop
    model = two()
    damper = -0.05 * control.ss(model.select(["aileron"], ["p"]).to_control())
    assert margins(-damper).stable
    assert not margins(40.0 * damper).stable


def test_an_unstable_law_is_counted():
    # u+ = 1.01 u - k p: the loop is stable where the poles of its difference equation are
    own = control.ss([[1.01]], [[1.0]], [[-0.02]], [[-1.0]], T, inputs="p", outputs="aileron")
    loop = control.c2d(control.tf([4.0], [1.0, 2.0]), T, "zoh") * control.tf([1], [1, 0], T) * -own
    for gain in (0.1, 1.0, 30.0):
        scaled = control.ss(
            own.A, own.B, gain * own.C, gain * own.D, T, inputs="p", outputs="aileron"
        )
        assert margins(lag(), scaled).stable == is_stable(gain * loop)


@pytest.mark.parametrize("gain", [0.01, 1e4])
def test_a_crossover_far_from_the_poles_has_a_margin(gain):
    loop = control.tf([gain], [1.0, 1.0, 0.0])
    assert margins(loop).phase_margin == pytest.approx(control.margin(loop)[1], abs=0.01)
    assert margins(loop).disk_margin == pytest.approx(
        control.disk_margins(loop, margins(loop).crossover * np.geomspace(0.3, 3, 1500))[0],
        rel=1e-2,
    )


def test_a_response_in_any_order_has_the_same_margins():
    omega = np.geomspace(0.1, 10.0, 100)
    L = control.tf(*LOOPS["third order"])(1j * omega)
    backwards = margins(control.frd(L[::-1], omega[::-1]))
    assert backwards.gain_margin == margins(control.frd(L, omega)).gain_margin


@pytest.mark.parametrize(
    ("model", "laws", "parameter"),
    [
        (two, [DiscretePID()], "law"),
        # standing still, it has no course over the ground
        (two, [CourseHold("c172p")], "law"),
        (two, [Autopilot("c172p")], "law"),
        (two, [PitchHold("c172p")], "law"),
        (two, [control.ss([], [], [], [[1.0]], inputs="P", outputs="aileron", name="P")], "law"),
        # its reference is far from the trim
        (two, [HeadingHold("c172p", psi_ref=90.0)], "law"),
        # the inner loop is closed twice
        (two, [HeadingHold("c172p"), RollHold("c172p")], "closed"),
        (two, [HeadingHold("c172p"), HeadingHold("c172p")], "closed"),
        (lag, [Roller(T=1 / 60)], "law"),
        (lag, [control.tf([1.0], [1.0, 0.0], 1 / 50)], "law"),
        (lag, ["pitch"], "law"),
        (lag, [None], "plant"),
    ],
)
def test_what_closes_no_loop_is_refused(model, laws, parameter):
    with pytest.raises(ParameterError) as refused:
        margins(model(), *laws)
    assert refused.value.parameter == parameter


def test_only_laws_of_python_control_need_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "control", None)
    assert margins(lag(), Roller()).gain_margin > 0
    with pytest.raises(MissingExtraError, match="pip install") as missing:
        margins(lag(), "pitch")
    assert missing.value.extra == "analysis"
