"""The study of modes over airspeed."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pathsim_jsbsim_blocks import AircraftError, ParameterError, TrimCondition
from pathsim_jsbsim_blocks.flight import linear_model
from pathsim_jsbsim_blocks.studies import modes_chart, modes_over_speed


@pytest.fixture(scope="module")
def table():
    return modes_over_speed(aircraft="c172p", speeds=[30, 80, 110], jobs=1, progress=False)


@pytest.mark.long
def test_each_point_has_the_modes_of_its_model(table):
    assert table.trimmed.tolist() == [False, True, True]
    assert table.reason[0] != ""
    condition = TrimCondition(altitude=5000, speed=80, setup={"propulsion/fuel_freeze": 1.0})
    found = {m.name: m.pole for m in linear_model("c172p", condition).modes()}
    row = table.iloc[1]
    for name in ("short period", "phugoid", "Dutch roll"):
        column = name.lower().replace(" ", "_")
        pole = row[f"{column}_real"] + 1j * row[f"{column}_imag"]
        assert pole == pytest.approx(found[name]), name
    assert row.roll_real == pytest.approx(found["roll"].real)
    assert np.isnan(row.short_period_2_real)


@pytest.mark.long
def test_the_chart_has_frequency_damping_and_real_poles(table):
    figure = modes_chart(table)
    frequency, damping, real = figure.axes
    labels, poles = ({line.get_label() for line in ax.lines} for ax in (frequency, real))
    assert {"short period", "phugoid", "Dutch roll"} <= labels
    assert {"roll", "spiral"} <= poles
    assert len(damping.lines) == len(frequency.lines)
    plt.close(figure)


@pytest.mark.parametrize(
    ("given", "error", "said"),
    [
        ({"speeds": [100]}, ParameterError, "speeds need an aircraft"),
        ({"aircraft": "A4"}, ParameterError, "'A4' needs speeds"),
        ({"aircraft": "c172q", "speeds": [100]}, AircraftError, "c172x"),
        ({"aircraft": "c172p", "speeds": []}, ParameterError, "speeds"),
    ],
)
def test_bad_input(given, error, said):
    with pytest.raises(error, match=said):
        modes_over_speed(**given)


def test_a_glider_has_no_thrust_for_level_flight_and_no_fuel_to_freeze():
    table = modes_over_speed(aircraft="SGS", speeds=[45], jobs=1, progress=False)
    assert [*table.reason] == ["thrust"]
