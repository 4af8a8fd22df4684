"""Elevator and ailerons at one sample: loops in loops, common to single holds and the autopilot.

Throttle and rudder have one loop each, `SpeedLoop` and `YawLoop`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from .loops import (
    AltitudeLoop,
    AltitudeState,
    HeadingLoop,
    HeadingState,
    Reference,
    ReferenceLoop,
    ReferenceState,
)
from .protection import UNPROTECTED, Protection, ProtectionState, Unprotected, true_airspeed
from .signals import larger, limit, select


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
    cut: float = 0.0  # ft/s, of the rate of climb asked for


@dataclass
class Vertical:
    """Elevator for a pitch angle, or for a rate of climb or altitude, within the protection."""

    START = VerticalState()

    loops: Mapping[str, Any]  # by their names in a gain table
    protected: bool  # there is an angle of attack to protect
    state: VerticalState  # before the sample
    theta: float
    q: float
    h: float
    hdot: float
    vc: float
    alpha: float
    off: bool  # as of `ReferenceLoop`, for the elevator
    sat: float

    def __post_init__(self) -> None:
        self.altitude: AltitudeLoop = self.loops["altitude"]
        self.pitch: ReferenceLoop = self.loops["pitch"]
        self.protection: Protection | Unprotected = UNPROTECTED
        envelope: Protection | None = self.loops["envelope"]
        if self.protected and envelope:
            self.protection = envelope
        if envelope and envelope.flies_envelope:
            self.altitude.descend(envelope.descent_max, true_airspeed(self.vc, self.h))

    def guard(self, vc: float, *signals: Any) -> None:
        """Let the protection find its limits."""
        sample: Callable[..., Any] = self.protection.sample
        # positive elevator is nose down
        stop = (self.sat < 0.0) | (self.state.pitch.law.u >= self.pitch.pid.high)
        stop = select(self.off, False, stop)
        self.limits, guard = sample(
            self.state.guard, self.theta, self.alpha, self.h, self.hdot, vc, stop, *signals
        )
        self.state = self.state._replace(guard=guard)

    def for_altitude(
        self,
        reference: Reference,
        idle: bool,
        share: float = 1.0,
        climb: tuple[bool, float] | None = None,
    ) -> tuple[float, float]:
        """Pitch angle and rate of climb for an altitude; while ``idle`` the loop waits to begin."""
        state, theta = self.state, self.pitch.reference(self.state.pitch, self.theta)
        if isinstance(self.protection, Protection) and self.protection.flies_envelope:
            # it limits the climb; level flight may take all of the angle of attack
            self.altitude.allow(self.protection.alpha_max)
        signals = reference, theta, share, self.limits, state.cut, climb
        wanted, hdot_cmd, altitude = self.altitude.sample(
            state.altitude, self.h, self.hdot, *signals
        )
        self.state = state._replace(altitude=select(idle, AltitudeLoop.START, altitude))
        return wanted, select(idle, 0.0, hdot_cmd)

    def for_climb(
        self,
        before: ClimbState,
        mode: float,
        asked: Reference,
        reference: Reference,
        idle: bool,
        share: float = 1.0,
        instead: tuple[bool, float] = (False, 0.0),
    ) -> tuple[float, float, ClimbState]:
        """Pitch angle and rate of climb, and the next state of the climb.

        Where ``mode`` is not 0 the rate ``asked`` is flown, or that in ``instead`` where its first
        value holds, until it meets the altitude demanded, if one is; that is held from then on.
        Otherwise the altitude is.
        """
        changed = mode != before.mode
        rate = select(changed, self.hdot, before.found)
        rate_asked = (rate if asked.target is None else asked.target) + asked.increment
        rate_asked = select(*instead, rate_asked)
        found, law = self.state.altitude
        found = select(select(before.captured, False, changed), self.h, found)
        found = select(law.engaged, found, self.h)
        self.state = self.state._replace(altitude=AltitudeState(found, law))
        target, increment = reference
        error = (found if target is None else target) + increment - self.h
        chosen = increment != 0.0 if target is None else True
        swift = self.altitude.capture_rate(error)
        met = chosen & (error * rate_asked > 0.0) & (abs(swift) <= abs(rate_asked))
        captured = select(changed, False, before.captured) | met
        off = idle | (mode == 0.0)
        captured = select(off, False, captured)
        # faster than the altitude hold while it still is
        level = self.altitude.climb_rate(error, share)
        swift = limit(swift, -abs(self.hdot), abs(self.hdot))
        level = select(abs(swift) > abs(level), swift, level)
        flown = select(captured, level, rate_asked)
        wanted, hdot_cmd = self.for_altitude(reference, idle, share, (mode != 0.0, flown))
        cut = select(off | captured, 0.0, rate_asked - hdot_cmd)
        return wanted, hdot_cmd, ClimbState(select(idle, 0.0, mode), captured, rate, cut)

    def fly(self, wanted: float, keeps: bool = False) -> tuple[float, float, VerticalState]:
        """Elevator, pitch reference and next state for a pitch angle."""
        most, least = self.limits.theta_max, self.limits.theta_min
        fastest = self.protection.pitch_rate(self.vc, self.h)
        wanted = wanted if least is None else larger(wanted, least)
        state, signals = self.state, (wanted, keeps, self.sat, self.off, 0.0, most, fastest)
        elevator, theta_cmd, pitch = self.pitch.sample(state.pitch, self.theta, self.q, *signals)
        cut = 0.0 if most is None else larger(wanted - most, 0.0)
        return elevator, theta_cmd, state._replace(pitch=pitch, cut=cut)


class LateralState(NamedTuple):
    """State of a `Lateral`."""

    heading: HeadingState = HeadingLoop.START
    roll: ReferenceState = ReferenceLoop.START


@dataclass
class Lateral:
    """Ailerons for a roll angle, or for a heading."""

    START = LateralState()

    loops: Mapping[str, Any]  # by their names in a gain table
    state: LateralState  # before the sample
    psi: float
    phi: float
    p: float
    off: bool  # as of `ReferenceLoop`, for the ailerons
    sat: float
    vt: float = 0.0  # true airspeed in ft/s, 0 where it is not known

    @property
    def roll(self) -> ReferenceLoop:
        """The loop of the roll angle."""
        loop: ReferenceLoop = self.loops["roll"]
        return loop

    def for_heading(self, reference: Reference, idle: bool) -> float:
        """Bank for a heading; while ``idle`` the loop waits to begin."""
        loop: HeadingLoop = self.loops["heading"]
        wanted, heading = loop.sample(self.state.heading, self.psi, reference, self.phi, self.vt)
        self.state = self.state._replace(heading=select(idle, HeadingLoop.START, heading))
        return wanted

    def fly(self, wanted: float, keeps: bool = False) -> tuple[float, float, LateralState]:
        """Ailerons, bank reference and next state for a bank."""
        aileron, phi_cmd, roll = self.roll.sample(
            self.state.roll, self.phi, self.p, wanted, keeps, self.sat, self.off
        )
        return aileron, phi_cmd, self.state._replace(roll=roll)
