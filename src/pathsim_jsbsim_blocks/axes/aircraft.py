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

Angles are in degrees:

- ``alpha``, angle of attack, positive with the air from below
- ``beta``, sideslip angle, positive with the air from the right
- ``phi``, ``theta``, ``psi``: roll (right wing down), pitch (nose up), true heading (from north,
  clockwise)

A vector is passed as three components and returned as a tuple of three, numbers or arrays. All
arguments of a call broadcast to one shape, which the results have; numbers give floats. A rotation
keeps the unit; NaN and infinite angles give NaN. Each function and its inverse cancel to rounding.
A ParameterError is raised for values that are not real numbers, and shapes that do not broadcast.

References
----------
JSBSim Reference Manual, Concepts, Frames of Reference.
Stevens, Lewis, Johnson: Aircraft Control and Simulation, 3rd ed., Wiley 2016, chapters 1 and 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .._core.checks import arrays, must_be

Values = float | np.ndarray
Components = tuple[Any, Any, Any]

INCHES_PER_FOOT = 12.0


def turn(a: Any, b: Any, angle: Any) -> tuple[Any, Any]:
    """Components along axes turned by ``angle`` (deg) from a towards b."""
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    return a * c + b * s, b * c - a * s


def structural_to_body(x: Values, y: Values, z: Values, reference: Sequence[Values]) -> Components:
    """Body coordinates (ft) of a point given in structural coordinates (in).

    ``reference`` is the point that becomes the origin, x, y and z in structural axes, in: for the
    body axes the centre of gravity (``inertia/cg-x-in``, ``cg-y-in``, ``cg-z-in``).

    (x_B, y_B, z_B) = (x_ref - x, y - y_ref, z_ref - z) / 12
    """
    x, y, z, x0, y0, z0 = arrays(x=x, y=y, z=z, **_reference(reference))
    return (x0 - x) / INCHES_PER_FOOT, (y - y0) / INCHES_PER_FOOT, (z0 - z) / INCHES_PER_FOOT


def body_to_structural(x: Values, y: Values, z: Values, reference: Sequence[Values]) -> Components:
    """Structural coordinates (in) of a point given in body coordinates (ft).

    The inverse of `structural_to_body`, with the same ``reference``.
    """
    x, y, z, x0, y0, z0 = arrays(x=x, y=y, z=z, **_reference(reference))
    return x0 - INCHES_PER_FOOT * x, y0 + INCHES_PER_FOOT * y, z0 - INCHES_PER_FOOT * z


def _reference(reference: Sequence[Values]) -> dict[str, Values]:
    parts = list(reference) if np.iterable(reference) else []
    if len(parts) != 3:
        must_be("reference", reference, "the three coordinates x, y, z")
    return {f"reference[{i}]": part for i, part in enumerate(parts)}


def aerodynamic_angles(u: Values, v: Values, w: Values) -> Components:
    """Alpha and beta (deg) and the airspeed of a velocity u, v, w relative to the air, body axes.

    alpha = atan2(w, u) in [-180, 180],  beta = atan2(v, sqrt(u^2 + w^2)) in [-90, 90],
    V = sqrt(u^2 + v^2 + w^2); all are 0 at rest.
    """
    u, v, w = arrays(u=u, v=v, w=w)
    uw = np.hypot(u, w)
    return np.rad2deg(np.arctan2(w, u)), np.rad2deg(np.arctan2(v, uw)), np.hypot(uw, v)


def body_to_stability(x: Values, y: Values, z: Values, alpha: Values) -> Components:
    """Turn a vector from body to stability axes, about the y axis by alpha (deg).

    x_S = x cos alpha + z sin alpha,  y_S = y,  z_S = z cos alpha - x sin alpha
    """
    x, y, z, alpha = arrays(x=x, y=y, z=z, alpha=alpha)
    x, z = turn(x, z, alpha)
    return x, y, z


