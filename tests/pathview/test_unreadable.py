"""Scripts that are no text; events and blocks that no PathView knows, in and after a subsystem."""

import json
import re

import pytest

from pathsim_jsbsim_blocks.errors import DiagramError
from pathsim_jsbsim_blocks.pathview import convert_model, export_script

pytest.importorskip("pathview")


@pytest.mark.parametrize("content", [b"x = 1\0\n", b"name = '\xff\xfe'\n"])
def test_a_script_that_is_no_text_is_refused(content, tmp_path):
    path = tmp_path / "script.py"
    path.write_bytes(content)
    with pytest.raises(DiagramError, match=re.escape(str(path))):
        export_script(path)
    assert list(tmp_path.iterdir()) == [path]


def converted(tmp_path, kind, after=(), **params):
    """The script of a model: a subsystem with one event, and the nodes after it."""
    place = {"position": {"x": 0, "y": 0}}
    interface = {
        "id": "i",
        "type": "Interface",
        "name": "Interface",
        "inputs": [],
        "outputs": [],
        "params": {},
        **place,
    }
    event = {"id": "e", "type": kind, "name": "tick", "params": params, **place}
    part = {
        "id": "s",
        "type": "Subsystem",
        "name": "part",
        "inputs": [],
        "outputs": [],
        "params": {},
        **place,
        "graph": {"nodes": [interface], "connections": [], "events": [event]},
    }
    model = {
        "version": "1.0.0",
        "metadata": {"name": "m", "created": "", "modified": ""},
        "graph": {"nodes": [part, *after], "connections": []},
        "events": [],
        "codeContext": {"code": ""},
        "simulationSettings": {"duration": "1"},
    }
    path = tmp_path / "model.pvm"
    path.write_text(json.dumps(model))
    return convert_model(path, tmp_path / "out.py").read_text()


def test_events_inside_a_subsystem_are_checked_too(tmp_path):
    with pytest.raises(DiagramError, match=r"event 'tick': .*did you mean 'Schedule'"):
        converted(tmp_path, "pathsim.events.Schedul")
    assert not (tmp_path / "out.py").exists()
    with pytest.warns(UserWarning, match="event 'tick'.*t_perod"):
        assert "t_perod" not in converted(tmp_path, "pathsim.events.Schedule", t_perod="1")


def test_blocks_after_a_subsystem_are_checked_too(tmp_path):
    block = {
        "id": "b",
        "type": "Amplifer",
        "name": "gain",
        "inputs": [],
        "outputs": [],
        "params": {},
        "position": {"x": 0, "y": 0},
    }
    with pytest.raises(DiagramError, match=r"block 'gain': .*did you mean 'Amplifier'"):
        converted(tmp_path, "pathsim.events.Schedule", [block])
