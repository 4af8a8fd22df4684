"""Where the aircraft that jsbsim 1.3 brings trim in level flight, and why the others do not."""

import csv
from pathlib import Path

from pathsim_jsbsim_blocks import TrimCondition

# aircraft: (altitude ft, speed KCAS, gear, properties to create at 0)
FLYING = {}
# aircraft: TrimError.reason, or the other error
NOT_FLYING = {}
# trimmed by the Newton search only: the mode, KCAS
BY_NEWTON = {}

with (Path(__file__).parent / "data" / "fleet.csv").open(newline="") as _file:
    for _row in csv.DictReader(_file):
        _name = _row["aircraft"]
        if _row["why_not"]:
            NOT_FLYING[_name] = _row["why_not"]
        else:
            _gear = float(_row["gear"]) if _row["gear"] else None
            _place = int(_row["altitude_ft"]), int(_row["speed_kcas"])
            FLYING[_name] = (*_place, _gear, tuple(_row["create_at_0"].split()))
        if _row["newton_mode"]:
            BY_NEWTON[_name] = _row["newton_mode"], int(_row["newton_speed_kcas"])

# one of each kind: jet and propeller, one to four engines, properties to create, little climb
FEW = ("737", "c172p", "Concorde", "f16", "fokker100", "J3Cub", "L17", "pa28")

# constant-speed propellers, with which JSBSim's own search may never end
GOVERNED = ("Boeing314", "DHC6", "c182", "c310", "pa28")


def setup(aircraft):
    """Properties as a plain JSBSim loop writes them between loading and run_ic.

    The fuel is frozen: Concorde would run its feed tanks dry in 20 s.
    """
    _, _, gear, create = FLYING[aircraft]
    retracted = {} if gear is None else {"gear/gear-cmd-norm": gear, "gear/gear-pos-norm": gear}
    return {**dict.fromkeys(create, 0.0), **retracted, "propulsion/fuel_freeze": 1.0}


def keywords(aircraft):
    """The same flight as keywords of JSBSimFDM."""
    altitude, speed, gear, create = FLYING[aircraft]
    if aircraft in GOVERNED:
        place = {"condition": TrimCondition(altitude=altitude, speed=speed, gear=gear)}
    else:
        place = {"trim_altitude": altitude, "trim_airspeed": speed, "gear": gear}
    created, frozen = dict.fromkeys(create, 0.0), {"propulsion/fuel_freeze": 1.0}
    return {"aircraft_model": aircraft, **place, "create": created, "setup": frozen}


def flight(aircraft, **changes):
    """The same flight as ``condition`` and ``create``, or one off it."""
    altitude, speed, gear, create = FLYING[aircraft]
    values = {"altitude": altitude, "speed": speed, "gear": gear, **changes}
    condition = TrimCondition(**values, setup={"propulsion/fuel_freeze": 1.0})
    return {"condition": condition, "create": dict.fromkeys(create, 0.0)}
