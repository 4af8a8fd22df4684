"""The loops around the attitude: yaw damper, turn coordination, heading, airspeed, altitude."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import linprog
from scipy.signal import fftconvolve

from .._core.units import GRAVITY
from ..control.gains import AltitudeGains, HeadingGains, SpeedGains, YawGains
from ..control.loops import SpeedLoop
from ..linear.stability import LoopMargins, loop_margins
from . import requirements as req
from .plant import OMEGA, Law, Plant, integral
from .requirements import MARGINS, STEP_REQUIREMENTS, requirement_met
from .search import (
    ALONE,
    Loop,
    LoopReport,
    Neighbours,
    Unstable,
    at,
    crossing,
    grid,
    margins_of,
    reported,
    step_quality,
    tracked,
)
from .turbulence import AIR, Rough, at_a_stop, moved

# periods of the loop in one step of a slow response, to save time
_COARSE = 6

# fractions of the gain at which rudder from yaw rate has a loop gain of 1 at the Dutch roll
_YAW_SHARES = np.geomspace(0.03, 1.5, 24)


def yaw_law(
    K: Any,
    tau: float = YawGains.tau,
    Kp: Any = 0.0,
    Ki: Any = 0.0,
    Kroll: float = 0.0,
    Kbank: float = 0.0,
) -> Law:
    """The law at the rudder, with the gains of `YawGains` or columns of them."""
    gains = {"r": (0.0, 0.0, -K), "beta": (Kp, Ki), "p": (-Kroll,), "phi": (-Kbank,)}
    return Law(gains, tau)


def damped(plant: Plant, gains: YawGains) -> Plant:
    """The plant with the rudder's loops closed; the input ``rudder`` is added to their output."""
    return plant.close("rudder", yaw_law(**vars(gains)), ("rudder", 1.0, 0.0))


def design_yaw(plant: Plant, room: float) -> YawGains:
    """Rudder from washed-out yaw rate: the minimum gain that damps the Dutch roll."""
    best, bare = YawGains(K=0.0), dutch_roll(plant)
    if bare is None or bare[1] >= req.DUTCH_ROLL:
        return best
    g = plant.response(OMEGA, "rudder")
    k = int(np.argmin(np.abs(OMEGA - bare[0])))
    sign = np.sign(yaw_law(K=1.0).of(g, plant.T)[k].real)
    K = sign * _YAW_SHARES / np.abs(g["r"][k])
    K = K[np.abs(K) * req.YAW_RATE <= req.RUDDER_USE * room]
    level = requirement_met(loop_margins(OMEGA, yaw_law(K[:, None]).of(g, plant.T)))
    damping_max = bare[1] + 0.02
    for gain in K[level == 0]:
        gains = YawGains(K=float(gain))
        mode = dutch_roll(damped(plant, gains))
        damping = 1.0 if mode is None else mode[1]
        if damping >= damping_max:
            best, damping_max = gains, damping
        if damping >= req.DUTCH_ROLL:
            break
    return best


def dutch_roll(plant: Plant) -> tuple[float, float] | None:
    """Frequency in rad/s and damping ratio of the oscillation that moves the sideslip most."""
    poles, vectors = np.linalg.eig(plant.A)
    s = np.log(np.where(np.abs(poles) < 1e-9, 1e-9, poles)) / plant.T
    slip = np.abs(plant.row("beta") @ vectors)
    turn = np.abs(plant.row("r") @ vectors)
    pitch = np.abs(plant.row("q") @ vectors) + 1e-12
    lateral = (slip + turn) / (slip + turn + pitch)
    w = np.abs(s)
    matches = (s.imag > 0.2) & (w > 0.3) & (w < 15.0) & (lateral > 0.5)
    if not matches.any():
        return None
    # weigh each mode by its response to a rudder impulse
    size = np.abs(np.linalg.pinv(vectors) @ plant.column("rudder"))
    i = int(np.argmax(np.where(matches, slip * size, -1.0)))
    return float(w[i]), float(-s[i].real / w[i])


