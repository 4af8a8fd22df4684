"""Bases of sampled blocks of one's own.

A block that acts at t_k = k T only, once at each, whatever solver, step and order of blocks a
diagram has, is a subclass of one of these.
"""

from ._core.sampling import SampledLaw, SampledPlant

__all__ = ["SampledLaw", "SampledPlant"]
