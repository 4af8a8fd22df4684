"""The code context of a model: the imports, parameters and functions that a diagram needs."""

from __future__ import annotations

import ast
import builtins
import copy
import io
import sys
import tokenize
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from textwrap import dedent
from types import ModuleType
from typing import Any, NoReturn
from unittest.mock import patch

from ..errors import DiagramError
from .functions import Functions
from .names import bound, passed, references, root, used
from .script import Script
from .values import PARTS, Unwritable, Values


class Context:
    """The code that the expressions of a diagram need, directly or indirectly.

    It consists of statements of the script. Names whose statements cannot be copied
    are written with their live values instead.

    Parameters
    ----------
    script : Script
        the script
    functions : Functions
        the functions of its source

    Attributes
    ----------
    parts : set of str
        blocks, events and the simulation that functions refer to
    values : Values
        writes live values as expressions
    """

    def __init__(self, script: Script, functions: Functions):
        self.script = script
        self.parts: set[str] = set()
        self.values = Values(script.namespace, functions, self._need)
        self._pins: dict[str, ast.expr] = {}
        self._binders: dict[str, list[ast.stmt]] = {}
        for statement in script.statements:
            for name in (bound([statement]) | self._changed(statement)) - self._part_names():
                self._binders.setdefault(name, []).append(statement)
        self._needed: set[str] = set()
        self._statements: list[ast.stmt] = []
        # PathView provides numpy as np; a seed set through it belongs to the diagram
        self._needed.add("np")
        for statement in self._binders.get("np", ()):
            self._try(partial(self._include, statement))

    @property
    def names(self) -> set[str]:
        """The names that the code binds."""
        return (
            {n for s in self._statements for n in bound([s])} & self._needed
            | self._pins.keys()
            | self.values.made.keys()
        )

    def nodes(self) -> list[ast.AST]:
        """All of the code."""
        return [*self._statements, *self._pins.values(), *self.values.made.values()]

    def admit(self, node: ast.AST) -> None:
        """Add all that an expression or a function needs.

        Raises
        ------
        DiagramError
            if that is not possible; nothing is added
        """
        if isinstance(node, ast.FunctionDef):  # a block's: its decorator is the block class
            node = copy.copy(node)
            node.decorator_list = []

        def need() -> None:
            for name in sorted(used(node)):
                self._need(name, node)

        error = self._try(need)
        if error:
            raise error

    def live(self, value: Any) -> ast.expr:
        """An expression for a live value.

        Raises
        ------
        DiagramError, Unwritable
            if there is none
        """
        found: list[ast.expr] = []
        error = self._try(lambda: found.append(self.values.expression(value)))
        if error:
            raise error
        return found[0]

    def _try(self, action: Callable[[], object]) -> DiagramError | Unwritable | None:
        """Run an action; undo it if it fails."""
        values = self.values
        state: list[Any] = [
            self.parts,
            self._pins,
            self._needed,
            values.made,
            values.parts,
            values.imports,
            values.names,
        ]
        before = [s.copy() for s in state]
        statements = list(self._statements)
        try:
            action()
        except (DiagramError, Unwritable) as error:
            for now, then in zip(state, before, strict=True):
                now.clear()
                now.update(then)
            self._statements[:] = statements
            return error
        return None

    def text(self, renamed: Mapping[str, str], extra: Iterable[str] = ()) -> str:
        """Source of the context, as written, with parts of the diagram under their new names."""
        statements = sorted(self._statements, key=lambda s: (s.lineno, s.col_offset))
        again = {n for s in statements for n in (bound([s]) | self._changed(s))}
        imports = [f"import {m}" for m in sorted(self.values.imports)]
        pieces = [
            *extra,
            *imports,
            *(
                f"{name} = {self.expression(node, renamed)}"
                for name, node in self._pins.items()
                if not _names(node) - {"np"}
            ),
        ]
        end = 0
        for statement in statements:
            text = self._statement(statement, renamed)
            if not text:
                continue
            start = self._first_line(statement)
            separate = pieces and start > end + 1
            pieces.append(("\n" if separate else "") + text)
            end = statement.end_lineno or 0
        late = {n: e for n, e in self._pins.items() if _names(e) - {"np"} or n in again}
        for name, node in {**self.values.made, **late}.items():
            if isinstance(node, ast.FunctionDef):
                pieces.append(
                    "\n" + ast.unparse(ast.fix_missing_locations(_renamed(node, renamed)))
                )
            else:
                pieces.append(f"{name} = {self.expression(node, renamed)}")
        return "\n".join(pieces).lstrip("\n")

    def expression(self, node: ast.expr, renamed: Mapping[str, str]) -> str:
        """Source of an expression as written, in one line."""
        if not hasattr(node, "lineno") or isinstance(node, ast.GeneratorExp):
            return ast.unparse(ast.fix_missing_locations(_renamed(node, renamed)))
        return _one_line(_rewrite(self.script.source, node, renamed))

    def function(self, node: ast.FunctionDef, name: str, renamed: Mapping[str, str]) -> str:
        """Source of a decorated function as a plain one, under another name."""
        plain = _renamed(node, renamed)
        plain.name, plain.decorator_list = name, []
        return ast.unparse(plain)

    def _need(self, name: str, where: ast.AST) -> None:
        if name in self._needed:
            return
        if name.endswith("."):  # a module of an installed package
            module = name[:-1]
            if not _installed(module.partition(".")[0], self.script.path):
                self._beside(module, where)
            return
        self._needed.add(name)
        value = self.script.namespace.get(name, ...)
        if isinstance(value, PARTS):
            self.parts.add(name)
            return
        if name == "__file__":
            self.script.refuse("__file__ has no meaning in PathView", where)
        error = self._try(lambda: self._need_statements(name, value, where))
        if error:
            self._needed.add(name)
            self._pin(name, error)

    def _pin(self, name: str, error: Exception) -> None:
        """Write a name's live value, because its statements cannot be taken."""
        value = self.script.namespace.get(name, ...)
        try:
            if value is ... or isinstance(value, ModuleType):
                raise Unwritable(f"{name!r} is not known")
            node = self.values.expression(value, name)
        except (Unwritable, DiagramError) as reason:
            raise error from reason
        if not (isinstance(node, ast.Name) and node.id == name):
            self._pins[name] = node

    def _need_statements(self, name: str, value: Any, where: ast.AST) -> None:
        if _holds_parts(value):
            self.script.refuse(f"{name!r} holds blocks; PathView's code has no such name", where)
        statements = self._binders.get(name) or self._star_imports(name)
        if not statements and not hasattr(builtins, name) and name != "__name__":
            self.script.refuse(f"{name!r} is not defined at the top level before the run", where)
        for statement in statements:
            if statement not in self._statements:
                self._include(statement)

    def _include(self, statement: ast.stmt) -> None:
        script = self.script
        if any(isinstance(script.namespace.get(n), PARTS) for n in bound([statement])):
            script.refuse(
                "this statement builds a block and a value that the diagram needs; "
                "PathView needs one statement each",
                statement,
            )
        if isinstance(statement, ast.ImportFrom) and statement.level:
            script.refuse("PathView cannot follow a relative import", statement)
        if isinstance(statement, (ast.Import, ast.ImportFrom)):
            modules = (
                [statement.module or ""]
                if isinstance(statement, ast.ImportFrom)
                else [a.name for a in statement.names]
            )
            for module in modules:
                if not _installed(module.partition(".")[0], script.path):
                    self._beside(module, statement)
        self._statements.append(statement)
        for name in sorted(used(statement)):
            self._need(name, statement)

    def _beside(self, module: str, where: ast.AST) -> NoReturn:
        self.script.refuse(
            f"module {module!r} is not installed, it is a file beside the script; "
            "PathView cannot import it",
            where,
        )

    def _part_names(self) -> set[str]:
        return {n for n, v in self.script.namespace.items() if isinstance(v, PARTS)}

    def _changed(self, statement: ast.stmt) -> set[str]:
        """Names whose values a statement may change."""
        if _plots(statement, self.script.namespace):
            return set()
        return {name for name, _ in self.script.changes(statement)} | passed(statement)

    def _star_imports(self, name: str) -> list[ast.stmt]:
        return [
            s
            for s in self.script.statements
            if isinstance(s, ast.ImportFrom)
            and s.names[0].name == "*"
            and not name.startswith("_")
            and hasattr(sys.modules.get(s.module or ""), name)
        ]

    def _statement(self, statement: ast.stmt, renamed: Mapping[str, str]) -> str:
        if isinstance(statement, (ast.Import, ast.ImportFrom)):
            return self._import(statement)
        text = _rewrite(self.script.source, statement, renamed)
        lines = self.script.source.split("\n")
        before = lines[statement.lineno - 1].encode()[: statement.col_offset].decode()
        after = lines[(statement.end_lineno or 0) - 1].encode()[statement.end_col_offset :].decode()
        if before.strip() or after.lstrip()[:1] not in ("", "#"):  # several statements in a line
            return text
        above = lines[self._first_line(statement) - 1 : statement.lineno - 1]
        return "".join(line[len(before) :] + "\n" for line in above) + dedent(before + text) + after

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


def _names(node: ast.AST) -> set[str]:
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}


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
    # a significant comma, as in a one-element tuple, may have been removed
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
    """Source of ``node`` with new names, and with multi-line strings written on one line.

    PathView indents the code before running it, which would change multi-line strings.
    """
    lines = source.encode().splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line))

    def place(n: Any) -> tuple[int, int]:
        return (starts[n.lineno - 1] + n.col_offset, starts[n.end_lineno - 1] + n.end_col_offset)

    edits: dict[tuple[int, int], str] = {}
    docstrings = {
        id(n.body[0].value)
        for n in ast.walk(node)
        if isinstance(n, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef))
        and isinstance(n.body[0], ast.Expr)
    }
    # before Python 3.12 the parts of an f-string have no positions of their own
    in_f_strings = {
        id(n)
        for f in ast.walk(node)
        if isinstance(f, ast.JoinedStr)
        for n in ast.walk(f)
        if n is not f
    }
    for inner in ast.walk(node):
        if id(inner) in in_f_strings:
            continue
        if isinstance(inner, ast.JoinedStr):
            if inner.lineno != inner.end_lineno or any(n.id in renamed for n in references(inner)):
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
