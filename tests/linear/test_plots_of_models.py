"""Figures of linear models: the right points and curves."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from test_modes import LATERAL, model

from pathsim_jsbsim_blocks import Aircraft, ParameterError
from pathsim_jsbsim_blocks.linear import (
    LinearModel,
    bode,
    pole_map,
    root_locus,
    step_response,
)


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


def lag(latency=1):
    """2 / (0.5 s + 1) at 120 Hz."""
    return LinearModel(
        aircraft="lag", condition="", method="flown", A=[[-2.0]], B=[[4.0]], C=[[1.0]], D=[[0.0]],
        states=("p",), inputs=("aileron",), outputs=("p",), units={"p": "deg/s", "aileron": "norm"},
        x0=[0.0], u0=[0.0], y0=[0.0], dt=1 / 120, latency=[latency], kinks=[[0.0]], fit=[[0.0]],
    )  # fmt: skip


def test_a_pole_map_has_the_poles_and_names():
    figure = pole_map(model(LATERAL, ("beta", "p", "r", "phi")), title="a transport")
    crosses = [line for line in figure.axes[0].lines if line.get_marker() == "x"]
    drawn = {complex(x, y) for line in crosses for x, y in line.get_xydata()}
    for pole in np.roots(np.poly(LATERAL)):
        if pole.imag >= 0:
            assert min(abs(pole - x) for x in drawn) < 1e-9
    named = {text.get_text() for ax in figure.axes for text in ax.texts}
    assert {"Dutch roll", "roll", "spiral"} <= named


def test_a_bode_diagram_is_that_of_a_lag_with_its_delay():
    gain, phase = bode(lag(), "p", "aileron").axes
    omega, drawn = gain.lines[0].get_xydata().T
    np.testing.assert_allclose(drawn, np.abs(2 / (0.5j * omega + 1)), rtol=1e-9)
    omega, drawn = phase.lines[0].get_xydata().T
    # one and a half samples of latency and hold
    wanted = -np.degrees(np.arctan(0.5 * omega) + omega * 1.5 / 120)
    np.testing.assert_allclose(drawn, wanted, atol=1e-6)
    assert gain.get_ylabel() == "gain [deg/s/1]"


def test_simulate_holds_and_delays():
    u = np.zeros((4, 1))
    u[0] = 1.0
    step = 2 * (1 - np.exp(-2 / 120))
    np.testing.assert_allclose(
        lag().simulate(u)[:, 0], [0, 0, step, step * np.exp(-2 / 120), step * np.exp(-4 / 120)]
    )
    # nothing has arrived yet
    assert not lag(latency=6).simulate(u).any()


@pytest.mark.parametrize("u", [np.zeros(600), np.zeros((4, 600)), {"aileron": 0.1}, [["x"]]])
def test_simulate_refuses_other_shapes_in_one_line(u):
    with pytest.raises(ParameterError, match=r"1 columns \(aileron\)") as caught:
        lag().simulate(u)
    assert len(str(caught.value)) < 250
    if isinstance(u, np.ndarray):
        assert f"of shape {u.shape}" in str(caught.value)


def test_what_is_no_linear_model_is_refused():
    plane = Aircraft("c172p", altitude=5000, speed=90)
    for draw in (
        lambda: pole_map(plane),
        lambda: pole_map([lag(), lag()]),
        lambda: bode(plane, "theta", "elevator"),
        lambda: step_response(plane, plane, "elevator", "theta", 0.01),
        lambda: root_locus([plane], [90.0]),
    ):
        with pytest.raises(ParameterError, match=r"a LinearModel is needed, .* not "):
            draw()


def test_an_unknown_name_is_refused():
    with pytest.raises(ParameterError, match="no 'ailern'; did you mean 'aileron'"):
        bode(lag(), "p", "ailern")


def test_a_step_is_drawn_as_it_is_flown():
    # u0 and u of the model are those of the aircraft, whose flight is not touched
    plane, twin = (Aircraft("737", altitude=5000, speed=260, gear=0.0) for _ in range(2))
    built = plane.linear_model("algebraic", ["elevator"])
    (ax,) = step_response(built, plane, "elevator", "q", 0.01, duration=3.0).axes
    drawn = {line.get_label(): line.get_xydata() for line in ax.lines}
    flown = [twin.outputs[Aircraft.output_port_labels["q"]]]
    for k in range(1, 361):
        y = twin.advance(k, [0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        flown.append(y[Aircraft.output_port_labels["q"]])
    np.testing.assert_array_equal(drawn["aircraft"][:, 1], flown)
    np.testing.assert_allclose(drawn["aircraft"][:, 0], np.arange(361) / 120)
    apart = np.abs(drawn["linear model"][:, 1] - flown).max()
    assert 0.0 < apart < 0.05 * np.ptp(flown)
    assert plane.samples == 0
    with pytest.raises(ParameterError, match="did you mean 'elevator'"):
        step_response(built, plane, "elevater", "q", 0.01)


def test_a_root_locus_has_the_poles_of_each_model():
    models = [model([[-k]], ("p",)) for k in (1.0, 2.0, 4.0)]
    figure = root_locus(models, [100, 200, 400], "airspeed [kt]")
    (points, *_) = figure.axes[0].collections
    assert sorted(points.get_offsets()[:, 0].tolist()) == [-4.0, -2.0, -1.0]
    assert points.get_array().tolist() == [100, 200, 400]
    assert figure.axes[-1].get_ylabel() == "airspeed [kt]"
    with pytest.raises(ParameterError, match="one number for each of the 3 models"):
        root_locus(models, [1, 2])
    with pytest.raises(ParameterError, match="values must be"):
        root_locus(models, ["a", 1, 2])
