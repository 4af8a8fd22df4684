"""Axes of the aircraft: structural, body, stability, wind and local NED.

==========  =================  ==================================================================
axes        origin             x, y, z
==========  =================  ==================================================================
structural  maker's datum      aft (station), right (buttline), up (waterline), in
body        centre of gravity  forward, right, down
stability   centre of gravity  the airspeed's projection on the plane of symmetry, right, down
wind        centre of gravity  the airspeed, right, down in the plane of symmetry
NED         centre of gravity  north, east, down
==========  =================  ==================================================================

Angles are in degrees. A vector is three components, numbers or arrays; all arguments of a call
broadcast to one shape, and the results have that shape. A rotation keeps the unit, and NaN gives
NaN. Each function and its inverse cancel to rounding.

References
----------
JSBSim Reference Manual, Concepts, Frames of Reference.
Stevens, Lewis, Johnson: Aircraft Control and Simulation, 3rd ed., Wiley 2016, chapters 1 and 2.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from inspect import cleandoc
from typing import Any, TypeVar

import numpy as np

from .._core.checks import arrays, must_be

Values = float | np.ndarray
Components = tuple[Any, Any, Any]
Function = TypeVar("Function", bound=Callable[..., Components])

INCHES_PER_FOOT = 12.0

_FORCE = {"x, y, z": "force along the body axes"}
_DRAG = {
    "drag, side, lift": "drag positive aft, side force positive to the right, lift positive up"
}
_ALPHA = {"alpha": "angle of attack, deg"}
_BETA = {"beta": "sideslip angle, deg, positive with the air from the right"}
_FLOW = {"alpha, beta": "angle of attack and sideslip angle, deg"}
_EULER = {
    "phi, theta, psi": "roll (right wing down), pitch (nose up) and true heading (clockwise from "
    "north), deg"
}

_PAGE = """\
{text}

Parameters
----------
{given}

Returns
-------
{found}

