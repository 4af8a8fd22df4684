"""Flight tests of one aircraft: searches by trims, and flights that check their results."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from .._core.checks import refuse
from .._core.units import FOOT
from ..air import isa
from ..errors import BlocksError
from ..flight import Airframe, TrimState, trim
from ..flight.fleet import prepared
from ..flight.trimming.nearest import speed_of_lift

Row = dict[str, Any]
Find = Callable[[float], TrimState | None]
Size = Callable[[TrimState], float]

_FINEST = 1.001  # ratio of speeds at which a search ends
_GUESSES = (0.4, 0.6, 0.25, 0.8, 1.2, 0.15, 1.6)  # lift coefficients of the first trims

_FLIGHT = 60.0  # s, duration of a checking flight
_CLIMB = 5000.0  # ft, within which a climb or descent hardly changes: a steep flight is shorter
_DEPARTED = 0.15  # relative airspeed change beyond which a flight no longer represents a condition

_MOST = 1000  # trims for one part of the charts, against endless searches; 20 to 300 are usual
LARGE = 19000.0  # lb, above which CS-25 applies
_LEAST_FUEL = 0.05  # of full tanks
_HEAVIEST = 1.5  # times the weight with full tanks and the model's payload

# at sea level an aircraft would otherwise roll on the ground
_NO_GROUND = {"ic/terrain-elevation-ft": -5000.0}

_RECORDED = {
    "h": "position/h-sl-ft",
    "v": "velocities/vt-fps",
    "vc": "velocities/vc-kts",
    "alpha": "aero/alpha-rad",
    "gamma": "flight-path/gamma-rad",
    "nx": "accelerations/Nx",
    "nz": "accelerations/Nz",
    "psi": "attitude/psi-deg",
    "q": "aero/qbar-psf",
    "w": "inertia/weight-lbs",
    "g": "accelerations/gravity-ft_sec2",
}

# chart and unit of each quantity
QUANTITIES = {
    "stall speed": ("stall", "KCAS"),
    "stall speed, throttle closed": ("envelope", "KTAS"),
    "highest level Mach number": ("envelope", ""),
    "lowest level Mach number": ("envelope", ""),
    "highest level speed": ("level", "KTAS"),
    "lowest level speed": ("level", "KTAS"),
    "thrust available": ("level", "lbf"),
    "thrust required": ("level", "lbf"),
    "thrust of level flight": ("level", "lbf"),
    "power available": ("level", "hp"),
    "power required": ("level", "hp"),
    "rate of climb": ("climb", "ft/min"),
    "best rate of climb": ("climb", "ft/min"),
    "climb angle": ("climb", "deg"),
    "best angle of climb": ("climb", "deg"),
    "Vx": ("climb", "KCAS"),
    "Vy": ("climb", "KCAS"),
    "absolute ceiling": ("climb", "ft"),
    "service ceiling": ("climb", "ft"),
    "sink rate": ("glide", "ft/min"),
    "least sink rate": ("glide", "ft/min"),
    "best glide ratio": ("glide", ""),
    "fuel flow": ("range", "lb/h"),
    "least fuel flow": ("range", "lb/h"),
    "specific range": ("range", "nmi/lb"),
    "best specific range": ("range", "nmi/lb"),
    "sustained load factor": ("turn", "g"),
    "instantaneous load factor": ("turn", "g"),
    "sustained side load": ("turn", "g"),
    "instantaneous side load": ("turn", "g"),
    "sustained turn rate": ("turn", "deg/s"),
    "instantaneous turn rate": ("turn", "deg/s"),
    "sustained turn radius": ("turn", "ft"),
    "instantaneous turn radius": ("turn", "ft"),
    "speed at the lift limit": ("V-n", "KEAS"),
    "VC": ("V-n", "KEAS"),
    "VD": ("V-n", "KEAS"),
    "gust load factor at VC": ("V-n", "g"),
    "gust load factor at VD": ("V-n", "g"),
    "take-off distance": ("field", "ft"),
    "take-off ground roll": ("field", "ft"),
    "landing distance": ("field", "ft"),
    "landing ground roll": ("field", "ft"),
    "lift slope": ("terms", "1/rad"),
    "drag at zero lift": ("terms", ""),
    "induced drag factor": ("terms", ""),
    "full thrust at Vy": ("terms", "lbf"),
}


def reason_of(error: BlocksError) -> str:
    """Reason for a missing trim: the error's keyword if it has one, else its text."""
    return getattr(error, "reason", str(error))


