"""Fly JSBSim aircraft in PathSim block diagrams.

Every block can be imported from here. Where jsbsim is not installed (PathView's hosted editor runs
in the browser), the aircraft blocks are absent and all others work.
"""

import logging
import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

# without a handler Python's last resort would write JSBSim's warnings to the console
logging.getLogger(__name__).addHandler(logging.NullHandler())

if TYPE_CHECKING:
    from ._public import *
    from .control.holds import *
else:
    # PathSim takes a second to import; the command's --help does not need it

    def __getattr__(name: str) -> Any:
        public = import_module("._public", __name__)
        here = globals()
        for n in ("__all__", *public.__all__):
            # what a test has put here in its place stays
            here.setdefault(n, getattr(public, n))
        if name in here:
            return here[name]
        raise AttributeError(
            f"module {__name__!r} has no attribute {name!r}", name=name, obj=sys.modules[__name__]
        )

    def __dir__() -> list[str]:
        # PathView looks for blocks here
        return sorted(__getattr__("__all__"))
