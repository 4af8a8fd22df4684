"""Newton search for steady flight on JSBSim's own accelerations, within the controls' limits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from ..airframe import Airframe
from .condition import TrimCondition
from .failure import alpha_range
from .state import STATE


class _Range(NamedTuple):
    """A quantity that the search may move."""

    start: float
    low: float
    high: float
    stride: float  # largest change in one iteration
    step: float  # of its difference quotients


_DEG = math.pi / 180.0
_COMMAND = _Range(0.0, -1.0, 1.0, 0.4, 1e-4)

# rad and ft/s; alpha and speed depend on the aircraft. Roll and sideslip as in JSBSim's FGTrimAxis
_RANGES = {
    "throttle": _Range(0.5, 0.0, 1.0, 0.5, 1e-4),
    "gamma": _Range(0.0, -60.0 * _DEG, 60.0 * _DEG, 5.0 * _DEG, 1e-5),
    "pitch_trim": _COMMAND,
    "elevator": _COMMAND,
    "phi": _Range(0.0, -30.0 * _DEG, 30.0 * _DEG, 8.0 * _DEG, 1e-5),
    "beta": _Range(0.0, -30.0 * _DEG, 30.0 * _DEG, 5.0 * _DEG, 1e-5),
    "aileron": _COMMAND,
    "rudder": _COMMAND,
}

# in this order a limit is taken for the cause of a failure: slow flight needs too much alpha first,
# and then more thrust and elevator than there are
_CAUSES = ("alpha", "throttle", "gamma", "speed", *list(_RANGES)[2:])

# deg, first guesses of alpha
_ALPHAS = (3.0, 9.0, -1.0)

# what is to vanish, and to which tolerance in ft/s2 and rad/s2
RESIDUALS = dict.fromkeys(("udot", "vdot", "wdot"), 1e-4) | dict.fromkeys(
    ("pdot", "qdot", "rdot"), 1e-5
)
_LONGITUDINAL = ("udot", "wdot", "qdot")
_THRUST_TOLERANCE = 1e-3  # lbf

# what one evaluation writes, and from what
_WRITTEN = (
    *(f"ic/{angle}-rad" for angle in ("psi-true", "theta", "phi")),
    *(f"ic/{axis}-fps" for axis in "uvw"),
    *(f"ic/{axis}-rad_sec" for axis in "pqr"),
    *(f"fcs/{name}-cmd-norm" for name in ("pitch-trim", "elevator", "aileron", "rudder")),
)
_FLIGHT = itemgetter("speed", "alpha", "beta", "phi", "gamma", "psi")
_CONTROLS = itemgetter("pitch_trim", "elevator", "aileron", "rudder")

# fractions of the tolerances: where the search ends, and what two readings may differ by
_POLISHED = 1e-5
_SETTLED = 1e-6

# a step that promises to leave more than this of the residuals ends the search; with a quantity at
# the end of its range, which is where most failures end, more is asked for
_MAX_LEFT = 0.98
_MAX_LEFT_AT_LIMIT = 0.9

_ITERATIONS = 30
_READINGS = 30  # of one state, until a flight control system with memory has settled

# what one search may take in steps of JSBSim (those that find a trim take 40,000 at most), and all
# searches of one trim together; a step takes 5 to 14 us (Short_S23: 60)
_BUDGET = 60_000
EFFORT = 100_000

# what one reading with its share of the search, and JSBSim's own settling of an engine are counted
# as; the latter takes 1 to 170
_READING = 4
_STEADY_STATE = 150

# s, in which nothing moves, and the steps that JSBSim's integrators remember at most
_INSTANT = 1e-12
_HISTORY = 5

# rows of steps in which an engine with propeller settles, and how often
_ROW = 40
_ROWS = 60

# how often propellers may settle anew to hold a state found elsewhere
_SPINS = 5

# rows with blades that no governor moves: engines that settle then need 3
_ROWS_AT_FIXED_PITCH = 10


class Seed(NamedTuple):
    """Where a search found its trim, for the next one near it."""

    # as of `Found`, and the slopes of the residuals by these, in tolerances
    free: Mapping[str, float]
    slopes: np.ndarray
    # whether the flight control system takes more than one reading to settle
    has_memory: bool
    in_time: bool


class Found(NamedTuple):
    """Where a search ended."""

    # whether all residuals are within their tolerances
    converged: bool
    # what the search moved: rad, ft/s, fractions of a command's range
    free: Mapping[str, float]
    # the one at the end of its range that holds the search back; empty if none is
    binding: str
    residuals: Mapping[str, float]
    # for the next search, if this one has converged
    seed: Seed | None


class Effort:
    """Steps of JSBSim that Newton searches have taken together, roughly."""

    steps = 0

    @property
    def over(self) -> bool:
        """Whether they have taken all that they may."""
        return self.steps > EFFORT


class Search:
    """Steady flight of an airframe initialised at a condition.

    One evaluation writes a state and controls, and reads the accelerations of JSBSim without a step
    in time. Propellers turn at the speed at which they settle: JSBSim holds the aircraft and blows
    its airspeed at it. The search leaves the airframe in the state found.

    With ``in_time`` each reading ends with a step of no length, which takes longer: only in steps
    of time have turboprops power, and only there do actuators move at their own rates (those of the
    f16's rudder start anew in each step). ``effort`` is what the searches of one trim have taken.
    """

    def __init__(
        self, airframe: Airframe, condition: TrimCondition, effort: Effort, in_time: bool = False
    ):
        self._airframe, self._condition = airframe, condition
        self._effort, self._start = effort, effort.steps
        self.in_time = in_time
        fdm = self._fdm = airframe.fdm
        engines = range(airframe.engines)
        self._speed = fdm["velocities/vt-fps"]
        self._ranges = self._free()
        self._limits = np.array([[r.low, r.high] for r in self._ranges.values()]).T
        self._strides = np.array([r.stride for r in self._ranges.values()])
        self._used = _LONGITUDINAL if condition.mode == "longitudinal" else tuple(RESIDUALS)
        tolerances = dict(RESIDUALS)
        readers = {name: airframe.reader(STATE[name]) for name in RESIDUALS}
        # zero but for turns in wind and a thrust
        self._targets = dict.fromkeys(RESIDUALS, 0.0)
        if condition.thrust is not None:
            self._used = *self._used, "thrust"
            tolerances["thrust"] = _THRUST_TOLERANCE
            thrusts = [airframe.reader(name) for name in airframe.of_engines("thrust-lbs")]
            readers["thrust"] = lambda: sum(read() for read in thrusts)
            self._targets["thrust"] = condition.thrust
        self._readers = readers
        self._read = [readers[name] for name in self._used]
        self._target = np.array([self._targets[name] for name in self._used])
        self._tolerances = np.array([tolerances[name] for name in self._used])
        self._throttles = [airframe.writer(f"fcs/throttle-cmd-norm[{i}]") for i in engines]
        self._write = [airframe.writer(name) for name in _WRITTEN] + self._throttles
        # what the search does not move
        self._given = {
            "speed": self._speed,
            "throttle": condition.throttle or 0.0,
            **dict.fromkeys(("pitch_trim", "aileron", "rudder"), 0.0),
            "elevator": fdm["fcs/elevator-cmd-norm"],
            "beta": math.radians(condition.beta),
            "gamma": math.radians(condition.gamma),
            "phi": math.radians(condition.bank),
            "psi": math.radians(condition.heading),
        }
        speeds, pitches, governors = map(
            airframe.of_engines, ("propeller-rpm", "blade-angle", "constant-speed-mode")
        )
        self._pitches = [airframe.reader(name) for name in pitches]
        self._propellers = [airframe.reader(name) for name in speeds] + self._pitches
        self._governors = [name for name in governors if fdm[name]]
        spools = airframe.of_engines("n1")
        self._read_spools = [airframe.reader(name) for name in spools]
        self._write_spools = [airframe.writer(name) for name in spools]
        self._gravity = fdm["accelerations/gravity-ft_sec2"]
        wind = condition.wind_north, condition.wind_east, 0.0
        self._wind = np.array(wind) if any(wind) else None
        self._settled_at: float | None = None
        # JSBSim's own settling, in steps of 0.5 s, ends beside the equilibrium of fast propellers
        self._leaps = True
        self._has_memory = True

    @property
    def leaves_traces(self) -> bool:
        """Whether a search that fails leaves engines or systems in another state than it found."""
        return bool(self._propellers) or self._has_memory

    @property
    def _spent(self) -> bool:
        """Whether the search has taken all that it may."""
        return self._effort.steps - self._start > _BUDGET or self._effort.over

    def _free(self) -> dict[str, _Range]:
        """The quantities that may move, throttle last: its engines settle anew."""
        condition = self._condition
        ranges = dict(_RANGES)
        low, high = (math.radians(angle) for angle in alpha_range(self._airframe))
        ranges["alpha"] = _Range(0.0, low, high, 5.0 * _DEG, 1e-5)
        gamma = math.radians(condition.gamma)
        ranges["gamma"] = ranges["gamma"]._replace(start=gamma)
        v = self._speed
        ranges["speed"] = _Range(v, 0.3 * v, 3.0 * v, 0.2 * v, 1e-5 * v)
        names = ["alpha", "pitch_trim"]
        if condition.mode != "longitudinal":
            names += ["beta" if condition.mode == "turn" else "phi", "aileron", "rudder"]
        if condition.balance != "throttle":
            names.append(condition.balance)
        if condition.balance == "throttle" or condition.thrust is not None:
            names.append("throttle")
        return {name: ranges[name] for name in names}

    def find(self, seed: Seed | None = None) -> Found:
        """Search from a seed, and without success from one first guess after the other."""
        time = self._fdm.get_sim_time()
        x, slopes = self._from(seed) if seed else (None, None)
        if x is None:
            x, slopes = self._from_guesses()
        has_memory, self._has_memory = self._has_memory, True
        # the last state written need not be the best
        r = self._settled(x)
        residuals = {name: self._readers[name]() - self._targets[name] for name in RESIDUALS}
        self._has_memory = has_memory
        converged = self._size(r) <= 1.0
        self._forget()
        self._fdm.set_sim_time(time)
        free = dict(zip(self._ranges, x.tolist(), strict=True))
        if not converged:
            return Found(False, free, self._binding(x, r), residuals, None)
        seed = None if slopes is None else Seed(free, slopes, has_memory, self.in_time)
        return Found(True, free, "", residuals, seed)

    def hold(self, found: Found) -> None:
        """Put the aircraft into the state that a search has found, engines and systems settled."""
        if "elevator" in found.free:
            self._without_pitch_trim()
        self._has_memory = found.seed is None or found.seed.has_memory
        x = np.array(list(found.free.values()))
        for _ in range(_SPINS):
            if self._size(self._settled(x)) <= 1.0:
                break
        self._forget()

    def _forget(self) -> None:
        """Let the integrators forget the accelerations before the step of no length."""
        for _ in range(_HISTORY if self.in_time else 0):
            self._run_no_time()

    def _from(self, seed: Seed) -> tuple[np.ndarray | None, np.ndarray | None]:
        """Where the search from a seed ends; None if it does not find a trim to full precision."""
        if "elevator" in seed.free:
            self._without_pitch_trim()
        # otherwise it is from a search of another kind
        if list(seed.free) == list(self._ranges) and len(seed.slopes) == len(self._used):
            self._has_memory = seed.has_memory
            x = np.array(list(seed.free.values())).clip(*self._limits)
            x, r, slopes = self._descend(x, seed.slopes)
            if self._size(r) <= _POLISHED:
                return x, slopes
            self._has_memory = True
            self._effort.steps = self._start
        self._ranges = self._free()
        return None, None

    def _from_guesses(self) -> tuple[np.ndarray, np.ndarray | None]:
        """Where the best of the searches from the first guesses ends."""
        best: tuple[float, np.ndarray, np.ndarray | None] | None = None
        low, high = self._limits
        start = np.clip([r.start for r in self._ranges.values()], low, high)
        self._try_out(start)
        for alpha in _ALPHAS:
            x = start.copy()
            x[list(self._ranges).index("alpha")] = math.radians(alpha)
            x, r, slopes = self._descend(np.clip(x, low, high))
            size = self._size(r)
            if best is None or size < best[0]:
                best, binding = (size, x, slopes), self._binding(x, r)
            if best[0] <= 1.0 or self._spent or binding:
                break
        assert best is not None
        return best[1:]

    def _try_out(self, x: np.ndarray) -> None:
        """Find out whether the model has pitch trim, and whether its controls have filters."""
        i = list(self._ranges).index("pitch_trim")
        y = x.copy()
        y[i] += 0.1
        before = self._residuals(x)
        self._put(y)
        first, second = self._accelerations(), self._accelerations()
        self._has_memory = not self._size(second - first) <= _SETTLED
        if self._size(second - before) <= _SETTLED:
            self._without_pitch_trim()

    def _without_pitch_trim(self) -> None:
        self._ranges = {
            "elevator" if name == "pitch_trim" else name: quantity
            for name, quantity in self._ranges.items()
        }

    def _at_limit(self, x: np.ndarray) -> np.ndarray:
        return (x <= self._limits[0]) | (x >= self._limits[1])

    def _binding(self, x: np.ndarray, r: np.ndarray) -> str:
        """The quantity at the end of its range that holds the search back; empty if none is."""
        more = {"alpha": r[self._used.index("wdot")] > 0.0}
        if self._condition.thrust is None:
            more["throttle"] = r[0] < 0.0
        ends = zip(self._ranges, self._at_limit(x), x >= self._limits[1], strict=True)
        # not where a search has got stuck and the other end would help
        names = [name for name, at, end in ends if at and more.get(name, end) == end]
        return min(names, key=_CAUSES.index, default="")

    def _size(self, r: np.ndarray) -> float:
        """Largest of the residuals, in tolerances."""
        sizes = list(map(abs, r.tolist()))
        return max(sizes) if all(map(math.isfinite, sizes)) else math.inf

    def _descend(
        self, x: np.ndarray, slopes: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Gauss-Newton from ``x``: where it ends, residuals in tolerances, and slopes there."""
        low, high = self._limits
        r = self._settled(x)
        norm = self._norm(r)
        for _ in range(_ITERATIONS):
            if self._size(r) <= _POLISHED or not math.isfinite(norm) or self._spent:
                break
            fresh = slopes is None
            if slopes is None:
                slopes = self._slopes(x, r)
                if not np.all(np.isfinite(slopes)):
                    break
            full = self._step(x, r, slopes)
            left = r + slopes @ full
            most = _MAX_LEFT_AT_LIMIT if self._at_limit(x + full).any() else _MAX_LEFT
            if self._norm(left) > most * norm:
                if fresh:
                    break
                slopes = None
                continue
            for fraction in (1.0, 0.4, 0.16, 0.06, 0.02) if fresh else (1.0,):
                y = np.minimum(np.maximum(x + fraction * full, low), high)
                ry = self._settled(y) if self._propellers else self._residuals(y)
                shorter = self._norm(ry)
                if shorter < norm * (1.0 - 1e-3 * fraction):
                    break
            else:
                if fresh:
                    break
                slopes = None
                continue
            moved = (y - x) / self._strides
            if shorter < 0.5 * norm:
                # Broyden's update in the scaled unknowns
                gap = ry - r - slopes @ (y - x)
                slopes = slopes + gap[:, None] * (moved / self._strides / (moved @ moved))
            else:
                slopes = None
            x, r, norm = y, ry, shorter
        return x, r, slopes

    def _norm(self, r: np.ndarray) -> float:
        norm = math.sqrt(r @ r)
        return norm if math.isfinite(norm) else math.inf

    def _slopes(self, x: np.ndarray, r: np.ndarray) -> np.ndarray:
        slopes = np.empty((len(r), len(x)))
        high = self._limits[1]
        for i, quantity in enumerate(self._ranges.values()):
            step = quantity.step if x[i] + quantity.step <= high[i] else -quantity.step
            y = x.copy()
            y[i] += step
            slopes[:, i] = (self._residuals(y) - r) / step
        return slopes

    def _step(self, x: np.ndarray, r: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """The step of Newton, or the best one within limits and strides."""
        strides = self._strides
        scaled = slopes * strides
        # at a limit the interval would be empty
        low = np.minimum(np.maximum((self._limits[0] - x) / strides, -1.0), -1e-12)
        high = np.maximum(np.minimum((self._limits[1] - x) / strides, 1.0), 1e-12)
        return _bounded(scaled, -r, low, high, _solution(scaled, -r)) * strides

    def _settled(self, x: np.ndarray) -> np.ndarray:
        """Residuals after engines and flight control system have settled."""
        self._settled_at = None
        return self._residuals(x)

    def _residuals(self, x: np.ndarray) -> np.ndarray:
        """The residuals at a state, in their tolerances."""
        throttle = self._put(x)
        r = self._accelerations()
        if self._propellers and throttle != self._settled_at:
            self._spin(self._size(r))
            self._settled_at = throttle
            self._put(x)
            r = self._accelerations()
        for _ in range(_READINGS if self._has_memory else 0):
            before, r = r, self._accelerations()
            if self._size(r - before) <= _SETTLED:
                break
        return r

    def _put(self, x: np.ndarray) -> float:
        """Write state and controls; returns the throttle."""
        condition = self._condition
        values = {**self._given, **dict(zip(self._ranges, x.tolist(), strict=True))}
        v, alpha, beta, phi, gamma, psi = _FLIGHT(values)
        throttle = values["throttle"]
        theta = _theta(alpha, beta, phi, gamma)
        p = q = r = 0.0
        if condition.mode == "turn":
            rate = self._gravity * math.tan(phi) / v
            p = -rate * math.sin(theta)
            q = rate * math.cos(theta) * math.sin(phi)
            r = rate * math.cos(theta) * math.cos(phi)
        elif condition.mode == "pull-up":
            q = self._gravity * (condition.load_factor - math.cos(gamma)) / v
        across = v * math.cos(beta)
        ground = across * math.cos(alpha), v * math.sin(beta), across * math.sin(alpha)
        if self._wind is not None:
            wind = _to_body(phi, theta, psi) @ self._wind
            ground = tuple((wind + ground).tolist())
            # the wind turns in the axes of an aircraft that turns
            turning = -np.cross([p, q, r], wind)
            self._targets.update(zip(("udot", "vdot", "wdot"), turning.tolist(), strict=True))
            self._target = np.array([self._targets[name] for name in self._used])
        throttles = (throttle for _ in self._throttles)
        state = psi, theta, phi, *ground, p, q, r, *_CONTROLS(values), *throttles
        for write, value in zip(self._write, state, strict=True):
            write(value)
        return throttle

    def _accelerations(self) -> np.ndarray:
        fdm = self._fdm
        # actuators then take their final position at once, and no fuel is burnt
        fdm.set_trim_status(True)
        try:
            fdm.run_ic()
            if self.in_time:
                self._start_turbines()
        finally:
            fdm.set_trim_status(False)
        if self.in_time:
            self._run_no_time()
        self._effort.steps += _READING
        return (np.array([read() for read in self._read]) - self._target) / self._tolerances

    def _start_turbines(self) -> None:
        """Take the step with which JSBSim starts turbines at idle, and keep their speeds."""
        speeds = [read() for read in self._read_spools]
        self._run_no_time()
        for write, speed in zip(self._write_spools, speeds, strict=True):
            write(speed)

    def _run_no_time(self) -> None:
        """A step of JSBSim in which nothing moves; its systems take a step of usual length."""
        self._fdm.set_dt(_INSTANT)
        self._fdm.run()
        self._fdm.set_dt(self._airframe.dt)

    def _spin(self, size: float) -> None:
        """Let the propellers settle in a wind tunnel: held in place, in the wind of the flight."""
        fdm = self._fdm
        tolerance = min(max(1e-10 * size, 1e-10), 1e-8)
        for axis in ("north", "east", "down"):
            still = fdm[f"atmosphere/total-wind-{axis}-fps"]
            fdm[f"atmosphere/wind-{axis}-fps"] = still - fdm[f"velocities/v-{axis}-fps"]
        fdm["forces/hold-down"] = 1.0
        fdm.set_trim_status(True)
        try:
            self._spin_at_fixed_pitch()
            before = [read() for read in self._propellers]
            for row in range(_ROWS):
                at_once = self._leaps and not self._governors
                if self._spent or (at_once and row >= _ROWS_AT_FIXED_PITCH):
                    break
                pitch = [read() for read in self._pitches]
                for _ in range(_ROW):
                    fdm.run()
                self._effort.steps += _ROW
                now = [read() for read in self._propellers]
                pairs = zip(now, before, strict=True)
                if all(abs(a - b) <= tolerance * max(abs(a), 1.0) for a, b in pairs):
                    break
                if self._leaps and pitch == [read() for read in self._pitches]:
                    self._spin_at_fixed_pitch()
                    again = [read() for read in self._propellers]
                    self._leaps = math.dist(again, before) > 0.01 * math.dist(now, before)
                    now = again
                before = now
        finally:
            fdm["forces/hold-down"] = 0.0
            fdm.set_trim_status(False)

    def _spin_at_fixed_pitch(self) -> None:
        """Settle the speeds at the present blade angles, many times faster than real time."""
        if not self._leaps:
            return
        # in its steps of 0.5 s a governor would overshoot
        for governor in self._governors:
            self._fdm[governor] = 0.0
        self._fdm.get_propulsion().get_steady_state()
        self._effort.steps += _STEADY_STATE * len(self._throttles)
        for governor in self._governors:
            self._fdm[governor] = 1.0


def _bounded(
    a: np.ndarray, b: np.ndarray, low: np.ndarray, high: np.ndarray, best: np.ndarray
) -> np.ndarray:
    """Least squares of a x - b within limits, low < high; ``best`` is the optimum without them."""
    # the active set method of Stark and Parker (1995), started with the limits that the optimum
    # without limits exceeds; scipy's lsq_linear is slower, also to import
    held = (best < low) | (best > high)
    if not held.any():
        return best
    x = np.minimum(np.maximum(best, low), high)
    square, aim, unit = a.T @ a, a.T @ b, np.eye(len(best))
    limits = list(zip(low.tolist(), high.tolist(), strict=True))
    for _ in range(4 * len(x)):
        fixed = np.where(held, x, 0.0)
        aims = np.where(held, fixed, aim - square @ fixed)
        y = _solution(np.where(held[:, None] | held, unit, square), aims)
        # as far as the first limit
        ways = [
            1.0 if least <= to <= most else ((least if to < least else most) - at) / (to - at)
            for at, to, (least, most) in zip(x.tolist(), y.tolist(), limits, strict=True)
        ]
        way = min(ways)
        if way < 1.0:
            i = ways.index(way)
            x = x + max(way, 0.0) * (y - x)
            x[i] = low[i] if y[i] < low[i] else high[i]
            held[i] = True
            continue
        x = y
        # how much each limit holds back; negative where it does not
        uphill = a.T @ (a @ x - b)
        back = np.where(held, np.where(x <= low, uphill, -uphill), 0.0)
        i = int(back.argmin())
        if back[i] >= -1e-10 * (1.0 + abs(uphill).max()):
            break
        held[i] = False
    return x


def _solution(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The solution of a x = b, the least one if there are many; NaN where numbers overflow."""
    try:
        return np.linalg.solve(a, b)
    except np.linalg.LinAlgError:
        # of infinities it never returns
        if np.isfinite(a).all() and np.isfinite(b).all():
            return np.linalg.lstsq(a, b, rcond=None)[0]
        return np.full(len(b), math.nan)


def _theta(alpha: float, beta: float, phi: float, gamma: float) -> float:
    """Pitch angle of a path angle, all in rad (Stevens and Lewis, 3rd edition, 3.6-3)."""
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
