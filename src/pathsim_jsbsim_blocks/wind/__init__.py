"""Wind, gusts and turbulence: plain functions, and blocks for the wind ports of an aircraft."""

from .gust import design_gust_velocity
from .microburst import oseguera_bowles
from .shear import logarithmic_profile
from .turbulence import Dryden, Field, dryden_field

__all__ = [
    "Dryden",
    "Field",
    "design_gust_velocity",
    "dryden_field",
    "logarithmic_profile",
    "oseguera_bowles",
]
