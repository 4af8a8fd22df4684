"""Performance charts of an aircraft, from trims; samples of them are flown.

A climb is a trim at full throttle with the path angle free, a glide one with the throttle closed.
Both have constant true airspeed. Optima are searched by trims, not read off a fitted curve.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.checks import name_list, one_of, positive, refuse
from .._core.extras import required
from .._core.units import GRAVITY, KNOT, RHO0
from ..errors import BlocksError
from ..flight import TrimCondition, TrimState
from ..flight.fleet import prepared
from ..flight.model_files import ModelFile
from .flight_tests import (
    LARGE,
    Find,
    Plane,
    Row,
    best_of,
    climb_rate,
    extremes,
    last,
    reason_of,
)
from .journal import of_models
from .physics import mark_faults
from .workers import WORKER_DIED, run_parts

if TYPE_CHECKING:
    import pandas as pd

# ft, for propeller aircraft and gliders, and for jets
_ALTITUDES = ((0.0, 5000.0, 10e3, 15e3, 20e3), (0.0, 10e3, 20e3, 30e3, 40e3, 50e3))
_FLAPS = (0.0, 0.5, 1.0)
_HIGHEST = 90e3  # ft, end of the search for a ceiling
_FASTEST = 5000.0  # ft/min, for a climb steeper than the trim can find
_STEEPEST = 9.0  # g, limit of pilot tolerance

_GRID, _STEPS = 1.12, 22  # ratio of neighbouring airspeeds from the stall on, and their number
_FAILURES = 6  # speeds in a row without trim, after which a curve ends
_ENDS = ("highest level speed", "lowest level speed")

_TURN = 10.0  # s, short enough that an unstable spiral hardly grows
_BURN = 20.0  # s, long enough for the fuel flow of a turbine to settle
_DECELERATION = 1.0  # kt/s into the stall: CS 23.201(b), CS 25.103(c)

COLUMNS = (
    *("chart", "quantity", "altitude_ft", "weight_lb", "flaps_norm", "speed_kcas", "load_factor"),
    *("value", "unit", "flown", "difference_percent", "reason", "fault"),
)


def _stall(plane: Plane) -> None:
    """The stall speed at one weight and flap setting, throttle closed, load factor 1."""
    slow, why = plane.slowest(), plane.reason
    value = slow.speed / math.sqrt(math.cos(math.radians(slow.gamma)))
    plane.put("stall speed", value, slow.speed, reason=why)
    seconds = 0.15 * slow.speed / _DECELERATION
    lift = plane.lift_flown(plane.glide(1.15 * slow.speed), slow, seconds)
    plane.flown(value / math.sqrt(lift) if lift else None)


def _levels(plane: Plane) -> None:
    """Level flight, climb, glide and range at one altitude, against airspeed."""
    slow = plane.slowest()
    plane.put("stall speed, throttle closed", slow.tas / KNOT, slow.speed, reason=plane.reason)
    speeds = [1.001 * slow.speed * _GRID**i for i in range(_STEPS)]
    levels = _curve(plane, plane.level, speeds, "thrust required", *_ENDS, "best specific range")
    end = 1.01 * _GRID * levels[-1].speed if levels else speeds[_STEPS // 2]
    speeds = [speed for speed in speeds if speed < end]
    glides = _curve(plane, plane.glide, speeds, "sink rate")
    climbs = _curve(plane, plane.climb, speeds, "rate of climb", "best rate of climb")
    _climbs(plane, climbs)
    _glides(plane, glides)
    _level(plane, levels)


def _curve(
    plane: Plane, find: Find, speeds: Sequence[float], drawn: str, *quantities: str
) -> list[TrimState]:
    """States at these airspeeds; if there are none, the quantities are recorded with the reason.

    An airspeed without trim between others is a row of the quantity ``drawn``, with its reason.
    """
    states: list[TrimState] = []
    misses: list[tuple[float, str]] = []
    plane.reason = "no engine"
    if plane.airframe.engines or find == plane.glide:
        for speed in speeds:
            state = find(speed)
            if state is None:
                misses.append((speed, plane.reason))
                if len(misses) == _FAILURES:
                    break
                continue
            for miss, reason in misses if states else ():
                plane.put(drawn, None, miss, reason=reason)
            misses = []
            states.append(state)
    for quantity in () if states else quantities:
        plane.put(quantity, None)
    return states


def _level(plane: Plane, levels: Sequence[TrimState]) -> None:
    """Thrust and fuel flow in level flight, and its minimum and maximum airspeed."""
    exact = [state for state in levels if state.condition.throttle is None]
    find, slow = (plane.trim, exact) if exact else (plane.level, levels)
    searches = ((plane.level, levels[-1:], _GRID), (find, slow[:1], 1.0 / _GRID))
    for quantity, (find, states, ratio) in zip(_ENDS, searches, strict=True):
        for edge in (last(find, state, ratio) for state in states):
            at: Row = {"speed": edge.speed, "reason": plane.reason}
            plane.put(quantity, edge.tas / KNOT, **at)
            plane.put(quantity.replace("speed", "Mach number"), edge.mach, **at)
    for state in exact:
        _thrust(plane, "required", state)
        _burn(plane, state)
    for name, best, choose in (("specific range", "best", max), ("fuel flow", "least", min)):
        rows = [row for row in plane.rows if row["quantity"] == name and row["value"] > 0.0]
        if rows:
            row = choose(rows, key=lambda row: row["value"])
            plane.rows.append({**row, "quantity": f"{best} {name}"})
        elif levels and best == "best":
            why = "the model burns no fuel" if exact else "no throttle setting flies level"
            plane.put("best specific range", None, reason=why)
    for level in exact[len(exact) // 2 :][:1]:
        rate = plane.energy_rate(level)
        less = None if rate is None else level.weight * rate / 60.0 / level.tas
        plane.put("thrust of level flight", level.thrust, level.speed)
        plane.flown(None if less is None else level.thrust - less)


def _thrust(plane: Plane, name: str, state: TrimState) -> None:
    """Thrust, and with propellers its power, required or available."""
    plane.put(f"thrust {name}", state.thrust, state.speed)
    if plane.propeller:
        plane.put(f"power {name}", state.thrust * state.tas / 550.0, state.speed)


def _burn(plane: Plane, level: TrimState) -> None:
    """Fuel flow and specific range in level flight, from the engines and from the weight lost."""
    setup = {**level.condition.setup, "propulsion/fuel_freeze": 0.0}
    flight = plane.fly(level, _BURN, setup=setup)
    if flight is None:
        plane.put("specific range", None, level.speed, reason="the flight fails")
        return
    if flight["fuel"][-1] <= 0.0:
        return
    weight, step = flight["w"], _BURN / len(flight["w"])
    # until a tank runs dry (Concorde) or the aircraft leaves its airspeed (XB-70)
    stays = abs(flight["vc"][1:] / level.speed - 1.0) < 0.01
    burns = np.flatnonzero(stays & (-np.diff(weight) > 0.9 * step * flight["fuel"][1:]))
    if not len(burns):
        why = "the flight does not stay at the condition"
        plane.put("specific range", None, level.speed, reason=why)
        return
    end = int(burns[-1]) + 1
    begin = (end + 1) // 2
    flow, burn = 3600.0 * float(flight["fuel"][end]), float(weight[begin] - weight[end])
    way = float(flight["v"][begin:end].sum()) * step / KNOT / 3600.0
    plane.put("fuel flow", flow, level.speed)
    plane.put("specific range", level.tas / KNOT / flow, level.speed)
    plane.flown(way / burn if burn > 0.0 else None)


def _climbs(plane: Plane, climbs: Sequence[TrimState]) -> None:
    """Rate and angle of climb, their maxima, and the thrust available."""
    if not climbs:
        return
    for state in climbs:
        plane.put("rate of climb", climb_rate(state), state.speed)
        plane.put("climb angle", state.gamma, state.speed)
        _thrust(plane, "available", state)
    fast = best_of(plane.climb, climb_rate, max(climbs, key=climb_rate))
    angle = attrgetter("gamma")
    steep = best_of(plane.climb, angle, max(climbs, key=angle))
    plane.put("best rate of climb", climb_rate(fast), fast.speed)
    plane.flown(plane.energy_rate(fast))
    plane.put("best angle of climb", steep.gamma, steep.speed)
    plane.put("Vy", fast.speed)
    plane.put("Vx", steep.speed)
    plane.put("full thrust at Vy", fast.thrust, fast.speed)


def _glides(plane: Plane, glides: Sequence[TrimState]) -> None:
    """Sink rates, best glide, minimum sink, and least-squares fits of lift curve and drag polar."""
    if not glides:
        return
    for state in glides:
        plane.put("sink rate", -climb_rate(state), state.speed)
    far = best_of(plane.glide, _lift_over_drag, max(glides, key=_lift_over_drag))
    slow = best_of(plane.glide, climb_rate, max(glides, key=climb_rate))
    why = "L/D still increases at the stall" if far.speed < 1.01 * glides[0].speed else ""
    if far.gamma >= 0.0:
        why = "it climbs with the throttle closed"
    if why:
        plane.put("best glide ratio", None, reason=why)
    else:
        rate = plane.energy_rate(far)
        plane.put("best glide ratio", _lift_over_drag(far), far.speed)
        plane.flown(rate and _lift_over_drag(far, math.degrees(math.asin(rate / 60.0 / far.tas))))
    plane.put("least sink rate", -climb_rate(slow), slow.speed)
    low = [s for s in glides if s.mach < 0.6 and s.alpha < glides[0].alpha - 3.0]
    if len(low) < 3 or plane.area <= 0.0:
        return
    force = np.array([0.5 * RHO0 * plane.light * s.tas**2 * plane.area for s in low])
    alpha, gamma = (np.radians([getattr(s, name) for s in low]) for name in ("alpha", "gamma"))
    thrust = np.array([s.thrust for s in low])
    lift = (plane.weight * np.cos(gamma) - thrust * np.sin(alpha)) / force
    drag = (thrust * np.cos(alpha) - plane.weight * np.sin(gamma)) / force
    induced, zero = np.polyfit(lift**2, drag, 1)
    plane.put("lift slope", float(np.polyfit(alpha, lift, 1)[0]))
    plane.put("drag at zero lift", float(zero))
    plane.put("induced drag factor", float(induced))


def _lift_over_drag(state: TrimState, gamma: float | None = None) -> float:
    """Lift over drag in a glide, or in one with this path angle in deg at its airspeed.

    Idle thrust of a jet is excluded; the drag of a windmilling propeller counts.
    """
    alpha = math.radians(state.alpha)
    path = math.radians(state.gamma if gamma is None else gamma)
    thrust = max(state.thrust, 0.0) / state.weight
    drag = thrust * math.cos(alpha) - math.sin(path)
    return (math.cos(path) - thrust * math.sin(alpha)) / drag if drag > 0.0 else math.inf


def _ceilings(plane: Plane) -> None:
    """The altitudes at which the maximum rate of climb falls to 0 and to the service limit."""
    from scipy.optimize import brentq  # no trim needs it

    best: TrimState | None = None

    def climb(altitude: float) -> float:
        nonlocal best
        plane.climb_to(altitude)
        start = plane.climb(best.speed) if best else plane.first(plane.climb)
        if start is None:
            why, level = plane.reason, plane.first(plane.trim)
            plane.reason = why
            # a climb steeper than the trim can find, or too little thrust
            return math.inf if level and level.throttle[0] < 0.95 else -math.inf
        best = best_of(plane.climb, climb_rate, start, 1.1)
        return climb_rate(best)

    def over(limit: float, altitude: float) -> float:
        if altitude not in rates:
            rates[altitude] = climb(altitude)
        return min(max(rates[altitude] - limit, -_FASTEST), _FASTEST)

    plane.reason = "no engine"
    rates = {-5000.0: math.inf, 0.0: climb(0.0) if plane.airframe.engines else -math.inf}
    why = "below 0 ft" if math.isfinite(rates[0.0]) else plane.reason
    while (top := max(rates)) < _HIGHEST and rates[top] > 0.0:
        rates[top + 5000.0] = climb(top + 5000.0)
    ceiling = math.inf
    for name, limit in (("absolute", 0.0), ("service", 100.0 if plane.propeller else 500.0)):
        order = sorted(rates)
        high = next((i for i, altitude in enumerate(order) if rates[altitude] < limit), 0)
        if not high:
            least = min(rates, key=lambda altitude: rates[altitude])
            why = f"above {_HIGHEST:.0f} ft: its rate of climb has its minimum at {least:.0f} ft"
        if high < 2:
            plane.put(f"{name} ceiling", None, reason=why)
            continue
        edge = brentq(partial(over, limit), order[high - 1], order[high], xtol=10.0)
        # where the climb ends abruptly both searches end within 10 ft of the same altitude
        ceiling = min(edge, ceiling)
        no_climb = any(rates[h] == -math.inf for h in rates if abs(h - ceiling) < 20.0)
        at: Row = {"altitude_ft": ceiling, "speed": best.speed if best else math.nan}
        plane.put(f"{name} ceiling", ceiling, **at, reason=plane.reason if no_climb else "")


def _turns(plane: Plane) -> None:
    """Load factor, rate and radius of turns, sustained in level flight and at the lift limit."""
    plane.reason = "no engine"
    slow = plane.slowest() if plane.airframe.engines else None
    if slow is None or plane.trim(1.6 * slow.speed) is None:
        plane.put("sustained load factor", None)
        return
    kinds: dict[str, Callable[..., TrimState | None]]
    kinds = {"sustained": plane.trim, "instantaneous": partial(plane.trim, throttle=1.0)}
    for factor in (1.2, 1.4, 1.6, 1.85, 2.1, 2.8):
        speed, turn = factor * slow.speed, None
        for name, find in kinds.items():
            # start from the sustained turn, which can be flown for an instant too
            turn = _steepest(plane, partial(find, speed, mode="turn"), turn)
            at: Row = {"speed": speed, "reason": plane.reason}
            plane.put(f"{name} load factor", _turn_load(turn) if turn else None, **at)
            if turn is None:
                continue
            plane.put(f"{name} turn radius", turn.turn_radius, **at)
            plane.put(f"{name} side load", abs(turn.ny), **at)
            plane.put(f"{name} turn rate", abs(turn.turn_rate), **at)
            if factor == 1.6 and name == "sustained":
                flight = plane.steady_flight(turn, _TURN)
                psi = None if flight is None else np.unwrap(flight["psi"], period=360.0)
                plane.flown(None if psi is None else abs(float(psi[-1] - psi[0])) / _TURN)


def _turn_load(turn: TrimState) -> float:
    """Load factor: force across the path over weight, from turn rate and path angle."""
    centripetal = turn.tas * math.radians(turn.turn_rate) / GRAVITY
    return math.cos(math.radians(turn.gamma)) * math.hypot(1.0, centripetal)


def _steepest(
    plane: Plane, find: Callable[..., TrimState | None], level: TrimState | None
) -> TrimState | None:
    """The turn with the maximum load factor, by ever finer steps of the bank.

    The search starts at the ``level`` turn, if any, and returns it if no other has more: a trim
    with the path angle free may end in a spiral descent, steep and with a low load factor.
    """
    steepest = level
    load, ratio = (1.0 / math.cos(math.radians(level.phi)) if level else 1.02), 1.3
    while ratio > 1.01:
        n = load * ratio
        plane.reason = f"{_STEEPEST:g} g"
        turn = None if n > _STEEPEST else find(bank=math.degrees(math.acos(1.0 / n)))
        load, ratio = (n, ratio) if turn else (load, math.sqrt(ratio))
        steepest = max(filter(None, (steepest, turn)), key=_turn_load, default=None)
    return steepest


def _load_factors(plane: Plane) -> None:
    """V-n diagram: airspeeds at the lift limit, throttle closed, by load factor."""
    slow = plane.slowest()
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
        least = start and last(pull, start, 0.93)
        keas = _keas(plane, least) if least else None
        plane.put("speed at the lift limit", keas, load_factor=n, reason=plane.reason)
        if n == 1.0 and start is None:
            return
        if n == 2.0 and least and keas:
            lift = plane.lift_flown(plane.glide(least.speed), least, 2.0)
            plane.flown(keas / math.sqrt(lift) if lift else None)
    _gusts(plane, slow)


def _keas(plane: Plane, state: TrimState) -> float:
    return state.tas / KNOT * math.sqrt(plane.light)


def _gusts(plane: Plane, slow: TrimState) -> None:
    """Load factors in gusts of 50 ft/s at VC and 25 ft/s at VD, up to 20,000 ft.

    CS 23.341(c) (amendment 4; CS 25.341 requires the response to a tuned gust instead): n = 1 +-
    Kg rho0 U V a / (2 W/S), Kg = 0.88 mu / (5.3 + mu), mu = 2 (W/S) / (rho c a g); K. G. Pratt,
    W. G. Walker, NACA Report 1206, 1954. The models have no design speeds: VC = 0.9 VH and
    VD = 1.25 VC are the minimum values of CS 23.335.
    """
    start = plane.level(1.5 * slow.speed) if plane.airframe.engines else None
    cruise = 0.9 * last(plane.level, start, _GRID).speed if start else 2.0 * slow.speed
    for name, speed, gust in (("VC", cruise, 50.0), ("VD", 1.25 * cruise, 25.0)):
        pull = partial(plane.trim, speed, mode="pull-up", throttle=0.0)
        one, more = pull(load_factor=1.0), pull(load_factor=1.2)
        if one is None or more is None or plane.area <= 0.0 or plane.chord <= 0.0:
            plane.put(f"gust load factor at {name}", None)
            continue
        rho, wing = RHO0 * plane.light, plane.weight / plane.area
        lift = 0.2 * wing / (0.5 * rho * one.tas**2)
        slope = lift / math.radians(more.alpha - one.alpha)
        mu = 2.0 * wing / (rho * plane.chord * slope * GRAVITY)
        relief, keas = 0.88 * mu / (5.3 + mu), _keas(plane, one)
        jump = relief * RHO0 * gust * keas * KNOT * slope / (2.0 * wing)
        plane.put(name, keas)
        plane.put(f"gust load factor at {name}", 1.0 + jump, speed)


def _field(plane: Plane) -> None:
    """Take-off and landing; imported late because only these need PathSim."""
    from .field import field

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
    """The rows of each task, or the reason why an aircraft cannot be loaded or does not glide."""
    results = []
    for task in tasks:
        try:
            plane = Plane(task)
            _PARTS[task["part"]](plane)
            rows = plane.rows
        except BlocksError as error:
            rows = [{"chart": task["part"], "quantity": f"all of {task['part']}"}]
            rows[0] |= {"altitude_ft": task["altitude"], "weight_lb": task["weight"]}
            rows[0] |= {"flaps_norm": task["flaps"], "reason": reason_of(error)}
        results.append({"rows": rows})
    return results


def performance_table(
    aircraft: str,
    *,
    altitudes: float | Iterable[float] | None = None,
    weights: float | Iterable[float] | None = None,
    flaps: float | Iterable[float] | None = None,
    root: str | None = None,
    create: Mapping[str, float] | str | None = None,
    jobs: int = -1,
    resume: str | Path | None = None,
    progress: bool = True,
    parts: Sequence[str] = tuple(_PARTS),
) -> pd.DataFrame:
    """Performance of an aircraft: stall, level flight, climb, ceilings, glide, range, turns, V-n.

    Retractable gear is up, fuel frozen, piston engines leaned in proportion to the air density. A
    sample of each chart is flown with controls fixed.

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
    root, jobs, resume, progress
        as in `trim_sweep`
    create : dict or "missing", optional
        properties that the model expects from outside, with their values; other missing ones are
        created as 0
    parts : sequence of str, optional
        of `level` (level flight, climb, glide and range), `turn`, `V-n`, `ceiling`, `stall` and
        `field`; default all

    Returns
    -------
    pandas.DataFrame
        one row for each value: ``chart``, ``quantity``, its condition (``altitude_ft``,
        ``weight_lb``, ``flaps_norm``, ``speed_kcas``, ``load_factor``), ``value`` and ``unit``,
        ``flown``, the value measured in a time history, its ``difference_percent``, and ``reason``:
        why there is no value, or what limits it; ``fault``, the invariant of physics that a value
        breaks: stall speed grows with the weight and falls with the flaps, no climb with the
        throttle closed, climb falls with the altitude without a supercharger, load factors are
        within the limit of the same table. If the search of such a value gave up, it is removed

    Raises
    ------
    ParameterError
        for numbers that are impossible for any aircraft
    AircraftError
        for a model that is unknown or cannot be initialised
    """
    pd = required("pandas", "studies")
    airframe, _ = prepared(aircraft, root, create)
    jet = bool(airframe.engines and not airframe.of_engines("propeller-rpm"))
    at = _ALTITUDES[jet] if altitudes is None else _axis("altitude", altitudes)
    loadings = [None] if weights is None else _axis("weight", weights)
    settings = _FLAPS if flaps is None else _axis("flaps", flaps)
    common: Row = {"aircraft": airframe.aircraft, "root": root, "flaps": None}
    common["create"] = airframe.created
    common |= {"altitude": at[0], "weight": loadings[0]}
    selection = {one_of("parts", part, _PARTS) for part in name_list("parts", parts)}
    if not selection:
        refuse("parts", parts, "no parts")
    tasks = [{**common, "part": "level", "altitude": h, "weight": w} for w in loadings for h in at]
    tasks += [{**common, "part": part} for part in ("turn", "V-n", "field")]
    tasks += [{**common, "part": "ceiling", "weight": w} for w in loadings]
    loads = extremes(airframe) if weights is None else loadings
    tasks += [{**common, "part": "stall", "weight": w, "flaps": f} for w in loads for f in settings]
    tasks = [task for task in tasks if task["part"] in selection]
    results = run_parts(
        _work,
        [[task] for task in tasks],
        death={"rows": [{"quantity": "all of a part", "reason": WORKER_DIED}]},
        describe=lambda task: f"{aircraft}: {task['part']} at {task['altitude']:g} ft",
        title=f"charts of {aircraft}",
        job=lambda: {"aircraft": aircraft, "parts": tasks, **of_models([root])},
        jobs=jobs,
        resume=resume,
        progress=progress,
    )
    table = pd.DataFrame([row for part in results for row in part["rows"]], columns=list(COLUMNS))
    pistons = bool(airframe.engines) and len(airframe.of_engines("map-inhg")) == airframe.engines
    table.attrs["aircraft"] = aircraft
    return mark_faults(table, pistons and not ModelFile(aircraft, root).xml.supercharged)


def _axis(name: str, values: Any) -> list[float]:
    """One or several values of a field of the condition, checked, without repetitions."""
    one = isinstance(values, str) or not np.iterable(values)
    weigh = partial(positive, name)
    check = weigh if name == "weight" else lambda x: getattr(TrimCondition(**{name: x}), name)
    points = list(dict.fromkeys(check(x) for x in ([values] if one else values)))
    return points or refuse(name, values, f"no {name}")
