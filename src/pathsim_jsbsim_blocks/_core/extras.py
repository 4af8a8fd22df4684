"""Import optional packages."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from ..errors import MissingExtraError


def required(package: str, extra: str, name: str | None = None) -> Any:
    """A package of an extra, or MissingExtraError; ``name`` is its name if not the module's."""
    try:
        return import_module(package)
    except ModuleNotFoundError as error:
        if error.name != package:
            raise
        raise MissingExtraError(name or package, extra) from None
