"""What a scope has recorded, and how its signals are labelled."""

from __future__ import annotations

import re
import reprlib
from typing import TYPE_CHECKING

import numpy as np

from .checks import refuse

if TYPE_CHECKING:
    from pathsim.blocks import Scope


def recording(scope: Scope) -> tuple[np.ndarray, np.ndarray]:
    """Times and values, one row for each signal; refused if nothing was recorded."""
    from pathsim.blocks import Scope  # a trim does without PathSim

    if not isinstance(scope, Scope):
        refuse("scope", scope, f"a Scope or a FlightRecorder is needed, not {reprlib.repr(scope)}")
    time, data = scope.read()
    if time is None:
        refuse("scope", scope, "the scope holds no recording: run the simulation first")
    # an interrupt may come between a sample's time and its values
    n = min(len(time), data.shape[1])
    return time[:n], data[:, :n]


def signal_label(scope: Scope, i: int) -> str:
    """Label of a signal; ``port i`` if it has none."""
    return scope.labels[i] if i < len(scope.labels) else f"port {i}"


def name_and_unit(text: str) -> tuple[str, str]:
    """Name and unit of a label of the form ``"pitch angle [deg]"``."""
    found = re.fullmatch(r"(.*?)\s*\[([^\]]*)\]\s*", text)
    return (found[1], found[2]) if found else (text, "")
