"""`LinearAircraft`: the linear model of an aircraft as a block, with the aircraft's ports."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Literal

import numpy as np

from .._core.ports import numbered
from ..flight.aircraft import Aircraft
from ..flight.trimming.condition import TrimCondition
from .block import LinearModelBlock
from .model import LinearModel


@dataclass(eq=False, repr=False)
class LinearAircraft(LinearModelBlock):
    """Linear model of a trimmed JSBSim aircraft, with the commands and outputs of `Aircraft`.

    .. math::
        \\dot{x} = A x + B u, \\qquad y = y_0 + C x + D u

    The aircraft is trimmed and its model identified when the block is built (about 0.5 s). The
    diagram's solver integrates the model, which is valid for small motions about the trim.
    Commands are not limited. The latency of JSBSim's order of computation is a first-order lag on
    each input.

    Parameters
    ----------
    aircraft : str
        name of the JSBSim model
    altitude : float
        altitude above mean sea level in ft, geometric, up to 278,386, near the end of the standard
        atmosphere (1e9 in mode "none")
    speed : float
        calibrated airspeed in kt, up to 2000; not used if ``mach`` is given
    mach : float, optional
        Mach number instead of ``speed``, up to 30
    gamma : float
        flight path angle in deg, positive in a climb
    heading : float
        true heading in deg
    gear : float, optional
        landing gear, 0 up to 1 down; default is the model's own setting, which is often down even
        if the gear is retractable (737, B747): set 0 above 200 KCAS
    flaps : float, optional
        flap command, 0 to 1; default is the model's own setting
    T : float
        sample period in s of the modelled aircraft
    substeps : int
        JSBSim steps per sample period
    condition : TrimCondition, optional
        replaces the parameters from ``altitude`` to ``flaps`` if they are not sufficient
    setup : dict, optional
        properties written before initialisation and trim (fuel, payload); one whose
        value then changes is refused, except commands that the trim solves for
    properties : dict, optional
        properties written after the trim (turbulence)
    method : str
        "flown" or "algebraic", as in `Aircraft.linear_model`
    root : str, optional
        JSBSim root directory; default is the one shipped with jsbsim
    create : dict or "missing", optional
        properties that the model expects from its environment (FlightGear), with their values

    Inputs
    ------
    elevator, aileron, rudder, throttle
        increments on the trimmed commands, as for `Aircraft`

    Outputs
    -------
    theta, phi, psi
        pitch, roll and heading angle, deg; `Aircraft` shows a heading in [0, 360)
    p, q, r
        body rates, deg/s
    alpha, beta, gamma
        angle of attack, sideslip angle, flight path angle, deg
    h
        altitude above mean sea level, ft
    hdot
        rate of climb, ft/s
    vc
        calibrated airspeed, kt
    vt
        true airspeed, ft/s
    mach
        Mach number
    nx, nz
        load factors, g; nz is +1 in level flight
    lat, lon
        geodetic latitude and longitude, deg
    elev_sat, ail_sat, rud_sat, thr_sat
        0, because commands are not limited

    Raises
    ------
    LinearisationError
        if there is no linear model
    AircraftError, PropertyError, ParameterError, TrimError
        for unknown names, impossible values, or no trim

    Examples
    --------
    >>> plane = LinearAircraft("c172p", altitude=5000, speed=90, method="algebraic")
    >>> round(float(plane.outputs["alpha"]), 2)
    1.29
    """

    model: LinearModel = field(init=False)
    aircraft: str = "c172p"
    altitude: float = 5000.0
    speed: float = 100.0
    mach: float | None = None
    gamma: float = 0.0
    heading: float = 0.0
    gear: float | None = None
    flaps: float | None = None
    T: float = 1 / 120
    substeps: int = 1
    condition: TrimCondition | None = None
    setup: Mapping[str, float] | None = None
    properties: Mapping[str, float] | None = None
    method: Literal["flown", "algebraic"] = "flown"
    root: str | None = None
    create: Mapping[str, float] | str | None = None

    # without the wind ports of `Aircraft`: the model has no wind inputs
    input_port_labels = numbered("elevator aileron rudder throttle")
    output_port_labels = Aircraft.output_port_labels

    def _begin(self) -> None:
        parameters = {f.name: getattr(self, f.name) for f in fields(LinearAircraft) if f.init}
        method = parameters.pop("method")
        model = Aircraft(**parameters).linear_model(method)
        self.model = _with_ports(model, self.input_port_labels)
        super()._begin()


def _with_ports(model: LinearModel, names: Iterable[str]) -> LinearModel:
    """The model with these inputs; those it lacks, such as a throttle, have no effect."""
    lacking = [name for name in names if name not in model.inputs]

    def beyond(array: np.ndarray, value: float = 0.0) -> np.ndarray:
        wide = [(0, 0)] * (array.ndim - 1) + [(0, len(lacking))]
        return np.pad(array, wide, constant_values=value)

    return replace(
        model,
        inputs=(*model.inputs, *lacking),
        units={**dict.fromkeys(lacking, "norm"), **model.units},
        B=beyond(model.B),
        D=beyond(model.D),
        u0=beyond(model.u0),
        latency=beyond(model.latency, 1.0),
        kinks=beyond(model.kinks, np.nan),
        fit=beyond(model.fit, np.nan),
    ).select(list(names))
