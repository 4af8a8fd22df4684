"""Trim maps: what they hold, that they leave nothing behind, and what they refuse."""

import math
import random
import re
import sys
from itertools import product
from pathlib import Path

import jsbsim
import numpy as np
import pandas as pd
import plain_jsbsim
import pytest
from fleet_conditions import FLYING
from how_many import first

from pathsim_jsbsim_blocks import (
    AircraftError,
    ParameterError,
    PropertyError,
    TrimCondition,
    TrimError,
)
from pathsim_jsbsim_blocks.errors import MissingExtraError
from pathsim_jsbsim_blocks.flight import Airframe, trim
from pathsim_jsbsim_blocks.studies import sweep, trim_sweep

GRID = {
    "altitude": 15000,
    "alpha_min": -4,
    "alpha_max": 12,
    "speed": [120, 200, 300, 450],
    "gamma": [-8, 0, 3],
}


def quiet(*args, **options):
    return trim_sweep(*args, **{"jobs": 1, "progress": False, **options})


UNITS = re.compile("(^|_)(ft|kcas|fps|deg|degps|norm|lb|rad|fps2|radps2|in|mach|g)$")


def test_a_table_of_the_product_of_axes():
    table = quiet("737", GRID)
    assert table.requested_speed_kcas.tolist() == [v for v in (120, 200, 300, 450) for _ in "abc"]
    assert table.requested_gamma_deg.tolist() == [-8, 0, 3] * 4
    assert (table.requested_altitude_ft == 15000).all()
    # every number has its unit in the name of its column
    assert all(UNITS.search(name) for name in table.select_dtypes("number"))
    assert table.trimmed.dtype == bool
    # points that do not trim say why and hold no numbers
    failed = table[~table.trimmed]
    assert set(failed.reason) == {"alpha limit", "thrust"}
    assert failed.loc[:, "altitude_ft":].isna().all(axis=None)
    assert table[table.trimmed].loc[:, "altitude_ft":].notna().all(axis=None)


def test_rows_are_taken_as_they_stand_from_a_list_or_a_table():
    angle = "propulsion/engine[0]/pitch-angle-rad"  # a property of JSBSim can be an axis
    rows = [{"speed": 200.0, angle: 0.1}, {"speed": 200.0, angle: 0.0}]
    table = quiet("737", rows)
    assert table[f"requested_{angle}"].tolist() == [0.1, 0.0]
    assert table.alpha_deg[0] < table.alpha_deg[1]
    pd.testing.assert_frame_equal(table, quiet("737", pd.DataFrame(rows)), check_exact=True)


def test_what_a_point_leaves_open_is_nan():
    fast, slow = {"altitude": 30000, "mach": 0.8}, {"altitude": 30000, "mach": 0.7}
    table = quiet("737", [fast, {**slow, "fuel": [1000, 1000, 1000]}])
    assert table.requested_speed_kcas.isna().all()
    assert table.requested_speed_kcas.dtype == float
    assert table["requested_fuel_lb[2]"].isna().tolist() == [True, False]
    np.testing.assert_allclose(table.mach, [0.8, 0.7], rtol=1e-12)


def test_gear_fuel_and_wind_reach_the_aircraft():
    setup = {"gear/gear-cmd-norm": 0.0, "gear/gear-pos-norm": 0.0}
    setup |= {f"propulsion/tank[{i}]/contents-lbs": x for i, x in enumerate((900.0, 700.0, 0.0))}
    fdm = plain_jsbsim.trimmed("737", 15000.0, 250.0, gamma=3.0, setup=setup)
    climb = {"altitude": 15000, "speed": 250, "gamma": 3, "gear": 0, "fuel": [[900, 700, 0]]}
    [row] = quiet("737", {**climb, "solver": "jsbsim"}).itertuples()  # as the plain loop trims
    thrust = sum(fdm[f"propulsion/engine[{i}]/thrust-lbs"] for i in (0, 1))
    assert row.thrust_lb == pytest.approx(thrust, rel=1e-9)
    assert row.alpha_deg == pytest.approx(fdm["aero/alpha-deg"], rel=1e-9)
    assert row.weight_lb == pytest.approx(fdm["inertia/weight-lbs"], rel=1e-9)
    assert row.pitch_trim_norm == pytest.approx(fdm["fcs/pitch-trim-cmd-norm"], rel=1e-6)

    # a tail wind from the south adds to the ground speed of an aircraft heading north
    table = quiet(
        "737",
        {"altitude": 15000, "speed": 250, "wind_north": [0, 50]},
        outputs=["velocities/vg-fps"],
    )
    assert table["velocities/vg-fps"].diff()[1] == pytest.approx(50, abs=0.5)