# fractions of the damper's gain; fraction of the sideslip that the rudder removes at once, and the
# rate in 1/s at which its integral removes the rest
_SLIP_DAMPERS = np.linspace(0.0, 3.0, 7)
_SLIP_GAINS = np.array([0.0, 0.2, 0.4, *np.linspace(0.8, 5.6, 7)])
_SLIP_RATES = np.array([0.1, 0.15, 0.3, 0.6])

# bandwidth of the turn entry, rad/s
_ENTRY = 0.6


def design_rudder(
    plant: Plant,
    damper: YawGains,
    room: float,
    vt: float,
    ramp: float,
    neighbours: Neighbours = ALONE,
) -> tuple[YawGains, LoopReport | None]:
    """Rudder from yaw rate, sideslip and roll, so that a bank turns the aircraft without sideslip.

    An integral removes the remaining sideslip, after an engine failure for example. ``plant`` has
    the roll loop closed with the input ``phi_cmd``, and no loop at the rudder.
    """
    T = plant.T
    rudder, bank = plant.response(OMEGA, "rudder"), plant.response(OMEGA, "phi_cmd")
    sign = float(np.sign(rudder["beta"][0].real))
    slip = np.abs(rudder["beta"][:60]).max()
    dampers = damper.K * _SLIP_DAMPERS if damper.K else np.zeros(1)
    K, P, rate = grid(dampers, _SLIP_GAINS, _SLIP_RATES)
    K, P, Ki = neighbours.joined("yaw", K=K, Kp=sign * P / slip, Ki=sign * rate * (1.0 + P) / slip)
    travel = (np.abs(K) * req.YAW_RATE + np.abs(P) * req.SIDESLIP) / room
    K, P, Ki, travel = (x[travel <= req.RUDDER_USE] for x in (K, P, Ki, travel))
    law = yaw_law(K[:, None], damper.tau, P[:, None], Ki[:, None])
    L = law.of(rudder, T)
    command = -law.of(bank, T) / (1.0 + L)
    beta = np.abs(bank["beta"] + command * rudder["beta"])
    psi = np.abs((bank["psi"] + command * rudder["psi"]) * OMEGA * vt / GRAVITY)
    entry = 1.0 / np.hypot(1.0, OMEGA / _ENTRY)
    score = (
        req.BANK * (beta * entry).max(axis=1)
        + np.where(OMEGA < 10.0, psi, 0.0).max(axis=1)
        + 0.5 * travel
        + neighbours.cost("yaw", K=K, Kp=P, Ki=Ki)
    )
    level = requirement_met(loop_margins(OMEGA, L))
    score = np.where(level < len(MARGINS), score + 10.0 * level, np.inf)
    selection = damper
    for i in np.argsort(score)[:30]:
        if not math.isfinite(score[i]):
            break
        gains = YawGains(K=float(K[i]), tau=damper.tau, Kp=float(P[i]), Ki=float(Ki[i]))
        if damped(plant, gains).growth() < req.DIVERGENCE:
            selection = gains
            break
    selection = coordinate(plant, selection, room, ramp)
    parts = (
        (selection.K, req.YAW_RATE),
        (selection.Kp, req.SIDESLIP),
        (selection.Kroll, ramp),
        (selection.Kbank, req.BANK),
    )
    use = sum(abs(gain) * size for gain, size in parts) / room
    if not use:
        return selection, None
    return selection, LoopReport("yaw", **margins_of(_of_rudder(plant, selection), 0), use=use)


# duration of the turn entry, s, and fractions of the best coordination to try for the margins
_ROLL_IN, _COORDINATED = 12.0, np.linspace(1.0, 0.3, 5)

# cost of full rudder travel, as deg of sideslip
_RUDDER_COST = 0.3


