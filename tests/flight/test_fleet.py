"""Every aircraft of jsbsim: level flight found, flown and compared, or the reason why not."""

import csv
import dataclasses
import importlib
import math
import re
from pathlib import Path

import numpy as np
import pytest
from fleet_conditions import BY_NEWTON, FLYING, NOT_FLYING, setup
from how_many import first
from pathsim.blocks import Source
from plain_jsbsim import fly, trimmed
from plane_diagram import diagram

from pathsim_jsbsim_blocks import AircraftError, JSBSimFDM, ParameterError, TrimError
from pathsim_jsbsim_blocks.flight import Airframe, aircraft_names
from pathsim_jsbsim_blocks.flight.fleet import TRIES, first_trim, level_flight, prepared

DOCS = Path(__file__).parents[2] / "docs"
INPUTS = ["fcs/elevator-cmd-norm", "fcs/aileron-cmd-norm"]
OUTPUTS = [
    "aero/alpha-deg",
    "attitude/theta-deg",
    "attitude/phi-deg",
    "velocities/vt-fps",
    "position/h-sl-ft",
    "position/lat-geod-deg",
    "simulation/sim-time-sec",
]


@pytest.fixture
def table(monkeypatch):
    """The module that writes the table of docs/evidence/fleet.csv."""
    monkeypatch.syspath_prepend(DOCS)
    return importlib.import_module("fleet")


def test_every_model_is_listed_and_forty_four_trim():
    assert sorted([*FLYING, *NOT_FLYING]) == sorted(aircraft_names())
    assert set(BY_NEWTON) <= set(NOT_FLYING)
    assert len(FLYING) + len(BY_NEWTON) >= 44


@pytest.mark.parametrize("tries", [0, 1.5])
def test_level_flight_is_tried_once_at_least(tries):
    with pytest.raises(ParameterError) as error:
        level_flight("c172p", tries=tries)
    assert (error.value.parameter, error.value.value) == ("tries", tries)


@pytest.mark.parametrize(
    "aircraft", first(sorted(BY_NEWTON, key=lambda name: name not in ("SGS", "dr1", "X15")), 3)
)
def test_the_newton_search_finds_what_jsbsim_does_not(aircraft, table):
    (row,) = table.fleet_table([aircraft], duration=10.0)
    assert row.flight is not None
    assert (row.flight.condition.mode, row.flight.condition.speed) == BY_NEWTON[aircraft]
    for axis in "uvw":
        assert abs(getattr(row.flight.trim, f"{axis}dot")) <= 1e-4  # ft/s2
    for axis in "pqr":
        assert abs(getattr(row.flight.trim, f"{axis}dot")) <= 1e-5  # rad/s2
    if aircraft in ("SGS", "dr1", "sgs126", "sgs233"):
        assert row.verdict.startswith(("trims", "glides"))
        assert abs(row.drift) < 1.0


def test_the_newton_search_can_be_asked_for():
    flight = level_flight("dr1", solver="newton")
    assert flight.condition.solver == "newton"
    assert ("full", flight.condition.speed) == BY_NEWTON["dr1"]


@pytest.mark.parametrize(
    "aircraft", first(sorted(FLYING, key=lambda n: n not in ("f16", "L17")), 2)
)
def test_level_flight_is_a_plain_loop(aircraft):
    flight = level_flight(aircraft)
    altitude, speed, gear, create = FLYING[aircraft]
    if aircraft == "Short_S23":
        assert flight.condition.altitude == 5000
        return  # JSBSim's own search does not find it there
    assert (flight.condition.altitude, flight.condition.speed) == (altitude, speed)
    assert flight.condition.gear == gear
    assert set(flight.create) == set(create)

    airframe = Airframe(aircraft, create=flight.create)
    airframe.run_ic()
    if any(airframe.fdm[name] for name in airframe.of_engines("constant-speed-mode")):
        return  # JSBSim's own search may never end there
    fdm = JSBSimFDM(
        input_properties=INPUTS,
        output_properties=OUTPUTS,
        aircraft_model=aircraft,
        condition=dataclasses.replace(flight.condition, solver="jsbsim"),
        create=flight.create,
    )
    # small enough for every aircraft to stay in the air, unstable ones included
    sources = {
        INPUTS[0]: Source(lambda t: 0.005 * math.sin(3.0 * t)),
        INPUTS[1]: Source(lambda t: 0.005 * math.sin(2.0 * t)),
    }
    sim, scope = diagram(fdm, OUTPUTS, sources, inputs=True)
    sim.run(10.0)
    y, u = np.hsplit(scope.read()[1].T, [len(OUTPUTS)])
    plain = trimmed(aircraft, altitude, speed, setup=setup(aircraft))
    assert np.array_equal(y, fly(plain, INPUTS, u[:-1], OUTPUTS))
    # a model that misses properties can be left with a frozen clock: it did fly, level and north
    assert y[-1, -1] == pytest.approx(10.0)
    assert abs(y[120, 4] - altitude) < 20.0
    # 362,776 ft per degree of latitude at the equator (WGS84); 5 % for drift in the first second
    assert (y[120, 5] - y[0, 5]) * 362776 == pytest.approx(y[0, 3], rel=0.05)


