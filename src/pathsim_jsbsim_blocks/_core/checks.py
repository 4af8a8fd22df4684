"""Checks of parameters, shared by all blocks and functions: refuse early, name the nearest."""

from __future__ import annotations

import difflib
import functools
import inspect
import math
from collections.abc import Container, Iterable, Mapping, Sequence
from numbers import Real
from typing import Any, NoReturn, TypeVar

import numpy as np

from ..errors import KeywordError, ParameterError

Checked = TypeVar("Checked", bound=type)


def refuse(parameter: str, value: Any, why: str) -> NoReturn:
    """Raise ParameterError, replacing an exception that is being handled."""
    raise ParameterError(why, parameter=parameter, value=value) from None


def must_be(parameter: str, value: Any, requirement: str) -> NoReturn:
    """Refuse a value, with the requirement."""
    refuse(parameter, value, f"{parameter} must be {requirement}, not {value!r}")


def nearest(name: str, names: Iterable[str], n: int = 3) -> list[str]:
    """The names most like ``name``: those that contain it, those in it, then by spelling.

    Paths (``attitude/theta-deg``) are also compared by their last part; case is ignored.
    """
    names = list(names)
    low = str(name).lower()
    holds = sorted((x for x in names if len(low) > 2 and low in x.lower()), key=len)
    parts = sorted((x for x in names if len(x) > 2 and x.lower() in low), key=len, reverse=True)
    spelt = {part.lower(): x for x in reversed(names) for part in (x.rpartition("/")[2], x)}
    close = difflib.get_close_matches(low, spelt, n=n, cutoff=0.55)
    return list(dict.fromkeys([*holds[:n], *parts, *(spelt[x] for x in close)]))[:n]


def nearest_ports(name: str, names: Iterable[str]) -> list[str]:
    """The ports or parameters of which ``name`` is another name, or else those most like it."""
    from .aircraft_ports import SYNONYMS

    names = list(names)
    key = str(name).lower().replace(" ", "_")
    meant = [port for port, words in SYNONYMS.items() if key in words.split() and port in names]
    return meant or nearest(name, names)


def did_you_mean(names: Iterable[str]) -> str:
    """Suffix for an error message; empty if there are no suggestions."""
    names = list(names)
    return f"; did you mean {' or '.join(repr(x) for x in names)}?" if names else ""


def refuse_unknown(
    owner: str, values: Mapping[str, Any], parameters: Iterable[str], ports: Container[str] = ()
) -> None:
    """Refuse unknown names of parameters: a KeywordError names the nearest, a port, or all."""
    parameters = list(parameters)
    for name, value in values.items():
        if name not in parameters:
            hint = did_you_mean(nearest_ports(name, parameters))
            if not hint and name in ports:
                hint = f": {name!r} is an input port; connect a signal to it"
            hint = hint or f"; it has {', '.join(parameters) or 'none'}"
            message = f"{owner} has no parameter {name!r}{hint}"
            raise KeywordError(message, parameter=name, value=value)


def known_keywords(cls: Checked) -> Checked:
    """A class decorator: refuse unknown keywords of the constructor, naming the nearest."""
    init = cls.__init__  # type: ignore[misc]
    parameters = list(inspect.signature(init).parameters.values())[1:]
    if not any(p.kind is p.VAR_KEYWORD for p in parameters):
        names = [p.name for p in parameters]

        @functools.wraps(init)
        def checked(self: Any, *args: Any, **kwargs: Any) -> None:
            ports = getattr(type(self), "input_port_labels", None) or ()
            refuse_unknown(type(self).__name__, kwargs, names, ports)
            init(self, *args, **kwargs)

        cls.__init__ = checked  # type: ignore[misc]
    return cls


