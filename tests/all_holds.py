"""All holds that the package offers, by name."""

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks.control.controller import Hold

HOLDS = {
    name: hold
    for name in package.__all__
    if isinstance(hold := getattr(package, name), type) and issubclass(hold, Hold)
}
