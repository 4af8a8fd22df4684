"""What other pages and other people's models can do to the editor: nothing."""

import functools
import json
import threading
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import urlsplit

import pytest
from how_many import first
from pathview_models import block, event, model, wire

from pathsim_jsbsim_blocks.catalogue import find_diagram
from pathsim_jsbsim_blocks.pathview import pvm


def mark(where):
    """JavaScript that runs Python in the editor's worker, which leaves a file behind."""
    code = json.dumps({"id": "x", "code": f"open({str(where)!r}, 'w').close()"})
    return (
        "fetch('/api/exec', {method: 'POST', body: " + json.dumps(code) + ", headers: "
        "{'Content-Type': 'application/json', 'X-Session-ID': "
        "localStorage.getItem('flask-session-id') ?? 'x'}}); top.ran = true"
    ).replace('"', "&quot;")


def hostile(*names, notes=()):
    """A model whose texts hold markup: each name is that of a block, its port, a trace and an event."""

    def at(thing, x, y, **changes):
        return {**thing, "position": {"x": x, "y": y}, **changes}

    count = len(names)
    scope = block("s", "Scope", count, 0, labels=json.dumps(names))
    for port, name in zip(scope["inputs"], names, strict=True):
        port["name"] = name
    blocks, events = [], []
    for i, name in enumerate(names):
        port = {"id": f"a{i}-output-0", "name": name}
        constant = block(f"a{i}", "Constant", value="1.0")
        blocks.append(at(constant, 100, 100 + 150 * i, name=name, outputs=[port]))
        crossing = event(name, "pathsim.events.ZeroCrossing", func_evt="lambda t: t - 0.5")
        events.append(at(crossing, 700, 300 + 150 * i, id=f"e{i}"))
    annotations = [
        at({"id": f"n{i}", "content": note, "width": 300, "height": 100}, 0, -200 - 150 * i)
        for i, note in enumerate([*notes, *names])
    ]
    wires = [wire(f"a{i}", "s", into=i) for i in range(count)]
    content = model(
        *blocks, at(scope, 400, 100), connections=wires, annotations=annotations, events=events
    )
    return {**content, "simulationSettings": {"duration": "1.0", "dt": "0.1"}}


@pytest.fixture(params=first(["127.0.0.1", "localhost"]))  # the same site, and another one
def elsewhere(request, tmp_path):
    """The address of another web server on this machine, which serves the test's folder."""
    handler = functools.partial(SimpleHTTPRequestHandler, directory=tmp_path)
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://{request.param}:{server.server_port}"
        server.shutdown()


@pytest.fixture
def oscillator(models):
    models["sine.pvm"] = pvm.read(find_diagram("damped_oscillator").with_suffix(".pvm"))
    return "sine.pvm"


TEXTS = [
    'step $x$<img src=q onerror="{}">',
    '$x$<a class=trap href="javascript:{}">a</a>',
    '<img src=q onerror="{}">$x$',
    '$x$<details open ontoggle="{}">',
    '$x$<iframe srcdoc="<script>{}</script>"></iframe>',
    '<img src=q onerror="{}">',
    "$\\href{{javascript:{}}}{{x}}$",
    '$x$<iframe src="javascript:{}"></iframe>',
]
# a link's address ends at the first bracket
NOTES = [
    "[a](javascript:top.ran=true)",
    '[a](x" onmouseover="top.ran=true" class="trap)',
    '$x$<img src=q onerror="top.ran=true">',
    "<script>top.ran=true</script>",
]


@pytest.mark.long
def test_a_model_opened_in_the_page_runs_nothing(editor, models, tmp_path):
    where = tmp_path / "ran"
    texts = [text.format(mark(where)) for text in TEXTS]
    models["hostile.pvm"] = hostile(*texts, notes=NOTES)  # as if opened there: ``view`` refuses it
    editor.open("hostile.pvm")
    for i, text in enumerate(texts):
        if "$x$" in text:  # the page does take the name for HTML
            block = f".svelte-flow__node[data-id='a{i}']"
            traps = editor.page.locator(f"{block} :is(img, details, iframe, .trap)")
            traps.first.wait_for(state="attached")
    for trap in editor.page.locator(".trap, .svelte-flow__node a").all():
        trap.dispatch_event("mouseover")
        trap.dispatch_event("click")
    assert editor.run() == "Simulation completed successfully"
    editor.page.wait_for_timeout(500)
    assert not editor.page.evaluate("window.ran")
    assert not where.exists()
    assert not editor.elsewhere


@pytest.mark.long
def test_another_page_cannot_call_or_frame_the_editor(editor, elsewhere, oscillator, tmp_path):
    where = tmp_path / "ran"
    editor.page.unroute_all()
    editor.open(oscillator)
    session = editor.page.evaluate("localStorage.getItem('flask-session-id')") + "-0"
    code = json.dumps({"id": "x", "code": f"open({str(where)!r}, 'w').close()"})
    attack = f"""<iframe src="{editor.url(oscillator)}"></iframe>
        <iframe src="{editor.address}/editor"></iframe>
        <form method=post target=_blank enctype=text/plain action="{editor.address}/api/exec">
        <input name='{code[:-1]}, "a": "' value='"}}'></form>
        <script>window.done = (async () => {{
            const body = {json.dumps(code)}, out = [];
            for (const mode of ["cors", "no-cors", "same-origin"])
                for (const type of ["application/json", "text/plain"])
                    for (const headers of [{{"Content-Type": type}}, {{"Content-Type": type,
                                           "X-Session-ID": "{session}"}}])
                        try {{
                            const answer = await fetch("{editor.address}/api/exec", {{
                                method: "POST", credentials: "include", mode, headers, body}});
                            out.push(answer.type + await answer.text());
                        }} catch {{}}
            try {{ out.push(await (await fetch("{editor.address}/model/{oscillator}",
                {{credentials: "include"}})).text()); }} catch {{}}
            document.forms[0].submit();
            return out;
        }})()</script>"""
    (tmp_path / "attack.html").write_text(attack)
    page = editor.context.new_page()
    asked, opened = [], []
    page.on("request", lambda r: asked.append(urlsplit(r.url).path))
    editor.context.on("page", lambda p: opened.append(p))
    page.goto(f"{elsewhere}/attack.html")
    read = page.evaluate("window.done")
    page.wait_for_timeout(1500)
    assert set(read) <= {"opaque"}
    assert asked.count("/api/exec") >= 8  # the browser has tried
    # what the form has opened: a plain text, sent before the body is read
    [answer] = [p.inner_text("body").split("\n") for p in opened]
    assert answer[0] == "Forbidden"
    assert "open the address that the command has printed: it carries this start's token" in answer
    assert not where.exists()
    assert not any(frame.url.startswith(editor.address) for frame in page.frames)
    # and the user's own page goes on
    assert editor.run() == "Simulation completed successfully"
