"""The loops of the holds and the autopilot, as plain classes made of the sampled PI-D law.

Every loop is a pure function of its state: `sample` takes the state and returns the next.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from .._core.units import GRAVITY
from .gains import AttitudeGains, HeadingGains, SpeedGains, YawGains
from .pid import PID, PIDState, clip

# of an airspeed error beyond its band, the share that does not count
BEYOND = 0.8

DEGREES, RADIANS = math.degrees(1.0), math.radians(1.0)

LEAST_RATE = 1e-9  # ft/s2 per deg, so that a loop without a gain is only very slow

# a target, None for the value found at engagement, and what is added to it
Reference = tuple[float | None, float]


def wrap(angle: float) -> float:
    """The same angle in [-180, 180) deg."""
    return (angle + 180.0) % 360.0 - 180.0


class ReferenceState(NamedTuple):
    """State of a `ReferenceLoop`."""

    found: float = 0.0  # measured value at engagement
    reference: float = 0.0
    law: PIDState = PID.START


class ReferenceLoop:
    """Holds a measured value at a reference that moves no faster than a ramp.

    At engagement the reference starts at the measured value and the output at its present value,
    so neither jumps. Then the reference moves to where it is wanted.
    """

    START = ReferenceState()

    band: float | None = None  # error beyond which only a part of it counts

    def __init__(self, pid: PID, ramp: float, sign: float = 1.0):
        self.pid = pid
        self.ramp = ramp  # largest rate of the reference, unit per s
        self.sign = sign  # -1 where a positive actuator command lowers the measured value

    def retune(self, gains: AttitudeGains) -> None:
        self.pid.retune(gains.Kp, gains.Ki, Kr=gains.Kr, b=gains.b)
        self.ramp = gains.ramp

    @staticmethod
    def reference(state: ReferenceState, y: float) -> float:
        """Where the reference is: on its ramp, or at the measured value while off."""
        return state.reference if state.law.engaged else y

    @staticmethod
    def towards(state: ReferenceState, y: float, reference: Reference) -> tuple[float, bool]:
        """Where the reference is to move, and whether that is the value found at engagement."""
        target, increment = reference
        if target is None:
            return (state.found if state.law.engaged else y) + increment, True
        return target + increment, False

    def sample(
        self,
        state: ReferenceState,
        y: float,
        rate: float,
        wanted: float,  # where the reference is to move
        keeps: bool,  # the value found at engagement is kept, because the reference is there
        sat: float,  # actuator increment of the last period less what was applied
        off: bool,  # hold the output
        feed: float = 0.0,
        highest: float = math.inf,  # the reference gives way to this limit at once
        fastest: float = math.inf,  # rate of the reference beside the ramp, unit per s
    ) -> tuple[float, float, ReferenceState]:
        """Actuator increment, reference and next state, from a measured value and its rate."""
        found, before, law = state
        pid, push = self.pid, 0.0
        if off or not law.engaged:
            found = reference = y
        else:
            reference = before
            if highest < reference:
                # at full weight: with a b below 1 the output would lag behind a limit that falls
                reference, push = highest, highest - before
            step = (fastest if fastest < self.ramp else self.ramp) * pid.T
            move = wanted - reference
            reference += step if move > step else -step if move < -step else move
            if highest < reference:
                reference = highest
            if not keeps:
                found = y
        seen = y
        if self.band is not None:
            error = reference - y
            seen += BEYOND * (error - clip(error, -self.band, self.band))
        u, law = pid.sample(
            law, reference, seen, rate, self.sign * sat, off, 0.0, feed, before, push
        )
        return self.sign * u, reference, ReferenceState(found, reference, law)


def attitude_loop(
    T: float,
    gains: AttitudeGains,
    authority: tuple[float, float],
    sign: float = 1.0,
    carry: bool = False,
) -> ReferenceLoop:
    """Aileron from roll angle; elevator from pitch, with a sign of -1: positive is nose down."""
    low, high = sorted(sign * x for x in authority)
    pid = PID(T, Kp=gains.Kp, Ki=gains.Ki, Kr=gains.Kr, b=gains.b, low=low, high=high, carry=carry)
    return ReferenceLoop(pid, gains.ramp, sign)


class HeadingState(NamedTuple):
    """State of a `HeadingLoop`."""

    found: float = 0.0  # heading at engagement
    law: PIDState = PID.START
    bank: float = 0.0  # deg, of straight flight
    psi: float = 0.0  # heading and bank, filtered
    phi: float = 0.0


class HeadingLoop:
    """Bank reference from the heading error, as in `HeadingHold`.

    Integration starts once the proportional part alone demands less than the largest bank. With
    the true airspeed V, the bank of straight flight follows what the turn does not explain, with a
    failed engine for example, in a turn of less than half a degree of bank:

    .. math::
        \\tau \\dot\\phi_0 = \\phi - \\phi_0
        - \\arctan \\frac{V \\dot\\psi}{g}, \\quad \\tau = 10 \\, \\mathrm{s}
    """

    START = HeadingState()

    STRAIGHT = 10.0  # s
    TURNS = 0.5  # deg, the bank of a turn, in which the bank of straight flight is kept
    RATE = 1.0  # s, filter of the turn's rate

    def __init__(self, T: float, gains: HeadingGains, bank_max: float):
        self.pid = PID(T, Kp=gains.Kp, Ki=gains.Ki, low=-bank_max, high=bank_max)
        self.bank = gains.bank
        self._share = -math.expm1(-T / self.RATE)
        self._learning = -math.expm1(-T / self.STRAIGHT)

    def retune(self, gains: HeadingGains) -> None:
        self.pid.retune(gains.Kp, gains.Ki)
        self.bank = gains.bank

    def lag(self, speed: float) -> float:
        """Time constant of a coordinated turn onto a heading at a speed in ft/s, s."""
        return speed / max(GRAVITY * abs(self.pid.Kp), LEAST_RATE)

    def sample(
        self,
        state: HeadingState,
        psi: float,
        reference: Reference,
        idle: bool,
        phi: float = 0.0,
        vt: float = 0.0,
    ) -> tuple[float, HeadingState]:
        """Bank reference in deg and next state; while ``idle`` the loop waits to begin.

        A ``vt`` of 0, in ft/s, is not known.
        """
        if idle:
            return 0.0, self.START
        found, law, bank, slow_psi, slow_phi = state
        target, increment = reference
        if target is not None or not law.engaged:
            found = psi
        if not law.engaged:
            bank, slow_psi, slow_phi = self.bank, psi, self.bank
        else:
            # both as late as the rate of the filtered heading
            slow_psi += self._share * wrap(psi - slow_psi)
            slow_phi += self._share * (phi - slow_phi)
            bank = self._straight(bank, wrap(psi - slow_psi), slow_phi, vt)
        error = wrap((found if target is None else target) + increment - psi)
        proportional = self.pid.Kp * error
        if not (law.engaged and abs(proportional) < self.pid.high):
            # an integral of 0
            law = PID.holding(proportional + bank)
        wanted, law = self.pid.sample(law, error, 0.0, feed=bank)
        return wanted, HeadingState(found, law, bank, slow_psi, slow_phi)

    def _straight(self, bank: float, behind: float, phi: float, vt: float) -> float:
        """The bank of straight flight; the filtered heading is ``behind`` deg late."""
        if vt <= 0.0:
            return self.bank
        turn = DEGREES * math.atan(vt / GRAVITY * RADIANS / self.RATE * behind)
        if abs(turn) < self.TURNS:
            bank += self._learning * (phi - turn - bank)
        return bank


class LateralState(NamedTuple):
    """State of the ailerons' loops: a bank for a heading, within it the roll angle."""

    heading: HeadingState = HeadingLoop.START
    roll: ReferenceState = ReferenceLoop.START


