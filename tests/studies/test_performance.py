"""Performance charts: values against plain JSBSim loops and printed formulas; bad input."""

import importlib
import math
from pathlib import Path

import numpy as np
import pytest
from plain_jsbsim import open_fdm

from pathsim_jsbsim_blocks import ParameterError, TrimCondition
from pathsim_jsbsim_blocks.flight import Airframe, trim
from pathsim_jsbsim_blocks.studies import performance_chart, performance_table
from pathsim_jsbsim_blocks.studies.field import field
from pathsim_jsbsim_blocks.studies.flight_tests import Plane, climb_rate, extremes, loading
from pathsim_jsbsim_blocks.studies.performance import (
    _PARTS,
    COLUMNS,
    _burn,
    _ceilings,
    _curve,
    _glides,
    _gusts,
    _load_factors,
    _stall,
    _turns,
    _work,
)

pandas = pytest.importorskip("pandas")

C172P = {
    "aircraft": "c172p",
    "root": None,
    "create": None,
    "altitude": 5000.0,
    "weight": None,
    "flaps": None,
}


def plane_of(aircraft, altitude=0.0, **task):
    return Plane({**C172P, "aircraft": aircraft, "altitude": altitude, **task})


def plain_flight(state, seconds, elevator=0.0):
    """Rows of a plain JSBSim loop from a trim: altitude, true speed, lift factor, qbar, alpha."""
    setup = {"propulsion/fuel_freeze": 1.0, "ic/terrain-elevation-ft": -5000.0}
    fdm = open_fdm("c172p", 1 / 120, setup)
    fdm["ic/h-sl-ft"] = state.altitude
    fdm["ic/vc-kts"] = state.speed
    fdm["ic/gamma-deg"], fdm["ic/alpha-deg"] = state.gamma, state.alpha
    fdm["ic/phi-deg"] = state.phi
    fdm["propulsion/set-running"] = -1
    fdm.run_ic()
    for name in ("pitch_trim", "elevator", "aileron", "rudder"):
        fdm[f"fcs/{name.replace('_', '-')}-cmd-norm"] = getattr(state, name)
    fdm["fcs/throttle-cmd-norm"] = state.throttle[0]
    fdm["fcs/mixture-cmd-norm"] = state.condition.setup["fcs/mixture-cmd-norm[0]"]
    rows = []
    for i in range(round(120 * seconds)):
        fdm["fcs/elevator-cmd-norm"] = state.elevator + elevator * i / 120
        fdm.run()
        a, g = fdm["aero/alpha-rad"], fdm["accelerations/gravity-ft_sec2"]
        n = fdm["accelerations/Nx"] * math.sin(a) + fdm["accelerations/Nz"] * math.cos(a)
        h, v = fdm["position/h-sl-ft"], fdm["velocities/vt-fps"]
        rows.append([h + v**2 / (2 * g), n * 32.174 / g, fdm["aero/qbar-psf"], a])
    return np.array(rows).T


def test_climb_is_that_of_a_plain_loop():
    state = Plane(C172P).climb(80.0)
    energy = plain_flight(state, 30.0)[0]
    # from 5 s on, when the engine that JSBSim starts turns fast; over the climb the rate falls
    rate = 60.0 * (energy[-1] - energy[600]) / 25.0
    assert climb_rate(state) == pytest.approx(rate, rel=0.03)
    assert climb_rate(state) > 1000.0


def test_stall_is_that_of_a_plain_deceleration():
    plane = Plane(C172P)
    _stall(plane)
    (row,) = plane.rows
    start = plane.glide(57.0)
    _, n, q, alpha = plain_flight(start, 40.0, elevator=-0.02)
    # without the engine's start, up to the model's limit of the angle of attack
    before = slice(600, int((alpha > 0.28).argmax()))
    lift = (n[before] / q[before]).max()
    knots = math.sqrt(1.0 / lift / 0.5 / 0.0023769) / 1.68781
    assert row["value"] == pytest.approx(knots, rel=0.01)
    assert row["flown"] == pytest.approx(row["value"], rel=0.01)


