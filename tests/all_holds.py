"""All holds that the package offers, by name."""

from public_blocks import BLOCKS

from pathsim_jsbsim_blocks.control.controller import Hold

HOLDS = {name: block for name, block in BLOCKS.items() if issubclass(block, Hold)}
