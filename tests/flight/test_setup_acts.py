"""What is set in a setup acts, or is refused with what to set instead."""

import pytest

from pathsim_jsbsim_blocks import Aircraft, JSBSimFDM, ParameterError, TrimCondition
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.flight import Airframe, trim
from pathsim_jsbsim_blocks.studies import trim_sweep

LEVEL = {"altitude": 5000, "speed": 90}
WIND = "atmosphere/wind-north-fps"

WAYS_IN = {
    "setup": lambda setup: Aircraft("c172p", **LEVEL, setup=setup),
    "condition": lambda setup: Aircraft("c172p", condition=TrimCondition(**LEVEL, setup=setup)),
    "fdm": lambda setup: JSBSimFDM(
        aircraft_model="c172p", trim_altitude=5000, trim_airspeed=90, setup=setup
    ),
    "no trim": lambda setup: Aircraft("c172p", **LEVEL, mode="none", setup=setup),
    "airframe": lambda setup: trim(Airframe("c172p"), TrimCondition(**LEVEL), setup),
    "sweep": lambda setup: trim_sweep("c172p", {**LEVEL, **setup}, jobs=1, progress=False),
}


@pytest.mark.parametrize("wind", [30.0, 5e-4])  # ft/s; a little is no rounding
@pytest.mark.parametrize("way", WAYS_IN)
def test_a_wind_that_would_vanish_is_refused_however_it_comes(way, wind):
    with pytest.raises(ParameterError) as error:
        WAYS_IN[way]({WIND: wind})
    assert (error.value.parameter, error.value.value) == ("setup", WIND)


# property, value, what else the condition has, what to set instead
@pytest.mark.parametrize(
    ("name", "value", "more", "instead"),
    [
        ("atmosphere/wind-mag-fps", 30.0, {}, "wind_north"),
        ("atmosphere/psiw-rad", 1.0, {}, "wind_north"),
        ("position/h-sl-ft", 3000.0, {}, "set altitude"),
        ("ic/theta-deg", 1.0, {}, "set gamma"),
        ("ic/vt-fps", 1.0, {}, "set speed"),
        ("ic/vn-fps", 1.0, {}, "heading of the condition"),
        ("ic/vw-mag-fps", 1.0, {}, "wind_north"),
        ("position/lat-gc-deg", 3.0, {}, "set latitude"),
        ("ic/terrain-elevation-ft", 300.0, {"mode": "ground", "altitude": 0.0}, "set altitude"),
        ("fcs/throttle-cmd-norm", 0.3, {"throttle": 0.6, "free": "gamma"}, "set throttle"),
        ("fcs/throttle-cmd-norm", 0.3, {"mode": "glide"}, "set throttle"),
        ("fcs/flap-pos-norm", 0.5, {}, "set flaps"),
        # the same water at 5,000 ft is 81 %
        ("atmosphere/RH", 50.0, {}, "after the trim"),
        # JSBSim keeps it beside the state, which a trim makes
        ("ic/p-rad_sec", 0.1, {}, "mode='none'"),
        ("ic/w-fps", 6.0, {}, "mode='none'"),
        ("ic/vd-fps", -3.0, {}, "mode='none'"),
    ],
)
def test_what_no_longer_has_its_value_is_refused(name, value, more, instead):
    with pytest.raises(ParameterError, match=instead) as error:
        trim(Airframe("c172p"), TrimCondition(**{**LEVEL, **more}, setup={name: value}))
    assert (error.value.parameter, error.value.value) == ("setup", name)


@pytest.mark.parametrize(
    ("setup", "more"),
    [
        # cannot be read
        ({"propulsion/fuel_freeze": 1.0, "propulsion/magneto_cmd": 3.0}, {}),
        ({"propulsion/set-running": -1.0}, {}),
        # solved for
        ({"fcs/throttle-cmd-norm": 0.3, "fcs/pitch-trim-cmd-norm": 0.1}, {}),
        ({"fcs/throttle-cmd-norm[0]": 0.3, "fcs/rudder-cmd-norm": 0.1}, {"solver": "jsbsim"}),
        # the same as the condition has
        ({"ic/h-sl-ft": 5000.0, "ic/vc-kts": 90.0}, {}),
        ({"ic/terrain-elevation-ft": 300.0}, {}),
        ({"ic/terrain-elevation-ft": 300.0}, {"mode": "ground", "altitude": 300.0}),
        ({"propulsion/tank[1]/contents-lbs": 77.7, "atmosphere/delta-T": 20.0}, {}),
        ({"ic/vn-fps": 200.0, "ic/q-rad_sec": 0.1}, {"mode": "none"}),
    ],
)
def test_what_acts_is_not_refused(setup, more):
    trim(Airframe("c172p"), TrimCondition(**{**LEVEL, **more}), setup)


def test_the_command_line_has_the_wind_of_a_condition(capsys):
    level = ["--altitude", "5000", "--speed", "90"]
    assert main(["trim", "c172p", *level, "--set", f"{WIND}=30"]) == 1
    assert "wind_north" in capsys.readouterr().err
    command = ["properties", "c172p", "atmosphere/total-wind", *level]
    assert main([*command, "--wind-north", "30", "--wind-east", "-10"]) == 0
    lines = capsys.readouterr().out.splitlines()
    wind = {name: float(value) for name, _, value in map(str.split, lines)}
    assert wind["atmosphere/total-wind-north-fps"] == pytest.approx(30.0)
    assert wind["atmosphere/total-wind-east-fps"] == pytest.approx(-10.0)
