"""Values that a script is built with instead of its own.

The script's source is not evaluated twice, and nothing is changed after the fact: what the script
derives from a value that is set, it derives from the new one.
"""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NoReturn

from pathsim import Connection, Simulation
from pathsim.blocks import Block
from pathsim.events import Event

from .._core.checks import did_you_mean, nearest, refuse
from ..errors import ParameterError
from .names import assignments, bound, own, references

_NAME = re.compile(r"([A-Za-z_]\w*)(?:\.([A-Za-z_]\w*))?")
_NUMBER = (ast.Expression, ast.Constant, ast.UnaryOp, ast.BinOp, ast.operator, ast.unaryop)
_LITERAL = (*_NUMBER, ast.List, ast.Tuple, ast.Dict, ast.expr_context)


class SettingError(ParameterError):
    """A setting that the script has no place for, whatever its value."""


class Text(str):
    """A value as it is typed on the command line; what it replaces tells how to read it."""

    def read(self, name: str, replaced: Any) -> Any:
        """The value: a number, list, ... in Python's notation, such as ``1/120``, or the text."""
        text = str(self)
        try:
            tree = ast.parse(text.strip(), mode="eval")
            # 9**9**9**9 would never end
            if any(not isinstance(n, _LITERAL) or isinstance(n, ast.Pow) for n in ast.walk(tree)):
                raise ValueError
            value = eval(compile(tree, "<setting>", "eval"), {"__builtins__": {}})
        except (SyntaxError, ValueError, TypeError, ArithmeticError, MemoryError, RecursionError):
            value = ...
        if isinstance(replaced, str):
            # "737" is an aircraft
            return value if isinstance(value, (str, dict, list, tuple)) else text
        if value is ...:
            if replaced is None or replaced is inspect.Parameter.empty:
                return text
            why = f"{text!r} is not a Python value such as 3.5, 1/120, True or [1, 2]"
            refuse(name, text, f"cannot set {name!r}: {why}; it replaces {replaced!r}")
        return value


class Settings:
    """Values by name, and where they belong in a script.

    ``"NAME"`` is a variable that the script assigns at its top level, ``"NAME.PARAMETER"`` an
    argument of the call from which it assigns a block (or anything else) to NAME, at any level,
    whether the script gives it or leaves it at its default. A `SettingError` says why the script
    has no place for a setting, naming the nearest.
    """

    def __init__(self, script: str, tree: ast.Module, values: Mapping[str, Any]):
        self._script, self._tree, self._values = script, tree, dict(values)
        top, everywhere = _assigned(own(tree.body)), _assigned(ast.walk(tree))
        self.assigned = dict.fromkeys(name for name, _ in top)
        self._made: dict[str, list[ast.Call]] = {name: [] for name, _ in everywhere}
        for name, made in everywhere:
            self._made[name] += [made] if isinstance(made, ast.Call) else []
        self._waiting = set(values)
        self._parameters: dict[str, list[str]] = {}  # by block
        for name in values:
            if reason := self._misplaced(name):
                self._refuse(name, reason)
            block, _, parameter = name.rpartition(".")
            if block:
                self._parameters.setdefault(block, []).append(parameter)
        # names of variables by the expressions that they are assigned
        self.constants = {value: name for name, value in top if name in values}
        # names of blocks by the calls that make them
        self.calls = {made: name for name in self._parameters for made in self._made[name]}
        # calls with a seed that follows from the values
        self.seeding = {c for c, block in self.calls.items() if "seed" in self._parameters[block]}
        following = _following(self.constants.values(), tree)
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and any(
                k.arg == "seed" and _reads(following, k.value) for k in node.keywords
            ):
                self.seeding.add(node)

    def _refuse(self, name: Any, reason: str) -> NoReturn:
        raise SettingError(
            f"cannot set {name!r}: {reason}", parameter=name, value=self._values[name]
        )

    def _misplaced(self, name: Any) -> str:
        """Why the script has no place for a setting; empty if it has."""
        match = _NAME.fullmatch(name) if isinstance(name, str) else None
        if match is None:
            return "a name is NAME or BLOCK.PARAMETER"
        variable, parameter = match.groups()
        return self._no_parameter(variable, parameter) if parameter else self._no_constant(variable)

    def _no_parameter(self, variable: str, parameter: str) -> str:
        if not self._made.get(variable):
            blocks = [name for name, calls in self._made.items() if calls]
            reason = f"{self._script} assigns no block to {variable!r}"
            if variable in self._made:
                reason = f"{variable!r} is not the result of one call in {self._script}"
            return reason + _nearest_of(variable, blocks)
        for root, names in _changes(self._tree):
            if names[:2] in ([variable, parameter], [variable, ...]):
                return f"{self._script} sets it itself, in line {root.lineno}"
        return ""

    def _no_constant(self, variable: str) -> str:
        if variable not in self.assigned:
            blocks = [
                f"{block}.{variable}"
                for block, calls in self._made.items()
                if any(keyword.arg == variable for call in calls for keyword in call.keywords)
            ]
            reason = f"{self._script} assigns no {variable!r} at its top level"
            return reason + (did_you_mean(blocks) or _nearest_of(variable, self.assigned))
        if not any(isinstance(n.ctx, ast.Load) for n in _uses(variable, references(self._tree))):
            return f"{self._script} never uses it"
        for node in ast.walk(self._tree):
            if isinstance(node, ast.Global) and variable in node.names:
                return f"a function of {self._script} changes it (line {node.lineno})"
        for node in own(self._tree.body):
            if isinstance(node, ast.Assign) and len(node.targets) > 1:
                names_in = (n for t in node.targets for n in ast.walk(t))
                others = {n.id for n in names_in if isinstance(n, ast.Name)}
                if variable in others:
                    names = ", ".join(sorted(others - {variable}))
                    return f"line {node.lineno} of {self._script} gives {names} the same value"
        lines = [n.lineno for n in self._changing(variable)]
        return f"{self._script} changes it in line {min(lines)}" if lines else ""

    def _changing(self, variable: str) -> Iterator[Any]:
        """Where a variable is bound in other ways than by an assignment of its own, or changed."""
        tree = self._tree
        plain = {target for node in ast.walk(tree) for target, _ in assignments(node)}
        for node in own(tree.body):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.alias)):
                if variable in bound([node]):
                    yield node
            elif node not in plain and not isinstance(getattr(node, "ctx", ast.Load()), ast.Load):
                yield from _uses(variable, [node])
        of_module = set(references(tree))
        for root, names in _changes(tree):
            through_module = names[0] in (..., "sys") and names[-1] == variable  # globals()["K"]
            if through_module or (names[0] == variable and root in of_module):
                yield root

    def constant(self, name: str, replaced: Any) -> Any:
        """The value of a variable, instead of the script's."""
        if isinstance(replaced, (Block, Connection, Event, Simulation)):
            kind = type(replaced)
            parameters = _named(inspect.signature(kind))
            example = f", such as {name}.{next(iter(parameters))}" if parameters else ""
            self._refuse(name, f"it is of class {kind.__name__}: set a parameter of it{example}")
        return self._taken(name, replaced)

    def arguments(
        self, variable: str, make: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]
    ) -> tuple[tuple[Any, ...], dict[str, Any]]:
        """The arguments of the call that makes a block, with the values set."""
        given = self._parameters[variable]
        try:
            signature = inspect.signature(make)
        except (TypeError, ValueError):
            self._refuse(f"{variable}.{given[0]}", f"the parameters of {make!r} are not known")
        try:
            bound = signature.bind_partial(*args, **kwargs)
        except TypeError:
            return args, kwargs  # the call itself says what is wrong
        known = _named(signature)
        # a function may pass further keywords on
        further = [n for n, p in signature.parameters.items() if p.kind is p.VAR_KEYWORD]
        passed: dict[str, Any] = bound.arguments.get(further[0], {}) if further else {}
        for parameter in given:
            name = f"{variable}.{parameter}"
            if parameter in known:
                replaced = bound.arguments.get(parameter, known[parameter].default)
                bound.arguments[parameter] = self._taken(name, replaced)
            elif parameter in passed:
                passed[parameter] = self._taken(name, passed[parameter])
            else:
                what = getattr(make, "__name__", repr(make))
                reason = f"{what} has no parameter {parameter!r}"
                self._refuse(name, reason + _nearest_of(parameter, [*known, *passed]))
        return bound.args, bound.kwargs

    def _taken(self, name: str, replaced: Any) -> Any:
        self._waiting.discard(name)
        value = self._values[name]
        return value.read(name, replaced) if isinstance(value, Text) else value

    def refuse_unused(self) -> None:
        """Raise for a setting that the script has not come across."""
        for name in sorted(self._waiting):
            self._refuse(name, f"{self._script} has not come to the line that has it")


