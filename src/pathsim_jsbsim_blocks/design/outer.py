"""The loops around the attitude: yaw damper, turn coordination, heading, airspeed, altitude."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import linprog
from scipy.signal import fftconvolve

from .._core.units import GRAVITY
from ..control.gains import AltitudeGains, HeadingGains, SpeedGains, YawGains
from ..control.loops import BEYOND
from .margins import Margins, margins
from .plant import Plant
from .requirements import (
    BAND,
    BANK,
    DUTCH_ROLL,
    GUST,
    MARGINS,
    STEP_REQUIREMENTS,
    StepRequirement,
    relaxation_text,
    requirement_met,
)
from .search import (
    ALONE,
    OMEGA,
    LoopReport,
    Neighbours,
    at,
    crossing,
    grid,
    integral,
    margins_of,
    settled,
    step_quality,
)
from .turbulence import AIR, Rough, at_a_stop, rms

# periods of the loop in one step of a slow response
_COARSE = 6

# 1/s; a slower divergence is left to the loops around
_DIVERGES = 0.03

# of the gain with which the rudder would move the yaw rate as much as it is
_YAW_SHARES = np.geomspace(0.03, 1.5, 24)


def design_yaw(plant: Plant, room: float) -> YawGains:
    """Rudder from washed-out yaw rate: the lowest gain that damps the Dutch roll."""
    bare = dutch_roll(plant)
    if bare is None or bare[1] >= DUTCH_ROLL:
        return YawGains(K=0.0)
    g = plant.response(OMEGA, "rudder")["r"]
    washed = _wash_out(plant.T, YawGains.tau) * g
    k = int(np.argmin(np.abs(OMEGA - bare[0])))
    K = -np.sign(washed[k].real) * _YAW_SHARES / np.abs(g[k])
    # 10 deg/s of yaw should not need all of the rudder
    K = K[np.abs(K) * 10.0 <= 0.9 * room]
    if not len(K):
        return YawGains(K=0.0)
    found = margins(OMEGA, -K[:, None] * washed)
    level = requirement_met(found)
    best = None
    for i in np.flatnonzero(level == 0):
        mode = dutch_roll(damped(plant, YawGains(K=float(K[i]))))
        damping = 1.0 if mode is None else mode[1]
        if best is None or damping > best[0]:
            best = damping, i
        if damping >= DUTCH_ROLL:
            break
    if best is None or best[0] < bare[1] + 0.02:
        return YawGains(K=0.0)
    return YawGains(K=float(K[best[1]]))


def _wash_out(T: float, tau: float) -> np.ndarray:
    """Frequency response of the wash-out of the yaw rate."""
    z = np.exp(1j * OMEGA * T)
    return (z - 1.0) / (z - math.exp(-T / tau))


def dutch_roll(plant: Plant) -> tuple[float, float] | None:
    """Frequency in rad/s and damping ratio of the oscillation that moves the sideslip most."""
    poles, vectors = np.linalg.eig(plant.A)
    s = np.log(np.where(np.abs(poles) < 1e-9, 1e-9, poles)) / plant.T
    slip = np.abs(plant.row("beta") @ vectors)
    turn = np.abs(plant.row("r") @ vectors)
    other = np.abs(plant.row("q") @ vectors) + 1e-12
    lateral = (slip + turn) / (slip + turn + other)
    w = np.abs(s)
    wanted = (s.imag > 0.2) & (w > 0.3) & (w < 15.0) & (lateral > 0.5)
    if not wanted.any():
        return None
    # as a kick of the rudder excites it
    size = np.abs(np.linalg.pinv(vectors) @ plant.column("rudder"))
    i = int(np.argmax(np.where(wanted, slip * size, -1.0)))
    return float(w[i]), float(-s[i].real / w[i])


def damped(plant: Plant, gains: YawGains) -> Plant:
    """The plant with the rudder's loops closed; ``rudder`` stays an input, added to theirs."""
    T = plant.T
    slow = 1.0 - math.exp(-T / gains.tau)
    return plant.close(
        "rudder",
        law=np.array([[1.0 - slow, 0.0], [0.0, 1.0], [-gains.K, 1.0]]),
        read={"r": np.array([slow, 0.0]), "beta": np.array([0.0, -gains.Ki * T])},
        through={
            "r": gains.K,
            "beta": -gains.Kp,
            "p": gains.Kroll,
            "phi": gains.Kbank,
            "rudder": 1.0,
        },
        reference="rudder",
    )


