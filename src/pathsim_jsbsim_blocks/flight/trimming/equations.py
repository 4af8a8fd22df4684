"""Steady flight as equations: unknowns in, JSBSim's own accelerations out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from ..._core.aircraft_ports import throttles
from ..airframe import Airframe
from ..settling import Settling
from .condition import TrimCondition
from .failure import alpha_range
from .state import STATE


class Unknown(NamedTuple):
    """A quantity that the search may move."""

    start: float
    low: float
    high: float
    stride: float  # maximum change in one iteration
    step: float  # of its difference quotients


_DEG = math.pi / 180.0
_COMMAND = Unknown(0.0, -1.0, 1.0, 0.4, 1e-4)

# angles in rad; alpha, speed and rate depend on the aircraft. Roll and sideslip limits are those
# of JSBSim's FGTrimAxis. With a quarter of these strides the X15 does not reach its Mach 3 glide.
# Steps 100 times as long or 1000 times as short find the same trims: these are far from both ends
_UNKNOWNS = {
    "throttle": Unknown(0.5, 0.0, 1.0, 0.5, 1e-4),
    "gamma": Unknown(0.0, -60.0 * _DEG, 60.0 * _DEG, 5.0 * _DEG, 1e-5),
    "pitch_trim": _COMMAND,
    "elevator": _COMMAND,
    "phi": Unknown(0.0, -30.0 * _DEG, 30.0 * _DEG, 8.0 * _DEG, 1e-5),
    "beta": Unknown(0.0, -30.0 * _DEG, 30.0 * _DEG, 5.0 * _DEG, 1e-5),
    "aileron": _COMMAND,
    "rudder": _COMMAND,
}

# residuals, with their tolerances in ft/s2 and rad/s2: in the 5 s of a check they change the
# airspeed by 0.0005 ft/s and the attitude by 0.007 deg
RESIDUALS = dict.fromkeys(("udot", "vdot", "wdot"), 1e-4) | dict.fromkeys(
    ("pdot", "qdot", "rdot"), 1e-5
)
_LONGITUDINAL = ("udot", "wdot", "qdot")
_THRUST_TOLERANCE = 1e-3  # lbf

# properties written by one evaluation, and the values for them
_WRITTEN = (
    *(f"ic/{angle}-rad" for angle in ("psi-true", "theta", "phi")),
    *(f"ic/{axis}-fps" for axis in "uvw"),
    *(f"ic/{axis}-rad_sec" for axis in "pqr"),
    *(STATE[name] for name in ("pitch_trim", "elevator", "aileron", "rudder")),
)
_FLIGHT = itemgetter("speed", "alpha", "beta", "phi", "gamma", "psi")
_CONTROLS = itemgetter("pitch_trim", "elevator", "aileron", "rudder")

# maximum difference of two readings of one settled state, in tolerances
_SETTLED = 1e-6

# maximum readings of one state until a control system with memory has settled; 5 are too few for
# the X15 at Mach 3
_READINGS = 30

# maximum steps of JSBSim for all searches of one trim
_EFFORT = 100_000

# cost of one reading, including its part of the search, in steps of JSBSim
_READING = 4

# maximum number of steps in the memory of JSBSim's integrators
_HISTORY = 5

# maximum repetitions of settling the propellers at a state from another aircraft
_SPINS = 5


class Effort:
    """Approximate cost of all searches of one trim, in steps of JSBSim.

    Successful searches need 40,000 at most; a step takes 5 to 14 us (Short_S23: 60).
    """

    def __init__(self) -> None:
        self.steps = 0

    def spend(self, steps: int) -> None:
        self.steps += steps

    @property
    def over(self) -> bool:
        return self.steps > _EFFORT


class SteadyFlight:
    """Equations of steady flight of an airframe initialised at a condition.

    One evaluation writes a state and controls, and reads the accelerations of JSBSim without a step
    in time. Propellers turn at the speed at which they settle in held flight. The airframe is left
    in the state evaluated last.

    With ``in_time`` each reading ends with a step of almost zero length, which is slower but needed
    for turboprops, which have power only in such steps, and for actuators that move at their own
    rates (the f16's rudder restarts in each step).
    """

    def __init__(self, airframe: Airframe, condition: TrimCondition, effort: Effort, in_time: bool):
        self._airframe, self._condition, self.effort = airframe, condition, effort
        self.in_time = in_time
        fdm = self._fdm = airframe.fdm
        self._gravity = fdm["accelerations/gravity-ft_sec2"]
        speed = fdm[STATE["tas"]]
        # values of the quantities that the search does not move; true airspeed in ft/s
        self.given = {
            "speed": speed,
            "throttle": condition.throttle or 0.0,
            **dict.fromkeys(("pitch_trim", "aileron", "rudder"), 0.0),
            "elevator": fdm[STATE["elevator"]],
            "beta": math.radians(condition.beta),
            "gamma": math.radians(condition.gamma),
            "phi": math.radians(condition.bank),
            "psi": math.radians(condition.heading),
        }
        self._set_unknowns(self._free(speed))
        self._choose_residuals()
        self._find_engines()
        wind = condition.wind_north, condition.wind_east, 0.0
        self._wind = np.array(wind) if any(wind) else None
        # whether the flight control system needs more than one reading to settle
        self.has_memory = True

    def _free(self, speed: float) -> dict[str, Unknown]:
        """The unknowns; throttle last, because engines settle again after each of its changes."""
        condition, unknowns = self._condition, dict(_UNKNOWNS)
        low, high = (math.radians(angle) for angle in alpha_range(self._airframe))
        unknowns["alpha"] = Unknown(0.0, low, high, 5.0 * _DEG, 1e-5)
        unknowns["gamma"] = unknowns["gamma"]._replace(start=math.radians(condition.gamma))
        unknowns["speed"] = Unknown(speed, 0.3 * speed, 3.0 * speed, 0.2 * speed, 1e-5 * speed)
        # within 1 g of side load from the rate of a coordinated turn
        most = self._gravity / speed
        rate = most * math.tan(math.radians(condition.bank))
        unknowns["rate"] = Unknown(rate, rate - most, rate + most, 0.1 * most, 1e-5)
        names = ["alpha", "pitch_trim"]
        if condition.mode == "turn":
            names += ["beta" if condition.coordinated else "rate"]
        elif condition.mode != "longitudinal":
            names += ["phi"]
        if condition.mode != "longitudinal":
            names += ["aileron", "rudder"]
        if condition.balance != "throttle":
            names.append(condition.balance)
        if condition.balance == "throttle" or condition.thrust is not None:
            names.append("throttle")
        return {name: unknowns[name] for name in names}

    def _set_unknowns(self, unknowns: dict[str, Unknown]) -> None:
        self.unknowns = unknowns
        self.names = list(unknowns)
        self.start, self.low, self.high, self.strides, self._steps = np.array(
            list(unknowns.values())
        ).T

    def without_pitch_trim(self) -> None:
        """Use the elevator instead of the pitch trim, which the model does not have."""
        self._set_unknowns(
            {"elevator" if name == "pitch_trim" else name: x for name, x in self.unknowns.items()}
        )

    def _choose_residuals(self) -> None:
        airframe, condition = self._airframe, self._condition
        self.used = _LONGITUDINAL if condition.mode == "longitudinal" else tuple(RESIDUALS)
        self._all_residuals = airframe.reader_of([STATE[name] for name in RESIDUALS])
        self._read = airframe.reader_of([STATE[name] for name in self.used])
        # zero except in turns with wind, and for a prescribed thrust
        self._targets = dict.fromkeys(RESIDUALS, 0.0)
        if condition.thrust is not None:
            self.used = *self.used, "thrust"
            accelerations = self._read
            thrusts = airframe.reader_of(airframe.of_engines("thrust-lbs"))
            self._read = lambda: [*accelerations(), sum(thrusts())]
            self._targets["thrust"] = condition.thrust
        self._target = np.array([self._targets[name] for name in self.used])
        tolerances = {**RESIDUALS, "thrust": _THRUST_TOLERANCE}
        self._tolerances = np.array([tolerances[name] for name in self.used])

    def _find_engines(self) -> None:
        airframe = self._airframe
        self._engines = airframe.engines
        self._write = airframe.writer_of([*_WRITTEN, *throttles(self._engines)])
        self.propellers = Settling(airframe, self.effort.spend, lambda: self.effort.over)
        # the throttle at which the propellers have settled
        self._settled_at: float | None = None

    @property
    def leaves_traces(self) -> bool:
        """Whether evaluations change the state of engines or systems."""
        return self.propellers.required or self.has_memory

    def try_out(self) -> None:
        """Determine whether the model has a pitch trim, and whether its controls have filters."""
        x = np.clip(self.start, self.low, self.high)
        i = self.names.index("pitch_trim")
        y = x.copy()
        y[i] += 0.1
        base = self.residuals(x)
        self._put(y)
        first, second = self._accelerations(), self._accelerations()
        self.has_memory = not size(second - first) <= _SETTLED
        if size(second - base) <= _SETTLED:
            self.without_pitch_trim()

    def guess(self, alpha: float, throttle: float) -> np.ndarray:
        """Initial unknowns for an alpha in deg and a throttle."""
        x = self.start.copy()
        x[self.names.index("alpha")] = math.radians(alpha)
        if "throttle" in self.names:
            x[self.names.index("throttle")] = throttle
        return x

    def settled(self, x: np.ndarray) -> np.ndarray:
        """Residuals after engines and flight control system have settled."""
        self._settled_at = None
        return self.residuals(x)

    def trial(self, x: np.ndarray) -> np.ndarray:
        """Residuals after a step of the search, which may be large."""
        return self.settled(x) if self.propellers.required else self.residuals(x)

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """The residuals at a state, divided by their tolerances."""
        throttle = self._put(x)
        r = self._accelerations()
        if self.propellers.required and throttle != self._settled_at:
            self.propellers.start(crank=self._condition.mode != "glide")
            self.propellers.settle(min(max(1e-10 * size(r), 1e-10), 1e-8))
            self._settled_at = throttle
            self._put(x)
            r = self._accelerations()
        for _ in range(_READINGS if self.has_memory else 0):
            last, r = r, self._accelerations()
            if size(r - last) <= _SETTLED:
                break
        return r

    def slopes(self, x: np.ndarray, r: np.ndarray) -> np.ndarray:
        """Difference quotients of the residuals, which are ``r`` at ``x``."""
        slopes = np.empty((len(r), len(x)))
        for i, step in enumerate(self._steps.tolist()):
            if x[i] + step > self.high[i]:
                step = -step
            y = x.copy()
            y[i] += step
            slopes[:, i] = (self.residuals(y) - r) / step
        return slopes

    def arrive(self, x: np.ndarray) -> tuple[np.ndarray, dict[str, float]]:
        """Leave the airframe in a state: residuals in tolerances, and in their units."""
        has_memory, self.has_memory = self.has_memory, True
        r = self.settled(x)
        self.has_memory = has_memory
        values = zip(RESIDUALS, self._all_residuals(), strict=True)
        residuals = {name: value - self._targets[name] for name, value in values}
        self._forget()
        return r, residuals

    def hold(self, x: np.ndarray) -> None:
        """Set the airframe to a state from another one."""
        for _ in range(_SPINS):
            if size(self.settled(x)) <= 1.0:
                break
        self._forget()

    def _forget(self) -> None:
        """Clear the integrators' memory of earlier accelerations."""
        for _ in range(_HISTORY if self.in_time else 0):
            self._airframe.run_no_time()

    def _put(self, x: Sequence[float] | np.ndarray) -> float:
        """Write state and controls; returns the throttle."""
        condition = self._condition
        values = {**self.given, **dict(zip(self.names, np.asarray(x).tolist(), strict=True))}
        v, alpha, beta, phi, gamma, psi = _FLIGHT(values)
        throttle = values["throttle"]
        theta = _theta(alpha, beta, phi, gamma)
        p = q = r = 0.0
        if condition.mode == "turn":
            if "rate" in values:
                rate = values["rate"]
            else:  # r u - p w = g sin(phi) cos(theta): no side force
                forward = math.cos(theta) * math.cos(phi) * math.cos(alpha)
                forward += math.sin(theta) * math.sin(alpha)
                rate = self._gravity * math.sin(phi) * math.cos(theta)
                rate /= v * math.cos(beta) * forward
            p = -rate * math.sin(theta)
            q = rate * math.cos(theta) * math.sin(phi)
            r = rate * math.cos(theta) * math.cos(phi)
        elif condition.mode == "pull-up":
            q = self._gravity * (condition.load_factor - math.cos(gamma)) / v
        level_speed = v * math.cos(beta)
        ground = level_speed * math.cos(alpha), v * math.sin(beta), level_speed * math.sin(alpha)
        if self._wind is not None:
            wind = _to_body(phi, theta, psi) @ self._wind
            ground = tuple((wind + ground).tolist())
            # in body axes of a turning aircraft the wind rotates
            turning = -np.cross([p, q, r], wind)
            self._targets.update(zip(("udot", "vdot", "wdot"), turning.tolist(), strict=True))
            self._target = np.array([self._targets[name] for name in self.used])
        commands = [*_CONTROLS(values), *[throttle] * self._engines]
        self._write([psi, theta, phi, *ground, p, q, r, *commands])
        return throttle

    def _accelerations(self) -> np.ndarray:
        fdm = self._fdm
        # in trim status actuators take their final position immediately, and no fuel is burnt
        fdm.set_trim_status(True)
        try:
            fdm.run_ic()
            if self.in_time:
                self._airframe.start_turbines()
        finally:
            fdm.set_trim_status(False)
        if self.in_time:
            self._airframe.run_no_time()
        self.effort.steps += _READING
        return (np.array(self._read()) - self._target) / self._tolerances


def size(r: np.ndarray) -> float:
    """Maximum of the residuals, in tolerances; infinite if one is not finite."""
    sizes = list(map(abs, r.tolist()))
    return max(sizes) if all(map(math.isfinite, sizes)) else math.inf


def _theta(alpha: float, beta: float, phi: float, gamma: float) -> float:
    """Pitch angle for a path angle, all in rad (Stevens and Lewis, 3rd edition, 3.6-3)."""
    a = math.cos(alpha) * math.cos(beta)
    b = math.sin(phi) * math.sin(beta) + math.cos(phi) * math.sin(alpha) * math.cos(beta)
    s = math.sin(gamma)
    return math.atan2(a * b + s * math.sqrt(max(a * a - s * s + b * b, 0.0)), a * a - s * s)


def _to_body(phi: float, theta: float, psi: float) -> np.ndarray:
    """Rotation from north, east, down to body axes."""
    cf, sf = math.cos(phi), math.sin(phi)
    ct, st = math.cos(theta), math.sin(theta)
    cp, sp = math.cos(psi), math.sin(psi)
    x = ct * cp, ct * sp, -st
    y = sf * st * cp - cf * sp, sf * st * sp + cf * cp, sf * ct
    z = cf * st * cp + sf * sp, cf * st * sp - sf * cp, cf * ct
    return np.array([x, y, z])
