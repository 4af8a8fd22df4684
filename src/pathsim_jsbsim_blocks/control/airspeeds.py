"""Airspeeds for limits, and the airspeed without gusts that the throttle follows."""

from __future__ import annotations

import math

from .._core.units import GRAVITY, KNOT

# ISA, troposphere: 1 / sqrt(density ratio) = (1 - L h)^-2.128, pressure ratio (1 - L h)^5.2559;
# tropopause at 36,089 ft, above it the pressure falls by 1/e in 20,806 ft
_LAPSE, _EXPONENT, _PRESSURE, _TROPOPAUSE, _SCALE = 6.8756e-6, -2.128, 5.2559, 36_089.0, 20_806.0
_SONIC = 661.479  # kt, at sea level


def true_airspeed(vc: float, h: float) -> float:
    """True airspeed in ft/s from calibrated airspeed (kt) and altitude (ft), for limits.

    Without compressibility and for ISA: 3 % high at Mach 0.5, 10 % at 0.8.
    """
    return vc * KNOT * (1.0 - _LAPSE * min(h, _TROPOPAUSE)) ** _EXPONENT


def fastest_airspeed(vmo: float, mmo: float, h: float) -> float:
    """The lower of two airspeeds in kt, one calibrated and one as a Mach number, for ISA."""
    pressure = (1.0 - _LAPSE * min(h, _TROPOPAUSE)) ** _PRESSURE
    pressure *= math.exp(-max(h - _TROPOPAUSE, 0.0) / _SCALE)
    impact = pressure * ((1.0 + 0.2 * mmo * mmo) ** 3.5 - 1.0)
    return min(vmo, _SONIC * (5.0 * ((1.0 + impact) ** (2.0 / 7.0) - 1.0)) ** 0.5)


class ComplementaryAirspeed:
    r"""Airspeed of the aircraft without gusts: measured at low, inertial at high frequencies.

    .. math::
        \dot{\hat V} &= a + \frac{V - \hat V}{\tau}, \quad \tau = 10 \, \mathrm{s} \\
        a &= g \left[(n_x \cos\alpha - n_z \sin\alpha) \cos\beta - \sin\gamma_a\right]
        \frac{V}{V_t}

    with the inertial acceleration a along the path through the air, whose angle is gamma_a, as
    calibrated airspeed. A gust changes V but not a. In level flight in steady wind the result is V;
    in a climb at 10 ft/s it is 0.15 % of V higher, because V / V_t changes with altitude. A wind
    that changes for good costs airspeed, so a loop follows it `within` limits about V. A law of
    high gain follows it without them: a gust that exceeds the limits would pass.
    """

    START = 0.0  # kt; 0 before the first sample

    SIGNALS = frozenset({"nx", "nz", "alpha", "theta", "phi", "vt"})
    TIME = 10.0  # time constant tau, s; gusts last 7 to 12 s
    ABOVE, BELOW = 4.0, 8.0  # limits about the measured airspeed, kt

    def __init__(self, T: float):
        self.T = T

    def sample(
        self,
        state: float,
        vc: float,
        nx: float,
        nz: float,
        alpha: float,
        beta: float,
        theta: float,
        phi: float,
        vt: float,
        *,
        connected: bool = False,
    ) -> tuple[float, float]:
        """Airspeed in kt, not yet `within` its limits, and next state; from kt, g, deg, and ft/s.

        If any of the `SIGNALS` is 0 and not all are ``connected``, it is the measured airspeed.
        """
        if vt == 0.0 or (not connected and 0.0 in (nx, nz, alpha, theta, phi)):
            return vc, self.START
        airspeed = state or vc
        alpha, beta, theta, phi = (math.radians(x) for x in (alpha, beta, theta, phi))
        forward, sideways, down = (
            math.cos(alpha) * math.cos(beta),
            math.sin(beta),
            math.sin(alpha) * math.cos(beta),
        )
        rise = math.sin(theta) * forward
        rise -= math.cos(theta) * (math.sin(phi) * sideways + math.cos(phi) * down)
        inertial = GRAVITY * (nx * forward - nz * down - rise) * vc / vt
        return airspeed, airspeed + self.T * (inertial + (vc - airspeed) / self.TIME)

    @classmethod
    def within(cls, airspeed: float, vc: float) -> float:
        """The airspeed within its limits about the measured one."""
        return min(max(airspeed, vc - cls.BELOW), vc + cls.ABOVE)