def stability_to_body(x: Values, y: Values, z: Values, alpha: Values) -> Components:
    """Turn a vector from stability to body axes: the inverse of `body_to_stability`."""
    x, y, z, alpha = arrays(x=x, y=y, z=z, alpha=alpha)
    x, z = turn(x, z, -alpha)
    return x, y, z


def stability_to_wind(x: Values, y: Values, z: Values, beta: Values) -> Components:
    """Turn a vector from stability to wind axes, about the z axis by beta (deg).

    x_W = x cos beta + y sin beta,  y_W = y cos beta - x sin beta,  z_W = z
    """
    x, y, z, beta = arrays(x=x, y=y, z=z, beta=beta)
    x, y = turn(x, y, beta)
    return x, y, z


def wind_to_stability(x: Values, y: Values, z: Values, beta: Values) -> Components:
    """Turn a vector from wind to stability axes: the inverse of `stability_to_wind`."""
    x, y, z, beta = arrays(x=x, y=y, z=z, beta=beta)
    x, y = turn(x, y, -beta)
    return x, y, z


def body_to_wind(x: Values, y: Values, z: Values, alpha: Values, beta: Values) -> Components:
    """Turn a vector from body to wind axes: by alpha about y, then by beta about z (deg)."""
    x, y, z, alpha, beta = arrays(x=x, y=y, z=z, alpha=alpha, beta=beta)
    x, z = turn(x, z, alpha)
    x, y = turn(x, y, beta)
    return x, y, z


def wind_to_body(x: Values, y: Values, z: Values, alpha: Values, beta: Values) -> Components:
    """Turn a vector from wind to body axes: the inverse of `body_to_wind`."""
    x, y, z, alpha, beta = arrays(x=x, y=y, z=z, alpha=alpha, beta=beta)
    x, y = turn(x, y, -beta)
    x, z = turn(x, z, -alpha)
    return x, y, z


def body_to_drag_side_lift(
    x: Values, y: Values, z: Values, alpha: Values = 0.0, beta: Values = 0.0
) -> Components:
    """Drag, side force and lift of an aerodynamic force given in body axes.

    Drag is positive aft, the side force to the right, lift up:
    (D, Y, L) = (-x_W, y_W, -z_W), the signs of JSBSim's ``forces/fw*-aero-lbs``; with beta = 0
    they are those of the stability axes, JSBSim's ``forces/fs*-aero-lbs``.
    """
    x, y, z = body_to_wind(x, y, z, alpha, beta)
    return -x, y, -z


def drag_side_lift_to_body(
    drag: Values, side: Values, lift: Values, alpha: Values = 0.0, beta: Values = 0.0
) -> Components:
    """Body-axis components of drag, side force and lift: inverse of `body_to_drag_side_lift`."""
    drag, side, lift, alpha, beta = arrays(drag=drag, side=side, lift=lift, alpha=alpha, beta=beta)
    x, y = turn(-drag, side, -beta)
    x, z = turn(x, -lift, -alpha)
    return x, y, z


def ned_to_body(
    north: Values, east: Values, down: Values, phi: Values, theta: Values, psi: Values
) -> Components:
    """Turn a vector from local NED to body axes by the 3-2-1 Euler angles.

    By psi about z (down), then theta about y, then phi about x, deg.
    """
    x, y, z, phi, theta, psi = arrays(
        north=north, east=east, down=down, phi=phi, theta=theta, psi=psi
    )
    x, y = turn(x, y, psi)
    z, x = turn(z, x, theta)
    y, z = turn(y, z, phi)
    return x, y, z


def body_to_ned(
    x: Values, y: Values, z: Values, phi: Values, theta: Values, psi: Values
) -> Components:
    """Turn a vector from body to local NED axes: the inverse of `ned_to_body`."""
    x, y, z, phi, theta, psi = arrays(x=x, y=y, z=z, phi=phi, theta=theta, psi=psi)
    y, z = turn(y, z, -phi)
    z, x = turn(z, x, -theta)
    x, y = turn(x, y, -psi)
    return x, y, z
