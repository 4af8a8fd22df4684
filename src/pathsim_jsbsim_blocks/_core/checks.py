"""Checks of parameters, shared by all blocks and functions: refuse early, name the nearest."""

from __future__ import annotations

import difflib
import functools
import inspect
import math
import os
from collections.abc import Container, Iterable, Mapping, Sequence
from numbers import Real
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import numpy as np

from ..errors import KeywordError, ParameterError

Checked = TypeVar("Checked", bound=type)


def refuse(parameter: str, value: Any, why: str) -> NoReturn:
    """Raise ParameterError, in place of the exception being handled if there is one."""
    raise ParameterError(why, parameter=parameter, value=value) from None


def nearest(name: str, names: Iterable[str], n: int = 3) -> list[str]:
    """The names most like ``name``: those that contain it, those in it, then by spelling.

    Names that are paths (``attitude/theta-deg``) are compared whole and by their last part; capital
    letters do not count.
    """
    names = list(names)
    low = str(name).lower()
    holds = sorted((x for x in names if len(low) > 2 and low in x.lower()), key=len)
    held = sorted((x for x in names if len(x) > 2 and x.lower() in low), key=len, reverse=True)
    spelt = {part.lower(): x for x in reversed(names) for part in (x.rpartition("/")[2], x)}
    close = difflib.get_close_matches(low, spelt, n=n, cutoff=0.55)
    return list(dict.fromkeys([*holds[:n], *held, *(spelt[x] for x in close)]))[:n]


# ports by what users call them, in small letters
_PORTS_OF = {
    "pitch": ("theta",),
    "pitch_angle": ("theta",),
    "roll": ("phi",),
    "bank": ("phi",),
    "roll_angle": ("phi",),
    "bank_angle": ("phi",),
    "heading": ("psi",),
    "yaw": ("psi",),
    "roll_rate": ("p",),
    "pitch_rate": ("q",),
    "yaw_rate": ("r",),
    "aoa": ("alpha",),
    "angle_of_attack": ("alpha",),
    "sideslip": ("beta",),
    "fpa": ("gamma",),
    "path_angle": ("gamma",),
    "flight_path_angle": ("gamma",),
    "altitude": ("h",),
    "alt": ("h",),
    "height": ("h", "altitude"),
    "h": ("altitude",),
    "climb": ("hdot",),
    "climb_rate": ("hdot",),
    "rate_of_climb": ("hdot",),
    "vertical_speed": ("hdot",),
    "vs": ("hdot",),
    "airspeed": ("vc", "vt"),
    "speed": ("vc", "vt"),
    "cas": ("vc",),
    "kcas": ("vc",),
    "ias": ("vc",),
    "tas": ("vt",),
    "v": ("vt",),
    "m": ("mach",),
    "load_factor": ("nz",),
    "g": ("nz",),
    "rho": ("density",),
    "t": ("temperature",),
    "a": ("speed_of_sound",),
    "mu": ("viscosity",),
}


def nearest_ports(name: str, names: Iterable[str]) -> list[str]:
    """The ports that ``name`` is another name of; otherwise those most like it."""
    names = list(names)
    key = str(name).lower().replace(" ", "_")
    return [port for port in _PORTS_OF.get(key, ()) if port in names] or nearest(name, names)


def did_you_mean(names: Iterable[str]) -> str:
    """Suffix for an error message; empty if there are no suggestions."""
    names = list(names)
    return f"; did you mean {' or '.join(repr(x) for x in names)}?" if names else ""


def refuse_unknown(
    owner: str, values: Mapping[str, Any], known: Iterable[str], ports: Container[str] = ()
) -> None:
    """Check the names of parameters.

    Raises
    ------
    KeywordError
        for one that is not known, naming the nearest, or the input port of that name, or all
        parameters that there are
    """
    known = list(known)
    for name, value in values.items():
        if name not in known:
            hint = did_you_mean(nearest(name, known))
            if not hint and name in ports:
                hint = f": {name!r} is an input port, which a Connection leads into"
            raise KeywordError(
                f"{owner} has no parameter {name!r}{hint or f'; it has {_listed(known)}'}",
                parameter=name,
                value=value,
            )


def known_keywords(cls: Checked) -> Checked:
    """A class whose constructor refuses keywords that it does not have, naming the nearest.

    A constructor that passes further keywords on is left alone.
    """
    init = cls.__init__  # type: ignore[misc]
    parameters = list(inspect.signature(init).parameters.values())[1:]
    if not any(p.kind is p.VAR_KEYWORD for p in parameters):
        known = [p.name for p in parameters]

        @functools.wraps(init)
        def checked(self: Any, *args: Any, **kwargs: Any) -> None:
            ports = getattr(type(self), "input_port_labels", None) or ()
            refuse_unknown(type(self).__name__, kwargs, known, ports)
            init(self, *args, **kwargs)

        cls.__init__ = checked  # type: ignore[misc]
    return cls


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) or "none"


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

    Raises
    ------
    ParameterError
        for text, booleans, arrays, NaN, infinities (unless ``infinite``) and values out of range
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        refuse(parameter, value, f"{parameter} must be a number, not {value!r}")
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


def optional(parameter: str, value: Any, **bounds: Any) -> float | None:
    """``value`` as a number within bounds, or None."""
    return None if value is None else number(parameter, value, **bounds)


