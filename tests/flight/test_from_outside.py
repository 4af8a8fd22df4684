"""Models that expect properties from outside: found, created before loading, named all at once."""

import itertools
import subprocess
import sys
import tempfile
from pathlib import Path

import jsbsim
import pytest
from models_from_outside import before, changed

from pathsim_jsbsim_blocks import (
    Aircraft,
    AircraftError,
    ParameterError,
    TrimCondition,
    TrimError,
)
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.errors import FileError
from pathsim_jsbsim_blocks.flight import Airframe, aircraft_names, level_flight, trim
from pathsim_jsbsim_blocks.studies import trim_sweep

LEVEL = {"altitude": 5000, "speed": 90}


def system(components, execute=""):
    """A system with a channel, as it stands before the aerodynamics."""
    text = f'<system name="s"><channel name="c"{execute}>{components}</channel></system>'
    return before("aerodynamics", text)


def gain(name, property):
    return f'<pure_gain name="{name}"><input>{property}</input><gain>1</gain></pure_gain>'


def function(property, name="aero/function/outside"):
    return f'<function name="{name}"><sum><property>{property}</property><value>1</value></sum></function>'


# where a property from outside can stand: what changes the model, its name
_C1 = """<lead_lag_filter name="x/f"><input>velocities/p-rad_sec</input><c1>outside/a</c1>
<c2>1</c2><c3>1</c3><c4>1</c4></lead_lag_filter>"""
_DELAY = """<pure_gain name="x/f"><input>velocities/p-rad_sec</input><gain>1</gain>
<delay type="frames">outside/a</delay></pure_gain>"""
# JSBSim reads it through a null pointer
_ANGLE = """<angle name="x/f" unit="DEG"><target_angle unit="DEG">outside/a</target_angle>
<source_angle unit="DEG">attitude/phi-deg</source_angle></angle>"""
# of a case that does not occur at the start
_CASE = """<switch name="x/f"><default value="0"/><test logic="AND" value="outside/a">
position/h-sl-ft LT -1000</test></switch>"""
_TEST = """<switch name="x/f"><default value="0"/><test logic="AND" value="1">
position/h-sl-ft LT -1000
<test logic="OR">-outside/a LT 1</test></test></switch>"""
PLACES = {
    "a constant of a filter": (system(_C1), "outside/a"),
    "a delay": (system(_DELAY), "outside/a"),
    "a channel": (
        system(gain("x/f", "fcs/flap-cmd-norm"), ' execute="/outside/on"'),
        "/outside/on",
    ),
    "an angle": (system(_ANGLE), "outside/a"),
    "an input with a minus": (system(gain("x/f", "-/controls/a[1]/b")), "/controls/a[1]/b"),
    "an input without a slash": (system(gain("x/f", "lonely")), "lonely"),
    "a case that is not met": (system(_CASE), "outside/a"),
    "a test within a test": (system(_TEST), "outside/a"),
    "an aerodynamic function": (before("axis", function("outside/a")), "outside/a"),
    "the axis of a table": (
        before(
            "axis",
            '<function name="aero/x"><table><independentVar>outside/a</independentVar>'
            "<tableData>0 0\n1 1</tableData></table></function>",
        ),
        "outside/a",
    ),
}


@pytest.mark.parametrize("place", PLACES)
def test_a_property_from_outside_is_named_and_created_before_the_model_is_loaded(place, tmp_path):
    change, name = PLACES[place]
    root = changed(tmp_path, "c172x", change)
    with pytest.raises(AircraftError) as error:
        Airframe("c172x", root=root)
    assert error.value.missing == (name,)
    plane = Aircraft("c172x", **LEVEL, root=root, create={name: 2.0})
    assert plane.airframe.created == {name: 2.0}
    plane.reset()
    assert plane.fdm[name] == 2.0


def test_functions_of_an_engine_stand_for_each(tmp_path):
    thruster = (
        '<direct><function name="propulsion/engine[#]/x"><sum><property>outside[#]/a</property>'
    )
    thruster += "<value>1</value></sum></function></direct>"
    twin = changed(
        tmp_path,
        "A320",
        (r'<thruster file="direct">', '<thruster file="own">'),
        files={"engine/own.xml": thruster},
    )
    with pytest.raises(AircraftError) as error:
        Airframe("A320", root=twin)
    assert error.value.missing == ("outside[0]/a", "outside[1]/a")


def test_what_is_created_acts(tmp_path):
    root = changed(tmp_path, "c172x", system(gain("x/f", "outside/a")))
    airframe = Airframe("c172x", root=root, create={"outside/a": 2.5})
    airframe.run_ic()
    assert airframe.fdm["x/f"] == 2.5
    other = airframe.twin()
    other.run_ic()
    assert other.fdm["x/f"] == 2.5


MANY = [f"outside/n{i}" for i in range(15)]


