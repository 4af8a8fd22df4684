"""Every diagram of the catalogue: built on import, run as a script and by the command."""

import csv
import errno
import io
import json
import os
import re
import subprocess
import sys

import pytest
from how_many import first
from plain_jsbsim import trimmed

from pathsim_jsbsim_blocks.catalogue import (
    diagram_folder,
    diagram_groups,
    diagram_names,
    find_diagram,
    load_diagram,
)
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.studies import STUDIES


# in one process: tests/diagrams and test_every_figure_is_saved
@pytest.mark.long
@pytest.mark.parametrize("name", diagram_groups()["published"])
def test_a_script_runs_from_any_directory_without_a_display(name, tmp_path, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("MPLBACKEND", raising=False)
    done = subprocess.run(
        [sys.executable, str(find_diagram(name))],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    # numbers that show that it worked, and a figure
    assert any(c.isdigit() for c in done.stdout.split("figure saved")[0])
    assert (tmp_path / f"{name}.png").stat().st_size > 10_000


@pytest.mark.parametrize("name", first(diagram_names(), 10))
def test_a_script_builds_its_diagram_on_import_and_does_not_run_it(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    module = load_diagram(name)
    assert module.sim.time == 0.0
    assert module.DURATION > 0
    assert list(tmp_path.iterdir()) == []


def test_list_shows_every_diagram_and_study_with_its_summary(capsys):
    assert main(["list"]) == 0
    parts = [part.splitlines() for part in capsys.readouterr().out.split("\n\n")]
    groups = [*diagram_groups().values(), [*STUDIES]]
    assert [[line.split()[0] for line in lines] for _, *lines in parts] == groups
    assert all(len(line.split()) > 3 for _, *lines in parts for line in lines)


def test_an_export_by_name_is_written_here_and_not_in_the_catalogue(tmp_path, monkeypatch, capsys):
    pytest.importorskip("pathview")
    monkeypatch.chdir(tmp_path)
    own = find_diagram("step_response").with_suffix(".pvm")
    before = own.stat().st_mtime_ns, own.read_bytes()
    assert main(["export", "step_response"]) == 0
    assert (own.stat().st_mtime_ns, own.read_bytes()) == before
    made = json.loads((tmp_path / "step_response.pvm").read_text("utf-8"))
    assert len(made["graph"]["nodes"]) == len(json.loads(before[1])["graph"]["nodes"])


def test_a_study_takes_another_aircraft_and_condition(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = ["--aircraft", "c172p", "--altitude", "3000", "--speeds", "70:90:10", "--jobs", "1"]
    files = ["--csv", "a.csv", "--save", "a.png"]
    assert main(["study", "aoa_vs_cas", *options, *files]) == 0
    assert "aoa_vs_cas: 3 of 3 points trim" in capsys.readouterr().out
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    rows = list(csv.DictReader((tmp_path / "a.csv").open()))
    assert [float(row["requested_speed_kcas"]) for row in rows] == [70.0, 80.0, 90.0]
    assert {row["requested_altitude_ft"] for row in rows} == {"3000.0"}
    # alpha at 3000 ft and 80 KCAS as published, at a different heading
    assert float(rows[1]["alpha_deg"]) == pytest.approx(2.534215, abs=5e-3)


@pytest.mark.skipif(sys.platform == "win32", reason="links need a privilege")
def test_a_script_behind_a_link_imports_what_lies_beside_it(tmp_path, capsys):
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "beside_a_linked_script.py").write_text("TEXT = 'flown'\n")
    script = tmp_path / "real" / "mine.py"
    script.write_text("from beside_a_linked_script import TEXT\nprint(TEXT)\n")
    (tmp_path / "link.py").symlink_to(script)
    assert main(["run", str(tmp_path / "link.py")]) == 0
    assert capsys.readouterr().out == "flown\n"


def test_every_figure_is_saved(tmp_path, capsys):
    save = ["--duration", "1", "--save", str(tmp_path / "a")]
    assert main(["run", "aileron_turn", *save]) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.png", "a_2.png"]
    assert capsys.readouterr().out.count(f"figure saved: {tmp_path / 'a'}") == 2


SCRIPT = """
import sys
import helper
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Constant, Scope
print(sys.argv, helper.TEXT)
outer, inner, port = Scope(labels=["outer"]), Scope(labels=["inner"]), Interface()
source = Constant(2.0)
part = Subsystem([port, inner], [Connection(port, inner)])
flight = Simulation([source, part, outer], [Connection(source, part, outer)], dt=0.5, log=False)
flight.run(1.0)
flight.plot()
"""


@pytest.fixture
def run(tmp_path):
    """Run this text as a script of one's own, with figure and signals saved: the status."""

    def with_text(text, figure="a.png", signals="a.csv"):
        (tmp_path / "helper.py").write_text("TEXT = 'beside the script'\n")
        script = tmp_path / "mine.py"
        script.write_bytes(text if isinstance(text, bytes) else text.encode())
        save = ["--save", str(tmp_path / figure)] if figure else []
        table = ["--csv", str(tmp_path / signals)] if signals else []
        return main(["run", str(script), *save, *table])

    return with_text


def test_run_is_what_python_does_and_saves_what_it_draws_and_records(run, tmp_path, capsys):
    before = sys.argv[:], sys.path[:]
    assert run(SCRIPT, "a.svg") == 0
    assert (sys.argv, sys.path) == before
    assert f"['{tmp_path / 'mine.py'}'] beside the script" in capsys.readouterr().out
    assert "<svg" in (tmp_path / "a.svg").read_text()
    header, *rows = csv.reader((tmp_path / "a.csv").read_text().splitlines())
    assert sorted(header) == ["inner", "outer", "time [s]"]
    assert rows[-1] == ["1.0", "2.0", "2.0"]


def test_run_says_that_there_is_nothing_to_save(run, capsys):
    assert run("", signals=None) == 1
    assert "no figure was shown" in (err := capsys.readouterr().err)
    assert "plots.time_histories(scope)" in err
    assert run("", figure=None) == 1
    assert "no Scope has recorded a signal" in capsys.readouterr().err


STOPPED = """
from pathsim import Connection, Simulation
from pathsim.blocks import Function, Scope, Source

def stop(t):
    if t >= 0.75:
        {stop}
    return t

def main():
    source, scope = Source(stop), Scope(labels=["time again [s]"])
    sim = Simulation([source, scope], [Connection(source, scope)], dt=0.25, log=False)
    sim.run(2.0)

if __name__ == "__main__":
    main()
"""


@pytest.mark.parametrize(
    ("stop", "status", "text"),
    [
        ("raise KeyboardInterrupt", 130, "interrupted"),
        ("raise KeyboardInterrupt('2 of 50 done')", 130, "interrupted: 2 of 50 done"),
        ("1 / 0", 1, "mine.py failed"),
        (
            "from pathsim_jsbsim_blocks import ParameterError; "
            "raise ParameterError('too late', parameter='t', value=t)",
            1,
            "too late",
        ),
    ],
)
def test_what_was_recorded_before_a_run_stopped_is_saved(stop, status, text, run, tmp_path, capsys):
    assert run(STOPPED.format(stop=stop)) == status
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    header, *rows = csv.reader((tmp_path / "a.csv").read_text().splitlines())
    assert header == ["time [s]", "time again [s]"]
    assert rows == [[str(t), str(t)] for t in (0.0, 0.25, 0.5)]
    err = capsys.readouterr().err.splitlines()
    assert err[-1].startswith("pathsim-jsbsim: ")
    assert err[-1].endswith(f"{text}; the recording until t = 0.5 s is saved")
    # the lines of a script that is at fault itself, and none of ours
    assert len(err) == 1 or (err[0].startswith("Traceback") and "cli/runs.py" not in "".join(err))


def test_sys_exit_is_an_ordinary_end(run, tmp_path):
    with pytest.raises(SystemExit) as end:
        run(SCRIPT + "sys.exit(3)\n")
    assert end.value.code == 3
    assert (tmp_path / "a.png").exists()
    assert (tmp_path / "a.csv").exists()


def test_a_stop_before_anything_was_recorded_saves_nothing(run, tmp_path, capsys):
    assert run("raise KeyboardInterrupt\n") == 130
    assert capsys.readouterr().err == "pathsim-jsbsim: interrupted\n"
    assert {file.name for file in tmp_path.iterdir()} == {"mine.py", "helper.py"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"x = 1\ndef f(:\n", "mine.py:2: invalid syntax"),
        (b"if x:\ny\n", "mine.py:2: expected an indented block"),
        (b"# coding: nonsense\n", "unknown encoding: nonsense"),
        (b"x = '\xff'\n", "mine.py"),
        (b"x = '\0'\n", "null bytes"),
    ],
)
def test_a_script_that_python_cannot_read_is_one_line(text, message, run, capsys):
    assert run(text, None, None) == 1
    err = capsys.readouterr().err
    assert message in err
    assert err.startswith("pathsim-jsbsim: ")
    assert len(err.splitlines()) == 1


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full")
@pytest.mark.parametrize("full", ["a.csv", "a.png"])
def test_a_full_disk_is_named_and_the_other_file_is_written(full, run, tmp_path, capsys):
    (tmp_path / full).symlink_to("/dev/full")
    assert run(SCRIPT) == 1
    assert capsys.readouterr().err == (
        f"pathsim-jsbsim: cannot write {str(tmp_path / full)!r}: No space left on device\n"
    )
    (other,) = {"a.csv", "a.png"} - {full}
    assert (tmp_path / other).stat().st_size > 50


@pytest.mark.skipif(sys.platform == "win32", reason="a directory in use cannot be deleted")
@pytest.mark.parametrize(
    "arguments",
    [["run", "hello_jsbsim", "--csv", "a.csv"], ["trim", "c172p"], ["export", "pitch_hold"]],
)
def test_a_working_directory_that_is_gone_is_one_line(arguments, tmp_path, monkeypatch, capsys):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    assert main(arguments) == 1
    err = capsys.readouterr().err
    assert err.startswith("pathsim-jsbsim: the working directory no longer exists")
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["run", "elevator_doublett"], "did you mean 'elevator_doublet'"),
        (["run", "trim_envelop"], "script 'trim_envelop'; did you mean 'trim_envelope'"),
        (
            ["study", "climb_schedule", "--altitude", "3000"],
            "no option --altitude; it has --aircraft",
        ),
        (["study", "aoa_vs_cas", "--speeds", "90:50:10"], "FIRST:LAST:STEP"),
        (["study", "trim_envelope", "--aircraft", "c17p"], "did you mean 'c172p'"),
        (["properties", "c172p", "--after", "-1"], "after must be at least 0"),
        (["properties", "737", "theta", "--trim", "--speed", "100"], "It trims at 15"),
        (["run", "hello_jsbsim", "--save", "a.foo"], "'png'"),
        (["run", "hello_jsbsim", "--save", "."], "is a directory"),
        (["run", "hello_jsbsim", "--csv", "a.xlsx"], "did you mean 'a.csv'"),
        (["export", "pitch_hold", "-o", "a.txt"], "did you mean 'a.pvm'"),
        (["run", str(diagram_folder().parent / "README.md")], "is not a Python script"),
        (["trim", "c172p", "--set", "fcs/flap"], "PROPERTY=VALUE"),
        (["modes", "c172p", "--mode", "ground"], "it is not in steady flight"),
        (["modes", "c172p", "--method", "algebraic", "--category", "D"], "must be one of 'A'"),
    ],
)
def test_mistakes_end_with_a_message_and_status_1(arguments, text, capsys):
    assert main(arguments) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert text in err
    assert err.startswith("pathsim-jsbsim: ")
    assert len(err.splitlines()) == 1


