"""Trim an aircraft: `TrimCondition` in, `TrimState` out. The only place that trims."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import jsbsim
import numpy as np

from .._core.callers import warn_user
from .._core.checks import flag, mapping, number, one_of
from .._core.extras import required
from ..errors import AircraftError, ParameterError, TrimError
from ._newton import EFFORT, Found, Search, Seed, alpha_range
from .airframe import ENGINE_RUNS, Airframe, has_retractable_gear
from .channels import ALMOST_NORTH
from .condition import MODES, TrimCondition, check_condition
from .console import messages
from .rehearsal import Outcome, rehearse

if TYPE_CHECKING:
    import pandas

_HEIGHT_BEFORE_SETTLING = 5.0  # ft above ground, where the ground trim starts

# an altitude is above the place that is set
_PLACE = ("ic/lat-", "ic/long-", "ic/terrain-")

_NEAR_GROUND = 200.0  # ft, more than any wheel lies below its aircraft

# s of CPU time; a search that finds its trim takes less than half a second
_LONGEST_SEARCH = 10

# the axis that JSBSim reports as not trimmable -> the control that ran out (FGTrim::SetMode)
_LIMITS = {
    "udot": "thrust",
    "vdot": "bank",
    "wdot": "alpha limit",
    "pdot": "aileron",
    "qdot": "elevator",
    "rdot": "rudder",
}
_LIMITS_OF_MODES = {
    "turn": {**_LIMITS, "vdot": "sideslip"},
    "pull-up": {**_LIMITS, "nlf": "alpha limit", "hmgt": "sideslip"},
    "ground": {"wdot": "height", "qdot": "pitch angle", "pdot": "bank"},
}

# the same by what the Newton search moves
_REASONS = {
    "throttle": "thrust",
    "alpha": "alpha limit",
    "pitch_trim": "elevator",
    "elevator": "elevator",
    "phi": "bank",
    "beta": "sideslip",
    "gamma": "path angle",
}
_ANGLES = ("alpha", "phi", "beta", "gamma")

# largest relative difference between two initialisations of the same state
_ROUNDING = 1e-12

# how far an aircraft in steady flight may be from its trim, controls fixed
_STEADY = {"height": 20.0, "speed": 6.0, "bank": 10.0}  # ft, kt, deg

# what a short flight may show of an equilibrium: s; ft/s2 and rad/s2
_SHORT_FLIGHT = 0.25
_STAYS = {"vdot": 0.1, "pdot": 0.02, "qdot": 0.02, "rdot": 0.02}

# of a surface's travel or of the weight in thrust: what is named as the cause moves by more
_SMALL_MOTION = 0.01

# KCAS, above which hardly any landing gear may be down
_FAST_FOR_GEAR = 200.0


class Drift(NamedTuple):
    """How far an aircraft is from its trim after a flight with controls fixed.

    Attributes
    ----------
    duration : float
        s of flight
    height : float
        ft above the trimmed path
    speed : float
        kt calibrated above the trimmed speed
    bank : float
        deg to the right of the trimmed bank
    """

    duration: float
    height: float
    speed: float
    bank: float


# units of the fields of a condition and of a state, in the column order of study tables
UNITS = {
    "altitude": "ft",
    "speed": "KCAS",
    "mach": "",
    "tas": "ft/s",
    **dict.fromkeys(("gamma", "alpha", "beta", "theta", "phi", "psi"), "deg"),
    "throttle": "norm",
    "thrust": "lbf",
    "pitch_trim": "norm",
    "elevator_rad": "rad",
    "elevator_norm": "norm",
    **dict.fromkeys(("elevator", "aileron", "rudder"), "cmd norm"),
    **dict.fromkeys(("udot", "vdot", "wdot"), "ft/s2"),
    **dict.fromkeys(("pdot", "qdot", "rdot"), "rad/s2"),
    "weight": "lb",
    **dict.fromkeys(("cg_x", "cg_y", "cg_z", "empty_cg_x"), "in"),
    **dict.fromkeys(("heading", "bank", "alpha_min", "alpha_max"), "deg"),
    "load_factor": "g",
    "mode": "",
    "gear": "norm",
    "flaps": "norm",
    **dict.fromkeys(("wind_north", "wind_east"), "ft/s"),
    "payload": "lb",
    "fuel": "lb",
    "engines_off": "",
    **dict.fromkeys(("latitude", "longitude"), "deg"),
    **dict.fromkeys(("p", "q", "r"), "deg/s"),
    "nz": "g",
}


@dataclass(frozen=True)
class TrimState:
    """The trimmed state found, with its residuals.

    Attributes
    ----------
    aircraft : str
        the model's name
    condition : TrimCondition
        the requested condition
    altitude, speed, mach, tas : float
        ft above mean sea level, KCAS, Mach number, true airspeed in ft/s
    alpha, beta, theta, phi, psi, gamma : float
        deg; psi is in [0, 360)
    throttle : tuple[float, ...]
        throttle command of each engine, 0 to 1
    thrust : float
        lbf, sum of the engines
    pitch_trim, elevator, aileron, rudder : float
        commands, -1 to 1; the trim uses the pitch trim for pitch, elevator stays 0 (but the Newton
        search uses it where a model has no pitch trim)
    elevator_rad, elevator_norm : float
        position of the elevator in rad and as a fraction of its travel (0 if the model has none)
    udot, vdot, wdot : float
        residual body accelerations in ft/s2
    pdot, qdot, rdot : float
        residual angular accelerations in rad/s2
    weight : float
        lb
    cg_x, cg_y, cg_z : float
        centre of gravity in inches, structural axes
    p, q, r : float
        body rates in deg/s
    nz : float
        load factor in g, +1 in level flight
    gear, flaps : float
        positions, 0 (up) to 1 (down)
    free : tuple[str, ...]
        the quantities that the search has moved; the others were given
    drift : Drift or None
        how far it is from its trim after a flight with controls fixed, if `trim` was asked to fly
    """

    aircraft: str
    condition: TrimCondition
    altitude: float
    speed: float
    mach: float
    tas: float
    alpha: float
    beta: float
    theta: float
    phi: float
    psi: float
    gamma: float
    throttle: tuple[float, ...]
    thrust: float
    pitch_trim: float
    elevator: float
    aileron: float
    rudder: float
    elevator_rad: float
    elevator_norm: float
    udot: float
    vdot: float
    wdot: float
    pdot: float
    qdot: float
    rdot: float
    weight: float
    cg_x: float
    cg_y: float
    cg_z: float
    p: float
    q: float
    r: float
    nz: float
    gear: float
    flaps: float
    free: tuple[str, ...]
    drift: Drift | None = None

    def __str__(self) -> str:
        """The state as a table: name, value and unit in each line."""
        rows: dict[str, Any] = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        units = UNITS
        if math.isfinite(self.turn_radius):
            rows |= {"turn_rate": self.turn_rate, "turn_radius": self.turn_radius}
            units = {**UNITS, "turn_rate": "deg/s", "turn_radius": "ft"}
        lines = [f"{self.aircraft}: {self.condition}"]
        for name, value in rows.items():
            values = value if isinstance(value, tuple) else (value,)
            if name in units and values:
                # adding 0 turns -0.0 into 0.0
                shown = [round(x, 6) + 0.0 for x in values]
                numbers = "".join(f"{x % 360.0 if name == 'psi' else x:14.6f}" for x in shown)
                degrees = f" ({math.degrees(value):.4f} deg)" if units[name] == "rad" else ""
                lines.append(f"  {name:<13}{numbers} {units[name]}{degrees}".rstrip())
        if self.free:
            lines.append(f"  {'free':<13} {', '.join(self.free)}")
        if self.drift is not None:
            lines.append(
                f"  {'steady' if self.steady else 'not steady'}: after {self.drift.duration:g} s "
                f"with controls fixed {self.drift.height:+.2f} ft, {self.drift.speed:+.2f} kt, "
                f"{self.drift.bank:+.2f} deg of bank"
            )
        return "\n".join(lines)

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """Show the table as the last line of a cell in IPython and Jupyter too."""
        printer.text(str(self))

    def to_dict(self) -> dict[str, float]:
        """The state's numbers by name; those of each engine as ``throttle[0]``."""
        found: dict[str, float] = {}
        for name in (n for n in UNITS if n in vars(self)):
            value = getattr(self, name)
            if isinstance(value, tuple):
                found |= {f"{name}[{i}]": x for i, x in enumerate(value)}
            else:
                found[name] = value
        return found

    def to_frame(self) -> pandas.DataFrame:
        """The state as a pandas table: value and unit by name.

        Raises
        ------
        MissingExtraError
            without pandas
        """
        pandas = required("pandas", "tracks")
        numbers = self.to_dict()
        units = [UNITS[name.partition("[")[0]] for name in numbers]
        return pandas.DataFrame({"value": numbers.values(), "unit": units}, index=list(numbers))

    @property
    def steady(self) -> bool | None:
        """Whether the drift is within 20 ft, 6 kt and 10 deg; None without a drift."""
        if self.drift is None:
            return None
        limits = _STEADY.items()
        return all(abs(getattr(self.drift, name)) <= limit for name, limit in limits)

    @property
    def turn_rate(self) -> float:
        """Rate of change of the heading in deg/s, right positive."""
        phi, theta = math.radians(self.phi), math.radians(self.theta)
        return (self.q * math.sin(phi) + self.r * math.cos(phi)) / math.cos(theta)

    @property
    def turn_radius(self) -> float:
        """Radius of the turn through the air in ft; infinite in straight flight."""
        rate = abs(math.radians(self.turn_rate))
        return self.tas * math.cos(math.radians(self.gamma)) / rate if rate > 1e-6 else math.inf


