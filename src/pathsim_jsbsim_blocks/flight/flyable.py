"""`Flyable`: the interface of aircraft blocks for models and trims on other aircraft."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from .airframe import Airframe
from .channels import Channel
from .trimming.state import TrimState


class Flyable(Protocol):
    """The members of an aircraft block that a linear model, a response or another trim needs."""

    airframe: Airframe
    trim: TrimState
    setup: Mapping[str, float] | None
    _before: Any
    T: float
    inputs: Any
    outputs: Any

    def channels(self) -> tuple[list[Channel], list[Channel]]: ...
    def trimmed_inputs(self) -> list[float]: ...
    def advance(self, index: int, u: list[float]) -> list[float]: ...
