"""PathView's own server, with models to open and their toolboxes registered in the editor."""

from __future__ import annotations

import logging
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

from .._core.checks import integer, refuse
from ..errors import MissingExtraError
from . import page, pvm
from .access import HOST, Access
from .shape import Json
from .toolboxes import required_toolboxes

# a constant address, because the browser stores the user's settings by address
PORT = 8360
_LARGEST = 32 * 2**20  # bytes of a request's body
_SILENT = 10.0  # s; a page with a run polls every second, even if hidden

_HEADERS = {
    "Content-Security-Policy": page.policy(),
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "same-origin",  # the address carries the token
    "X-Content-Type-Options": "nosniff",
}


class Server:
    """PathView on 127.0.0.1. As a context manager it closes itself, with PathView's workers.

    ``models`` are contents by file name; ``port`` is by default 8360, or a free port if that is in
    use; 0 is a free port. A `ParameterError` says why a port cannot be used.
    """

    def __init__(self, models: Mapping[str, Json], port: int | None = None):
        self._heard: dict[str, float] = {}  # time of each session's last request, s
        self._closed = False
        self._models = models
        self._access = Access(self._served)
        self.app = self._app()
        self._server = _bound(self.app, port)
        self._server.channel_class = _channels(self._access)
        self.address = f"http://{HOST}:{self._server.effective_port}"

    def url(self, name: str = "") -> str:
        """Address of the editor with a model open; it grants access to the server."""
        # quoted twice: the page requests the path exactly as written in the parameter
        model = f"model={quote(f'/model/{quote(name)}')}&" if name else ""
        return f"{self.address}/editor?{model}token={self._access.token}"

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
        while self._heard:
            remove_session(self._heard.popitem()[0])

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def _served(self, path: str) -> bool:
        """Whether the page may open the model at a path."""
        folder, _, name = path.rpartition("/")
        if folder == "/examples":
            return f"examples/{name}" in self._files
        return folder == "/model" and unquote(name) in self._models

    def _app(self) -> Any:
        try:
            import pathview
            from flask import make_response, request
            from pathview.app import create_app
        except ImportError as error:
            raise MissingExtraError("pathview", "pathview") from error

        static = Path(pathview.__file__).parent / "static"
        # compared by name: file systems may ignore case and final dots, and limit lengths
        files = filter(Path.is_file, static.rglob("*"))
        self._files = {file.relative_to(static).as_posix(): file for file in files}
        scripts = page.local_scripts(static)
        app = create_app(serve_static=True)

        def source() -> Path | None:
            """The file of the page to serve; PathView has one page for unknown paths."""
            if request.endpoint in ("model", "katex") or request.path.startswith("/api/"):
                return None
            file = self._files.get(request.path[1:], static / "index.html")
            return file if file.suffix == ".html" else None

        @app.before_request
        def answer() -> Any:
            html = source()
            if reason := self._access.refusal(request, page=html is not None):
                return make_response(page.refused(reason), 403)
            if session := request.headers.get("X-Session-ID"):
                if request.path == "/api/init":  # a new page replaces the session's previous one
                    _end_run(session)
                self._heard[session] = time.monotonic()
            if html is not None:
                for session, heard in list(self._heard.items()):
                    if time.monotonic() - heard > _SILENT:
                        _end_run(session)
                return editor(html)
            if text := scripts.get(request.path):
                response = make_response(text)
                response.mimetype = "text/javascript"
                response.add_etag()
                return response.make_conditional(request)
            return None

        def editor(html: Path) -> Any:
            name = unquote(request.args.get("model", "").removeprefix("/model/"))
            model = self._models.get(name, {})
            toolboxes = required_toolboxes(model, Path(name))
            text, nonce = page.rendered(html.read_text(encoding="utf-8"), toolboxes)
            response = make_response(text)
            response.headers["Content-Security-Policy"] = page.policy(nonce)
            response.cache_control.no_store = True  # a nonce is valid for one response
            if self._access.has_token(request):
                self._access.set_cookie(request, response)
            return response

        self._add_routes(app)
        return app

    def _add_routes(self, app: Any) -> None:
        from flask import abort, send_from_directory

        @app.after_request
        def harden(response: Any) -> Any:
            for name, value in _HEADERS.items():
                response.headers.setdefault(name, value)
            return response

        @app.get("/model/<name>")
        def model(name: str) -> tuple[str, dict[str, str]]:
            if name not in self._models:
                abort(404)
            headers = {"Content-Type": "application/json", "Cache-Control": "no-store"}
            return pvm.text(self._models[name]), headers

        @app.get("/katex/<path:name>")
        def katex(name: str) -> Any:
            return send_from_directory(page.KATEX, name)


def _end_run(session: str) -> None:
    """End a session's worker if it has results that no page has read."""
    from pathview.app import _sessions, remove_session

    worker = _sessions.get(session)
    if worker and (worker._streaming or not worker._stream_queue.empty()):
        remove_session(session)


def _channels(access: Access) -> type:
    """A channel class that refuses requests before their body is read."""
    from flask import Request
    from waitress.channel import HTTPChannel
    from waitress.parser import HTTPRequestParser
    from waitress.task import WSGITask
    from waitress.utilities import Error

    class Forbidden(Error):
        code, reason = 403, "Forbidden"

    class Parser(HTTPRequestParser):
        def __init__(self, adj: Any, channel: Any):
            super().__init__(adj)
            self.channel = channel

        def parse_header(self, header_plus: bytes) -> None:
            super().parse_header(header_plus)
            if self.body_rcv is not None:
                request = Request(WSGITask(self.channel, self).get_environment())
                if reason := access.refusal(request, page=False):
                    self.error, self.body_rcv = Forbidden(reason), None
                    self.content_length, self.expect_continue = 0, False

    class Channel(HTTPChannel):
        def parser_class(self, adj: Any) -> Parser:
            return Parser(adj, self)

    return Channel


def _bound(app: Any, port: int | None) -> Any:
    from waitress import create_server

    # silences its warnings about a full queue and about requests dropped at shutdown
    logging.getLogger("waitress").setLevel(logging.ERROR)
    if port is not None and integer("port", port, low=0) > 65535:
        refuse("port", port, f"port must be at most 65535, not {port}")
    try:
        return create_server(
            app,
            map={},
            host=HOST,
            threads=8,
            port=PORT if port is None else port,
            max_request_body_size=_LARGEST,
        )
    except OSError as error:
        if port is None:
            return _bound(app, 0)
        refuse("port", port, f"port {port} cannot be used ({error.strerror})")
