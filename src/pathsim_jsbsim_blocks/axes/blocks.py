"""Blocks that turn vectors between axes inside a diagram.

References
----------
JSBSim Reference Manual, Concepts, Frames of Reference.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .._core.checks import number
from .._core.function import NamedFunction
from .._core.parameters import parameter
from .aircraft import body_to_drag_side_lift, body_to_ned, drag_side_lift_to_body, ned_to_body
from .earth import geodetic_to_ned


@dataclass(eq=False, repr=False)
class WindToBody(NamedFunction):
    """Drag, side force and lift to forces along the body axes.

    .. math::

        x = -(D \\cos\\beta + Y \\sin\\beta) \\cos\\alpha + L \\sin\\alpha

        y = -D \\sin\\beta + Y \\cos\\beta

        z = -(D \\cos\\beta + Y \\sin\\beta) \\sin\\alpha - L \\cos\\alpha

    The exact inverse of `BodyToWind`. If beta is not connected, it starts from the stability axes.

    Inputs
    ------
    drag, side, lift : float
        drag positive aft, side force positive to the right, lift positive up, lbf (any unit)
    alpha, beta : float
        angle of attack and sideslip angle (positive with the air from the right), deg

    Outputs
    -------
    x, y, z : float
        force forward, right, down, lbf (the unit of the inputs)
    """

    input_port_labels = {"drag": 0, "side": 1, "lift": 2, "alpha": 3, "beta": 4}
    output_port_labels = {"x": 0, "y": 1, "z": 2}

    function = staticmethod(drag_side_lift_to_body)


@dataclass(eq=False, repr=False)
class BodyToWind(NamedFunction):
    """Forces along the body axes to drag, side force and lift.

    .. math::

        D = -(x \\cos\\alpha + z \\sin\\alpha) \\cos\\beta - y \\sin\\beta

        Y = -(x \\cos\\alpha + z \\sin\\alpha) \\sin\\beta + y \\cos\\beta

        L = x \\sin\\alpha - z \\cos\\alpha

    The exact inverse of `WindToBody`. If beta is not connected, it ends in the stability axes.

    Inputs
    ------
    x, y, z : float
        force forward, right, down, lbf (any unit)
    alpha, beta : float
        angle of attack and sideslip angle (positive with the air from the right), deg

    Outputs
    -------
    drag, side, lift : float
        drag positive aft, side force positive to the right, lift positive up, lbf (the unit of
        the inputs)
    """

    input_port_labels = {"x": 0, "y": 1, "z": 2, "alpha": 3, "beta": 4}
    output_port_labels = {"drag": 0, "side": 1, "lift": 2}

    function = staticmethod(body_to_drag_side_lift)


@dataclass(eq=False, repr=False)
class NEDToBody(NamedFunction):
    """Turn a vector from north, east, down to the body axes by the 3-2-1 Euler angles.

    Through psi about the down axis, then theta about y, then phi about x. The exact inverse of
    `BodyToNED`. For example, it gives the wind in body axes.

    Inputs
    ------
    north, east, down : float
        components along the local NED axes, any unit
    phi, theta, psi : float
        roll (right wing down), pitch (nose up) and true heading, deg

    Outputs
    -------
    x, y, z : float
        components forward, right, down, in the unit of the inputs
    """

    input_port_labels = {"north": 0, "east": 1, "down": 2, "phi": 3, "theta": 4, "psi": 5}
    output_port_labels = {"x": 0, "y": 1, "z": 2}

    function = staticmethod(ned_to_body)


@dataclass(eq=False, repr=False)
class BodyToNED(NamedFunction):
    """Turn a vector from the body axes to north, east, down by the 3-2-1 Euler angles.

    The exact inverse of `NEDToBody`. For example, it gives the ground velocity from u, v, w.

    Inputs
    ------
    x, y, z : float
        components forward, right, down, any unit
    phi, theta, psi : float
        roll (right wing down), pitch (nose up) and true heading, deg

    Outputs
    -------
    north, east, down : float
        components along the local NED axes, in the unit of the inputs
    """

    input_port_labels = {"x": 0, "y": 1, "z": 2, "phi": 3, "theta": 4, "psi": 5}
    output_port_labels = {"north": 0, "east": 1, "down": 2}

    function = staticmethod(body_to_ned)


@dataclass(eq=False, repr=False)
class GeodeticToNED(NamedFunction):
    """Position north, east and down of a reference point, such as a runway threshold.

    The axes are tangent to JSBSim's ellipsoid (WGS84) at the reference.

    Parameters
    ----------
    lat0 : float
        geodetic latitude of the reference in [-90, 90], deg
    lon0 : float
        longitude of the reference, deg, east positive
    h0 : float
        height of the reference above the ellipsoid, ft

    Inputs
    ------
    lat, lon : float
        geodetic latitude and longitude, deg (``position/lat-geod-deg``, ``position/long-gc-deg``)
    h : float
        height above the ellipsoid, ft (``position/geod-alt-ft``)

    Outputs
    -------
    north, east, down : float
        ft

    Raises
    ------
    ParameterError
        for a reference that is not finite, or a latitude beyond 90 deg
    """

    lat0: float = parameter(0.0, number, low=-90.0, high=90.0)
    lon0: float = parameter(0.0, number)
    h0: float = parameter(0.0, number)

    input_port_labels = {"lat": 0, "lon": 1, "h": 2}
    output_port_labels = {"north": 0, "east": 1, "down": 2}

    def function(self, lat: float, lon: float, h: float) -> tuple[Any, Any, Any]:
        c = self._checked
        return geodetic_to_ned(lat, lon, h, c.lat0, c.lon0, c.h0)