# shares of the damper's gain, and of what the rudder can do to the sideslip; Ki / Kp, 1/s
_SLIP_DAMPERS = np.linspace(0.0, 3.0, 7)
_SLIP_GAINS = np.linspace(0.0, 1.4, 8)
_SLIP_RATES = np.linspace(0.0, 1.4, 5)

# rad/s up to which a turn is entered
_ENTRY = 0.6


def design_rudder(
    plant: Plant,
    damper: YawGains,
    room: float,
    vt: float,
    ramp: float,
    near: Neighbours = ALONE,
) -> tuple[YawGains, LoopReport | None]:
    """Rudder from yaw rate, sideslip and roll, so that a bank turns the aircraft and nothing else.

    ``plant`` has the roll loop closed with the input ``phi_cmd``, and no loop at the rudder.
    """
    T = plant.T
    rudder, bank = plant.response(OMEGA, "rudder"), plant.response(OMEGA, "phi_cmd")
    wash = _wash_out(T, damper.tau)
    sign = float(np.sign(rudder["beta"][0].real))
    slip = np.abs(rudder["beta"][:60]).max()
    dampers = damper.K * _SLIP_DAMPERS if damper.K else np.zeros(1)
    K, P, rate = grid(dampers, _SLIP_GAINS, _SLIP_RATES)
    P = P * sign * 4.0 / slip
    K, P, Ki = near.joined("yaw", K=K, Kp=P, Ki=P * rate)
    used = (np.abs(K) * 10.0 + np.abs(P) * 5.0) / room
    K, P, Ki, used = (x[used <= 0.9] for x in (K, P, Ki, used))
    on_slip = P[:, None] + Ki[:, None] * integral(OMEGA, T)
    on_rate = K[:, None] * wash
    found = margins(OMEGA, on_slip * rudder["beta"] - on_rate * rudder["r"])
    command = (on_rate * bank["r"] - on_slip * bank["beta"]) / (
        1.0 + on_slip * rudder["beta"] - on_rate * rudder["r"]
    )
    beta = np.abs(bank["beta"] + command * rudder["beta"])
    psi = np.abs((bank["psi"] + command * rudder["psi"]) * OMEGA * vt / GRAVITY)
    entry = 1.0 / np.hypot(1.0, OMEGA / _ENTRY)
    score = (
        BANK * (beta * entry).max(axis=1)
        + np.where(OMEGA < 10.0, psi, 0.0).max(axis=1)
        + 0.5 * used
        + near.cost("yaw", K=K, Kp=P, Ki=Ki)
    )
    score[requirement_met(found) > 0] = np.inf
    chosen = damper
    for i in np.argsort(score)[:30]:
        if not math.isfinite(score[i]):
            break
        gains = YawGains(K=float(K[i]), tau=damper.tau, Kp=float(P[i]), Ki=float(Ki[i]))
        if damped(plant, gains).growth() < _DIVERGES:
            chosen = gains
            break
    chosen = coordinate(plant, chosen, room, ramp)
    use = (
        abs(chosen.K) * 10.0
        + abs(chosen.Kp) * 5.0
        + abs(chosen.Kroll) * ramp
        + abs(chosen.Kbank) * BANK
    ) / room
    margins_ = margins_of(_of_rudder(plant, chosen), 0)
    return chosen, LoopReport("yaw", *margins_, use=use) if use else None


# s of a turn's entry, largest share of the rudder's remaining travel that it may need, and
# the shares of the best coordination that are tried for the margins
_ROLL_IN, _TURN_USE = 12.0, 0.6
_COORDINATED = np.linspace(1.0, 0.3, 5)