_STATE = {
    "altitude": "position/h-sl-ft",
    "speed": "velocities/vc-kts",
    "mach": "velocities/mach",
    "tas": "velocities/vt-fps",
    "alpha": "aero/alpha-deg",
    "beta": "aero/beta-deg",
    "theta": "attitude/theta-deg",
    "phi": "attitude/phi-deg",
    "psi": "attitude/psi-deg",
    "gamma": "flight-path/gamma-deg",
    "pitch_trim": "fcs/pitch-trim-cmd-norm",
    "elevator": "fcs/elevator-cmd-norm",
    "aileron": "fcs/aileron-cmd-norm",
    "rudder": "fcs/rudder-cmd-norm",
    "elevator_rad": "fcs/elevator-pos-rad",
    "elevator_norm": "fcs/elevator-pos-norm",
    "udot": "accelerations/udot-ft_sec2",
    "vdot": "accelerations/vdot-ft_sec2",
    "wdot": "accelerations/wdot-ft_sec2",
    "pdot": "accelerations/pdot-rad_sec2",
    "qdot": "accelerations/qdot-rad_sec2",
    "rdot": "accelerations/rdot-rad_sec2",
    "weight": "inertia/weight-lbs",
    "cg_x": "inertia/cg-x-in",
    "cg_y": "inertia/cg-y-in",
    "cg_z": "inertia/cg-z-in",
    "nz": "accelerations/Nz",
    "gear": "gear/gear-pos-norm",
    "flaps": "fcs/flap-pos-norm",
}
_NUMBERS = [f.name for f in dataclasses.fields(TrimState) if f.name in UNITS]
_RATES = {axis: f"velocities/{axis}-rad_sec" for axis in "pqr"}

