"""The code of a model: the imports, parameters and functions that a diagram needs."""

from __future__ import annotations

import ast
import contextlib
import copy
import re
import sys
from collections.abc import Collection, Iterable, Mapping
from textwrap import dedent
from typing import Any

from ..scripts.first_run import FirstRun
from ..scripts.names import bound, own, references, root, used
from .plain import PARTS, text_of

# what sees the names of the script, of which the code has only those that it needs
_MEANINGLESS = {"__file__", "__name__", "globals", "eval", "exec"}
_RANDOM = ("np.random.", "numpy.random.", "random.")


class Code:
    """The statements of a script that the expressions of its diagram need.

    These are the statements, as written, that bind a needed name or stand alone with it
    (``table.append(1)``), and neither build nor use a part of the diagram. ``without`` are lines of
    statements that PathView cannot execute.
    """

    def __init__(self, script: FirstRun, without: Collection[int] = ()):
        self.script = script
        self.parts: set[str] = set()  # parts of the diagram to which functions refer
        self.made: dict[str, ast.stmt] = {}  # functions and values to add, by their name
        self.places: dict[int, int] = {}  # lines of the script by lines of the text
        usable = [s for s in script.statements if not self._has_parts(s)]
        self._of_parts = bound(s for s in script.statements if s not in usable)
        self._statements = [s for s in usable if s.lineno not in without]
        self._touched = {s: self._touches(s) for s in self._statements}
        self._needed: set[str] = {"np"}  # which PathView provides; a seed belongs to the diagram
        self._kept: set[ast.stmt] = set()

    def need(self, node: ast.AST) -> None:
        """Add all that an expression or a function needs; refuse what PathView lacks."""
        todo = used(node)
        while todo:
            for name in sorted(todo - self._needed):
                self._check(name, node)
            self._needed |= todo
            new = {s for s in self._statements if self._touched[s] & self._needed} - self._kept
            self._kept |= new
            todo = {name for s in new for name in used(s)}

    @property
    def names(self) -> set[str]:
        """The names that the code binds."""
        inner = (n for s in self._kept for n in ast.walk(s))
        declared = {n for g in inner if isinstance(g, ast.Global) for n in g.names}
        return self._needed & (declared | bound(self._kept)) | self.made.keys()

    def values(self) -> dict[str, str]:
        """What the script has under the names that the code needs, as texts."""
        found = {}
        for name in sorted(self._needed & self.script.namespace.keys()):
            value = self.script.namespace[name]
            if not isinstance(value, PARTS):
                # the text of a function does not tell one from another
                unlike = name in self._of_parts and callable(value)
                found[name] = "made from blocks" if unlike else text_of(value)
        return found

    def nodes(self) -> list[ast.AST]:
        """All of the code."""
        return [*self._kept, *self.made.values()]

    def _check(self, name: str, where: ast.AST) -> None:
        value = self.script.namespace.get(name)
        if isinstance(value, PARTS):
            self.parts.add(name)
        elif _is_part(value):
            self.script.refuse(f"{name!r} holds blocks; PathView's code has no such name", where)
        elif name in _MEANINGLESS:
            self.script.refuse(f"{name} has no meaning in PathView", where)

    def _has_parts(self, statement: ast.stmt) -> bool:
        """Whether a statement builds or changes parts of the diagram."""
        names = set(bound([statement]))
        if not isinstance(statement, (ast.FunctionDef, ast.ClassDef, ast.Import, ast.ImportFrom)):
            names |= used(statement)
        return any(_is_part(self.script.namespace.get(n)) for n in names)

    def _touches(self, statement: ast.stmt) -> set[str]:
        """Names that a statement binds, or may change where it stands alone."""
        names = set(bound([statement]))
        if isinstance(statement, ast.ImportFrom) and statement.names[0].name == "*":
            module = vars(sys.modules.get(statement.module or "", ast))
            return {n for n in module if not n.startswith("_")} - {"np"}
        for node in own([statement]):
            if isinstance(node, ast.Expr):
                for call in (n for n in ast.walk(node) if isinstance(n, ast.Call)):
                    names |= self._changed_by(call)
            elif isinstance(node, (ast.Attribute, ast.Subscript)) and not isinstance(
                node.ctx, ast.Load
            ):
                names.add(root(node) or "")
        return names

    def _changed_by(self, call: ast.Call) -> set[str]:
        """Names that a call that stands alone may change."""
        function, name = ast.unparse(call.func), root(call.func)
        if function.startswith(_RANDOM):
            return {"np"}
        owner = self.script.namespace.get(name or "")
        module = getattr(owner, "__name__", "") or type(owner).__module__
        if name == "print" or module.partition(".")[0] == "matplotlib":
            return set()
        functions = {s.name: s for s in self.script.statements if isinstance(s, ast.FunctionDef)}
        names, todo = used(call), [function]
        while todo:
            inside = functions.pop(todo.pop(), None)
            if inside is not None:
                declared = (n.names for n in ast.walk(inside) if isinstance(n, ast.Global))
                names |= used(inside).union(*declared)
                todo += used(inside)
        return names - {"np"}

    def text(self, renamed: Mapping[str, str], extra: Iterable[str] = ()) -> str:
        """Source of the context, as written, with parts of the diagram under their new names."""
        statements = sorted(self._kept, key=lambda s: (s.lineno, s.col_offset))
        pieces = [*extra]
        end = 0
        for statement in statements:
            text = self._statement(statement, renamed)
            if not text:
                continue
            start = self._first_line(statement)
            separate = pieces and start > end + 1
            pieces.append(("\n" if separate else "") + text)
            for line in range(len(text.split("\n"))):
                self.places["\n".join(pieces).count("\n") - line + 1] = statement.lineno
            end = statement.end_lineno or 0
        for made in self.made.values():
            pieces.append("\n" + ast.unparse(_renamed(made, renamed)))
        return "\n".join(pieces).lstrip("\n")

    def expression(self, node: ast.expr, renamed: Mapping[str, str]) -> str:
        """Source of an expression as written, in one line."""
        if not hasattr(node, "lineno") or isinstance(node, ast.GeneratorExp):
            return ast.unparse(_renamed(node, renamed))
        return _one_line(self._written(node, renamed) or ast.unparse(_renamed(node, renamed)))

    def _statement(self, statement: ast.stmt, renamed: Mapping[str, str]) -> str:
        if isinstance(statement, (ast.Import, ast.ImportFrom)):
            return self._import(statement)
        lines = self.script.source.split("\n")
        above = lines[self._first_line(statement) - 1 : statement.lineno - 1]
        text = self._written(statement, renamed)
        if not text:
            comments = [line.strip() for line in above if line.lstrip().startswith("#")]
            return "\n".join([*comments, ast.unparse(_renamed(statement, renamed))])
        before = lines[statement.lineno - 1].encode()[: statement.col_offset].decode()
        after = lines[(statement.end_lineno or 0) - 1].encode()[statement.end_col_offset :].decode()
        if before.strip() or after.lstrip()[:1] not in ("", "#"):  # several statements in a line
            return text
        return "".join(line[len(before) :] + "\n" for line in above) + dedent(before + text) + after

    def _written(self, node: ast.AST, renamed: Mapping[str, str]) -> str:
        """Source of a node as written; empty where names change, or a text spans lines.

        PathView indents the code before running it, which would change such a text.
        """
        docstrings = {
            id(n.body[0].value)
            for n in ast.walk(node)
            if isinstance(n, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef))
            and isinstance(n.body[0], ast.Expr)
        }
        texts = (
            n
            for n in ast.walk(node)
            if isinstance(n, ast.JoinedStr)
            or (isinstance(n, ast.Constant) and isinstance(n.value, (str, bytes)))
        )
        if any(n.id in renamed for n in references(node)) or any(
            n.lineno != n.end_lineno and id(n) not in docstrings for n in texts
        ):
            return ""
        return ast.get_source_segment(self.script.source, node) or ""

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
        names = [
            a
            for a in statement.names
            if a.name == "*" or (a.asname or a.name).partition(".")[0] in self._needed
        ]
        if isinstance(statement, ast.Import):
            names = [a for a in names if (a.name, a.asname) != ("numpy", "np")]
        return ast.unparse(type(statement)(**{**vars(statement), "names": names})) if names else ""