def coordinate(plant: Plant, yaw: YawGains, room: float, ramp: float) -> YawGains:
    """Rudder from roll rate and bank for minimum sideslip in the entry of a turn.

    ``plant`` has the roll loop closed with the input ``phi_cmd``, and no loop at the rudder;
    ``room`` is the rudder's travel, ``ramp`` the rate of the bank reference in deg/s. For one roll
    response the sideslip is linear in the two gains, so a linear programme minimises its peak; this
    is repeated with the resulting roll response. The gains are then reduced until the rudder's
    margins are met.
    """
    feed, best, minimum = np.zeros(2), np.zeros(2), math.inf
    for _ in range(4):
        beta, p, phi, impulse = _entry(
            plant, replace(yaw, Kroll=float(feed[0]), Kbank=float(feed[1])), ramp
        )
        use = np.abs(feed[0] * p + feed[1] * phi).max()
        score = np.abs(beta).max() + _RUDDER_COST * max(use / room - req.TURN_USE, 0.0)
        if score < minimum:
            best, minimum = feed, score
        if not np.isfinite(impulse).all():
            break
        effect = np.array([fftconvolve(impulse, signal)[: len(impulse)] for signal in (p, phi)])
        cost = _RUDDER_COST / room * np.array([np.abs(p).max(), np.abs(phi).max()])
        feed = feed + _least_peak(beta, effect.T, cost)
    # the outer loops stabilise a divergence that exists without these gains, as at low airspeed
    limit = max(req.DIVERGENCE, 1.01 * damped(plant, yaw).growth())
    for fraction in _COORDINATED:
        gains = replace(yaw, Kroll=float(fraction * best[0]), Kbank=float(fraction * best[1]))
        steady = damped(plant, gains).growth() < limit
        if steady and requirement_met(_of_rudder(plant, gains))[0] == 0:
            return gains
    return yaw


def _entry(plant: Plant, gains: YawGains, ramp: float) -> tuple[np.ndarray, ...]:
    """Sideslip, roll rate and bank in the entry of a turn; sideslip after a rudder impulse."""
    p = damped(plant, gains).slower(_COARSE)
    turn = p.steps(
        "phi_cmd",
        ("beta", "p", "phi"),
        lambda k, y: min(ramp * p.T * k, req.BANK),
        1,
        _ROLL_IN,
    )
    impulse = p.steps("rudder", ("beta",), lambda k, y: float(k == 0), 1, _ROLL_IN)
    return *turn[:, :, 0].T, impulse[:, 0, 0]


def _least_peak(beta: np.ndarray, effect: np.ndarray, cost: np.ndarray) -> np.ndarray:
    """Gains that minimise max |beta + effect gains| plus a small cost of each gain's size."""
    m = len(cost)
    # variables: positive and negative parts of the gains, and the peak sideslip
    one = np.ones((len(beta), 1))
    both = np.hstack([effect, -effect])
    solution = linprog(
        np.concatenate([cost, cost, [1.0]]),
        A_ub=np.block([[both, -one], [-both, -one]]),
        b_ub=np.concatenate([-beta, beta]),
    )
    return np.zeros(m) if solution.x is None else solution.x[:m] - solution.x[m : 2 * m]


def _of_rudder(plant: Plant, gains: YawGains) -> LoopMargins:
    """Margins of the rudder's loops, broken at the rudder."""
    L = yaw_law(**vars(gains)).of(plant.response(OMEGA, "rudder"), plant.T)
    return loop_margins(OMEGA, L[None])


_HEADING_SHARES = np.geomspace(0.25, 1.6, 14)