def test_full_flaps_of_an_airliner_have_a_stall_speed():
    """Below a lift coefficient of 1.2 the angle of attack would be under the model's least."""
    plane = plane_of("B747", flaps=1.0)
    _stall(plane)
    (row,) = plane.rows
    assert row["flown"] == pytest.approx(row["value"], rel=0.01)
    assert row["value"] < 125.0


@pytest.mark.long
def test_take_off_run_is_that_of_a_plain_loop():
    """With the nose wheel on the ground, from rest to the airspeed of the lift-off."""
    plane = Plane({**C172P, "altitude": 0.0})
    field(plane)
    found = {row["quantity"]: row for row in plane.rows}
    roll = found["take-off ground roll"]
    fdm = open_fdm("c172p", 1 / 120, {"ic/vc-kts": 0.0, "ic/h-agl-ft": 4.4})
    fdm["propulsion/set-running"] = -1
    fdm.run_ic()
    fdm["propulsion/set-running"] = -1
    fdm["fcs/flap-cmd-norm"] = 0.5
    way = 0.0
    for _ in range(120 * 60):
        # 4 s at rest for the engine
        fdm["fcs/throttle-cmd-norm"] = fdm["fcs/mixture-cmd-norm"] = 1.0
        held = float(fdm.get_sim_time() < 4.0)
        fdm["fcs/left-brake-cmd-norm"] = fdm["fcs/right-brake-cmd-norm"] = held
        fdm.run()
        way += 0.0 if held else fdm["velocities/vg-fps"] / 120
        if fdm["velocities/vc-kts"] > roll["speed_kcas"]:
            break
    assert roll["value"] == pytest.approx(way, rel=0.1)
    assert found["take-off distance"]["value"] > roll["value"] + 200.0
    assert 200.0 < found["landing ground roll"]["value"] < 700.0
    assert 0.9 * 46 < found["landing ground roll"]["speed_kcas"] < 60.0


def test_fuel_is_weighed_up_to_where_a_tank_runs_dry():
    """The Concorde's collector tanks are empty after 12 s; its next flight has engines again."""
    plane = plane_of("Concorde")
    _burn(plane, plane.trim(302.0))
    assert abs(plane.rows[1]["difference_percent"]) < 1.0
    plane.climb_to(30e3)
    climb = plane.climb(301.4)
    assert plane.energy_rate(climb) == pytest.approx(climb_rate(climb), rel=0.01)


def test_fuel_is_weighed_while_an_unstable_aircraft_stays_at_its_airspeed():
    """The XB-70 pitches up after 16 s with its controls fixed."""
    plane = plane_of("XB-70")
    _burn(plane, plane.trim(345.0))
    assert abs(plane.rows[1]["difference_percent"]) < 1.0


def test_level_flight_goes_on_where_an_afterburner_has_too_much_thrust():
    plane = plane_of("F4N", 30e3)
    assert plane.trim(450.0) is None
    fast = plane.level(450.0)
    assert (fast.mach > 1.1, fast.throttle[0], fast.gamma > 0.0) == (True, 1.0, True)


@pytest.mark.long
def test_a_model_that_climbs_ever_better_has_no_ceiling():
    """The table of the F4N's engine ends at 50,000 ft."""
    plane = plane_of("F4N", 5000.0, part="level")
    _ceilings(plane)
    for row in plane.rows:
        assert row["reason"] == "above 90000 ft: its rate of climb is minimum at 55000 ft"


def test_a_chart_resumes_from_its_file(tmp_path, monkeypatch):
    asked = {"altitudes": 0.0, "flaps": 0.0, "jobs": 1, "progress": False}
    file, parts = tmp_path / "sgs126.jsonl", "pathsim_jsbsim_blocks.studies.performance._PARTS"
    monkeypatch.setattr(parts, {**dict.fromkeys(_PARTS, lambda plane: None), "stall": _stall})
    table = performance_table("sgs126", **asked, resume=file)
    monkeypatch.setattr(parts, {})
    again = performance_table("sgs126", **asked, resume=file)
    pandas.testing.assert_frame_equal(table, again)
    assert again.value.notna().sum() == 1


