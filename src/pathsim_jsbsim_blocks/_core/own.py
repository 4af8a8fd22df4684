"""A block's own values: read-only copies of what the caller passed."""

from __future__ import annotations

from collections.abc import Mapping, MutableSequence
from typing import Any, NoReturn

import numpy as np


def _read_only(self: Any, *_: Any, **__: Any) -> NoReturn:
    kind = type(self).__mro__[1].__name__
    raise TypeError(f"a parameter is read-only: edit a copy, {kind}(...), and set that")


class ReadOnlyDict(dict):
    """A dict that can be hashed, and not edited; ``dict(values)`` can."""

    __setitem__ = __delitem__ = __ior__ = _read_only  # type: ignore[assignment]
    clear = pop = popitem = setdefault = update = _read_only  # type: ignore[assignment]

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(frozenset(self.items()))

    def __reduce__(self) -> tuple[type, tuple[dict]]:
        return type(self), (dict(self),)


class ReadOnlyList(list):
    """A list that cannot be edited; ``list(values)`` can."""

    __setitem__ = __delitem__ = __iadd__ = __imul__ = _read_only  # type: ignore[assignment]
    append = extend = insert = pop = remove = _read_only  # type: ignore[assignment]
    clear = sort = reverse = _read_only  # type: ignore[assignment]

    def __reduce__(self) -> tuple[type, tuple[list]]:
        return type(self), (list(self),)


def own(value: Any) -> Any:
    """A read-only copy of a dict, list, set or array, nested ones included; others unchanged."""
    if isinstance(value, np.ndarray):
        value = value.copy()
        value.flags.writeable = False
    elif isinstance(value, Mapping):
        value = ReadOnlyDict({key: own(x) for key, x in value.items()})
    elif isinstance(value, (list, MutableSequence)):
        value = ReadOnlyList(map(own, value))
    elif type(value) is tuple:
        value = tuple(map(own, value))
    elif isinstance(value, set):
        value = frozenset(value)
    return value


def editable(value: Any) -> Any:
    """The same value in dicts and lists that can be edited."""
    if isinstance(value, ReadOnlyDict):
        return {key: editable(x) for key, x in value.items()}
    if isinstance(value, ReadOnlyList):
        return [editable(x) for x in value]
    return tuple(map(editable, value)) if type(value) is tuple else value
