"""Diagram scripts in PathView and back.

PathView (the package ``pathview``) is needed only when one of these functions is called.
"""

from ._view import view
from .convert import convert_model
from .export import export_script

__all__ = ["convert_model", "export_script", "view"]
