"""Fly JSBSim aircraft in PathSim block diagrams.

Every block is imported from here, and so are ``fly``, ``TrimCondition``, ``TrimState`` and the
errors of blocks. Functions are imported from the module of their subject:

- ``air``: the standard atmosphere and airspeeds, such as ``isa`` and ``cas_to_tas``
- ``axes``: axes of the aircraft and of the Earth, ``great_circle``, ``place``
- ``catalogue``: the diagrams, ``load_diagram``, ``find_diagram``
- ``check_cases``: NASA's check cases, ``fly_case``, ``compare``
- ``control``: ``response_quality`` of a step
- ``daveml``: models in DAVE-ML, ``DaveModel``
- ``design``: gains for any aircraft, ``design_gains``, ``design_schedule``
- ``errors``: all errors
- ``flight``: aircraft without a diagram, ``trim``, ``linear_model``, ``level_flight``,
  ``aircraft_names``
- ``gym``: ``make_env``, any diagram as an environment of Gymnasium
- ``linear``: ``LinearModel``, its modes and ``flying_qualities``, figures such as ``bode``
- ``pathview``: ``view``, ``export_script``, ``convert_model``
- ``plots``: figures, such as ``time_histories`` and ``show``
- ``sampling``: ``SampledPlant`` and ``SampledLaw``, bases of sampled blocks of one's own
- ``studies``: ``trim_sweep``, ``run_batch`` and the published studies
- ``tracks``: recorded flights, ``save_tracks``, ``to_frame``
- ``units``: ``convert`` from one unit to another
- ``wind``: models of wind, gusts and turbulence, such as ``dryden_field``

Where jsbsim is not installed (PathView's hosted editor runs in the browser), the aircraft blocks
are absent and all others work.
"""

import logging
import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.3.0"

# without a handler Python's last resort would write JSBSim's warnings to the console
logging.getLogger(__name__).addHandler(logging.NullHandler())

if TYPE_CHECKING:
    from ._public import *
    from .control.holds import *
else:
    # PathSim takes a second to import; the command's --help does not need it

    def __getattr__(name: str) -> Any:
        here, public = globals(), vars(import_module("._public", __name__))
        names = [n for n in public if n[0] != "_"]
        for n, x in {"__all__": names, **{n: public[n] for n in names}}.items():
            # what a test has put here in its place stays
            here.setdefault(n, x)
        if name in here:
            return here[name]
        raise AttributeError(
            f"module {__name__!r} has no attribute {name!r}", name=name, obj=sys.modules[__name__]
        )

    def __dir__() -> list[str]:
        # PathView looks for blocks here
        return sorted(__getattr__("__all__"))
