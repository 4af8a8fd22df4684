"""Laws described by operations on signals, and the plain functions that fly them.

A law is written once, as arithmetic and the named operations here, with no ``if`` on a signal. On
floats it is computed as it stands. On a `Signal` it gives the expression, of which `compiled` makes
a flat Python function: without calls, attributes or unused operations it takes a fraction of the
time.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import lru_cache
from typing import Any, NamedTuple, TypeVar

Value = TypeVar("Value")


class Signal:
    """A value of a law: an operation, and what it is applied to."""

    __slots__ = ("operands", "operation")

    def __init__(self, operation: str, *operands: Any):
        self.operation = operation
        self.operands = operands

    def __bool__(self) -> bool:
        raise TypeError("a law decides by select and limit, not by the truth of a signal")


# each operation as Python writes it
_FORMS = {
    "add": "{} + {}",
    "sub": "{} - {}",
    "mul": "{} * {}",
    "truediv": "{} / {}",
    "mod": "{} % {}",
    "pow": "{} ** {}",
    "lt": "{} < {}",
    "le": "{} <= {}",
    "gt": "{} > {}",
    "ge": "{} >= {}",
    "eq": "{} == {}",
    "ne": "{} != {}",
    "and": "{} and {}",
    "or": "{} or {}",
    "neg": "-{}",
    "abs": "abs({})",
    "select": "{1} if {0} else {2}",
    "limit": "{2} if {0} > {2} else {1} if {0} < {1} else {0}",
    "smaller": "{1} if {1} < {0} else {0}",
    "larger": "{1} if {1} > {0} else {0}",
}


def _operator(name: str, swapped: bool) -> Callable[..., Signal]:
    def apply(*operands: Any) -> Signal:
        return Signal(name, *(operands[::-1] if swapped else operands))

    return apply


for _name in list(_FORMS)[:16]:
    setattr(Signal, f"__{_name}__", _operator(_name, False))
    setattr(Signal, f"__r{_name}__", _operator(_name, True))


def _any(*values: Any) -> bool:
    return any(isinstance(x, Signal) for x in values)


def select(condition: Any, yes: Value, no: Value) -> Value:
    """``yes`` where the condition holds, otherwise ``no``."""
    if not isinstance(condition, Signal):
        return yes if condition else no
    if isinstance(yes, tuple) and isinstance(no, tuple):
        return _like(yes, [select(condition, a, b) for a, b in zip(yes, no, strict=True)])
    same = yes is no or (not _any(yes, no) and repr(yes) == repr(no))
    return yes if same else Signal("select", condition, yes, no)  # type: ignore[return-value]


def limit(x: Any, low: Any, high: Any) -> Any:
    """``x`` within limits that do not cross."""
    if _any(x, low, high):
        return Signal("limit", x, low, high)
    return high if x > high else low if x < low else x


def smaller(a: Any, b: Any) -> Any:
    """The smaller of two values."""
    return Signal("smaller", a, b) if _any(a, b) else min(a, b)


def larger(a: Any, b: Any) -> Any:
    """The larger of two values."""
    return Signal("larger", a, b) if _any(a, b) else max(a, b)


def function(name: str) -> Callable[[Any], Any]:
    """A function of the module ``math``, for signals too."""
    plain = getattr(math, name)
    _FORMS[name] = f"{name}({{}})"
    return lambda x: Signal(name, x) if isinstance(x, Signal) else plain(x)


acos, atan, cos, exp, expm1, sin = map(function, ("acos", "atan", "cos", "exp", "expm1", "sin"))


def wrap(angle: Any) -> Any:
    """The same angle in [-180, 180) deg."""
    return (angle + 180.0) % 360.0 - 180.0


def flat(state: Any) -> tuple[Any, ...]:
    """The values in a state of nested tuples."""
    return tuple(x for part in state for x in (flat(part) if isinstance(part, tuple) else (part,)))


def nested(values: Iterator[Any], like: Any) -> Any:
    """The inverse of `flat`, for a state of the same form."""
    parts = [nested(values, x) if isinstance(x, tuple) else next(values) for x in like]
    return _like(like, parts)


def _like(form: Any, parts: Sequence[Any]) -> Any:
    return type(form)(*parts) if hasattr(form, "_fields") else tuple(parts)


Law = Callable[[Sequence[float], tuple[Any, ...]], tuple[list[float], tuple[Any, ...]]]


def compiled(describe: Callable[[list[Any], Any], tuple[Any, Any]], inputs: int, start: Any) -> Law:
    """A law as a plain function of its inputs and its state, which is `flat`, for floats.

    ``describe`` gives outputs and next state from a list of inputs and a state; ``inputs`` is the
    number of inputs, and further ones are not read; ``start`` is any state, for its form.
    """
    u = [Signal(f"u{i}") for i in range(inputs)]
    x = [Signal(f"x{i}") for i in range(len(flat(start)))]
    outputs, state = describe(u, nested(iter(x), start))
    return _function(_source(list(outputs), flat(state), "".join(f"{s.operation}, " for s in x)))


@lru_cache(maxsize=64)
def _function(source: str) -> Law:
    names: dict[str, Any] = {**vars(math)}
    exec(compile(source, "<law>", "exec"), names)
    law: Law = names["law"]
    return law


class Operations(NamedTuple):
    """The operations behind some values, each once, in an order in which they can be done."""

    steps: dict[str, tuple[str, ...]]  # by the result: the operation, and what it is applied to
    results: list[str]  # of the values: names of operations, or numbers

    def uses(self, twice: Sequence[str] = ()) -> Counter[str]:
        """How often each result is used; ``twice`` are operations that write their operands so."""
        uses = Counter(self.results)
        for operation, *operands in self.steps.values():
            for operand in operands:
                uses[operand] += 2 if operation in twice else 1
        return uses


# operations with these change nothing
_NOTHING = {"add": "0.0", "sub": "0.0", "mul": "1.0", "truediv": "1.0"}


def _simple(operation: str, operands: Sequence[str]) -> str | None:
    """The result of an operation that need not be done."""
    nothing = _NOTHING.get(operation)
    if operation == "mul" and "0.0" in operands:
        return "0.0"
    if operation in ("add", "mul") and operands[0] == nothing:
        return operands[1]
    if operands and operands[-1] in (nothing, operands[1] if operation == "select" else None):
        return operands[-2]
    return None


def operations(values: Iterable[Any]) -> Operations:
    """What leads to some values: equal operations are one."""
    steps: dict[str, tuple[str, ...]] = {}
    named: dict[tuple[str, ...], str] = {}
    seen: dict[int, str] = {}

    def name(value: Any) -> str:
        if not isinstance(value, Signal):
            return repr(value)
        if id(value) not in seen:
            key = (value.operation, *map(name, value.operands))
            simple = _simple(key[0], key[1:])
            seen[id(value)] = simple or named.setdefault(key, f"t{len(named)}")
            if simple is None:
                steps[named[key]] = key
        return seen[id(value)]

    results = [name(value) for value in values]
    needed = set(results)
    for result, (_, *operands) in reversed(steps.items()):
        if result in needed:
            needed.update(operands)
    return Operations({r: step for r, step in steps.items() if r in needed}, results)


def _source(outputs: Sequence[Any], state: Sequence[Any], before: str) -> str:
    """A function in which equal operations are done once; those used once stand where they are."""
    steps, results = found = operations((*outputs, *state))
    uses = found.uses(twice=("limit", "smaller", "larger"))
    texts: dict[str, str] = {}
    lines = ["def law(u, x):", f"{before}= x"]
    for result, (operation, *operands) in steps.items():
        if not operands:
            texts[result] = operation
            if operation[0] == "u":
                lines.append(f"{operation} = u[{operation[1:]}]")
            continue
        text = _FORMS[operation].format(*(texts.get(x, x) for x in operands))
        if uses[result] > 1:
            lines.append(f"{result} = {text}")
        else:
            texts[result] = f"({text})"
    y = [texts.get(x, x) for x in results]
    n = len(outputs)
    lines.append(f"return [{', '.join(y[:n])}], ({', '.join(y[n:])},)")
    return "\n    ".join(lines)
