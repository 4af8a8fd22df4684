"""An option that several commands show arrives in each of them."""

import argparse
import collections
import importlib
import json

import pytest

from pathsim_jsbsim_blocks.catalogue import find_diagram
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.cli.parser import command_parser

# a value that each command must refuse, and what its error says of it
REFUSED = {
    "--set": ("no/such=1", "'no/such'"),
    "--create": ("a b=1", "'a b' is not a valid property name"),
    "--root": ("nowhere", "no folder 'nowhere/aircraft' with aircraft models"),
    "--save": ("nowhere/a.json", "nowhere' to write 'a.json' in"),
    "--csv": ("nowhere/a.csv", "nowhere' to write 'a.csv' in"),
    "--resume": ("nowhere/a.txt", "nowhere/a.txt' cannot be opened"),
    "--output": ("nowhere/a.pvm", "nowhere"),
    "--trust-toolbox": ("no such", "not 'no such'"),
    "--altitude": ("1e9", "altitude must lie in [-2000, 278386], not 1e+09"),
    "--speed": ("-1", "speed must be greater than 0, not -1"),
    "--mach": ("-1", "mach must be greater than 0, not -1"),
    "--gamma": ("99", "gamma must lie in [-90, 90], not 99"),
    "--heading": ("nan", "heading must be finite"),
    "--bank": ("99", "bank must lie in [-89, 89], not 99"),
    "--load-factor": ("nan", "load_factor must be finite"),
    "--mode": ("stedy", "mode must be one of"),
    "--method": ("flwn", "did you mean 'flown'?"),
    "--beta": ("99", "beta must lie in [-30, 30], not 99"),
    "--throttle": ("2", "throttle must lie in [0, 1], not 2"),
    "--thrust": ("nan", "thrust must be finite"),
    "--free": ("gama", "did you mean 'gamma'?"),
    "--wind-north": ("nan", "wind_north must be finite"),
    "--wind-east": ("inf", "wind_east must be finite"),
    "--latitude": ("91", "latitude must lie in [-90, 90], not 91"),
    "--longitude": ("nan", "longitude must be finite"),
    "--engines-off": ("9", "engines_off=(9,): aircraft 'c172p' has 1 engine, numbered from 0"),
    "--solver": ("newtn", "did you mean 'newton'?"),
    "--gear": ("2", "gear must lie in [0, 1], not 2"),
    "--jobs": ("0", "jobs must be"),
    "--flaps": ("2", "flaps must lie in [0, 1], not 2"),
    "--substeps": ("0", "substeps must be at least 1, not 0"),
}

# what a command works on, where that is not the c172p
SUBJECTS = {
    "run": "model.pvm",
    "view": "model.pvm",
    "convert": "model.pvm",
    "export": "step_response",
    "study": "climb_schedule",
    "check": "1",
}


(actions,) = (a for a in command_parser()._actions if isinstance(a, argparse._SubParsersAction))
COMMANDS = collections.defaultdict(list)  # by option
for command, parser in actions.choices.items():
    for action in parser._actions:
        if action.option_strings and action.dest != "help":
            COMMANDS[action.option_strings[-1]].append(command)
SHARED = [(option, one) for option, many in COMMANDS.items() if len(many) > 1 for one in many]


@pytest.mark.parametrize(("option", "command"), [x for x in SHARED if x[0] != "--trust"])
def test_a_shared_option_arrives(option, command, tmp_path, monkeypatch, capsys):
    value, text = REFUSED[option]
    subject = SUBJECTS.get(command, "c172p")
    if (command, option) == ("study", "--altitude"):
        subject = "trim_envelope"
    if command in ("view", "convert") or option == "--trust-toolbox":
        pytest.importorskip("pathview")
    monkeypatch.chdir(tmp_path)
    model = find_diagram("step_response").with_suffix(".pvm")
    (tmp_path / "model.pvm").write_bytes(model.read_bytes())
    if option == "--root" and command in ("run", "convert"):
        # a script of JSBSim
        subject = tmp_path / "script.xml"
        subject.write_text(
            '<runscript><use aircraft="own" initialize="own"/><run end="1" dt="1"/></runscript>'
        )
    assert main([command, str(subject), option, value]) == 1
    out, err = capsys.readouterr()
    assert text in err
    assert out == ""  # before any work


@pytest.mark.parametrize("command", COMMANDS["--trust"])
def test_trust_opens_a_model_from_outside(command, tmp_path, monkeypatch):
    pytest.importorskip("pathview")
    opened = []
    # serving has tests of its own, in a browser
    load = importlib.import_module("pathsim_jsbsim_blocks.pathview._view")._load
    monkeypatch.setattr(
        "pathsim_jsbsim_blocks.pathview.view",
        lambda target, port, browser, **trust: opened.append(load(target, **trust)),
    )
    monkeypatch.chdir(tmp_path)
    model = json.loads(find_diagram("step_response").with_suffix(".pvm").read_text())
    model["codeContext"]["code"] += f"\nopen('executed', 'w').close()  # {command}"
    (tmp_path / "model.pvm").write_text(json.dumps(model))
    assert main([command, "model.pvm"]) == 2
    assert not opened
    assert not (tmp_path / "executed").exists()
    assert main([command, "model.pvm", "--trust"]) == 0
    assert opened or (tmp_path / "executed").exists()