# cost of the rudder's whole travel, as deg of sideslip
_RUDDER_COST = 0.3


def coordinate(plant: Plant, yaw: YawGains, room: float, ramp: float) -> YawGains:
    """Rudder from roll rate and bank for the least sideslip in the entry of a turn.

    ``plant`` has the roll loop closed with the input ``phi_cmd``, and no loop at the rudder. For a
    given roll the sideslip is linear in the two gains, so a linear programme finds its smallest
    peak; this is repeated with the roll that results. The gains are then lowered until the rudder's
    margins are met.

    Parameters
    ----------
    plant : Plant
    yaw : YawGains
        the rudder's other gains
    room : float
        travel of the rudder
    ramp : float
        of the bank's reference, deg/s
    """
    feed, found = np.zeros(2), (math.inf, np.zeros(2))
    for rounds_left in (3, 2, 1, 0):
        beta, p, phi, kick = _entry(
            plant, replace(yaw, Kroll=float(feed[0]), Kbank=float(feed[1])), ramp
        )
        use = np.abs(feed[0] * p + feed[1] * phi).max()
        score = np.abs(beta).max() + _RUDDER_COST * max(use / room - _TURN_USE, 0.0)
        if score < found[0]:
            found = score, feed
        if not rounds_left or not np.isfinite(kick).all():
            break
        effect = np.array([fftconvolve(kick, signal)[: len(kick)] for signal in (p, phi)])
        feed = feed + _least_peak(beta, effect.T, np.abs(p).max(), np.abs(phi).max(), room)
    # a divergence that is there without them, as at low airspeed, is left to the outer loops
    most = max(_DIVERGES, 1.01 * damped(plant, yaw).growth())
    for share in _COORDINATED:
        gains = replace(yaw, Kroll=float(share * found[1][0]), Kbank=float(share * found[1][1]))
        if (
            requirement_met(_of_rudder(plant, gains))[0] == 0
            and damped(plant, gains).growth() < most
        ):
            return gains
    return yaw


