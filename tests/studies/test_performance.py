"""Performance charts: values against plain JSBSim loops and printed formulas; bad input."""

import dataclasses
import functools
import importlib
import math
from pathlib import Path

import numpy as np
import pandas
import pytest
from how_many import first
from plain_jsbsim import open_fdm

from pathsim_jsbsim_blocks import ParameterError, TrimCondition, TrimError
from pathsim_jsbsim_blocks.flight import Airframe, trim
from pathsim_jsbsim_blocks.studies import performance_chart, performance_table
from pathsim_jsbsim_blocks.studies.flight_tests import Plane, climb_rate

NO_GROUND = {"ic/terrain-elevation-ft": -5000.0}


@functools.cache
def table(aircraft, *parts, altitude=0.0, **axes):
    """Parts of the performance at one altitude, without flaps, computed once."""
    axes = {"altitudes": altitude, "flaps": 0.0, **axes}
    return performance_table(aircraft, **axes, parts=parts, jobs=1, progress=False)


def value(rows, quantity):
    """The only row of a quantity."""
    (row,) = rows[rows.quantity == quantity].itertuples()
    return row


def as_it_is(aircraft, altitude):
    """A plane at the model's own weight, without flaps."""
    task = {"aircraft": aircraft, "root": None, "create": None, "weight": None, "flaps": 0.0}
    return Plane(task | {"altitude": altitude})


def plain_flight(aircraft, state, seconds, elevator=0.0):
    """Rows of a plain JSBSim loop from a trim: energy height, lift factor, qbar, alpha."""
    fdm = open_fdm(aircraft, 1 / 120, {"propulsion/fuel_freeze": 1.0, **NO_GROUND})
    fdm["ic/h-sl-ft"] = state.altitude
    fdm["ic/vc-kts"] = state.speed
    fdm["ic/gamma-deg"], fdm["ic/alpha-deg"] = state.gamma, state.alpha
    fdm["ic/phi-deg"] = state.phi
    fdm["propulsion/set-running"] = -1
    fdm.run_ic()
    for name in ("pitch_trim", "elevator", "aileron", "rudder"):
        fdm[f"fcs/{name.replace('_', '-')}-cmd-norm"] = getattr(state, name)
    for throttle in state.throttle:
        fdm["fcs/throttle-cmd-norm"] = throttle
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


def test_a_mixture_that_the_model_sets_itself_is_left_to_it():
    assert table("c172x", "stall").value.notna().all()


@pytest.mark.long
def test_climb_is_that_of_a_plain_loop():
    climbs = table("c172p", "level", altitude=5000.0).query("quantity == 'rate of climb'")
    row = climbs.iloc[abs(climbs.speed_kcas - 80.0).argmin()]
    # leaned in proportion to the density of the standard atmosphere
    setup = {"fcs/mixture-cmd-norm[0]": 0.8617, **NO_GROUND}
    condition = TrimCondition(altitude=5000, speed=row.speed_kcas, throttle=1.0, setup=setup)
    energy = plain_flight("c172p", trim(Airframe("c172p"), condition, hint=False), 30.0)[0]
    # from 5 s on, when the engine that JSBSim starts turns fast; over the climb the rate falls
    rate = 60.0 * (energy[-1] - energy[600]) / 25.0
    assert row.value == pytest.approx(rate, rel=0.03)
    assert row.value > 1000.0


def glides(aircraft, speeds):
    """Trims at sea level with the throttle closed, gear up, at airspeeds in KCAS."""
    airframe = Airframe(aircraft)
    at = {"altitude": 0.0, "mode": "glide", "gear": 0.0, "setup": NO_GROUND}
    return [trim(airframe, TrimCondition(speed=v, **at), hint=False) for v in speeds]


def test_stall_is_that_of_a_plain_deceleration():
    row = value(table("sgs126", "stall"), "stall speed")
    (start,) = glides("sgs126", [1.15 * row.speed_kcas])
    _, n, q, _ = plain_flight("sgs126", start, 20.0, elevator=-0.02)
    knots = math.sqrt(1.0 / (n / q).max() / 0.5 / 0.0023769) / 1.68781
    assert row.value == pytest.approx(knots, rel=0.01)
    assert row.flown == pytest.approx(row.value, rel=0.01)