# what JSBSim's search moves in each mode (FGTrim::SetMode)
_LONGITUDINAL = ("alpha", "throttle", "pitch_trim")
_MOVED = {
    "longitudinal": _LONGITUDINAL,
    "full": (*_LONGITUDINAL, "phi", "aileron", "rudder"),
    "ground": ("altitude", "theta", "phi"),
    "pull-up": (*_LONGITUDINAL, "beta", "phi", "aileron", "rudder"),
    "turn": (*_LONGITUDINAL, "beta", "aileron", "rudder"),
}


def trim(
    airframe: Airframe,
    condition: TrimCondition,
    setup: Mapping[str, float] | None = None,
    *,
    hint: bool = True,
    steady: float = 0.0,
    warm: bool = False,
) -> TrimState:
    """Initialise an airframe at a condition and trim it.

    JSBSim's own search takes one control after the other, to residuals of up to 0.01 ft/s2 and
    0.001 rad/s2. The Newton search (``solver="newton"``) moves all together within their limits
    until udot, vdot, wdot are below 1e-4 ft/s2 and pdot, qdot, rdot below 1e-5 rad/s2 (usually
    1e-9), with propellers and flight control system settled: in a flight of 0.25 s, which a twin
    makes, vdot stays below 0.1 ft/s2 and pdot, qdot, rdot below 0.02 rad/s2 (pull-ups are not
    flown). It also trims glides, steady sideslips and flights at a given throttle or thrust; its
    turns are steady in wind, its pull-ups in all accelerations.

    Parameters
    ----------
    airframe : Airframe
        loaded with the condition's ``empty_cg_x``; it can be trimmed repeatedly
    condition : TrimCondition
        what to trim for
    setup : dict, optional
        further properties, written before the model is initialised and after the condition's
    hint : bool
        after a failure ask the Newton search which limit is reached, and look for the nearest
        speed that trims: the error names both. Warn of a landing gear that is down above 200 KCAS
        where it retracts and the condition does not say so
    steady : float
        fly another aircraft of the same kind from its trim for this time in s (up to 3600),
        controls fixed (10 shows most departures, some take 30): the state's ``drift`` and
        ``steady`` say how it ends. Modes "pull-up" and "none", which are not steady flight, have
        none
    warm : bool
        let the Newton search start where the last one on this airframe found its trim. The result
        is the same, sooner: if it does not get there to full precision, it starts again cold. An
        airframe that can be put back to the precision of the search makes the flight itself

    Returns
    -------
    TrimState
        the state found; the airframe is left in it

    Raises
    ------
    TrimError
        if no trim is found, or with JSBSim's search and constant-speed propellers not within
        10 s of computing (no limit on Windows). The airframe stays usable: after a failure
        that has changed engines, systems or accelerations, the next trim starts
        from a fresh executive (`Airframe.renew`), as does a trim on the ground after any other.
        This discards fuel burnt in between and direct writes to ``airframe.fdm``
    AircraftError
        if the model cannot be initialised
    PropertyError
        for unknown properties in ``setup`` or the condition, or missing tanks or point masses
    ParameterError
        for initial conditions in ``setup`` that the trim would overwrite, and for an aircraft's
        name in place of an `Airframe`
    """
    if not isinstance(airframe, Airframe):
        raise ParameterError(
            f"airframe must be an Airframe, as in trim(Airframe('c172p'), ...), not {airframe!r}",
            parameter="airframe",
            value=airframe,
        )
    check_condition(condition)
    flag("hint", hint)
    flag("warm", warm)
    steady = number("steady", steady, low=0.0, high=3600.0)
    try:
        found = _trim(airframe, condition, setup, warm)
        if hint:
            _warn_of_gear(airframe, found)
        if steady and condition.mode not in ("pull-up", "none"):
            drift = _drift(airframe.twin(), condition, setup, steady)
            found = dataclasses.replace(found, drift=drift)
        return found
    except TrimError as error:
        if not hint:
            raise
        raise _explained(airframe, condition, setup, error) from None


def _drift(
    airframe: Airframe,
    condition: TrimCondition,
    setup: Mapping[str, float] | None,
    duration: float,
) -> Drift:
    """Trim and fly an airframe with controls fixed."""
    start, fdm = _trim(airframe, condition, setup), airframe.fdm
    climb = fdm["velocities/h-dot-fps"]
    for _ in range(round(duration / airframe.dt)):
        fdm.run()
    end = state(airframe, condition)
    return Drift(
        duration=duration,
        height=end.altitude - start.altitude - climb * duration,
        speed=end.speed - start.speed,
        bank=math.remainder(end.phi - start.phi, 360.0) if math.isfinite(end.phi) else math.nan,
    )


