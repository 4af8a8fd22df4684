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

from collections.abc import Callable, Sequence
from inspect import cleandoc
from typing import Any, TypeVar

import numpy as np

from .._core.checks import arrays, refuse
from .._core.docstrings import filler

Values = float | np.ndarray
Components = tuple[Any, Any, Any]
Rotation = TypeVar("Rotation", bound=Callable[..., Components])

INCHES_PER_FOOT = 12.0

RAISES = """\
Raises
------
ParameterError
    for a value that is not real, shapes that do not broadcast{more}"""

_fill = filler(
    raises_reference=RAISES.format(more=", a reference not of three parts"),
    raises=RAISES.format(more=""),
    flow_angles="""
    alpha, beta : array_like
        angle of attack and sideslip angle, deg
    """,
)

_ANGLES = {
    "alpha": ("alpha", "angle of attack, deg"),
    "beta": ("beta", "sideslip angle, deg, positive with the air from the right"),
    "flow": ("alpha, beta", "angle of attack and sideslip angle, deg"),
    "euler": (
        "phi, theta, psi",
        "roll (right wing down), pitch (nose up) and true heading (clockwise from north), deg",
    ),
}

_ROTATION = """\
{text}

Parameters
----------
{given} : array_like
    components along the {source} axes
{angles} : array_like
    {meaning}

Returns
-------
{found} : float or ndarray
    components along the {target} axes

{raises}"""


def rotation(
    source: str, target: str, angles: str, meaning: str, more: str = ""
) -> Callable[[Rotation], Rotation]:
    """A decorator that completes the docstring of a rotation between axes."""

    def names(axes: str) -> str:
        return "north, east, down" if "NED" in axes else "x, y, z"

    def complete(function: Rotation) -> Rotation:
        if function.__doc__:  # absent under python -OO
            function.__doc__ = _ROTATION.format(
                text=cleandoc(function.__doc__),
                given=names(source),
                source=source,
                angles=angles,
                meaning=meaning,
                found=names(target),
                target=target,
                raises=RAISES.format(more=more),
            )
        return function

    return complete


def turn(a: Any, b: Any, angle: Any) -> tuple[Any, Any]:
    """Components along axes turned by ``angle`` (deg) from a towards b."""
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    return a * c + b * s, b * c - a * s


@_fill
def structural_to_body(x: Values, y: Values, z: Values, reference: Sequence[Values]) -> Components:
    """Body coordinates of a point given in structural coordinates.

    (x_B, y_B, z_B) = (x_ref - x, y - y_ref, z_ref - z) / 12

    Parameters
    ----------
    x, y, z : array_like
        the point: station (aft), buttline (right) and waterline (up), in
    reference : sequence of three array_like
        the point that becomes the origin, in the same axes, in; the centre of gravity
        (``inertia/cg-x-in``, ``cg-y-in``, ``cg-z-in``) for the body axes

    Returns
    -------
    x, y, z : float or ndarray
        forward, right, down of the reference, ft

    %(raises_reference)s
    """
    x, y, z, x0, y0, z0 = arrays(x=x, y=y, z=z, **_reference(reference))
    return (x0 - x) / INCHES_PER_FOOT, (y - y0) / INCHES_PER_FOOT, (z0 - z) / INCHES_PER_FOOT


@_fill
def body_to_structural(x: Values, y: Values, z: Values, reference: Sequence[Values]) -> Components:
    """Structural coordinates of a point given in body coordinates.

    Parameters
    ----------
    x, y, z : array_like
        the point: forward, right, down of the reference, ft
    reference : sequence of three array_like
        origin of the body axes in structural coordinates, in

    Returns
    -------
    x, y, z : float or ndarray
        station (aft), buttline (right) and waterline (up), in

    %(raises_reference)s
    """
    x, y, z, x0, y0, z0 = arrays(x=x, y=y, z=z, **_reference(reference))
    return x0 - INCHES_PER_FOOT * x, y0 + INCHES_PER_FOOT * y, z0 - INCHES_PER_FOOT * z


def _reference(reference: Sequence[Values]) -> dict[str, Values]:
    parts = list(reference) if np.iterable(reference) else []
    if len(parts) != 3:
        refuse(
            "reference",
            reference,
            f"reference must be the three coordinates x, y, z, not {reference!r}",
        )
    return {f"reference[{i}]": part for i, part in enumerate(parts)}


@_fill
def aerodynamic_angles(u: Values, v: Values, w: Values) -> Components:
    """Angle of attack, sideslip angle and airspeed of a velocity relative to the air.

    alpha = atan2(w, u),  beta = atan2(v, sqrt(u^2 + w^2)),  V = sqrt(u^2 + v^2 + w^2)

    Parameters
    ----------
    u, v, w : array_like
        velocity relative to the air in body axes, any unit

    Returns
    -------
    alpha, beta : float or ndarray
        deg; alpha is positive with the air from below, in [-180, 180]; beta is positive with the
        air from the right, in [-90, 90]; both are 0 at rest
    airspeed : float or ndarray
        in the unit of u, v, w

    %(raises)s
    """
    u, v, w = arrays(u=u, v=v, w=w)
    uw = np.hypot(u, w)
    return np.rad2deg(np.arctan2(w, u)), np.rad2deg(np.arctan2(v, uw)), np.hypot(uw, v)


