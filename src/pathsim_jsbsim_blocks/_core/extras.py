"""Packages that an extra brings."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from ..errors import MissingExtraError


def required(package: str, extra: str, name: str | None = None) -> Any:
    """A package that is installed with an extra; its name, where it is not that of the module.

    Raises
    ------
    MissingExtraError
        if the package is not installed
    """
    try:
        return import_module(package)
    except ModuleNotFoundError as error:
        if error.name != package:
            raise
        raise MissingExtraError(name or package, extra) from None