def numbers(parameter: str, value: Any, **bounds: Any) -> list[float]:
    """``value``, a list, tuple or array, as numbers within bounds."""
    if not isinstance(value, (list, tuple)) and not (isinstance(value, np.ndarray) and value.ndim):
        refuse(parameter, value, f"{parameter} must be a list of numbers, not {value!r}")
    return [number(f"{parameter}[{i}]", x, **bounds) for i, x in enumerate(value)]


def limits(low: Any, high: Any) -> tuple[float, float]:
    """``low`` and ``high`` as floats, which may be infinite, the lower not above the upper."""
    least, most = number("low", low, infinite=True), number("high", high, infinite=True)
    if least > most:
        refuse("low", low, f"the lower limit {low!r} must not be above the upper, {high!r}")
    return least, most


def whole(parameter: str, value: Any, *, low: int) -> int:
    """``value`` as an int of at least ``low``; 4.0 passes, 4.5 does not."""
    x = number(parameter, value, low=low)
    if x != int(x):
        refuse(parameter, value, f"{parameter} must be a whole number, not {x:g}")
    # not of x, which has 53 bits
    return int(value)


def one_of(parameter: str, value: Any, choices: Iterable[str]) -> str:
    """``value`` if it is one of ``choices``; the error names them all and the nearest."""
    choices = list(choices)
    if isinstance(value, str) and value in choices:
        return value
    refuse(
        parameter,
        value,
        f"{parameter} must be one of {', '.join(map(repr, choices))}, not {value!r}"
        + did_you_mean(nearest(str(value), choices, 1)),
    )


def flag(parameter: str, value: Any) -> bool:
    """``value`` if it is a real bool: the string "no" is truthy."""
    if not isinstance(value, (bool, np.bool_)):
        refuse(parameter, value, f"{parameter} must be True or False, not {value!r}")
    return bool(value)


def as_path(parameter: str, value: Any) -> Path:
    """``value`` as a path."""
    try:
        path = Path(value)
        if "\0" in str(path):  # no system has such a file
            raise TypeError
        return path
    except TypeError:
        refuse(parameter, value, f"{parameter} must be a path, not {value!r}")


def writable(parameter: str, value: Any) -> Path:
    """``value`` as the path of a file that can be written, tried by opening it."""
    path = as_path(parameter, value)
    # os.path, because a name too long for the system is an error of Path's
    if os.path.isdir(path):
        refuse(parameter, str(path), f"{parameter} must be a file, {str(path)!r} is a directory")
    if not os.path.isdir(path.parent):
        refuse(parameter, str(path), f"no directory {str(path.parent)!r} to write {path.name!r} in")
    new = not os.path.lexists(path)
    if new or os.path.isfile(path):  # opening and closing a pipe would end its data
        try:
            path.open("ab").close()
            if new:
                path.unlink()
        except OSError as error:
            refuse(parameter, str(path), f"cannot write {str(path)!r}: {error.strerror}")
    return path


def ending(parameter: str, path: Path, *endings: str) -> Path:
    """``path`` if it has one of ``endings``; the error names it with the first of them."""
    if path.suffix.lower() not in endings:
        known = " or ".join(x for x in endings if x)
        refuse(
            parameter,
            str(path),
            f"{parameter} must end in {known}, not {path.name!r}; did you mean "
            f"{os.path.splitext(path)[0] + endings[0]!r}?",
        )
    return path


def property_list(parameter: str, names: Any) -> list[str]:
    """``names`` as a list of texts."""
    if isinstance(names, str) or not isinstance(names, Sequence):
        refuse(parameter, names, f"{parameter} must be a list of property names, not {names!r}")
    for i, name in enumerate(names):
        if not isinstance(name, str):
            refuse(parameter, names, f"{parameter}[{i}] must be a property's name, not {name!r}")
    return list(names)


def mapping(parameter: str, value: Any) -> dict[Any, Any]:
    """``value`` as a dict; None is an empty one."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        refuse(parameter, value, f"{parameter} must be a dict of names and values, not {value!r}")
    return dict(value)


def arrays(**values: Any) -> list[Any]:
    """``values`` as floats or as float arrays of their common shape, copied.

    Raises
    ------
    ParameterError
        for text, booleans, None, complex numbers, and for shapes that do not broadcast
    """
    out, shape = _reals(values)
    return [np.broadcast_to(x, shape).copy() for x in out] if shape else [x[()] for x in out]


def finite(**values: Any) -> list[Any]:
    """``values`` as finite floats or float arrays, each in its own shape, not copied.

    Raises
    ------
    ParameterError
        for NaN and infinities, and for what ``arrays`` refuses
    """
    for value in values.values():
        if type(value) is not float or not math.isfinite(value):
            break
    else:
        return list(values.values())
    out, _ = _reals(values)
    for parameter, x in zip(values, out, strict=True):
        known = np.isfinite(x)
        if not known.all():
            refuse(
                parameter, values[parameter], f"{parameter} must be finite, not {x[~known].flat[0]}"
            )
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
            refuse(
                parameter,
                value,
                f"{parameter} must be a real number or an array of them, not {value!r}",
            )
        out.append(x.astype(float, copy=False))
    try:
        return out, np.broadcast_shapes(*(x.shape for x in out))
    except ValueError:
        shapes = {parameter: x.shape for parameter, x in zip(values, out, strict=True)}
        refuse(
            ", ".join(values),
            shapes,
            "the arrays must broadcast to one shape, not "
            + ", ".join(f"{parameter} {shape}" for parameter, shape in shapes.items() if shape),
        )
