"""Recordings of scopes, and the labels of their signals."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from .checks import refuse

if TYPE_CHECKING:
    from pathsim.blocks import Scope


def recording(scope: Scope) -> tuple[np.ndarray, np.ndarray]:
    """Times and values, one row for each signal; refused if nothing was recorded."""
    from pathsim.blocks import Scope  # imported late: a trim does not need PathSim

    if not isinstance(scope, Scope):
        refuse("scope", scope, f"scope must be a Scope or recorder, not {type(scope).__name__}")
    time, data = scope.read()
    if time is None:
        refuse("scope", scope, "the scope has no recording: run the simulation first")
    # Ctrl-C may have stopped a scope between storing a time and its values
    n = min(len(time), data.shape[1])
    return time[:n], data[:, :n]


def signal_label(scope: Scope, i: int) -> str:
    """Label of a signal; ``port i`` if it has none."""
    return scope.labels[i] if i < len(scope.labels) else f"port {i}"


def name_and_unit(text: str) -> tuple[str, str]:
    """Name and unit of a label of the form ``"pitch angle [deg]"``."""
    match = re.fullmatch(r"(.*?)\s*\[([^\]]*)\]\s*", text)
    return (match[1], match[2]) if match else (text, "")
