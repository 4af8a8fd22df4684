"""Values of options."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..errors import ParameterError

if TYPE_CHECKING:
    from ..flight.condition import TrimCondition


def condition_of(args: argparse.Namespace) -> TrimCondition:
    from ..flight.condition import TrimCondition

    # each option of a condition has the name of its field
    fields = {field.name for field in dataclasses.fields(TrimCondition)}
    return TrimCondition(**{name: value for name, value in vars(args).items() if name in fields})


def values_of(option: str, items: Iterable[str]) -> dict[str, float]:
    values = {}
    for item in items:
        name, _, value = item.partition("=")
        try:
            values[name] = float(value)
        except ValueError:
            raise ParameterError(
                f"--{option} needs PROPERTY=VALUE with a number, not {item!r}",
                parameter=option,
                value=item,
            ) from None
    return values


def engine_numbers(text: str) -> tuple[int, ...] | str:
    try:
        return text if text == "all" else tuple(map(int, text.split(",")))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"numbers of engines from 0, such as 0,2, or all, not {text!r}"
        ) from None


def values_in_range(option: str, text: str) -> list[float]:
    """The numbers of FIRST:LAST:STEP, including the last."""
    try:
        first, last, step = map(float, text.split(":"))
        count = int((last - first) / step + 1e-9)
        if not 0 <= count < 10_000:
            raise ValueError
    except (ValueError, OverflowError, ZeroDivisionError):
        raise ParameterError(
            f"--{option} needs FIRST:LAST:STEP, such as 60:120:10, not {text!r}",
            parameter=option,
            value=text,
        ) from None
    return [first + i * step for i in range(count + 1)]