def _warn_of_gear(airframe: Airframe, found: TrimState) -> None:
    """Warn of a gear that retracts and is down in fast flight because no one has said."""
    condition = found.condition
    fast = found.gear > 0.0 and found.speed > _FAST_FOR_GEAR and condition.mode != "ground"
    if condition.gear is None and fast and has_retractable_gear(airframe.aircraft, airframe.root):
        warn_user(
            f"{airframe.aircraft} at {found.speed:.0f} KCAS: the landing gear is down, as the "
            "model has it; gear=0 retracts it, gear=1 confirms it",
            once=True,
        )


# what the present flight says, rather than the setup with which it began
_PRESENT = re.compile(
    r"ic/(?!terrain)|propulsion/(tank.*/contents-lbs|(engine.*/)?set-running)$"
    r"|inertia/pointmass-weight|(gear/gear|fcs/flap)-(cmd|pos)-norm$"
)


def here(
    airframe: Airframe,
    condition: TrimCondition,
    setup: Mapping[str, float] | None,
    changes: Mapping[str, Any],
) -> TrimCondition:
    """The present flight of an airframe that began at a condition, as a condition with changes.

    Raises
    ------
    ParameterError
        for a change that no condition has
    """
    known = [field.name for field in dataclasses.fields(TrimCondition)]
    for name in changes:
        one_of("change", name, known)
    fdm, now = airframe.fdm, state(airframe, condition)
    mode = "full" if condition.mode in ("ground", "none", "pull-up") else condition.mode
    before = {**condition.setup, **mapping("setup", setup)}
    masses = map("inertia/pointmass-weight-lbs[{}]".format, itertools.count())
    present: dict[str, Any] = {
        "altitude": now.altitude,
        "speed": now.speed,
        "mach": None,
        # relative to the air, which JSBSim's own is not
        "gamma": math.degrees(math.asin(fdm["velocities/h-dot-fps"] / now.tas)),
        "heading": now.psi,
        "bank": now.phi if changes.get("mode", mode) == "turn" else 0.0,
        "load_factor": 1.0,
        "mode": mode,
        "gear": min(max(now.gear, 0.0), 1.0),
        "flaps": min(max(now.flaps, 0.0), 1.0),
        # rounding errors of still air are none
        "wind_north": round(fdm["atmosphere/total-wind-north-fps"], 9) + 0.0,
        "wind_east": round(fdm["atmosphere/total-wind-east-fps"], 9) + 0.0,
        "payload": [fdm[name] for name in itertools.takewhile(airframe.has, masses)],
        "fuel": [fdm[name] for name in airframe.tanks],
        "latitude": fdm["position/lat-geod-deg"],
        "longitude": fdm["position/long-gc-deg"],
        "engines_off": [
            i for i in range(airframe.engines) if not fdm[f"propulsion/engine[{i}]/set-running"]
        ],
        "setup": {n: v for n, v in before.items() if not _PRESENT.match(airframe.canonical(n))},
    }
    return dataclasses.replace(condition, **{**present, **changes})


# lift coefficient of a speed at which most aircraft fly, and factors of this speed
_USUAL_LIFT = 0.4
_USUAL_SPEEDS = (1.0, 1.3, 0.8, 1.7)

# KCAS, limits for models whose reference area is unrelated to lift (rockets, helicopters)
_LEVEL_SPEEDS = (20.0, 350.0)

_RHO0 = 0.0023769  # slug/ft3, standard air at sea level (US Standard Atmosphere, 1976)
_KNOT = 1.6878099  # ft/s


def level_speed(airframe: Airframe, lift_coefficient: float) -> float:
    """The speed in KCAS at which an initialised airframe's wing lifts its weight."""
    low, high = _LEVEL_SPEEDS
    weight, area = (airframe.fdm[name] for name in ("inertia/weight-lbs", "metrics/Sw-sqft"))
    if area <= 0.0:
        return low
    speed = math.sqrt(2.0 * weight / (_RHO0 * area * lift_coefficient)) / _KNOT
    return float(round(min(max(speed, low), high)))


def _explained(
    airframe: Airframe,
    condition: TrimCondition,
    setup: Mapping[str, float] | None,
    error: TrimError,
) -> TrimError:
    """The error of a failed trim with the limit that is reached and the nearest that trims."""
    powered = len(airframe.stopped) < airframe.engines or condition.balance != "throttle"
    if condition.mode in ("ground", "none") or not powered or error.reason in ("mach", "ground"):
        return error
    airframe.renew()
    nearest, how = None, "with solver='newton'"
    try:
        airframe.write(_properties(airframe, condition, setup), "setup")
        # at another speed a model may be impossible to initialise
        with airframe.engines_stopped(), contextlib.suppress(AircraftError):
            _initialise(airframe, condition, condition.heading)
            speed = airframe.fdm[_STATE["speed"]]
            if condition.searched_by == "jsbsim":
                try:
                    _by_newton(airframe, condition)
                    nearest = dataclasses.replace(condition, solver="newton")
                except TrimError as ours:
                    error = _with_limit(airframe, error, ours)
            helps = error.reason in ("thrust", "alpha limit", "elevator", "no convergence")
            if nearest is None and helps and condition.balance != "speed" and math.isfinite(speed):
                nearest = _nearest_speed(airframe, condition, speed)
                how = f"at {nearest.speed:.0f} KCAS there" if nearest else ""
    finally:
        airframe.spent = True  # whatever the searches left, the next trim starts afresh
    if nearest is None:
        return error
    return error.reworded(f"{error}. It trims {how}", nearest=nearest)