@pytest.mark.long
def test_gust_lines_are_those_of_the_printed_formula():
    plane = Plane({**C172P, "altitude": 0.0})
    _gusts(plane, plane.glide(55.0))
    found = {row["quantity"]: row["value"] for row in plane.rows}
    speed = next(r["speed_kcas"] for r in plane.rows if r["quantity"].endswith("factor at VC"))
    one, more = (plane.trim(speed, mode="pull-up", throttle=0.0, load_factor=n) for n in (1.0, 1.2))
    wing = 1880.0 / 174.0
    slope = 0.2 * wing / (0.5 * 0.0023769 * one.tas**2) / math.radians(more.alpha - one.alpha)
    mu = 2.0 * wing / (0.0023769 * 4.9 * slope * 32.2)
    # CS 23.341 in the units of 14 CFR 23.341 (1996): knots, ft/s, lb/ft2
    n = 1.0 + 0.88 * mu / (5.3 + mu) * 50.0 * found["VC"] * slope / (498.0 * wing)
    assert found["gust load factor at VC"] == pytest.approx(n, rel=0.005)


def test_a_trim_keeps_the_mixture_that_it_is_given():
    plane = Airframe("c172p")
    rich = trim(plane, TrimCondition(altitude=9000, speed=75, throttle=1.0), hint=False)
    setup = {"fcs/mixture-cmd-norm": 0.77}
    lean = trim(
        plane, TrimCondition(altitude=9000, speed=75, throttle=1.0, setup=setup), hint=False
    )
    assert plane.fdm["fcs/mixture-cmd-norm"] == 0.77
    # JSBSim's engine drowns in full rich mixture at this altitude
    assert lean.thrust > 2.0 * rich.thrust


@pytest.mark.parametrize("weight", [1550.0, 2400.0])
def test_loading_makes_up_a_weight(weight):
    plane = Plane({**C172P, "weight": weight})
    state = plane.glide(75.0)
    assert state.weight == pytest.approx(weight, abs=0.01)


@pytest.mark.parametrize(
    ("task", "reason"),
    [
        ({"part": "turn", "altitude": 1e9}, "altitude must lie in"),
        ({"part": "stall", "weight": 9e9}, "not 9,000,000,000 lb"),
        ({"part": "ceiling", "aircraft": "SGS"}, "no engine"),
        ({"part": "field", "aircraft": "DHC6"}, "no gain table"),
    ],
)
def test_what_a_model_cannot_do_is_a_reason_in_the_table(task, reason):
    (found,) = _work([{**C172P, **task}])
    assert all(reason in row["reason"] for row in found["rows"])
    assert found["rows"]


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"weights": -1.0}, "weight must be"),
        ({"flaps": [0.0, 2.0]}, "flaps"),
        ({"altitudes": []}, "no altitude"),
        ({"altitudes": [[0.0]]}, "altitude must be a number"),
    ],
)
def test_bad_numbers_are_refused_at_once(asked, said):
    with pytest.raises(ParameterError, match=said):
        performance_table("c172p", **asked)


def test_loading_stays_within_what_a_model_weighs():
    with pytest.raises(ParameterError) as error:
        loading(Plane(C172P).airframe, 500.0)
    assert (error.value.parameter, error.value.value) == ("weight", 500.0)
    # with 5 % of its fuel and without payload it has 1e-13 lb less than its own weight
    airframe = plane_of("Short_S23").airframe
    assert all(x >= 0.0 for x in loading(airframe, extremes(airframe)[0])["payload"])


