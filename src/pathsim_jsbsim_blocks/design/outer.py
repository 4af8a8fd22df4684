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
from .requirements import MARGINS, STEP_REQUIREMENTS, relaxation_text, requirement_met
from .search import OMEGA, at_the_end, integral, margins_of, settled
from .turbulence import AIR, Rough, at_a_stop, rms

# periods of the loop in one step of a slow response
_COARSE = 6

# 1/s; a slower divergence is left to the loops around
_DIVERGES = 0.03


@dataclass(frozen=True)
class Outcome:
    """What was found for one loop besides its gains."""

    margins: dict[str, float]
    settling: float = math.nan
    overshoot: float = math.nan
    use: float = math.nan
    relaxed: str = ""
    # largest error in the last 5 s of the step; of the airspeed without its band, and with b = 1
    late: float = math.nan


# the Dutch roll is damped to this; a model that has as much needs no damper
_DAMPED = 0.35
_TAU = 2.0
_YAW_SHARES = np.geomspace(0.03, 1.5, 24)


def design_yaw(plant: Plant, room: float) -> YawGains:
    """Rudder from washed-out yaw rate: the lowest gain that damps the Dutch roll."""
    bare = dutch_roll(plant)
    if bare is None or bare[1] >= _DAMPED:
        return YawGains(K=0.0, tau=_TAU)
    g = plant.response(OMEGA, "rudder")["r"]
    washed = _wash_out(plant.T, _TAU) * g
    k = int(np.argmin(np.abs(OMEGA - bare[0])))
    K = -np.sign(washed[k].real) * _YAW_SHARES / np.abs(g[k])
    # 10 deg/s of yaw should not need all of the rudder
    K = K[np.abs(K) * 10.0 <= 0.9 * room]
    if not len(K):
        return YawGains(K=0.0, tau=_TAU)
    found = margins(OMEGA, -K[:, None] * washed)
    level = requirement_met(found)
    best = None
    for i in np.flatnonzero(level == 0):
        mode = dutch_roll(damped(plant, YawGains(K=float(K[i]), tau=_TAU)))
        damping = 1.0 if mode is None else mode[1]
        if best is None or damping > best[0]:
            best = damping, i
        if damping >= _DAMPED:
            break
    if best is None or best[0] < bare[1] + 0.02:
        return YawGains(K=0.0, tau=_TAU)
    return YawGains(K=float(K[best[1]]), tau=_TAU)


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


_SLIP_DAMPERS = np.array([0.0, 0.5, 1.0, 1.5, 2.2, 3.2])
_SLIP_GAINS = np.array([0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.5])
_SLIP_TIMES = np.array([0.7, 1.2, 2.0, 4.0, math.inf])

# deg of bank, and rad/s up to which a turn is entered with it
_TURN, _ENTRY = 25.0, 0.6


def design_rudder(
    plant: Plant, damper: YawGains, room: float, vt: float, ramp: float
) -> tuple[YawGains, Outcome | None]:
    """Rudder from yaw rate, sideslip and roll, so that a bank turns the aircraft and nothing else.

    ``plant`` has the roll loop closed with the input ``phi_cmd``, and no loop at the rudder.
    """
    T = plant.T
    rudder, bank = plant.response(OMEGA, "rudder"), plant.response(OMEGA, "phi_cmd")
    wash = _wash_out(T, damper.tau)
    sign = float(np.sign(rudder["beta"][0].real))
    slip = np.abs(rudder["beta"][:60]).max()
    K = damper.K * _SLIP_DAMPERS
    if damper.K == 0.0:
        K = np.array([0.0])
    K, P, time = (x.ravel() for x in np.meshgrid(K, _SLIP_GAINS, _SLIP_TIMES, indexing="ij"))
    P = P * sign * 4.0 / slip
    fits = np.abs(K) * 10.0 + np.abs(P) * 5.0 <= 0.9 * room
    K, P = K[fits], P[fits]
    Ki = P / time[fits]
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
        _TURN * (beta * entry).max(axis=1)
        + np.where(OMEGA < 10.0, psi, 0.0).max(axis=1)
        + 0.5 * (np.abs(K) * 10.0 + np.abs(P) * 5.0) / room
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
        + abs(chosen.Kbank) * _TURN
    ) / room
    return chosen, Outcome(margins_of(_of_rudder(plant, chosen), 0), use=use) if use else None


