"""Pages that end, stand side by side, or lack blocks: no model is lost, and no run."""

import os
from pathlib import Path

import numpy as np
import pytest
from pathview_models import block, model, subsystem

from pathsim_jsbsim_blocks.catalogue import find_diagram
from pathsim_jsbsim_blocks.pathview import pvm

from .editor import Editor


def workers():
    """PathView's worker processes."""
    children = Path(f"/proc/{os.getpid()}/task").glob("*/children")
    numbers = [int(n) for file in children for n in file.read_text().split()]
    return {n for n in numbers if b"pathview" in Path(f"/proc/{n}/cmdline").read_bytes()}


def more_results(editor):
    """Wait for results of the run."""

    def count():
        return len(editor.runs[-1].get("height", [[]])[0]) if editor.runs else 0

    before = count()
    for _ in range(600):
        if count() > before:
            return
        editor.page.wait_for_timeout(100)
    pytest.fail("the run has ended")


@pytest.mark.long
def test_a_run_ends_with_its_page_and_pages_take_nothing_from_each_other(
    editor, profile, browser, server, models
):
    slow = pvm.read(find_diagram("isa_profile").with_suffix(".pvm"))
    [source] = [node for node in slow["graph"]["nodes"] if node["type"] == "Source"]
    source["params"]["func"] = "lambda t: __import__('time').sleep(0.01) or t"
    models["slow.pvm"] = slow
    seconds, hours = ({"duration": text} for text in ("5", "20000"))
    slow["simulationSettings"].update(hours)
    editor.open("slow.pvm")
    editor.page.click("button[aria-label='Run']")
    more_results(editor)

    # a second page beside it has a worker of its own
    slow["simulationSettings"].update(seconds)
    second = Editor(browser, server.address, server.url, profile)
    second.open("slow.pvm")
    assert second.run() == "Simulation completed successfully"
    more_results(editor)
    time, _ = editor.runs[-1]["height"]
    np.testing.assert_allclose(np.diff(time), 0.5)  # s: no frame is lost
    assert not editor.complaints()

    # the next page takes the place of a closed one, whose run ends
    running = workers()
    editor.page.close()
    third = Editor(browser, server.address, server.url, profile)
    third.open("slow.pvm")
    assert len(running - workers()) == 1
    assert len(workers() - running) == 1
    assert not [text for _, text, _ in third.blocks() if "(missing)" in text]
    assert third.run() == "Simulation completed successfully"
    parameters = {node["id"]: node["params"] for node in third.saved()["graph"]["nodes"]}
    for node in slow["graph"]["nodes"]:
        assert node["params"].items() <= parameters[node["id"]].items()
    assert not third.errors


AUTOSAVED = """() => new Promise(answer => {
    indexedDB.open("pathview").onsuccess = event => {
        const get = event.target.result.transaction("kv").objectStore("kv").get("autosave");
        get.onsuccess = () => answer(JSON.stringify(get.result ?? null));
    };
})"""


@pytest.mark.long
def test_a_diagram_with_an_unknown_block_neither_runs_nor_is_saved(editor, models):
    airship = block("airship", "Airship", 0, 0, gas='"helium"')
    inside = subsystem("s", block("i", "Interface", 0, 0), airship, connections=[])
    models["airship.pvm"] = model(inside, connections=[])
    said, downloads = [], []
    editor.page.on("dialog", lambda dialog: (said.append(dialog.message), dialog.dismiss()))
    editor.page.on("download", lambda download: downloads.append(download))
    editor.open("airship.pvm")
    assert "failed" in editor.run()
    assert any("Unknown blocks: airship (Airship)" in m for m in editor.complaints())
    editor.page.keyboard.press("Control+s")
    editor.page.click("button[aria-label='Save As']")
    editor.page.evaluate("delete window.showSaveFilePicker")
    editor.page.click("button[aria-label='Save']")
    editor.page.wait_for_timeout(1000)  # PathView also keeps a copy for itself
    assert len(said) == 3
    assert all("Unknown blocks: airship (Airship)" in text for text in said)
    assert not downloads
    assert "Airship" not in editor.page.evaluate(AUTOSAVED)
