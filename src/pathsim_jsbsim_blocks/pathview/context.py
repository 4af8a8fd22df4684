"""The code context of a model: the imports, parameters and functions that a diagram needs."""

from __future__ import annotations

import ast
import builtins
import copy
import io
import sys
import tokenize
from collections.abc import Iterable, Mapping
from pathlib import Path
from textwrap import dedent
from types import ModuleType
from typing import Any
from unittest.mock import patch

from pathsim import Connection, Simulation
from pathsim.blocks import Block
from pathsim.events._event import Event

from .names import bound, passed, references, root, used
from .script import Script

PARTS = (Block, Event, Connection, Simulation)


class Context:
    """The statements of a script that the given expressions need, directly or not.

    Parameters
    ----------
    script : Script
        the script
    needed_by : iterable of ast.AST
        parameter expressions, decorated functions, the duration

    Attributes
    ----------
    names : set of str
        what the statements bind
    parts : set of str
        blocks, events and the simulation, as far as functions refer to them
    """

    def __init__(self, script: Script, needed_by: Iterable[ast.AST]):
        self.script = script
        self.parts: set[str] = set()
        self._binders: dict[str, list[ast.stmt]] = {}
        for statement in script.statements:
            for name in (bound([statement]) | self._changed(statement)) - self._part_names():
                self._binders.setdefault(name, []).append(statement)
        self._needed: set[str] = set()
        self._statements: list[ast.stmt] = []
        # PathView brings numpy as np; a seed set through it belongs to the diagram
        self._need("np", script.tree)
        for node in needed_by:
            if isinstance(node, ast.FunctionDef):  # a block's: its decorator is the block class
                node = copy.copy(node)
                node.decorator_list = []
            for name in sorted(used(node)):
                self._need(name, node)
        self._statements.sort(key=lambda s: s.lineno)
        self.names = {n for s in self._statements for n in bound([s])} & self._needed

    def text(self, renamed: Mapping[str, str], extra: Iterable[str] = ()) -> str:
        """Source of the context, as written, with parts of the diagram under their new names."""
        pieces: list[str] = list(extra)
        end = 0
        for statement in self._statements:
            text = self._statement(statement, renamed)
            if not text:
                continue
            start = self._first_line(statement)
            separate = pieces and start > end + 1
            pieces.append(("\n" if separate else "") + text)
            end = statement.end_lineno or 0
        return "\n".join(pieces)

    def expression(self, node: ast.expr, renamed: Mapping[str, str]) -> str:
        """Source of an expression as written, in one line."""
        if not hasattr(node, "lineno") or isinstance(node, ast.GeneratorExp):
            return ast.unparse(_renamed(node, renamed))
        return _one_line(_rewrite(self.script.source, node, renamed))

    def function(self, node: ast.FunctionDef, name: str, renamed: Mapping[str, str]) -> str:
        """Source of a decorated function as a plain one, under another name."""
        plain = _renamed(node, renamed)
        plain.name, plain.decorator_list = name, []
        return ast.unparse(plain)

    def bound_before(self, name: str, line: int) -> bool:
        """Whether a statement above a line binds or changes ``name``."""
        return any(s.lineno < line for s in self._binders.get(name, ()))

    def bound_after(self, name: str, line: int) -> ast.stmt | None:
        """The first statement below a line that binds or changes ``name``."""
        return next((s for s in self._binders.get(name, ()) if s.lineno > line), None)

    def _need(self, name: str, where: ast.AST) -> None:
        if name in self._needed:
            return
        self._needed.add(name)
        value = self.script.namespace.get(name)
        if isinstance(value, PARTS):
            self.parts.add(name)
            return
        if _holds_parts(value):
            self.script.refuse(f"{name!r} holds blocks; PathView's code has no such name", where)
        statements = self._binders.get(name) or self._star_imports(name)
        if not statements and not hasattr(builtins, name) and name not in ("np", "__name__"):
            self.script.refuse(
                "__file__ has no meaning in PathView" if name == "__file__" else
                f"{name!r} is not defined at the top level before the run", where)
        for statement in statements:
            if statement not in self._statements:
                self._include(statement)

    def _include(self, statement: ast.stmt) -> None:
        script = self.script
        if any(isinstance(script.namespace.get(n), PARTS) for n in bound([statement])):
            script.refuse("this statement builds a block and a value that the diagram needs; "
                          "PathView wants one statement each", statement)
        if isinstance(statement, ast.ImportFrom) and statement.level:
            script.refuse("PathView cannot follow a relative import", statement)
        if isinstance(statement, (ast.Import, ast.ImportFrom)):
            modules = ([statement.module or ""] if isinstance(statement, ast.ImportFrom)
                       else [a.name for a in statement.names])
            for module in modules:
                if not _installed(module.partition(".")[0], script.path):
                    script.refuse(f"module {module!r} is not installed, it lies beside the script; "
                                  "PathView cannot import it", statement)
        self._statements.append(statement)
        for name in sorted(used(statement)):
            self._need(name, statement)

    def _part_names(self) -> set[str]:
        return {n for n, v in self.script.namespace.items() if isinstance(v, PARTS)}

    def _changed(self, statement: ast.stmt) -> set[str]:
        """Names whose values a statement may change."""
        if _plots(statement, self.script.namespace):
            return set()
        return {name for name, _ in self.script.changes(statement)} | passed(statement)

    def _star_imports(self, name: str) -> list[ast.stmt]:
        return [s for s in self.script.statements
                if isinstance(s, ast.ImportFrom) and s.names[0].name == "*"
                and not name.startswith("_") and hasattr(sys.modules.get(s.module or ""), name)]

    def _statement(self, statement: ast.stmt, renamed: Mapping[str, str]) -> str:
        if isinstance(statement, (ast.Import, ast.ImportFrom)):
            return self._import(statement)
        text = _rewrite(self.script.source, statement, renamed)
        lines = self.script.source.split("\n")
        before = lines[statement.lineno - 1].encode()[:statement.col_offset].decode()
        after = lines[(statement.end_lineno or 0) - 1].encode()[statement.end_col_offset:].decode()
        if before.strip() or after.lstrip()[:1] not in ("", "#"):  # several statements in a line
            return text
        above = lines[self._first_line(statement) - 1:statement.lineno - 1]
        return "".join(line[len(before):] + "\n" for line in above) + dedent(before + text) + after

    def _first_line(self, statement: ast.stmt) -> int:
        """First line of a statement with its decorators and the comments right above it."""
        decorators = getattr(statement, "decorator_list", [])
        line = min([statement.lineno, *(d.lineno for d in decorators)])
        lines = self.script.source.split("\n")
        while line > 1 and lines[line - 2].lstrip().startswith("#"):
            line -= 1
        return line

    def _import(self, statement: ast.Import | ast.ImportFrom) -> str:
        """The part of an import that is needed; numpy as np is there already."""
        names = [a for a in statement.names
                 if a.name == "*" or (a.asname or a.name).partition(".")[0] in self._needed]
        if isinstance(statement, ast.Import):
            names = [a for a in names if (a.name, a.asname) != ("numpy", "np")]
        return ast.unparse(type(statement)(**{**vars(statement), "names": names})) if names else ""