@pytest.mark.parametrize(
    ("aircraft", "speed", "rows"),
    first(
        [
            ("737", 250, [{}, {"gear": 0}, {"fuel": [1000, 1000, 1000]}]),
            # a full trim moves the ailerons, a longitudinal one leaves them as they are
            ("c172p", 90, [{"mode": "longitudinal"}, {}]),
            ("c172p", 90, [{"fcs/flap-cmd-norm": 0.5, "fcs/flap-pos-norm": 0.5}, {}]),
        ],
        2,
    ),
)
def test_what_one_point_sets_does_not_reach_the_next(aircraft, speed, rows):
    rows = [{"speed": speed, **row} for row in rows]
    forward, backward = quiet(aircraft, rows), quiet(aircraft, rows[::-1])[::-1]
    found = forward.loc[:, "altitude_ft":].to_numpy()
    assert np.array_equal(found, backward.loc[:, "altitude_ft":].to_numpy())
    assert len(np.unique(found.round(3), axis=0)) == len(rows)


def test_a_file_of_other_outputs_or_another_mode_is_another_study(tmp_path):
    def sweep(outputs=(), **more):
        options = {"root": Path(jsbsim.get_default_root_dir()), "resume": tmp_path / "a.jsonl"}
        return quiet("c172p", {"speed": 90, **more}, outputs=outputs, **options)

    first = sweep(["aero/alpha-rad"])
    pd.testing.assert_frame_equal(sweep(["aero/alpha-rad"]), first, check_exact=True)
    for other in ({}, {"outputs": ["aero/alpha-rad"], "mode": "longitudinal"}):
        with pytest.raises(ParameterError) as error:
            sweep(**other)
        assert error.value.parameter == "resume"


@pytest.mark.parametrize(
    ("aircraft", "speed", "keeps"), first([("737", 100, True), ("c182", 150, False)])
)
def test_a_warm_trim_loads_again_only_after_a_search_that_left_something(aircraft, speed, keeps):
    airframe = Airframe(aircraft)
    before = airframe.fdm
    with pytest.raises(TrimError):
        trim(airframe, TrimCondition(altitude=5000, speed=speed), hint=False)
    condition = TrimCondition(altitude=5000, speed=250 if keeps else 90, gear=1)
    trim(airframe, condition, hint=False, warm=True)
    assert (airframe.fdm is before) == keeps
    trim(airframe, condition, hint=False)
    assert airframe.fdm is not before


def test_nothing_is_printed_but_the_progress_bar(capfd, caplog):
    table = trim_sweep("737", {"speed": [60, 70, 80], "altitude": 15000}, jobs=1)
    assert not table.trimmed.any()
    out, err = capfd.readouterr()
    assert out == ""
    assert err.split("\r")[-1].startswith("trim_sweep 737, 3 points: 100%")
    assert "trimmable" not in err
    quiet("737", {"speed": [60, 200]})
    assert capfd.readouterr() == ("", "")
    # nor does a log that is shown from warnings on fill with expected failures
    assert [r for r in caplog.records if r.levelname not in ("DEBUG", "INFO")] == []


