"""PathView's editor as a user handles it, and the data that it receives."""

import contextlib
import json
import re
from pathlib import Path

import numpy as np

from pathsim_jsbsim_blocks.pathview.toolboxes import OURS

ENDED = re.compile(
    r"Simulation (completed|continued) successfully|"
    r"(Streaming|Continue) simulation failed|Validation (failed|error)"
)
TIMED_OUT = "Execution timed out"
SIZE = {"width": 1200, "height": 800}  # px: small enough for the text to be read on a page


class Editor:
    """A page in a fresh browser profile, or in the one that is given.

    ``url`` gives the address of a model, with the server's token.
    """

    def __init__(self, browser, address, url=None, profile=None):
        self.address, self.url = address, url
        self.context = profile or browser.new_context(
            viewport={"width": 1600, "height": 1000}, accept_downloads=True
        )
        self.page = self.context.new_page()
        self.errors = []
        self.overlooked = 0  # errors in PathView's console
        self.runs = []  # of each run: {node id: [time, [signals]]}
        self.polls = []  # answers in their order whose bodies are not here yet
        self.page.on("pageerror", lambda e: self.errors.append(str(e)))
        self.page.on("console", self._console)
        self.page.on("response", self._response)
        self.page.on("request", self._request)
        self.elsewhere = []  # what the page asks of other servers: it gets nothing
        self.page.route(
            lambda url: not url.startswith((address, "blob:", "data:")), lambda route: route.abort()
        )

    def __enter__(self):
        return self

    def __exit__(self, *exc):
        if self.page.url.startswith(self.address):  # the worker process of this profile
            with contextlib.suppress(Exception):  # the server has ended
                self.page.evaluate("""() => fetch("/api/session", {method: "DELETE", headers: {
                    "X-Session-ID": localStorage.getItem("flask-session-id")}})""")
        self.context.close()

    def _console(self, message):
        lost = TIMED_OUT in message.text or "504 (GATEWAY TIMEOUT)" in message.text  # see run
        if (
            message.type == "error"
            and not lost
            and message.location["url"].startswith(self.address)
        ):
            self.errors.append(message.text)

    def _request(self, request):
        if not request.url.startswith((self.address, "blob:", "data:")):
            self.elsewhere.append(request.url)

    def _response(self, response):
        path = response.url.removeprefix(self.address)
        if path.startswith("/api/stream/start"):
            self.runs.append({})
        elif path.startswith("/api/stream/poll"):
            self.polls.append(poll := [])
            poll.append(response.json().get("messages", []))  # the next answer may come meanwhile
            while self.polls and self.polls[0]:
                [messages] = self.polls.pop(0)
                for message in messages:
                    if message["type"] == "stream-data":
                        self._take(json.loads(message["value"])["result"])

    def _take(self, result):
        for node, data in (result or {}).get("scopeData", {}).items():
            time, signals = self.runs[-1].setdefault(node, [[], [[] for _ in data["signals"]]])
            time += data["time"]
            for whole, part in zip(signals, data["signals"], strict=True):
                whole += part

    def open(self, name):
        """Open a model of the server, and wait until it can run."""
        self.page.goto(self.url(name))
        self.ready()

    def open_empty(self):
        """Open the editor without a model, and wait until it can run one."""
        self.page.goto(self.url(""))
        self._can_run()

    def _can_run(self):
        self.page.wait_for_selector("button[aria-label='Run']:not([disabled])", timeout=120_000)

    def ready(self):
        self._can_run()
        self.page.wait_for_selector(".svelte-flow__node")

    def blocks(self):
        """What the canvas shows of each block, and how many ports it has."""
        return self.page.evaluate(
            """() => [...document.querySelectorAll('.svelte-flow__node')].map(n => [
                n.dataset.id, n.innerText, n.querySelectorAll('.svelte-flow__handle').length])"""
        )

    def messages(self, level=""):
        """The lines of PathView's own console panel."""
        if self.page.locator(".console-panel").count() == 0:
            self.page.click("button[aria-label='Console']")
            self.page.wait_for_selector(".console-panel")
        return self.page.locator(f".console-panel .log-entry{level}").all_inner_texts()

    def complaints(self):
        """Errors in PathView's console, but for a scope with nothing new and a run done again."""
        return [
            m
            for m in self.messages(".error")[self.overlooked :]
            if m.strip() not in ("", "Error reading Scope: 'NoneType' object is not iterable")
        ]

    def run(self, button="Run", timeout=300_000):
        """Press a button and wait for the run's end; returns what PathView says of it."""
        runs = len(self.runs)
        said = self._press(button, timeout)
        if TIMED_OUT in said:
            # two threads of PathView's worker read its messages after a run, and at times one is
            # lost between them; the server then gives up after 35 s and starts another worker
            if button == "Continue":
                self._press("Run", timeout)
            del self.runs[runs:]
            self.overlooked = len(self.messages(".error"))
            said = self._press(button, timeout)
        return said

    def _press(self, button, timeout):
        before = len(self.messages())
        self.page.click(f"button[aria-label='{button}']")
        self.page.wait_for_function(
            """([pattern, before]) => [...document.querySelectorAll('.console-panel .log-entry')]
                .slice(before).some(e => new RegExp(pattern).test(e.innerText))""",
            arg=[ENDED.pattern, before],
            timeout=timeout,
        )
        for _ in range(600):  # the page may show the end before the last body is here
            if not self.polls:
                break
            self.page.wait_for_timeout(50)
        return next(filter(ENDED.search, reversed(self.messages())))

    def saved(self):
        """The model as the page saves it, without the browser's own dialog."""
        self.page.evaluate("delete window.showSaveFilePicker")
        with self.page.expect_download() as download:
            self.page.click("button[aria-label='Save']")
        return json.loads(Path(download.value.path()).read_text(encoding="utf-8"))

    def python(self):
        """The script that PathView exports."""
        self.page.click("button[aria-label='View Python Code']")
        with self.page.expect_download() as download:
            self.page.click(".export-dialog button[aria-label='Download Python file']")
        self.page.click(".export-dialog button[aria-label='Close']")
        with open(download.value.path(), encoding="utf-8") as file:
            return file.read()