def _holds_parts(value: Any) -> bool:
    if isinstance(value, Mapping):
        value = list(value.values())
    return isinstance(value, (list, tuple, set)) and any(isinstance(v, PARTS) for v in value)


def _plots(statement: ast.stmt, namespace: Mapping[str, Any]) -> bool:
    """A bare call of matplotlib: it changes none of its arguments."""
    if not (isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Call)):
        return False
    owner = namespace.get(root(statement.value.func) or "")
    module = owner.__name__ if isinstance(owner, ModuleType) else type(owner).__module__
    return module.partition(".")[0] == "matplotlib"


def _installed(module: str, script: Path) -> bool:
    """Whether Python finds a module without looking beside the script or in the current folder."""
    beside = {"", str(script.resolve().parent), str(Path.cwd())}
    with patch.object(sys, "path", [p for p in sys.path if p not in beside]):
        return any(finder.find_spec(module, None) for finder in sys.meta_path)


def _one_line(text: str) -> str:
    """An expression without line breaks and comments."""
    if "\n" not in text:
        return text
    out, end = "", (1, 0)
    for token in tokenize.generate_tokens(io.StringIO(f"({text})").readline):
        if token.type in (tokenize.NL, tokenize.COMMENT, tokenize.NEWLINE, tokenize.ENDMARKER):
            continue
        if token.start[0] > end[0]:
            space = "" if out[-1] in "([{" or token.string in ")]}" else " "
            if token.string in ("]", "}"):
                out = out.rstrip(",")
        else:
            space = " " * (token.start[1] - end[1])
        out, end = out + space + token.string, token.end
    # a comma that was not the last of a list may have gone
    tree, same = (ast.parse(t, mode="eval") for t in (f"({text})", out))
    return out[1:-1] if ast.dump(tree) == ast.dump(same) else ast.unparse(tree)


def _renamed(node: Any, renamed: Mapping[str, str]) -> Any:
    node = copy.deepcopy(node)
    for name in list(references(node)):
        name.id = renamed.get(name.id, name.id)
    for inner in ast.walk(node):
        if isinstance(inner, ast.Global):
            inner.names = [renamed.get(n, n) for n in inner.names]
    return node


def _rewrite(source: str, node: ast.AST, renamed: Mapping[str, str]) -> str:
    """Source of ``node`` with new names, and with strings of several lines written in one.

    PathView indents the code before it runs it, which would change such strings.
    """
    lines = source.encode().splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line))

    def place(n: Any) -> tuple[int, int]:
        return (starts[n.lineno - 1] + n.col_offset, starts[n.end_lineno - 1] + n.end_col_offset)

    edits: dict[tuple[int, int], str] = {}
    docstrings = {id(n.body[0].value) for n in ast.walk(node)
                  if isinstance(n, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef))
                  and isinstance(n.body[0], ast.Expr)}
    # before Python 3.12 the parts of an f-string have no places of their own
    in_f_strings = {id(n) for f in ast.walk(node) if isinstance(f, ast.JoinedStr)
                    for n in ast.walk(f) if n is not f}
    for inner in ast.walk(node):
        if id(inner) in in_f_strings:
            continue
        if isinstance(inner, ast.JoinedStr):
            if (inner.lineno != inner.end_lineno
                    or any(n.id in renamed for n in references(inner))):
                edits[place(inner)] = ast.unparse(_renamed(inner, renamed))
        elif isinstance(inner, ast.Constant) and isinstance(inner.value, (str, bytes)):
            if inner.lineno != inner.end_lineno and id(inner) not in docstrings:
                edits[place(inner)] = repr(inner.value)
        elif isinstance(inner, ast.Global):
            edits[place(inner)] = ast.unparse(_renamed(inner, renamed))
    for name in references(node):
        if name.id in renamed and id(name) not in in_f_strings:
            edits[place(name)] = renamed[name.id]
    begin, end = place(node)
    text = b"".join(lines)
    out, at = [], begin
    for (first, last), new in sorted(edits.items(), key=lambda e: (e[0][0], -e[0][1])):
        if first >= at:  # decorators come before
            out += [text[at:first], new.encode()]
            at = last
    return b"".join([*out, text[at:end]]).decode()