def number(
    parameter: str,
    value: Any,
    *,
    low: float = -math.inf,
    high: float = math.inf,
    above: float | None = None,
    infinite: bool = False,
) -> float:
    """``value`` as a finite float with ``low <= value <= high`` (and ``value > above``).

    Refuses text, booleans, arrays, NaN, and infinities unless ``infinite``.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        must_be(parameter, value, "a number")
    try:
        x = float(value)
    except OverflowError:
        x = math.inf
    if not math.isfinite(x) and not (infinite and math.isinf(x)):
        refuse(parameter, value, f"{parameter} must be finite, not {x}")
    if above is not None and not x > above:
        refuse(parameter, value, f"{parameter} must be greater than {above:g}, not {x:g}")
    if not low <= x <= high:
        if high == math.inf:
            bounds = f"be at least {low:g}"
        elif low == -math.inf and above is None:
            bounds = f"be at most {high:g}"
        elif above is None or low > above:
            bounds = f"lie in [{low:g}, {high:g}]"
        else:
            bounds = f"lie in ({above:g}, {high:g}]"
        refuse(parameter, value, f"{parameter} must {bounds}, not {x:g}")
    return x


def positive(parameter: str, value: Any) -> float:
    """``value`` as a finite float greater than 0."""
    return number(parameter, value, above=0.0)


def optional(parameter: str, value: Any, of: Any = number, **bounds: Any) -> Any:
    """None, or ``value`` after another check, by default for a number within bounds."""
    return None if value is None else of(parameter, value, **bounds)


def heading(parameter: str, value: Any) -> float:
    """``value`` as a finite angle in deg, reduced to [0, 360)."""
    # twice: the first gives 360 for -1e-20 deg
    return number(parameter, value) % 360.0 % 360.0


def numbers(parameter: str, value: Any, **bounds: Any) -> list[float]:
    """``value``, a list, tuple or array, as numbers within bounds."""
    if not isinstance(value, (list, tuple)) and not (isinstance(value, np.ndarray) and value.ndim):
        must_be(parameter, value, "a list of numbers")
    return [number(f"{parameter}[{i}]", x, **bounds) for i, x in enumerate(value)]


def check_range(low: Any, high: Any) -> tuple[float, float]:
    """``low`` and ``high`` as floats, which may be infinite, with low <= high."""
    least, most = number("low", low, infinite=True), number("high", high, infinite=True)
    if least > most:
        refuse("low", low, f"the lower limit {low!r} must not be above the upper, {high!r}")
    return least, most


def integer(parameter: str, value: Any, *, low: int) -> int:
    """``value`` as an int of at least ``low``; 4.0 passes, 4.5 does not."""
    x = number(parameter, value, low=low)
    if x != int(x):
        refuse(parameter, value, f"{parameter} must be a whole number, not {x:g}")
    # of the value: a float would lose digits beyond 53 bits
    return int(value)


def one_of(parameter: str, value: Any, choices: Iterable[str]) -> str:
    """``value`` if it is one of ``choices``; the error names them all and the nearest."""
    choices = list(choices)
    if isinstance(value, str) and value in choices:
        return str(value)
    close = did_you_mean(nearest(str(value), choices, 1))
    options = ", ".join(map(repr, choices))
    refuse(parameter, value, f"{parameter} must be one of {options}, not {value!r}{close}")


def flag(parameter: str, value: Any) -> bool:
    """``value`` if it is a real bool: the string "no" is truthy."""
    if not isinstance(value, (bool, np.bool_)):
        must_be(parameter, value, "True or False")
    return bool(value)


def name_list(parameter: str, names: Any, requirement: str = "a list of names") -> list[Any]:
    """``names``, a list, tuple or array, as a list; numpy strings become Python's."""
    is_list = isinstance(names, Sequence) or (isinstance(names, np.ndarray) and names.ndim)
    if isinstance(names, str) or not is_list:
        must_be(parameter, names, requirement)
    return list(map(plain_name, names))


def property_list(parameter: str, names: Any) -> list[str]:
    names = name_list(parameter, names, "a list of property names")
    for i, name in enumerate(names):
        if not isinstance(name, str):
            refuse(parameter, names, f"{parameter}[{i}] must be a property's name, not {name!r}")
    return names


def plain_name(name: Any) -> Any:
    """A numpy string as Python's, because JSBSim accepts no other; other values unchanged."""
    return str(name) if isinstance(name, str) else name


def mapping(parameter: str, value: Any) -> dict[Any, Any]:
    """``value`` as a dict; None gives an empty one."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        must_be(parameter, value, "a dict of names and values")
    return {plain_name(name): x for name, x in value.items()}


def arrays(**values: Any) -> list[Any]:
    """``values`` as floats or as float arrays of their common shape, copied.

    Refuses text, booleans, None, complex numbers, and shapes that do not broadcast.
    """
    out, shape = _reals(values)
    return [np.broadcast_to(x, shape).copy() for x in out] if shape else [x[()] for x in out]


def finite(**values: Any) -> list[Any]:
    """``values`` as finite floats or float arrays, each in its own shape, not copied.

    Refuses NaN, infinities, and values that ``arrays`` refuses.
    """
    for value in values.values():
        if type(value) is not float or not math.isfinite(value):
            break
    else:
        return list(values.values())
    out, _ = _reals(values)
    for parameter, x in zip(values, out, strict=True):
        is_finite = np.isfinite(x)
        if not is_finite.all():
            why = f"{parameter} must be finite, not {x[~is_finite].flat[0]}"
            refuse(parameter, values[parameter], why)
    return [x if x.ndim else float(x) for x in out]


def _reals(values: Mapping[str, Any]) -> tuple[list[Any], tuple[int, ...]]:
    """Float arrays, and the shape to which they broadcast."""
    out = []
    for parameter, value in values.items():
        try:
            x = np.asarray(value)
        except ValueError:  # ragged
            x = np.empty(0, object)
        if x.dtype.kind not in "iuf":
            must_be(parameter, value, "a real number or an array of them")
        out.append(x.astype(float, copy=False))
    try:
        return out, np.broadcast_shapes(*(x.shape for x in out))
    except ValueError:
        shapes = {parameter: x.shape for parameter, x in zip(values, out, strict=True)}
        text = ", ".join(f"{parameter} {shape}" for parameter, shape in shapes.items() if shape)
        refuse(", ".join(values), shapes, f"the arrays must broadcast to one shape, not {text}")
