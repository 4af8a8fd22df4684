"""Which models may run: those of this package, and those that the user has trusted.

Parameters and code of a model are Python and run when the model runs.
"""

from __future__ import annotations

import functools
import hashlib
import json
import os
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..catalogue import diagram_folder
from ..errors import UntrustedModelError
from . import pvm
from .generate import checked, to_python
from .shape import Json
from .toolboxes import registry_for

_remembered: set[str] = set()  # in this process; the file may be read-only


def trusted(
    content: Json, path: Path, trust: bool = False, trust_toolboxes: Sequence[str] = ()
) -> tuple[Json, str]:
    """A trusted model in the form that PathView runs, and its script; none of it is executed here.

    ``content`` comes from `pvm.read`, so the model that runs is the one checked. ``trust`` trusts
    it now and later. An `UntrustedModelError` has the digest by which the model can be trusted.
    """
    registry = registry_for(content, path, trust_toolboxes=trust_toolboxes)
    model = checked(content, registry, path)
    code = to_python(model, registry, path)
    if trust:
        remember(digest(content))
    require_trust(content, path)
    return model, code


def require_trust(content: Json, path: Path) -> None:
    """Refuse a model that is neither one of this package nor trusted by the user."""
    value = digest(content)
    if value not in _remembered and value not in _trusted() and value not in _ours():
        raise UntrustedModelError(path=path, digest=value)


def digest(content: Json) -> str:
    """A digest of a model's content without times of saving and positions of blocks."""

    def lasting(value: Any) -> Any:
        if isinstance(value, dict):
            return {
                k: v if k == "params" else lasting(v)
                for k, v in value.items()
                if not (k == "position" and _coordinates(v))
            }
        return [lasting(v) for v in value] if isinstance(value, list) else value

    metadata = content.get("metadata")
    if isinstance(metadata, dict):
        lasting_metadata = {k: v for k, v in metadata.items() if k not in ("created", "modified")}
        content = {**content, "metadata": lasting_metadata}
    return hashlib.sha256(json.dumps(lasting(content), sort_keys=True).encode()).hexdigest()


def _coordinates(value: Any) -> bool:
    return isinstance(value, dict) and all(isinstance(x, (int, float)) for x in value.values())


def remember(value: str) -> None:
    """Record permanently that the user trusts the model with this digest."""
    _remembered.add(value)
    try:
        file = _file()
        file.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        with file.open("a", encoding="ascii") as lines:
            lines.write(f"{value}\n")
    except (OSError, RuntimeError) as error:
        warnings.warn(f"cannot remember the model ({error}); you will be asked again", stacklevel=2)


def _trusted() -> set[str]:
    try:
        return set(_file().read_text(encoding="ascii", errors="replace").split())
    except (OSError, RuntimeError):
        return set()


@functools.cache
def _ours() -> set[str]:
    return {digest(pvm.read(p)) for p in diagram_folder().glob("*/*.pvm")}


def _file() -> Path:
    """File with one digest per line, in the system's folder for application state."""
    home = Path.home()  # RuntimeError if the user has none, as in some containers
    if sys.platform == "win32":
        folder = Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    elif sys.platform == "darwin":
        folder = home / "Library" / "Application Support"
    else:
        state = Path(os.environ.get("XDG_STATE_HOME", ""))
        # the XDG specification says to ignore a relative path
        folder = state if state.is_absolute() else home / ".local" / "state"
    return folder / "pathsim-jsbsim-blocks" / "trusted-models"
