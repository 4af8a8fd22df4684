"""Access control for PathView's server, which runs any code that it is sent."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable
from hmac import compare_digest
from pathlib import Path
from typing import Any

HOST = "127.0.0.1"
_NAMES = (HOST, "localhost")
_SAFE = ("GET", "HEAD")


class Access:
    """Secrets of one server start: a token in the opened address, exchanged for a cookie.

    They differ because other programs may see or log the address. ``may_open`` tells whether the
    page may open the file at a path.
    """

    def __init__(self, may_open: Callable[[str], bool]):
        self.token = secrets.token_urlsafe(32)
        self._session = secrets.token_urlsafe(32)
        self._may_open = may_open

    def refusal(self, request: Any, page: bool) -> str:
        """Reason for refusing a request, ``page`` if it is for an HTML page; empty if allowed."""
        headers = request.headers
        # another site can make its own name resolve to this machine (DNS rebinding)
        if request.host.partition(":")[0] not in _NAMES:
            return "unknown host name"
        if _of_another_user(request.environ):
            return "this server answers its own user only"
        if not (self.has_token(request) or self._has_cookie(request)):
            return "open the address that the command has printed: it carries this start's token"
        if request.path.startswith("/api/"):
            if headers.get("Sec-Fetch-Site") != "same-origin":
                return "only the served page may call this"
            # browsers omit Origin in same-origin reads
            absent = None if request.method not in _SAFE else _origin(request)
            if headers.get("Origin", absent) != _origin(request):
                return "only the served page may call this"
        elif request.method not in _SAFE:
            return "only GET and HEAD are allowed here"
        return self._bad_parameter(request) if page else ""

    def has_token(self, request: Any) -> bool:
        """Whether the address carries the token."""
        token = request.args.get("token", "")
        return request.method in _SAFE and compare_digest(token.encode(), self.token.encode())

    def set_cookie(self, request: Any, response: Any) -> None:
        """Let the page's own requests in: browsers keep cookies by host, for all its ports."""
        response.set_cookie(_cookie(request), self._session, httponly=True, samesite="Strict")

    def _has_cookie(self, request: Any) -> bool:
        cookie = request.cookies.get(_cookie(request), "")
        # another port of this host is the same site: its pages send the cookie too
        return request.headers.get("Sec-Fetch-Site") in ("same-origin", "none") and compare_digest(
            cookie.encode(), self._session.encode()
        )

    def _bad_parameter(self, request: Any) -> str:
        """Error text for the first query parameter that is unknown or loads foreign content."""
        harmless = ("token", "theme", "tour", "new", "fancyloading")
        for name, value in request.args.items(multi=True):
            if not (
                name in harmless
                or (name == "model" and self._may_open(value))
                or (name, value) in (("backend", "flask"), ("host", _origin(request)))
            ):
                return f"not served here: {name}={value}"
        return ""


def _origin(request: Any) -> str:
    return f"http://{request.host}"


def _cookie(request: Any) -> str:
    return f"pathsim-jsbsim-{request.environ['SERVER_PORT']}"


def _of_another_user(environ: dict[str, Any]) -> bool:
    """Whether the client belongs to another user; False if the system cannot tell (not Linux).

    The browser's command line shows the token to every user of the machine, and a browser sends
    the cookie to servers of other users on other ports of this host.
    """
    try:
        # an IPv6 socket may connect to IPv4
        rows = [
            line.split()
            for table in ("tcp", "tcp6")
            for line in Path("/proc/net", table).read_text().splitlines()[1:]
        ]
        ours, theirs = (f":{int(environ[p]):04X}" for p in ("SERVER_PORT", "REMOTE_PORT"))
    except (OSError, KeyError, ValueError):
        return False
    users = {
        int(row[7])
        for row in rows
        # a socket closed by its program has no inode and lists root as its owner
        if row[1].endswith(theirs) and row[2].endswith(ours) and row[9] != "0"
    }
    if not users:  # some sandboxes show no connection at all
        return any(row[1].endswith(ours) for row in rows)
    # port forwarders of containers and of WSL run as root
    return bool(users - {os.getuid(), 0})
