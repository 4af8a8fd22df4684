"""Ports by name: one that does not exist is refused, naming the nearest."""

from __future__ import annotations

from typing import Any

from pathsim.blocks import Block

from ..errors import BlocksError, ParameterError
from .checks import did_you_mean, nearest


class NamedPorts(Block):
    """Base of blocks whose ports have names: ``block["name"]`` is checked against them."""

    def __getitem__(self, key: Any) -> Any:
        names = [*self.inputs._mapping, *self.outputs._mapping]
        for port in key if isinstance(key, (list, tuple)) else [key]:
            if isinstance(port, str) and port not in names:
                close = nearest(port, names)
                known = did_you_mean(close) if close else f"; its ports are {', '.join(names)}"
                raise self._no_port(f"{type(self).__name__} has no port {port!r}{known}", port,
                                    close)
        return super().__getitem__(key)

    def _no_port(self, message: str, port: str, close: list[str]) -> BlocksError:
        return ParameterError(message, parameter="port", value=port)
