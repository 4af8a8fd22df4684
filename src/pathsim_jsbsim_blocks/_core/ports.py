"""Ports and parameters by name: one that does not exist is refused, naming the nearest."""

from __future__ import annotations

import functools
import inspect
import reprlib
from collections.abc import Callable
from typing import Any

import numpy as np
from pathsim.blocks import Block, Function
from pathsim.optim.operator import Operator

from ..errors import BlocksError, ParameterError
from . import wiring  # noqa: F401  (warns of mistakes in the wiring)
from .checks import did_you_mean, known_keywords, nearest_ports, refuse_unknown
from .pathsim_internals import NamedRegister, port_names

_PACKAGE = __name__.partition(".")[0] + "."

# relative to an input's value, and the least
_STEP = 1e-6

# labels of the ports whose names PathView would cut, at 8 characters
_LABELS = {
    "wind_north": "wind_N",
    "wind_east": "wind_E",
    "wind_down": "wind_D",
    "theta_ref": "θ_ref",
    "theta_cmd": "θ_cmd",
    "pitch_mode": "pitch_md",
    "roll_mode": "roll_md",
    "pitch_off": "pit_off",
    "speed_off": "spd_off",
    "go_around": "goaround",
    "temp_deviation": "temp_dev",
    "temperature": "temp",
    "speed_of_sound": "sound",
    "viscosity": "visc",
}


def label(port: str) -> str:
    """What PathView writes at a port: its name, or a shorter label."""
    return _LABELS.get(port, port)


def numbered(names: str) -> dict[str, int]:
    """Port labels from names with spaces between them, in their order."""
    return {name: i for i, name in enumerate(names.split())}


class NamedPorts(Block):
    """Base of all blocks here: parameters, ``block["name"]`` and outputs are checked by name."""

    # from the end of the constructor on, in the classes of this package
    _built = False

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        if "__init__" in vars(cls):
            known_keywords(cls)
            init = cls.__init__  # type: ignore[misc]

            @functools.wraps(init)
            def building(self: Any, *arguments: Any, **keywords: Any) -> None:
                init(self, *arguments, **keywords)
                kind = type(self)
                if kind.__init__ is building and kind.__module__.startswith(_PACKAGE):
                    self._built = True

            cls.__init__ = building  # type: ignore[method-assign]

    def __init__(self, *arguments: Any, **keywords: Any) -> None:
        super().__init__(*arguments, **keywords)
        self.outputs = NamedRegister(len(self.outputs), port_names(self.outputs))

    def __setattr__(self, name: str, value: Any) -> None:
        # 20 times as slow as a plain assignment: what every step changes is on the sample clock
        if self._built and name[0] != "_" and not hasattr(self, name):
            known, ports = self.info()["parameters"], port_names(self.inputs)
            refuse_unknown(type(self).__name__, {name: value}, known, ports)
        super().__setattr__(name, value)

    def __repr__(self) -> str:
        given = []
        for name, parameter in inspect.signature(type(self)).parameters.items():
            value = getattr(self, name, parameter.default)
            # by its text, because arrays do not compare to one value
            if repr(value) != repr(parameter.default):
                given.append(f"{name}={reprlib.repr(value)}")
        return f"{type(self).__name__}({', '.join(given)})"

    @classmethod
    def info(cls) -> dict[str, Any]:
        """Metadata of the block, as PathSim gives it, with the ports as PathView labels them."""
        found = dict(super().info())
        for side in ("input_port_labels", "output_port_labels"):
            found[side] = found[side] and {label(n): i for n, i in found[side].items()}
        return found

    def __getitem__(self, key: Any) -> Any:
        names = [*port_names(self.inputs), *port_names(self.outputs)]
        for port in key if isinstance(key, (list, tuple)) else [key]:
            if isinstance(port, str) and port not in names:
                close = nearest_ports(port, names)
                known = did_you_mean(close) if close else f"; its ports are {', '.join(names)}"
                message = f"{type(self).__name__} has no port {port!r}{known}"
                raise self._no_port(message, port, close)
        return super().__getitem__(key)

    def _no_port(self, message: str, port: str, close: list[str]) -> BlocksError:
        return ParameterError(message, parameter="port", value=port)

    def set(self, **values: Any) -> None:
        """Set several parameters at once, as PathSim's ``@mutable`` blocks do.

        They are checked together: ``pid.set(low=2.0, high=3.0)`` works in either order. If one is
        refused, none is set.

        Raises
        ------
        ParameterError
            for a parameter that the block does not have, naming the nearest, and for bad values
        """
        refuse_unknown(type(self).__name__, values, self.info()["parameters"])
        before = {name: getattr(self, name) for name in values}
        try:
            self._put(values)
        except BlocksError:
            self._put(before)
            raise

    def _put(self, values: dict[str, Any]) -> None:
        for name, value in values.items():
            setattr(self, name, value)


class NamedFunction(NamedPorts, Function):
    """Base of the blocks without a state: a function of the inputs, given as floats."""

    def __init__(self, func: Callable[..., Any]) -> None:
        # past the constructors of pathsim-flight's classes, which take no function
        Function.__init__(self, func)
        self.outputs = NamedRegister(len(self.outputs), port_names(self.outputs))

        # Function's own operator gives a tuple, which PathSim cannot differentiate
        def outputs(u: np.ndarray) -> np.ndarray:
            return np.atleast_1d(func(*u.tolist()))

        def slopes(u: np.ndarray) -> np.ndarray:
            # PathSim's steps are of a thousandth: too wide for a latitude
            steps = _STEP * np.maximum(np.abs(u), 1.0)
            changes = [outputs(u + step) - outputs(u - step) for step in np.diag(steps)]
            return np.column_stack(changes) / (2 * steps)

        self.op_alg = Operator(outputs, slopes)