def test_a_pull_that_does_not_stall_has_no_flown_stall_speed():
    # half the elevator: the lift of the unstalled flight is not the maximum lift
    plane = as_it_is("sgs126", 0.0)
    slow = plane.slowest()
    start = plane.glide(1.15 * slow.speed)
    elevator = 0.5 * (start.pitch_trim + start.elevator - slow.pitch_trim + slow.elevator)
    weak = dataclasses.replace(slow, elevator=elevator)
    assert plane.lift_flown(start, slow, 10.0) == pytest.approx(1.0, rel=0.02)
    assert plane.lift_flown(start, weak, 10.0) is None


def test_an_airliner_with_full_flaps_stalls_by_its_weight():
    """Below a lift coefficient of 1.2 the angle of attack would be under the model's least."""
    rows = table("B747", "stall", flaps=1.0)
    assert rows.weight_lb.nunique() == 3
    assert rows.flown.to_numpy() == pytest.approx(rows.value, rel=0.01)
    assert rows.value.max() < 125.0
    # one lift coefficient
    assert np.ptp(rows.value**2 / rows.weight_lb) < 0.01 * (rows.value**2 / rows.weight_lb).min()


@pytest.mark.long
def test_take_off_run_is_that_of_a_plain_loop():
    """With the nose wheel on the ground, from rest to the airspeed of the lift-off."""
    rows = table("c172p", "field")
    roll = value(rows, "take-off ground roll")
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
        if fdm["velocities/vc-kts"] > roll.speed_kcas:
            break
    assert roll.value == pytest.approx(way, rel=0.1)
    assert value(rows, "take-off distance").value > roll.value + 200.0
    landing = value(rows, "landing ground roll")
    assert 200.0 < landing.value < 700.0
    assert 0.9 * 46 < landing.speed_kcas < 60.0


@pytest.mark.parametrize(
    ("aircraft", "altitude"),
    first(
        [
            ("c172p", 5000.0),
            ("Concorde", 0.0),  # its collector tanks are empty after 12 s
            ("XB-70", 0.0),  # it pitches up after 16 s with its controls fixed
            ("F4N", 30e3),  # its afterburner has too much thrust for level flight
        ]
    ),
)
def test_flights_have_the_values_of_the_trims(aircraft, altitude):
    rows = table(aircraft, "level", altitude=altitude)
    assert rows.difference_percent.count() > 9
    assert rows.difference_percent.abs().max() < 1.0
    if aircraft == "F4N":
        assert value(rows, "highest level Mach number").value > 1.1


@pytest.mark.parametrize(
    ("aircraft", "altitude", "kind", "speed"),
    [
        ("Concorde", 20e3, "climb", 942.0),  # 26,000 ft/min
        ("f104", 30e3, "glide", 347.0),  # 9000 ft/min
        ("p51d", 5e3, "glide", 121.0),  # its engine stands in the glide, and runs in a pull-up
    ],
)
def test_a_steep_flight_has_the_rate_of_its_trim(aircraft, altitude, kind, speed):
    plane = as_it_is(aircraft, altitude)
    state = getattr(plane, kind)(speed)
    assert plane.energy_rate(state) == pytest.approx(climb_rate(state), rel=0.005)


def test_engines_of_a_c310_idle_at_two_speeds():
    plane = as_it_is("c310", 0.0)
    glides, rpm = [], []
    for _ in range(2):
        glides.append(plane.glide(95.8))
        rpm.append(plane.airframe.fdm["propulsion/engine[0]/propeller-rpm"])
        plane.trim(95.8, mode="pull-up", throttle=0.0, load_factor=0.99)
    assert rpm == pytest.approx([759.0, 952.0], abs=1.0)
    assert climb_rate(glides[0]) < 1.1 * climb_rate(glides[1])


def test_an_sgs_glides_at_two_angles_of_attack():
    # its tables end at -1 deg: beyond, lift and drag are those of the end
    plane = as_it_is("SGS", 15e3)
    inside = plane.glide(57.48)
    for speed in (58.24, 58.5, 57.99, 57.73):
        plane.glide(speed)
    beyond = plane.glide(57.48)
    assert inside.alpha == pytest.approx(-0.7, abs=0.05)
    assert beyond.alpha == pytest.approx(-4.4, abs=0.1)