def _with_limit(airframe: Airframe, error: TrimError, newton: TrimError) -> TrimError:
    """The error of JSBSim's search with the limit and residuals of the Newton search."""
    reason, limit, residuals = error.reason, newton.limit, newton.residuals
    if reason == "no convergence":
        reason = newton.reason
    elif reason != newton.reason:
        low, high = alpha_range(airframe)
        limit = {
            "thrust": 1.0 if residuals["udot"] < 0.0 else 0.0,
            "alpha limit": high if residuals["wdot"] > 0.0 else low,
        }.get(reason)
    if limit is None:
        return error
    return _failure(airframe, error.condition, reason, residuals=residuals, limit=limit)


def _nearest_speed(
    airframe: Airframe, condition: TrimCondition, speed: float
) -> TrimCondition | None:
    """The condition at the speed nearest to ``speed`` in KCAS that trims; None without one.

    It lies between ``speed`` and a usual one that trims: too fast, it is the fastest that trims,
    too slow, the slowest.
    """
    seed: Seed | None = None

    def trims(knots: float) -> TrimCondition | None:
        nonlocal seed
        other = dataclasses.replace(condition, speed=knots, mach=None, solver=None)
        _initialise(airframe, other, other.heading)
        if not math.isfinite(airframe.fdm[_STATE["tas"]]):
            return None
        try:
            _, seed = _searched(airframe, other, seed, warm=True)
        except TrimError:
            return None
        return other

    usual, bad = level_speed(airframe, _USUAL_LIFT), speed
    for factor in _USUAL_SPEEDS:
        if airframe.effort > EFFORT:
            return None
        good = float(round(usual * factor))
        if nearest := trims(good):
            break
    else:
        return None
    while abs(good - bad) > 1.0 and airframe.effort < EFFORT:
        middle = float(round(0.5 * (bad + good)))
        if middle in (bad, good):
            break
        if closer := trims(middle):
            nearest, good = closer, middle
        else:
            bad = middle
    return dataclasses.replace(nearest, solver=condition.solver)


# initial conditions that a trim overwrites -> the field of a condition that sets them
_OVERWRITTEN = {
    r"ic/h-(sl|agl)-ft": "altitude",
    r"ic/v[cegt]-kts|ic/v[gt]-fps": "speed",
    r"ic/mach": "mach",
    r"ic/([uvw]|v[ned])-fps": "speed, gamma and heading",
    r"ic/(gamma|theta|alpha)-(deg|rad)|ic/roc-fp[ms]": "gamma",
    r"ic/phi-(deg|rad)": "bank",
    r"ic/psi-true-(deg|rad)": "heading",
    r"ic/beta-(deg|rad)": "beta",
    r"ic/vw-.*": "wind_north and wind_east",
    r"ic/[pqr]-rad_sec": "mode",
}


def _refuse_overwritten(airframe: Airframe, condition: TrimCondition, names: Iterable[str]) -> None:
    """Raise ParameterError for properties in ``setup`` that would have no effect."""
    for name in names:
        for pattern, parameter in _OVERWRITTEN.items():
            if condition.mode != "none" and re.fullmatch(pattern, airframe.canonical(name)):
                raise ParameterError(
                    f"setup[{name!r}] would be overwritten by the trim: set {parameter} of the "
                    'condition, or start without a trim (mode="none")',
                    parameter="setup",
                    value=name,
                )


def _properties(
    airframe: Airframe, condition: TrimCondition, setup: Mapping[str, float] | None
) -> dict[str, float]:
    """The properties of a condition, those of ``setup`` after them."""
    last = mapping("setup", setup)
    _refuse_overwritten(airframe, condition, {**condition.setup, **last})
    first = {**_loading(condition), **condition.setup}
    return {**{n: v for n, v in first.items() if n not in last}, **last}


def _trim(
    airframe: Airframe,
    condition: TrimCondition,
    setup: Mapping[str, float] | None,
    warm: bool = False,
    effort: int = 0,
) -> TrimState:
    airframe.effort = effort
    if airframe.spent or (airframe.used and condition.mode == "ground"):
        airframe.renew()
    used = airframe.used
    seed, airframe.seed = airframe.seed if warm else None, None
    airframe.lower_ground()
    written = _properties(airframe, condition, setup)
    # without a search nothing needs the condition's own speed and attitude
    initial = (
        {n: v for n, v in written.items() if _is_initial(airframe.canonical(n))}
        if condition.mode == "none"
        else {}
    )
    airframe.write({n: v for n, v in written.items() if n not in initial}, "setup")
    airframe.stopped = _stopped(airframe, condition, written)
    # spent is cleared below on success: a search that ends early leaves the executive unusable
    airframe.used = airframe.spent = True
    with airframe.engines_stopped():
        _initialise(airframe, condition, condition.heading, initial)
        if not (used and _not_finite(state(airframe, condition))):
            try:
                return _search(airframe, condition, seed, warm)
            except TrimError as error:
                by_newton = condition.searched_by == "newton"
                again = error.reason in ("no convergence", "no equilibrium")
                if not (again and used and by_newton):
                    raise
    # the previous flight left NaN or inf in the executive, or engines from which a search with
    # constant-speed propellers does not converge or stay: this call renews it
    airframe.spent = True
    return _trim(airframe, condition, setup, effort=airframe.effort)


