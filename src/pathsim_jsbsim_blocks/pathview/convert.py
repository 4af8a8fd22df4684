"""Turn a PathView model into a Python script."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from .._core.files import as_path
from ..errors import DiagramError
from .generate import checked, to_python
from .pvm import read, write
from .toolboxes import registry_for


def convert_model(
    path: str | Path,
    out: str | Path | None = None,
    toolboxes: Sequence[str] = (),
    trust_toolboxes: Sequence[str] = (),
) -> Path:
    """Write a PathView model as a Python script.

    No code of the model is executed. Toolboxes are imported to find their blocks: those of
    PathSim and those given here, but no others that the model requires.

    Parameters
    ----------
    path : str or Path
        a model file, .pvm or .json
    out : str or Path, optional
        the script; default is the model's name with .py, which must not exist yet
    toolboxes : sequence of str
        toolboxes that the model does not name itself, ``PACKAGE`` or ``PACKAGE:IMPORT.PATH``;
        this package, pathsim-flight and the model's ``requiredToolboxes`` are always included
    trust_toolboxes : sequence of str
        further toolboxes, not PathSim's own, that may be imported if the model requires them

    Returns
    -------
    Path
        the script

    Raises
    ------
    DiagramError
        if the file is not a model, requires a toolbox that is not trusted, has unknown blocks or
        events, broken connections, ambiguous ids or parameters that are not Python
        expressions, a name in its code clashes with a block, or the script cannot be written
    ParameterError
        if a toolbox cannot be imported
    """
    path = as_path("path", path)
    content = read(path)
    if out is None:
        out = path.with_suffix(".py")
        if out.exists():  # often the script from which the model was exported
            raise DiagramError(
                "exists and may be the model's original; name the script to write (-o FILE.py)",
                path=out,
            )
    out = as_path("out", out)
    registry = registry_for(content, path, toolboxes, trust_toolboxes)
    code = to_python(checked(content, registry, path), registry, path)
    write(out, code)
    return out
