"""The script of a model that is to run: checked as a whole, and trusted."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from .generate import to_python
from .shape import Json
from .toolboxes import registry_for
from .trusted_models import digest, remember, require_trust


def trusted_code(
    content: Json, path: Path, trust: bool = False, trust_toolboxes: Sequence[str] = ()
) -> str:
    """A model's script; none of its code is executed here.

    Parameters
    ----------
    content : dict
        the model as `pvm.read` gives it: what is checked is what runs
    path : Path
        its file, for messages
    trust : bool
        trust it now and later
    trust_toolboxes : sequence of str
        further toolboxes that may be imported if the model requires them

    Raises
    ------
    DiagramError
        if the model has unknown parts, or code that is not Python
    UntrustedModelError
        if the model is from another source and not trusted
    """
    code = to_python(content, registry_for(content, path, trust_toolboxes=trust_toolboxes), path)
    if trust:
        remember(digest(content))
    require_trust(content, path)
    return code