def test_a_shuttle_has_stall_speeds():
    # it glides at a lift coefficient of 0.15, not at 0.25
    assert table("Shuttle", "stall").value.notna().all()


@pytest.mark.long
def test_a_turn_that_leaves_its_airspeed_has_no_flown_rate():
    # the Camel loses 22 kt in 10 s
    rows = table("Camel", "turn")
    row = value(rows[rows.reason.str.contains("does not stay")], "sustained turn rate")
    assert math.isnan(row.flown)
    assert row.value > 10.0


@pytest.mark.long
def test_a_model_that_climbs_ever_better_has_no_ceiling():
    """The table of the F4N's engine ends at 50,000 ft."""
    for reason in table("F4N", "ceiling", altitude=5000.0).reason:
        assert reason == "above 90000 ft: its rate of climb has its minimum at 55000 ft"


def test_a_chart_resumes_from_its_file(tmp_path):
    file = tmp_path / "sgs126.jsonl"
    assert table("sgs126", "stall", resume=file).equals(table("sgs126", "stall"))
    with pytest.raises(ParameterError) as error:
        table("sgs126", "ceiling", resume=file)
    assert error.value.parameter == "resume"


@pytest.mark.long
def test_gust_lines_are_those_of_the_printed_formula():
    rows = table("c172p", "V-n")
    gust, cruise = (value(rows, name) for name in ("gust load factor at VC", "VC"))
    at = {"altitude": 0.0, "speed": gust.speed_kcas, "mode": "pull-up", "throttle": 0.0}
    one, more = (
        trim(Airframe("c172p"), TrimCondition(**at, load_factor=n, setup=NO_GROUND), hint=False)
        for n in (1.0, 1.2)
    )
    wing = 1880.0 / 174.0
    slope = 0.2 * wing / (0.5 * 0.0023769 * one.tas**2) / math.radians(more.alpha - one.alpha)
    mu = 2.0 * wing / (0.0023769 * 4.9 * slope * 32.2)
    # CS 23.341 in the units of 14 CFR 23.341 (1996): knots, ft/s, lb/ft2
    n = 1.0 + 0.88 * mu / (5.3 + mu) * 50.0 * cruise.value * slope / (498.0 * wing)
    assert gust.value == pytest.approx(n, rel=0.005)


@pytest.mark.parametrize(
    ("aircraft", "high", "low"),
    [
        ("T38", 2.1 + 24000.0 / 21474.0, -0.4 * (2.1 + 24000.0 / 21474.0)),  # CS 23.337, 11,474 lb
        ("737", 2.5, -1.0),  # CS 25.337
        ("SGS", 5.3, -2.65),  # CS 22.337, utility
    ],
)
def test_load_factors_end_at_those_of_the_regulations(aircraft, high, low):
    rows = table(aircraft, "V-n").query("quantity == 'speed at the lift limit'")
    assert [rows.load_factor.max(), rows.load_factor.min()] == pytest.approx([high, low], rel=1e-4)


def test_a_pull_reaches_the_lift_limit():
    (limit,) = table("c172p", "V-n").query("load_factor == 2.0").itertuples()
    assert limit.flown == pytest.approx(limit.value, rel=0.01)


def test_a_c172p_has_a_negative_lift_limit():
    (speed,) = table("c172p", "V-n").query("load_factor == -0.5").value
    # at -5 deg, the model's limit, its table has CL = -0.206, and 0.43 per rad of elevator, 23 deg
    keas = [math.sqrt(940.0 / (c * 0.5 * 0.0023769 * 174.0)) / 1.68781 for c in (0.206, 0.033)]
    assert keas[0] < speed < keas[1]


def test_a_trim_keeps_the_mixture_that_it_is_given():
    plane = Airframe("c172p")
    climb = {"altitude": 9000, "speed": 75, "throttle": 1.0}
    rich = trim(plane, TrimCondition(**climb), hint=False)
    lean = trim(plane, TrimCondition(**climb, setup={"fcs/mixture-cmd-norm": 0.77}), hint=False)
    assert plane.fdm["fcs/mixture-cmd-norm"] == 0.77
    # JSBSim's engine drowns in full rich mixture at this altitude
    assert lean.thrust > 2.0 * rich.thrust