class Plane:
    """An aircraft at one weight that is trimmed repeatedly, with a twin for flights, and results.

    Every result is a row: its condition, the value, the value flown, or the reason for none.
    """

    def __init__(self, task: Mapping[str, Any]):
        self._trims = 0
        self.airframe, base = prepared(task["aircraft"], task["root"], task["create"])
        self.create = self.airframe.created
        self.flyer = partial(Airframe, task["aircraft"], root=task["root"], create=self.create)
        self.rows: list[Row] = []
        self.reason = ""
        self._twin: Airframe | None = None
        fdm = self.airframe.fdm
        self.area, self.chord = (fdm[f"metrics/{name}"] for name in ("Sw-sqft", "cbarw-ft"))
        self.propeller = bool(self.airframe.of_engines("propeller-rpm"))
        self.weight = fdm["inertia/weight-lbs"]
        # reset the fuel in every trim: a flight that burns fuel would make the next one lighter
        mass: dict[str, Any] = {"fuel": [fdm[name] for name in self.airframe.tanks]}
        if task["weight"] is not None:
            self.weight, mass = task["weight"], loading(self.airframe, task["weight"])
        self.base = replace(base, flaps=task["flaps"], **mass)
        self.mixtures = self._mixtures()
        self.climb_to(task["altitude"])

    def _mixtures(self) -> list[str]:
        """The mixture commands of piston engines, without those that the model sets itself."""
        engines = range(self.airframe.engines if self.airframe.of_engines("map-inhg") else 0)
        names = [f"fcs/mixture-cmd-norm[{i}]" for i in engines]
        for name in names:
            self.airframe.fdm[name] = 0.5
        self.airframe.run_ic()
        return [name for name in names if self.airframe.fdm[name] == 0.5]

    def climb_to(self, altitude: float) -> None:
        """Change the altitude, with piston engines leaned in proportion to the air density."""
        self.light = float(isa(altitude * FOOT).density / isa(0.0).density)
        lean = dict.fromkeys(self.mixtures, min(self.light, 1.0))
        setup = {**self.base.setup, **_NO_GROUND, **lean}
        self.base = replace(self.base, altitude=altitude, setup=setup)

    def put(self, quantity: str, value: float | None, speed: float = math.nan, **more: Any) -> None:
        """Record a value, at an airspeed in KCAS, or the reason for None."""
        chart, unit = QUANTITIES[quantity]
        row: Row = {"chart": chart, "quantity": quantity, "altitude_ft": self.base.altitude}
        row |= {"weight_lb": self.weight, "flaps_norm": self.base.flaps or 0.0}
        row |= {"speed_kcas": speed, "value": math.nan if value is None else value, "unit": unit}
        self.rows.append(row | {"reason": self.reason if value is None else "", **more})

    def flown(self, value: float | None) -> None:
        """Add the flown value of the last quantity, and the difference in percent."""
        row = self.rows[-1]
        if value is None:
            row["reason"] = "the flight does not stay at the condition"
        else:
            row["flown"] = value
            row["difference_percent"] = 100.0 * (value - row["value"]) / row["value"]

    def trim(self, speed: float, **fields: Any) -> TrimState | None:
        """The trim at an airspeed in KCAS; None without one, with ``reason`` set."""
        self._trims += 1
        if self._trims > _MOST:
            self.reason = f"more than {_MOST} trims"
            return None
        try:
            condition = replace(self.base, speed=speed, **fields)
            return trim(self.airframe, condition, hint=False, warm=True)
        except BlocksError as error:
            self.reason = reason_of(error)
            return None

    def level(self, speed: float) -> TrimState | None:
        """Level flight, or a climb at full throttle if the thrust jumps at afterburner light-up."""
        state = self.trim(speed)
        if state is None and self.reason == "no convergence" and not self.propeller:
            full = self.climb(speed)
            state = full if full and full.gamma >= 0.0 else None
        return state

    def climb(self, speed: float) -> TrimState | None:
        return self.trim(speed, throttle=1.0)

    def glide(self, speed: float) -> TrimState | None:
        return self.trim(speed, mode="glide")

    def fly(
        self, state: TrimState, duration: float, elevator: float = 0.0, **fields: Any
    ) -> dict[str, np.ndarray] | None:
        """A flight from the condition of a trim; ``elevator`` is the rate of its command in 1/s."""
        self._twin = plane = self._twin or self.flyer()
        try:
            trim(plane, replace(state.condition, **fields), hint=False, warm=True)
        except BlocksError:
            return None
        fdm, rows = plane.fdm, []
        read = plane.reader_of([*_RECORDED.values(), *plane.of_engines("fuel-flow-rate-pps")])
        start = fdm["fcs/elevator-cmd-norm"]
        for step in range(round(duration / plane.dt)):
            if elevator:
                fdm["fcs/elevator-cmd-norm"] = max(start + elevator * step * plane.dt, -1.0)
            fdm.run()
            rows.append(read())
        if plane.starved():
            # engines without fuel would restart only during the next flight
            self._twin = None
        signals = np.array(rows).T
        if not np.isfinite(signals).all():
            return None
        record = dict(zip(_RECORDED, signals, strict=False))
        return {**record, "fuel": signals[len(_RECORDED) :].sum(axis=0)}

    def steady_flight(
        self, state: TrimState, duration: float, **fields: Any
    ) -> dict[str, np.ndarray] | None:
        """A flight with controls fixed; None if it leaves the airspeed of the trim."""
        flight = self.fly(state, duration, **fields)
        if flight is None or abs(flight["vc"] / state.speed - 1.0).max() > _DEPARTED:
            return None
        return flight

    def first(self, find: Find) -> TrimState | None:
        """The first trim near a speed at which the wing lifts the weight."""
        speeds = (speed_of_lift(self.weight, max(self.area, 1.0), c) for c in _GUESSES)
        return next(filter(None, map(find, speeds)), None)

    def slowest(self) -> TrimState:
        """The glide at maximum lift coefficient; ``reason`` says what limits it."""
        start = self.first(self.glide)
        if start is None:
            raise BlocksError(self.reason)
        self.reason = "maximum lift"
        return last(self.glide, start, 0.93, _lift)

    def energy_rate(self, state: TrimState) -> float | None:
        """Rate of change of the energy height in ft/min in a flight with controls fixed.

        The flight passes the trim's altitude at half time. Three flights adjust the initial
        airspeed so that the last passes it at the trim's airspeed. A phugoid changes the energy
        only through the drag due to its load factor: the difference of two pull-ups corrects this.
        """
        climb = climb_rate(state)
        climbs = abs(climb) > 1.0
        seconds = min(_FLIGHT, 60.0 * _CLIMB / abs(climb)) if climbs else _FLIGHT
        altitude = max(state.condition.altitude - 0.5 * climb * seconds / 60.0, -1500.0)
        speed = state.speed
        for _ in range(3 if climbs else 1):
            flight = self.steady_flight(state, seconds, altitude=altitude, speed=speed)
            if flight is None:
                return None
            middle = len(flight["h"]) // 2
            passage = abs(flight["h"] - state.condition.altitude).argmin() if climbs else middle
            speed *= state.speed / flight["vc"][passage]
        assert flight is not None
        height = flight["h"] + 0.5 * flight["v"] ** 2 / flight["g"]
        at = np.linspace(-0.5, 0.5, len(height))
        slope = np.polyder(np.polyfit(at, height, 5))
        rate = float(np.polyval(slope, at[passage])) * 60.0 / seconds
        # both, as an engine may run in a pull-up that stands in the glide
        throttle = max(state.throttle, default=0.0)
        pull_up = partial(self.trim, state.speed, mode="pull-up", throttle=throttle)
        loads = math.cos(math.radians(state.gamma)), float(_load_factor(flight)[passage])
        rates = [climb_rate(pull) for load in loads if (pull := pull_up(load_factor=load))]
        return rate + rates[0] - rates[1] if len(rates) == 2 else rate

    def lift_flown(self, start: TrimState | None, limit: TrimState, seconds: float) -> float | None:
        """Maximum lift coefficient in a pull to the limit's elevator, relative to the limit's.

        The pull lasts ``seconds``; only the flight below the limit's angle of attack counts, and
        none that does not reach it.
        """
        if start is None:
            return None
        up = [state.pitch_trim + state.elevator for state in (start, limit)]
        flight = self.fly(start, 2.0 * seconds, (up[1] - up[0]) / seconds)
        if flight is None:
            return None
        is_stall = flight["alpha"] >= math.radians(limit.alpha)
        if not is_stall.any():
            return None
        end = max(int(is_stall.argmax()), 1)
        lift = (_load_factor(flight)[:end] / flight["q"][:end]).max()
        pressure = flight["q"][0] * (limit.tas / flight["v"][0]) ** 2
        pulls = limit.condition.mode == "pull-up"
        load = limit.condition.load_factor if pulls else math.cos(math.radians(limit.gamma))
        return float(lift * pressure / load)