class SpeedLoop:
    """Throttle from airspeed, with the rate of climb fed forward, as in `AirspeedHold`.

    The gain is less for large errors: gusts are large, the error after a step is small.
    """

    START = ReferenceLoop.START

    def __init__(
        self, T: float, gains: SpeedGains, authority: tuple[float, float], carry: bool = False
    ):
        low, high = authority
        self.pid = PID(T, low=low, high=high, carry=carry)
        self.loop = ReferenceLoop(self.pid, gains.ramp)
        self.retune(gains)

    def retune(self, gains: SpeedGains) -> None:
        self.pid.retune(gains.Kp, gains.Ki, Kd=gains.Kd, b=gains.b, Tf=gains.Tf)
        self.loop.ramp, self.loop.band = gains.ramp, gains.band
        self.Kc = gains.Kc

    def sample(
        self,
        state: ReferenceState,
        vc: float,
        hdot: float,
        wanted: float,
        keeps: bool,
        sat: float,
        off: bool,
        boost: float = 0.0,
        feed: float = 0.0,
    ) -> tuple[float, float, ReferenceState]:
        """Throttle increment, reference in kt and next state; as in `ReferenceLoop`.

        ``boost`` is added to the throttle. The integral takes it up as it does an error, or the
        boost would leave it no error to correct; at the aircraft's limit it stays. ``feed`` is
        added too, and goes as it came.
        """
        rest = sat - clip(sat, min(boost, 0.0), max(boost, 0.0))
        u, reference, state = self.loop.sample(
            state, vc, 0.0, wanted, keeps, rest, off, self.Kc * hdot + feed
        )
        if boost and not off:
            pid, law = self.pid, state.law
            raised = clip(u + boost, pid.low, pid.high)
            taken = pid.unwind * (raised - u) if sat == 0.0 else 0.0
            law = law._replace(integral=law.integral + taken, u=raised)
            u, state = raised, state._replace(law=law)
        return u, reference, state


