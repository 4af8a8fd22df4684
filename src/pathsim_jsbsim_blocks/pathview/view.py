"""Start PathView with this package's blocks registered and a diagram open."""

from __future__ import annotations

import importlib.util
import json
import logging
import os
import signal
import sys
import tempfile
import threading
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn
from unittest.mock import patch
from urllib.parse import quote

from ..catalogue import find_diagram
from ..checks import whole
from ..errors import MissingExtraError, ParameterError
from . import pvm
from .convert import Json, registry_for, required_toolboxes, to_python
from .export import script_model
from .toolboxes import OURS, Toolbox

HOST = "127.0.0.1"
# one address from day to day: the browser keeps the user's settings by address
PORT = 8360

# PathView installs this toolbox with pip when it first starts in a browser
_PRELOADED = ("pathsim-chem", "pathsim_chem")
_CATEGORIES = {  # module of this package: category and shape in PathView's block library
    "fdm": ("Aircraft", "rect"),
    "sources": ("Sources", "pill"),
    "control": ("Autopilot", "rect"),
    "atmosphere_blocks": ("Air data", "rect"),
    "airspeed": ("Air data", "rect"),
    "axes": ("Axes", "rect"),
}


def view(target: str | Path | None = None, port: int | None = None, browser: bool = True) -> None:
    """Serve PathView on 127.0.0.1 until Ctrl-C, with a diagram open and its toolboxes registered.

    Parameters
    ----------
    target : str or Path, optional
        a diagram of the catalogue, a model (.pvm, .json) or a script (.py); default is an empty
        diagram
    port : int, optional
        default is 8360, or a free port if that is in use
    browser : bool
        open the user's browser

    Raises
    ------
    DiagramError
        if the diagram cannot be shown as it is
    ParameterError
        if there is no such diagram, a toolbox that it needs is not installed, or the port is in use
    """
    model = None if target is None else _load(target)
    name = "" if target is None else f"{Path(target).stem}.pvm"
    sessions: set[str] = set()
    with _interrupts(), _temporary_files():
        server = _server(_app({} if model is None else {name: model}, sessions), port)
        url = f"http://{HOST}:{server.effective_port}/editor"
        if model is not None:
            url += f"?model=/model/{quote(name)}"
        print(f"PathView: {url}\nCtrl-C ends it", flush=True)
        if browser:
            threading.Thread(target=webbrowser.open, args=[url], daemon=True).start()
        try:
            server.run()
        finally:
            server.close()
            _end(sessions)


def _load(target: str | Path) -> Json:
    """A model, checked as a whole: PathView runs a diagram without the blocks it does not know."""
    path = Path(target)
    if path.suffix not in (".pvm", ".json"):
        script = find_diagram(str(target))
        path = script.with_suffix(".pvm")
        if str(target) != script.stem or not path.exists():
            return script_model(script, pvm.read(path) if path.exists() else None)
    content = pvm.read(path)
    to_python(content, registry_for(content, path), path)
    return content


def _app(models: dict[str, Json], sessions: set[str]) -> Any:
    """PathView's own application, with models to open, and an editor that knows their toolboxes."""
    try:
        import pathview
        from flask import abort, request
        from pathview.app import create_app
    except ImportError as error:
        raise MissingExtraError("pathview", "pathview") from error

    page = (Path(pathview.__file__).parent / "static" / "index.html").read_text(encoding="utf-8")
    page = page.replace("<head>", f"<head><script>{_registration(models)}</script>", 1)
    app = create_app(serve_static=True)

    @app.before_request
    def only_here() -> None:
        # the server runs any code it is sent: refuse pages that got here by another name
        if request.host.partition(":")[0] not in (HOST, "localhost"):
            abort(403)
        if session := request.headers.get("X-Session-ID"):
            sessions.add(session)

    @app.get("/editor")
    def editor() -> tuple[str, dict[str, str]]:
        return page, {"Cache-Control": "no-store"}

    @app.get("/model/<name>")
    def model(name: str) -> tuple[str, dict[str, str]]:
        if name not in models:
            abort(404)
        return pvm.text(models[name]), {"Content-Type": "application/json",
                                        "Cache-Control": "no-store"}

    return app


def _registration(models: dict[str, Json]) -> str:
    """JavaScript that registers toolboxes before PathView starts; the last one wins a class name."""
    required = [t for name, model in models.items()
                for t in required_toolboxes(model, Path(name))]
    toolboxes = list(dict.fromkeys([*(t for t in (OURS,) if t not in required), *required]))
    entries = [{**t.requirement(), "blocks": _selection(t), "events": []} for t in toolboxes]
    name, module = _PRELOADED
    seeded = [name] if importlib.util.find_spec(module) is None else []
    return f"""(() => {{
        const key = "pathview.toolboxes.v1", toolboxes = {json.dumps(entries)};
        let state = null;
        try {{ state = JSON.parse(localStorage.getItem(key)); }} catch {{}}
        if (state?.version !== 1) state = {{version: 1}};
        const others = (state.toolboxes ?? []).filter(o => !toolboxes.some(t => t.id === o.id));
        state.toolboxes = [...others, ...toolboxes];
        state.seededIds = [...new Set([...(state.seededIds ?? []), ...{json.dumps(seeded)}])];
        localStorage.setItem(key, JSON.stringify(state));
    }})();"""


def _selection(toolbox: Toolbox) -> list[dict[str, Any]]:
    """This package's blocks with their categories; of other toolboxes PathView takes all."""
    out = []
    for name, block in toolbox.blocks().items() if toolbox == OURS else ():
        category, shape = _CATEGORIES.get(block.__module__.split(".")[1], ("Flight", "rect"))
        out.append({"className": name, "enabled": True,
                    "override": {"category": category, "shape": shape}})
    return out


def _server(app: Any, port: int | None) -> Any:
    from waitress import create_server

    logging.getLogger("waitress.queue").setLevel(logging.ERROR)
    if port is not None and whole("port", port, low=0) > 65535:
        raise ParameterError(f"port must be at most 65535, not {port}", parameter="port", value=port)
    for number in [PORT, 0] if port is None else [port]:
        try:
            return create_server(app, host=HOST, port=number, threads=8)
        except OSError as error:
            if number == 0 or port is not None:
                raise ParameterError(f"port {number} cannot be used ({error.strerror})",
                                     parameter="port", value=port) from error
    raise AssertionError


def _end(sessions: set[str]) -> None:
    from pathview.app import remove_session

    for session in sessions:
        remove_session(session)


@contextmanager
def _temporary_files() -> Iterator[None]:
    """One folder for what PathView's workers put aside: they are killed and cannot tidy up."""
    with tempfile.TemporaryDirectory(prefix="pathsim-jsbsim-", ignore_cleanup_errors=True) as folder:
        with patch.dict(os.environ, TMPDIR=folder, TMP=folder, TEMP=folder):
            yield


@contextmanager
def _interrupts() -> Iterator[None]:
    """A closed terminal and ``kill`` end the server as Ctrl-C does."""
    def interrupt(number: int, frame: FrameType | None) -> NoReturn:
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = [getattr(signal, n) for n in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, n)]
    before = {n: signal.signal(n, interrupt) for n in numbers}
    try:
        yield
    except KeyboardInterrupt:
        pass
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)

