"""``pathsim-jsbsim view`` in a fresh browser profile: nothing is set up before."""

import pytest
from served_pathview import Served

from .editor import Editor


@pytest.fixture
def served(tmp_path):
    served = Served(tmp_path, "elevator_doublet", "--no-browser", "--port", "0")
    yield served
    if served.process.poll() is None:
        served.process.kill()


def test_the_command_is_all_that_run_needs(browser, served):
    with Editor(browser, served.address) as editor:
        editor.page.goto(served.url)
        editor.ready()
        shown = {name: text for name, text, _ in editor.blocks()}
        assert "Aircraft" in shown["aircraft"]
        assert not [text for text in shown.values() if "(missing)" in text]
        assert editor.run() == "Simulation completed successfully"
        alpha = editor.runs[-1]["scope"][1][1]
        assert max(alpha) - min(alpha) > 3.0  # deg: the aircraft flies, the block is not left out
        assert not editor.errors
        workers = served.children()
        assert workers
        status, errors = served.end()
    assert (status, errors) == (0, "")
    assert served.left_behind(workers) == []
