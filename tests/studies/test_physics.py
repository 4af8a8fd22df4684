"""Invariants of performance tables: what a chart prints as a value obeys physics, or is marked."""

import math

import pandas as pd
import pytest

from pathsim_jsbsim_blocks.flight.model_files import ModelFile
from pathsim_jsbsim_blocks.studies import performance_chart, performance_table
from pathsim_jsbsim_blocks.studies.performance import COLUMNS
from pathsim_jsbsim_blocks.studies.physics import mark_faults


def rows(quantity, **columns):
    """Rows of one quantity; each column is a list."""
    return [
        {"quantity": quantity, **dict(zip(columns, values, strict=True))}
        for values in zip(*columns.values(), strict=True)
    ]


def marked(*parts, **options):
    table = pd.DataFrame([row for part in parts for row in part], columns=list(COLUMNS))
    return [bool(fault) for fault in mark_faults(table, **options).fault]


PC7 = {"weight_lb": [2969.0, 4443.0, 4806.0], "flaps_norm": [0.0] * 3}


def test_stall_speed_grows_with_the_weight_and_falls_with_the_flaps():
    # as the pc7's were printed at 0.4.0; speed grows with the root of the weight
    assert marked(rows("stall speed", value=[54.0, 89.0, 69.0], **PC7)) == [False, True, True]
    sound = [54.0 * math.sqrt(w / 2969.0) for w in PC7["weight_lb"]]
    assert marked(rows("stall speed", value=sound, **PC7)) == [False] * 3
    assert marked(rows("stall speed", value=[54.0, math.nan, 53.0], **PC7)) == [True, False, True]
    flaps = {"weight_lb": [4443.0] * 3, "flaps_norm": [0.0, 0.5, 1.0]}
    assert marked(rows("stall speed", value=[89.0, 88.0, 108.0], **flaps)) == [False, False, True]


def test_the_airspeed_at_the_lift_limit_grows_with_the_load_factor():
    # as the XB-70's were printed at 82622b96; speed grows with the root of the load factor
    factors = [0.5, 1.0, 1.5, 2.0, 2.5, -0.5, -1.0]
    folded = [165.0, 155.4, 142.9, 154.1, 173.3, 200.0, 190.0]
    limit = {"weight_lb": [534000.0] * 7, "load_factor": factors}
    faults = [True, True, False, False, False, True, True]
    assert marked(rows("speed at the lift limit", value=folded, **limit)) == faults
    sound = [142.9 * math.sqrt(abs(n) / 1.5) for n in factors]
    assert marked(rows("speed at the lift limit", value=sound, **limit)) == [False] * 7


def test_no_glide_climbs():
    sinks = rows("sink rate", value=[900.0, -10.0], speed_kcas=[80.0, 90.0])
    assert marked(sinks, rows("least sink rate", value=[-10.0])) == [False, True, True]


def test_climb_falls_with_the_altitude_without_a_supercharger():
    climb = rows("best rate of climb", value=[700.0, 500.0, 800.0], altitude_ft=[0.0, 5e3, 1e4])
    for row in climb:
        row["weight_lb"] = 2000.0
    assert marked(climb, unsupercharged=True) == [False, False, True]
    assert marked(climb) == [False] * 3
    # below the ceiling of 0 ft rates are negative
    for row, rate in zip(climb, (-75.0, -76.0, -200.0), strict=True):
        row["value"] = rate
    assert marked(climb, unsupercharged=True) == [False] * 3


def test_turns_are_within_the_limit_of_the_table():
    limit = rows("speed at the lift limit", value=[52.0, 101.0], load_factor=[1.0, 3.8])
    turns = rows("instantaneous load factor", value=[3.7, 4.4])
    assert marked(limit, turns) == [False, False, False, True]
    assert marked(turns) == [False, False]


@pytest.mark.parametrize(
    ("aircraft", "boosted"), [("c172p", False), ("p51d", True), ("737", False)]
)
def test_superchargers(aircraft, boosted):
    # by eye: <numboostspeeds> of Packard-V-1650-7.xml
    assert ModelFile(aircraft, None).xml.supercharged == boosted


def test_a_fault_is_drawn_hollow_and_named():
    stall = rows("stall speed", value=[54.0, 89.0, 69.0], chart=["stall"] * 3, **PC7)
    table = mark_faults(pd.DataFrame(stall, columns=list(COLUMNS)))
    figure = performance_chart(table, charts=["stall"])
    line, hollow = figure.axes[0].lines
    assert [*hollow.get_xdata()] == [4443.0, 4806.0]
    assert hollow.get_markerfacecolor() != line.get_color()
    assert figure.get_supxlabel() == "hollow: the stall speed falls with the weight (stall speed)"


def test_a_lift_limit_that_folds_back_is_drawn_hollow():
    limit = {"load_factor": [0.5, 1.0, 1.5], "weight_lb": [534000.0] * 3, "chart": ["V-n"] * 3}
    folded = rows("speed at the lift limit", value=[165.0, 155.4, 142.9], **limit)
    table = mark_faults(pd.DataFrame(folded, columns=list(COLUMNS)))
    _, hollow = performance_chart(table, charts=["V-n"]).axes[0].lines
    # each contradicts the two others
    assert [*hollow.get_xdata()] == [165.0, 155.4, 142.9]
    assert [*hollow.get_ydata()] == [0.5, 1.0, 1.5]


def test_the_value_that_contradicts_most_is_the_fault():
    # the pc7 at 1195b2d8: eight of nine grow with the root of the weight
    weights, flaps = [2969.0, 4443.0, 4806.0], [0.0, 0.5, 1.0]
    speeds = [54.3, 52.2, 104.3, 66.5, 63.9, 61.6, 69.2, 66.4, 64.0]
    pc7 = {"weight_lb": [w for w in weights for _ in flaps], "flaps_norm": 3 * flaps}
    pc7["reason"] = 9 * ["no convergence"]
    table = pd.DataFrame(rows("stall speed", value=speeds, **pc7), columns=list(COLUMNS))
    mark_faults(table)
    assert [*table.index[table.fault != ""]] == [2]
    # where a search gave up there is no value
    assert [*table.index[table.value.isna()]] == [2]


def test_of_two_that_contradict_the_fault_is_where_the_search_gave_up():
    x15 = {"weight_lb": [14566.0, 14972.0, 22796.0], "flaps_norm": [0.0] * 3}
    x15["reason"] = ["no convergence", "no convergence", "alpha limit"]
    assert marked(rows("stall speed", value=[175.7, 173.6, 160.0], **x15)) == [True, True, False]


@pytest.mark.long
def test_a_service_ceiling_is_not_above_the_absolute_one():
    # the f15's climb ends abruptly, above 500 ft/min
    table = performance_table("f15", altitudes=0.0, flaps=0.0, parts=["ceiling"], progress=False)
    ceiling = table.set_index("quantity").value
    assert 40e3 < ceiling["service ceiling"] <= ceiling["absolute ceiling"]


@pytest.mark.long
def test_stall_speeds_of_an_x15_grow_with_the_weight():
    table = performance_table("X15", altitudes=0.0, flaps=0.0, parts=["stall"], progress=False)
    stall = table[table.quantity == "stall speed"].sort_values("weight_lb")
    assert len(stall) == 3
    assert stall.value.dropna().is_monotonic_increasing
    assert stall.value.isna().any()