@pytest.mark.parametrize(
    ("aircraft", "part", "axes", "reason"),
    [
        ("c172p", "stall", {"weights": 9e9}, "not 9,000,000,000 lb"),
        ("c172p", "stall", {"weights": 500.0}, "from 1,518 lb"),
        ("sgs126", "ceiling", {}, "no engine"),
        ("sgs126", "field", {}, "no gain table"),
        # with 5 % of its fuel and without payload it has 1e-13 lb less than its own weight
        pytest.param("Short_S23", "stall", {}, "alpha limit", marks=pytest.mark.long),
        # the drag of the T37's model grows with alpha itself, not with its square
        pytest.param("T37", "level", {}, "L/D still increases", marks=pytest.mark.long),
        # its engine gives thrust at any throttle
        pytest.param("Camel", "level", {}, "climbs with the throttle", marks=pytest.mark.long),
    ],
)
def test_the_reason_for_a_missing_value_is_in_the_table(aircraft, part, axes, reason):
    rows = table(aircraft, part, **axes)
    missing = rows[rows.quantity == "best glide ratio"] if part == "level" else rows
    assert missing.value.isna().all()
    assert missing.reason.str.contains(reason).all()
    assert len(missing)


@pytest.mark.parametrize(
    ("axes", "parameter"),
    [
        ({"weights": -1.0}, "weight"),
        ({"flaps": [0.0, 2.0]}, "flaps"),
        ({"altitudes": []}, "altitude"),
        ({"altitudes": [[0.0]]}, "altitude"),
        ({"altitudes": 1e9}, "altitude"),
        ({"parts": ["climb"]}, "parts"),
        ({"parts": "stall"}, "parts"),
        ({"parts": []}, "parts"),
    ],
)
def test_bad_numbers_are_refused_at_once(axes, parameter):
    with pytest.raises(ParameterError) as error:
        performance_table("c172p", **axes)
    assert error.value.parameter == parameter


def lift_over_drag(aircraft, glide):
    """Of a model's aerodynamics alone, with the angle of attack and the elevator of a glide."""
    fdm = open_fdm(aircraft, 1 / 120, NO_GROUND)
    fdm["ic/h-sl-ft"], fdm["ic/vc-kts"] = 0.0, glide.speed
    fdm["ic/alpha-deg"], fdm["fcs/elevator-cmd-norm"] = glide.alpha, glide.elevator
    fdm["fcs/pitch-trim-cmd-norm"] = glide.pitch_trim
    fdm["gear/gear-pos-norm"] = fdm["gear/gear-cmd-norm"] = 0.0
    fdm.set_trim_status(True)
    fdm.run_ic()
    return fdm["forces/fwz-aero-lbs"] / fdm["forces/fwx-aero-lbs"]


@pytest.mark.parametrize("aircraft", ["sgs126", pytest.param("737", marks=pytest.mark.long)])
def test_the_best_glide_is_the_largest_lift_over_drag_of_the_model(aircraft):
    """Not the flattest path of a 737, to which the thrust of its idling engines adds."""
    rows = table(aircraft, "level")
    best = value(rows, "best glide ratio")
    slow = value(rows, "stall speed, throttle closed").speed_kcas
    flights = glides(aircraft, slow * np.arange(1.04, 2.0, 0.04))
    ratios = {glide.speed: lift_over_drag(aircraft, glide) for glide in flights}
    # the elevator moves in the first moment, which this leaves out
    assert best.value == pytest.approx(max(ratios.values()), rel=0.01)
    assert best.speed_kcas == pytest.approx(max(ratios, key=ratios.get), rel=0.03)
    assert best.flown == pytest.approx(best.value, rel=0.02)


