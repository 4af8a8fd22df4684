"""Plain loops of a climb: pitch angle from the altitude, rate of climb from the airspeed."""

from __future__ import annotations

import math
from typing import NamedTuple

from .._core.checks import refuse
from .._core.units import GRAVITY
from ..control.airspeeds import true_airspeed
from ..control.gains import AltitudeGains
from ..control.loops import LEAST_RATE, LoopSample, Reference, ReferenceLoop, ReferenceState
from ..control.pid import PID, PIDState


class AltitudeState(NamedTuple):
    """State of an `AltitudeLoop`."""

    initial: float = 0.0  # altitude at engagement
    law: PIDState = PID.START
    cut: float = 0.0  # commanded rate of climb less the allowed one, ft/s


class AltitudeLoop:
    """Pitch reference from the altitude error over the rate of climb, as in `AltitudeHold`."""

    START = AltitudeState()

    CAPTURE = 0.1 * GRAVITY  # vertical acceleration of a capture, ft/s2

    # limits of a descent: ft/s, fraction of the true airspeed, fraction of the sink rate at idle
    FASTEST, STEEPEST, OF_IDLE = 25.0, 0.06, 0.8

    def __init__(
        self,
        T: float,
        gains: AltitudeGains,
        hdot_max: float | None,
        theta_min: float,
        theta_max: float | None,
    ):
        self._own_hdot_max, self._own_theta_max = hdot_max, theta_max
        self.pid = PID(T, low=theta_min)
        self.retune(gains)
        if theta_min > self.theta_max:
            whose = " of the gains" if theta_max is None else ""
            refuse(
                "theta_min",
                theta_min,
                f"theta_min, {theta_min:g} deg, must not be above theta_max{whose}, "
                f"{self.theta_max:g} deg",
            )

    def retune(self, gains: AltitudeGains) -> None:
        self.Kh = gains.Kh
        self.pid.retune(gains.Kp, gains.Ki)
        own_hdot_max, own_theta_max = self._own_hdot_max, self._own_theta_max
        self.hdot_max = self.sink_max = gains.hdot_max if own_hdot_max is None else own_hdot_max
        self.theta_max = self.pid.high = gains.theta_max if own_theta_max is None else own_theta_max

    def allow(self, theta: float) -> None:
        """Raise the maximum pitch angle to ``theta``, unless the user has set that maximum."""
        if self._own_theta_max is None:
            self.pid.high = max(self.theta_max, theta)

    def descend(self, descent: float, vt: float) -> None:
        """Allow faster descents, from the sink rate at idle and the true airspeed, both in ft/s."""
        if self._own_hdot_max is None:
            limit = min(self.STEEPEST * vt, self.OF_IDLE * descent, self.FASTEST)
            self.sink_max = max(self.hdot_max, limit)

    def climb_rate(self, error: float, fraction: float = 1.0) -> float:
        """Commanded rate of climb in ft/s for an altitude error in ft.

        ``fraction`` of ``hdot_max`` limits the climb; a negative one commands a descent.
        """
        return min(max(self.Kh * error, -self.sink_max), fraction * self.hdot_max)

    def capture_rate(self, error: float) -> float:
        """Rate of climb in ft/s at which the capture of an altitude begins, at an error in ft.

        For a large error the deceleration is constant, for a small one the rate is proportional.
        """
        Kh = max(self.Kh, LEAST_RATE)
        linear, distance = self.CAPTURE / Kh**2, abs(error)
        rate = Kh * distance
        if distance >= linear:
            rate = max(self.CAPTURE * (2.0 * distance - linear), 0.0) ** 0.5
        return -rate if error < 0.0 else rate

    def error(self, state: AltitudeState, h: float, reference: Reference) -> tuple[float, float]:
        """Altitude at engagement, and the altitude error, in ft."""
        target, increment = reference
        initial = state.initial if target is None and state.law.engaged else h
        return initial, (initial if target is None else target) + increment - h

    def climb(
        self, law: PIDState, hdot_cmd: float, hdot: float, theta: float, cut: float = 0.0
    ) -> tuple[float, PIDState]:
        """Pitch reference for a rate of climb, and the next state of the law.

        At engagement the loop continues from the pitch reference ``theta``; ``cut`` is the last
        pitch reference less the allowed one, for anti-windup.
        """
        if not law.engaged:
            law = PID.holding(theta)
        return self.pid.sample(law, hdot_cmd, hdot, 0.0, cut)


class SpeedOnPitchLoop:
    """Rate of climb from true airspeed: hdot_0 - V/g (2 zeta omega e + omega^2 int e dt).

    e is the airspeed error. Height is exchanged for speed at the present throttle. At constant
    energy dV/dt = -g/V dh/dt, so omega and zeta are those of the airspeed for any aircraft whose
    rate of climb follows its command faster.
    """

    START = ReferenceLoop.START

    FREQUENCY = 0.15  # rad/s, below the crossover of the rate of climb
    DAMPING = 0.9

    def __init__(self, T: float, ramp: float, theta_min: float, theta_max: float):
        # limits of the path angle, taken from those of the pitch angle
        self.steepest = math.radians(theta_max), math.radians(theta_min)
        self.loop = ReferenceLoop(PID(T), ramp, -1.0)

    def sample(
        self,
        state: ReferenceState,
        vc: float,
        h: float,
        hdot: float,
        target: float,
        keeps: bool,
        sat: float,
        off: bool,
    ) -> LoopSample:
        """Rate of climb in ft/s, reference in kt and next state; as in `ReferenceLoop`."""
        pid, per_knot = self.loop.pid, true_airspeed(1.0, h)
        v = vc * per_knot
        gain = v * per_knot * self.FREQUENCY / GRAVITY
        pid.retune(2.0 * self.DAMPING * gain, self.FREQUENCY * gain)
        up, down = self.steepest
        pid.low, pid.high = -v * up, -v * down
        if not state.law.engaged:
            state = state._replace(law=PID.holding(-hdot))
        return self.loop.sample(state, vc, 0.0, target, keeps, sat, off)
