"""Protection from stall, ground and overspeed: limits on pitch, climb, bank and airspeed."""

from __future__ import annotations

import math
from typing import NamedTuple

from .._core.units import GRAVITY
from ..control.airspeeds import fastest_airspeed, true_airspeed
from ..control.gains import EnvelopeLimits
from ..control.loops import DEGREES, RADIANS
from ..control.pid import clip


def share_of_climb(vc: float, vc_cmd: float) -> float:
    """Share of the climb that an airspeed leaves, without a protection that measures it.

    1 down to 90 % of the airspeed demanded, 0 (level) at 80 %, -1 (descent) at 70 %.
    """
    return clip((vc / vc_cmd - 0.8) / 0.1, -1.0, 1.0) if vc_cmd > 0.0 else 1.0


class Allowed(NamedTuple):
    """What a `Protection` allows; by default everything."""

    theta_max: float = math.inf  # deg
    theta_min: float = -math.inf
    climb_max: float = math.inf  # ft/s
    climb_min: float = -math.inf
    boost: float = 0.0  # throttle to add, or to take where negative
    vc_min: float = -math.inf  # kt
    vc_max: float = math.inf
    feed: float = 0.0  # throttle that makes way for a descent, at most 0


EVERYTHING = Allowed()


class ProtectionState(NamedTuple):
    """State of a `Protection`."""

    known: bool = False  # the angle of attack
    own: float = 0.0  # deg, angle of attack by the aircraft's own motion, and its rate, deg/s
    own_rate: float = 0.0
    gust: float = 0.0  # deg, what the air adds to it, filtered
    v: float = 0.0  # true airspeed, 0 while unknown
    acceleration: float = 0.0
    airspeed: float = 0.0  # v without gusts
    available: float = 0.0  # rate of climb at full throttle
    measured: float = 0.0  # and at the present one
    climb: float = 0.0  # rate of climb, filtered
    load: float = 1.0  # vertical load factor, filtered
    level: float = 0.0  # deg, alpha above that of no lift with the wings level, filtered
    stopped: float = 0.0  # share of the time with the elevator at its stop
    reach: float = 90.0  # deg, angle of attack that the elevator can hold