def design_heading(
    plant: Plant,
    ramp: float,
    settling: float,
    vt: float,
    straight: float = 0.0,
    neighbours: Neighbours = ALONE,
) -> tuple[HeadingGains, LoopReport]:
    """Bank per heading error; ``plant`` has the roll loop closed with the input ``phi_cmd``.

    The bank settles in ``settling`` s and moves at ``ramp`` deg/s. ``straight`` is the bank of
    straight flight in deg, which is not 0 with a propeller.
    """
    turn = GRAVITY / vt  # psi-dot per phi, 1/s
    (Kp,) = neighbours.joined("heading", Kp=min(0.25, 0.7 / settling) / turn * _HEADING_SHARES)
    Kp = np.clip(Kp, 0.3, 6.0)
    margins = loop_margins(OMEGA, Kp[:, None] * plant.response(OMEGA, "phi_cmd")["psi"])
    level = requirement_met(margins)
    p, requirement = plant.slower(_COARSE), STEP_REQUIREMENTS["heading"]
    cmd = np.zeros(len(Kp))

    def law(k: int, y: np.ndarray) -> np.ndarray:
        target = np.clip(Kp * (requirement.size - y[0]), -req.BANK, req.BANK)
        cmd[:] += np.clip(target - cmd, -ramp * p.T, ramp * p.T)
        return cmd

    y = p.steps("phi_cmd", ("psi", "phi"), law, len(Kp), 60.0)
    time, over, _ = step_quality(y[:, 0] - requirement.size, requirement.tolerance, p.T)
    bank = np.abs(y[:, 1]).max(axis=0)
    score = time + 200.0 * np.maximum(over - 0.5 * requirement.overshoot, 0.0) + 10.0 * level
    score += requirement.size / (turn * req.BANK) * neighbours.cost("heading", Kp=Kp)
    i = int(np.argmin(np.where(np.isfinite(score), score, 1e6 + over)))
    if level[i] == len(MARGINS) or not math.isfinite(time[i]):
        raise Unstable("heading", "no gain of the heading loop settles a turn")
    return HeadingGains(Kp=float(Kp[i]), bank=straight), reported(
        "heading", margins, i, requirement, time[i], over[i], bank[i] / req.BANK
    )


SPEED = Loop("speed", "throttle", "vc", "climb", STEP_REQUIREMENTS["speed"])


def with_climb(plant: Plant) -> Plant:
    """The plant with the input ``hdot_cmd`` and, behind the lag of `SpeedLoop`, ``climb``."""
    if "climb" in plant.outputs:
        return plant
    return plant.lagged("hdot_cmd", "climb", SpeedLoop.LAG)


def speed_law(plant: Plant, gains: SpeedGains) -> Law:
    """The law at the throttle: in turbulence it follows the airspeed without gusts."""
    slope = -math.expm1(-plant.T / gains.Tf) / plant.T
    airspeed = "airspeed" if "airspeed" in plant.outputs else "vc"
    return Law({airspeed: (gains.Kp, gains.Ki, gains.Kd * slope), "climb": (-gains.Kc,)}, gains.Tf)


def with_speed(plant: Plant, gains: SpeedGains) -> Plant:
    """The plant with the airspeed loop closed; the throttle becomes an output."""
    plant, law = with_climb(plant), speed_law(plant, gains)
    return plant.close("throttle", law, ("vc_cmd", gains.Kp * gains.b, gains.Ki), "throttle")


# from the fastest to the slowest, rad/s
_SPEED_CROSSOVERS = np.geomspace(*req.SPEED_CROSSOVERS[::-1], 25)


