"""A model's script, by PathView's own generator."""

from __future__ import annotations

import ast
import builtins
import json
import re
import sys
from pathlib import Path
from typing import Any

from ..errors import DiagramError
from .buses import BUSES
from .check import NUMBERS, ModelCheck, compiling, complete
from .diagram import NOTE
from .shape import Json, with_parts
from .variables import printable, without_clashes


def checked(content: Json, registry: Json, path: Path) -> Json:
    """A model from `pvm`, complete and with names that do not clash, after a full check."""
    content = complete(content)
    check = ModelCheck(content, registry, path)
    check.all()
    builtin_names = check.used & set(dir(builtins))
    return without_clashes(content, check.assigned | builtin_names, check.called_later, path)


def to_python(content: Json, registry: Json, path: Path) -> str:
    """The script of a `checked` model: the converter drops unknown parts."""
    from pathview.converter import generate_python

    try:
        code = generate_python(_spliceable(content), registry, source_name=_in_docstring(path.name))
        with compiling():
            ast.parse(code)
    except (RecursionError, MemoryError) as error:
        raise DiagramError("too deep or too large for a script", path=path) from error
    return _with_names_of_ports(_finished(code, content, path), registry)


def _with_names_of_ports(code: str, registry: Json) -> str:
    """PathView's script with named ports instead of numbers, if a block's class names several."""
    classes = {
        ast.unparse(n.targets[0]): ast.unparse(n.value.func)
        for n in ast.parse(code).body
        if isinstance(n, ast.Assign) and isinstance(n.value, ast.Call)
    }

    def named(wires: re.Match[str]) -> str:
        texts: list[str] = []
        for variable, port in re.findall(r"(\w+)\[(\d+)\]", wires[2]):
            entry = registry["blocks"].get(classes.get(variable, ""))
            module = sys.modules.get(entry["importPath"]) if entry else None
            kind = getattr(module, classes.get(variable, ""), None)
            labels = getattr(kind, f"{'input' if texts else 'output'}_port_labels", None) or {}
            names = [n for n, i in labels.items() if len(labels) > 1 and i == int(port)]
            texts.append(f"{variable}[{json.dumps(names[-1]) if names else port}]")
        return f"{wires[1]}{', '.join(texts)}),"

    return re.sub(r"(?m)^(\s+Connection\()((?:\w+\[\d+\](?:, )?)+)\),$", named, code)


def _finished(code: str, content: Json, path: Path) -> str:
    """PathView's script with the note of a script's docstring, its ``log=``, and plots by unit."""
    notes = content["graph"].get("annotations") or []
    note = next((str(n.get("content")) for n in notes if n.get("id") == NOTE), "")
    if note:
        docstring = ast.parse(code).body[0]
        lines = code.split("\n")[docstring.end_lineno or 0 :]
        text = "\n".join(map(printable, note.split("\n")))
        text = text.replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
        text = re.sub('"$', r'\\"', text)
        head = [f'"""{text}"""', "", f"# converted from {printable(path.name)}"]
        code = "\n".join([*head, *lines])
    # the last match: the model's own code, which comes first, may contain the same text
    definitions, start, tail = code.rpartition("\nsim = Simulation(\n")
    if content["simulationSettings"].get("log") is False:
        tail = tail.replace("\n)\n", "\n    log=False,\n)\n", 1)
    kinds = {node["type"] for node in content["graph"]["nodes"]}
    plots = _SPECTRA if "Spectrum" in kinds else _SCOPES if "Scope" in kinds else _PLOTS
    return definitions + start + tail.replace(_PLOTS, plots)


_PLOTS = """\
    sim.plot()
    plt.show()
"""
_SCOPES = """\
    from pathlib import Path

    from pathsim_jsbsim_blocks.plots import show, time_histories

    scopes = [block for block in blocks if isinstance(block, Scope)]
    show(time_histories(*scopes), Path(__file__).stem)
"""
_SPECTRA = """\
    from pathlib import Path

    from pathsim_jsbsim_blocks.plots import show

    sim.plot()
    for figure in [plt.figure(number) for number in plt.get_fignums()]:
        show(figure, f"{Path(__file__).stem}_{figure.number}")
"""


def _in_docstring(name: str) -> str:
    return printable(name).replace("\\", "\\\\").replace('"', '\\"')


def _spliceable(content: Json) -> Json:
    """A model whose names and expressions keep their meaning inside PathView's script.

    PathView writes names into comments, where a line separator would end the comment, and
    parameters between commas, where a comment would hide what follows.
    """

    def part(old: Json) -> Json:
        if old["type"] in BUSES:
            return old
        params = {k: v if k.startswith("_") else _argument(v) for k, v in old["params"].items()}
        return {**old, "name": printable(old["name"]), "params": params}

    settings = content["simulationSettings"]
    numbers = {name: _argument(settings[name]) for name in NUMBERS if name in settings}
    return {**with_parts(content, part), "simulationSettings": {**settings, **numbers}}


def _argument(value: Any) -> Any:
    """An expression, in parentheses if needed between other arguments of a call."""
    if not isinstance(value, str) or not value.strip():
        return value
    value = value.strip()
    bracket = f"({value}\n)"
    try:
        with compiling():
            sure, plain = (ast.dump(ast.parse(f"f(x={v}, y=0)")) for v in (bracket, value))
    except (SyntaxError, ValueError):
        return bracket
    return value if sure == plain else bracket
