"""The run of a script that its model is of, and what is no diagram that PathView can hold."""

import os
import subprocess
import sys
import warnings

import numpy as np
import pytest
from scripts_of_tests import HEAD, LOOP, OSCILLATOR, code, names, script

from pathsim_jsbsim_blocks.catalogue import find_diagram
from pathsim_jsbsim_blocks.cli import editor, main
from pathsim_jsbsim_blocks.errors import DiagramError
from pathsim_jsbsim_blocks.pathview import export_script
from pathsim_jsbsim_blocks.pathview.first_run import FirstRun


@pytest.mark.parametrize(
    ("run", "duration"),
    [
        ("fly(sim, 20)", "20"),
        ("fly(duration=7.0, sim=sim)", "7.0"),
        ("sim.run(duration=2 * T)\nsim.plot()", "2 * T"),
        ("sim.run()", "10.0"),
        ("if __name__ == '__main__':\n    tf = 7\n    sim.run(tf)", "tf"),
        ("def main():\n    sim.run(T)\n\nif __name__ == '__main__':\n    main()", "T"),
        ("", "10.0"),
        ("DURATION = 3.0", "DURATION"),
        # it does not hear of the run's end
        ("try:\n    sim.run(0.05)\nexcept BaseException:\n    pass", "0.05"),
    ],
)
def test_duration_is_that_of_the_first_run(written, run, duration):
    before = "from pathsim_jsbsim_blocks import fly\nT = 5.0"
    model = written(script("a = Constant(1)\ns = Scope()", before=before, after=run))
    assert model["simulationSettings"]["duration"] == duration
    own = {"T", "tf", "DURATION"} & {duration.split(" ")[-1]}
    assert all(f"{n} = " in code(model) for n in own)


@pytest.mark.parametrize(
    ("after", "left"),
    [
        ("sim.run(1)\nsim.run(2)", [(13, "sim.run()")]),
        ("sim.run(1)\na.gain = 3\nsim.steadystate()", [(14, "sim.steadystate()")]),
        (
            "for g in (1.0, 2.0):\n    a.gain = g\n    sim.run(1)",
            [(12, "the loop runs the simulation again")],
        ),
        ("sim.run(1)\nother = Simulation([a], log=False)\nother.run(3)", [(14, "other.run()")]),
        ("while sim.time < 1:\n    sim.timestep()", [(13, "the number of calls of timestep()")]),
        ("if __name__ == '__main__':\n    sim.run(1)\n    sim.plot()\n    print(s.read())", []),
    ],
)
def test_what_comes_after_the_first_run_is_left_out(after, left, saved):
    assert FirstRun(saved(HEAD + LOOP + after)).left_out() == left


def test_a_flight_after_the_first_is_warned_of(saved):
    path = saved(
        HEAD + LOOP + "from pathsim_jsbsim_blocks import fly\nfly(sim, 0.1)\nfly(sim, 1.0)"
    )
    with pytest.warns(
        UserWarning, match=r"first run \(line 13\); not in it: line 14: fly\(\)"
    ) as caught:
        export_script(path)
    assert [(w.filename, w.lineno) for w in caught] == [(str(path), 13)]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the pool is of forks")
@pytest.mark.parametrize(
    ("run", "message"),
    [
        (
            "import threading\nt = threading.Thread(target=sim.run, args=(0.05,))\n"
            "t.start()\nt.join()",
            r"at t = 0\.0\d* when its first run begins",
        ),
        (
            "def go(k):\n    sim.run(k)\nfrom multiprocessing import get_context\n"
            "with get_context('fork').Pool(1) as pool:\n    pool.map(go, [1])",
            "in a separate process",
        ),
    ],
)
def test_a_run_in_another_thread_or_process_is_refused(run, message, written):
    with pytest.raises(DiagramError, match=message):
        written(script("a = Amplifier(2.0)", after=run))


BLOCK = "a = Amplifier(2.0)"

REFUSED = {
    "own class": (
        script(
            "class Mine(Amplifier):\n    def update(self, t):\n        pass\na = Mine()", names="a"
        ),
        11,
        "does not know the block 'Mine'.*installed package",
    ),
    "JSBSim in a function": (
        script(
            "import jsbsim\nfdm = jsbsim.FGFDMExec(None)\n"
            "a = DynamicalFunction(lambda u, t: fdm.run())",
            names="a",
        ),
        10,
        "in a function JSBSim runs ahead of the clock: use Aircraft",
    ),
    "core block that PathView lacks, in a script with JSBSim": (
        script("import jsbsim\na = Comparator()"),
        9,
        "does not know the block 'Comparator'(?!.*runs ahead)",
    ),
    "switched off": (
        script(BLOCK + "\nb = Scope()\nc = Connection(a, b)\nc.off()", "c", names="a, b"),
        8,
        "a connection of 'a' is switched off when the run begins",
    ),
    "event switched off": (
        script(f"{BLOCK}\ne = ZeroCrossing(len, None)\ne.off()", names="a", events="[e]"),
        9,
        "'e' is switched off when the run begins",
    ),
    "absent block": (
        script(f"{BLOCK}\nb = Constant(1)\ns = Source(lambda t: b.value)", names="a, s"),
        None,
        "'b', which is not in the simulation",
    ),
    "not listed": (
        script(f"{BLOCK}\nb = Scope()", "Connection(a, b)", names="a"),
        None,
        "'b' is connected but not in the list",
    ),
    "twice": (
        script(BLOCK, names="Subsystem([Interface(), a]), a"),
        8,
        "'a' is in the diagram twice",
    ),
    "not adaptive": (
        script(BLOCK, after="sim.run(3, adaptive=False)").replace("log=False", "Solver=RKCK54"),
        10,
        "adaptive",
    ),
    "error": ("x = 1\ny = x / 0", 2, "script fails: ZeroDivisionError"),
    "syntax": ("x = (", 1, "not Python"),
    "no simulation": ("x = 1", None, "neither runs a Simulation"),
    "several simulations": (
        "from pathsim import Simulation\na = Simulation(log=False)\nb = Simulation(log=False)",
        None,
        "builds 2 simulations",
    ),
}