def design_speed(
    plant: Plant,
    vc: float,
    room: tuple[float, float],
    Kc: float,
    neighbours: Neighbours = ALONE,
    altitude: AltitudeGains | None = None,
) -> SpeedGains:
    """Throttle from airspeed: one loop for all conditions of an aircraft.

    .. math::
        \\dot V = a \\, u - d \\, V, \\qquad
        K_p = \\frac{\\omega_c}{a}, \\qquad K_i = \\frac{K_p}{T_i}

    with the slopes of `level_slopes`. The crossover is the highest within its range at which the
    throttle's rms in moderate turbulence is at most a third of the smaller distance to a stop, with
    the ``altitude`` held, and Kp at most 0.032 per kt. Without these gains, or for a plant without
    turbulence, it is 0.12 rad/s. The weight b of the reference cancels the slower pole of the
    closed loop; otherwise the airspeed would overshoot.

    ``plant`` has the pitch angle held, ``vc`` is the airspeed in KCAS, ``room`` the minimum and
    maximum throttle increment, ``Kc`` the feed-forward of the rate of climb. If there are
    neighbours, all gains but ``Kc`` are theirs.
    """
    for neighbour in neighbours.gains:
        if neighbour.speed is not None:
            return replace(neighbour.speed, Kc=Kc)
    thrust, drag = level_slopes(plant)

    def shaped(crossover: float) -> SpeedGains:
        Kp, Ti, half = crossover / thrust, req.SPEED_TIME, 0.5 * (crossover + drag)
        slower = half - math.sqrt(max(half * half - crossover / Ti, 0.0))
        if not min(thrust, slower) > 0.0:
            raise Unstable("speed", "the throttle cannot hold the airspeed of level flight")
        return SpeedGains(
            Kp=Kp,
            Ki=Kp / Ti,
            Kd=-Kp * SpeedGains.Tf,
            b=min(1.0 / (Ti * slower), 1.0),
            ramp=max(req.SPEED_RAMP, vc / req.SPEED_RAMP_TIME),
            Kc=Kc,
            band=req.GUST,
        )

    if altitude is None or AIR[0] not in plant.inputs:
        return shaped(req.SPEED_CROSSOVER)
    plant, limit = with_altitude(plant, altitude), req.THROTTLE_IN_TURBULENCE
    for crossover in _SPEED_CROSSOVERS:
        gains = shaped(crossover)
        _, moves = moved(plant, speed_law(plant, gains), "throttle")
        quiet = moves["throttle"] <= limit * min(-room[0], room[1])
        if quiet and gains.Kp <= req.THROTTLE_PER_KNOT:
            break
    return gains


def level_slopes(plant: Plant) -> tuple[float, float]:
    """Acceleration per full throttle in kt/s, and deceleration per kt of airspeed in 1/s.

    Evaluated below the crossover of the airspeed loop, as engines follow up to there, and with the
    pitch angle that keeps the rate of climb at 0.
    """
    w = np.array([0.1])
    throttle, theta = plant.response(w, "throttle"), plant.response(w, "theta_cmd")
    level = throttle["vc"] - theta["vc"] * throttle["hdot"] / theta["hdot"]
    thrust = float((w / (1.0 / level).imag)[0])
    return thrust, thrust * float((1.0 / level).real[0])


def speed_report(
    plant: Plant, gains: SpeedGains, room: tuple[float, float], step: float
) -> LoopReport:
    """Margins, and a ``step`` in kt; ``plant`` has the altitude held, and may have turbulence."""
    plant = with_climb(plant)
    L, moves = moved(plant, speed_law(plant, gains), "throttle")
    margins, zero = loop_margins(OMEGA, L[None]), np.zeros(1)
    if requirement_met(margins)[0] == len(MARGINS):
        raise Unstable("speed", "no gains of the throttle hold the airspeed")
    rough = Rough(zero, zero, at_a_stop(moves["throttle"][None], room))
    p, requirement = plant.slower(_COARSE), SPEED.required
    error, peak = tracked(
        p,
        SPEED,
        step,
        requirement.seconds,
        gains.ramp,
        room,
        np.array([[gains.Kp], [gains.Ki], [-gains.Kc]]),
        np.array([gains.b]),
        gains.Tf,
        gains.band,
    )
    time, over, _ = step_quality(error, requirement.tolerance, p.T)
    use = peak[0] / min(-room[0], room[1])
    return reported("speed", margins, 0, requirement, time[0], over[0], use, rough.violations(0))


