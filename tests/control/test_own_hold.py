"""The hold that CONTRIBUTING shows, copied into a package and flown."""

import importlib
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from flights import start
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import ParameterError

PAGE = Path(__file__).parents[2] / "CONTRIBUTING.md"
SHOWN = re.search(r"## Add a hold.*?```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
T = 1 / 120


@pytest.fixture
def holds(tmp_path, monkeypatch):
    package = tmp_path / "my_holds"
    package.mkdir()
    (package / "__init__.py").write_text(SHOWN[1], encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    yield importlib.import_module("my_holds")
    del sys.modules["my_holds"]


def test_it_uses_public_names_only():
    assert re.findall(r"^(?:from|import) (\S+)", SHOWN[1], re.M) == [
        "dataclasses",
        "typing",
        "pathsim_jsbsim_blocks.control",
        "pathsim_jsbsim_blocks.sampling",
    ]
    code = [x for x in SHOWN[1].splitlines() if x]
    assert len(code) <= 42
    assert not re.search(r"\._[a-z]", SHOWN[1])


def test_it_flies(holds):
    plane, hold, scope = start("c172p"), holds.PathHold(gamma_ref=1.5), Scope()
    seen = ("gamma", "q", "elev_sat")
    sim = Simulation(
        [plane, hold, scope],
        [
            Connection(plane[seen], hold[seen]),
            Connection(hold["elevator"], plane["elevator"], scope[1]),
            Connection(plane["gamma"], scope[0]),
        ],
        dt=T,
        log=False,
    )
    sim.run(30.0)
    t, (gamma, elevator) = scope.read()
    # bumpless; the throttle stays, so the airspeed falls and the integral follows it
    assert np.max(np.abs(np.diff(elevator))) < 0.02
    assert gamma[0] == pytest.approx(0.0, abs=0.01)
    assert np.max(np.abs(gamma[t > 12.0] - 1.5)) < 0.2
    hold.gamma_ref = 0.0  # a parameter, set while it flies
    sim.run(20.0)
    assert abs(plane.outputs["gamma"]) < 0.2
    with pytest.raises(ParameterError) as error:
        holds.PathHold(gama_ref=1.0)
    assert (error.value.parameter, error.value.value) == ("gama_ref", 1.0)
    assert "'gamma_ref'" in str(error.value)
