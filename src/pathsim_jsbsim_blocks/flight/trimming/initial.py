"""A condition as JSBSim's initial conditions, and the present flight as a condition."""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import jsbsim

from ..._core.aircraft_ports import property_of
from ..._core.callers import warn_user
from ..._core.checks import mapping, one_of, refuse
from ..airframe import Airframe
from ..console import failure_of
from ..model_xml import Engine
from ..writable import ENGINE_RUNS, cannot_stop
from .condition import TrimCondition
from .state import TrimState, read_state

_HEIGHT_BEFORE_SETTLING = 5.0  # ft above ground, where the ground trim starts

# s of held flight, in which a model's pumps fill the tanks of its engines (Short_S23: 0.1)
_FILLING = 2.0

# written first, because altitudes refer to the terrain at this place
_PLACE = ("ic/lat-", "ic/long-", "ic/terrain-")

# properties that a condition sets -> its field
_FIELDS = {
    r"(ic|position)/h-(sl|agl)-.*": "altitude",
    r"ic/v[cegt]-kts|ic/v[gt]-fps|velocities/v[cegt]-.*": "speed",
    r"ic/mach": "mach",
    r"ic/([uvw]|v[ned])-fps": "speed, gamma and heading",
    r"ic/(gamma|theta|alpha)-(deg|rad)|ic/roc-fp[ms]": "gamma",
    r"ic/phi-(deg|rad)": "bank",
    r"ic/psi-true-(deg|rad)": "heading",
    r"ic/beta-(deg|rad)": "beta",
    r"ic/vw-.*|atmosphere/(wind-.*|psiw-rad)": "wind_north and wind_east",
    r"ic/[pqr]-rad_sec": "mode",
    r"ic/terrain-elevation-ft": "altitude",
    r"position/lat-.*": "latitude",
    r"position/long-.*": "longitude",
    r"fcs/throttle-cmd-norm.*": "throttle",
    r"fcs/flap-.*": "flaps",
    r"gear/gear-.*": "gear",
}

# relative tolerance of a value that is read back
_ROUNDING = 1e-6


def properties(
    airframe: Airframe, condition: TrimCondition, setup: Mapping[str, float] | None
) -> dict[str, float]:
    """The properties of a condition, then those of ``setup``."""
    last = mapping("setup", setup)
    first = {**_loading(condition), **condition.setup}
    return {**{n: v for n, v in first.items() if n not in last}, **last}


def read_back(
    airframe: Airframe,
    condition: TrimCondition,
    setup: Mapping[str, float] | None,
    free: Sequence[str],
) -> None:
    """Refuse properties of a setup that have another value after initialisation and trim.

    Commands that the search has solved for, with the unknowns ``free``, are exempt, and so are
    properties that cannot be read.
    """
    # the elevator takes the place of a pitch trim without effect
    unknowns = "|".join({*free, "pitch_trim"} if free else ()).replace("_", "-")
    for name, value in {**condition.setup, **mapping("setup", setup)}.items():
        path = airframe.canonical(name)
        is_unknown = re.fullmatch(rf"fcs/({unknowns})-cmd-norm(\[\d+\])?", path)
        # tanks were checked when written, and engines may have run since
        if is_unknown or path.endswith("/contents-lbs") or "r" not in airframe.access(name):
            continue
        # JSBSim keeps the rates of the initial conditions, which a trim does not have
        result = airframe.reader(re.sub(r"ic/([pqr]-rad_sec)", r"velocities/\1", path))()
        if not math.isclose(result, value, rel_tol=_ROUNDING, abs_tol=1e-3 * _ROUNDING):
            fields = [field for pattern, field in _FIELDS.items() if re.fullmatch(pattern, path)]
            instead = f"set {fields[0]} of the condition" if fields else "write it after the trim"
            if path.startswith("ic/") and condition.mode != "none":
                instead += ", or start without a trim (mode='none')"
            why = f"setup[{name!r}] is overwritten: set to {value!r}, it is {result:.7g} after "
            refuse("setup", name, f"{why}initialisation and trim; {instead}")


