"""Fly JSBSim aircraft in PathSim block diagrams.

Every block is imported from here, and so are ``fly``, ``TrimCondition``, ``TrimState`` and the
errors of blocks. Functions are imported from the module of their subject:

- ``air``: the standard atmosphere and airspeeds, such as ``isa`` and ``cas_to_tas``
- ``axes``: axes of the aircraft and of the Earth, ``great_circle``
- ``catalogue``: the diagrams, ``load_diagram``, ``find_diagram``
- ``check_cases``: NASA's check cases, ``fly_case``, ``compare``
- ``control``: ``PID``, the law of the holds
- ``daveml``: models in DAVE-ML, ``DaveModel``
- ``design``: gains for any aircraft, ``design_gains``, ``design_schedule``
- ``errors``: all errors
- ``flight``: aircraft without a diagram, ``trim``, ``linear_model``, ``level_flight``,
  ``aircraft_names``
- ``gym``: ``make_env``, any diagram as an environment of Gymnasium
- ``linear``: ``LinearModel``, its modes and ``flying_qualities``, figures such as ``pole_map``
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
from importlib.util import find_spec

import lazy_loader

__version__ = "0.5.0"

# without a handler Python's last resort would write JSBSim's warnings to the console
logging.getLogger(__name__).addHandler(logging.NullHandler())

# each name of __init__.pyi is loaded at its first use: the command's --help does not need PathSim,
# which takes a second to import, and a user of one hold needs no aircraft
_load, _, _names = lazy_loader.attach_stub(__name__, __file__)
_SUBJECTS = {name for name in _names if name.islower() and name != "fly"}
_OF_JSBSIM = {"Aircraft", "JSBSimFDM", "LinearAircraft", "TrimCondition", "TrimState"}
_absent = set() if find_spec("jsbsim") else _OF_JSBSIM

# PathView looks for blocks among these
__all__ = sorted(set(_names) - _SUBJECTS - _absent)


def __dir__() -> list[str]:
    return __all__.copy()


def __getattr__(name: str) -> object:
    if name not in _names or name in _absent:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _load(name)
