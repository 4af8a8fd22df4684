"""Protection from the stall: limits on pitch, climb and airspeed from the angle of attack."""

from __future__ import annotations

import math
from typing import NamedTuple

from .._core.units import GRAVITY, KNOT
from .gains import EnvelopeLimits
from .signals import acos, cos, expm1, larger, limit, select, smaller

# ISA, troposphere: 1 / sqrt(density ratio) = (1 - L h)^-2.128; tropopause at 36,089 ft
_LAPSE, _EXPONENT, _TROPOPAUSE = 6.8756e-6, -2.128, 36_089.0


def true_airspeed(vc: float, h: float) -> float:
    """True airspeed in ft/s from calibrated airspeed (kt) and altitude (ft), for limits.

    Without compressibility and for ISA: 3 % high at Mach 0.5, 10 % at 0.8.
    """
    return vc * KNOT * (1.0 - _LAPSE * smaller(h, _TROPOPAUSE)) ** _EXPONENT


class ProtectionState(NamedTuple):
    """State of a `Protection`."""

    known: bool = False  # the angle of attack and its rate
    alpha: float = 0.0
    alpha_rate: float = 0.0
    v: float = 0.0  # true airspeed, 0 while unknown
    acceleration: float = 0.0
    airspeed: float = 0.0  # v without gusts
    available: float = 0.0  # rate of climb at full throttle
    measured: float = 0.0  # and at the present one


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

    START = ProtectionState()

    LEAD = 0.4  # s, of the angle of attack
    RATE = 0.15  # s, filter of its rate
    ACCELERATION = 2.0  # s, filter of the acceleration
    ADAPT = 3.0  # s, towards the climb measured at full throttle
    DECAY = 0.1  # 1/s, with which the airspeed may approach its lowest value
    LIFT = 1.1  # load factor at the lowest airspeed
    LOAD = 0.8  # g, of a change of the pitch reference
    SLOWEST = 50.0  # ft/s, true airspeed
    BANK_YIELDS = 1.0  # deg below the largest angle of attack, before the pitch does

    # of the airspeed demanded
    BOOST_ENDS_ABOVE = 0.985
    CLIMB_YIELDS_BELOW = 0.97  # from 1 on, from the climb at full throttle to that measured
    CLIMB_TRADED_BELOW = 0.95  # the airspeed is regained at the climb's expense

    # of the lowest airspeed
    DESCENT_REGAINS_BELOW = 1.15  # behind the power curve, a descent may regain the one demanded
    DESCENT_FORCED_BELOW = 0.96
    BOOST_FULL_AT = 0.1  # so far below the one demanded

    def __init__(self, T: float, alpha_max: float | None, envelope: EnvelopeLimits | None):
        self.T = T
        self._own = alpha_max is not None
        self.alpha_max = 0.0 if alpha_max is None else alpha_max
        self.flies_envelope = envelope is not None
        if envelope:
            self.retune(**vars(envelope))
        self._alpha_filter = -expm1(-T / self.RATE)
        self._speed_filter = -expm1(-T / self.ACCELERATION)
        self._adapt = -expm1(-T / self.ADAPT)

    def retune(self, alpha_max: float, vc_min: float, climb_max: float, descent_max: float) -> None:
        if not self._own:
            self.alpha_max = alpha_max
        self.vc_min, self.climb_max, self.descent_max = vc_min, climb_max, descent_max

    def sample(
        self,
        state: ProtectionState,
        theta: float,
        alpha: float,
        h: float,
        hdot: float,
        vc: float,
        full_throttle: bool,
        vc_cmd: float | None = None,
        hold_pitch: bool = False,
    ) -> tuple[float, float, float, ProtectionState]:
        """Highest pitch reference (deg) and rate of climb (ft/s), added throttle, next state.

        ``full_throttle`` says whether the excess measured is all there is; ``vc_cmd`` is the
        airspeed that has priority over a climb, None for none; ``hold_pitch`` limits the pitch
        reference to the path angle of that rate of climb too. At a ``vc`` of 0, without a wire,
        only the angle of attack counts.
        """
        known, alpha_last, alpha_rate, v_last, acceleration, airspeed, available, measured = state
        v = true_airspeed(vc, h)
        alpha_rate += select(
            known, self._alpha_filter * ((alpha - alpha_last) / self.T - alpha_rate), 0.0
        )
        moving = v_last != 0.0
        acceleration += select(
            moving, self._speed_filter * ((v - v_last) / self.T - acceleration), 0.0
        )
        airspeed = select(moving, airspeed + self._speed_filter * (v - airspeed), v)
        theta_max = theta + self.alpha_max - alpha - self.LEAD * alpha_rate
        most, boost = math.inf, 0.0
        if self.flies_envelope:
            # a gust changes the airspeed faster than thrust and drag can
            excess = hdot + v * acceleration / GRAVITY
            excess = limit(excess, -self.descent_max, self.climb_max)
            available = select(moving, available, self.climb_max)
            measured = select(moving, measured, excess)
            measured += self._adapt * (excess - measured)
            available += self._adapt * (select(full_throttle, excess, self.climb_max) - available)
            slowest = true_airspeed(self.vc_min, h)
            stiffness = self.DECAY * v / GRAVITY
            spare = stiffness * (v - self.DESCENT_FORCED_BELOW * slowest)
            if vc_cmd is None:
                most = measured + spare
            else:
                wanted = larger(true_airspeed(vc_cmd, h), 1.0)
                # while it has the airspeed demanded, throttle is left for a climb
                kept = (v / wanted - self.CLIMB_YIELDS_BELOW) / (1.0 - self.CLIMB_YIELDS_BELOW)
                climb = measured + limit(kept, 0.0, 1.0) * (available - measured)
                # behind the power curve the airspeed takes throttle and descent to recover
                behind = (self.DESCENT_REGAINS_BELOW - airspeed / slowest) / 0.1
                behind = limit(behind, 0.0, 1.0)
                traded = available - stiffness * (self.CLIMB_TRADED_BELOW * wanted - v)
                most = smaller(larger(traded, -behind * self.descent_max), climb + spare)
                missing = self.BOOST_ENDS_ABOVE * wanted - airspeed
                boost = limit(behind * missing / (self.BOOST_FULL_AT * slowest), 0.0, 1.0)
            # without the airspeed none of it is known
            most = select(vc > 0.0, larger(most, -self.descent_max), math.inf)
            boost = select(vc > 0.0, boost, 0.0)
            steepest = larger(measured + spare, -self.descent_max) / larger(v, self.SLOWEST)
            lower = smaller(theta_max, alpha + math.degrees(1.0) * smaller(steepest, 1.0))
            theta_max = select(hold_pitch, select(vc > 0.0, lower, theta_max), theta_max)
        state = ProtectionState(
            True, alpha, alpha_rate, v, acceleration, airspeed, available, measured
        )
        return theta_max, most, boost, state

    def fastest(self, vc: float, h: float) -> float:
        """Rate of the pitch reference in deg/s that the load factor allows at an airspeed."""
        return math.degrees(self.LOAD * GRAVITY) / larger(true_airspeed(vc, h), self.SLOWEST)

    @staticmethod
    def share_of_climb(vc: float, vc_cmd: float) -> float:
        """1: the rate of climb from `sample` takes the airspeed into account."""
        return 1.0

    def airspeed(self, wanted: float) -> float:
        """The airspeed demanded, at least the lowest, kt."""
        return larger(wanted, self.vc_min) if self.flies_envelope else wanted

    def bank(self, state: ProtectionState, wanted: float, phi: float, h: float) -> float:
        """The bank demanded in deg, within its limit; after `sample`.

        The load factor of level flight is limited to what the airspeed allows, and to what the
        angle of attack leaves, to which it is proportional: the bank gives way before the pitch.
        """
        alpha = larger(state.alpha + self.LEAD * state.alpha_rate, 1e-6)
        load = (self.alpha_max - self.BANK_YIELDS) / alpha / cos(math.radians(1.0) * phi)
        if self.flies_envelope:
            share = state.airspeed / true_airspeed(self.vc_min, h)
            load = smaller(load, self.LIFT * share * share)
        most = math.degrees(1.0) * acos(1.0 / larger(load, 1.0))
        return limit(wanted, -most, most)


class Unprotected:
    """Stands in for a `Protection` without limits or angle of attack; it limits nothing."""

    @staticmethod
    def sample(
        state: ProtectionState, *signals: float, **more: bool
    ) -> tuple[None, None, None, ProtectionState]:
        return None, None, None, state

    @staticmethod
    def fastest(vc: float, h: float) -> None:
        return None

    @staticmethod
    def share_of_climb(vc: float, vc_cmd: float) -> float:
        """1 down to 90 % of the airspeed demanded, 0 (level) at 80 %, -1 (descent) at 70 %."""
        share = limit((vc / select(vc_cmd > 0.0, vc_cmd, 1.0) - 0.8) / 0.1, -1.0, 1.0)
        return select(vc_cmd > 0.0, share, 1.0)

    @staticmethod
    def airspeed(wanted: float) -> float:
        return wanted

    @staticmethod
    def bank(state: ProtectionState, wanted: float, phi: float, h: float) -> float:
        return wanted


UNPROTECTED = Unprotected()
