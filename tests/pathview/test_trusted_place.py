"""Where the models that were trusted are remembered, on each system."""

import sys
from pathlib import Path

import pytest

from pathsim_jsbsim_blocks.pathview import trusted_models


@pytest.mark.parametrize(("platform", "variable", "value", "folder"), [
    ("win32", "LOCALAPPDATA", "", "home/AppData/Local"),
    ("win32", "LOCALAPPDATA", "/local", "/local"),
    ("darwin", "XDG_STATE_HOME", "/state", "home/Library/Application Support"),
    ("linux", "XDG_STATE_HOME", "", "home/.local/state"),
    ("linux", "XDG_STATE_HOME", "/state", "/state")])
def test_the_systems_folder_for_what_programs_remember(monkeypatch, platform, variable, value,
                                                       folder):
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setattr("pathlib.Path.home", lambda: Path("home"))
    monkeypatch.setenv(variable, value)
    assert trusted_models._file() == Path(folder) / "pathsim-jsbsim-blocks" / "trusted-models"