@pytest.mark.filterwarnings("ignore:.*not among the blocks")
@pytest.mark.parametrize("case", REFUSED)
def test_what_pathview_cannot_hold_is_refused_with_file_line_and_reason(case, written, tmp_path):
    text, line, reason = REFUSED[case]
    with pytest.raises(DiagramError, match=reason) as caught:
        written(text)
    assert caught.value.path == str(tmp_path / "script.py")
    assert line in (None, caught.value.line)


@pytest.mark.parametrize(
    "data",
    [
        b"\xef\xbb\xbf" + OSCILLATOR.encode(),
        b"# -*- coding: latin-1 -*-\n" + OSCILLATOR.replace("a spring", "\xe9").encode("latin-1"),
    ],
)
def test_encodings_that_python_knows(data, written):
    assert len(names(written(data))) == 6


@pytest.mark.parametrize("content", [b"x = 1\0\n", b"name = '\xff\xfe'\n"])
def test_a_script_that_is_no_text_is_refused(content, written):
    with pytest.raises(DiagramError, match=r"script\.py: not (a )?Python"):
        written(content)


def test_running_a_script_leaves_the_process_as_it_was(written, tmp_path):
    def world():
        filters, shown = list(warnings.filters), np.get_printoptions()
        return list(sys.path), list(sys.argv), sys.stdout, filters, shown

    before, modules, marker = world(), set(sys.modules), tmp_path / "ran"
    changes = """
import sys, warnings
warnings.simplefilter("error")
np.set_printoptions(precision=2)
sys.stdout = None
"""
    after = f"sim.run(0.05)\nopen({str(marker)!r}, 'w').close()"
    written(script("a = Amplifier(2.0)", before=changes, after=after), "left_over")
    assert world() == before
    assert not [m for m in set(sys.modules) - modules if "left_over" in m]
    assert not marker.exists()  # nothing runs after the first run


def test_a_function_that_fails_in_the_run_is_named_by_its_line(saved):
    path = saved(script(f"{BLOCK}\ns = Source(lambda t: 0.0 if t < 0.1 else 1 / 0)", names="a, s"))
    with pytest.raises(DiagramError, match="the script fails: ZeroDivisionError") as caught:
        export_script(path)
    assert (caught.value.path, caught.value.line) == (str(path), 9)


def test_a_comparison_that_ends_before_the_run_says_so(saved):
    path = saved(HEAD + LOOP + "sim.run(10)")
    with pytest.warns(
        UserWarning, match=r"script\.pvm: same for \d+ steps, 3 signals, to t = .* only"
    ):
        export_script(path, check=1e-9)


@pytest.mark.long
def test_a_process_that_has_imported_no_block_exports_a_script_with_blocks(tmp_path):
    # what this package changes in PathSim is no change of the script
    out, diagram = tmp_path / "hello.pvm", find_diagram("hello_jsbsim")
    command = ["-m", "pathsim_jsbsim_blocks.cli", "export", str(diagram), "-o", str(out)]
    done = subprocess.run([sys.executable, *command], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert out.exists()


@pytest.mark.long
def test_the_models_process_does_not_import_the_program_that_exports(saved, tmp_path):
    path = saved(HEAD + LOOP)
    program = tmp_path / "program.py"  # without a main guard
    program.write_text(
        "from pathsim_jsbsim_blocks.pathview import export_script\nprint('once')\n"
        f"export_script({str(path)!r})\n"
    )
    done = subprocess.run([sys.executable, str(program)], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "once\n"), done.stderr


@pytest.mark.parametrize(("status", "hint"), [(2, True), (3, False)])
def test_a_script_that_wants_arguments_hears_that_there_are_none(status, hint, written):
    with pytest.raises(DiagramError, match="SystemExit") as error:
        written(f"raise SystemExit({status})")
    assert ("PathView passes no arguments" in str(error.value)) == hint


def test_a_script_that_does_not_end_is_told_of(saved, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(editor, "_LONG", 0.01)
    path = saved(HEAD + "import time\ntime.sleep(0.2)\n" + LOOP + "sim.run(0.1)")
    assert main(["export", str(path), "-o", str(tmp_path / "a.pvm")]) == 0
    assert "still runs after 0 s; Ctrl-C ends the export" in capsys.readouterr().err
