"""Cascade from the altitude to the elevator, common to `AltitudeHold` and the autopilot."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..control.airspeeds import true_airspeed
from ..control.loops import Reference, ReferenceLoop, ReferenceState
from .climb_loops import AltitudeLoop, AltitudeState
from .protection import NO_LIMITS, Allowed, Protection, ProtectionState


class Motion(NamedTuple):
    """Measurements of the elevator's loops, and whether their output is applied."""

    theta: float  # deg
    q: float  # deg/s
    h: float  # ft
    hdot: float  # ft/s
    vc: float  # kt
    alpha: float | None  # deg, None if not connected
    off: bool = False  # hold the elevator
    sat: float = 0.0  # elevator increment of the last period less the part applied


class VerticalState(NamedTuple):
    """State of a `Vertical`."""

    altitude: AltitudeState = AltitudeLoop.START
    pitch: ReferenceState = ReferenceLoop.START
    guard: ProtectionState = Protection.START
    cut: float = 0.0  # last pitch reference less the allowed one, deg


class ClimbState(NamedTuple):
    """State of a climb to an altitude."""

    mode: float = 0.0  # 0: no climb
    captured: bool = False
    initial: float = 0.0  # rate of climb at the start of the mode, ft/s


NO_CLIMB = ClimbState()


class Vertical:
    """Elevator for a pitch angle, or for a rate of climb or altitude, within the protection.

    At each sample `guard` comes first, then a pitch angle for an altitude or a climb, then `fly`.
    """

    START = VerticalState()

    def __init__(self, altitude: AltitudeLoop, pitch: ReferenceLoop, envelope: Protection | None):
        self.altitude, self.pitch, self.envelope = altitude, pitch, envelope
        # keys are the names of gain tables
        self.loops = {"altitude": altitude, "pitch": pitch, "envelope": envelope}

    def protection(self, alpha: float | None) -> Protection | None:
        """The protection, if the angle of attack is connected."""
        return self.envelope if alpha is not None else None

    def guard(
        self,
        state: VerticalState,
        motion: Motion,
        vc: float,  # airspeed to protect, kt; 0 for none
        **signals: Any,  # arguments of `Protection.sample`, from ``full_throttle`` on
    ) -> tuple[Allowed, ProtectionState]:
        """Limits set by the protection, and its next state."""
        if self.envelope and self.envelope.flies_envelope:
            sink = self.envelope.limits.descent_max
            self.altitude.descend(sink, true_airspeed(motion.vc, motion.h))
        if motion.alpha is None or self.envelope is None:
            return NO_LIMITS, state.guard
        # positive elevator is nose down, so these are the nose-up limits
        stop = not motion.off and (motion.sat < 0.0 or state.pitch.law.u >= self.pitch.pid.high)
        measured = motion.theta, motion.alpha, motion.h, motion.hdot, vc
        return self.envelope.sample(state.guard, *measured, stop, **signals, cut=state.altitude.cut)

    def at_rate(
        self,
        state: VerticalState,
        motion: Motion,
        bounds: Allowed,
        initial: float,
        hdot_cmd: float,
        idle: bool,
    ) -> tuple[float, float, AltitudeState]:
        """Pitch angle, allowed rate of climb and next state, from the commanded rate.

        While ``idle`` the loop is reset.
        """
        altitude, protection = self.altitude, self.protection(motion.alpha)
        theta_max = -math.inf
        if protection and protection.flies_envelope:
            # the climb is limited separately; level flight may use the maximum angle of attack
            theta_max = protection.alpha_max
        altitude.allow(theta_max)
        command, hdot_cmd = hdot_cmd, min(max(hdot_cmd, bounds.climb_min), bounds.climb_max)
        reference = self.pitch.reference(state.pitch, motion.theta)
        theta, law = altitude.climb(state.altitude.law, hdot_cmd, motion.hdot, reference, state.cut)
        if idle:
            return theta, 0.0, AltitudeLoop.START
        return theta, hdot_cmd, AltitudeState(initial, law, command - hdot_cmd)

    def for_climb(
        self,
        state: VerticalState,
        motion: Motion,
        bounds: Allowed,
        *,
        reference: Reference,
        idle: bool,
        last: ClimbState = NO_CLIMB,
        mode: float = 0.0,
        rate: Reference = (None, 0.0),
        fraction: float = 1.0,
    ) -> tuple[float, float, AltitudeState, ClimbState]:
        """Pitch angle, rate of climb and next states.

        If ``mode`` is not 0, the reference ``rate`` is flown until it leads to the capture of the
        commanded altitude, which is held from then on. Otherwise the altitude is held.
        """
        altitude, begins = self.altitude, mode != last.mode
        initial_rate = motion.hdot if begins else last.initial
        target, increment = rate
        rate_cmd = (initial_rate if target is None else target) + increment
        level = state.altitude
        if begins and not last.captured:
            level = level._replace(initial=motion.h)
        initial, error = altitude.error(level, motion.h, reference)
        hdot_cmd = altitude.climb_rate(error, fraction)
        captured = False
        if not idle and mode != 0.0:
            commanded = reference != (None, 0.0)
            capture = altitude.capture_rate(error)
            captures = commanded and error * rate_cmd > 0.0 and abs(capture) <= abs(rate_cmd)
            captured = captures or (last.captured and not begins)
            if captured:
                # the altitude law's maximum rate would brake a fast climb too early
                capture = min(max(capture, -abs(motion.hdot)), abs(motion.hdot))
                if abs(capture) > abs(hdot_cmd):
                    hdot_cmd = capture
            else:
                hdot_cmd = rate_cmd
        theta, hdot_cmd, new = self.at_rate(state, motion, bounds, initial, hdot_cmd, idle)
        return theta, hdot_cmd, new, ClimbState(0.0 if idle else mode, captured, initial_rate)

    def fly(
        self,
        state: VerticalState,
        motion: Motion,
        bounds: Allowed,
        target: float,
        keeps: bool = False,
    ) -> tuple[float, float, ReferenceState, float]:
        """Elevator, pitch reference, next state, and target less the maximum pitch reference."""
        highest, fastest = bounds.theta_max, math.inf
        if protection := self.protection(motion.alpha):
            fastest = protection.pitch_rate(motion.vc, motion.h)
        target, measured = max(target, bounds.theta_min), (motion.theta, motion.q)
        elevator, theta_cmd, pitch = self.pitch.sample(
            state.pitch, *measured, target, keeps, motion.sat, motion.off, 0.0, highest, fastest
        )
        return elevator, theta_cmd, pitch, max(target - highest, 0.0)