def _entry(
    plant: Plant, gains: YawGains, ramp: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Sideslip, roll rate and bank in the entry of a turn; sideslip after an impulse of rudder."""
    p = damped(plant, gains).slower(_COARSE)
    turn = p.steps(
        "phi_cmd",
        ("beta", "p", "phi"),
        lambda k, y: min(ramp * p.T * k, BANK),
        1,
        _ROLL_IN,
    )
    kick = p.steps("rudder", ("beta",), lambda k, y: float(k == 0), 1, _ROLL_IN)
    return turn[:, 0, 0], turn[:, 1, 0], turn[:, 2, 0], kick[:, 0, 0]


def _least_peak(
    beta: np.ndarray, effect: np.ndarray, p: float, phi: float, room: float
) -> np.ndarray:
    """Gains that minimise max |beta + effect gains| plus a small cost of the rudder's travel."""
    cost = _RUDDER_COST / room * np.array([p, phi])
    m = effect.shape[1]
    # positive and negative parts of the gains, and the largest sideslip
    one = np.ones((len(beta), 1))
    both = np.hstack([effect, -effect])
    found = linprog(
        np.concatenate([cost, cost, [1.0]]),
        A_ub=np.block([[both, -one], [-both, -one]]),
        b_ub=np.concatenate([-beta, beta]),
    )
    return np.zeros(m) if found.x is None else found.x[:m] - found.x[m : 2 * m]


def _of_rudder(plant: Plant, gains: YawGains) -> Margins:
    """Margins of the rudder's loops, broken at the rudder."""
    g = plant.response(OMEGA, "rudder")
    L = (
        (gains.Kp + gains.Ki * integral(OMEGA, plant.T)) * g["beta"]
        - gains.K * _wash_out(plant.T, gains.tau) * g["r"]
        - gains.Kroll * g["p"]
        - gains.Kbank * g["phi"]
    )
    return margins(OMEGA, L[None])


_HEADING_SHARES = np.geomspace(0.25, 1.6, 14)


def design_heading(
    plant: Plant,
    ramp: float,
    settling: float,
    vt: float,
    straight: float = 0.0,
    near: Neighbours = ALONE,
) -> tuple[HeadingGains, LoopReport] | None:
    """Bank per heading error; ``plant`` has the roll loop closed with the input ``phi_cmd``.

    ``straight`` is the bank of straight flight in deg: with a propeller it is not 0.
    """
    turn = GRAVITY / vt  # psi-dot per phi, 1/s
    fast = min(0.25, 0.7 / max(settling if math.isfinite(settling) else 5.0, 0.5))
    (Kp,) = near.joined("heading", Kp=fast / turn * _HEADING_SHARES)
    Kp = np.clip(Kp, 0.3, 6.0)
    found = margins(OMEGA, Kp[:, None] * plant.response(OMEGA, "phi_cmd")["psi"])
    level = requirement_met(found)
    p, required = plant.slower(_COARSE), STEP_REQUIREMENTS["heading"]
    cmd = np.zeros(len(Kp))

    def law(k: int, y: np.ndarray) -> np.ndarray:
        wanted = np.clip(Kp * (required.size - y[0]), -BANK, BANK)
        cmd[:] += np.clip(wanted - cmd, -ramp * p.T, ramp * p.T)
        return cmd

    y = p.steps("phi_cmd", ("psi", "phi"), law, len(Kp), 60.0)
    time, over, _ = step_quality(y[:, 0] - required.size, required.tolerance, p.T)
    bank = np.abs(y[:, 1]).max(axis=0)
    score = time + 200.0 * np.maximum(over - 0.5 * required.overshoot, 0.0) + 10.0 * level
    score += required.size / (turn * BANK) * near.cost("heading", Kp=Kp)
    score = np.where(np.isfinite(score), score, 1e6 + over)
    i = int(np.argmin(score))
    if level[i] == len(MARGINS) or not math.isfinite(time[i]):
        return None
    return HeadingGains(Kp=float(Kp[i]), bank=straight), LoopReport(
        "heading",
        *margins_of(found, i),
        float(time[i]),
        float(over[i]),
        float(bank[i] / BANK),
        relaxed=relaxation_text(
            level[i], f"overshoot {over[i]:.1f} deg" if over[i] > required.overshoot else ""
        ),
    )


_SPEED_SHARES = np.geomspace(0.15, 1.0, 6)
# where turbulence is light, as at high altitude
_HIGHER_SHARES = np.geomspace(1.0, 4.0, 5)
_SPEED_TIMES = np.geomspace(6.0, 75.0, 7)
_SPEED_RAMPS = np.geomspace(0.3, 1.0, 4)
_SPEED_WEIGHTS = np.linspace(0.5, 1.25, 16)

# shares of the throttle that a rate of climb takes to be fed forward
_SPEED_RISES = np.linspace(0.0, 1.0, 3)
_UNFED = 20.0  # s of settling, for none of it

# weight of the time within 0.2 kt, as a step of 25 kt needs it
_LARGER = 0.5


@dataclass(frozen=True)
class _SpeedLoops:
    """Candidates for the airspeed loop, arrays of shape (loops,), and what they are flown with."""

    plant: Plant
    room: tuple[float, float]
    step: float
    Kp: np.ndarray
    Ki: np.ndarray
    Kc: np.ndarray
    margins: Margins
    rough: Rough
    cost: np.ndarray  # of all but the step, s of settling
    required: StepRequirement = STEP_REQUIREMENTS["speed"]

    def steps(
        self, j: np.ndarray, b: np.ndarray, ramp: np.ndarray, band: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Errors, shape (samples, loops), below 0 before the step is reached; largest commands."""
        p, sign = self.plant.slower(_COARSE), math.copysign(1.0, self.step)
        dt, a = p.T, -math.expm1(-p.T / SpeedGains.Tf)
        Kp, Ki, Kc = self.Kp[j], self.Ki[j], self.Kc[j]
        total, slow, peak = np.zeros(len(j)), np.zeros(len(j)), np.zeros(len(j))
        unwind = Ki / np.maximum(Kp, 1e-12)

        def law(k: int, y: np.ndarray) -> np.ndarray:
            ref = sign * np.minimum(k * dt * ramp, abs(self.step))
            error = ref - y[0]
            error -= BEYOND * (error - np.minimum(np.maximum(error, -band), band))
            slow[:] += a * (ref - error - slow)
            v = Kp * (b * ref - slow) + total + Kc * y[1]
            u = np.minimum(np.maximum(v, self.room[0]), self.room[1])
            np.maximum(peak, np.abs(v), out=peak)
            total[:] += Ki * dt * error + unwind * dt * (u - v)
            return u

        y = p.steps("throttle", ("vc", "hdot"), law, len(j), self.required.seconds)
        return sign * (y[:, 0] - self.step), peak

    def fly(
        self, j: np.ndarray, b: np.ndarray, ramp: np.ndarray, band: float
    ) -> tuple[np.ndarray, ...]:
        """Score, settling, overshoot, last error and use of steps, and the time within 0.2 kt."""
        error, peak = self.steps(j, b, ramp, band)
        dt, use = _COARSE * self.plant.T, peak / min(-self.room[0], self.room[1])
        there = self.room[1] if self.step > 0.0 else -self.room[0]
        time, over, late = step_quality(error, self.required.tolerance, dt)
        score = (
            np.maximum(time, self.required.quick)
            + 30.0 * np.maximum(over - 0.25, 0.0)
            + 300.0 * np.maximum(late - 0.1, 0.0)
            + 5.0 * use
            + 60.0 * np.maximum(peak / there - self.required.use, 0.0)
        )
        return score, time, over, late, use, settled(error, 0.2, dt)

    def referred(self, j: int, band: float) -> tuple[SpeedGains, float, float, float]:
        """The gains of one with the best weight and ramp of the reference, and its step.

        With the ``band``, or the widest one where no step settles with it.
        """
        b, ramp = grid(_SPEED_WEIGHTS, _SPEED_RAMPS)
        for kept in dict.fromkeys((band, GUST)):
            score, time, over, _, use, close = self.fly(np.full(len(b), j), b, ramp, kept)
            i = int(np.argmin(score + _LARGER * np.minimum(close, self.required.seconds)))
            if math.isfinite(time[i]):
                break
        Kp = float(self.Kp[j])
        gains = SpeedGains(
            Kp=Kp,
            Ki=float(self.Ki[j]),
            Kd=-Kp * SpeedGains.Tf,
            Tf=SpeedGains.Tf,
            b=float(b[i]),
            ramp=float(ramp[i]),
            Kc=float(self.Kc[j]),
            band=kept,
        )
        return gains, float(time[i]), float(over[i]), float(use[i])


def _speed_loops(
    plant: Plant,
    room: tuple[float, float],
    Kc: float,
    step: float,
    stops: float,
    near: Neighbours,
    shares: np.ndarray,
) -> tuple[_SpeedLoops, np.ndarray]:
    """All combinations of shares, integral times and shares of the feed-forward; their levels."""
    T, g, travel = plant.T, plant.response(OMEGA, "throttle"), min(-room[0], room[1])
    share, time, rise = grid(shares, _SPEED_TIMES, _SPEED_RISES)
    Kp = share * travel / GUST
    Kp, Ki, feed = near.joined("speed", Kp=Kp, Ki=Kp / time, Kc=rise * Kc)
    feed = np.minimum(feed, Kc)
    alpha = -math.expm1(-T / SpeedGains.Tf)
    z = np.exp(1j * OMEGA * T)
    slope = alpha / (1 - (1 - alpha) / z) * (1 - 1 / z) / T
    law = Kp[:, None] * (1 - SpeedGains.Tf * slope) + Ki[:, None] * integral(OMEGA, T)
    L = law * g["vc"] - feed[:, None] * g["hdot"]
    found = margins(OMEGA, L)
    level = requirement_met(found)
    air = [plant.response(OMEGA, name) for name in AIR if name in plant.inputs]
    moved = [(feed[:, None] * gust["hdot"] - law * gust["vc"]) / (1.0 + L) for gust in air]
    none = np.zeros(len(Kp))
    rough = Rough(none, none, at_a_stop(rms(OMEGA, *moved, np.zeros_like(L)), room))
    cost = (
        60.0 * level
        + 10.0 * Kp * GUST / travel
        + _UNFED * (1.0 - feed / max(Kc, 1e-12))
        + rough.cost(stops)
        + STEP_REQUIREMENTS["speed"].quick * near.cost("speed", Kp=Kp, Ki=Ki, Kc=feed)
    )
    return _SpeedLoops(plant, room, step, Kp, Ki, feed, found, rough, cost), level


def design_speed(
    plant: Plant,
    room: tuple[float, float],
    Kc: float,
    step: float,
    stops: float = 1.0,
    band: float = BAND,
    near: Neighbours = ALONE,
    shares: np.ndarray = _SPEED_SHARES,
) -> tuple[SpeedGains, LoopReport] | None:
    """Throttle from airspeed and rate of climb; ``plant`` has the attitude or the altitude held.

    ``stops`` is the weight of the throttle's stops in turbulence, of which the plant may have some;
    the ``band`` is for steps that settle with it.
    """
    loops, level = _speed_loops(plant, room, Kc, step, stops, near, shares)
    pick = np.flatnonzero(level < len(MARGINS))
    if not len(pick):
        return None
    k, ramp = grid(pick, _SPEED_RAMPS)

    # candidates are compared without the band, or it would count for loose ones that it spares,
    # and without a weight of the reference, which would hide slow ones
    def fly(i: np.ndarray) -> tuple[np.ndarray, ...]:
        score, *found, _ = loops.fly(k[i], np.ones(len(i)), ramp[i], math.inf)
        return score + loops.cost[k[i]], *found

    i, _, _, late, _ = _least(np.arange(len(k)), loops.cost[k] + loops.required.quick, fly)
    j = k[i]
    gains, time, over, use = loops.referred(j, band)
    unsettled = "" if math.isfinite(time) else "settling"
    relaxed = relaxation_text(level[j], unsettled, *loops.rough.said(j))
    margins_ = margins_of(loops.margins, j)
    report = LoopReport("speed", *margins_, time, over, use, relaxed=relaxed, late=late)
    rough = any(name in plant.inputs for name in AIR)
    if rough and shares is _SPEED_SHARES and not time <= loops.required.settling_off:
        more = design_speed(plant, room, Kc, step, stops, band, near, _HIGHER_SHARES)
        if more and more[1].settling < time and not more[1].relaxed:
            return more
    return gains, report


def design_feed(plant: Plant, room: tuple[float, float], rise: float) -> tuple[float, float]:
    """Throttle per rate of climb that keeps the airspeed, s/ft, and throttle per kt, both slow.

    ``plant`` has the pitch loop closed; a ``rise`` of so many ft/s may use all of the throttle's
    remaining travel.
    """
    w = np.array([0.05])
    throttle, theta = plant.response(w, "throttle"), plant.response(w, "theta_cmd")
    need = -theta["vc"] / throttle["vc"]
    climb = theta["hdot"] + need * throttle["hdot"]
    most = min(-room[0], room[1]) / rise
    gain = float(np.abs(plant.response(np.array([OMEGA[0]]), "throttle")["vc"])[0])
    return float(np.clip((need / climb).real[0], 0.0, most)), 1.0 / gain


def with_speed(plant: Plant, gains: SpeedGains) -> Plant:
    """The plant with the airspeed loop closed."""
    T = plant.T
    a = -math.expm1(-T / gains.Tf)
    law = np.array(
        [
            [1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0],
            [0.0, -a / T, 1.0 - a],
            [1.0, gains.Kd * a / T, -gains.Kd * (1.0 - a)],
        ]
    )
    return plant.close(
        "throttle",
        law=law,
        read={
            "vc": np.array([-gains.Ki * T, 1.0, a / T]),
            "vc_cmd": np.array([gains.Ki * T, 0.0, 0.0]),
        },
        through={
            "vc": -gains.Kp - gains.Kd * a / T,
            "hdot": gains.Kc,
            "vc_cmd": gains.Kp * gains.b,
        },
        reference="vc_cmd",
        command="throttle",
    )


def with_altitude(plant: Plant, gains: AltitudeGains) -> Plant:
    """The plant with the altitude loop closed; ``theta_cmd`` is no input any more."""
    Ki = gains.Ki * plant.T
    return plant.close(
        "theta_cmd",
        law=np.array([[1.0], [1.0]]),
        read={"h": np.array([-Ki * gains.Kh]), "hdot": np.array([-Ki])},
        through={"h": -gains.Kp * gains.Kh, "hdot": -gains.Kp},
    )


_CLIMB_CROSSOVERS = np.geomspace(0.15, 1.6, 32)
_CLIMB_PHASES = np.linspace(60.0, 108.0, 7)
_CLIMB_RATIOS = np.geomspace(2.5, 24.0, 7)

# s of settling; share of the time at the largest rate of climb in which no step is done
_HOPE, _SOONEST = 300.0, 0.8


def _altitude_candidates(
    plant: Plant, room: tuple[float, float], near: Neighbours
) -> tuple[np.ndarray, np.ndarray, np.ndarray, Margins, Rough]:
    """Kp, Ki and Kh of all combinations, their margins, and what turbulence does to them."""
    T, g = plant.T, plant.response(OMEGA, "theta_cmd")
    sums = integral(OMEGA, T)
    w, phase = grid(_CLIMB_CROSSOVERS, _CLIMB_PHASES)
    G = at(w, g["hdot"])
    Ki, Kp = crossing(G * integral(w, T), G, phase)
    good = (Ki >= 0.0) & np.isfinite(Ki)
    Kp, Ki = Kp[good], Ki[good]
    wc = margins(OMEGA, (Kp[:, None] + Ki[:, None] * sums) * g["hdot"]).crossover
    k, r = grid(np.arange(len(Kp)), _CLIMB_RATIOS)
    Kp, Ki, Kh = near.joined("altitude", Kp=Kp[k], Ki=Ki[k], Kh=np.minimum(wc[k] / r, 0.3))
    law = Kp[:, None] + Ki[:, None] * sums
    L = law * (g["hdot"] + Kh[:, None] * g["h"])
    air = [plant.response(OMEGA, name) for name in AIR if name in plant.inputs]
    moved = [-law * (gust["hdot"] + Kh[:, None] * gust["h"]) / (1.0 + L) for gust in air]
    off, pitch, throttle = (
        rms(
            OMEGA,
            np.zeros_like(L),
            *(gust[name] + g[name] * u for gust, u in zip(air, moved, strict=True)),
        )
        if name in g
        else np.zeros(len(Kp))
        for name in ("h", "theta", "throttle")
    )
    return Kp, Ki, Kh, margins(OMEGA, L), Rough(off, pitch, at_a_stop(throttle, room))


def design_altitude(
    plant: Plant,
    ramp: float,
    hdot_max: float,
    room: tuple[float, float] = (-1.0, 1.0),
    stops: float = 1.0,
    near: Neighbours = ALONE,
) -> tuple[AltitudeGains, LoopReport] | None:
    """Pitch reference from the rate of climb; ``plant`` has pitch and airspeed loops closed.

    ``room`` is the throttle's; ``stops`` as in `design_speed`.
    """
    Kp, Ki, Kh, found, rough = _altitude_candidates(plant, room, near)
    if not len(Kp):
        return None
    level, required = requirement_met(found), STEP_REQUIREMENTS["altitude"]
    soonest = _SOONEST * required.size / hdot_max
    cost = 30.0 * level + 6.0 * found.crossover + rough.cost(stops)
    cost += soonest * near.cost("altitude", Kp=Kp, Ki=Ki, Kh=Kh)
    valid = level < len(MARGINS)
    if not valid.any():
        return None

    def fly(j: np.ndarray) -> tuple[np.ndarray, ...]:
        error, speed, peak = _climbs(plant, Kh[j], Kp[j], Ki[j], ramp, hdot_max)
        time, over, late = step_quality(error, required.tolerance, _COARSE * plant.T)
        score = (
            time
            + 10.0 * np.maximum(over - 1.0, 0.0)
            + 200.0 * np.maximum(late - 0.05, 0.0)
            + cost[j]
            + 2.0 * speed
            + np.maximum(peak - 8.0, 0.0)
        )
        return score, time, over, late, peak

    # no step makes up for a cost that is higher by so much
    for pick in (valid & (cost <= cost[valid].min() + _HOPE), valid):
        j, time, over, late, peak = _least(np.flatnonzero(pick), cost + soonest, fly)
        if math.isfinite(time):
            break
    gains = AltitudeGains(Kh=float(Kh[j]), Kp=float(Kp[j]), Ki=float(Ki[j]), hdot_max=hdot_max)
    relaxed = relaxation_text(
        level[j],
        "" if math.isfinite(time) else "settling",
        f"overshoot {over:.1f} ft" if over > required.overshoot else "",
        *rough.said(j),
    )
    margins_ = margins_of(found, j)
    return gains, LoopReport(
        "altitude", *margins_, time, over, peak / 10.0, relaxed=relaxed, late=late
    )


# candidates flown at first, and how many times as many each time after: most of the time of a step
# does not depend on how many are flown
_BATCH, _MORE = 256, 4


def _least(
    pick: np.ndarray, floor: np.ndarray, fly: Callable[[np.ndarray], tuple[np.ndarray, ...]]
) -> tuple[Any, ...]:
    """The candidate of ``pick`` with the least score, and what else ``fly`` says of it.

    ``fly`` gives the scores of some candidates, none less than its ``floor``, then settling time,
    overshoot, last error and peak; where nothing settles, the last error decides.
    """
    order = pick[np.argsort(floor[pick], kind="stable")]
    best: tuple[Any, ...] = ()
    batch = _BATCH
    while len(order):
        some, order = order[:batch], order[batch:]
        batch *= _MORE
        score, *found = fly(some)
        late = np.nan_to_num(found[2], nan=math.inf)
        score = np.where(np.isfinite(score), score, 1e6 + late)
        i = int(np.argmin(score))
        if not best or score[i] < best[0]:
            best = (float(score[i]), int(some[i]), *(float(x[i]) for x in found))
        order = order[floor[order] < best[0]]
    return best[1:]


def _climbs(
    plant: Plant, Kh: np.ndarray, Kp: np.ndarray, Ki: np.ndarray, ramp: float, hdot_max: float
) -> tuple[np.ndarray, ...]:
    """Errors of climbs, shape (samples, loops), and largest changes of airspeed and pitch."""
    p, step = plant.slower(_COARSE), STEP_REQUIREMENTS["altitude"].size
    most = ramp * p.T
    total, cmd, peak = np.zeros(len(Kh)), np.zeros(len(Kh)), np.zeros(len(Kh))

    def law(k: int, y: np.ndarray) -> np.ndarray:
        error = np.minimum(np.maximum(Kh * (step - y[0]), -hdot_max), hdot_max) - y[1]
        cmd[:] += np.minimum(np.maximum(Kp * error + total - cmd, -most), most)
        total[:] += Ki * p.T * error
        np.maximum(peak, np.abs(cmd), out=peak)
        return cmd

    seconds = 80.0 + 1.3 * step / hdot_max
    y = p.steps("theta_cmd", ("h", "hdot", "vc"), law, len(Kh), seconds)
    return y[:, 0] - step, np.abs(y[:, 2]).max(axis=0), peak
