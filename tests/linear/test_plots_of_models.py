"""Figures of linear models: the right points and curves."""

import control
import numpy as np
import pytest
from test_modes import LATERAL, model

from pathsim_jsbsim_blocks import Aircraft, ParameterError
from pathsim_jsbsim_blocks.linear import LinearModel, bode, margins, pole_map, step_response


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


@pytest.mark.parametrize("gain", [20.0, 50.0])
def test_the_bode_diagram_of_a_loop_shows_its_margins(gain):
    # the second loop is unstable
    loop = margins(lag(), control.ss([], [], [], [[-gain]]))
    upper, lower = bode(loop).axes
    (_, stem), (_, more) = ([*ax.lines[:2]] for ax in (upper, lower))
    assert stem.get_ydata() == pytest.approx([0.0, -loop.gain_margin])
    assert stem.get_xdata() == pytest.approx([loop.phase_crossover] * 2)
    assert more.get_ydata() == pytest.approx([-180.0, loop.phase_margin - 180.0])
    assert more.get_xdata() == pytest.approx([loop.crossover] * 2)
    # the stems end on the curves
    for ax, line in ((upper, stem), (lower, more)):
        at = np.interp(line.get_xdata()[1], *ax.lines[2].get_xydata().T)
        assert at == pytest.approx(line.get_ydata()[1], abs=0.5)


def test_simulate_holds_and_delays():
    u = np.zeros((4, 1))
    u[0] = 1.0
    step = 2 * (1 - np.exp(-2 / 120))
    np.testing.assert_allclose(
        lag().simulate(u)[:, 0], [0, 0, step, step * np.exp(-2 / 120), step * np.exp(-4 / 120)]
    )
    # nothing has arrived yet
    assert not lag(latency=6).simulate(u).any()


def test_what_is_no_linear_model_is_refused():
    plane = Aircraft("c172p", altitude=5000, speed=90)
    for draw in (
        lambda: pole_map(plane),
        lambda: pole_map([lag(), lag()]),
        lambda: step_response(plane, plane, "elevator", "theta", 0.01),
    ):
        with pytest.raises(ParameterError) as error:
            draw()
        assert error.value.parameter == "model"


def test_bode_refuses_what_is_no_loop():
    for other, text in ((lag(), "control.bode_plot"), (1.0, r"margins\(\)")):
        with pytest.raises(ParameterError, match=text) as refused:
            bode(other)
        assert (refused.value.parameter, refused.value.value) == ("loop", other)


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
    with pytest.raises(ParameterError) as error:
        step_response(built, plane, "elevater", "q", 0.01)
    assert (error.value.parameter, error.value.value) == ("inputs", ["elevater"])
    assert "'elevator'" in str(error.value)


def test_a_pole_map_of_a_sweep_has_the_poles_of_each_model():
    figure = pole_map(*(model([[-k]], ("p",)) for k in (1.0, 2.0, 4.0)))
    crosses = [line for line in figure.axes[0].lines if line.get_marker() == "x"]
    assert [line.get_xdata().tolist() for line in crosses] == [[-1.0], [-2.0], [-4.0]]
    assert len({line.get_color() for line in crosses}) == 3