class YawState(NamedTuple):
    """State of a `YawLoop`."""

    engaged: bool = False
    slow: float = 0.0  # low-passed yaw rate
    u: float = 0.0
    integral: float = 0.0


class YawLoop:
    """Rudder from washed-out yaw rate, sideslip and roll, as in `YawDamper`.

    At engagement the output continues from its present value; while off it decays with tau. The
    integral takes out a steady sideslip, of a failed engine for example, and gives its rudder back
    when the asymmetry ends. Without a sideslip (0) there is nothing to integrate.
    """

    START = YawState()

    def __init__(self, T: float, gains: YawGains, authority: tuple[float, float]):
        self.T = T
        self.low, self.high = authority
        self.retune(gains)

    def retune(self, gains: YawGains) -> None:
        self.gains = gains
        self._fade = math.exp(-self.T / gains.tau)

    def sample(
        self,
        state: YawState,
        r: float,
        off: bool,
        beta: float,
        p: float,
        phi: float,
    ) -> tuple[float, YawState]:
        """Rudder increment and next state, from rates in deg/s and angles in deg."""
        gains = self.gains
        engaged, slow, u, integral = state
        if off:
            u *= self._fade
            return u, YawState(u=u)
        turn = gains.Kroll * p + gains.Kbank * DEGREES * math.sin(RADIANS * phi)
        if not engaged:
            slow = r - u / gains.K if gains.K else r
            integral = gains.Kp * beta - turn
        v = gains.K * (r - slow) - (gains.Kp * beta - integral) + turn
        u = clip(v, self.low, self.high)
        if gains.Ki == 0.0 or beta == 0.0:
            integral *= self._fade
        else:
            change = -gains.Ki * self.T * beta
            # where the rudder is at its limit the integral may only come back from it
            if change * (v - u) <= 0.0:
                integral += change
        return u, YawState(True, slow + (1.0 - self._fade) * (r - slow), u, integral)
