"""Performance charts: what an aircraft can do, from trims, with samples of them flown.

A climb is a trim at full throttle with the path angle free, a glide one with the throttle closed.
Both hold their true airspeed. Best values are searched by trims, not read off a fitted curve.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.checks import positive, refuse
from .._core.extras import required
from .._core.units import GRAVITY, KNOT, RHO0
from ..errors import BlocksError
from ..flight import TrimCondition, TrimState
from ..flight.fleet import prepared
from .flight_tests import (
    LARGE,
    Plane,
    Row,
    best_of,
    climb_rate,
    energy_rate,
    extremes,
    first,
    flown,
    last,
    lift_flown,
    path_angle,
    slowest,
)
from .workers import WORKER_DIED, run_parts

if TYPE_CHECKING:
    import pandas as pd

# ft; those of propeller aircraft and gliders, and of jets
_ALTITUDES = ((0.0, 5000.0, 10e3, 15e3, 20e3), (0.0, 10e3, 20e3, 30e3, 40e3, 50e3))
_FLAPS = (0.0, 0.5, 1.0)
_SERVICE = {"propeller": 100.0, "jet": 500.0}  # ft/min of climb left at the service ceiling
_HIGHEST = 90e3  # ft, where the search for a ceiling ends
_STEEPEST = 9.0  # g, what pilots stand

_GRID, _STEPS = 1.12, 22  # ratio of neighbouring airspeeds from the stall on, and their number
_DIVE = -20.0  # deg, a glide so steep that a chart above the ceiling ends
_TRIES = 6  # speeds at which a climb or level flight is looked for in vain

_TURN = 10.0  # s, before a spiral grows
_BURN = 20.0  # s in which the fuel flow of a turbine settles
_DECELERATION = 1.0  # kt/s into the stall: CS 23.201(b), CS 25.103(c)

COLUMNS = (
    *("chart", "quantity", "altitude_ft", "weight_lb", "flaps_norm", "speed_kcas", "load_factor"),
    *("value", "unit", "flown", "difference_percent", "reason"),
)


def _stall(plane: Plane) -> None:
    """The stall speed at one weight and flap setting, throttle closed, load factor 1."""
    slow, why = slowest(plane), plane.reason
    if slow is None:
        plane.put("stall", "stall speed", None)
        return
    value = slow.speed / math.sqrt(math.cos(math.radians(slow.gamma)))
    fast = plane.glide(1.15 * slow.speed)
    lift = fast and lift_flown(plane, fast, slow, 0.15 * slow.speed / _DECELERATION)
    found = flown(value, value / math.sqrt(lift) if lift else None)
    more = {"speed_kcas": slow.speed, "reason": why, **found}
    plane.put("stall", "stall speed", value, **more)


def _levels(plane: Plane) -> None:
    """Level flight, climb, glide and range at one altitude, against airspeed."""
    slow, why = slowest(plane), plane.reason
    if slow is None:
        plane.put("level", "level flight", None)
        return
    at = {"speed_kcas": slow.speed, "reason": why}
    plane.put("envelope", "stall speed, throttle closed", slow.tas / KNOT, **at)
    climbs: list[TrimState] = []
    glides: list[TrimState] = []
    levels: list[TrimState] = []
    engines, speed = plane.airframe.engines, 1.001 * slow.speed
    why_climb = plane.reason = "no engine"
    for step in range(_STEPS if engines else _STEPS // 2):
        at = {"speed_kcas": speed}
        if glide := plane.glide(speed):
            glides.append(glide)
            plane.put("glide", "sink rate", -climb_rate(glide), **at)
        # a search in vain is not repeated at every speed
        climb = plane.climb(speed) if engines and (climbs or step < _TRIES) else None
        if climb:
            climbs.append(climb)
            plane.put("climb", "rate of climb", climb_rate(climb), **at)
            plane.put("climb", "climb angle", climb.gamma, **at)
            _thrust(plane, "available", climb)
        elif engines and step < _TRIES:
            why_climb = plane.reason
        level = plane.trim(speed) if engines and (levels or step < _TRIES) else None
        if level:
            levels.append(level)
            _thrust(plane, "required", level)
            _burn(plane, level)
        elif levels or (glide and glide.gamma < _DIVE):
            break
        speed *= _GRID
    if not engines:
        plane.reason = "no engine"
    _ends_of_level(plane, levels)
    plane.reason = why_climb
    _bests(plane, climbs)
    _glides(plane, glides)
    _farthest(plane)


def _thrust(plane: Plane, name: str, state: TrimState) -> None:
    """Thrust, and with propellers its power, required or available."""
    plane.put("level", f"thrust {name}", state.thrust, speed_kcas=state.speed)
    if plane.kind == "propeller":
        power = state.thrust * state.tas / 550.0
        plane.put("level", f"power {name}", power, speed_kcas=state.speed)


def _burn(plane: Plane, level: TrimState) -> None:
    """Fuel flow and specific range in level flight, from the engines and from the weight lost."""
    setup = {**level.condition.setup, "propulsion/fuel_freeze": 0.0}
    flight = plane.fly(level, _BURN, setup=setup)
    if flight is None or flight["fuel"][-1] <= 0.0:
        return
    half, flow = len(flight["w"]) // 2, 3600.0 * float(flight["fuel"][-1])
    lost = float(flight["w"][half] - flight["w"][-1])
    way = float(flight["v"][half:].mean()) / KNOT * 0.5 * _BURN / 3600.0
    value, at = level.tas / KNOT / flow, {"speed_kcas": level.speed}
    plane.put("range", "fuel flow", flow, **at)
    found = flown(value, way / lost if lost > 0.0 else None)
    plane.put("range", "specific range", value, **at, **found)


def _farthest(plane: Plane) -> None:
    """Best range and endurance among the speeds of the chart."""
    flow, reach = (
        [row for row in plane.rows if row["quantity"] == name]
        for name in ("fuel flow", "specific range")
    )
    if not flow:
        flies = any(row["quantity"] == "thrust required" for row in plane.rows)
        why = "the model burns no fuel" if flies else "no level flight"
        plane.put("range", "best specific range", None, reason=why)
        return
    best = max(reach, key=lambda row: row["value"])
    least = min(flow, key=lambda row: row["value"])
    plane.rows += [{**best, "quantity": "best specific range"}]
    plane.rows += [{**least, "quantity": "least fuel flow"}]


def _ends_of_level(plane: Plane, levels: Sequence[TrimState]) -> None:
    """The highest and the lowest airspeed of level flight, and its thrust in a flight."""
    for end, i, ratio in (("highest", -1, _GRID), ("lowest", 0, 1.0 / _GRID)):
        if not levels:
            plane.put("level", f"{end} level speed", None)
            continue
        plane.reason = ""
        edge = last(plane.trim, levels[i], ratio)
        at = {"speed_kcas": edge.speed, "reason": plane.reason}
        plane.put("level", f"{end} level speed", edge.tas / KNOT, **at)
        plane.put("envelope", f"{end} level Mach number", edge.mach, **at)
    if levels:
        level = levels[len(levels) // 2]
        rate = energy_rate(plane, level, 0.0)
        thrust = None if rate is None else level.thrust - level.weight * rate / 60.0 / level.tas
        found = {"speed_kcas": level.speed, **flown(level.thrust, thrust)}
        plane.put("level", "thrust of level flight", level.thrust, **found)


def _bests(plane: Plane, climbs: Sequence[TrimState]) -> None:
    """Best rate and angle of climb."""
    if not climbs:
        plane.put("climb", "best rate of climb", None)
        return
    fast = best_of(plane.climb, climb_rate, max(climbs, key=climb_rate))
    steep = best_of(plane.climb, path_angle, max(climbs, key=path_angle))
    found = {
        "speed_kcas": fast.speed,
        **flown(climb_rate(fast), energy_rate(plane, fast, climb_rate(fast))),
    }
    plane.put("climb", "best rate of climb", climb_rate(fast), **found)
    plane.put("climb", "best angle of climb", steep.gamma, speed_kcas=steep.speed)
    plane.put("climb", "Vy", fast.speed)
    plane.put("climb", "Vx", steep.speed)
    plane.put("terms", "full thrust at Vy", fast.thrust, speed_kcas=fast.speed)


def _glides(plane: Plane, glides: Sequence[TrimState]) -> None:
    """Best glide, least sink, and the terms of lift and drag: least squares over glides."""
    if not glides:
        return
    far = best_of(plane.glide, path_angle, max(glides, key=path_angle))
    slow = best_of(plane.glide, climb_rate, max(glides, key=climb_rate))
    ratio, rate = -1.0 / math.tan(math.radians(far.gamma)), energy_rate(plane, far, climb_rate(far))
    seen = rate and 1.0 / math.tan(math.asin(-rate / 60.0 / far.tas))
    found = {"speed_kcas": far.speed, **flown(ratio, seen)}
    plane.put("glide", "best glide ratio", ratio, **found)
    plane.put("glide", "least sink rate", -climb_rate(slow), speed_kcas=slow.speed)
    used = [s for s in glides if s.mach < 0.6 and s.alpha < glides[0].alpha - 3.0]
    if len(used) < 3 or plane.area <= 0.0:
        return
    force = np.array([0.5 * RHO0 * plane.light * s.tas**2 * plane.area for s in used])
    alpha, gamma = (np.radians([getattr(s, name) for s in used]) for name in ("alpha", "gamma"))
    thrust = np.array([s.thrust for s in used])
    lift = (plane.weight * np.cos(gamma) - thrust * np.sin(alpha)) / force
    drag = (thrust * np.cos(alpha) - plane.weight * np.sin(gamma)) / force
    induced, zero = np.polyfit(lift**2, drag, 1)
    plane.put("terms", "lift slope", float(np.polyfit(alpha, lift, 1)[0]))
    plane.put("terms", "drag at zero lift", float(zero))
    plane.put("terms", "induced drag factor", float(induced))


def _ceilings(plane: Plane) -> None:
    """The altitudes at which the best rate of climb has fallen to 0 and to the service limit."""
    best: TrimState | None = None

    def climb(altitude: float) -> float:
        nonlocal best
        plane.climb_to(altitude)
        start = plane.climb(best.speed) if best else first(plane, plane.climb)
        if start is None:
            why, level = plane.reason, first(plane, plane.trim)
            plane.reason = why
            # steeper than the search goes, or a thrust that it does not find
            return math.inf if level and level.throttle[0] < 0.95 else -math.inf
        best = best_of(plane.climb, climb_rate, start, 1.1)
        return climb_rate(best)

    plane.reason = "no engine"
    rates = {-5000.0: math.inf, 0.0: climb(0.0) if plane.airframe.engines else -math.inf}
    why_none = "below 0 ft" if math.isfinite(rates[0.0]) else plane.reason
    while (top := max(rates)) < _HIGHEST and rates[top] > 0.0:
        rates[top + 5000.0] = climb(top + 5000.0)
    for name, limit in (("absolute", 0.0), ("service", _SERVICE[plane.kind])):
        high = next((h for h, rate in rates.items() if rate < limit), math.inf)
        if high == 0.0 or math.isinf(high):
            why = f"above {_HIGHEST:,.0f} ft" if high else why_none
            plane.put("climb", f"{name} ceiling", None, reason=why)
            continue
        low, why = high - 5000.0, ""
        up, down = rates[low], rates[high]
        while high - low > 20.0:
            share = (up - limit) / (up - down) if math.isfinite(up - down) else 0.5
            middle = low + min(max(share, 0.05), 0.95) * (high - low)
            rate = climb(middle)
            if rate > limit:
                low, up = middle, rate
            else:
                high, down, why = middle, rate, "" if math.isfinite(rate) else plane.reason
            if abs(rate - limit) < 1.0:
                low = high = middle
        at = {"altitude_ft": low, "speed_kcas": best.speed if best else math.nan, "reason": why}
        plane.put("climb", f"{name} ceiling", low, **at)


def _steepest(plane: Plane, speed: float, **fields: Any) -> TrimState | None:
    """The turn with the largest load factor, in steps of a ratio, ever finer."""
    found, load, ratio = None, 1.02, 1.3
    while ratio > 1.01:
        plane.reason = f"{_STEEPEST:g} g"
        bank = math.degrees(math.acos(1.0 / (load * ratio)))
        steep = load * ratio > _STEEPEST
        turn = None if steep else plane.trim(speed, mode="turn", bank=bank, **fields)
        if turn:
            found, load = turn, load * ratio
        else:
            ratio = math.sqrt(ratio)
    return found


def _turns(plane: Plane) -> None:
    """Load factor, rate and radius of turns, sustained in level flight and at the lift limit."""
    slow = slowest(plane) if plane.airframe.engines else None
    if slow is None or plane.trim(1.6 * slow.speed) is None:
        plane.reason = plane.reason or "no engine"
        plane.put("turn", "sustained load factor", None)
        return
    for factor, (name, fields) in itertools.product(
        (1.2, 1.4, 1.6, 1.85, 2.1, 2.8),
        {"sustained": {}, "instantaneous": {"throttle": 1.0}}.items(),
    ):
        turn = _steepest(plane, factor * slow.speed, **fields)
        at: Row = {"speed_kcas": factor * slow.speed, "reason": plane.reason}
        n = 1.0 / math.cos(math.radians(turn.phi)) if turn else None
        plane.put("turn", f"{name} load factor", n, **at)
        if turn is None:
            continue
        plane.put("turn", f"{name} turn radius", turn.turn_radius, **at)
        rate = abs(turn.turn_rate)
        if factor == 1.6 and name == "sustained":
            flight = plane.fly(turn, _TURN)
            heading = None if flight is None else np.unwrap(flight["psi"], period=360.0)
            at |= flown(
                rate, None if heading is None else abs(float(heading[-1] - heading[0])) / _TURN
            )
        plane.put("turn", f"{name} turn rate", rate, **at)


def _load_factors(plane: Plane) -> None:
    """V-n diagram: airspeeds at the lift limit, throttle closed, by load factor."""
    slow = slowest(plane)
    if slow is None:
        plane.put("V-n", "speed at the lift limit", None)
        return
    # limit load factors: CS 23.337 (amendment 4), CS 25.337, CS 22.337
    high = min(max(2.1 + 24000.0 / (plane.weight + 10000.0), 2.5), 3.8)
    low = -1.0 if plane.weight > LARGE else -0.4 * high
    if not plane.airframe.engines:
        low, high = -2.65, 5.3
    for n in (1.0, 1.5, 2.0, 3.0, high, 0.5, -0.5, low):
        if not low <= n <= high:
            continue
        pull = partial(plane.trim, mode="pull-up", throttle=0.0, load_factor=n)
        usual = math.sqrt(abs(n)) * slow.speed
        start = next(filter(None, (pull(factor * usual) for factor in (1.2, 1.8, 3.0, 4.5))), None)
        if start is None and n == 1.0:
            plane.put("V-n", "speed at the lift limit", None)
            return
        least = start and last(pull, start, 0.93)
        keas = _keas(plane, least) if least else None
        more: Row = {"load_factor": n, "reason": plane.reason}
        if n == 2.0 and least and keas and (fast := plane.glide(least.speed)):
            lift = lift_flown(plane, fast, least, 2.0)
            more |= flown(keas, keas / math.sqrt(lift) if lift else None)
        plane.put("V-n", "speed at the lift limit", keas, **more)
    _gusts(plane, slow)


def _keas(plane: Plane, state: TrimState) -> float:
    return state.tas / KNOT * math.sqrt(plane.light)


def _gusts(plane: Plane, slow: TrimState) -> None:
    """Load factors in gusts of 50 ft/s at VC and 25 ft/s at VD, up to 20,000 ft.

    CS 23.341(c) (amendment 4; CS 25.341 asks for the response to a tuned gust instead): n = 1 +-
    Kg rho0 U V a / (2 W/S), Kg = 0.88 mu / (5.3 + mu), mu = 2 (W/S) / (rho c a g); K. G. Pratt,
    W. G. Walker, NACA Report 1206, 1954. The models have no design speeds: VC = 0.9 VH and
    VD = 1.25 VC are the lowest that CS 23.335 allows.
    """
    start = plane.trim(1.5 * slow.speed) if plane.airframe.engines else None
    cruise = 0.9 * last(plane.trim, start, _GRID).speed if start else 2.0 * slow.speed
    for name, speed, gust in (("VC", cruise, 50.0), ("VD", 1.25 * cruise, 25.0)):
        pull = partial(plane.trim, speed, mode="pull-up", throttle=0.0)
        one, more = pull(load_factor=1.0), pull(load_factor=1.2)
        if one is None or more is None or plane.area <= 0.0 or plane.chord <= 0.0:
            plane.put("V-n", f"gust load factor at {name}", None)
            continue
        rho, wing = RHO0 * plane.light, plane.weight / plane.area
        lift = 0.2 * wing / (0.5 * rho * one.tas**2)
        slope = lift / math.radians(more.alpha - one.alpha)
        mu = 2.0 * wing / (rho * plane.chord * slope * GRAVITY)
        relief, keas = 0.88 * mu / (5.3 + mu), _keas(plane, one)
        jump = relief * RHO0 * gust * keas * KNOT * slope / (2.0 * wing)
        plane.put("V-n", name, keas)
        plane.put("V-n", f"gust load factor at {name}", 1.0 + jump, speed_kcas=speed)


def _field(plane: Plane) -> None:
    """Take-off and landing."""
    from .field import field  # with PathSim, which no trim needs

    field(plane)


_PARTS: Mapping[str, Callable[[Plane], None]] = {
    "level": _levels,
    "turn": _turns,
    "V-n": _load_factors,
    "ceiling": _ceilings,
    "stall": _stall,
    "field": _field,
}


def _work(tasks: list[Mapping[str, Any]]) -> list[Row]:
    """The rows of each task; where an aircraft cannot be loaded so, the reason."""
    found = []
    for task in tasks:
        try:
            plane = Plane(task)
            _PARTS[task["part"]](plane)
            rows = plane.rows
        except BlocksError as error:
            rows = [{"quantity": f"all of {task['part']}", "reason": str(error), **_place(task)}]
        found.append({"rows": rows})
    return found


def _place(task: Mapping[str, Any]) -> Row:
    names = {"altitude": "altitude_ft", "weight": "weight_lb", "flaps": "flaps_norm"}
    return {"chart": task["part"], **{column: task[name] for name, column in names.items()}}


def performance_table(
    aircraft: str,
    *,
    altitudes: float | Iterable[float] | None = None,
    weights: float | Iterable[float] | None = None,
    flaps: float | Iterable[float] | None = None,
    root: str | None = None,
    jobs: int = -1,
    progress: bool = True,
) -> pd.DataFrame:
    """What an aircraft can do: stall, level flight, climb, ceilings, glide, range, turns, V-n.

    Retractable gear is up and fuel is frozen; piston engines are leaned in proportion to the air
    density. A sample of each chart is flown for 60 s with controls fixed (turns 10 s, the stall in
    a deceleration of 1 kt/s).

    Parameters
    ----------
    aircraft : str
        name of the model
    altitudes : float or iterable, optional
        ft; stall, turns and V-n are those of the first one. Default are 0 to 20,000 ft for
        propeller aircraft and gliders and 0 to 50,000 ft for jets
    weights : float or iterable, optional
        gross weights in lb, made up of fuel first and of payload then; turns and V-n are those of
        the first one. Default is the model's own, and for the stall its lightest and heaviest too
    flaps : float or iterable, optional
        flap commands for the stall speeds, 0 to 1; default 0, 0.5 and 1
    root : str, optional
        JSBSim root directory; default is the one shipped with jsbsim
    jobs, progress
        as in `trim_sweep`

    Returns
    -------
    pandas.DataFrame
        one row for each value: ``chart``, ``quantity``, its condition (``altitude_ft``,
        ``weight_lb``, ``flaps_norm``, ``speed_kcas``, ``load_factor``), ``value`` and ``unit``,
        ``flown``, what a time history has found, ``difference_percent`` of it, and ``reason``: why
        there is no value, or what limits it. Work on one part ends after 15 s of processor time,
        with the reason "out of time"

    Raises
    ------
    ParameterError
        for numbers that are not possible for any aircraft
    AircraftError
        for a model that is unknown or cannot be initialised
    """
    pd = required("pandas", "studies")
    required("joblib", "studies")
    airframe, _, _ = prepared(aircraft, root)
    jet = bool(airframe.engines and not airframe.of_engines("propeller-rpm"))
    at = _ALTITUDES[jet] if altitudes is None else _axis("altitude", altitudes)
    given = [None] if weights is None else _axis("weight", weights)
    settings = _FLAPS if flaps is None else _axis("flaps", flaps)
    common = {
        "aircraft": aircraft,
        "root": root,
        "flaps": None,
        "altitude": at[0],
        "weight": given[0],
    }
    parts = [{**common, "part": "level", "altitude": h, "weight": w} for w in given for h in at]
    parts += [{**common, "part": part} for part in ("turn", "V-n", "field")]
    parts += [{**common, "part": "ceiling", "weight": w} for w in given]
    loads = extremes(airframe) if weights is None else given
    parts += [{**common, "part": "stall", "weight": w, "flaps": f} for w in loads for f in settings]
    found = run_parts(
        _work,
        [[part] for part in parts],
        died={"rows": [{"quantity": "all of a part", "reason": WORKER_DIED}]},
        describe=lambda part: f"{aircraft}: {part['part']} at {part['altitude']:g} ft",
        title=f"charts of {aircraft}",
        job=lambda: {"aircraft": aircraft, "parts": parts},
        jobs=jobs,
        resume=None,
        progress=progress,
    )
    table = pd.DataFrame([row for part in found for row in part["rows"]], columns=list(COLUMNS))
    table.attrs["aircraft"] = aircraft
    return table


def _axis(name: str, values: Any) -> list[float]:
    """One value of a condition or several, each once."""
    one = isinstance(values, str) or not np.iterable(values)
    weigh = partial(positive, name)
    check = weigh if name == "weight" else lambda x: getattr(TrimCondition(**{name: x}), name)
    found = list(dict.fromkeys(check(x) for x in ([values] if one else values)))
    return found or refuse(name, values, f"no {name}")
