"""The study of modes over airspeed."""

import inspect

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pathsim_jsbsim_blocks import AircraftError, ParameterError, TrimCondition, studies
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
    assert row.dutch_roll_real + 1j * row.dutch_roll_imag == pytest.approx(found["Dutch roll"])
    assert row.roll_real == pytest.approx(found["roll"].real)
    assert np.isnan(row.short_period_2_real)


@pytest.mark.long
def test_the_frequencies_are_those_that_theory_expects(table):
    # the short period and the Dutch roll grow with airspeed, the phugoid is near sqrt(2) g / V
    slow, fast = table.iloc[1], table.iloc[2]

    def size(row, mode):
        return np.hypot(row[f"{mode}_real"], row[f"{mode}_imag"])

    assert size(fast, "short_period") / size(slow, "short_period") == pytest.approx(
        110 / 80, rel=0.1
    )
    assert size(fast, "dutch_roll") / size(slow, "dutch_roll") == pytest.approx(110 / 80, rel=0.1)
    true_airspeed = 80 * 1.6878 * 1.077  # ft/s at 5000 ft
    assert size(slow, "phugoid") == pytest.approx(2**0.5 * 32.174 / true_airspeed, rel=0.15)


@pytest.mark.long
def test_the_chart_has_frequency_damping_and_real_poles(table):
    figure = modes_chart(table)
    frequency, damping, real = figure.axes
    assert {"short period", "phugoid", "Dutch roll"} <= {
        line.get_label() for line in frequency.lines
    }
    assert {"roll", "spiral"} <= {line.get_label() for line in real.lines}
    assert len(damping.lines) == len(frequency.lines)
    plt.close(figure)


def test_jobs_resume_and_progress_are_those_of_a_sweep():
    here, there = (inspect.signature(f).parameters for f in (modes_over_speed, studies.trim_sweep))
    for name in ("jobs", "resume", "progress"):
        assert here[name].default == there[name].default, name


def test_bad_input():
    with pytest.raises(ParameterError, match="those of one aircraft"):
        modes_over_speed(speeds=[100])
    with pytest.raises(ParameterError, match="give those of 'A4'"):
        modes_over_speed(aircraft="A4")
    with pytest.raises(AircraftError, match="c172x"):
        modes_over_speed(aircraft="c172q", speeds=[100])
    with pytest.raises(ParameterError, match="speeds"):
        modes_over_speed(aircraft="c172p", speeds=[])


def test_it_is_in_the_catalogue():
    assert studies.STUDIES["modes_over_speed"].table is modes_over_speed