# one of each reason first
@pytest.mark.parametrize(
    ("aircraft", "reason"),
    first(
        sorted(
            (item for item in NOT_FLYING.items() if BY_NEWTON.get(item[0], "")[:1] != ("full",)),
            key=lambda item: item[0] not in ("ball", "blank", "f22", "ZLT-NT", "Pterosaur"),
        ),
        5,
    ),
)
def test_the_others_say_why_not(aircraft, reason):
    with pytest.raises((TrimError, AircraftError), match=re.escape(repr(aircraft))) as error:
        first_trim(*prepared(aircraft, None), TRIES[:1], mode="full")
    assert getattr(error.value, "reason", "AircraftError") == reason


def test_an_aircraft_that_does_not_stay_level_is_no_success(table):
    # its engines do not stay as they were settled
    (row,) = table.fleet_table(["XB-70"])
    assert abs(row.drift) > 20.0
    assert row.verdict == "trims, not steady"


def test_rows_of_the_table(table):
    flies, created, glides, dry, refused, broken = table.fleet_table(
        ["c172p", "L17", "SGS", "Concorde", "ball", "blank"], duration=2.0
    )
    cells = ["c172p", "1", "5000", "89", "as is", "1.39", "0.690", "+0.0"]
    assert [*table.table_row(flies).values()][:8] == cells
    assert created.verdict == "trims with `fcs/flaps-pos-deg` created"
    assert glides.verdict == "glides at -2.2 deg"
    # 46 lb in each collector tank, 4.03 lb/s
    assert dry.verdict == "trims, engines out of fuel within 60 s"
    assert refused.verdict == "no trim: thrust"
    assert math.isnan(refused.drift)
    assert broken.verdict == "does not load"
    assert broken.engines is None


def test_the_page_is_up_to_date():
    rows = [[*row.values()] for row in evidence("fleet")]
    assert [row[0] for row in rows] == aircraft_names()
    for name, _, altitude, speed, *_, verdict, _, _ in rows:
        if name in FLYING:
            # JSBSim's search does not find the Short_S23's at 5,000 ft
            expected = (5000, 130) if name == "Short_S23" else FLYING[name][:2]
            assert (float(altitude), float(speed)) == expected
            assert verdict.startswith("trims")
        elif name in BY_NEWTON:
            mode, knots = BY_NEWTON[name]
            assert float(speed) == knots
            assert verdict.startswith("glides" if mode == "glide" else "trims")
        else:
            assert verdict in (f"no trim: {NOT_FLYING[name]}", "does not load")


@pytest.mark.long
@pytest.mark.parametrize("aircraft", ["737", "SGS", "L410"])
def test_rows_of_the_table_are_those_of_the_code(aircraft, table):
    (row,) = (row for row in evidence("fleet") if row["aircraft"] == aircraft)
    (made,) = table.fleet_table([aircraft])
    assert without_gaps(table.table_row(made)) == without_gaps(row)


@pytest.mark.long
@pytest.mark.parametrize("aircraft", ["c172p", "sgs126", "ah1s"])
def test_modes_of_the_table_are_those_of_the_code(aircraft, table):
    generate = importlib.import_module("generate")
    (row,) = (row for row in evidence("fleet-modes") if row["aircraft"] == aircraft)
    assert without_gaps(generate.modes_of(aircraft)) == without_gaps(row)


def without_gaps(row):
    return {column: cell for column, cell in row.items() if cell and column != "commit"}


def evidence(name):
    with (DOCS / "evidence" / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