@pytest.fixture
def lacking_many(tmp_path):
    """A model that lacks fifteen properties, the first of which loading needs."""
    channel = ' execute="outside/n0"'
    text = "".join(gain(f"x/f{i}", name) for i, name in enumerate(MANY))
    return changed(tmp_path, "c172x", system(text, channel))


def test_all_that_are_missing_are_named_with_the_dict_to_copy(lacking_many):
    with pytest.raises(AircraftError) as error:
        Aircraft("c172x", **LEVEL, root=lacking_many, create={MANY[3]: 7.0})
    assert sorted(error.value.missing) == sorted({*MANY} - {MANY[3]})
    copied = str(error.value).partition("create=")[2].partition("}")[0]
    create = eval(f"{copied}}}")
    assert create == {**dict.fromkeys(MANY, 0.0), MANY[3]: 7.0}
    assert Aircraft("c172x", **LEVEL, root=lacking_many, create=create).airframe.created == create


def test_the_missing_are_created_as_0_with_one_warning(lacking_many):
    with pytest.warns(RuntimeWarning, match="outside") as warned:
        plane = Aircraft("c172x", **LEVEL, root=lacking_many, create="missing")
    [warning] = warned
    assert all(name in str(warning.message) for name in MANY)
    # a second one would be an error
    plane.reset()
    plane.linear_model("algebraic")
    assert plane.airframe.created == dict.fromkeys(MANY, 0.0)
    with pytest.raises(ParameterError):
        Aircraft("c172x", **LEVEL, create="mising")


def test_a_divisor_that_was_created_as_0_is_said_where_nothing_is_finite(tmp_path):
    ratio = "<quotient><value>0</value><property>outside/a</property></quotient>"
    ratio = f"<function><sum><value>1</value>{ratio}</sum></function>"
    root = changed(tmp_path, "c172x", (r'(<axis name="LIFT">)', rf"\1{ratio}"))
    with pytest.raises(TrimError) as error:
        trim(Airframe("c172x", root=root, create={"outside/a": 0.0}), TrimCondition(**LEVEL))
    assert error.value.reason == "no convergence"


@pytest.mark.long
def test_sweeps_and_commands_pass_create_on(lacking_many, capsys):
    create = dict.fromkeys(MANY, 1.0)
    grid = {**LEVEL, MANY[4]: [2.0, 3.0]}
    table = trim_sweep(
        "c172x", grid, outputs=MANY[3:5], root=lacking_many, create=create, jobs=1, progress=False
    )
    assert table[MANY[4]].tolist() == [2.0, 3.0]
    assert table[MANY[3]].tolist() == [1.0, 1.0]
    flight = level_flight("c172x", lacking_many, create={MANY[0]: 1.0})
    assert flight.create == {**dict.fromkeys(MANY, 0.0), MANY[0]: 1.0}
    options = ["--root", lacking_many, *itertools.chain(*(["--create", f"{n}=1"] for n in MANY))]
    assert main(["trim", "c172x", "--speed", "90", *options]) == 0
    assert main(["aircraft", "c172x", *options]) == 0
    assert main(["trim", "c172x", "--speed", "90", *options[:-2]]) == 1
    capsys.readouterr()
    assert main(["trim", "c172x", "--speed", "90", *options[:2], "--create", "missing"]) == 0
    assert MANY[14] in capsys.readouterr().out


def test_bundled_models_that_load_refer_to_nothing_that_is_missing():
    # what JSBSim asks for in these, one after the other
    lacking = {"L17": 1, "Pterosaur": 1, "dr1": 5, "f104": 1, "fokker100": 5, "fokker50": 2}
    found = {}
    for name in aircraft_names():
        try:
            Airframe(name)
        except AircraftError as error:
            found[name] = len(error.missing)
    assert found == {**lacking, "blank": 0}


ENDS = """
from pathsim_jsbsim_blocks import Aircraft, BlocksError
from pathsim_jsbsim_blocks.flight import Airframe
create = {"outside/a": 1.0}
def attempt(action):
    try:
        return action()
    except BlocksError as error:
        print(type(error).__name__)
for root in sys.argv[1:]:
    attempt(lambda: Airframe("c172x", root=root))
    attempt(lambda: Aircraft("c172x", root=root, setup={"fcs/flap-cmd-nrm": 1}))
    attempt(lambda: Airframe("c172x", root=root, create={**create, "fcs": 1}))
    attempt(lambda: Aircraft("c172x", root=root, create=create, setup={"fcs/flap-cmd-nrm": 1}))
    Airframe("c172x", root=root, create=create)
    plane = Airframe("c172x", root=root, create=create)
    twin = plane.twin()
    plane.renew()
    del plane
    twin.run_ic()
    del twin
    plane = attempt(lambda: Aircraft("c172x", root=root, create=create, mode="none"))
    plane.reset()
    del plane
last = Airframe("c172x", root=root, create=create)
attempt(lambda: Airframe("c172x", root=root))
print("still there", flush=True)
"""


