"""Axes of the aircraft and of the Earth: plain functions, and blocks that wrap them."""

from .aircraft import (
    aerodynamic_angles,
    body_to_drag_side_lift,
    body_to_ned,
    body_to_stability,
    body_to_structural,
    body_to_wind,
    drag_side_lift_to_body,
    ned_to_body,
    stability_to_body,
    stability_to_wind,
    structural_to_body,
    wind_to_body,
    wind_to_stability,
)
from .blocks import BodyToNED, BodyToWind, GeodeticToNED, NEDToBody, WindToBody
from .earth import (
    ecef_to_eci,
    ecef_to_geodetic,
    ecef_to_ned,
    ecef_vector_to_ned,
    eci_to_ecef,
    geodetic_to_ecef,
    geodetic_to_ned,
    ned_to_ecef,
    ned_to_geodetic,
    ned_vector_to_ecef,
)
from .navigation import great_circle, place
