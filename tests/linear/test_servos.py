"""Servos with hysteresis, which no small pulse passes."""

import math

import pytest

from pathsim_jsbsim_blocks import Aircraft, LinearisationError, TrimCondition
from pathsim_jsbsim_blocks.design import design_gains
from pathsim_jsbsim_blocks.errors import DesignError
from pathsim_jsbsim_blocks.flight.model_xml import ModelXml
from pathsim_jsbsim_blocks.linear.servos import hysteresis

SLOW = TrimCondition(altitude=5000, speed=90)


# the widths are those of c172x.xml
@pytest.mark.parametrize(
    ("keywords", "name", "servos"),
    [
        ({}, "elevator", {"fcs/elevator-actuator": 0.05}),
        (
            {"inputs": ["aileron"]},
            "aileron",
            {"fcs/left-aileron-actuator": 0.005, "fcs/right-aileron-actuator": 0.005},
        ),
    ],
)
def test_the_servo_and_its_width_are_named(keywords, name, servos):
    with pytest.raises(LinearisationError) as error:
        Aircraft("c172x", condition=SLOW).linear_model(**keywords)
    assert (error.value.name, error.value.servos) == (name, servos)


def test_inputs_without_hysteresis_name_none():
    with pytest.raises(LinearisationError) as error:
        Aircraft("c172p", condition=TrimCondition(5000, 90, mode="glide")).linear_model()
    assert error.value.servos == {}


@pytest.mark.parametrize(
    ("component", "servos"),
    [
        ('<actuator name="fcs/servo"><input>fcs/a-cmd</input>{}</actuator>', ["fcs/servo"]),
        (
            '<actuator name="Left Servo"><input> -fcs/a-cmd </input>{}</actuator>',
            ["fcs/left-servo"],
        ),
        ('<actuator name="s"><input>fcs/b-cmd</input>{}</actuator>', []),
        (
            '<summer name="sum"><input>fcs/a-cmd</input><output>x/y</output></summer>'
            '<actuator name="s"><input>x/y</input>{}</actuator>',
            ["fcs/s"],
        ),
        (
            '<fcs_function name="f"><function><product><property>fcs/a-cmd</property>'
            "<value>2</value></product></function></fcs_function>"
            '<actuator name="s"><input>fcs/f</input>{}</actuator>',
            ["fcs/s"],
        ),
    ],
)
def test_a_servo_is_reached_through_the_control_system(tmp_path, component, servos):
    width = "<hysteresis_width> 0.02 </hysteresis_width>"
    channel = f"<channel name='c'>{component.format(width)}</channel>"
    folder = tmp_path / "aircraft" / "m"
    folder.mkdir(parents=True)
    files = "<system file='broken'/><system file='a'/>"
    (folder / "m.xml").write_text(f"<fdm_config>{files}</fdm_config>")
    (folder / "a.xml").write_text(f"<system>{channel}</system>")
    (folder / "broken.xml").write_text("<system>")
    (folder / "unused.xml").write_text(f"<system>{channel.replace('0.02', '0.5')}</system>")
    components = ModelXml.of(folder / "m.xml").components
    assert hysteresis(components, ["fcs/a-cmd"]) == dict.fromkeys(servos, 0.02)


def test_the_algebraic_model_passes_it():
    modes = {m.name: m for m in Aircraft("c172x", condition=SLOW).linear_model("algebraic").modes()}
    like = {m.name: m for m in Aircraft("c172p", condition=SLOW).linear_model("algebraic").modes()}
    for name in ("short period", "phugoid", "Dutch roll"):
        assert modes[name].frequency == pytest.approx(like[name].frequency, rel=0.25), name


@pytest.mark.long
def test_the_report_has_the_limit_cycle():
    with pytest.raises(DesignError):
        design_gains("c172x", SLOW)
    designed = design_gains("c172x", SLOW, method="algebraic")
    report = {row.loop: row for row in designed.report}
    assert math.isinf(report["pitch"].flown_settling)
    assert "limit cycle" in report["pitch"].relaxed
    assert report["roll"].flown_settling < 5.0