class Protection:
    """Limits of the references that keep the aircraft off the stall, the ground and overspeed.

    .. math::
        \\theta &\\le \\theta + \\alpha_\\mathrm{max} - \\hat\\alpha - \\tau\\dot{\\hat\\alpha} \\\\
        V_\\mathrm{min} &= 1.1 \\, V \\sqrt{\\frac{\\alpha}{n \\, \\alpha_\\mathrm{max}}} \\\\
        \\dot h_\\mathrm{cmd} &\\le \\hat P + \\frac{k V}{g} (V - V_\\mathrm{min}), \\qquad
        P = \\dot h + \\frac{V \\dot V}{g} \\\\
        \\dot h_\\mathrm{cmd} &\\ge P + \\frac{k V}{g} (V - V_\\mathrm{max}) \\\\
        \\dot h_\\mathrm{cmd} &\\ge k (h_0 - h_\\mathrm{agl})

    The first makes the pitch loop hold the largest angle of attack where more pitch would exceed
    it. Its estimate follows pitch less path angle, and with a lag of 2 s what is measured: gusts
    that pass do not lower the nose. The lowest airspeed follows from the angle of attack that the
    aircraft flies at, which shows its weight, flaps and load factor; n is the part of a passing
    pull-up. Where the elevator reaches its stop, the angle of attack found there takes the place of
    the largest one.

    The third lets the airspeed fall towards the lowest one no faster than with the time constant
    1/k, and demands a descent below it, but not near the ground; the fourth ends a descent at the
    highest airspeed, or a little above the one demanded, and the fifth above the ground. The excess
    of a climb is that at full throttle: the table's, until the throttle is at its stop; from then
    on what is measured.

    Without an ``envelope`` only the angle of attack is limited.
    """

    START = ProtectionState()

    LEAD = 0.4  # s, of the angle of attack
    RATE = 0.15  # s, filter of its rate
    SLOW = 2.0  # s, filter of acceleration, airspeed and lift
    ADAPT = 3.0  # s, towards the climb measured at full throttle
    DECAY = 0.1  # 1/s, with which airspeed and height may approach their limits
    MARGIN = 1.1  # lowest airspeed, of that at which the elevator reached its stop
    LIFT = 1.1  # load factor at the lowest airspeed
    LOADS = (0.5, 2.0)  # of the vertical load factor
    LOAD = 0.8  # g, of a change of the pitch reference
    LEAST_LIFT = 0.1  # share of the largest
    STEEPEST = 75.0  # deg of bank
    SLOWEST = 50.0  # ft/s, true airspeed
    BANK_YIELDS = 1.0  # deg below the largest angle of attack, before the pitch does
    STOPPED = 0.5  # share of the time at its stop, from which the elevator is at its end
    CLIMB_KEPT = 8.0  # ft/s, below which the bank is less, down to
    SINK = 30.0  # ft/s beyond what ground and overspeed allow, for wings level
    GENTLE = 10.0  # deg, which takes hardly any thrust
    RELEARN = 0.02  # deg/s, with which more of the elevator's reach is tried
    CLEARANCE = 100.0  # ft above the ground, where a descent ends
    TRADED = 500.0  # ft above the ground, below which no height is given for airspeed

    # of the airspeed demanded
    BOOST_ENDS_ABOVE = 0.985
    CLIMB_YIELDS_BELOW = 0.97  # from 1 on, from the climb at full throttle to that measured
    CLIMB_TRADED_BELOW = 0.95  # the airspeed is regained at the climb's expense
    MAKES_WAY = 2.0  # throttle taken, of that which the rest of the descent would save

    # of the lowest airspeed
    DESCENT_REGAINS_BELOW = 1.15  # behind the power curve, a descent may regain the one demanded
    DESCENT_FORCED_BELOW = 0.96
    BOOST_FULL_AT = 0.04  # so far below the one demanded, or above the highest, where it is taken
    AHEAD = 2.0  # s, of the airspeed, by the rate of the energy
    DESCENT_YIELDS = 5.0  # kt above the airspeed demanded, beyond which a descent does not take it

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
        h_agl: float = 0.0,
        eases: bool = False,
        *,
        cut: float = 0.0,
    ) -> tuple[Allowed, ProtectionState]:
        """Limits of the references, and the next state.

        ``full_throttle`` and ``full_elevator`` say whether the excess and the angle of attack
        measured are all there is; ``vc_cmd`` is the airspeed that has priority over a climb, None
        for none; ``hold_pitch`` limits the pitch reference to the path angles of the rates of climb
        too; ``eases`` limits a descent to what the airspeed leaves; ``cut`` is the last rate of
        climb demanded less the one allowed. A ``vc`` or ``h_agl`` of 0, without a wire, limits
        nothing.
        """
        per_knot, stops = true_airspeed(1.0, h), (full_elevator, full_throttle)
        state = self._filtered(state, theta, alpha, vc * per_knot, hdot, phi, *stops)
        theta_max = theta + self.alpha_max - self._ahead(state)
        if not self.flies_envelope:
            return Allowed(theta_max), state
        v, moving, used = state.v, vc > 0.0, self._used(state)
        vc_max = fastest_airspeed(self.limits.vmo, self.limits.mmo, h)
        fastest = max(vc_max * per_knot, 1.0)
        # the bank gives way before height is spent on airspeed
        slowest = max(state.airspeed * used**0.5, 1.0)
        stiffness = self.DECAY * v / GRAVITY
        spare = stiffness * (v - self.DESCENT_FORCED_BELOW * slowest)
        sustained = max(state.measured + spare, -self.limits.descent_max)
        above = h_agl if h_agl > 0.0 else math.inf
        floor = self.DECAY * (self.CLEARANCE - above)
        given = max(floor, min(self.DECAY * (self.TRADED - above), 0.0))
        most, boost, feed, kept = sustained, 0.0, 0.0, fastest
        if vc_cmd is not None:
            wanted = max(vc_cmd * per_knot, 1.0)
            most, boost = self._for_airspeed(state, wanted, slowest, stiffness, spare)
            boost = self._boost(state, boost, floor, fastest)
            if eases:
                kept = min(wanted + self.DESCENT_YIELDS * per_knot, fastest)
        least = eased = floor
        if moving:
            # level flight at idle is enough to slow down
            least = max(least, min(state.measured + stiffness * (v - fastest), 0.0))
            eased = max(least, min(state.measured + stiffness * (state.airspeed - kept), 0.0))
            if eased > least:
                # the throttle makes way for a descent that the airspeed does not allow with it
                travel = self.limits.climb_max + self.limits.descent_max
                feed = clip(self.MAKES_WAY * cut / travel, -1.0, 0.0)
        theta_min = -math.inf
        if hold_pitch:
            path = DEGREES / max(v, self.SLOWEST)
            theta_min = alpha + path * max(least, -v)
            if moving:
                theta_max = min(theta_max, alpha + path * min(max(sustained, least, given), v))
        # at the load factor of a turn
        turning = used / math.cos(RADIANS * clip(phi, -self.STEEPEST, self.STEEPEST))
        vc_min = state.airspeed * turning**0.5 / per_knot
        if moving:
            most = max(most, least, given)
        else:
            most, boost = math.inf, 0.0
        return Allowed(theta_max, theta_min, most, eased, boost, vc_min, vc_max, feed), state

    def _filtered(
        self,
        state: ProtectionState,
        theta: float,
        alpha: float,
        v: float,
        hdot: float,
        phi: float,
        full_elevator: bool,
        full_throttle: bool,
    ) -> ProtectionState:
        """The state with what has been measured."""
        slow, begun = self._slow_filter, state.v != 0.0
        level = (alpha - self.alpha_zero) * math.cos(RADIANS * phi)
        own = alpha
        if v > 0.0:
            # pitch less path angle is alpha cos(phi), and tells less of it in a steep bank
            path = DEGREES * hdot / max(state.airspeed or v, self.SLOWEST)
            upright = math.cos(RADIANS * phi)
            own += upright * (theta - path - upright * alpha)
        own_rate, gust, acceleration = 0.0, alpha - own, 0.0
        airspeed, climb = v, hdot
        if begun:
            acceleration = state.acceleration
            acceleration += slow * ((v - state.v) / self.T - acceleration)
            airspeed = state.airspeed + slow * (v - state.airspeed)
        if state.known:
            own_rate = state.own_rate
            own_rate += self._alpha_filter * ((own - state.own) / self.T - own_rate)
            gust = state.gust + slow * (gust - state.gust)
            climb = state.climb + slow * (hdot - state.climb)
            level = state.level + slow * (level - state.level)

        available = measured = 0.0
        if self.flies_envelope:
            most = self.limits.climb_max
            # a gust changes the airspeed faster than thrust and drag can
            excess = clip(hdot + v * acceleration / GRAVITY, -self.limits.descent_max, most)
            available, measured = most, excess
            if begun:
                available, measured = state.available, state.measured
            available += self._adapt * ((excess if full_throttle else most) - available)
            measured += self._adapt * (excess - measured)

        load = clip(1.0 + (hdot - climb) / (self.SLOW * GRAVITY), *self.LOADS)
        stopped = state.stopped + slow * ((1.0 if full_elevator else 0.0) - state.stopped)
        reach = min(state.reach + self.RELEARN * self.T, 90.0)
        if full_elevator and stopped > self.STOPPED:
            reach = min(reach, max(alpha, self.alpha_zero + 1.0))
        return ProtectionState(
            known=True,
            own=own,
            own_rate=own_rate,
            gust=gust,
            v=v,
            acceleration=acceleration,
            airspeed=airspeed,
            available=available,
            measured=measured,
            climb=climb,
            load=load,
            level=level,
            stopped=stopped,
            reach=reach,
        )

    def _ahead(self, state: ProtectionState) -> float:
        """The angle of attack without passing gusts, deg, as the aircraft's motion goes on."""
        return state.own + state.gust + self.LEAD * state.own_rate

    def _used(self, state: ProtectionState) -> float:
        """Lift of straight and level flight, of the largest that it may take at this airspeed."""
        largest = self.limits.lift_max * (self.alpha_max - self.alpha_zero)
        largest = min(largest, (state.reach - self.alpha_zero) / self.MARGIN**2)
        return max(state.level / (largest * state.load), self.LEAST_LIFT)

    def _for_airspeed(
        self, state: ProtectionState, wanted: float, slowest: float, stiffness: float, spare: float
    ) -> tuple[float, float]:
        """Highest rate of climb, and throttle to add, for an airspeed that has priority."""
        v, available, measured = state.v, state.available, state.measured
        # while it has the airspeed demanded, throttle is left for a climb
        kept = (v / wanted - self.CLIMB_YIELDS_BELOW) / (1.0 - self.CLIMB_YIELDS_BELOW)
        climb = measured + clip(kept, 0.0, 1.0) * (available - measured)
        # behind the power curve the airspeed takes throttle and descent to recover
        behind = clip((self.DESCENT_REGAINS_BELOW - state.airspeed / slowest) / 0.1, 0.0, 1.0)
        traded = available - stiffness * (self.CLIMB_TRADED_BELOW * wanted - v)
        most = min(max(traded, -behind * self.limits.descent_max), climb + spare)
        rate = state.acceleration + GRAVITY * state.climb / max(v, self.SLOWEST)
        missing = self.BOOST_ENDS_ABOVE * wanted - state.airspeed - self.AHEAD * rate
        boost = clip(behind * missing / (self.BOOST_FULL_AT * slowest), 0.0, 1.0)
        return max(most, -self.limits.descent_max), boost

    def _boost(self, state: ProtectionState, boost: float, floor: float, fastest: float) -> float:
        """Throttle to add, or to take above the highest airspeed."""
        # a sink that the pitch may not end, or not yet, takes all of the throttle
        boost = max(boost, min((floor - state.climb) / self.CLIMB_KEPT, 1.0))
        beyond = state.airspeed + self.AHEAD * state.acceleration - fastest
        return boost - clip(beyond / (self.BOOST_FULL_AT * fastest), 0.0, 1.0)

    def pitch_rate(self, vc: float, h: float) -> float:
        """Rate of the pitch reference in deg/s that the load factor allows at an airspeed."""
        return math.degrees(self.LOAD * GRAVITY) / max(true_airspeed(vc, h), self.SLOWEST)

    def bank(self, allowed: Allowed, state: ProtectionState, wanted: float, phi: float) -> float:
        """The bank demanded in deg, within its limit; after `sample`.

        The load factor of level flight is limited to what the airspeed allows, and to what the
        angle of attack leaves, to which it is proportional: the bank gives way before the pitch,
        and where less than `CLIMB_KEPT` is left, before the height.
        """
        alpha = self._ahead(state) - self.alpha_zero
        left = (self.alpha_max - self.BANK_YIELDS - self.alpha_zero) / max(alpha, 1e-6)
        load = left * state.load / math.cos(RADIANS * phi)
        if self.flies_envelope:
            load = min(load, self.LIFT / self._used(state))
        most = DEGREES * math.acos(1.0 / max(load, 1.0))
        less = most * clip(allowed.climb_max / self.CLIMB_KEPT, 0.0, 1.0)
        most = min(most, max(less, self.GENTLE))
        # a sink that ground or overspeed forbid is ended with the wings level
        excess = clip(allowed.climb_min - state.climb, 0.0, self.SINK)
        most *= 1.0 - excess / self.SINK
        return clip(wanted, -most, most)
