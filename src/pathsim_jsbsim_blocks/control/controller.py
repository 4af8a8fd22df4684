"""What the controller blocks share: the form of an authority, and sections of their pages."""

from __future__ import annotations

from .._core.docs import filler

# largest increment, or lower and upper
Authority = float | tuple[float, float]

# docstring sections shared by the holds
fill = filler(
    T="""
    T : float
        sample period in s
    """,
    raises="""
    Raises
    ------
    ParameterError
        for an unknown gain table or gain, naming the nearest, and for invalid numbers
    """,
)