def design_feed(plant: Plant, room: tuple[float, float], rise: float) -> tuple[float, float]:
    """Throttle per rate of climb that holds the airspeed, s/ft, and per kt, at low frequency.

    ``plant`` has the pitch loop closed; a ``rise`` in ft/s may use the remaining throttle.
    """
    w = np.array([0.05])
    throttle, theta = plant.response(w, "throttle"), plant.response(w, "theta_cmd")
    ratio = -theta["vc"] / throttle["vc"]
    climb = theta["hdot"] + ratio * throttle["hdot"]
    limit = min(-room[0], room[1]) / rise
    gain = float(np.abs(plant.response(OMEGA[:1], "throttle")["vc"])[0])
    return float(np.clip((ratio / climb).real[0], 0.0, limit)), 1.0 / gain


_CLIMB_CROSSOVERS = np.geomspace(0.15, 1.6, 32)
_CLIMB_PHASES = np.linspace(60.0, 108.0, 7)
_CLIMB_RATIOS = np.geomspace(2.5, 24.0, 7)

# lower bound of a step's settling time, as a fraction of the time at the maximum rate of climb
_SOONEST = 0.8


def altitude_law(Kp: Any, Ki: Any, Kh: Any) -> Law:
    """The law from altitude and rate of climb to the pitch reference."""
    return Law({"hdot": (Kp, Ki), "h": (Kp * Kh, Ki * Kh)})


def with_altitude(plant: Plant, gains: AltitudeGains) -> Plant:
    """The plant with the altitude loop closed, without the inputs ``theta_cmd``, ``hdot_cmd``."""
    climbing = with_climb(plant).close("hdot_cmd", climb_law(gains.Kh))
    return climbing.close("theta_cmd", altitude_law(gains.Kp, gains.Ki, gains.Kh))


def climb_law(Kh: Any) -> Law:
    """The law from altitude to the commanded rate of climb, which the throttle's loop uses too."""
    return Law({"h": (Kh,)})


def _altitude_candidates(plant: Plant, neighbours: Neighbours) -> np.ndarray:
    """Kp, Ki and Kh of all combinations."""
    g = plant.response(OMEGA, "theta_cmd")["hdot"]
    w, phase = grid(_CLIMB_CROSSOVERS, _CLIMB_PHASES)
    G = at(w, g)
    Ki, Kp = crossing(G * integral(w, plant.T), G, phase)
    good = (Ki >= 0.0) & np.isfinite(Ki)
    Kp, Ki = Kp[good], Ki[good]
    climb = Law({"hdot": (Kp[:, None], Ki[:, None])})
    wc = loop_margins(OMEGA, climb.of({"hdot": g}, plant.T)).crossover
    k, r = grid(np.arange(len(Kp)), _CLIMB_RATIOS)
    Kh = np.minimum(wc[k] / r, 0.3)
    return np.array(neighbours.joined("altitude", Kp=Kp[k], Ki=Ki[k], Kh=Kh))