def _stopped(
    airframe: Airframe, condition: TrimCondition, written: Mapping[str, float]
) -> frozenset[int]:
    """The engines that do not run, by the condition or by what is written before the trim."""
    engines = set(range(airframe.engines))
    stopped = engines if condition.engines_off == "all" else set(condition.engines_off)
    if not stopped <= engines:
        raise ParameterError(
            f"engines_off={condition.engines_off!r}: aircraft {airframe.aircraft!r} has "
            + (f"the engines 0 to {len(engines) - 1}" if engines else "no engine"),
            parameter="engines_off",
            value=condition.engines_off,
        )
    for name, value in written.items():
        engine = ENGINE_RUNS.match(name)
        if engine and value == 0.0:
            stopped = stopped | {int(engine[1] or 0)}
        elif name == "propulsion/set-running" and value >= 0.0:
            # JSBSim starts this engine only
            stopped = stopped | engines - {int(value)}
    return frozenset(stopped)  # type: ignore[arg-type]


def _search(
    airframe: Airframe, condition: TrimCondition, seed: Seed | None, warm: bool
) -> TrimState:
    """Trim an initialised airframe."""
    if condition.mode != "none":
        _refuse_hopeless(airframe, condition)
    dead = airframe.stopped and condition.solver is None
    flies = condition.mode not in ("ground", "none")
    if condition.searched_by == "newton" or (dead and flies):
        return _by_newton(airframe, condition, seed, warm)
    if condition.mode in ("full", "longitudinal"):
        before = airframe.internal()
        try:
            _find(airframe, condition)
        except TrimError:
            # most failed searches with jet engines leave nothing behind to renew for
            _initialise(airframe, condition, condition.heading)
            airframe.spent = not _same(before, airframe.internal())
            raise
    elif condition.mode != "none":
        _find(airframe, condition)
    if condition.mode == "turn":
        # JSBSim keeps the track and turns the nose, so start with the opposite offset
        beyond = math.remainder(airframe.fdm[_STATE["psi"]] - condition.heading, 360.0)
        _initialise(airframe, condition, condition.heading - beyond)
        _find(airframe, condition)
    found = state(airframe, condition)
    broken = _not_finite(found)
    if broken:
        raise _failure(
            airframe, condition, "no convergence", f"{', '.join(broken)} not finite after the trim"
        )
    airframe.spent = False
    return found


def _by_newton(
    airframe: Airframe, condition: TrimCondition, seed: Seed | None = None, warm: bool = False
) -> TrimState:
    """Trim an initialised airframe with the Newton search; a failure leaves its commands alone."""
    if len(airframe.stopped) == airframe.engines and condition.balance == "throttle":
        airframe.spent = False
        raise _failure(airframe, condition, "thrust")
    commands = [f"fcs/{name}-cmd-norm" for name in ("pitch-trim", "elevator", "aileron", "rudder")]
    commands += [f"fcs/throttle-cmd-norm[{i}]" for i in range(airframe.engines)]
    before = {name: airframe.fdm[name] for name in commands}
    try:
        reached, airframe.seed = _searched(airframe, condition, seed, warm)
    except TrimError:
        airframe.seed = seed and seed._replace(near=False)
        for name, value in before.items():
            airframe.fdm[name] = value
        raise
    airframe.spent = False
    return reached


def _searched(
    airframe: Airframe,
    condition: TrimCondition,
    seed: Seed | None,
    warm: bool,
    in_time: bool = False,
) -> tuple[TrimState, Seed | None]:
    """The trim that the Newton search finds, and the seed of the next one."""
    turboprops = bool(airframe.of_engines("itt-c"))
    in_time = in_time or turboprops or (seed is not None and seed.in_time)
    search = Search(airframe, condition, in_time)
    found = search.find(seed)
    airframe.spent = search.leaves_traces
    try:
        return _reached(airframe, condition, search, found, warm), found.seed
    except TrimError as error:
        if in_time or error.reason != "no equilibrium":
            raise
    return _searched(airframe, condition, seed, warm, in_time=True)


def _reached(
    airframe: Airframe, condition: TrimCondition, search: Search, found: Found, warm: bool
) -> TrimState:
    """The state in which a Newton search has left an airframe, if it is a trim."""
    touches = airframe.fdm["forces/fbz-gear-lbs"] != 0.0
    if found.converged and not touches:
        changes: dict[str, Any] = {"free": tuple(found.free), **found.residuals}
        reached = dataclasses.replace(state(airframe, condition), **changes)
        if not _not_finite(reached):
            moving = condition.mode != "pull-up" and _moving(
                airframe, condition, search, found, warm
            )
            if moving:
                raise _failure(airframe, condition, "no equilibrium", moving, found.residuals)
            return reached
    if touches:
        raise _failure(
            airframe, condition, "ground", "a wheel or another contact point touches the ground"
        )
    reason = _REASONS.get(found.binding, found.binding) or "no convergence"
    limit = found.free.get(found.binding)
    if limit is not None and found.binding in _ANGLES:
        limit = math.degrees(limit)
    raise _failure(airframe, condition, reason, residuals=found.residuals, limit=limit)


