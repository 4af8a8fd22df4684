"""The published studies against tables made by plain JSBSim loops (tests/data/studies)."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pathsim_jsbsim_blocks import ParameterError, studies
from pathsim_jsbsim_blocks.studies import published

DATA = Path(__file__).parents[1] / "data" / "studies"

# the loops take one step before some trims: it burns 0.02 lb of fuel and climbs 1e-3 ft
RTOL = 1e-5


@pytest.fixture(scope="module")
def tables():
    """Each study, computed once."""
    found = {}

    def table(name, **options):
        if name not in found:
            found[name] = studies.STUDIES[name].table(progress=False, **options)
        return found[name]

    return table


def same(ours, reference, atol=0.0):
    np.testing.assert_allclose(ours, reference, rtol=RTOL, atol=atol)


def compare_aoa(ours, reference):
    ours = ours[ours.trimmed]
    assert ours.requested_speed_kcas.tolist() == reference.vc_request_kts.tolist()
    same(ours.speed_kcas, reference.vc_kts)
    same(ours.alpha_deg, reference.alpha_deg)
    # with the heavy weight and the CG aft the elevator passes through zero
    same(ours.elevator_rad, reference.elevator_rad, atol=1e-7)
    same(ours.elevator_norm, reference.elevator_norm, atol=1e-7)
    same(ours.weight_lb, reference.weight_lbs)


def test_aoa_vs_cas(tables):
    table = tables("aoa_vs_cas", jobs=1)
    assert len(table) == 46
    compare_aoa(table, pd.read_csv(DATA / "06_aoa_vs_cas.csv"))


def by_case(table, reference):
    """The rows of each CG position, weight and altitude, of both tables."""
    for (factor, weight, altitude), rows in reference.groupby(["cg_factor", "weight_case", "h_ft"]):
        ours = table[
            (table.cg_shift_percent == round(100 * factor - 100))
            & (table.weight_case == weight)
            & (table.requested_altitude_ft == altitude)
        ]
        yield factor, altitude, ours, rows


@pytest.mark.long
def test_aoa_vs_cas_for_every_weight_cg_and_altitude(tables):
    table = tables("aoa_vs_cas_loading", wide=True)
    assert len(table) == 3 * 2 * 2 * 46
    reference = pd.read_csv(DATA / "06_aoa_vs_cas_weight_cg.csv")
    assert table.trimmed.sum() == len(reference)
    for _, _, ours, rows in by_case(table, reference):
        compare_aoa(ours, rows)
        same(ours[ours.trimmed].cg_x_in, rows.cg_x_in)


def test_the_six_published_weight_and_cg_cases(monkeypatch):
    speeds = [170, 230]
    monkeypatch.setattr(published, "_SPEEDS", speeds)
    table = studies.aoa_vs_cas_loading(jobs=1, progress=False)
    reference = pd.read_csv(DATA / "06_aoa_vs_cas_weight_cg.csv")
    reference = reference[reference.vc_request_kts.isin(speeds)]
    assert len(table) == 12
    for factor, altitude, ours, rows in by_case(table, reference):
        if (factor, altitude) in ((0.95, 8000), (1.05, 30000)):
            compare_aoa(ours, rows)
        else:
            assert ours.empty


@pytest.mark.long
def test_thrust_vectoring(tables):
    table = tables("thrust_vectoring", jobs=1)
    reference = pd.read_csv(DATA / "08_thrust_vectoring.csv")
    assert table.case.tolist() == reference.case.tolist()
    assert table.trimmed.all()
    same(table.thrust_angle_deg, reference.angle_deg)
    same(table.thrust_lb, reference.thrust_lbs)
    same(table.alpha_deg, reference.alpha_deg)
    for _, rows in table.groupby("case"):
        # the trim's tolerance is a lbf; a polynomial smooths it
        curve = np.polynomial.Polynomial.fit(rows.thrust_angle_deg, rows.thrust_lb, 4)
        angle = np.linspace(0.0, 10.0, 1001)
        assert angle[curve(angle).argmin()] == pytest.approx(4.0, abs=0.3)
        assert np.abs(rows.thrust_lb - curve(rows.thrust_angle_deg)).max() < 1.5
        # thrust straight ahead takes a quarter of a percent more
        assert rows.thrust_lb.iloc[0] / rows.thrust_lb.min() == pytest.approx(1.0025, abs=3e-4)


@pytest.mark.long
def test_trim_envelope(tables):
    table = tables("trim_envelope")
    reference = pd.read_csv(DATA / "09_trim_envelope.csv")
    assert len(table) == 680
    assert table.requested_speed_kcas.tolist() == reference.vc_request_kts.tolist()
    assert table.requested_gamma_deg.tolist() == reference.gamma_deg.tolist()
    assert table.trimmed.tolist() == reference.trimmed.astype(bool).tolist()
    assert table.trimmed.sum() == 364
    for ours, theirs in (
        ("speed_kcas", "vc_kts"),
        ("alpha_deg", "alpha_deg"),
        ("throttle_norm", "throttle_norm"),
        ("pitch_trim_norm", "pitch_trim_norm"),
    ):
        np.testing.assert_allclose(table[ours], reference[theirs], rtol=RTOL, equal_nan=True)
    assert set(table.reason[~table.trimmed]) == {"thrust", "alpha limit", "no convergence"}
    assert (table.reason[table.trimmed] == "").all()
    # slower than the slowest trimmed speed it is alpha, faster than the fastest it is thrust
    level = table[table.requested_gamma_deg == 0].set_index("requested_speed_kcas").reason
    assert level[150] == "alpha limit"
    assert level[450] == "thrust"


def test_climb_schedule(tables):
    table = tables("climb_schedule", jobs=1)
    reference = pd.read_csv(DATA / "10_climb_schedule.csv")
    assert table.requested_altitude_ft.tolist() == reference.h_ft.tolist()
    same(table.throttle_norm, reference.throttle_norm)
    same(table.pitch_trim_norm, reference.pitch_trim_norm)
    same(table.alpha_deg, reference.alpha_deg)


def test_the_envelope_map_shows_every_point():
    speeds = [250]
    figure = studies.envelope_map(studies.trim_envelope(speeds=speeds, jobs=1, progress=False))
    reference = pd.read_csv(DATA / "09_trim_envelope.csv")
    reference = reference[reference.vc_request_kts.isin(speeds)]
    maps = [ax for ax in figure.axes if ax.get_ylabel() == "flight path angle [deg]"]
    assert len(maps) == 3
    for ax in maps:
        assert sum(len(marks.get_offsets()) for marks in ax.collections) == len(reference)
        assert len(ax.collections[0].get_offsets()) == reference.trimmed.sum() > 0
    assert {ax.get_ylabel() for ax in figure.axes} > {
        "throttle command [-]",
        "thrust [1000 lbf]",
        "angle of attack [deg]",
    }


def test_the_climb_chart_shows_both_commands(tables):
    figure = studies.climb_chart(tables("climb_schedule", jobs=1))
    reference = pd.read_csv(DATA / "10_climb_schedule.csv")
    for ax, column in zip(figure.axes, ("throttle_norm", "pitch_trim_norm"), strict=True):
        np.testing.assert_allclose(ax.lines[0].get_ydata(), reference[column], rtol=RTOL)
        assert ax.get_xlabel() == "altitude [ft]"


def test_the_chart_of_angles_of_attack_shows_both_angles(tables):
    upper, lower = studies.alpha_elevator_chart(tables("aoa_vs_cas", jobs=1)).axes
    reference = pd.read_csv(DATA / "06_aoa_vs_cas.csv")
    assert upper.get_ylabel() == "angle of attack [deg]"
    same(upper.lines[0].get_ydata(), reference.alpha_deg)
    assert lower.get_ylabel() == "elevator deflection [deg]"
    same(lower.lines[0].get_ydata(), np.degrees(reference.elevator_rad))
    for ax in (upper, lower):
        same(ax.lines[0].get_xdata(), reference.vc_kts)
    assert lower.get_xlabel() == "calibrated airspeed [kt]"


TABLE = pd.DataFrame({"trimmed": [False], "case": ["level"]})


@pytest.mark.parametrize(
    ("chart", "table", "said"),
    [
        (studies.alpha_elevator_chart, pd.DataFrame({"alpha": [1.0]}), "has no column 'trimmed'"),
        (studies.climb_chart, [1.0, 2.0], "draws a table"),
        (studies.thrust_chart, TABLE.drop(columns="case"), "thrust_vectoring; .*no column 'case'"),
        (studies.envelope_map, TABLE, "this one has no column 'reason'"),
    ],
)
def test_a_chart_refuses_a_foreign_table(chart, table, said):
    with pytest.raises(ParameterError, match=said) as refused:
        chart(table)
    assert refused.value.parameter == "table"


@pytest.fixture
def asked(monkeypatch):
    """The aircraft and grids that studies ask ``trim_sweep`` for."""
    found = []

    def sweep(aircraft, grid, **_):
        found.append((aircraft, grid))
        return pd.DataFrame(index=range(len(grid)))

    monkeypatch.setattr(published, "trim_sweep", sweep)
    return found


def test_the_wide_envelope_is_flown_clean(asked):
    studies.trim_envelope()
    studies.trim_envelope(wide=True)
    axes = {"altitude": 15000.0, "speed": range(120, 460, 10), "gamma": range(-10, 10)}
    clean = {"gear": 0.0, "alpha_min": -5.0, "alpha_max": 15.0}
    assert [grid for _, grid in asked] == [
        {**axes, "solver": "jsbsim", "alpha_min": -4.0, "alpha_max": 12.0},
        {**axes, "solver": "jsbsim", **clean},
    ]


def test_thrust_vectoring_turns_every_engine_of_another_aircraft(asked):
    studies.thrust_vectoring(aircraft="B747")
    ((aircraft, grid),) = asked
    assert aircraft == "B747"
    assert sum("pitch-angle-rad" in key for key in grid[0]) == 4