@pytest.mark.long
@pytest.mark.parametrize(
    ("aircraft", "altitude"),
    [
        ("T37", 300.0),
        ("A4", 0.0),  # with the path angle free, its turns of the highest rate are spiral descents
        ("f15", 0.0),
    ],
)
def test_an_instantaneous_turn_is_at_least_the_sustained_one(aircraft, altitude):
    turns = table(aircraft, "turn", altitude=altitude)
    turns = turns.pivot(index="speed_kcas", columns="quantity", values="value")
    assert len(turns) == 6
    turns = turns.dropna(subset=["sustained turn rate"])
    assert len(turns) >= 4
    for name in ("load factor", "turn rate"):
        assert (turns[f"instantaneous {name}"] >= turns[f"sustained {name}"]).all()
    assert (turns["instantaneous turn radius"] <= turns["sustained turn radius"]).all()
    for kind in ("sustained", "instantaneous"):
        # v = omega r, and the force that bends the path, in any turn
        pull = np.radians(turns[f"{kind} turn rate"]) ** 2 * turns[f"{kind} turn radius"] / 32.174
        assert (turns[f"{kind} load factor"] <= np.hypot(1.0, pull) + 1e-6).all()


def test_an_airspeed_without_trim_is_left_out_and_named(monkeypatch):
    def search(airframe, condition, **options):
        if 45.0 < condition.speed < 50.0:
            raise TrimError("", aircraft="", condition=condition, residuals={}, reason="thrust")
        return trim(airframe, condition, **options)

    monkeypatch.setattr("pathsim_jsbsim_blocks.studies.flight_tests.trim", search)
    rows = table("sgs126", "level", weights=445.0)
    (gap,) = rows[rows.value.isna() & (rows.quantity == "sink rate")].itertuples()
    assert (round(gap.speed_kcas), gap.reason) == (48, "thrust")
    figure = performance_chart(rows)
    assert figure.get_supxlabel().startswith("left out: sink rate at 48 KCAS (")
    (line,) = figure.axes[6].lines
    assert not any(45.0 < x < 50.0 for x in line.get_xdata())


def drawn(*rows):
    """The page of a table with these rows."""
    columns = table("sgs126", "stall").columns
    return performance_chart(pandas.DataFrame(rows, columns=columns))


def test_the_page_of_a_table_without_values_shows_the_reasons():
    figure = drawn({"chart": "turn", "quantity": "sustained load factor", "reason": "no engine"})
    figure.draw_without_rendering()  # matplotlib warns of a layout in which panels have no room
    texts = [text.get_text() for ax in figure.axes for text in ax.texts]
    assert "no turn chart:\nno engine" in texts
    with pytest.raises(ParameterError) as error:
        performance_chart(pandas.DataFrame({"a": [1]}))
    assert error.value.parameter == "table"


def limits_drawn(*points):
    rows = [
        {"chart": "V-n", "quantity": "speed at the lift limit", "load_factor": n, "value": keas}
        for n, keas in points
    ]
    return drawn(*rows, {"chart": "V-n", "quantity": "VD", "value": 150.0}).axes[1].lines


def test_lift_limit_is_a_parabola_that_ends_flat_only_at_the_limit_load_factor():
    up, down = limits_drawn((1.0, 50.0), (4.0, 100.0), (-0.5, 70.0), (-1.5, math.nan))
    speed, n = up.get_data()
    assert np.interp(25.0, speed, n) == pytest.approx(0.25, abs=0.01)  # (25 / 50) ** 2
    assert (speed[-1], n[-1], n[-2]) == (150.0, 4.0, 4.0)
    speed, n = down.get_data()
    assert (speed[-1], n[-1]) == (70.0, pytest.approx(-0.5))
    # without positive load factors there is no legend, of which matplotlib would warn
    (only,) = limits_drawn((1.0, math.nan), (-0.5, 70.0))
    assert only.get_ydata()[-1] == pytest.approx(-0.5)


@pytest.mark.long
@pytest.mark.parametrize("aircraft", ["sgs126", "X15"])
def test_the_page_of_the_fleet_is_current(aircraft, monkeypatch):
    docs = Path(__file__).parents[2] / "docs"
    monkeypatch.syspath_prepend(docs)
    charts = importlib.import_module("performance_charts")
    table = performance_table(aircraft, progress=False).assign(seconds=0.0, commit="")
    (printed,) = (r for r in charts.read_table("performance") if r["aircraft"] == aircraft)
    of_the_run = {"time s": "", "commit": ""}
    assert charts.table_row(aircraft, table) | of_the_run == printed | of_the_run
