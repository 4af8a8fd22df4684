"""Properties of JSBSim as ports of a block: lists of names, checked."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from .._core.checks import nearest, property_list, refuse
from ..errors import PropertyError
from .airframe import Airframe
from .writable import why_no_input


def listed(parameter: str, names: Sequence[str] | None) -> list[str]:
    """A list of property names, empty for None."""
    return [] if names is None else property_list(parameter, names)


def behind(name: str, short: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
    """The properties of a short name; any other name is returned as it is."""
    index = re.search(r"\[(\d+)\]$", name)
    if index is None:
        return short.get(name, (name,))
    pattern = short.get(f"{name[: index.start()]}[i]", (name,))
    return tuple(p.replace("[i]", index[0]) for p in pattern)


def check_ports(
    parameter: str,
    names: Any,
    ports: Sequence[str],
    airframe: Airframe,
    short: Mapping[str, tuple[str, ...]] = {},
    taken: Mapping[str, str] = {},
) -> None:
    """Refuse properties that cannot be ports of a block, repetitions, and a changed list.

    ``ports`` are the names after the block's fixed ones, ``short`` the short names of properties,
    ``taken`` the fixed ports by the properties that they write.
    """
    names = listed(parameter, names)
    sources: dict[str, str] = {}
    for name in names:
        for property_ in _properties(name, short, airframe):
            if parameter == "input_properties" and (why := why_no_input(property_)):
                raise airframe.property_error(name, f"{name!r} cannot be an input: {why}")
            if property_ in taken:
                why = f"{parameter} lists {name!r}, but port {taken[property_]!r} writes it already"
                refuse(parameter, names, why)
            if name_before := sources.get(property_):
                first = f", first as {name_before!r}" if name_before != name else ""
                refuse(parameter, names, f"{parameter} lists {name!r} twice{first}")
            sources[property_] = name
    if names != list(ports):
        why = f"{parameter} cannot change because they are the block's ports: build another block"
        refuse(parameter, names, why)


def _properties(name: str, short: Mapping[str, tuple[str, ...]], airframe: Airframe) -> list[str]:
    """The properties of a name; the error for an unknown one suggests short names too."""
    try:
        return [airframe.canonical(property_) for property_ in behind(name, short)]
    except PropertyError as error:
        close = [] if "/" in name else nearest(name, short)
        if not close or behind(name, short) != (name,):
            raise
        message = f"aircraft {airframe.aircraft!r} has no property {name!r}"
        raise airframe.property_error(name, message, [*close, *error.nearest][:3]) from None