def _nearest_of(name: str, names: Iterable[str]) -> str:
    names = list(names)
    close = nearest(name, names)
    return did_you_mean(close) if close or not names else f"; there is {', '.join(names)}"


def _uses(variable: str, nodes: Iterable[ast.AST]) -> Iterator[ast.Name]:
    return (n for n in nodes if isinstance(n, ast.Name) and n.id == variable)


def _changes(tree: ast.AST) -> Iterator[tuple[ast.expr, list[Any]]]:
    """What is assigned by attribute, key or ``setattr``: where it begins, and the names to it.

    ``x.a["b"] = 1`` has the names x, a and b; ``...`` stands for what only a run can tell.
    """
    for node in ast.walk(tree):
        target: Any = node
        names: list[Any] = []
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "setattr":
            target, name, *_ = *node.args, None, None
            names = [getattr(name, "value", ...)]
        elif isinstance(getattr(node, "ctx", ast.Load()), ast.Load):
            continue
        while isinstance(target, (ast.Attribute, ast.Subscript)):
            key = getattr(target, "slice", None)
            names.insert(0, getattr(target, "attr", getattr(key, "value", None)))
            target = target.value
        if target is not None and names:
            yield target, [getattr(target, "id", ...), *names]


def _named(signature: inspect.Signature) -> dict[str, inspect.Parameter]:
    """Parameters that have a name for the caller."""
    return {
        n: p
        for n, p in signature.parameters.items()
        if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)
    }


def _assigned(nodes: Iterable[ast.AST]) -> list[tuple[str, ast.expr]]:
    """Variables, and what is assigned to them."""
    return [(target.id, value) for node in nodes for target, value in assignments(node)]


def _following(names: Iterable[str], tree: ast.AST) -> set[str]:
    """The variables whose values follow from those of ``names``, these included."""
    found, before = set(names), None
    while found != before:
        before = set(found)
        for node in ast.walk(tree):
            value = getattr(node, "value", None) or getattr(node, "iter", None)
            targets = getattr(node, "targets", None) or [getattr(node, "target", None)]
            if isinstance(value, ast.AST) and _reads(before, value):
                found |= {
                    n.id for t in targets if t for n in ast.walk(t) if isinstance(n, ast.Name)
                }
    return found


def _reads(names: set[str], expression: ast.AST) -> bool:
    return any(isinstance(n, ast.Name) and n.id in names for n in ast.walk(expression))
