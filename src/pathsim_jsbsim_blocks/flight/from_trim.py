"""A flight looked at from its trim, with another aircraft: a twin, and a trim of the present."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields
from typing import Any

from .flightgear import sending_to
from .flyable import Flyable
from .trimming import TrimState, trim
from .trimming.initial import present_condition

# called with each block that has taken off: when it is built, and again after a reset
at_take_off: list[Callable[[Any], None]] = []


@contextlib.contextmanager
def _unobserved() -> Iterator[None]:
    """Context in which blocks take off without being recorded."""
    observers, at_take_off[:] = at_take_off[:], []
    try:
        yield
    finally:
        at_take_off[:] = observers


def twin(flown: Flyable) -> Any:
    """A sealed block with the same parameters and a fresh aircraft, trimmed as this one was."""
    # the constructor of a user's subclass may have other parameters
    block: Any = next(c for c in type(flown).__mro__ if "__dataclass_fields__" in vars(c))
    parameters = {f.name: getattr(flown, f.name) for f in fields(block)}
    with _unobserved(), sending_to(None):
        return block._trimmed_like(flown._before, **{**parameters, "flightgear": None})


def trim_here(flown: Flyable, changes: Mapping[str, Any]) -> TrimState:
    """Trim the present flight with changes of its condition; see `FlightBlock.trim_here`."""
    condition = present_condition(flown.airframe, flown.trim.condition, flown.setup, changes)
    return trim(flown.airframe.twin(), condition)