def _masses(airframe: Airframe) -> tuple[float, list[float], list[float]]:
    """Weight without fuel and payload, contents of full tanks, and payload of the model, in lb."""
    fdm = airframe.fdm
    fuel = [fdm[name] for name in airframe.tanks]
    percent = [fdm[name.replace("contents-lbs", "pct-full")] for name in airframe.tanks]
    full = [100.0 * x / p if p > 0.0 else 0.0 for x, p in zip(fuel, percent, strict=True)]
    names = map("inertia/pointmass-weight-lbs[{}]".format, itertools.count())
    payload = [fdm[name] for name in itertools.takewhile(airframe.has, names)]
    return fdm["inertia/weight-lbs"] - sum(fuel) - sum(payload), full, payload


def extremes(airframe: Airframe) -> list[float | None]:
    """Gross weights in lb: almost empty, the model's own (None), full tanks and payload."""
    empty, full, payload = _masses(airframe)
    light, heavy = empty + _LEAST_FUEL * sum(full), empty + sum(full) + sum(payload)
    gross = airframe.fdm["inertia/weight-lbs"]
    return [x for x in (light, None, heavy) if x is None or abs(x / gross - 1.0) > 0.02]


def loading(airframe: Airframe, weight: float) -> dict[str, Any]:
    """Fuel, then payload, that make up a gross weight in lb: fields of a `TrimCondition`."""
    empty, full, payload = _masses(airframe)
    tanks, useful = sum(full), sum(payload)
    low, high = empty + _LEAST_FUEL * tanks, empty + tanks
    high = _HEAVIEST * (high + useful) if payload else high
    if not low - 0.5 <= weight <= high + 0.5:
        why = f"{airframe.aircraft} weighs from {low:,.0f} lb, almost without fuel and payload, to "
        refuse("weight", weight, f"{why}{high:,.0f} lb in a chart, not {weight:,.0f} lb")
    part = min(max((weight - empty - useful) / tanks, _LEAST_FUEL), 1.0) if tanks else 0.0
    remainder = max(weight - empty - part * tanks, 0.0)
    shares = [x / useful if useful else 1.0 / len(payload) for x in payload]
    fields = {"fuel": [part * x for x in full], "payload": [remainder * share for share in shares]}
    return {name: values for name, values in fields.items() if values}


