"""The door from an aircraft to its linear models, which are beyond the core.

What is imported from there is imported when it is asked for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from .flyable import Flyable
from .options import AircraftOptions
from .trimming.condition import TrimCondition

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ..linear.model import LinearModel


def linear_model(
    aircraft: str,
    condition: TrimCondition | None = None,
    method: Literal["flown", "algebraic"] = "flown",
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    amplitude: Mapping[str, float] | None = None,
    *,
    T: float = 1 / 120,
    substeps: int = 1,
    **options: Unpack[AircraftOptions],
) -> LinearModel:
    """Linear model of an aircraft about a trim, with the commands and outputs of `Aircraft`.

    Parameters
    ----------
    aircraft : str
        name of the JSBSim model
    condition : TrimCondition, optional
        the trim; default 5000 ft and 100 KCAS
    method, inputs, outputs, amplitude
        as in `Aircraft.linear_model`
    T : float
        sample period in s
    substeps : int
        JSBSim steps per sample period
    **options
        ``setup``, ``properties``, ``root``, ``create``, ``allow_network`` or ``allow_files``, as
        of `Aircraft`

    Returns
    -------
    LinearModel

    Raises
    ------
    LinearisationError
        if no linear model exists: no steady trim in flight, an input at the end of its range
        or without response, responses that no linear model fits
    AircraftError, PropertyError, ParameterError, TrimError
        for unknown names, impossible values, or no trim

    Examples
    --------
    >>> model = linear_model("737", TrimCondition(altitude=5000, speed=260, gear=0.0))
    >>> model.states
    ('vt', 'alpha', 'beta', 'p', 'q', 'r', 'phi', 'theta', 'h', 'psi', 'lat', 'lon')
    """
    from ..linear import jsbsim

    return jsbsim.linear_model_of(
        aircraft, condition, (method, inputs, outputs, amplitude), T=T, substeps=substeps, **options
    )


def model_of(
    block: Flyable,
    method: str,
    inputs: Sequence[str] | None,
    outputs: Sequence[str] | None,
    amplitude: Mapping[str, float] | None,
) -> LinearModel:
    """Linear model about the trim of a block; see `FlightBlock.linear_model`."""
    from ..linear import jsbsim

    return jsbsim.model_about_trim(block, method, inputs, outputs, amplitude)


def response_of(block: Flyable, input: str, increments: Sequence[float], output: str) -> np.ndarray:
    """An output over increments on an input; see `FlightBlock.response`."""
    from ..linear import jsbsim

    return jsbsim.response(block, input, increments, output)