def glides_of(aircraft):
    """Glides of an aircraft at sea level from the stall on, and what is found in them."""
    plane = plane_of(aircraft)
    slow = plane.slowest().speed
    _glides(plane, [plane.glide(factor * slow) for factor in (1.001, 1.12, 1.25, 1.4, 1.6, 2.0)])
    best = next(row for row in plane.rows if row["quantity"] == "best glide ratio")
    return plane, [plane.glide(factor * slow) for factor in np.arange(1.0, 2.0, 0.04)], best


def lift_over_drag(aircraft, glide):
    """Of a model's aerodynamics alone, with the angle of attack and the elevator of a glide."""
    fdm = open_fdm(aircraft, 1 / 120, {"ic/terrain-elevation-ft": -5000.0})
    fdm["ic/h-sl-ft"], fdm["ic/vc-kts"] = 0.0, glide.speed
    fdm["ic/alpha-deg"], fdm["fcs/elevator-cmd-norm"] = glide.alpha, glide.elevator
    fdm["fcs/pitch-trim-cmd-norm"] = glide.pitch_trim
    fdm["gear/gear-pos-norm"] = fdm["gear/gear-cmd-norm"] = 0.0
    fdm.set_trim_status(True)
    fdm.run_ic()
    return fdm["forces/fwz-aero-lbs"] / fdm["forces/fwx-aero-lbs"]


def test_the_best_glide_is_the_largest_lift_over_drag_of_the_model():
    """Not the flattest path of a 737, to which the thrust of its idling engines adds."""
    _, glides, best = glides_of("737")
    ratios = {glide.speed: lift_over_drag("737", glide) for glide in glides}
    # the elevator moves in the first moment, which this leaves out
    assert best["value"] == pytest.approx(max(ratios.values()), rel=0.01)
    assert best["speed_kcas"] == pytest.approx(max(ratios, key=ratios.get), rel=0.03)
    assert best["flown"] == pytest.approx(best["value"], rel=0.02)


@pytest.mark.long
def test_a_model_whose_lift_over_drag_grows_down_to_the_stall_has_no_best_glide():
    """The drag of the T37's model grows with alpha itself, not with its square."""
    _, glides, best = glides_of("T37")
    ratios = [lift_over_drag("T37", glide) for glide in glides[::3]]
    assert ratios == sorted(ratios, reverse=True)
    assert math.isnan(best["value"])
    assert best["reason"] == "L/D still increases at the stall"


@pytest.mark.long
def test_an_instantaneous_turn_is_at_least_the_sustained_one():
    plane = plane_of("T37", 300.0)
    _turns(plane)
    found = {(row["quantity"], row["speed_kcas"]): row["value"] for row in plane.rows}
    speeds = {speed for _, speed in found}
    assert len(speeds) == 6
    compared = 0
    for speed in speeds:
        of = lambda kind, what: found.get((f"{kind} {what}", speed), math.nan)  # noqa: E731, B023
        if math.isnan(of("sustained", "turn rate")):
            continue
        compared += 1
        for what in ("load factor", "turn rate"):
            assert of("instantaneous", what) >= of("sustained", what)
        assert of("instantaneous", "turn radius") <= of("sustained", "turn radius")
        for kind in ("sustained", "instantaneous"):
            # v = omega r, and the force that bends the path, in any turn
            rate = math.radians(of(kind, "turn rate"))
            pull = rate**2 * of(kind, "turn radius") / 32.174
            assert of(kind, "load factor") <= math.hypot(1.0, pull) + 1e-6
    assert compared >= 4


def test_a_point_without_trim_is_left_out_and_named():
    plane = Plane(C172P)
    find = lambda speed: None if 80.0 < speed < 90.0 else plane.climb(speed)  # noqa: E731
    plane.reason = "thrust"
    found = _curve(plane, find, [40.0, 70.0, 85.0, 95.0, 300.0], "rate of climb")
    assert [round(state.speed) for state in found] == [70, 95]
    (row,) = plane.rows
    assert (row["quantity"], row["speed_kcas"]) == ("rate of climb", 85.0)
    for state in found:
        plane.put("rate of climb", climb_rate(state), state.speed)
    figure = performance_chart(pandas.DataFrame(plane.rows, columns=list(COLUMNS)))
    assert figure.get_supxlabel().startswith("left out: rate of climb at 85 KCAS (")
    (line,) = figure.axes[3].lines
    assert [round(x) for x in line.get_xdata()] == [70, 95]