def _is_part(value: Any) -> bool:
    """Whether a value is a part of a diagram, or a collection that holds one."""
    inside = value.values() if isinstance(value, Mapping) else value
    collection = isinstance(value, (Mapping, list, tuple, set))
    return isinstance(value, PARTS) or (collection and any(isinstance(v, PARTS) for v in inside))


def _one_line(text: str) -> str:
    """An expression without line breaks and comments, otherwise as written where that will do."""
    if "\n" not in text:
        return text
    out = re.sub(r"[ \t]*#.*", "", text)
    out = re.sub(r"([\[({])\s*\n\s*", r"\1", out)
    out = re.sub(r",?\s*\n\s*([\]}])", r"\1", out)
    out = re.sub(r"\s*\n\s*", " ", out).replace(" )", ")")
    meant = ast.parse(f"({text}\n)", mode="eval")
    with contextlib.suppress(SyntaxError):
        if ast.dump(ast.parse(out, mode="eval")) == ast.dump(meant):
            return out
    return ast.unparse(meant)


def _renamed(node: Any, renamed: Mapping[str, str]) -> Any:
    node = copy.deepcopy(node)
    for name in list(references(node)):
        name.id = renamed.get(name.id, name.id)
    for inner in ast.walk(node):
        if isinstance(inner, ast.Global):
            inner.names = [renamed.get(n, n) for n in inner.names]
    return ast.fix_missing_locations(node)
