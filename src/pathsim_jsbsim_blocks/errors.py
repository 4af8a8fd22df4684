"""The errors of this package. Each carries its data as attributes, not only as text."""

from __future__ import annotations

import pickle
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeVar

_Error = TypeVar("_Error", bound="BlocksError")


class BlocksError(Exception):
    """Base class of all errors that this package raises."""

    def __reduce__(self) -> tuple[Any, ...]:
        # the default pickles the message alone, and workers send errors back to the caller
        data = {name: _sendable(value) for name, value in self.__dict__.items()}
        return _restored, (type(self), self.args, data)

    def reworded(self: _Error, message: str, **changed: Any) -> _Error:
        """The same error with another message, and with the data in ``changed``."""
        return _restored(type(self), (message,), {**self.__dict__, **changed})


def _restored(kind: type[_Error], args: tuple[Any, ...], data: dict[str, Any]) -> _Error:
    error = kind.__new__(kind, *args)
    error.__dict__.update(data)
    return error


def _sendable(value: Any) -> Any:
    """A value, or its text if it cannot be pickled: a refused function, say."""
    try:
        pickle.dumps(value)
    except Exception:
        return repr(value)
    return value


class ParameterError(BlocksError, ValueError):
    """A parameter of a block or function has an invalid value.

    Attributes
    ----------
    parameter : str
        name of the parameter
    value : object
        the value that was refused
    """

    def __init__(self, message: str, *, parameter: str, value: Any):
        super().__init__(message)
        self.parameter = parameter
        self.value = value


class KeywordError(ParameterError, TypeError):
    """A keyword argument that a block or condition does not have.

    Also a `TypeError`, as Python's own. `parameter` and `value` are the argument's.
    """


class AircraftError(BlocksError, ValueError):
    """An aircraft model is unknown or cannot be loaded.

    Attributes
    ----------
    aircraft : str
        the model's name
    nearest : list[str]
        models with a similar name, or existing properties similar to the missing ones
    missing : tuple[str, ...]
        properties that the model uses but that do not exist; empty for another reason
    """

    def __init__(
        self,
        message: str,
        *,
        aircraft: str,
        nearest: Sequence[str] = (),
        missing: Iterable[str] = (),
    ):
        super().__init__(message)
        self.aircraft = aircraft
        self.nearest = list(nearest)
        self.missing = tuple(missing)


class PropertyError(BlocksError, ValueError):
    """A JSBSim property is malformed, unknown, or cannot be read or written.

    Attributes
    ----------
    aircraft : str
        the model's name
    name : str
        the property's name as requested
    nearest : list[str]
        existing properties with a similar name
    """

    def __init__(self, message: str, *, aircraft: str, name: str, nearest: Sequence[str] = ()):
        super().__init__(message)
        self.aircraft = aircraft
        self.name = name
        self.nearest = list(nearest)


class TrimError(BlocksError, RuntimeError):
    """No trim was found at a condition.

    Attributes
    ----------
    aircraft : str
        the model's name
    condition : TrimCondition
        the requested condition
    reason : str
        the quantity that reached its limit: "thrust", "alpha limit", "elevator", "aileron",
        "rudder", "bank", "sideslip", "path angle" or "speed", on the ground "height", "pitch angle"
        or "bank"; "ground" if an aircraft in flight
        touches it or starts below it; "turbulence" in the setup; "mach" (propellers); "no
        equilibrium" if the state is not steady; or "no convergence". Of engines: "fuel" (empty
        tanks), "fuel valve" (fuel shut off by the model), "mixture", "engine" (does not run for
        another reason) or "propeller" (does not settle). Of the model: "no effect" (of a command),
        "rotorcraft", or "aerodynamics" (it has none)
    residuals : dict[str, float]
        accelerations in ft/s2 and rad/s2: untrimmed, or the minimum that the Newton search reached
    nearest : TrimCondition or None
        the nearest condition that trims, if a search for it succeeded: the same with
        ``solver="newton"``, or at another speed, the maximum for a condition that is too fast
    limit : float or None
        the limit that was reached (command, deg, ft/s), if a Newton search ended there; with
        ``trim(..., hint=True)`` a Newton search follows a failure of JSBSim's
    engines : list[int]
        engines without thrust
    command : str
        command without effect: "throttle", "pitch", "roll" or "yaw"
    commands : list[str]
        all commands without effect; ``command`` is the first
    properties : dict[str, float]
        the properties concerned: contents of empty tanks, priorities of tanks that are shut off,
        the mixture with which the engines run, or the value of a command after it was set
    """

    def __init__(
        self,
        message: str,
        *,
        aircraft: str,
        condition: Any,
        reason: str,
        residuals: Mapping[str, float],
        nearest: Any = None,
        limit: float | None = None,
        engines: Sequence[int] = (),
        command: str = "",
        commands: Sequence[str] = (),
        properties: Mapping[str, float] | None = None,
    ):
        super().__init__(message)
        self.aircraft = aircraft
        self.condition = condition
        self.reason = reason
        self.residuals = dict(residuals)
        self.nearest = nearest
        self.limit = limit
        self.engines = list(engines)
        self.command = command
        self.commands = list(commands)
        self.properties = dict(properties or {})