def climb_rate(state: TrimState) -> float:
    """Rate of climb in ft/min."""
    return 60.0 * state.tas * math.sin(math.radians(state.gamma))


def _lift(state: TrimState) -> float:
    """Lift over weight and square of the Mach number: a lift coefficient."""
    return math.cos(math.radians(state.gamma)) / state.mach**2


def last(find: Find, good: TrimState, ratio: float, size: Size | None = None) -> TrimState:
    """The last trim in ever finer steps of speed by a ratio; ``size``, if set, must keep growing.

    The plane's ``reason`` tells why the search ended.
    """
    while abs(math.log(ratio)) > math.log(_FINEST):
        nearer = find(good.speed * ratio)
        if nearer is not None and (size is None or size(nearer) > size(good)):
            good = nearer
        else:
            ratio = math.sqrt(ratio)
    return good


def best_of(find: Find, size: Size, start: TrimState, ratio: float = 1.05) -> TrimState:
    """The trim that maximises ``size`` over the speeds around ``start``."""
    best = start
    while ratio > _FINEST**2:
        up, down = find(best.speed * ratio), find(best.speed / ratio)
        top = max(filter(None, (best, up, down)), key=size)
        if top is not best:
            best = top
            continue
        bend = size(up) + size(down) - 2.0 * size(best) if up and down else 0.0
        if up and down and bend < 0.0:
            # the vertex of the parabola through the three
            vertex = find(best.speed * ratio ** (0.5 * (size(down) - size(up)) / bend))
            best = max(filter(None, (best, vertex)), key=size)
        ratio = ratio**0.3
    return best


def _load_factor(flight: Mapping[str, np.ndarray]) -> np.ndarray:
    """Force across the flight path over the weight, from a flight that starts in a steady state.

    It is scaled to the initial value, the cosine of the path angle: the Earth's rotation makes the
    weight slightly less than mass times gravitation.
    """
    force = flight["nx"] * np.sin(flight["alpha"]) + flight["nz"] * np.cos(flight["alpha"])
    return force / force[0] * np.cos(flight["gamma"][0])
