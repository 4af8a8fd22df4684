"""Protection from stall, ground and overspeed: limits on pitch, climb, bank and airspeed."""

from __future__ import annotations

import math
from typing import NamedTuple

from .._core.units import GRAVITY
from ..control.airspeeds import ComplementaryAirspeed, fastest_airspeed, true_airspeed
from ..control.gains import EnvelopeLimits
from ..control.loops import DEGREES, RADIANS
from ..control.pid import clip


def share_of_climb(vc: float, vc_cmd: float) -> float:
    """Fraction of the climb allowed at a low airspeed, for holds without a protection.

    1 down to 90 % of the commanded airspeed, 0 (level) at 80 %, -1 (descent) at 70 %.
    """
    return clip((vc / vc_cmd - 0.8) / 0.1, -1.0, 1.0) if vc_cmd > 0.0 else 1.0


class Allowed(NamedTuple):
    """Limits set by a `Protection`; the defaults limit no reference."""

    theta_max: float = math.inf  # deg
    theta_min: float = -math.inf
    climb_max: float = math.inf  # ft/s
    climb_min: float = -math.inf
    boost: float = 0.0  # throttle to add, negative to reduce it
    vc_min: float = -math.inf  # kt
    vc_max: float = math.inf
    feed: float = 0.0  # throttle increment for a descent that the airspeed limits, at most 0


NO_LIMITS = Allowed()


class ProtectionState(NamedTuple):
    """State of a `Protection`."""

    has_values: bool = False  # whether the filters have values
    calm: float = 0.0  # angle of attack from the aircraft's own motion, deg, and its rate, deg/s
    calm_rate: float = 0.0
    gust: float = 0.0  # angle of attack from gusts, deg, filtered
    v: float = 0.0  # true airspeed, ft/s; 0 before the first sample
    inertial: float = 0.0  # v without gusts, from the aircraft's motion
    acceleration: float = 0.0  # its rate, filtered
    airspeed: float = 0.0  # v, filtered
    available: float = 0.0  # excess rate of climb at full throttle, ft/s
    measured: float = 0.0  # and at the present throttle
    climb: float = 0.0  # rate of climb, filtered
    load: float = 1.0  # vertical load factor, filtered
    level: float = 0.0  # alpha above zero lift with the wings level, deg, filtered
    stop: float = 0.0  # fraction of the time with the elevator at its stop
    reach: float = 90.0  # angle of attack that the elevator can hold, deg


