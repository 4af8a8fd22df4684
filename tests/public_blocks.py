"""All blocks that the package offers, by name."""

from pathsim.blocks import Block

import pathsim_jsbsim_blocks as package

BLOCKS = {
    name: thing
    for name in package.__all__
    if isinstance(thing := getattr(package, name), type) and issubclass(thing, Block)
}
