"""Where the aircraft that jsbsim 1.3 brings trim in level flight, and why the others do not."""

from pathsim_jsbsim_blocks import TrimCondition

_PUSHBACK = (
    "/sim/model/pushback/position-norm",
    "/gear/gear/wow",
    "/sim/model/pushback/ki",
    "/sim/model/pushback/kp",
    "/sim/model/pushback/kd",
)

FLYING = {  # aircraft: (altitude ft, speed KCAS, gear, properties to create at 0)
    "737": (5000, 260, 0.0, ()),
    "787-8": (5000, 298, 0.0, ()),
    "A320": (5000, 281, 0.0, ()),
    "A4": (5000, 194, 0.0, ()),
    "B747": (5000, 268, 0.0, ()),
    "Boeing314": (5000, 147, None, ()),
    "c172p": (5000, 89, None, ()),
    "c172r": (5000, 102, None, ()),
    "c172x": (5000, 103, None, ()),
    "c182": (5000, 98, None, ()),
    "c310": (5000, 135, 0.0, ()),
    "Camel": (5000, 74, None, ()),
    "Concorde": (5000, 280, 0.0, ()),
    "DHC6": (5000, 133, None, ()),
    "f104": (5000, 274, 0.0, ("systems/radar/range",)),
    "f15": (5000, 201, 0.0, ()),
    "f16": (5000, 225, 0.0, ()),
    "F4N": (5000, 239, 0.0, ()),
    "F80C": (5000, 185, 0.0, ()),
    "fokker100": (5000, 231, 0.0, _PUSHBACK),
    "global5000": (5000, 241, 0.0, ()),
    "J3Cub": (5000, 63, None, ()),
    "L17": (5000, 105, 0.0, ("fcs/flaps-pos-deg",)),
    "MD11": (5000, 284, 0.0, ()),
    "OV10": (5000, 193, 0.0, ()),
    "pa28": (2000, 96, None, ()),
    "Short_S23": (2000, 130, None, ()),
    "T37": (5000, 139, 0.0, ()),
    "T38": (5000, 223, 0.0, ()),
    "t6texan2": (5000, 159, 0.0, ()),
    "XB-70": (5000, 192, 0.0, ()),
}

# one of each kind: jet and propeller, one to four engines, properties to create, little climb
FEW = ("737", "c172p", "Concorde", "f16", "fokker100", "J3Cub", "L17", "pa28")

# constant-speed propellers, with which JSBSim's own search may never end
GOVERNED = ("Boeing314", "DHC6", "c182", "c310", "pa28")

NOT_FLYING = {  # aircraft: TrimError.reason, or the other error
    "ah1s": "rotorcraft",
    "B17": "thrust",
    "ball": "thrust",
    "ballx": "thrust",
    "blank": "AircraftError",
    "C130": "thrust",
    "dr1": "no convergence",
    "f22": "no effect",  # its ailerons do not move, in plain JSBSim too
    "F450": "no effect",
    "fokker50": "no effect",
    "J246": "no effect",
    "L410": "no effect",
    "minisgs": "thrust",
    "mk82": "thrust",
    "p51d": "no effect",
    "paraglider": "no effect",
    "pc7": "thrust",
    "pogo-jsbsim": "thrust",
    "Pterosaur": "alpha limit",
    "SGS": "thrust",
    "sgs126": "thrust",
    "sgs233": "thrust",
    "Shuttle": "thrust",
    "Submarine_Scout": "thrust",
    "weather-balloon": "thrust",
    "wrightFlyer1903": "thrust",
    "X15": "fuel",
    "x24b": "no effect",
    "ZLT-NT": "no effect",
}

# trimmed by the Newton search only: the mode, KCAS
BY_NEWTON = {
    "B17": ("glide", 166),
    "C130": ("glide", 163),
    "dr1": ("full", 59),
    "fokker50": ("glide", 177),
    "p51d": ("glide", 160),
    "pc7": ("full", 136),
    "pogo-jsbsim": ("full", 167),
    "SGS": ("glide", 50),
    "sgs126": ("glide", 45),
    "sgs233": ("glide", 57),
    "Shuttle": ("glide", 350),
    "X15": ("glide", 232),
    "x24b": ("glide", 350),
}


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
        return {
            "aircraft_model": aircraft,
            "condition": TrimCondition(altitude=altitude, speed=speed, gear=gear),
            "create": dict.fromkeys(create, 0.0),
            "setup": {"propulsion/fuel_freeze": 1.0},
        }
    return {
        "aircraft_model": aircraft,
        "trim_altitude": altitude,
        "trim_airspeed": speed,
        "gear": gear,
        "create": dict.fromkeys(create, 0.0),
        "setup": {"propulsion/fuel_freeze": 1.0},
    }