class Protection:
    """Limits of the references that keep the aircraft off the stall, the ground and overspeed.

    .. math::
        \\theta &\\le \\theta + \\alpha_\\mathrm{max} - \\hat\\alpha - \\tau\\dot{\\hat\\alpha} \\\\
        V_\\mathrm{min} &= 1.1 \\, V \\sqrt{\\frac{\\alpha}{n \\, \\alpha_\\mathrm{max}}} \\\\
        \\dot h_\\mathrm{cmd} &\\le \\hat P + \\frac{k V}{g} (V - V_\\mathrm{min}), \\qquad
        P = \\dot h + \\frac{V \\dot V}{g} \\\\
        \\dot h_\\mathrm{cmd} &\\ge P + \\frac{k V}{g} (V - V_\\mathrm{max}) \\\\
        \\dot h_\\mathrm{cmd} &\\ge k (h_0 - h_\\mathrm{agl})

    The first makes the pitch loop hold the maximum angle of attack if more pitch would exceed it.
    The estimate follows pitch angle less path angle, and the measurement with a lag of 2 s, so that
    short gusts do not lower the nose. The minimum airspeed follows from the present angle of
    attack, which reflects weight, flaps and load factor; n removes the effect of a short pull-up.
    If the elevator reaches its stop, the angle of attack at that moment replaces the maximum.

    The third lets the airspeed fall towards its minimum no faster than with the time constant 1/k,
    and commands a descent below it, but not near the ground. The fourth ends a descent at the
    maximum airspeed, or a little above the commanded one, the fifth above the ground. The excess
    rate of climb is that at full throttle: from the gain table until the throttle saturates, then
    from the measurement.

    Without an ``envelope`` only the angle of attack is limited.
    """

    START = ProtectionState()

    LEAD = 0.4  # lead time of the angle of attack, s
    RATE = 0.15  # time constant of the filter of its rate, s
    SLOW = 2.0  # time constant of the filters of acceleration, airspeed and lift, s
    ADAPT = 3.0  # time constant towards the climb measured at full throttle, s
    DECAY = 0.1  # rate at which airspeed and height may approach their limits, 1/s
    MARGIN = 1.1  # minimum airspeed over that at which the elevator reached its stop
    LIFT = 1.1  # load factor at the minimum airspeed
    LOADS = (0.5, 2.0)  # limits of the estimated vertical load factor
    LOAD = 0.8  # load factor increment of a moving pitch reference, g
    LEAST_LIFT = 0.1  # minimum fraction of the maximum lift, avoids division by 0
    STEEPEST = 75.0  # maximum bank in 1 / cos(phi), deg
    SLOWEST = 50.0  # minimum true airspeed as a divisor, ft/s
    BANK_YIELDS = 1.0  # margin to the maximum angle of attack at which the bank is reduced, deg
    STOPPED = 0.5  # fraction of the time at its stop above which the elevator is saturated
    CLIMB_KEPT = 8.0  # allowed rate of climb below which the bank is reduced, ft/s
    SINK = 30.0  # sink rate beyond the limit at which the wings are levelled, ft/s
    GENTLE = 10.0  # bank that costs hardly any thrust, deg
    RELEARN = 0.02  # rate at which the elevator's reach is increased again, deg/s
    CLEARANCE = 100.0  # height above the ground at which a descent ends, ft
    TRADED = 500.0  # height above the ground below which no height is traded for airspeed, ft

    BOOST_ENDS_ABOVE = 0.985  # fraction of the commanded airspeed
    # below the commanded airspeed: down to this error the climb is reduced to the measured excess,
    # and beyond it further, to regain the airspeed, kt
    CLIMB_YIELDS = 5.0
    # and for full throttle: at a third of it the throttle of a c172p at its minimum airspeed
    # oscillates by 0.6, at three times it an A320 loses 150 ft
    BOOST_FULL_AT = 6.0
    MAKES_WAY = 2.0  # throttle reduction over the throttle that the remaining descent would save

    # fractions of the minimum airspeed
    DESCENT_REGAINS_BELOW = 1.15  # behind the power curve a descent may regain the commanded one
    DESCENT_FORCED_BELOW = 0.96
    CLOSED_AT = 0.04  # fraction of the maximum airspeed: excess for which the throttle is closed
    AHEAD = 2.0  # prediction time of the airspeed, from the rate of the energy, s
    DESCENT_YIELDS = 5.0  # excess over the commanded airspeed beyond which a descent is reduced, kt

    def __init__(self, T: float, alpha_max: float | None, envelope: EnvelopeLimits | None):
        self.T = T
        self._own = alpha_max is not None
        self.alpha_max = 0.0 if alpha_max is None else alpha_max
        self.flies_envelope = envelope is not None
        self.alpha_zero = 0.0
        if envelope:
            self.retune(envelope)
        self._alpha_filter = -math.expm1(-T / self.RATE)
        self._slow_filter = -math.expm1(-T / self.SLOW)
        self._adapt = -math.expm1(-T / self.ADAPT)

    def retune(self, limits: EnvelopeLimits) -> None:
        self.limits, self.alpha_zero = limits, limits.alpha_zero
        if not self._own:
            self.alpha_max = limits.alpha_max

    def sample(
        self,
        state: ProtectionState,
        theta: float,
        alpha: float,
        h: float,
        hdot: float,
        vc: float,
        full_elevator: bool,
        full_throttle: bool,
        vc_cmd: float | None = None,
        hold_pitch: bool = False,
        phi: float = 0.0,
        h_agl: float | None = None,
        eases: bool = False,
        *,
        airspeed: float | None = None,
        cut: float = 0.0,
    ) -> tuple[Allowed, ProtectionState]:
        """Limits of the references, and the next state.

        If ``full_throttle`` and ``full_elevator`` are set, the measured excess and angle of attack
        are the maximum attainable. ``vc_cmd`` is the airspeed that has priority over a climb;
        ``hold_pitch`` limits the pitch reference to the path angles of the allowed rates of climb;
        ``eases`` reduces a descent to keep the airspeed; ``cut`` is the last commanded rate of
        climb less the allowed one. ``airspeed`` is that without gusts, kt, and ``vc`` by default:
        the energy and the priority of ``vc_cmd`` follow it, the limits of the airspeed ``vc``. A
        ``vc`` of 0 or a ``h_agl`` of None (not connected) sets no limit.
        """
        per_knot, stops = true_airspeed(1.0, h), (full_elevator, full_throttle)
        airspeed = vc if airspeed is None else airspeed
        speeds = vc * per_knot, airspeed * per_knot
        state = self._filtered(state, theta, alpha, *speeds, hdot, phi, *stops)
        theta_max = theta + self.alpha_max - self._ahead(state)
        if not self.flies_envelope:
            return Allowed(theta_max), state
        v, moving, share = state.v, vc > 0.0, self._used(state)
        vc_max = fastest_airspeed(self.limits.vmo, self.limits.mmo, h)
        fastest = max(vc_max * per_knot, 1.0)
        # without the bank's load factor: the bank is reduced before height is traded for airspeed
        slowest = max(state.airspeed * share**0.5, 1.0)
        stiffness = self.DECAY * v / GRAVITY
        spare = stiffness * (v - self.DESCENT_FORCED_BELOW * slowest)
        steady = max(state.measured + spare, -self.limits.descent_max)
        height = math.inf if h_agl is None else h_agl
        floor = self.DECAY * (self.CLEARANCE - height)
        trade = max(floor, min(self.DECAY * (self.TRADED - height), 0.0))
        highest, boost, feed, limit = steady, 0.0, 0.0, fastest
        if vc_cmd is not None:
            target = max(vc_cmd * per_knot, 1.0)
            within = per_knot * ComplementaryAirspeed.within(airspeed, vc)
            highest, boost = self._for_airspeed(
                state, within, target, per_knot, slowest, stiffness, spare
            )
            boost = self._boost(state, boost, floor, fastest)
            if eases:
                limit = min(target + self.DESCENT_YIELDS * per_knot, fastest)
        lowest = gentle = floor
        if moving:
            lowest, gentle, feed = self._for_descent(state, floor, fastest, limit, stiffness, cut)
        theta_min = -math.inf
        if hold_pitch:
            path = DEGREES / max(v, self.SLOWEST)
            theta_min = alpha + path * max(lowest, -v)
            if moving:
                theta_max = min(theta_max, alpha + path * min(max(steady, lowest, trade), v))
        # here with the load factor of the turn, as it limits the commanded airspeed
        turning = share / math.cos(RADIANS * clip(phi, -self.STEEPEST, self.STEEPEST))
        vc_min = state.airspeed * turning**0.5 / per_knot
        highest, boost = (max(highest, lowest, trade), boost) if moving else (math.inf, 0.0)
        return Allowed(theta_max, theta_min, highest, gentle, boost, vc_min, vc_max, feed), state

    def _excess(
        self, state: ProtectionState, excess: float, full_throttle: bool
    ) -> tuple[float, float]:
        """Rates of climb in ft/s that full throttle sustains, and that the present one does."""
        if not self.flies_envelope:
            return 0.0, 0.0
        climb_max = self.limits.climb_max
        # limited, because a gust changes the airspeed faster than thrust and drag can
        excess = clip(excess, -self.limits.descent_max, climb_max)
        available, measured = climb_max, excess
        if state.v != 0.0:
            available, measured = state.available, state.measured
        available += self._adapt * ((excess if full_throttle else climb_max) - available)
        return available, measured + self._adapt * (excess - measured)

    def _filtered(
        self,
        state: ProtectionState,
        theta: float,
        alpha: float,
        v: float,
        inertial: float,
        hdot: float,
        phi: float,
        full_elevator: bool,
        full_throttle: bool,
    ) -> ProtectionState:
        """The state with the estimates of this sample."""
        slow, moving = self._slow_filter, state.v != 0.0
        level = (alpha - self.alpha_zero) * math.cos(RADIANS * phi)
        calm = alpha
        if v > 0.0:
            # theta - gamma = alpha cos(phi): in a steep bank the pitch angle counts less
            path = DEGREES * hdot / max(state.airspeed or v, self.SLOWEST)
            upright = math.cos(RADIANS * phi)
            calm += upright * (theta - path - upright * alpha)
        calm_rate, gust, acceleration, airspeed, climb = 0.0, alpha - calm, 0.0, v, hdot
        if moving:
            acceleration = state.acceleration
            acceleration += slow * ((inertial - state.inertial) / self.T - acceleration)
            airspeed = state.airspeed + slow * (v - state.airspeed)
        if state.has_values:
            calm_rate = state.calm_rate
            calm_rate += self._alpha_filter * ((calm - state.calm) / self.T - calm_rate)
            gust = state.gust + slow * (gust - state.gust)
            climb = state.climb + slow * (hdot - state.climb)
            level = state.level + slow * (level - state.level)

        available, measured = self._excess(state, hdot + v * acceleration / GRAVITY, full_throttle)
        load = clip(1.0 + (hdot - climb) / (self.SLOW * GRAVITY), *self.LOADS)
        stop = state.stop + slow * ((1.0 if full_elevator else 0.0) - state.stop)
        reach = min(state.reach + self.RELEARN * self.T, 90.0)
        if full_elevator and stop > self.STOPPED:
            reach = min(reach, max(alpha, self.alpha_zero + 1.0))
        return ProtectionState(
            has_values=True,
            calm=calm,
            calm_rate=calm_rate,
            gust=gust,
            v=v,
            inertial=inertial,
            acceleration=acceleration,
            airspeed=airspeed,
            available=available,
            measured=measured,
            climb=climb,
            load=load,
            level=level,
            stop=stop,
            reach=reach,
        )

    def _ahead(self, state: ProtectionState) -> float:
        """The angle of attack predicted from the aircraft's motion, without short gusts, deg."""
        return state.calm + state.gust + self.LEAD * state.calm_rate

    def _used(self, state: ProtectionState) -> float:
        """Lift of straight and level flight over the maximum allowed at this airspeed."""
        lift_max = self.limits.lift_max * (self.alpha_max - self.alpha_zero)
        lift_max = min(lift_max, (state.reach - self.alpha_zero) / self.MARGIN**2)
        return max(state.level / (lift_max * state.load), self.LEAST_LIFT)

    def _for_airspeed(
        self,
        state: ProtectionState,
        v: float,
        target: float,
        per_knot: float,
        slowest: float,
        stiffness: float,
        spare: float,
    ) -> tuple[float, float]:
        """Maximum rate of climb, and throttle to add, for an airspeed that has priority.

        ``v`` is the airspeed without gusts, within its limits, ft/s: as only errors below the
        ``target`` count, gusts would cost height. The throttle to add, per knot some ten times that
        of the loop, follows it without limits: gusts beyond them would move it from stop to stop.
        """
        available, measured = state.available, state.measured
        yields = target - self.CLIMB_YIELDS * per_knot
        # while the commanded airspeed is held, reserve throttle for the climb
        reserve = (v - yields) / (target - yields)
        climb = measured + clip(reserve, 0.0, 1.0) * (available - measured)
        # behind the power curve it requires throttle and a descent to recover the airspeed
        deficit = clip((self.DESCENT_REGAINS_BELOW - state.airspeed / slowest) / 0.1, 0.0, 1.0)
        trade = available - stiffness * (yields - v)
        highest = min(max(trade, -deficit * self.limits.descent_max), climb + spare)
        rate = state.acceleration + GRAVITY * state.climb / max(state.v, self.SLOWEST)
        missing = self.BOOST_ENDS_ABOVE * target - state.inertial - self.AHEAD * rate
        boost = clip(deficit * missing / (self.BOOST_FULL_AT * per_knot), 0.0, 1.0)
        return max(highest, -self.limits.descent_max), boost

    def _for_descent(
        self,
        state: ProtectionState,
        floor: float,
        fastest: float,
        limit: float,
        stiffness: float,
        cut: float,
    ) -> tuple[float, float, float]:
        """Minimum rates of climb and throttle to reduce, for airspeeds that a descent must keep.

        The first rate is for the maximum airspeed ``fastest``, the second for the ``limit`` that
        eases a descent, both ft/s and at least the ``floor``.
        """
        # at most 0: level flight at idle is enough to decelerate
        lowest = max(floor, min(state.measured + stiffness * (state.v - fastest), 0.0))
        gentle = max(lowest, min(state.measured + stiffness * (state.airspeed - limit), 0.0))
        if gentle <= lowest:
            return lowest, gentle, 0.0
        # reduce the throttle: only less thrust allows this descent at the airspeed
        travel = self.limits.climb_max + self.limits.descent_max
        return lowest, gentle, clip(self.MAKES_WAY * cut / travel, -1.0, 0.0)

    def _boost(self, state: ProtectionState, boost: float, floor: float, fastest: float) -> float:
        """Throttle to add, or negative above the maximum airspeed."""
        # if the pitch limit prevents the end of a forbidden sink, full throttle must end it
        boost = max(boost, min((floor - state.climb) / self.CLIMB_KEPT, 1.0))
        excess = state.airspeed + self.AHEAD * state.acceleration - fastest
        return boost - clip(excess / (self.CLOSED_AT * fastest), 0.0, 1.0)

    def pitch_rate(self, vc: float, h: float) -> float:
        """Maximum rate of the pitch reference at an airspeed, from the load factor, deg/s."""
        return math.degrees(self.LOAD * GRAVITY) / max(true_airspeed(vc, h), self.SLOWEST)

    def bank(self, bounds: Allowed, state: ProtectionState, command: float, phi: float) -> float:
        """The commanded bank in deg within its limit; call it after `sample`.

        The load factor of a level turn is limited by the airspeed, and by the margin of the angle
        of attack, to which it is proportional: the bank is reduced before the pitch angle and, if
        the allowed rate of climb is below `CLIMB_KEPT`, before the height.
        """
        alpha = self._ahead(state) - self.alpha_zero
        ratio = (self.alpha_max - self.BANK_YIELDS - self.alpha_zero) / max(alpha, 1e-6)
        load = ratio * state.load / math.cos(RADIANS * phi)
        if self.flies_envelope:
            load = min(load, self.LIFT / self._used(state))
        limit = DEGREES * math.acos(1.0 / max(load, 1.0))
        share = limit * clip(bounds.climb_max / self.CLIMB_KEPT, 0.0, 1.0)
        limit = min(limit, max(share, self.GENTLE))
        # near the ground or at overspeed, level wings use all of the lift to end the sink
        excess = clip(bounds.climb_min - state.climb, 0.0, self.SINK)
        limit *= 1.0 - excess / self.SINK
        return clip(command, -limit, limit)
