"""Scripts of tests, and the models that become of them."""

import json
import textwrap

import pytest

from pathsim_jsbsim_blocks.pathview import export_script, pvm
from pathsim_jsbsim_blocks.pathview.first_run import FirstRun
from pathsim_jsbsim_blocks.pathview.reader import read_diagram


@pytest.fixture(scope="session", autouse=True)
def _pathview():
    pytest.importorskip("pathview")


@pytest.fixture
def saved(tmp_path):
    """The path of a script, from its text or bytes."""

    def saved(text, name="script"):
        path = tmp_path / f"{name}.py"
        data = text if isinstance(text, bytes) else textwrap.dedent(text).encode()
        path.write_bytes(data)
        return path

    return saved


@pytest.fixture
def written(saved):
    """The model of a script, which does not fly."""

    def written(text, name="script"):
        return FirstRun(saved(text, name), lambda script: pvm.model(read_diagram(script))).result

    return written


@pytest.fixture
def export(saved):
    """Export the text of a script; returns the model."""

    def export(text, name="script"):
        return json.loads(export_script(saved(text, name)).read_text(encoding="utf-8"))

    return export