def _moving(
    airframe: Airframe, condition: TrimCondition, search: Search, found: Found, warm: bool
) -> str:
    """What moves in a short flight from a trim; empty if nothing does."""
    other = airframe
    if not warm or search.leaves_traces:
        # the airframe could be put back to the precision of the search only
        other = airframe.stand_in()
        with other.engines_stopped():
            _initialise(other, condition, condition.heading)
            other.fdm[_STATE["elevator"]] = airframe.fdm[_STATE["elevator"]]
            Search(other, condition, search.in_time).hold(found)
    parts = [f"fcs/{name}-pos-norm" for name in ("elevator", "left-aileron", "right-aileron")]
    parts += ["fcs/rudder-pos-norm", *other.of_engines("thrust-lbs")]
    watched, kept = ([other.reader(n) for n in names] for names in (parts, other.tanks))
    before, fuel, time = [r() for r in watched], [r() for r in kept], other.fdm.get_sim_time()
    largest = _flown(other)
    after = [r() for r in watched]
    if other is airframe:
        for tank, contents in zip(airframe.tanks, fuel, strict=True):
            airframe.writer(tank)(contents)
        search.hold(found)
        airframe.fdm.set_sim_time(time)
    axes = ["qdot"] if condition.mode == "longitudinal" else [*_STAYS]
    if all(largest[name] < _STAYS[name] for name in axes):
        return ""
    worst = max(axes, key=lambda name: largest[name] / _STAYS[name])
    weight = other.fdm["inertia/weight-lbs"]
    why = f"it does not stay: within {_SHORT_FLIGHT} s of flight {worst} reaches "
    why += f"{largest[worst]:.3g} {UNITS[worst]}"
    sizes = [weight if name.endswith("-lbs") else 1.0 for name in parts]
    moved = [abs(b - a) / size for a, b, size in zip(before, after, sizes, strict=True)]
    i = int(np.argmax(moved))
    if moved[i] > _SMALL_MOTION:
        why += f" ({parts[i]} goes from {before[i]:.3g} to {after[i]:.3g})"
    return why


def _flown(airframe: Airframe) -> dict[str, float]:
    """Largest accelerations in a short flight."""
    # relative to the air: in a turn with wind the ground velocity turns in body axes
    names = "velocities/v-aero-fps", *(_STATE[name] for name in ("pdot", "qdot", "rdot"))
    readers = [airframe.reader(name) for name in names]
    rows = [[read() for read in readers]]
    for _ in range(max(round(_SHORT_FLIGHT / airframe.dt), 1)):
        airframe.fdm.run()
        rows.append([read() for read in readers])
    flight = np.array(rows)
    flight[1:, 0] = np.diff(flight[:, 0]) / airframe.dt
    return dict(zip(_STAYS, abs(flight[1:]).max(axis=0).tolist(), strict=True))


def _same(before: list[float], now: list[float]) -> bool:
    """Whether two internal states are the same up to rounding; false where one is not finite."""
    a, b = np.array(before), np.array(now)
    with np.errstate(invalid="ignore"):
        return bool((abs(a - b) <= _ROUNDING * np.maximum(abs(a), 1.0)).all())


def _not_finite(found: TrimState) -> list[str]:
    """Names of the fields of a state that are not finite."""
    fields = vars(found)
    return [
        name
        for name in _NUMBERS
        for value in [fields[name]]
        if not all(map(math.isfinite, value if isinstance(value, tuple) else (value,)))
    ]


def _refuse_hopeless(airframe: Airframe, condition: TrimCondition) -> None:
    """Raise TrimError for conditions that crash JSBSim's search or make it long and futile."""
    fdm = airframe.fdm
    mach = fdm[_STATE["mach"]]
    if mach >= 1.0 and _propellers(airframe, "propeller-rpm"):
        raise _failure(
            airframe,
            condition,
            "mach",
            f"Mach {mach:.3g}: propellers give thrust below Mach 1 only",
        )
    # the search may still make other fields, such as thrust, finite
    if broken := [name for name in _LIMITS if not math.isfinite(fdm[_STATE[name]])]:
        raise _failure(
            airframe,
            condition,
            "no convergence",
            f"{', '.join(broken)} not finite at this condition",
        )


def _propellers(airframe: Airframe, quantity: str) -> list[float]:
    """A quantity of each propeller; empty without propellers."""
    return [airframe.fdm[name] for name in airframe.of_engines(quantity)]


def state(airframe: Airframe, condition: TrimCondition) -> TrimState:
    """Current state of an initialised airframe."""
    fdm = airframe.fdm
    found: dict[str, Any] = {name: fdm[source] for name, source in _STATE.items()}
    found |= {name: math.degrees(fdm[source]) for name, source in _RATES.items()}
    if found["psi"] > ALMOST_NORTH:
        found["psi"] = 0.0
    thrusts = [fdm[f"propulsion/engine[{i}]/thrust-lbs"] for i in range(airframe.engines)]
    return TrimState(
        aircraft=airframe.aircraft,
        condition=condition,
        throttle=tuple(fdm[f"fcs/throttle-cmd-norm[{i}]"] for i in range(airframe.engines)),
        # fsum refuses infinities of both signs
        thrust=math.fsum(thrusts) if all(map(math.isfinite, thrusts)) else math.nan,
        free=_MOVED.get(condition.mode, ()),
        **found,
    )


