"""DAVE-ML (ANSI/AIAA S-119): models read, evaluated and verified."""

from .model import Check, DaveModel, Variable

__all__ = ["Check", "DaveModel", "Variable"]
