"""DAVE-ML (ANSI/AIAA S-119): models read, evaluated, verified, and written for JSBSim."""

from .aircraft import write_aircraft
from .model import Check, DaveModel, Variable

__all__ = ["Check", "DaveModel", "Variable", "write_aircraft"]