@pytest.mark.long
def test_an_aircraft_that_climbs_with_the_throttle_closed_has_no_glide_ratio():
    """The Camel's engine gives thrust at any throttle."""
    plane = plane_of("Camel")
    _glides(plane, [plane.glide(50.0)])
    reasons = {row["quantity"]: row["reason"] for row in plane.rows}
    assert reasons["best glide ratio"] == "it climbs with the throttle closed"


def test_the_page_of_a_table_without_values_shows_the_reasons():
    rows = [{"chart": "turn", "quantity": "sustained load factor", "reason": "no engine"}]
    figure = performance_chart(pandas.DataFrame(rows, columns=list(COLUMNS)))
    texts = [text.get_text() for ax in figure.axes for text in ax.texts]
    assert "no turn chart:\nno engine" in texts
    with pytest.raises(ParameterError) as error:
        performance_chart(pandas.DataFrame({"a": [1]}))
    assert error.value.parameter == "table"


def v_n_rows(*points):
    rows = [{"load_factor": n, "value": keas} for n, keas in points]
    rows = [{"chart": "V-n", "quantity": "speed at the lift limit", **row} for row in rows]
    rows.append({"chart": "V-n", "quantity": "VD", "value": 150.0})
    return performance_chart(pandas.DataFrame(rows, columns=list(COLUMNS))).axes[1].lines


def test_lift_limit_is_a_parabola_that_ends_flat_only_at_the_limit_load_factor():
    up, down = v_n_rows((1.0, 50.0), (4.0, 100.0), (-0.5, 70.0), (-1.5, math.nan))
    speed, n = up.get_data()
    assert np.interp(25.0, speed, n) == pytest.approx(0.25, abs=0.01)  # (25 / 50) ** 2
    assert (speed[-1], n[-1], n[-2]) == (150.0, 4.0, 4.0)
    speed, n = down.get_data()
    assert (speed[-1], n[-1]) == (70.0, pytest.approx(-0.5))
    # without positive load factors there is no legend, of which matplotlib would warn
    assert v_n_rows((1.0, math.nan), (-0.5, 70.0))[0].get_data()[1][-1] == pytest.approx(-0.5)


@pytest.mark.long
def test_a_c172p_has_a_negative_lift_limit():
    plane = Plane({**C172P, "altitude": 0.0})
    _load_factors(plane)
    (speed,) = (row["value"] for row in plane.rows if row.get("load_factor") == -0.5)
    # at -5 deg, the model's limit, its table has CL = -0.206, and 0.43 per rad of elevator, 23 deg
    keas = [math.sqrt(940.0 / (c * 0.5 * 0.0023769 * 174.0)) / 1.68781 for c in (0.206, 0.033)]
    assert keas[0] < speed < keas[1]


@pytest.mark.long
@pytest.mark.parametrize("aircraft", ["SGS", "sgs126", "X15"])
def test_the_page_of_the_fleet_is_current(aircraft, monkeypatch):
    docs = Path(__file__).parents[2] / "docs"
    monkeypatch.syspath_prepend(docs)
    charts = importlib.import_module("performance_charts")
    table = performance_table(aircraft, progress=False).assign(seconds=0.0, commit="")
    (printed,) = (r for r in charts.read_table("performance") if r["aircraft"] == aircraft)
    found = [cell.strip() for cell in charts.line(aircraft, table).strip()[1:-1].split("|")]
    of_the_run = ("time s", "commit")
    numbers = zip(printed.items(), found, strict=True)
    assert [(n, x) for (n, x), y in numbers if x != y and n not in of_the_run] == []