class LinearisationError(BlocksError, RuntimeError):
    """A linear model cannot be identified: no steady trim, or a zero or noisy response.

    Attributes
    ----------
    aircraft : str
        the model's name, empty for a block without one
    reason : str
        "no trim", "no response", "limit" (an input at the end of its range, or a step of the
        control system), "no fit" or "engine" (it does not settle)
    name : str
        input or output concerned, empty if all are
    servos : dict[str, float]
        servos with hysteresis behind that input, with the width in the unit of each
    """

    def __init__(
        self,
        message: str,
        *,
        aircraft: str = "",
        reason: str,
        name: str = "",
        servos: Mapping[str, float] | None = None,
    ):
        super().__init__(message)
        self.aircraft = aircraft
        self.reason = reason
        self.name = name
        self.servos = dict(servos or {})


class DesignError(BlocksError, RuntimeError):
    """The design found no gains for an aircraft at a condition.

    Attributes
    ----------
    aircraft : str
        the model's name
    reason : str
        "unstable" (no gains settle a step), or the reason for a missing linear model, as in
        `LinearisationError`
    loop : str
        "pitch", "roll", "heading", "altitude" or "speed"; empty if all are concerned
    """

    def __init__(self, message: str, *, aircraft: str, reason: str, loop: str = ""):
        super().__init__(message)
        self.aircraft = aircraft
        self.reason = reason
        self.loop = loop


class FlightError(BlocksError, RuntimeError):
    """The flight cannot continue: an input or a state is not finite, or the aircraft has crashed.

    Attributes
    ----------
    aircraft : str
        the model's name, empty for a block without one
    time : float
        simulated time in s
    name : str
        property or input port
    value : float
        its value
    """

    def __init__(self, message: str, *, aircraft: str, time: float, name: str, value: float):
        super().__init__(message)
        self.aircraft = aircraft
        self.time = time
        self.name = name
        self.value = value


class CopyError(BlocksError, TypeError):
    """An aircraft block cannot be copied or pickled, because JSBSim's state cannot.

    Attributes
    ----------
    block : str
        class of the block
    aircraft : str
        the model's name
    """

    def __init__(self, message: str, *, block: str, aircraft: str):
        super().__init__(message)
        self.block = block
        self.aircraft = aircraft


class BranchError(BlocksError, RuntimeError):
    """A future of `studies.branch` has no result, or no branch is possible.

    Attributes
    ----------
    future : int or None
        its place in the list, None if no branch is possible
    reason : str
        what ended the future, such as "killed by SIGKILL"
    """

    def __init__(self, message: str, *, future: int | None = None, reason: str = ""):
        super().__init__(message)
        self.future = future
        self.reason = reason or message


class DiagramError(BlocksError, ValueError):
    """A script or a model file cannot be read, or cannot be represented in the other format.

    Attributes
    ----------
    path : str
        the file
    line : int or None
        line of the script
    reason : str
        the fault
    """

    def __init__(self, reason: str, *, path: Any, line: int | None = None):
        super().__init__(f"{path}:{line}: {reason}" if line else f"{path}: {reason}")
        self.path = str(path)
        self.line = line
        self.reason = reason


class FileError(BlocksError, OSError):
    """A file cannot be read or written: no permission, a full disk, a missing folder.

    Attributes
    ----------
    path : str
        the file
    reason : str
        the operating system's message
    """

    def __init__(self, action: str, path: Any, cause: OSError, advice: str = ""):
        reason = cause.strerror or str(cause)
        super().__init__(f"cannot {action} {str(path)!r}: {reason}{advice}")
        self.path = str(path)
        self.reason = reason


class UntrustedModelError(DiagramError):
    """A model from outside would run, and the user has not trusted it yet.

    Attributes
    ----------
    digest : str
        digest of the model's content, under which trust in it is stored
    """

    def __init__(self, *, path: Any, digest: str):
        super().__init__(
            "from outside: its parameters and code are Python that runs as you when "
            "the model runs; read its code first",
            path=path,
        )
        self.digest = digest


class MissingExtraError(BlocksError, ImportError):
    """An optional package is not installed.

    Attributes
    ----------
    extra : str
        name of the extra that provides it
    """

    def __init__(self, package: str, extra: str):
        super().__init__(
            f'{package} is not installed; get it with pip install "pathsim-jsbsim-blocks[{extra}]"'
        )
        self.extra = extra


class DaveMLError(BlocksError, ValueError):
    """A DAVE-ML file is malformed, or one of its variables has no value.

    Attributes
    ----------
    path : str
        the file
    line : int or None
        line of the file
    variable : str
        varID of the variable concerned, empty if none is
    """

    def __init__(self, reason: str, *, path: Any, line: int | None = None, variable: str = ""):
        where = f"{path}:{line}" if line else f"{path}"
        what = f"variable {variable!r}: " if variable else ""
        super().__init__(f"{where}: {what}{reason}")
        self.path = str(path)
        self.line = line
        self.variable = variable