def test_a_script_of_ones_own_is_suggested(tmp_path, monkeypatch, capsys):
    (tmp_path / "climb.py").write_text("")
    monkeypatch.chdir(tmp_path)
    for name, meant in (("climb", "climb.py"), ("clmb.py", "climb.py")):
        assert main(["run", name]) == 1
        assert f"script {name!r}; did you mean {meant!r}" in capsys.readouterr().err
    assert main(["view", f"{tmp_path}/clim.py"]) == 1
    assert f"did you mean '{tmp_path}/climb.py'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["run", "pitch_hold", "--cvs", "a.csv"], "--cvs a.csv; did you mean '--csv'?\n"),
        (["trim", "737", "--alttude", "3"], "--alttude 3; did you mean '--altitude'?\n"),
        (["trim", "737", "more"], "arguments: more\n"),
    ],
)
def test_an_option_that_does_not_exist_is_refused_naming_the_nearest(arguments, text, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(arguments)
    err = capsys.readouterr().err
    assert err.startswith(f"usage: pathsim-jsbsim {arguments[0]} ")
    assert err.endswith(text)


def test_trim_prints_the_published_state(capsys):
    flight = ["--altitude", "3000", "--speed", "80", "--heading", "45"]
    assert main(["trim", "c172p", *flight, "--solver", "jsbsim"]) == 0
    out = capsys.readouterr().out
    assert "throttle           0.621568" in out
    assert "alpha              2.534215 deg" in out
    radians, degrees = re.search(r"elevator_rad +(\S+) rad \((\S+) deg\)", out).groups()
    assert float(degrees) == pytest.approx(float(radians) * 57.29578, abs=1e-4)
    assert re.search(r"weight +\d+\.\d+ lb\n +cg_x +\d+\.\d+ in", out)


def test_a_state_without_engines_prints(capsys):
    assert main(["trim", "SGS", "--speed", "55", "--mode", "glide"]) == 0
    out = capsys.readouterr().out
    assert "throttle" not in out
    assert "gamma " in out


def test_trim_creates_what_a_model_misses(capsys):
    flight = ["trim", "L17", "--speed", "105", "--gear", "0"]
    assert main(flight) == 1
    assert "create={'fcs/flaps-pos-deg': 0.0}" in capsys.readouterr().err
    assert main([*flight, "--create", "fcs/flaps-pos-deg=0"]) == 0
    assert " norm" in capsys.readouterr().out


def test_properties_shows_access_and_value(capsys):
    assert main(["properties", "c172p", "elevator-cmd"]) == 0
    assert capsys.readouterr().out.split() == ["fcs/elevator-cmd-norm", "rw", "0"]


def value_of(name, capsys):
    (line,) = (x for x in capsys.readouterr().out.splitlines() if x.split()[0] == name)
    return float(line.split()[2])


def test_properties_after_the_trim_and_in_flight(capsys):
    # a descent: the altitude changes with time
    arguments = ["properties", "c172p", "position/h-sl-ft", "--speed", "90", "--gamma", "-3"]
    arguments += ["--solver", "jsbsim"]  # as the plain loop trims
    plain = trimmed("c172p", 5000.0, 90.0, gamma=-3.0)
    assert main([*arguments, "--trim"]) == 0
    # printed with ten digits
    name = arguments[2]
    assert value_of(name, capsys) == pytest.approx(plain[name], rel=1e-9)
    for _ in range(240):
        plain.run()
    assert main([*arguments, "--after", "2"]) == 0
    assert value_of(name, capsys) == pytest.approx(plain[name], rel=1e-9)
    assert plain[name] < 4990.0


def test_a_condition_or_a_setting_alone_means_trimmed(capsys):
    for options in (["--speed", "90"], ["--set", "propulsion/tank[0]/contents-lbs=100"]):
        assert main(["properties", "c172p", "aero/alpha-deg", *options]) == 0
        # as initialised it is 0
        assert value_of("aero/alpha-deg", capsys) > 0.1


@pytest.mark.long
def test_aircraft_lists_all_bundled_models(capsys):
    assert main(["aircraft"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 60
    assert any(line.startswith("737 ") and "2 engines" in line for line in lines)
    assert any(line.startswith("blank ") and "cannot load" in line for line in lines)


def test_a_folder_without_models_or_with_other_names_is_told(tmp_path, capsys):
    folder = tmp_path / "aircraft" / "X8_FixedWing"
    folder.mkdir(parents=True)
    (folder / "X8.xml").write_text("<fdm_config/>")
    root = ["--root", str(tmp_path)]
    assert main(["aircraft", *root]) == 1
    assert "no models in" in capsys.readouterr().err
    assert main(["aircraft", "X8_FixedWing", *root]) == 1
    assert "its folder has X8.xml, not X8_FixedWing.xml" in capsys.readouterr().err
    assert main(["aircraft", "X9", *root]) == 1
    assert capsys.readouterr().err.endswith("among the 0 models in " + str(folder.parent) + "\n")


def test_modes_are_printed_with_their_levels(tmp_path, capsys):
    arguments = ["c172p", "--speed", "90", "--method", "algebraic", "--class", "I"]
    saved, figure = tmp_path / "model.json", tmp_path / "poles.png"
    assert main(["modes", *arguments, "--json", str(saved), "--save", str(figure)]) == 0
    out = capsys.readouterr().out
    for text in ("short period", "phugoid", "Dutch roll", "roll", "spiral", "level 1 (3.2.2.1.2)"):
        assert text in out
    for loop in ("PitchHold", "RollHold", "HeadingHold", "AirspeedHold"):
        assert f"{loop} of c172p, broken at" in out
    assert saved.stat().st_size > 1000
    assert figure.stat().st_size > 10_000


@pytest.mark.long
def test_a_terminal_that_lacks_a_letter_gets_its_number(tmp_path):
    script = tmp_path / "mine.py"
    script.write_text("print('\u03b1')\n", encoding="utf-8")
    command = [sys.executable, "-m", "pathsim_jsbsim_blocks.cli", "run", str(script)]
    ended = subprocess.run(
        command, capture_output=True, text=True, env={**os.environ, "PYTHONIOENCODING": "ascii"}
    )
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "\\u03b1\n", "")


def test_output_that_does_not_fit_on_the_disk(monkeypatch, capsys):
    class Full(io.StringIO):
        def flush(self):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", Full())
        assert main(["list"]) == 1
    assert capsys.readouterr().err == "pathsim-jsbsim: the output: No space left on device\n"
