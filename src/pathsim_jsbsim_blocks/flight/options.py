"""What functions that build an aircraft of their own pass on to it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypedDict


class AircraftOptions(TypedDict, total=False):
    """Parameters of `Aircraft` beside the model, its trim and its time step."""

    setup: Mapping[str, float] | None
    properties: Mapping[str, float] | None
    root: str | None
    create: Mapping[str, float] | str | None
    allow_network: bool
    allow_files: bool