@rotation("body", "stability", *_ANGLES["alpha"])
def body_to_stability(x: Values, y: Values, z: Values, alpha: Values) -> Components:
    """Turn a vector from body to stability axes, about the y axis.

    x_S = x cos alpha + z sin alpha,  y_S = y,  z_S = z cos alpha - x sin alpha
    """
    x, y, z, alpha = arrays(x=x, y=y, z=z, alpha=alpha)
    x, z = turn(x, z, alpha)
    return x, y, z


@rotation("stability", "body", *_ANGLES["alpha"])
def stability_to_body(x: Values, y: Values, z: Values, alpha: Values) -> Components:
    """Turn a vector from stability to body axes: the inverse of `body_to_stability`."""
    x, y, z, alpha = arrays(x=x, y=y, z=z, alpha=alpha)
    x, z = turn(x, z, -alpha)
    return x, y, z


@rotation("stability", "wind", *_ANGLES["beta"])
def stability_to_wind(x: Values, y: Values, z: Values, beta: Values) -> Components:
    """Turn a vector from stability to wind axes, about the z axis.

    x_W = x cos beta + y sin beta,  y_W = y cos beta - x sin beta,  z_W = z
    """
    x, y, z, beta = arrays(x=x, y=y, z=z, beta=beta)
    x, y = turn(x, y, beta)
    return x, y, z


@rotation("wind", "stability", *_ANGLES["beta"])
def wind_to_stability(x: Values, y: Values, z: Values, beta: Values) -> Components:
    """Turn a vector from wind to stability axes: the inverse of `stability_to_wind`."""
    x, y, z, beta = arrays(x=x, y=y, z=z, beta=beta)
    x, y = turn(x, y, -beta)
    return x, y, z


@rotation("body", "wind", *_ANGLES["flow"])
def body_to_wind(x: Values, y: Values, z: Values, alpha: Values, beta: Values) -> Components:
    """Turn a vector from body to wind axes: through alpha, then through beta."""
    x, y, z, alpha, beta = arrays(x=x, y=y, z=z, alpha=alpha, beta=beta)
    x, z = turn(x, z, alpha)
    x, y = turn(x, y, beta)
    return x, y, z


@rotation("wind", "body", *_ANGLES["flow"])
def wind_to_body(x: Values, y: Values, z: Values, alpha: Values, beta: Values) -> Components:
    """Turn a vector from wind to body axes: the inverse of `body_to_wind`."""
    x, y, z, alpha, beta = arrays(x=x, y=y, z=z, alpha=alpha, beta=beta)
    x, y = turn(x, y, -beta)
    x, z = turn(x, z, -alpha)
    return x, y, z


@_fill
def body_to_drag_side_lift(
    x: Values, y: Values, z: Values, alpha: Values = 0.0, beta: Values = 0.0
) -> Components:
    """Drag, side force and lift of an aerodynamic force given in body axes.

    (D, Y, L) = (-x_W, y_W, -z_W), the signs of JSBSim's ``forces/fw*-aero-lbs``.

    Parameters
    ----------
    x, y, z : array_like
        force along the body axes
    alpha, beta : array_like
        angle of attack and sideslip angle, deg; with beta = 0 the result is that of the stability
        axes, JSBSim's ``forces/fs*-aero-lbs``

    Returns
    -------
    drag, side, lift : float or ndarray
        drag positive aft, side force positive to the right, lift positive up

    %(raises)s
    """
    x, y, z = body_to_wind(x, y, z, alpha, beta)
    return -x, y, -z


@_fill
def drag_side_lift_to_body(
    drag: Values, side: Values, lift: Values, alpha: Values = 0.0, beta: Values = 0.0
) -> Components:
    """Body-axis components of drag, side force and lift.

    Parameters
    ----------
    drag, side, lift : array_like
        drag positive aft, side force positive to the right, lift positive up
    %(flow_angles)s

    Returns
    -------
    x, y, z : float or ndarray
        force along the body axes

    %(raises)s
    """
    drag, side, lift, alpha, beta = arrays(drag=drag, side=side, lift=lift, alpha=alpha, beta=beta)
    x, y = turn(-drag, side, -beta)
    x, z = turn(x, -lift, -alpha)
    return x, y, z


@rotation("local NED", "body", *_ANGLES["euler"])
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


@rotation("body", "local NED", *_ANGLES["euler"])
def body_to_ned(
    x: Values, y: Values, z: Values, phi: Values, theta: Values, psi: Values
) -> Components:
    """Turn a vector from body to local NED axes: the inverse of `ned_to_body`."""
    x, y, z, phi, theta, psi = arrays(x=x, y=y, z=z, phi=phi, theta=theta, psi=psi)
    y, z = turn(y, z, -phi)
    z, x = turn(z, x, -theta)
    x, y = turn(x, y, -psi)
    return x, y, z
