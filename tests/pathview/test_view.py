"""The server behind ``view``: bound to this machine, gone without a trace."""

import functools
import json
import re
import signal
import socket
import sys
import threading
import time
import urllib.request

import pytest
from pathview_models import block, event, model, subsystem
from served_pathview import Served, page_headers

from pathsim_jsbsim_blocks.errors import ParameterError
from pathsim_jsbsim_blocks.pathview import view
from pathsim_jsbsim_blocks.pathview.page import registration
from pathsim_jsbsim_blocks.pathview.server import Server
from pathsim_jsbsim_blocks.pathview.toolboxes import FLIGHT, OURS


def call(address, headers, path, session, **body):
    """The answer to a call of the page."""
    request = urllib.request.Request(
        f"{address}/api/{path}",
        data=json.dumps(body).encode(),
        headers={"Content-Type": "application/json", "X-Session-ID": session, **headers},
    )
    return json.load(urllib.request.urlopen(request, timeout=60))


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="no POSIX signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_interrupted_it_leaves_no_port_process_or_file(number, tmp_path):
    served = Served(tmp_path, "step_response", "--no-browser", "--port", "0")
    ready = call(served.address, page_headers(served.url), "init", "one", packages=[])
    assert ready["type"] == "ready"
    workers = served.children()
    assert workers
    status, errors = served.end(number)
    assert (status, errors) == (0, "")
    assert served.left_behind(workers) == []


@pytest.mark.long
def test_it_opens_the_users_browser_with_the_diagram(tmp_path):
    seen = tmp_path / "seen"
    program = tmp_path / "browser"
    program.write_text(f'#!/bin/sh\necho "$1" > {seen}.part && mv {seen}.part {seen}\n')
    program.chmod(0o755)
    served = Served(tmp_path, "step_response", "--port", "0", env={"BROWSER": str(program)})
    try:
        for _ in range(200):
            if seen.exists():
                break
            time.sleep(0.05)
        assert seen.read_text().strip() == served.url
        assert re.search(r"/editor\?model=/model/step_response\.pvm&token=[\w-]{43}$", served.url)
    finally:
        served.end()


@pytest.fixture
def server():
    with Server({"a b.pvm": {"graph": 1}}, port=0) as server:
        threading.Thread(target=server.run, daemon=True).start()
        yield server


def test_it_listens_on_this_machine_only(server):
    port = int(server.address.rpartition(":")[2])
    # the second would reach a server that listens on all addresses
    for address, answers in (("127.0.0.1", True), ("127.0.0.2", False)):
        with socket.socket() as probe:
            assert (probe.connect_ex((address, port)) == 0) == answers


def test_a_port_in_use_is_an_error_if_asked_for(server):
    port = int(server.address.rpartition(":")[2])
    with pytest.raises(ParameterError, match=f"port {port} cannot be used"):
        Server({}, port=port)
    for bad in (-1, 65536, 1.5, "x"):
        with pytest.raises(ParameterError, match="port"):
            Server({}, port=bad)


def test_this_package_is_always_registered_and_the_models_toolboxes_last():
    def registered(required):
        script = registration(required)
        start = script.index("toolboxes = ") + len("toolboxes = ")
        return json.JSONDecoder().raw_decode(script[start:])[0]

    both = [OURS.import_path, FLIGHT.import_path]
    for required, expected in (([], both[:1]), ([FLIGHT], both), ([OURS, FLIGHT], both)):
        assert [t["importPath"] for t in registered(required)] == expected
    blocks = {b["className"]: b["override"] for b in registered([])[0]["blocks"]}
    assert blocks["DoubletSource"] == {"category": "Sources", "shape": "pill"}
    assert blocks["DaveML"] == {"category": "Aircraft", "shape": "rect"}
    assert blocks.keys() == OURS.blocks().keys()


def test_opening_the_address_ends_runs_without_a_page_and_no_others(server, monkeypatch):
    ask = functools.partial(call, server.address, page_headers(server.url()))
    for session in ("gone", "there"):
        ask("exec", session, code="import time", id="1")
        ask("stream/start", session, expr="time.sleep(0.01) or {'done': False, 'result': 1}")
    monkeypatch.setattr("pathsim_jsbsim_blocks.pathview.server._SILENT", 0.5)
    end = time.monotonic() + 1.0
    while time.monotonic() < end:
        assert not ask("stream/poll", "there")["done"]
    page_headers(server.url())
    assert ask("stream/poll", "gone") == {"messages": [], "done": True}
    assert ask("stream/poll", "there")["messages"]


def test_it_serves_a_model_in_which_pathview_finds_every_name(tmp_path, monkeypatch):
    """PathView imports no event class of a subsystem alone, and takes a keyword for a variable."""
    tick = event("tick", func_act="print")
    plant = subsystem("Plant", block("one", "Constant"), events=[tick])
    path = tmp_path / "drawn.pvm"
    path.write_text(json.dumps(model(block("Class", "Constant"), plant, code="k = 1")))
    served = {}

    def server(models, port):
        served.update(models)
        raise InterruptedError

    monkeypatch.setattr("pathsim_jsbsim_blocks.pathview._view.Server", server)
    with pytest.raises(InterruptedError):
        view(path, trust=True)
    content = served["drawn.pvm"]
    assert [n["name"] for n in content["graph"]["nodes"]] == ["Class block", "Plant"]
    assert content["codeContext"]["code"] == "from pathsim.events import Schedule\n\nk = 1"
    assert [e["name"] for e in content["graph"]["nodes"][1]["graph"]["events"]] == ["tick"]
    assert content["events"] == content["graph"]["events"] == []
