"""The errors of this package. Each carries its data as attributes, not only as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


class BlocksError(Exception):
    """Base class: catches every error that this package raises on purpose."""


class ParameterError(BlocksError, ValueError):
    """A parameter of a block or function has a value that it cannot take.

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


class AircraftError(BlocksError, ValueError):
    """An aircraft model is unknown or cannot be loaded.

    Attributes
    ----------
    aircraft : str
        the model's name
    nearest : list[str]
        known models with a similar name
    """

    def __init__(self, message: str, *, aircraft: str, nearest: Sequence[str] = ()):
        super().__init__(message)
        self.aircraft = aircraft
        self.nearest = list(nearest)


class PropertyError(BlocksError, ValueError):
    """A JSBSim property is malformed, unknown, or cannot be read or written.

    Attributes
    ----------
    aircraft : str
        the model's name
    name : str
        the property's name as it was given
    nearest : list[str]
        existing properties with a similar name
    """

    def __init__(self, message: str, *, aircraft: str, name: str, nearest: Sequence[str] = ()):
        super().__init__(message)
        self.aircraft = aircraft
        self.name = name
        self.nearest = list(nearest)


class TrimError(BlocksError, RuntimeError):
    """JSBSim found no trim at a condition.

    Attributes
    ----------
    aircraft : str
        the model's name
    condition : TrimCondition
        what was asked for
    reason : str
        "thrust", "alpha limit", "elevator", "initial condition" or "no convergence"
    residuals : dict[str, float]
        what JSBSim left: accelerations in ft/s2 and rad/s2, commands, alpha in deg
    """

    def __init__(self, message: str, *, aircraft: str, condition: Any, reason: str,
                 residuals: Mapping[str, float]):
        super().__init__(message)
        self.aircraft = aircraft
        self.condition = condition
        self.reason = reason
        self.residuals = dict(residuals)


class FlightError(BlocksError, RuntimeError):
    """The flight cannot go on: an input or a state is not finite.

    Attributes
    ----------
    aircraft : str
        the model's name
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
