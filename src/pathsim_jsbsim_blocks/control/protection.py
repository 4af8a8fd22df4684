"""Protection from the stall: limits on pitch, climb and airspeed from the angle of attack."""

from __future__ import annotations

import math
from typing import Any

from .._core.units import GRAVITY, conversion
from .gains import EnvelopeLimits
from .loops import ReferenceLoop

State = tuple

_KNOT, _ = conversion("kt", "ft/s")

# ISA, troposphere: 1 / sqrt(density ratio) = (1 - L h)^-2.128; tropopause at 36,089 ft
_LAPSE, _EXPONENT, _TROPOPAUSE = 6.8756e-6, -2.128, 36_089.0


def true_airspeed(vc: float, h: float) -> float:
    """True airspeed in ft/s from calibrated airspeed (kt) and altitude (ft), for limits.

    Without compressibility and for ISA: 3 % high at Mach 0.5, 10 % at 0.8.
    """
    return vc * _KNOT * (1.0 - _LAPSE * min(h, _TROPOPAUSE)) ** _EXPONENT


class Protection:
    """Highest pitch reference and rate of climb that keep the angle of attack and the airspeed.

    .. math::
        \\theta &\\le \\theta + \\alpha_\\mathrm{max} - \\alpha - \\tau \\dot\\alpha \\\\
        \\dot h_\\mathrm{cmd} &\\le \\hat P + \\frac{k V}{g} (V - V_\\mathrm{min}), \\qquad
        P = \\dot h + \\frac{V \\dot V}{g}

    The first makes the pitch loop hold the largest angle of attack where more pitch would exceed
    it. The second lets the airspeed fall towards the lowest one no faster than with the time
    constant 1/k, and demands a descent below it. The excess P is that at full throttle: the
    table's, until the throttle is at its stop; from then on what is measured.

    Parameters
    ----------
    T : float
        sample period in s
    alpha_max : float
        deg
    envelope : EnvelopeLimits, optional
        lowest airspeed and rate of climb at full throttle; None for the angle of attack alone
    """

    # sampled before, angle of attack and its rate, airspeed and its rate, rate of
    # climb at full throttle and at the present one
    START: State = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    LEAD = 0.4  # s, of the angle of attack
    RATE = 0.15  # s, filter of its rate
    ACCELERATION = 2.0  # s, filter of the acceleration
    ADAPT = 3.0  # s, towards the climb measured at full throttle
    DECAY = 0.1  # 1/s, with which the airspeed may approach its lowest value
    PRIORITY = 0.95  # of the airspeed demanded, below which a climb gives way
    LIFT = 1.1  # load factor at the lowest airspeed
    BANK_YIELDS = 1.0  # deg below the largest angle of attack, before the pitch does
    LOAD = 0.8  # g, of a change of the pitch reference
    SLOWEST = 50.0  # ft/s, true airspeed
    FLOOR = 0.96  # of the lowest airspeed demanded, below which the aircraft descends
    BEHIND = 1.15  # of the lowest airspeed, below which a descent may recover the one demanded
    BOOST = 0.1  # of the lowest airspeed: so far below the one demanded the throttle is full
    ENOUGH = 0.985  # of the airspeed demanded, above which no throttle is added
    KEPT = 0.97  # of the airspeed demanded, below which only the climb measured is allowed

    def __init__(self, T: float, alpha_max: float | None, envelope: EnvelopeLimits | None):
        self.T = T
        self._own = alpha_max is not None
        self.alpha_max = 0.0 if alpha_max is None else alpha_max
        self.vc_min, self.climb_max, self.descent_max = 0.0, math.inf, math.inf
        if envelope:
            self.retune(**vars(envelope))
        self._alpha_filter = -math.expm1(-T / self.RATE)
        self._speed_filter = -math.expm1(-T / self.ACCELERATION)
        self._adapt = -math.expm1(-T / self.ADAPT)

    def retune(self, alpha_max: float, vc_min: float, climb_max: float, descent_max: float) -> None:
        if not self._own:
            self.alpha_max = alpha_max
        self.vc_min, self.climb_max, self.descent_max = vc_min, climb_max, descent_max

    def sample(
        self,
        state: State,
        theta: float,
        alpha: float,
        h: float,
        hdot: float,
        vc: float,
        full_throttle: bool,
        vc_cmd: float = 0.0,
        hold_pitch: bool = False,
    ) -> tuple[float, float, float, State]:
        """Highest pitch reference (deg) and rate of climb (ft/s), added throttle, next state.

        ``full_throttle`` says whether the excess measured is all there is; ``vc_cmd`` is the
        airspeed that has priority over a climb, 0 for none; ``hold_pitch`` limits the pitch
        reference to the path angle of that rate of climb too.
        """
        known, alpha_last, alpha_rate, v_last, acceleration, airspeed, available, measured = state
        v = true_airspeed(vc, h)
        if known:
            alpha_rate += self._alpha_filter * ((alpha - alpha_last) / self.T - alpha_rate)
        if v_last:
            acceleration += self._speed_filter * ((v - v_last) / self.T - acceleration)
            airspeed += self._speed_filter * (v - airspeed)
        else:
            airspeed = v
        theta_max = theta + self.alpha_max - alpha - self.LEAD * alpha_rate
        most, boost = math.inf, 0.0
        if self.vc_min and vc > 0.0:
            slowest = true_airspeed(self.vc_min, h)
            # a gust changes the airspeed faster than thrust and drag can
            excess = hdot + v * acceleration / GRAVITY
            excess = min(max(excess, -self.descent_max), self.climb_max)
            if not v_last:
                available, measured = self.climb_max, excess
            measured += self._adapt * (excess - measured)
            available += self._adapt * ((excess if full_throttle else self.climb_max) - available)
            stiffness = self.DECAY * v / GRAVITY
            climb = measured
            if vc_cmd:
                wanted = true_airspeed(vc_cmd, h)
                # while it has the airspeed demanded, throttle is left for a climb
                kept = min(max((v / wanted - self.KEPT) / (1.0 - self.KEPT), 0.0), 1.0)
                climb += kept * (available - measured)
                # behind the power curve the airspeed takes throttle and descent to recover
                behind = min(max((self.BEHIND - airspeed / slowest) / 0.1, 0.0), 1.0)
                boost = behind * (self.ENOUGH * wanted - airspeed) / (self.BOOST * slowest)
                boost = min(max(boost, 0.0), 1.0)
                most = max(
                    available - stiffness * (self.PRIORITY * wanted - v),
                    -behind * self.descent_max,
                )
            spare = stiffness * (v - self.FLOOR * slowest)
            most = max(min(most, climb + spare), -self.descent_max)
            if hold_pitch:
                steepest = max(measured + spare, -self.descent_max) / max(v, self.SLOWEST)
                theta_max = min(theta_max, alpha + math.degrees(min(steepest, 1.0)))
        state = (1.0, alpha, alpha_rate, v, acceleration, airspeed, available, measured)
        return theta_max, most, boost, state

    def limit(
        self,
        loop: ReferenceLoop,
        pitch: State,
        theta: float,
        target: float | None,
        increment: float,
        theta_max: float,
        h: float,
        vc: float,
    ) -> tuple[State, float, float]:
        """State of the pitch loop, increment of its reference, and what was cut off.

        The reference stays below ``theta_max``, at once, and moves no faster than the load factor
        allows at the airspeed. It gives way at full weight: with a ``b`` below 1 the pitch would
        lag behind a limit that falls.
        """
        found, reference, law = pitch
        if law[0] <= 0.0:
            found = reference = theta
        elif target is not None:
            found = theta
        if reference > theta_max:
            law = loop.pid.moved(law, theta_max - reference)
            reference = theta_max
        wanted = ReferenceLoop.destination(pitch, theta, target, increment)
        v = max(true_airspeed(vc, h), self.SLOWEST)
        step = math.degrees(self.LOAD * GRAVITY / v) * self.T
        allowed = min(max(wanted, reference - step), reference + step, theta_max)
        cut = max(wanted - theta_max, 0.0)
        return (found, reference, law), increment + allowed - wanted, cut

    @staticmethod
    def share_of_climb(vc: float, vc_cmd: float) -> float:
        """1: the rate of climb from `sample` takes the airspeed into account."""
        return 1.0

    def bank(self, state: State, h: float, phi: float) -> float:
        """Largest bank in deg; after `sample`.

        Its load factor in level flight is what the airspeed allows, and what the angle of attack
        leaves, to which the load factor is proportional: the bank gives way before the pitch.
        """
        alpha = state[1] + self.LEAD * state[2]
        load = math.inf
        if alpha > 0.0:
            load = (self.alpha_max - self.BANK_YIELDS) / alpha / math.cos(math.radians(phi))
        if self.vc_min:
            load = min(load, self.LIFT * (state[5] / true_airspeed(self.vc_min, h)) ** 2)
        return math.degrees(math.acos(1.0 / load)) if load > 1.0 else 0.0


class Unprotected:
    """Stands in for a `Protection` without limits or angle of attack; it limits nothing."""

    vc_min = -math.inf

    @staticmethod
    def sample(state: State, *signals: Any) -> tuple[float, float, float, State]:
        return math.inf, math.inf, 0.0, state

    @staticmethod
    def limit(
        loop: ReferenceLoop,
        pitch: State,
        theta: float,
        target: float | None,
        increment: float,
        *others: float,
    ) -> tuple[State, float, float]:
        return pitch, increment, 0.0

    @staticmethod
    def share_of_climb(vc: float, vc_cmd: float) -> float:
        """1 down to 90 % of the airspeed demanded, 0 (level) at 80 %, -1 (descent) at 70 %."""
        if vc_cmd <= 0.0:
            return 1.0
        return min(max((vc / vc_cmd - 0.8) / 0.1, -1.0), 1.0)

    @staticmethod
    def bank(state: State, h: float, phi: float) -> float:
        return math.inf


UNPROTECTED = Unprotected()