def _loading(condition: TrimCondition) -> dict[str, float]:
    """Mass, configuration, place and trim limits as properties."""
    payload, fuel = dict(condition.payload), dict(condition.fuel)  # type: ignore[arg-type]
    weights = {f"inertia/pointmass-weight-lbs[{i}]": w for i, w in payload.items()}
    weights |= {f"propulsion/tank[{i}]/contents-lbs": w for i, w in fuel.items()}
    for value, *names in (
        (condition.gear, "gear/gear-cmd-norm", "gear/gear-pos-norm"),
        (condition.flaps, "fcs/flap-cmd-norm", "fcs/flap-pos-norm"),
        (condition.latitude, "ic/lat-geod-deg"),
        (condition.longitude, "ic/long-gc-deg"),
    ):
        if value is not None:
            weights |= dict.fromkeys(names, value)
    for end in ("min", "max"):
        if (alpha := getattr(condition, f"alpha_{end}")) is not None:
            weights[f"aero/alpha-{end}-rad"] = math.radians(alpha)
    return weights


def engines_off(
    airframe: Airframe, condition: TrimCondition, settings: Mapping[str, float]
) -> frozenset[int]:
    """The engines that do not run, from the condition or the properties written before the trim."""
    engines = set(range(airframe.engines))
    off = engines if condition.engines_off == "all" else set(condition.engines_off)
    if not off <= engines:
        why = f"engines_off={condition.engines_off!r}: aircraft {airframe.aircraft!r} has "
        why += f"{len(engines)} engine{'s' * (len(engines) != 1)}, numbered from 0"
        refuse("engines_off", condition.engines_off, why)
    for name, value in settings.items():
        number = ENGINE_RUNS.fullmatch(name)
        if number and value == 0.0:
            off = off | {int(number[1] or 0)}
        elif name == "propulsion/set-running" and value >= 0.0:
            # JSBSim starts only this engine
            off = off | engines - {int(value)}
    for engine in airframe.engine_list if off else ():
        if engine.number in off and engine.follows_throttle:
            refuse("engines_off", condition.engines_off, cannot_stop(engine))
    return frozenset(off)  # type: ignore[arg-type]


def is_initial(name: str) -> bool:
    """Whether a property is an initial condition other than the place, which is written first."""
    return name.startswith("ic/") and not name.startswith(_PLACE)


def initialise(
    airframe: Airframe,
    condition: TrimCondition,
    heading: float,
    initial: Mapping[str, float] = MappingProxyType({}),
) -> None:
    """Write a condition as initial conditions, ``initial`` last, and initialise the model."""
    fdm = airframe.fdm
    on_ground = condition.mode == "ground"

    def put(name: str, value: float) -> None:
        # write only changes: each write moves other initial conditions by a rounding error
        if fdm[name] != value:
            fdm[name] = value

    # some models trim only if the engines are started after run_ic, others only if before it
    with airframe.governors_off():
        airframe.start_engines()
    if fdm["ic/vw-mag-fps"]:
        # the wind of the previous trim would turn the nose
        fdm["ic/vw-mag-fps"] = fdm["ic/vc-kts"] = 0.0
    if fdm["ic/w-fps"] and not fdm["ic/u-fps"]:  # from a setup; JSBSim would lose the next speed
        fdm["ic/u-fps"] = fdm["ic/w-fps"]
    put("ic/phi-deg", 0.0)
    put("ic/psi-true-deg", heading)
    if on_ground:
        put("ic/terrain-elevation-ft", condition.altitude)
        fdm["ic/h-agl-ft"] = _HEIGHT_BEFORE_SETTLING
    else:
        fdm["ic/h-sl-ft"] = condition.altitude
    # the order matters: setting altitude or speed zeroes gamma
    put("ic/beta-deg", 0.0)
    if condition.mach is not None and not on_ground:
        fdm["ic/mach"] = condition.mach
    else:
        fdm["ic/vc-kts"] = 0.0 if on_ground else condition.speed
    fdm["ic/gamma-deg"] = 0.0 if on_ground else condition.gamma
    if condition.wind_north or condition.wind_east:
        # JSBSim subtracts a wind set before the speed from the ground speed: set the speed in still
        # air, add the wind to the ground velocity, and set the wind itself last
        if not on_ground:
            fdm["ic/vn-fps"] = fdm["ic/vn-fps"] + condition.wind_north
            fdm["ic/ve-fps"] = fdm["ic/ve-fps"] + condition.wind_east
        fdm["ic/vw-mag-fps"] = math.hypot(condition.wind_north, condition.wind_east)
        fdm["ic/vw-dir-deg"] = math.degrees(math.atan2(condition.wind_east, condition.wind_north))
        if on_ground:
            # otherwise it settles on the gear at constant calibrated airspeed, not at rest
            fdm["ic/vn-fps"] = fdm["ic/ve-fps"] = fdm["ic/vd-fps"] = 0.0
    put("ic/phi-deg", condition.bank)
    if condition.mode == "pull-up":
        fdm["ic/targetNlf"] = condition.load_factor
    airframe.write(initial, "setup")
    with airframe.governors_off():
        airframe.run_ic()
        airframe.start_engines()


