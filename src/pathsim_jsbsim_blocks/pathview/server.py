"""PathView's own server, with models to open and an editor that knows their toolboxes."""

from __future__ import annotations

import importlib.util
import json
import logging
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any
from urllib.parse import quote

from .._core.checks import whole
from ..errors import MissingExtraError, ParameterError
from . import pvm
from .shape import Json
from .toolboxes import OURS, Toolbox, required_toolboxes

HOST = "127.0.0.1"
# one address from day to day: the browser keeps the user's settings by address
PORT = 8360

# PathView installs this toolbox with pip when it first starts in a browser
_PRELOADED = ("pathsim-chem", "pathsim_chem")
_CATEGORIES = {  # folder of this package: category and shape in PathView's block library
    "flight": ("Aircraft", "rect"),
    "sources": ("Sources", "pill"),
    "control": ("Autopilot", "rect"),
    "axes": ("Axes", "rect"),
    "air": ("Air data", "rect"),
}


class Server:
    """PathView on 127.0.0.1. As a context manager it closes itself, with PathView's workers.

    Parameters
    ----------
    models : mapping
        contents of models by file name
    port : int, optional
        default is 8360, or a free port if that is in use; 0 is a free port

    Raises
    ------
    ParameterError
        if the port cannot be used
    """

    def __init__(self, models: Mapping[str, Json], port: int | None = None):
        self._sessions: set[str] = set()
        self._closed = False
        self._server = _bound(self._app(models), port)
        self.address = f"http://{HOST}:{self._server.effective_port}"

    def url(self, name: str = "") -> str:
        """Where the editor is, with a model open."""
        return f"{self.address}/editor" + (f"?model=/model/{quote(name)}" if name else "")

    def run(self) -> None:
        """Serve until KeyboardInterrupt, or ``close`` in another thread."""
        try:
            self._server.run()
        except OSError:  # closed while it waits
            if not self._closed:
                raise

    def close(self) -> None:
        from pathview.app import remove_session

        self._closed = True
        self._server.close()
        while self._sessions:
            remove_session(self._sessions.pop())

    def __enter__(self) -> Server:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()

    def _app(self, models: Mapping[str, Json]) -> Any:
        try:
            import pathview
            from flask import abort, request
            from pathview.app import create_app
        except ImportError as error:
            raise MissingExtraError("pathview", "pathview") from error

        index = Path(pathview.__file__).parent / "static" / "index.html"
        page = index.read_text(encoding="utf-8")
        app = create_app(serve_static=True)

        @app.before_request
        def guard() -> None:
            # the server runs any code it is sent: refuse pages that got here by another name
            if request.host.partition(":")[0] not in (HOST, "localhost"):
                abort(403)
            if session := request.headers.get("X-Session-ID"):
                self._sessions.add(session)

        @app.get("/editor")
        def editor() -> tuple[str, dict[str, str]]:
            name = request.args.get("model", "").rpartition("/")[2]
            required = required_toolboxes(models[name], Path(name)) if name in models else []
            script = f"<script>{_registration(required)}</script>"
            return page.replace("<head>", f"<head>{script}", 1), {"Cache-Control": "no-store"}

        @app.get("/model/<name>")
        def model(name: str) -> tuple[str, dict[str, str]]:
            if name not in models:
                abort(404)
            return pvm.text(models[name]), {"Content-Type": "application/json",
                                            "Cache-Control": "no-store"}

        return app


def _bound(app: Any, port: int | None) -> Any:
    from waitress import create_server

    # it warns of a full queue, and of requests that it drops at the end
    logging.getLogger("waitress").setLevel(logging.ERROR)
    if port is not None and whole("port", port, low=0) > 65535:
        raise ParameterError(f"port must be at most 65535, not {port}", parameter="port",
                             value=port)
    try:
        return create_server(app, map={}, host=HOST, threads=8,
                             port=PORT if port is None else port)
    except OSError as error:
        if port is None:
            return _bound(app, 0)
        raise ParameterError(f"port {port} cannot be used ({error.strerror})", parameter="port",
                             value=port) from error


def _registration(required: list[Toolbox]) -> str:
    """JavaScript that registers toolboxes before PathView starts; the last one wins a name."""
    toolboxes = required if OURS in required else [OURS, *required]
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
        // a model that opens before its toolboxes are there is drawn, and wired, at wrong sizes
        const fetched = window.fetch, ready = "button[aria-label='Run']:not([disabled])";
        const pause = ms => new Promise(done => setTimeout(done, ms));
        window.fetch = async (url, ...rest) => {{
            if (String(url).startsWith("/model/"))
                for (let i = 0; i < 600 && !document.querySelector(ready); i++) await pause(100);
            return fetched(url, ...rest);
        }};
    }})();"""


def _selection(toolbox: Toolbox) -> list[dict[str, Any]]:
    """This package's blocks with their categories; of other toolboxes PathView takes all."""
    out = []
    for name, block in toolbox.blocks().items() if toolbox == OURS else ():
        category, shape = _CATEGORIES[block.__module__.split(".")[1]]
        out.append({"className": name, "enabled": True,
                    "override": {"category": category, "shape": shape}})
    return out
