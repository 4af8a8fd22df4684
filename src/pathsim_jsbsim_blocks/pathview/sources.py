"""Functions and classes of a script, found in its source and written with other names."""

from __future__ import annotations

import ast
import contextlib
import linecache
import re
import types
from collections.abc import Mapping
from functools import lru_cache
from textwrap import dedent
from typing import Any, NamedTuple

_DEFINITIONS = (ast.FunctionDef, ast.Lambda, ast.ClassDef)


class SourceNode(NamedTuple):
    """A part of a file: its node, and the file's text."""

    node: Any
    source: str


@lru_cache
def _parsed(path: str, source: str) -> ast.Module:
    return ast.parse(source, path)


def _definitions(path: str) -> tuple[str, list[Any]]:
    linecache.checkcache(path)
    source = "".join(linecache.getlines(path))
    return source, [n for n in ast.walk(_parsed(path, source)) if isinstance(n, _DEFINITIONS)]


def _the_one(source: str, definitions: list[Any]) -> SourceNode | None:
    """The definition; None if there are several that differ."""
    unique = len({ast.dump(node) for node in definitions}) == 1
    return SourceNode(definitions[0], source) if unique else None


def of_function(function: types.FunctionType) -> SourceNode | None:
    """The definition of a function."""
    code = function.__code__
    span = _span(code)

    def fits(node: Any) -> bool:
        if isinstance(node, ast.Lambda) and span:
            body = node.body
            return span == (body.lineno, body.col_offset, body.end_lineno, body.end_col_offset)
        return getattr(node, "name", "<lambda>") == code.co_name

    source, definitions = _definitions(code.co_filename)
    line = code.co_firstlineno
    return _the_one(source, [n for n in definitions if _first_line(n) == line and fits(n)])


def of_class(name: str, path: str, lines: list[int]) -> SourceNode | None:
    """The definition of a class; ``lines`` are those of its methods, to tell namesakes apart."""
    source, definitions = _definitions(path)
    candidates = [n for n in definitions if isinstance(n, ast.ClassDef) and n.name == name]
    hits = [n for n in candidates if any(n.lineno <= line <= (n.end_lineno or 0) for line in lines)]
    return _the_one(source, hits or candidates)


def _span(code: types.CodeType) -> tuple[int, ...]:
    """Start and end of the body of a lambda; empty before Python 3.11."""
    places = [p for p in getattr(code, "co_positions", list)() if p[2] != p[3] or p[0] != p[1]]
    if code.co_name != "<lambda>" or not places:
        return ()
    return (*min(p[::2] for p in places), *max(p[1::2] for p in places))


def _first_line(node: Any) -> int:
    decorators = getattr(node, "decorator_list", ())
    return min(n.lineno for n in (node, *decorators))


def first_line(part: SourceNode) -> int:
    """First line of a statement with its decorators and the comments right above it."""
    lines, line = part.source.split("\n"), _first_line(part.node)
    while line > 1 and lines[line - 2].lstrip().startswith("#"):
        line -= 1
    return line


def with_comments(part: SourceNode, text: str) -> str:
    """The text of a statement with the comments above and beside it."""
    lines, node = part.source.split("\n"), part.node
    head = lines[node.lineno - 1].encode()[: node.col_offset].decode()
    tail = lines[node.end_lineno - 1].encode()[node.end_col_offset :].decode()
    if head.strip() or tail.lstrip()[:1] not in ("", "#"):  # several statements in a line
        return text
    comments = lines[first_line(part) - 1 : _first_line(node) - 1]
    return "".join(f"{line.strip()}\n" for line in comments) + text + tail.rstrip()


def text_of(part: SourceNode, new: Mapping[ast.AST, str] = {}, decorated: bool = False) -> str:
    """The source of a node, with some nodes in it replaced by text.

    It is as written, unless a string in it spans lines: PathView indents the code before running
    it, which would change that string.
    """
    node, source = part
    bare: dict[str, Any] = (
        {} if decorated or isinstance(node, ast.Lambda) else {"decorator_list": []}
    )
    if _spans_lines(node) or any(_in_formatted(node, inner) for inner in new):
        return ast.unparse(ast.fix_missing_locations(_rebuilt(node, new, bare)))
    raw, starts = source.encode(), [0]
    for line in raw.split(b"\n"):
        starts.append(starts[-1] + len(line) + 1)

    def place(line: int, column: int) -> int:
        return starts[line - 1] + column

    begin = place(node.lineno, node.col_offset)
    if decorated and node.decorator_list:
        begin = place(_first_line(node), node.col_offset)
    pieces, at = [], begin
    for inner in sorted(new, key=lambda n: (n.lineno, n.col_offset)):  # type: ignore[attr-defined]
        where: Any = inner
        pieces += [raw[at : place(where.lineno, where.col_offset)], new[inner].encode()]
        at = place(where.end_lineno, where.end_col_offset)
    text = b"".join([*pieces, raw[at : place(node.end_lineno, node.end_col_offset)]]).decode()
    return dedent(" " * node.col_offset + text) if isinstance(node, ast.stmt) else text


def one_line(text: str) -> str:
    """An expression without line breaks and comments, otherwise as written if that is valid."""
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


def _rebuilt(value: Any, new: Mapping[ast.AST, str], instead: Mapping[str, Any] = {}) -> Any:
    """A copy of a syntax tree with some nodes replaced by text."""
    if isinstance(value, list):
        return [_rebuilt(item, new) for item in value]
    if not isinstance(value, ast.AST):
        return value
    if value in new:
        replacement: Any = ast.parse(new[value]).body[0]
        return replacement if isinstance(value, ast.stmt) else replacement.value
    fields = {k: _rebuilt(v, new) for k, v in ast.iter_fields(value)}
    return type(value)(**{**fields, **instead})


def _spans_lines(node: ast.AST) -> bool:
    """Whether a string in a node, other than a docstring, spans lines."""
    definitions = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    docstrings = {
        id(n.body[0].value)
        for n in ast.walk(node)
        if isinstance(n, definitions) and isinstance(n.body[0], ast.Expr)
    }
    return any(
        n.lineno != n.end_lineno and id(n) not in docstrings
        for n in ast.walk(node)
        if isinstance(n, ast.JoinedStr)
        or (isinstance(n, ast.Constant) and isinstance(n.value, (str, bytes)))
    )


def _in_formatted(node: ast.AST, inner: ast.AST) -> bool:
    """Whether a node is in an f-string: before Python 3.12 its position is wrong there."""
    texts = (n for n in ast.walk(node) if isinstance(n, ast.JoinedStr))
    return any(n is inner for text in texts for n in ast.walk(text))