def start_from_file(airframe: Airframe, setup: Mapping[str, float] | None) -> TrimState:
    """Initialise an airframe as JSBSim does with its script or reset file, which may ask to trim.

    ``setup`` is written first. A trim that fails is a warning, and the aircraft flies untrimmed, as
    by JSBSim's command line.
    """
    airframe.write(setup, "setup")
    # JSBSim writes a row before the first step
    airframe.start_outputs()
    airframe.run_ic()
    fdm = airframe.fdm
    mode = fdm.get_ic().trim_requested()
    if mode != jsbsim.TrimMode.NONE and (why := failure_of(jsbsim.FGTrim(fdm, mode).do_trim)):
        warn_user(f"{airframe.start}: the trim at the start failed: {why}")
    altitude, speed = fdm[property_of("h")], fdm[property_of("vc")]
    condition = TrimCondition(altitude, speed, mode="none")
    read_back(airframe, condition, setup, ())
    return read_state(airframe, condition)


def fill(airframe: Airframe) -> list[Engine]:
    """Engines without fuel after the model's own fuel system has had time to supply it.

    Meanwhile frozen fuel keeps the engines and their pumps running.
    """
    if not airframe.without_fuel():
        return []
    with airframe.held():
        for _ in range(round(_FILLING / airframe.dt)):
            airframe.fdm.run()
            if not airframe.without_fuel():
                break
    return airframe.without_fuel()


# properties whose present values replace those of the original setup
_PRESENT = re.compile(
    r"ic/(?!terrain)|propulsion/(tank.*/contents-lbs|(engine.*/)?set-running)$"
    r"|inertia/pointmass-weight|(gear/gear|fcs/flap)-(cmd|pos)-norm$"
)


def present_condition(
    airframe: Airframe,
    condition: TrimCondition,
    setup: Mapping[str, float] | None,
    changes: Mapping[str, Any],
) -> TrimCondition:
    """The present flight as a condition with changes; ``condition`` is that of its start."""
    names = [field.name for field in dataclasses.fields(TrimCondition)]
    for name in changes:
        one_of("change", name, names)
    fdm, state = airframe.fdm, read_state(airframe, condition)
    # at rest it has no path
    climb = fdm[property_of("hdot")] / state.tas if state.tas else 0.0
    mode = "full" if condition.mode in ("ground", "none", "pull-up") else condition.mode
    values = {**condition.setup, **mapping("setup", setup)}
    masses = map("inertia/pointmass-weight-lbs[{}]".format, itertools.count())
    present: dict[str, Any] = {
        "altitude": state.altitude,
        "speed": state.speed,
        "mach": None,
        # relative to the air, unlike JSBSim's own
        "gamma": math.degrees(math.asin(min(max(climb, -1.0), 1.0))),
        "heading": state.psi,
        "bank": state.phi if changes.get("mode", mode) == "turn" else 0.0,
        "load_factor": 1.0,
        "mode": mode,
        "gear": min(max(state.gear, 0.0), 1.0),
        "flaps": min(max(state.flaps, 0.0), 1.0),
        # rounded, because still air has rounding errors
        "wind_north": round(fdm["atmosphere/total-wind-north-fps"], 9) + 0.0,
        "wind_east": round(fdm["atmosphere/total-wind-east-fps"], 9) + 0.0,
        "payload": [fdm[name] for name in itertools.takewhile(airframe.has, masses)],
        "fuel": [fdm[name] for name in airframe.tanks],
        "latitude": fdm[property_of("lat")],
        "longitude": fdm[property_of("lon")],
        "engines_off": [i for i, runs in airframe.marks().items() if not runs],
        "setup": {n: v for n, v in values.items() if not _PRESENT.match(airframe.canonical(n))},
    }
    return dataclasses.replace(condition, **{**present, **changes})