# s of a turn's entry, largest share of the rudder's remaining travel that it may need, and
# the shares of the best coordination that are tried for the margins
_ROLL_IN, _TURN_USE = 12.0, 0.6
_COORDINATED = (1.0, 0.85, 0.7, 0.5, 0.3)

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
    rows = np.array([p.row("beta"), p.row("p"), p.row("phi")])
    n = round(_ROLL_IN / p.T)
    turn, kick = np.empty((n, 3)), np.empty(n)
    x, z = np.zeros(len(p.A)), np.zeros(len(p.A))
    bank, rudder = p.column("phi_cmd"), p.column("rudder")
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(n):
            turn[k], kick[k] = rows @ x, rows[0] @ z
            x = p.A @ x + bank * min(ramp * p.T * k, _TURN)
            z = p.A @ z + (rudder if k == 0 else 0.0)
    return turn[:, 0], turn[:, 1], turn[:, 2], kick


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


def _pi(
    G: np.ndarray, T: float, crossovers: np.ndarray, phases: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Kp and Ki with a crossover and a phase margin each, where both are not negative."""
    w, pm = (x.ravel() for x in np.meshgrid(crossovers, phases, indexing="ij"))
    size = np.exp(np.interp(np.log(w), np.log(OMEGA), np.log(np.abs(G))))
    angle = np.interp(np.log(w), np.log(OMEGA), np.unwrap(np.angle(G)))
    wanted = -np.exp(1j * pm) / (size * np.exp(1j * angle))
    term = integral(w, T)
    Ki = wanted.imag / term.imag
    Kp = wanted.real - Ki * term.real
    # an integral alone, or a gain alone, where the phase asks for it
    alone = Kp < 0.0
    Ki = np.where(alone, 1.0 / (size * np.abs(term)), Ki)
    Kp = np.where(alone, 0.0, Kp)
    good = (Ki >= 0.0) & np.isfinite(Ki)
    return Kp[good], Ki[good]


def design_heading(
    plant: Plant,
    ramp: float,
    settling: float,
    vt: float,
    straight: float = 0.0,
    bank_max: float = 25.0,
) -> tuple[HeadingGains | None, Outcome]:
    """Bank per heading error; ``plant`` has the roll loop closed with the input ``phi_cmd``.

    ``straight`` is the bank of straight flight in deg: with a propeller it is not 0.
    """
    turn = GRAVITY / vt  # psi-dot per phi, 1/s
    fast = min(0.25, 0.7 / max(settling if math.isfinite(settling) else 5.0, 0.5))
    Kp = np.clip(fast / turn * np.geomspace(0.25, 1.6, 14), 0.3, 6.0)
    G = plant.response(OMEGA, "phi_cmd")["psi"]
    found = margins(OMEGA, Kp[:, None] * G)
    level = requirement_met(found)
    p = plant.slower(_COARSE)
    T, seconds, step = p.T, 60.0, 30.0
    c, f, B = p.row("psi"), p.row("phi"), p.column("phi_cmd")[:, None]
    x, cmd = np.zeros((len(p.A), len(Kp))), np.zeros(len(Kp))
    y = np.empty((round(seconds / T), len(Kp)))
    bank = np.zeros(len(Kp))
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(len(y)):
            y[k] = c @ x
            phi = f @ x
            bank = np.maximum(bank, np.abs(phi))
            wanted = np.clip(Kp * (step - y[k]), -bank_max, bank_max)
            cmd = cmd + np.clip(wanted - cmd, -ramp * T, ramp * T)
            x = p.A @ x + B * cmd
    time = settled(y - step, 0.5, T)
    over = np.maximum((y - step).max(axis=0), 0.0)
    score = time + 200.0 * np.maximum(over - 0.25, 0.0) + 10.0 * level
    score = np.where(np.isfinite(score), score, 1e6 + over)
    i = int(np.argmin(score))
    if level[i] == len(MARGINS) or not math.isfinite(time[i]):
        return None, Outcome(margins_of(found, i), float(time[i]), float(over[i]))
    return HeadingGains(Kp=float(Kp[i]), bank=straight), Outcome(
        margins_of(found, i),
        float(time[i]),
        float(over[i]),
        float(bank[i] / bank_max),
        relaxation_text(level[i], f"overshoot {over[i]:.1f} deg" if over[i] > 0.5 else ""),
    )


# kt: an error that may use all of the throttle's remaining travel
GUST = 12.0

# kt: a larger error is a gust, and counts less
BAND = 4.0

_TF = 0.5
_SPEED_SHARES = np.array([0.15, 0.22, 0.33, 0.5, 0.7, 1.0])
# where turbulence is light, as at high altitude
_HIGHER_SHARES = np.array([1.0, 1.4, 2.0, 2.8, 4.0])
_SPEED_TIMES = np.array([6.0, 10.0, 16.0, 25.0, 40.0, 55.0, 75.0])
_SPEED_RAMPS = np.array([0.3, 0.5, 0.7, 1.0])
_SPEED_WEIGHTS = np.linspace(0.5, 1.25, 16)
_SPEED_SECONDS = 150.0  # of a step

# shares of the throttle that a rate of climb takes to be fed forward
_SPEED_RISES = np.array([1.0, 0.5, 0.0])
_UNFED = 20.0  # s of settling, for none of it


@dataclass(frozen=True)
class _SpeedCandidates:
    """Airspeed loops, arrays of shape (loops,)."""

    share: np.ndarray
    time: np.ndarray
    rise: np.ndarray
    Kp: np.ndarray
    Ki: np.ndarray
    feed: np.ndarray
    margins: Margins
    level: np.ndarray
    rough: Rough


def _speed_candidates(
    plant: Plant, room: tuple[float, float], Kc: float, shares: np.ndarray
) -> _SpeedCandidates:
    """All combinations of shares, integral times and shares of the feed-forward."""
    T, g = plant.T, plant.response(OMEGA, "throttle")
    share, time, rise = (
        x.ravel() for x in np.meshgrid(shares, _SPEED_TIMES, _SPEED_RISES, indexing="ij")
    )
    Kp = share * min(-room[0], room[1]) / GUST
    Ki = Kp / time
    feed = rise * Kc
    alpha = -math.expm1(-T / _TF)
    z = np.exp(1j * OMEGA * T)
    slope = alpha / (1 - (1 - alpha) / z) * (1 - 1 / z) / T
    law = Kp[:, None] * (1 - _TF * slope) + Ki[:, None] * integral(OMEGA, T)
    L = law * g["vc"] - feed[:, None] * g["hdot"]
    found = margins(OMEGA, L)
    air = [plant.response(OMEGA, name) for name in AIR if name in plant.inputs]
    moved = [(feed[:, None] * gust["hdot"] - law * gust["vc"]) / (1.0 + L) for gust in air]
    none = np.zeros(len(Kp))
    rough = Rough(none, none, at_a_stop(rms(OMEGA, *moved, np.zeros_like(L)), room))
    return _SpeedCandidates(share, time, rise, Kp, Ki, feed, found, requirement_met(found), rough)


def design_speed(
    plant: Plant,
    room: tuple[float, float],
    Kc: float,
    step: float,
    stops: float = 1.0,
    band: float = BAND,
    shares: np.ndarray = _SPEED_SHARES,
) -> tuple[SpeedGains | None, Outcome]:
    """Throttle from airspeed and rate of climb; ``plant`` has the attitude or the altitude held.

    ``stops`` is the weight of the throttle's stops in turbulence, of which the plant may have some;
    the ``band`` is for steps that settle with it.
    """
    dt, travel = _COARSE * plant.T, min(-room[0], room[1])
    all_ = _speed_candidates(plant, room, Kc, shares)
    pick = np.flatnonzero(all_.level < len(MARGINS))
    if not len(pick):
        return None, Outcome(margins_of(all_.margins, 0))
    k, ramp = (x.ravel() for x in np.meshgrid(pick, _SPEED_RAMPS, indexing="ij"))
    unfed = _UNFED * (1.0 - all_.rise)
    fixed = (60.0 * all_.level + 10.0 * all_.share + unfed + all_.rough.cost(stops))[k]

    def steps(
        j: np.ndarray, b: np.ndarray, ramp: np.ndarray, band: float
    ) -> tuple[np.ndarray, ...]:
        error, peak = _accelerates(
            plant,
            room,
            step,
            all_.Kp[j],
            all_.Ki[j],
            b,
            all_.feed[j],
            1.0 / all_.time[j],
            ramp,
            band,
        )
        time = settled(error, 0.5, dt)
        over = np.maximum((np.sign(step) * error).max(axis=0), 0.0)
        late = at_the_end(error, dt)
        score = (
            np.maximum(time, _QUICK)
            + 30.0 * np.maximum(over - 0.25, 0.0)
            + 300.0 * np.maximum(late - 0.1, 0.0)
            + 5.0 * peak / travel
        )
        return error, score, time, over, late, peak

    def fly(pick: np.ndarray) -> tuple[np.ndarray, ...]:
        _, score, *found = steps(k[pick], np.ones(len(pick)), ramp[pick], math.inf)
        return score + fixed[pick], *found

    # candidates are compared without the band, or it would count for loose ones that it spares,
    # and without a weight of the reference, which would hide slow ones
    i, _, _, late, _ = _least(np.arange(len(k)), fixed + _QUICK, fly)
    j = k[i]
    b, ramps = (x.ravel() for x in np.meshgrid(_SPEED_WEIGHTS, _SPEED_RAMPS, indexing="ij"))
    for kept in dict.fromkeys((band, GUST)):
        error, score, *quality = steps(np.full(len(b), j), b, ramps, kept)
        close = np.minimum(settled(error, 0.2, dt), _SPEED_SECONDS)
        i = int(np.argmin(score + _LARGER * close))
        time, over, _, peak = (float(x[i]) for x in quality)
        if math.isfinite(time):
            break
    kp = float(all_.Kp[j])
    gains = SpeedGains(
        Kp=kp,
        Ki=float(all_.Ki[j]),
        Kd=-kp * _TF,
        Tf=_TF,
        b=float(b[i]),
        ramp=float(ramps[i]),
        Kc=float(all_.feed[j]),
        band=kept,
    )
    unsettled = "" if math.isfinite(time) else "settling"
    outcome = Outcome(
        margins_of(all_.margins, j),
        time,
        over,
        peak / travel,
        relaxation_text(all_.level[j], unsettled, *all_.rough.said(j)),
        late,
    )
    rough = any(name in plant.inputs for name in AIR)
    if rough and shares is _SPEED_SHARES and not time <= STEP_REQUIREMENTS["speed"].settling_off:
        more = design_speed(plant, room, Kc, step, stops, band, _HIGHER_SHARES)
        if more[1].settling < time and not more[1].relaxed:
            return more
    return gains, outcome


# s of settling; faster is worth nothing
_QUICK = 12.0

# weight of the time within 0.2 kt, as a step of 25 kt needs it
_LARGER = 0.5


def _accelerates(
    plant: Plant,
    room: tuple[float, float],
    step: float,
    Kp: np.ndarray,
    Ki: np.ndarray,
    b: np.ndarray,
    feed: np.ndarray,
    unwind: np.ndarray,
    ramp: np.ndarray,
    band: float,
) -> tuple[np.ndarray, ...]:
    """Errors of steps of the airspeed, shape (samples, loops), and the largest commands."""
    p = plant.slower(_COARSE)
    dt = p.T
    moves = np.column_stack([p.A, p.column("throttle")])
    rows = np.array([p.row("vc"), p.row("hdot")])
    a = -math.expm1(-dt / _TF)
    low, high = room
    n, size = len(Kp), len(p.A)
    # the command is the last row of the state
    x, total, slow = np.zeros((size + 1, n)), np.zeros(n), np.zeros(n)
    y, peak = np.empty((round(_SPEED_SECONDS / dt), n)), np.zeros(n)
    with np.errstate(over="ignore", invalid="ignore"):
        for j in range(len(y)):
            y[j], climb = rows @ x[:size]
            ref = math.copysign(1.0, step) * np.minimum(j * dt * ramp, abs(step))
            error = ref - y[j]
            error -= BEYOND * (error - np.minimum(np.maximum(error, -band), band))
            slow = slow + a * (ref - error - slow)
            v = Kp * (b * ref - slow) + total + feed * climb
            u = np.minimum(np.maximum(v, low), high)
            peak = np.maximum(peak, np.abs(v))
            total += Ki * dt * error + unwind * dt * (u - v)
            x[size] = u
            x[:size] = moves @ x
    return y - step, peak


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
_CLIMB_PHASES = np.radians([60.0, 68.0, 76.0, 84.0, 92.0, 100.0, 108.0])
_CLIMB_RATIOS = np.array([2.5, 3.3, 4.5, 7.0, 12.0, 24.0])

# s of settling; share of the time at the largest rate of climb in which no step is done
_HOPE, _SOONEST = 300.0, 0.8


def _altitude_candidates(
    plant: Plant, room: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, Margins, Rough]:
    """Kp, Ki and Kh of all combinations, their margins, and what turbulence does to them."""
    T, g = plant.T, plant.response(OMEGA, "theta_cmd")
    Kp, Ki = _pi(g["hdot"], T, _CLIMB_CROSSOVERS, _CLIMB_PHASES)
    sums = integral(OMEGA, T)
    wc = margins(OMEGA, (Kp[:, None] + Ki[:, None] * sums) * g["hdot"]).crossover
    k, r = (x.ravel() for x in np.meshgrid(np.arange(len(Kp)), _CLIMB_RATIOS, indexing="ij"))
    Kp, Ki, Kh = Kp[k], Ki[k], np.minimum(wc[k] / r, 0.3)
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
    step: float = 500.0,
    room: tuple[float, float] = (-1.0, 1.0),
    stops: float = 1.0,
) -> tuple[AltitudeGains | None, Outcome]:
    """Pitch reference from the rate of climb; ``plant`` has pitch and airspeed loops closed.

    ``room`` is the throttle's; ``stops`` as in `design_speed`.
    """
    Kp, Ki, Kh, found, rough = _altitude_candidates(plant, room)
    if not len(Kp):
        return None, Outcome({})
    level = requirement_met(found)
    cost = 30.0 * level + 6.0 * found.crossover + rough.cost(stops)
    valid = level < len(MARGINS)
    if not valid.any():
        return None, Outcome(margins_of(found, 0))

    def fly(j: np.ndarray) -> tuple[np.ndarray, ...]:
        time, over, late, speed, peak = _climbs(plant, Kh[j], Kp[j], Ki[j], ramp, hdot_max, step)
        score = (
            time
            + 10.0 * np.maximum(over - 1.0, 0.0)
            + 200.0 * np.maximum(late - 0.05, 0.0)
            + cost[j]
            + 2.0 * speed
            + np.maximum(peak - 8.0, 0.0)
        )
        return score, time, over, late, peak

    floor = cost + _SOONEST * step / hdot_max
    # no step makes up for a cost that is higher by so much
    for pick in (valid & (cost <= cost[valid].min() + _HOPE), valid):
        j, time, over, late, peak = _least(np.flatnonzero(pick), floor, fly)
        if math.isfinite(time):
            break
    gains = AltitudeGains(Kh=float(Kh[j]), Kp=float(Kp[j]), Ki=float(Ki[j]), hdot_max=hdot_max)
    return gains, Outcome(
        margins_of(found, j),
        time,
        over,
        peak / 10.0,
        relaxation_text(
            level[j],
            "" if math.isfinite(time) else "settling",
            f"overshoot {over:.1f} ft" if over > 5.0 else "",
            *rough.said(j),
        ),
        late,
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
    plant: Plant,
    Kh: np.ndarray,
    Kp: np.ndarray,
    Ki: np.ndarray,
    ramp: float,
    hdot_max: float,
    step: float,
) -> tuple[np.ndarray, ...]:
    """Settling, overshoot, last error, and largest changes of airspeed and pitch of climbs."""
    p = plant.slower(_COARSE)
    dt, seconds = p.T, 80.0 + 1.3 * step / hdot_max
    moves = np.column_stack([p.A, p.column("theta_cmd")])
    rows = np.array([p.row("h"), p.row("hdot"), p.row("vc")])
    most = ramp * dt
    n, size = len(Kh), len(p.A)
    # the command is the last row of the state
    x, total = np.zeros((size + 1, n)), np.zeros(n)
    y, speed, peak = np.empty((round(seconds / dt), n)), np.zeros(n), np.zeros(n)
    with np.errstate(over="ignore", invalid="ignore"):
        for j in range(len(y)):
            y[j], hdot, vc = rows @ x[:size]
            speed = np.maximum(speed, np.abs(vc))
            wanted = np.minimum(np.maximum(Kh * (step - y[j]), -hdot_max), hdot_max)
            error = wanted - hdot
            cmd = x[size]
            cmd += np.minimum(np.maximum(Kp * error + total - cmd, -most), most)
            total += Ki * dt * error
            peak = np.maximum(peak, np.abs(cmd))
            x[:size] = moves @ x
    return (
        settled(y - step, 10.0, dt),
        np.maximum((y - step).max(axis=0), 0.0),
        at_the_end(y - step, dt),
        speed,
        peak,
    )
