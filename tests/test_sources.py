"""Test inputs: shape, edges in adaptive runs, editing while running, bad input."""

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Integrator, Scope
from pathsim.solvers import RKBS32, RKCK54

from pathsim_jsbsim_blocks import DoubletSource, MultistepSource, ParameterError, RampSource

pytestmark = pytest.mark.matrix

SOURCES = {
    "doublet": lambda: DoubletSource(amplitude=2.0, start=0.5, width=0.7),
    "doublet with gap": lambda: DoubletSource(start=0.5, width=0.7, gap=0.31, polarity=-1),
    "3-2-1-1": lambda: MultistepSource(start=0.25, step=0.3),
    "ramp": lambda: RampSource(final=3.0, start=0.4, rise_time=1.1),
    "ramp with hold": lambda: RampSource(start=0.4, rise_time=1.1, hold=0.6),
}


def record(source, duration=3.0, **options):
    scope = Scope()
    sim = Simulation(
        [source, scope], [Connection(source, scope)], **{"dt": 0.01, "log": False, **options}
    )
    sim.run(duration)
    time, data = scope.read()
    return time, data[0]


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        (
            DoubletSource(amplitude=0.1, start=1.0, width=0.5, gap=0.25, polarity=-1),
            {0.2: 0.0, 1.25: -0.1, 1.6: 0.0, 2.0: 0.1, 2.5: 0.0},
        ),
        (DoubletSource(amplitude=1.0, start=1.0, width=0.5), {0.99: 0, 1.49: 1, 1.5: -1, 2.0: 0}),
        # a 3-2-1-1 by default
        (
            MultistepSource(amplitude=0.5, start=0.0, step=0.2),
            {0.59: 0.5, 0.6: -0.5, 0.99: -0.5, 1.0: 0.5, 1.2: -0.5, 1.4: 0.0},
        ),
        (
            MultistepSource(2.0, start=1.0, widths=[0.5, 0.25, 1.0], signs=[-1, 0, 0.5]),
            {0.5: 0.0, 1.2: -2.0, 1.6: 0.0, 2.0: 1.0, 2.9: 0.0},
        ),
        (
            RampSource(final=-2.0, start=0.5, rise_time=1.5, hold=0.4),
            {0.5: 0.0, 0.8: -0.4, 1.25: -1.0, 2.0: -2.0, 2.39: -2.0, 2.41: 0.0},
        ),
    ],
)
def test_a_source_has_its_shape(source, expected):
    time, y = record(source)
    found = {t: y[abs(time - t).argmin()] for t in expected}
    assert found == pytest.approx(expected, abs=1e-12)
    assert y[0] == 0.0 or source.start == 0.0
    assert len(source) == 0  # nothing passes through


def test_ramp_does_not_overshoot_within_the_step_that_passes_its_top():
    source = RampSource(final=2.0, start=0.5, rise_time=1.0)
    Simulation([source], dt=0.01, log=False).run(1.0)
    source.update(1.25)
    assert source.outputs[0] == 1.5
    source.update(1.51)
    assert source.outputs[0] == 2.0


@pytest.mark.parametrize("solver", [RKBS32, RKCK54])
@pytest.mark.parametrize("name", SOURCES)
def test_the_integral_is_exact_because_no_edge_is_missed(name, solver):
    # the area under the source, by a solver that would smear a missed edge over its step of 0.5 s
    area = {
        "doublet": 0.0,
        "doublet with gap": 0.0,
        "3-2-1-1": 0.1 * 0.3,
        "ramp": 3.0 * (0.55 + 1.5),
        "ramp with hold": 0.55 + 0.6,
    }[name]
    source, state = SOURCES[name](), Integrator(0.0)
    sim = Simulation(
        [source, state], [Connection(source, state)], Solver=solver, dt=0.5, dt_max=0.5, log=False
    )
    sim.run(3.0)
    # the last stage before an edge is evaluated with the value after the edge only if it is missed
    assert float(state.outputs[0]) == pytest.approx(area, abs=1e-9)


@pytest.mark.parametrize("name", SOURCES)
def test_reset_and_runs_in_pieces(name):
    source, scope = SOURCES[name](), Scope()
    sim = Simulation([source, scope], [Connection(source, scope)], dt=0.01, log=False)
    sim.run(3.0)
    first = scope.read()[1]
    sim.run(3.0, reset=True)
    assert np.array_equal(scope.read()[1], first)
    sim.reset()
    for _ in range(3):
        sim.run(1.0)
    assert np.array_equal(scope.read()[1], first)


def test_parameters_can_be_edited_while_it_runs():
    source, scope = DoubletSource(amplitude=1.0, start=1.0, width=1.0), Scope()
    sim = Simulation([source, scope], [Connection(source, scope)], dt=0.01, log=False)
    sim.run(1.5)
    source.amplitude = 3.0
    sim.run(2.0)
    time, data = scope.read()
    assert data[0][abs(time - 1.5).argmin()] == 1.0
    assert data[0][abs(time - 2.5).argmin()] == -3.0


@pytest.mark.parametrize(
    "make",
    [
        lambda: DoubletSource(start=1e6, width=1e-11),  # no float between the two edges
        lambda: RampSource(start=1e308, rise_time=1e308),
    ],
)
def test_edges_that_cannot_be_told_apart_are_refused(make):
    with pytest.raises(ParameterError, match="too close to be distinguished") as error:
        make()
    assert error.value.parameter == "start"


@pytest.mark.parametrize(
    ("make", "parameter"),
    [
        (lambda: DoubletSource(amplitude="big"), "amplitude"),
        (lambda: DoubletSource(width=0.0), "width"),
        (lambda: DoubletSource(gap=-0.1), "gap"),
        (lambda: DoubletSource(start=-1.0), "start"),
        (lambda: DoubletSource(polarity=0), "polarity"),
        (lambda: MultistepSource(widths=[1, 2], signs=[1]), "signs"),
        (lambda: MultistepSource(widths="321"), "widths"),
        (lambda: MultistepSource(widths=np.array(2.0)), "widths"),
        (lambda: MultistepSource(widths=[1, 0, 1, 1]), "widths[1]"),
        (lambda: MultistepSource(step=float("inf")), "step"),
        (lambda: RampSource(rise_time=0.0), "rise_time"),
        (lambda: RampSource(final=None), "final"),
        (lambda: RampSource(hold=-1.0), "hold"),
    ],
)
def test_bad_parameters_are_refused_by_name(make, parameter):
    with pytest.raises(ParameterError) as error:
        make()
    assert error.value.parameter == parameter
    assert parameter in str(error.value)


def test_the_width_of_a_multistep_is_its_step():
    with pytest.raises(ParameterError, match=r"no parameter 'width'; did you mean 'step'\?"):
        MultistepSource(width=1.0)
