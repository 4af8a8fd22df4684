"""Base classes for sampled blocks of your own.

Their subclasses act exactly once at each t_k = k T, for any solver, step and order of blocks.
"""

from ._core.sampling import SampledLaw, SampledPlant

__all__ = ["SampledLaw", "SampledPlant"]
