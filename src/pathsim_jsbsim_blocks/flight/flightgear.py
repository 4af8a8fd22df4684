"""Display flights in FlightGear: JSBSim sends its state in native FDM packets (UDP)."""

from __future__ import annotations

import contextlib
import itertools
import re
import socket
from collections.abc import Iterator
from typing import Any

from .._core.checks import must_be, refuse

HOST, PORT = "127.0.0.1", 5550

# Hz of simulated time; FlightGear draws no faster
_RATE = 60

_addresses: list[Iterator[str | None]] = []


def address(parameter: str, value: Any) -> tuple[str, int]:
    """Host and port of ``HOST:PORT``, ``HOST`` or ``:PORT``."""
    match = re.fullmatch(r"([\w.-]*)(?::(\d{1,5}))?", value) if isinstance(value, str) else None
    port = int(match[2] or PORT) if match else 0
    if not match or not 0 < port < 65536:
        must_be(parameter, value, f"HOST:PORT such as '{HOST}:{PORT}'")
    host = match[1] or HOST
    try:
        socket.getaddrinfo(host, port, socket.AF_INET)
    except OSError as error:
        why = f"{parameter}: the host {host!r} cannot be resolved: {error.strerror}"
        refuse(parameter, value, why)
    return host, port


def directive(host: str, port: int) -> str:
    """JSBSim's output directive that sends the packets."""
    return f"<output name='{host}' type='FLIGHTGEAR' port='{port}' protocol='UDP' rate='{_RATE}'/>"


@contextlib.contextmanager
def sending_to(first: str | None) -> Iterator[None]:
    """Context in which new aircraft blocks send to FlightGear; with None they do not.

    The first block sends to this address, each further one to the next port.
    """
    addresses: Iterator[str | None] = itertools.repeat(None)
    if first is not None:
        host, port = address("flightgear", first)
        addresses = (f"{host}:{n}" for n in itertools.count(port))
    _addresses.append(addresses)
    try:
        yield
    finally:
        _addresses.pop()


def next_address() -> str | None:
    """The address for the next block; None outside of `sending_to`."""
    return next(_addresses[-1]) if _addresses else None
