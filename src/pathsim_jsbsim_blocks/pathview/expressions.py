"""Select the expressions of a script that its model keeps: plain ones that give live values."""

from __future__ import annotations

import ast
import cmath
import dataclasses
import math
import types
from collections.abc import Mapping
from typing import Any

import numpy as np
from pathsim.blocks import Block

from ..scripts.names import assignments, bound
from .first_run import FirstRun

_PLAIN = (
    ast.Constant, ast.Name, ast.Attribute, ast.Call, ast.keyword, ast.Starred, ast.Subscript,
    ast.Slice, ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp, ast.List, ast.Tuple,
    ast.Dict, ast.Set, ast.JoinedStr, ast.FormattedValue, ast.operator, ast.unaryop, ast.boolop,
    ast.cmpop, ast.expr_context,
)  # fmt: skip
_BUILTINS = (abs, bool, complex, dict, float, int, len, list, max, min, range, round, set, sorted,
             str, sum, tuple)  # fmt: skip
_BUILTIN_NAMES: dict[str, Any] = {function.__name__: function for function in _BUILTINS}
# functions of numpy that read files: the model may run elsewhere, so it gets their results
_READERS = ("load", "loadtxt", "genfromtxt", "fromfile", "fromregex", "memmap")
_DATA = (bool, int, float, complex, str, bytes, type(None), np.generic)


def same(a: Any, b: Any) -> bool:
    """Whether two values are the same to the last bit; NaN is equal to NaN."""
    if a is b:
        return True
    if type(a) is not type(b):
        return False
    if type(a) is np.ndarray:
        if a.dtype != b.dtype or a.shape != b.shape:
            return False
        return a.tobytes() == b.tobytes() if a.dtype != object else same(a.tolist(), b.tolist())
    if isinstance(a, (list, tuple)):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, Mapping):
        return list(a) == list(b) and all(same(a[k], b[k]) for k in a)
    if dataclasses.is_dataclass(a):
        return same(vars(a), vars(b))
    if isinstance(a, (float, complex, np.generic)):
        return repr(a) == repr(b)
    return isinstance(a, (int, str, bytes, set, range)) and a == b


def is_data(value: Any) -> bool:
    """Whether a value is a number, a text, an array or a collection of these."""
    if isinstance(value, dict):
        return type(value) is dict and is_data([*value, *value.values()])
    if isinstance(value, (list, tuple, set)):
        return type(value) in (list, tuple, set) and all(map(is_data, value))
    return isinstance(value, (*_DATA, range)) or (
        type(value) is np.ndarray and value.dtype != object
    )


class Expressions:
    """Tells which expressions and assignments of a script may be used in its model."""

    def __init__(self, script: FirstRun):
        self._script = script
        self._statements: dict[str, ast.stmt] = {}
        for statement in script.statements:
            for name in bound([statement]):
                self._statements[name] = statement

    def gives(self, node: ast.expr, value: Any) -> bool:
        """Whether an expression is plain, and gives a value."""
        if not all(map(self._is_plain, ast.walk(node))):
            return False
        try:
            return same(self._value(node), value)
        except Exception:
            return False

    def assigned(self, name: str) -> tuple[ast.stmt, ast.expr] | None:
        """The assignment that gives a name its live value, and the expression, if it is plain."""
        statement = self._statements.get(name)
        live = self._script.namespace.get(name)
        # repeated for each name, ``a = b = x`` would build two values
        if statement is None or len(getattr(statement, "targets", "1")) > 1:
            return None
        for target, value in assignments(statement):
            if target.id == name and self._is_value(live) and self.gives(value, live):
                return statement, value
        return None

    def imported(self, name: str) -> str:
        """The import that gives a name its live value, without other names."""
        statement = self._statements.get(name)
        if not isinstance(statement, (ast.Import, ast.ImportFrom)):
            return ""
        module = getattr(statement, "module", "") or ""
        for alias in statement.names:
            is_local = self._script.is_beside(module or alias.name)
            if name == (alias.asname or alias.name.partition(".")[0]) and not is_local:
                return ast.unparse(type(statement)(**{**vars(statement), "names": [alias]}))
        return ""

    def line(self, name: str) -> float:
        """The line in which the script binds a name; infinite if it does not."""
        statement = self._statements.get(name)
        return math.inf if statement is None else statement.lineno

    def _is_plain(self, node: ast.AST) -> bool:
        if isinstance(node, ast.Call):
            return self._is_pure(node.func)
        if isinstance(node, ast.Attribute):
            owner = self._resolved(node.value)
            if isinstance(owner, types.ModuleType):
                return self._is_value(self._resolved(node))
            return owner is None or isinstance(owner, (*_DATA, np.ndarray))
        if isinstance(node, ast.Name):
            return self._is_value(self._resolved(node))
        return isinstance(node, _PLAIN)

    def _is_value(self, value: Any) -> bool:
        if isinstance(value, (types.ModuleType, type)) or _is_mathematical(value):
            return True
        return is_data(value) or (dataclasses.is_dataclass(value) and is_data(vars(value)))

    def _is_pure(self, function: ast.expr) -> bool:
        value = self._resolved(function)
        if value is None and isinstance(function, ast.Attribute):  # a method of an array
            return all(map(self._is_plain, ast.walk(function.value)))
        is_record = isinstance(value, type) and dataclasses.is_dataclass(value)
        return _is_mathematical(value) or (is_record and not issubclass(value, Block))

    def _resolved(self, node: ast.AST) -> Any:
        """The object to which a name or an attribute refers; None for other expressions."""
        if isinstance(node, ast.Attribute):
            return getattr(self._resolved(node.value), node.attr, None)
        if not isinstance(node, ast.Name):
            return None
        return self._script.namespace.get(node.id, _BUILTIN_NAMES.get(node.id))

    def _value(self, node: ast.expr) -> Any:
        code = compile(ast.Expression(node), "expression", "eval", dont_inherit=True)
        return eval(code, dict(self._script.namespace))


def _is_mathematical(value: Any) -> bool:
    """Whether a function computes without side effects."""
    if isinstance(value, np.ufunc) or any(value is f for f in _BUILTINS):
        return True
    module, name = getattr(value, "__module__", None) or "", getattr(value, "__name__", "")
    of_numpy = module.partition(".")[0] == "numpy" and getattr(np, name, None) is value
    return callable(value) and (
        module in (math.__name__, cmath.__name__) or (of_numpy and name not in _READERS)
    )
