"""The server behind ``view``: bound to this machine, gone without a trace."""

import json
import re
import signal
import socket
import sys
import threading
import time
import urllib.error
import urllib.request
from pathlib import Path

import pytest
from models import block, event, model, subsystem
from served_pathview import Served, page_headers

from pathsim_jsbsim_blocks.errors import BlocksError, DiagramError, ParameterError
from pathsim_jsbsim_blocks.pathview import view
from pathsim_jsbsim_blocks.pathview.page import local_scripts, registration
from pathsim_jsbsim_blocks.pathview.server import Server
from pathsim_jsbsim_blocks.pathview.toolboxes import FLIGHT, OURS

pathview = pytest.importorskip("pathview")


def get(url, **headers):
    with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=30) as answer:
        return answer.read().decode()


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="no POSIX signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_interrupted_it_leaves_no_port_process_or_file(number, tmp_path):
    served = Served(tmp_path, "step_response", "--no-browser", "--port", "0")
    request = urllib.request.Request(
        f"{served.address}/api/init",
        data=b'{"packages": []}',
        headers={
            "Content-Type": "application/json",
            "X-Session-ID": "one",
            **page_headers(served.url),
        },
    )
    assert json.load(urllib.request.urlopen(request, timeout=60))["type"] == "ready"
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


def test_it_serves_the_model_and_nothing_to_other_names(server):
    page = page_headers(server.url())
    assert json.loads(get(f"{server.address}/model/a%20b.pvm", **page)) == {"graph": 1}
    with pytest.raises(urllib.error.HTTPError, match="404"):
        get(f"{server.address}/model/other.pvm", **page)
    with pytest.raises(urllib.error.HTTPError, match="403"):
        get(server.url(), Host="rebound.example:80")


def test_it_listens_on_this_machine_only(server):
    port = int(server.address.rpartition(":")[2])
    others = {i[4][0] for i in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}
    for address in others - {"127.0.0.1", "127.0.1.1"}:
        with socket.socket() as probe:
            assert probe.connect_ex((address, port)) != 0
    with socket.socket() as probe:
        assert probe.connect_ex(("127.0.0.1", port)) == 0


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

    assert [t["importPath"] for t in registered([])] == [OURS.import_path]
    assert [t["importPath"] for t in registered([FLIGHT])] == [OURS.import_path, FLIGHT.import_path]
    assert [t["importPath"] for t in registered([OURS, FLIGHT])] == [
        OURS.import_path,
        FLIGHT.import_path,
    ]
    blocks = {b["className"]: b["override"] for b in registered([])[0]["blocks"]}
    assert blocks["DoubletSource"] == {"category": "Sources", "shape": "pill"}
    assert blocks["DaveML"] == {"category": "Aircraft", "shape": "rect"}
    assert blocks.keys() == OURS.blocks().keys()


@pytest.mark.parametrize(
    ("target", "error", "message"),
    [
        ("no_such_diagram", ParameterError, "no diagram or script 'no_such_diagram'"),
        ("missing.pvm", DiagramError, "cannot be read"),
    ],
)
def test_what_cannot_be_shown_is_an_error_at_once(target, error, message):
    with pytest.raises(error, match=message):
        view(target, browser=False)


def test_a_model_with_an_unknown_block_is_not_served(tmp_path):
    path = tmp_path / "model.pvm"
    path.write_text(
        json.dumps(
            {
                "version": "1.0.0",
                "graph": {
                    "nodes": [
                        {
                            "id": "a",
                            "type": "Nothing",
                            "name": "a",
                            "inputs": [],
                            "outputs": [],
                            "params": {},
                        }
                    ]
                },
            }
        )
    )
    with pytest.raises(BlocksError, match="does not know the block 'Nothing'"):
        view(path, browser=False)


def test_scripts_that_load_the_style_sheet_are_redirected_here():
    static = Path(pathview.__file__).parent / "static"
    cdn = re.compile(r"https://[^\s\"'`]*/katex@")
    loading = {
        f"/{file.relative_to(static).as_posix()}"
        for file in static.rglob("*.js")
        if cdn.search(file.read_text(encoding="utf-8"))
    }
    found = local_scripts(static)
    assert loading
    assert loading <= found.keys()
    assert not any(map(cdn.search, found.values()))


def test_opening_the_address_ends_runs_without_a_page_and_no_others(server, monkeypatch):
    headers = page_headers(server.url())

    def call(path, session, **body):
        request = urllib.request.Request(
            f"{server.address}/api/{path}",
            data=json.dumps(body).encode(),
            headers={"Content-Type": "application/json", "X-Session-ID": session, **headers},
        )
        return json.load(urllib.request.urlopen(request, timeout=60))

    for session in ("gone", "there"):
        call("exec", session, code="import time", id="1")
        call("stream/start", session, expr="time.sleep(0.01) or {'done': False, 'result': 1}")
    monkeypatch.setattr("pathsim_jsbsim_blocks.pathview.server._SILENT", 0.5)
    end = time.monotonic() + 1.0
    while time.monotonic() < end:
        assert not call("stream/poll", "there")["done"]
    get(server.url())
    assert call("stream/poll", "gone") == {"messages": [], "done": True}
    assert call("stream/poll", "there")["messages"]


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
