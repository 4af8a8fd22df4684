"""Elevator at one sample: loops in loops, common to the climbing holds and the autopilot."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..control.airspeeds import true_airspeed
from ..control.loops import Reference, ReferenceLoop, ReferenceState
from .climb_loops import AltitudeLoop, AltitudeState
from .protection import EVERYTHING, Allowed, Protection, ProtectionState


class Motion(NamedTuple):
    """What the loops of the elevator measure, and what becomes of their output."""

    theta: float  # deg
    q: float  # deg/s
    h: float  # ft
    hdot: float  # ft/s
    vc: float  # kt
    alpha: float  # deg, 0 where it is not known
    off: bool = False  # as of `ReferenceLoop`, for the elevator
    sat: float = 0.0


class VerticalState(NamedTuple):
    """State of a `Vertical`."""

    altitude: AltitudeState = AltitudeLoop.START
    pitch: ReferenceState = ReferenceLoop.START
    guard: ProtectionState = Protection.START
    cut: float = 0.0  # deg, what the protection cut off the last pitch reference


class ClimbState(NamedTuple):
    """State of a climb to an altitude."""

    mode: float = 0.0  # 0 for none
    captured: bool = False
    found: float = 0.0  # rate of climb at the beginning, ft/s


NO_CLIMB = ClimbState()


class Vertical:
    """Elevator for a pitch angle, or for a rate of climb or altitude, within the protection.

    At each sample `guard` comes first, then a pitch angle for an altitude or a climb, then `fly`.
    """

    START = VerticalState()

    def __init__(self, altitude: AltitudeLoop, pitch: ReferenceLoop, envelope: Protection | None):
        self.altitude, self.pitch, self.envelope = altitude, pitch, envelope
        # by their names in a gain table
        self.loops = {"altitude": altitude, "pitch": pitch, "envelope": envelope}

    def protection(self, alpha: float) -> Protection | None:
        """The protection, where there is an angle of attack to protect."""
        return self.envelope if alpha != 0.0 else None

    def guard(
        self,
        state: VerticalState,
        now: Motion,
        vc: float,  # the airspeed to protect; 0 for none
        **signals: Any,  # of `Protection.sample`, from ``full_throttle`` on
    ) -> tuple[Allowed, ProtectionState]:
        """What the protection allows, and its next state."""
        if self.envelope and self.envelope.flies_envelope:
            self.altitude.descend(self.envelope.limits.descent_max, true_airspeed(now.vc, now.h))
        protection = self.protection(now.alpha)
        if not protection:
            return EVERYTHING, state.guard
        # positive elevator is nose down
        stop = not now.off and (now.sat < 0.0 or state.pitch.law.u >= self.pitch.pid.high)
        measured = now.theta, now.alpha, now.h, now.hdot, vc
        return protection.sample(state.guard, *measured, stop, **signals, cut=state.altitude.cut)

    def at_rate(
        self,
        state: VerticalState,
        now: Motion,
        allowed: Allowed,
        found: float,
        hdot_cmd: float,
        idle: bool,
    ) -> tuple[float, float, AltitudeState]:
        """Pitch angle, rate of climb as allowed and next state, from the rate demanded.

        While ``idle`` the loop waits to begin.
        """
        altitude, protection = self.altitude, self.protection(now.alpha)
        most = -math.inf
        if protection and protection.flies_envelope:
            # it limits the climb; level flight may take all of the angle of attack
            most = protection.alpha_max
        altitude.allow(most)
        asked, hdot_cmd = hdot_cmd, min(max(hdot_cmd, allowed.climb_min), allowed.climb_max)
        theta = self.pitch.reference(state.pitch, now.theta)
        wanted, law = altitude.climb(state.altitude.law, hdot_cmd, now.hdot, theta, state.cut)
        if idle:
            return wanted, 0.0, AltitudeLoop.START
        return wanted, hdot_cmd, AltitudeState(found, law, asked - hdot_cmd)

    def for_climb(
        self,
        state: VerticalState,
        now: Motion,
        allowed: Allowed,
        *,
        reference: Reference,
        idle: bool,
        before: ClimbState = NO_CLIMB,
        mode: float = 0.0,
        asked: Reference = (None, 0.0),
        share: float = 1.0,
    ) -> tuple[float, float, AltitudeState, ClimbState]:
        """Pitch angle, rate of climb and next states.

        Where ``mode`` is not 0 the rate ``asked`` is flown until it meets the altitude demanded, if
        one is; that is held from then on. Otherwise the altitude is.
        """
        altitude, changed = self.altitude, mode != before.mode
        rate = now.hdot if changed else before.found
        target, increment = asked
        rate_asked = (rate if target is None else target) + increment
        level = state.altitude
        if changed and not before.captured:
            level = level._replace(found=now.h)
        found, error = altitude.error(level, now.h, reference)
        hdot_cmd = altitude.climb_rate(error, share)
        captured = False
        if not idle and mode != 0.0:
            chosen = reference != (None, 0.0)
            swift = altitude.capture_rate(error)
            met = chosen and error * rate_asked > 0.0 and abs(swift) <= abs(rate_asked)
            captured = met or (before.captured and not changed)
            if captured:
                # faster than the altitude hold while it still is
                swift = min(max(swift, -abs(now.hdot)), abs(now.hdot))
                if abs(swift) > abs(hdot_cmd):
                    hdot_cmd = swift
            else:
                hdot_cmd = rate_asked
        wanted, hdot_cmd, after = self.at_rate(state, now, allowed, found, hdot_cmd, idle)
        return wanted, hdot_cmd, after, ClimbState(0.0 if idle else mode, captured, rate)

    def fly(
        self,
        state: VerticalState,
        now: Motion,
        allowed: Allowed,
        wanted: float,
        keeps: bool = False,
    ) -> tuple[float, float, ReferenceState, float]:
        """Elevator, pitch reference and next state for a pitch angle, and what was cut off it."""
        most, fastest = allowed.theta_max, math.inf
        if protection := self.protection(now.alpha):
            fastest = protection.pitch_rate(now.vc, now.h)
        wanted = max(wanted, allowed.theta_min)
        elevator, theta_cmd, pitch = self.pitch.sample(
            state.pitch, now.theta, now.q, wanted, keeps, now.sat, now.off, 0.0, most, fastest
        )
        return elevator, theta_cmd, pitch, max(wanted - most, 0.0)