def design_altitude(
    plant: Plant,
    ramp: float,
    hdot_max: float,
    room: tuple[float, float] = (-1.0, 1.0),
    neighbours: Neighbours = ALONE,
) -> tuple[AltitudeGains, LoopReport]:
    """Pitch reference from the rate of climb; ``plant`` has pitch and airspeed loops closed.

    ``ramp`` is the rate of the pitch reference, deg/s, ``hdot_max`` the maximum rate of climb,
    ft/s, ``room`` the throttle's minimum and maximum increment.
    """
    gains, requirement = _altitude_candidates(plant, neighbours), STEP_REQUIREMENTS["altitude"]
    plant, (Kp, Ki, Kh) = with_climb(plant), gains
    law, climb = altitude_law(*gains[:, :, None]), climb_law(gains[2][:, None])
    outputs = "h", "theta", "throttle"
    L, moves = moved(plant, law, "theta_cmd", *outputs, inner=("hdot_cmd", climb))
    rough = Rough(moves["h"], moves["theta"], at_a_stop(moves["throttle"], room))
    margins = loop_margins(OMEGA, L)
    level = requirement_met(margins)
    soonest = _SOONEST * requirement.size / hdot_max
    cost = 30.0 * level + 6.0 * margins.crossover + rough.cost()
    cost += soonest * neighbours.cost("altitude", Kp=Kp, Ki=Ki, Kh=Kh)
    pick = np.flatnonzero(level < len(MARGINS))
    if not len(pick):
        raise Unstable("altitude", "no gains of the rate of climb are stable")

    def fly(j: np.ndarray) -> tuple[np.ndarray, ...]:
        error, speed, peak = _climbs(plant, gains[:, j], ramp, hdot_max)
        time, over, late = step_quality(error, requirement.tolerance, _COARSE * plant.T)
        score = (
            time
            + 10.0 * np.maximum(over - 1.0, 0.0)
            + 200.0 * np.maximum(late - 0.05, 0.0)
            + cost[j]
            + 2.0 * speed
            + np.maximum(peak - 8.0, 0.0)
        )
        return score, time, over, late, peak

    j, time, over, _, peak = _least(pick, cost + soonest, fly)
    return AltitudeGains(
        Kh=float(Kh[j]), Kp=float(Kp[j]), Ki=float(Ki[j]), hdot_max=hdot_max
    ), reported("altitude", margins, j, requirement, time, over, peak / 10.0, rough.violations(j))


# candidates of the first batch, and factor of the next ones: most of the time of a step response
# does not depend on the number of candidates
_BATCH, _MORE = 256, 4


def _least(
    pick: np.ndarray, floor: np.ndarray, fly: Callable[[np.ndarray], tuple[np.ndarray, ...]]
) -> tuple[Any, ...]:
    """The candidate of ``pick`` with the minimum score, and its other results of ``fly``.

    ``fly`` returns the scores of some candidates, each at least its ``floor``, then settling time,
    overshoot, last error and peak. If no candidate settles, the last error decides.
    """
    order = pick[np.argsort(floor[pick], kind="stable")]
    best: tuple[Any, ...] = ()
    batch = _BATCH
    while len(order):
        candidates, order = order[:batch], order[batch:]
        batch *= _MORE
        score, *results = fly(candidates)
        late = np.nan_to_num(results[2], nan=math.inf)
        score = np.where(np.isfinite(score), score, 1e6 + late)
        i = int(np.argmin(score))
        if not best or score[i] < best[0]:
            best = (float(score[i]), int(candidates[i]), *(float(x[i]) for x in results))
        # drop those whose floor is above the best score
        order = order[floor[order] < best[0]]
    return best[1:]


def _climbs(
    plant: Plant, gains: np.ndarray, ramp: float, hdot_max: float
) -> tuple[np.ndarray, ...]:
    """Errors of climbs, shape (samples, loops), and maximum changes of airspeed and pitch."""
    p, step = plant.slower(_COARSE), STEP_REQUIREMENTS["altitude"].size
    Kp, Ki, Kh = gains
    step_max = ramp * p.T
    total, cmd, peak = np.zeros((3, len(Kh)))

    def law(k: int, y: np.ndarray) -> np.ndarray:
        climb = np.minimum(np.maximum(Kh * (step - y[0]), -hdot_max), hdot_max)
        error = climb - y[1]
        cmd[:] += np.minimum(np.maximum(Kp * error + total - cmd, -step_max), step_max)
        total[:] += Ki * p.T * error
        np.maximum(peak, np.abs(cmd), out=peak)
        return np.array([cmd, climb])

    seconds = 80.0 + 1.3 * step / hdot_max
    inputs = "theta_cmd", "hdot_cmd"
    y = p.steps(inputs, ("h", "hdot", "vc"), law, len(Kh), seconds)
    return y[:, 0] - step, np.abs(y[:, 2]).max(axis=0), peak