def _loading(condition: TrimCondition) -> dict[str, float]:
    """Mass, configuration and trim limits as properties."""
    payload, fuel = dict(condition.payload), dict(condition.fuel)  # type: ignore[arg-type]
    written = {f"inertia/pointmass-weight-lbs[{i}]": w for i, w in payload.items()}
    written |= {f"propulsion/tank[{i}]/contents-lbs": w for i, w in fuel.items()}
    if condition.gear is not None:
        written |= {"gear/gear-cmd-norm": condition.gear, "gear/gear-pos-norm": condition.gear}
    if condition.flaps is not None:
        written |= {"fcs/flap-cmd-norm": condition.flaps, "fcs/flap-pos-norm": condition.flaps}
    if condition.latitude is not None:
        written["ic/lat-geod-deg"] = condition.latitude
    if condition.longitude is not None:
        written["ic/long-gc-deg"] = condition.longitude
    if condition.alpha_min is not None:
        written["aero/alpha-min-rad"] = math.radians(condition.alpha_min)
    if condition.alpha_max is not None:
        written["aero/alpha-max-rad"] = math.radians(condition.alpha_max)
    return written


def _is_initial(name: str) -> bool:
    """Whether a property is an initial condition, other than the place, which comes first."""
    return name.startswith("ic/") and not name.startswith(_PLACE)


def _initialise(
    airframe: Airframe,
    condition: TrimCondition,
    heading: float,
    initial: Mapping[str, float] = MappingProxyType({}),
) -> None:
    """Write a condition as initial conditions, ``initial`` last, and initialise the model."""
    fdm = airframe.fdm
    on_ground = condition.mode == "ground"

    def put(name: str, value: float) -> None:
        # a needless write moves the other initial conditions by a rounding error
        if fdm[name] != value:
            fdm[name] = value

    # some models trim only if the engines are started after run_ic, others only if before it
    airframe.start_engines()
    if fdm["ic/vw-mag-fps"]:
        # the wind of the previous trim would turn the nose
        fdm["ic/vw-mag-fps"] = fdm["ic/vc-kts"] = 0.0
    put("ic/phi-deg", 0.0)
    put("ic/psi-true-deg", heading)
    if on_ground:
        airframe.raise_ground(condition.altitude)
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
    airframe.run_ic()
    airframe.start_engines()


def _find(airframe: Airframe, condition: TrimCondition) -> None:
    def find() -> bool:
        try:
            airframe.fdm["simulation/do_simple_trim"] = MODES[condition.mode]
        except jsbsim.TrimFailureError:
            return False
        return True

    # with wheels near the ground JSBSim's search may read invalid memory; with constant-speed
    # propellers it may wait minutes for engines that never settle
    near_ground = condition.mode == "ground" or airframe.fdm["position/h-agl-ft"] < _NEAR_GROUND
    if near_ground or any(_propellers(airframe, "constant-speed-mode")):
        outcome = rehearse(find, _LONGEST_SEARCH)
        if outcome is not Outcome.ENDS:
            raise _failure(
                airframe,
                condition,
                "no convergence",
                f"the search was given up after {_LONGEST_SEARCH} s of computing"
                if outcome is Outcome.GOES_ON
                else "JSBSim's search would crash there",
            )
    # hushed: the TrimError reports the failure
    found, said = messages(find, hushed=True)
    if not found:
        limits = _LIMITS_OF_MODES.get(condition.mode, _LIMITS)
        axis = re.search(r"Sorry, (\w+) doesn't appear to be trimmable", " ".join(said))
        powered = airframe.engines or condition.mode == "ground"
        raise _failure(
            airframe,
            condition,
            limits[axis[1]] if axis else "no convergence" if powered else "thrust",
        )


def _failure(
    airframe: Airframe,
    condition: TrimCondition,
    reason: str,
    why: str = "",
    residuals: Mapping[str, float] | None = None,
    limit: float | None = None,
) -> TrimError:
    fdm = airframe.fdm
    reached = "without trim" if residuals is None else "at best"
    if residuals is None:
        residuals = {name: fdm[_STATE[name]] for name in _LIMITS}
    alpha_min, alpha_max = alpha_range(airframe)
    limits = {
        "thrust": "the throttle ran to the end of its range"
        if len(airframe.stopped) < airframe.engines
        else f"it has no {'running ' if airframe.stopped else ''}engine to hold the speed with "
        "(mode='glide' frees the path angle)",
        "alpha limit": f"alpha ran to the end of [{alpha_min:.4g}, {alpha_max:.4g}] deg",
        "elevator": "the pitch trim ran to the end of [-1, 1]",
        "no convergence": "no control ran out, but the search did not converge",
    }
    why = why or limits.get(reason, f"the {reason} ran to the end of its range")
    if limit is not None:
        why += f", {limit + 0.0:.4g}"
    return TrimError(
        f"aircraft {airframe.aircraft!r} does not trim at {condition}: {why}; {reached} "
        + ", ".join(f"{name}={value:.3g}" for name, value in residuals.items())
        + " (ft/s2, rad/s2)",
        aircraft=airframe.aircraft,
        condition=condition,
        reason=reason,
        residuals=residuals,
        limit=limit,
    )