@pytest.mark.parametrize(
    ("grid", "message"),
    [
        ({}, "grid is empty"),
        ({"speed": []}, "grid is empty: speed has no values"),
        (None, "must be a dict of axes"),
        ([1, 2], "one dict for each point"),
        ({"sped": [200]}, "did you mean 'speed'"),
        ({"speed": [200, math.nan]}, r"grid point 1: speed must be finite"),
        ({"speed": [200, 0]}, r"grid point 1: speed must be greater than 0"),
        ({"speed": [200], "payload": [[-1]]}, r"payload\[0\] must be at least 0"),
        ({"speed": [200], "fuel": [100, 200]}, "fuel must be a list or a dict of weights"),
        ({"speed": [200], "mach": [0.5]}, "both mach and speed"),
        ({"speed": [object()]}, "must be a number, text"),
        ({"speed": [200], "gear/gear-cmd-norm": ["up"]}, "gear/gear-cmd-norm must be a number"),
        (pd.DataFrame({"speed": [200.0, math.nan]}), "grid point 1: speed must be finite"),
    ],
)
def test_a_bad_grid_is_refused_before_the_work_begins(monkeypatch, grid, message):
    monkeypatch.setattr(sweep, "run_parts", None)
    with pytest.raises(ParameterError, match=message):
        quiet("737", grid)


@pytest.mark.parametrize(
    ("aircraft", "grid", "options", "error", "message"),
    [
        ("73", {"speed": [200]}, {}, AircraftError, "did you mean '737'"),
        ("737", {"gear/gear-cmd-nrm": [1]}, {}, PropertyError, "gear/gear-cmd-norm"),
        ("737", {"fuel": [[1, 1, 1, 1]]}, {}, PropertyError, r"tank\[3\]"),
        ("737", {"speed": [200]}, {"outputs": ["aero/alfa-deg"]}, PropertyError, "aero/alpha-deg"),
        ("737", {"speed": [200]}, {"outputs": "aero/alpha-deg"}, ParameterError, "must be a list"),
        ("737", {"speed": [200]}, {"chunk": 0}, ParameterError, "chunk"),
    ],
)
def test_bad_parameters_are_refused_before_the_work_begins(
    monkeypatch, aircraft, grid, options, error, message
):
    monkeypatch.setattr(sweep, "run_parts", None)
    with pytest.raises(error, match=message):
        quiet(aircraft, grid, **options)


def test_without_the_extra_the_error_names_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingExtraError) as error:
        quiet("737", {"speed": [200]})
    assert error.value.extra == "studies"


def same_whatever_the_order(aircraft, speeds, gammas, solver):
    rng = random.Random(aircraft)
    altitude, speed, gear, _ = FLYING[aircraft]
    rows = [
        {"altitude": altitude, "speed": v * speed, "gear": gear, "gamma": gamma, "solver": solver}
        for v in speeds
        for gamma in gammas
    ]
    there = quiet(aircraft, rows)
    assert there.trimmed.any()
    backward, shuffled = range(len(rows))[::-1], rng.sample(range(len(rows)), len(rows))
    for order, chunk, jobs in ((backward, 7, 1), (shuffled, 40, 2)):
        table = quiet(aircraft, [rows[i] for i in order], chunk=chunk, jobs=jobs)
        back = table.set_index(pd.Index(order)).sort_index()
        pd.testing.assert_frame_equal(back, there, check_exact=True)


@pytest.mark.parametrize("solver", first(["newton", "jsbsim"]))
def test_chunk_order_and_workers_do_not_show(solver):
    same_whatever_the_order("737", (0.9, 1.1), (-2, *range(-1, 3), 8, 3, 12, 1.5, 9, 0.5), solver)


@pytest.mark.long
def test_order_does_not_show_where_the_newton_search_depends_on_its_start():
    # at 134.3 KCAS it converges from a neighbour's trim, but not from its own guesses
    rows = [{"altitude": 3000, "speed": speed, "solver": "newton"} for speed in (132.0, 134.3)]
    there, back = quiet("DHC6", rows), quiet("DHC6", rows[::-1], chunk=1)
    pd.testing.assert_frame_equal(there, back[::-1].reset_index(drop=True), check_exact=True)


@pytest.mark.long
@pytest.mark.parametrize(
    ("aircraft", "solver"),
    [
        *product(["c172p", "737", "A320", "f16", "T38", "OV10"], ["newton", "jsbsim"]),
        # JSBSim's search is refused with constant-speed propellers
        *product(["DHC6", "c182"], ["newton"]),
    ],
)
def test_chunk_order_and_workers_do_not_show_for_several_aircraft(aircraft, solver):
    same_whatever_the_order(aircraft, (1.0, 1.04), range(-5, 6), solver)
