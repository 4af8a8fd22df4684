"""Find the diagrams, in the installed package or in the repository.

Of the three folders, ``published`` follows the published notebooks, ``check_cases`` has NASA's
check cases, and ``beyond`` has the others.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from ._core.checks import did_you_mean, mapping, must_be, nearest, refuse
from ._core.files import as_path

__all__ = [
    "diagram_folder",
    "diagram_groups",
    "diagram_names",
    "diagram_notebook",
    "find_diagram",
    "load_diagram",
]


def diagram_folder() -> Path:
    """The root of the catalogue; `find_diagram` gives the script in one of its folders.

    The model ``NAME.pvm`` of a diagram is beside its script ``NAME.py``.
    """
    package = Path(__file__).resolve().parent
    in_package = package / "diagrams"
    return in_package if in_package.is_dir() else package.parents[1] / "diagrams"


def diagram_names() -> list[str]:
    """Names of all diagrams, sorted."""
    return sorted(_scripts())


def diagram_groups() -> dict[str, list[str]]:
    """Names of the diagrams by folder; the published ones in the order of their notebooks."""
    groups: dict[str, list[str]] = {"published": [], "beyond": [], "check_cases": []}
    for name, script in sorted(_scripts().items()):
        groups[script.parent.name].append(name)
    groups["published"].sort(key=lambda name: diagram_notebook(name) or 0)
    return groups


def diagram_notebook(name: str) -> int | None:
    """Number of the published notebook that a diagram's docstring gives as its source, if any."""
    text = ast.get_docstring(ast.parse(find_diagram(name).read_text(encoding="utf-8"))) or ""
    match = re.search(r"^Source: notebook (\d+) of", text, re.MULTILINE)
    return int(match[1]) if match else None


def _scripts() -> dict[str, Path]:
    return {script.stem: script for script in diagram_folder().glob("*/*.py")}


def find_diagram(name: str, also: Iterable[str] = ()) -> Path:
    """The script of a diagram, by its name in the catalogue or its path.

    Parameters
    ----------
    name : str
        name in the catalogue, or path of a script
    also : iterable of str
        other names that the caller accepts, which the error may suggest as well

    Raises
    ------
    ParameterError
        if neither exists; the message names the nearest
    """
    if not isinstance(also, Iterable) or not all(isinstance(n, str) for n in also):
        must_be("also", also, "names")
    also = list(also)
    script = as_path("name", name)
    if script.suffix == ".py" and script.is_file():
        return script
    scripts = _scripts()
    if script.is_file():
        refuse("name", name, f"{name!r} is not a Python script (.py)")
    if name in scripts:
        return scripts[name]
    close = nearest(name, [*map(str, script.parent.glob("*.py")), *sorted(scripts), *also])
    why = f"no {'diagram, study' if also else 'diagram'} or script {name!r}"
    refuse("name", name, why + did_you_mean(close))


def load_diagram(name: str, settings: Mapping[str, Any] | None = None) -> ModuleType:
    """Import a diagram's script, which builds ``sim`` and does not run it.

    Parameters
    ----------
    name : str
        name in the catalogue, or path of a script
    settings : dict, optional
        values that replace the script's own as it builds: ``{"hold.theta_ref": 5.0}`` is the
        parameter of the block that the script assigns to ``hold``, ``{"DURATION": 60.0}`` a
        variable that it assigns at its top level

    Raises
    ------
    ParameterError
        for a diagram, block, parameter or variable that does not exist, naming the nearest, and for
        a setting that would have no effect
    """
    from ._core.wiring import warn_of_wiring
    from .scripts.script import Script

    diagram = Script(find_diagram(name), mapping("settings", settings)).load()
    if hasattr(diagram, "sim"):
        warn_of_wiring(diagram.sim)
    return diagram
