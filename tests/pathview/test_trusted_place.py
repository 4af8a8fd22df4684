"""Where the models that were trusted are remembered, on each system."""

import sys
from pathlib import Path

import pytest

from pathsim_jsbsim_blocks.errors import UntrustedModelError
from pathsim_jsbsim_blocks.pathview import trusted_models


@pytest.mark.parametrize(
    ("platform", "variable", "value", "folder"),
    [
        ("win32", "LOCALAPPDATA", "", "home/AppData/Local"),
        ("win32", "LOCALAPPDATA", "/local", "/local"),
        ("darwin", "XDG_STATE_HOME", "/state", "home/Library/Application Support"),
        ("linux", "XDG_STATE_HOME", "", "home/.local/state"),
        ("linux", "XDG_STATE_HOME", "/state", "/state"),
    ],
)
def test_the_systems_folder_for_what_programs_remember(
    monkeypatch, platform, variable, value, folder
):
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setattr("pathlib.Path.home", lambda: Path("home"))
    monkeypatch.setenv(variable, value)
    assert trusted_models._file() == Path(folder) / "pathsim-jsbsim-blocks" / "trusted-models"


def test_without_a_home_a_model_is_trusted_for_this_process(monkeypatch):
    def homeless():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr("pathlib.Path.home", homeless)
    monkeypatch.setattr(trusted_models, "_remembered", set())
    content = {"graph": {}}
    value = trusted_models.digest(content)
    with pytest.raises(UntrustedModelError):
        trusted_models.require_trust(content, Path("model.pvm"))
    with pytest.warns(UserWarning, match="cannot remember the model"):
        trusted_models.remember(value)
    trusted_models.require_trust(content, Path("model.pvm"))