@pytest.mark.long
def test_no_refusal_and_no_airframe_that_is_let_go_ends_the_process(tmp_path):
    # each of them did: an exception of JSBSim's destructors, or a null pointer
    places = ("an aerodynamic function", "an angle")
    roots = [changed(tmp_path / place, "c172x", PLACES[place][0]) for place in places]
    run = subprocess.run(
        [sys.executable, "-c", f"import sys{ENDS}", *roots], capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    refused = ["AircraftError"] * 2 + ["PropertyError"] * 2
    assert run.stdout.split() == [*refused, *refused, "AircraftError", "still", "there"]


def test_elements_nested_3000_deep_are_read_as_jsbsim_reads_them(tmp_path):
    root, file = changed(tmp_path, "ball"), tmp_path / "aircraft/ball/ball.xml"
    text = file.read_text()
    file.write_text(text.replace("</fdm_config>", "<a>" * 3000 + "</a>" * 3000 + "</fdm_config>"))
    deep, plain = (Aircraft("ball", root=x, mode="none") for x in (root, None))
    u = [0.0] * len(plain.inputs)
    assert deep.advance(1, u) == plain.advance(1, u)


def test_without_a_folder_for_temporary_files_a_moved_centre_of_gravity_is_refused(monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", "/nonexistent")
    with pytest.raises(FileError):
        Aircraft("c172p", condition=TrimCondition(speed=90, empty_cg_x=41.0))


_ELSEWHERE = """
import os, sys
import jsbsim
assert os.path.dirname(jsbsim.__file__) == sys.argv[1], jsbsim.__file__
from pathsim_jsbsim_blocks import Aircraft, JSBSimFDM
plane = Aircraft("c172p", altitude=5000.0, speed=90.0)
plane.advance(1, [0.0] * len(plane.inputs))
JSBSimFDM(script="scripts/c1723.xml")
print(repr(float(plane.outputs["theta"])))
"""


def test_jsbsim_outside_site_packages_flies(tmp_path):
    """As after ``pip install --target``: JSBSim itself looks in Python's own folders only."""
    target = tmp_path / "jsbsim"
    target.symlink_to(Path(jsbsim.__file__).parent, target_is_directory=True)
    # Python without its own site-packages
    paths = [str(tmp_path), *(p for p in sys.path if p)]
    run = subprocess.run(
        [sys.executable, "-S", "-c", f"import sys; sys.path[:0] = {paths!r}\n{_ELSEWHERE}", target],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert run.returncode == 0, run.stderr
    assert float(run.stdout) == Aircraft("c172p", altitude=5000.0, speed=90.0).outputs["theta"]


def test_opening_a_healthy_model_again_and_again_takes_no_memory(tmp_path):
    root = changed(tmp_path, "c172x", system(gain("x/f", "outside/a")))

    def resident():  # MB
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * 4096 / 1e6

    def open_often(n):
        for _ in range(n):
            Airframe("c172x", root=root, create={"outside/a": 1.0})

    open_often(20)
    before = resident()
    open_often(100)
    assert resident() - before < 10.0  # of 37 that they would keep


def test_an_error_of_jsbsim_keeps_its_cause(tmp_path):
    note = "<product><property>aero/alpha-rad</property></product>"
    notes = "".join(
        f'<fcs_function name="x/f{i}"><function>\n{note}</function></fcs_function>'
        for i in range(40)
    )
    change = system(notes)
    root = changed(tmp_path, "c172x", change, before("aerodynamics", '<system file="nowhere"/>'))
    with pytest.raises(AircraftError) as error:
        Airframe("c172x", root=root)
    assert "Could not open file: nowhere" in str(error.value)
    assert "product" not in str(error.value)
    # where all are errors the last stay
    wrong = "".join(f'<nothing_{i} name="a{i}"/>' for i in range(60))
    root = changed(
        tmp_path, "c172x", system(wrong), before("aerodynamics", '<system file="nowhere"/>')
    )
    with pytest.raises(AircraftError) as error:
        Airframe("c172x", root=root)
    assert "Could not open file: nowhere" in str(error.value)
    assert len(str(error.value)) < 1200


def test_values_and_missing_go_together(tmp_path):
    test = """<system name="late"><channel name="late"><switch name="late/a">
    <default value="0"/><test logic="AND" value="1">
    sim-time-sec le 30
    outside/lever == 0
    </test></switch></channel></system>"""
    root = changed(tmp_path, "c172p", before("aerodynamics", test))
    with pytest.raises(AircraftError) as error:
        Airframe("c172p", root=root)
    # JSBSim looks up a name without a slash only when it initialises
    assert [*error.value.missing] == ["sim-time-sec", "outside/lever"]
    with pytest.warns(RuntimeWarning, match="created as 0.*sim-time-sec"):
        airframe = Airframe("c172p", root=root, create={"missing": True, "outside/lever": 0.5})
    airframe.run_ic()
    assert airframe.created == {"outside/lever": 0.5, "sim-time-sec": 0.0}