def assert_same(streamed, expected):
    """Recordings in the page and in the script: time and signals by the scope's name."""
    assert streamed.keys() == expected.keys()
    for name, (time, signals) in expected.items():
        np.testing.assert_allclose(streamed[name][0], time, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(streamed[name][1], signals, rtol=1e-12, atol=1e-12)


class Drawing:
    """What a hand does in an empty editor."""

    def __init__(self, page):
        self.page = page
        page.set_default_timeout(120_000)  # a busy machine is slow
        page.set_viewport_size(SIZE)
        # a browser's own file dialogs are out of reach; without them PathView downloads and uploads
        page.add_init_script("delete window.showSaveFilePicker; delete window.showOpenFilePicker")

    def place(self, kind, x, y):
        """Drag a block from the library to the canvas."""
        self.page.fill(".node-library .search-input", kind)
        name = self.page.get_by_text(kind, exact=True)
        tile = self.page.locator(".node-library .node-tile").filter(has=name)
        tile.drag_to(self.page.locator(".svelte-flow__pane"), target_position={"x": x, "y": y - 40})
        self.block(kind).wait_for()

    def block(self, kind):
        name = self.page.locator(".node-type").get_by_text(kind, exact=True)
        return self.page.locator(".svelte-flow__node").filter(has=name)

    def port(self, kind, direction, name):
        """A port by its name, for which the canvas may show a shorter label."""
        labels = getattr(OURS.blocks().get(kind), f"{direction}_port_labels", None)
        index = labels[name] if labels else int(name)
        return self.block(kind).locator(f".handle-{direction}").nth(index)

    def wire(self, source, target):
        """Drag from an output to an input."""
        before = self.page.locator(".svelte-flow__edge").count()
        self.port(source[0], "output", source[1]).drag_to(self.port(target[0], "input", target[1]))
        self.page.wait_for_function(
            "count => document.querySelectorAll('.svelte-flow__edge').length === count",
            arg=before + 1,
        )

    def add_input(self, kind):
        self.block(kind).click()
        self.block(kind).get_by_title("Add input").click()
        self.page.locator(".svelte-flow__pane").click(position={"x": 1100, "y": 700})

    def open(self, kind):
        """Double-click a block: its dialog."""
        box = self.block(kind).bounding_box()
        self.block(kind).dblclick(position={"x": box["width"] / 2, "y": 8})
        return self.page.locator(".properties-dialog")

    def set(self, kind, **parameters):
        dialog = self.open(kind)
        for name, text in parameters.items():
            label = self.page.get_by_text(name, exact=True)
            dialog.locator(".param-item").filter(has=label).locator("input").fill(text)
        return dialog

    def close(self, dialog):
        dialog.locator("button[aria-label='Close']").click()
        dialog.wait_for(state="detached")

    def panel(self, name):
        self.page.click(f"button[aria-label='{name}']")
        self.page.wait_for_timeout(300)  # it slides
