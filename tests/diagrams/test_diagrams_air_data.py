"""The diagrams isa_profile and constant_cas_climb against printed answers and the table."""

import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from how_many import first
from test_diagrams_flight import flown

from pathsim_jsbsim_blocks.catalogue import find_diagram


def test_profile_passes_through_the_table():
    profile = flown("isa_profile")
    _, (height,) = profile.height.read()
    _, air = profile.air.read()
    assert (height[0], height[-1]) == (0.0, 80_000.0)
    file = Path(__file__).parents[1] / "data" / "isa_reference.csv"
    rows = np.loadtxt(file, delimiter=",", skiprows=1)
    on_the_way = [row for row in rows if row[2] == 0.0 and row[0] in height]
    assert len(on_the_way) >= 10
    for h, _, _, temperature, pressure, density, speed_of_sound, viscosity in on_the_way:
        recorded = air[:, np.flatnonzero(height == h)[0]]
        # the table has twelve digits
        assert recorded == pytest.approx(
            [pressure, density, temperature, speed_of_sound, viscosity], rel=1e-11
        )
    # the layers end where the docstring says
    for celsius, bottom, top in ((-56.5, 11.0, 20.1), (-2.5, 47.4, 51.4)):
        isothermal = height[np.abs(air[2] - 273.15 - celsius) < 1e-9] / 1000
        # sampled every 50 m
        assert (isothermal[0], isothermal[-1]) == pytest.approx((bottom, top), abs=0.1)


def test_climb_holds_cas_then_mach():
    climb = flown("constant_cas_climb")
    _, (feet,) = climb.height.read()
    _, (tas, cas, eas) = climb.airspeeds.read()
    _, (mach,) = climb.machs.read()
    assert feet[-1] == pytest.approx(45_000.0, abs=1e-6)
    # BADA's transition altitude gives 32,259.7 ft geopotential, 32,309.7 ft of height
    below, above = feet < 32_309.0, feet > 32_310.5
    np.testing.assert_allclose(cas[below], 250.0, rtol=1e-14)
    np.testing.assert_allclose(mach[above], 0.70, rtol=1e-14)
    assert np.all(mach[below] < 0.70)
    assert np.all(cas[above] < 250.0)
    assert np.all(eas[1:] < cas[1:])
    # 0.70 a(216.65 K) = 0.70 * 295.0695 m/s, with ICAO's six digits
    np.testing.assert_allclose(tas[feet > 36_160.0], 0.70 * 295.069 * 3600 / 1852, rtol=3e-6)
    # at 10,000 ft, printed with the gas constant of 1976: 4e-6
    i = np.flatnonzero(np.abs(feet - 10_000.0) < 1e-6)[0]
    assert mach[i] == pytest.approx(0.452236, rel=4e-6)
    assert tas[i] == pytest.approx(288.682, rel=4e-6)


@pytest.mark.parametrize("name", first(["constant_cas_climb", "isa_profile"]))
def test_a_script_prints_its_numbers_and_saves_its_figures(name, tmp_path, monkeypatch, capsys):
    # in a process of its own: tests/test_catalogue.py
    monkeypatch.chdir(tmp_path)
    plt.switch_backend("agg")
    runpy.run_path(str(find_diagram(name)), run_name="__main__")
    plt.close("all")
    done = capsys.readouterr()
    assert (tmp_path / f"{name}.png").stat().st_size > 10_000
    assert done.err == ""
    lines = {line.split()[0]: line.split() for line in done.out.splitlines()}
    if name == "constant_cas_climb":
        assert "crossover altitude 32310 ft" in done.out
        # 241.4 is EAS to TAS; CAS to TAS at 40,000 ft is 237.3
        assert lines["40,000"][2] == "237.3"
        assert "241.4" not in done.out
    else:
        assert lines["80.00"][2:4] == ["1.05", "Pa"]
        assert (tmp_path / "isa_profile_troposphere.png").exists()
