"""The glides of the study equal glides that are flown from fresh take-offs, without a branch."""

import os

import pytest

from pathsim_jsbsim_blocks.studies import engine_failure, engine_failure_chart
from pathsim_jsbsim_blocks.studies.failure import INSTANTS, WAYS
from pathsim_jsbsim_blocks.studies.take_off import TakeOff

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork"),
]


def test_glides_equal_those_of_fresh_take_offs():
    table = engine_failure(progress=False)
    assert len(table.groupby(["failure_s", "way"])) == len(INSTANTS) * len(WAYS) == 24
    for time, way in ((20, "left turn"), (30, "right turn"), (30, "straight ahead")):
        flight = TakeOff.build()
        for instant in range(10, time + 1, 10):
            flight.until(instant)
        rows = table[(table.failure_s == time) & (table.way == way)]
        assert rows.drop(columns=["failure_s", "way"]).to_dict("records") == flight.glide(WAYS[way])
    last = table.groupby(["way", "failure_s"]).last()
    # a higher failure leaves more height at the threshold, and the turn into the wind too
    for way in ("left turn", "right turn"):
        assert last.height_ft[way].is_monotonic_increasing
        assert last.distance_ft[way].loc[20:].max() < 150.0
    assert (last.height_ft["left turn"] > last.height_ft["right turn"]).all()
    assert (last.height_ft["straight ahead"].abs() < 10.0).all()
    # without power the airspeed is the one commanded, and the path that of the model's glide
    glide = table[(table.way == "straight ahead") & (table.failure_s == 80)].iloc[-100:]
    assert glide.speed_kcas.between(66, 70).all()
    figure = engine_failure_chart(table)
    assert len(figure.axes[0].lines) == 2 * 24 + 1
