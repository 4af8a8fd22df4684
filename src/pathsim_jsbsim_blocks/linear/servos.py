"""Servos with hysteresis behind a command, from the XML files of a model."""

from __future__ import annotations

import contextlib
import xml.etree.ElementTree as ET
from collections.abc import Sequence


def hysteresis(components: Sequence[ET.Element], commands: Sequence[str]) -> dict[str, float]:
    """Widths of hysteresis downstream of the commands, by property, in its unit."""
    signals, widths, size = set(commands), dict[str, float](), 0
    while len(signals) > size:
        size = len(signals)
        for component in components:
            texts = {(e.text or "").strip().lstrip("-") for e in component.iter()}
            if texts & signals:
                name = component.get("name", "").lower().replace(" ", "-")
                name = name if "/" in name else f"fcs/{name}"
                signals |= {name, *(e.text.strip() for e in component.iter("output") if e.text)}
                with contextlib.suppress(ValueError):
                    widths[name] = float(component.findtext("hysteresis_width", ""))
    return {name: width for name, width in widths.items() if width > 0.0}