Raises
------
ParameterError
    for a value that is not real, shapes that do not broadcast{more}"""


def page(
    given: Mapping[str, str], found: Mapping[str, str], more: str = ""
) -> Callable[[Function], Function]:
    """A decorator that completes a docstring: names and meaning of what is given and found."""

    def listed(values: Mapping[str, str], kind: str) -> str:
        return "\n".join(f"{names} : {kind}\n    {text}" for names, text in values.items())

    def complete(function: Function) -> Function:
        if function.__doc__:  # absent under python -OO
            function.__doc__ = _PAGE.format(
                text=cleandoc(function.__doc__),
                given=listed(given, "array_like"),
                found=listed(found, "float or ndarray"),
                more=more,
            )
        return function

    return complete


def rotation(
    source: str, target: str, angles: Mapping[str, str], more: str = ""
) -> Callable[[Function], Function]:
    """`page` of a rotation between axes."""
    given, found = (
        {"north, east, down" if "NED" in axes else "x, y, z": f"components along the {axes} axes"}
        for axes in (source, target)
    )
    return page({**given, **angles}, found, more)


def turn(a: Any, b: Any, angle: Any) -> tuple[Any, Any]:
    """Components along axes turned by ``angle`` (deg) from a towards b."""
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    return a * c + b * s, b * c - a * s


@page(
    {
        "x, y, z": "the point: station (aft), buttline (right) and waterline (up), in",
        "reference": "x, y, z of the point that becomes the origin, in the same axes, in; the "
        "centre of gravity (``inertia/cg-x-in``, ``cg-y-in``, ``cg-z-in``) for the body axes",
    },
    {"x, y, z": "forward, right, down of the reference, ft"},
    ", a reference not of three parts",
)
def structural_to_body(x: Values, y: Values, z: Values, reference: Sequence[Values]) -> Components:
    """Body coordinates of a point given in structural coordinates.

    (x_B, y_B, z_B) = (x_ref - x, y - y_ref, z_ref - z) / 12
    """
    x, y, z, x0, y0, z0 = arrays(x=x, y=y, z=z, **_reference(reference))
    return (x0 - x) / INCHES_PER_FOOT, (y - y0) / INCHES_PER_FOOT, (z0 - z) / INCHES_PER_FOOT


@page(
    {
        "x, y, z": "the point: forward, right, down of the reference, ft",
        "reference": "origin of the body axes in structural coordinates, in",
    },
    {"x, y, z": "station (aft), buttline (right) and waterline (up), in"},
    ", a reference not of three parts",
)
def body_to_structural(x: Values, y: Values, z: Values, reference: Sequence[Values]) -> Components:
    """Structural coordinates of a point given in body coordinates."""
    x, y, z, x0, y0, z0 = arrays(x=x, y=y, z=z, **_reference(reference))
    return x0 - INCHES_PER_FOOT * x, y0 + INCHES_PER_FOOT * y, z0 - INCHES_PER_FOOT * z


def _reference(reference: Sequence[Values]) -> dict[str, Values]:
    parts = list(reference) if np.iterable(reference) else []
    if len(parts) != 3:
        must_be("reference", reference, "the three coordinates x, y, z")
    return {f"reference[{i}]": part for i, part in enumerate(parts)}


@page(
    {"u, v, w": "velocity relative to the air in body axes, any unit"},
    {
        "alpha, beta": "deg; alpha is positive with the air from below, in [-180, 180]; beta is "
        "positive with the air from the right, in [-90, 90]; both are 0 at rest",
        "airspeed": "in the unit of u, v, w",
    },
)
def aerodynamic_angles(u: Values, v: Values, w: Values) -> Components:
    """Angle of attack, sideslip angle and airspeed of a velocity relative to the air.

    alpha = atan2(w, u),  beta = atan2(v, sqrt(u^2 + w^2)),  V = sqrt(u^2 + v^2 + w^2)
    """
    u, v, w = arrays(u=u, v=v, w=w)
    uw = np.hypot(u, w)
    return np.rad2deg(np.arctan2(w, u)), np.rad2deg(np.arctan2(v, uw)), np.hypot(uw, v)


@rotation("body", "stability", _ALPHA)
def body_to_stability(x: Values, y: Values, z: Values, alpha: Values) -> Components:
    """Turn a vector from body to stability axes, about the y axis.

    x_S = x cos alpha + z sin alpha,  y_S = y,  z_S = z cos alpha - x sin alpha
    """
    x, y, z, alpha = arrays(x=x, y=y, z=z, alpha=alpha)
    x, z = turn(x, z, alpha)
    return x, y, z


@rotation("stability", "body", _ALPHA)
def stability_to_body(x: Values, y: Values, z: Values, alpha: Values) -> Components:
    """Turn a vector from stability to body axes: the inverse of `body_to_stability`."""
    x, y, z, alpha = arrays(x=x, y=y, z=z, alpha=alpha)
    x, z = turn(x, z, -alpha)
    return x, y, z


@rotation("stability", "wind", _BETA)
def stability_to_wind(x: Values, y: Values, z: Values, beta: Values) -> Components:
    """Turn a vector from stability to wind axes, about the z axis.

    x_W = x cos beta + y sin beta,  y_W = y cos beta - x sin beta,  z_W = z
    """
    x, y, z, beta = arrays(x=x, y=y, z=z, beta=beta)
    x, y = turn(x, y, beta)
    return x, y, z


@rotation("wind", "stability", _BETA)
def wind_to_stability(x: Values, y: Values, z: Values, beta: Values) -> Components:
    """Turn a vector from wind to stability axes: the inverse of `stability_to_wind`."""
    x, y, z, beta = arrays(x=x, y=y, z=z, beta=beta)
    x, y = turn(x, y, -beta)
    return x, y, z


@rotation("body", "wind", _FLOW)
def body_to_wind(x: Values, y: Values, z: Values, alpha: Values, beta: Values) -> Components:
    """Turn a vector from body to wind axes: through alpha, then through beta."""
    x, y, z, alpha, beta = arrays(x=x, y=y, z=z, alpha=alpha, beta=beta)
    x, z = turn(x, z, alpha)
    x, y = turn(x, y, beta)
    return x, y, z


@rotation("wind", "body", _FLOW)
def wind_to_body(x: Values, y: Values, z: Values, alpha: Values, beta: Values) -> Components:
    """Turn a vector from wind to body axes: the inverse of `body_to_wind`."""
    x, y, z, alpha, beta = arrays(x=x, y=y, z=z, alpha=alpha, beta=beta)
    x, y = turn(x, y, -beta)
    x, z = turn(x, z, -alpha)
    return x, y, z


@page({**_FORCE, **_FLOW}, _DRAG)
def body_to_drag_side_lift(
    x: Values, y: Values, z: Values, alpha: Values = 0.0, beta: Values = 0.0
) -> Components:
    """Drag, side force and lift of an aerodynamic force given in body axes.

    (D, Y, L) = (-x_W, y_W, -z_W), the signs of JSBSim's ``forces/fw*-aero-lbs``; with beta = 0
    they are those of the stability axes, JSBSim's ``forces/fs*-aero-lbs``.
    """
    x, y, z = body_to_wind(x, y, z, alpha, beta)
    return -x, y, -z


@page({**_DRAG, **_FLOW}, _FORCE)
def drag_side_lift_to_body(
    drag: Values, side: Values, lift: Values, alpha: Values = 0.0, beta: Values = 0.0
) -> Components:
    """Body-axis components of drag, side force and lift: inverse of `body_to_drag_side_lift`."""
    drag, side, lift, alpha, beta = arrays(drag=drag, side=side, lift=lift, alpha=alpha, beta=beta)
    x, y = turn(-drag, side, -beta)
    x, z = turn(x, -lift, -alpha)
    return x, y, z


@rotation("local NED", "body", _EULER)
def ned_to_body(
    north: Values, east: Values, down: Values, phi: Values, theta: Values, psi: Values
) -> Components:
    """Turn a vector from local NED to body axes by the 3-2-1 Euler angles.

    Through psi about z (down), then theta about y, then phi about x.
    """
    x, y, z, phi, theta, psi = arrays(
        north=north, east=east, down=down, phi=phi, theta=theta, psi=psi
    )
    x, y = turn(x, y, psi)
    z, x = turn(z, x, theta)
    y, z = turn(y, z, phi)
    return x, y, z


@rotation("body", "local NED", _EULER)
def body_to_ned(
    x: Values, y: Values, z: Values, phi: Values, theta: Values, psi: Values
) -> Components:
    """Turn a vector from body to local NED axes: the inverse of `ned_to_body`."""
    x, y, z, phi, theta, psi = arrays(x=x, y=y, z=z, phi=phi, theta=theta, psi=psi)
    y, z = turn(y, z, -phi)
    z, x = turn(z, x, -theta)
    x, y = turn(x, y, -psi)
    return x, y, z
