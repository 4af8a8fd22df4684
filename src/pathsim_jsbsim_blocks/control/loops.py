"""The loops of the holds and the autopilot, as plain classes made of the sampled PI-D law.

Every loop is a pure function of its state: `sample` takes the state and returns the next.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from .._core.units import GRAVITY
from .gains import AttitudeGains, HeadingGains, SpeedGains, YawGains
from .pid import PID, PIDState, clip

# fraction of an airspeed error beyond the band that is ignored
BEYOND = 0.8

DEGREES, RADIANS = math.degrees(1.0), math.radians(1.0)

LEAST_RATE = 1e-9  # ft/s2 per deg, avoids division by 0: a loop without gain is only very slow

# target, None for the value at engagement, and increment
Reference = tuple[float | None, float]


def wrap(angle: float) -> float:
    """The same angle in [-180, 180) deg."""
    return (angle + 180.0) % 360.0 - 180.0


class ReferenceState(NamedTuple):
    """State of a `ReferenceLoop`."""

    initial: float = 0.0  # measured value at engagement
    reference: float = 0.0
    law: PIDState = PID.START


class LoopSample(NamedTuple):
    """A sample of a `ReferenceLoop`."""

    output: float  # increment of the actuator
    reference: float
    state: ReferenceState


class ReferenceLoop:
    """Holds a measured value at a reference that moves no faster than a ramp.

    At engagement the reference starts at the measured value and the output at its present value,
    so neither jumps. Then the reference moves to its target.
    """

    START = ReferenceState()

    band: float | None = None  # error beyond which only a fraction counts

    def __init__(self, pid: PID, ramp: float, sign: float = 1.0):
        self.pid = pid
        self.ramp = ramp  # maximum rate of the reference, unit per s
        self.sign = sign  # -1 if a positive actuator command lowers the measured value

    def retune(self, gains: AttitudeGains) -> None:
        self.pid.retune(gains.Kp, gains.Ki, Kr=gains.Kr, b=gains.b)
        self.ramp = gains.ramp

    @staticmethod
    def reference(state: ReferenceState, y: float) -> float:
        """The current reference: on its ramp, or the measured value while off."""
        return state.reference if state.law.engaged else y

    @staticmethod
    def towards(state: ReferenceState, y: float, reference: Reference) -> tuple[float, bool]:
        """Target of the reference, and whether it is the value at engagement."""
        target, increment = reference
        if target is None:
            return (state.initial if state.law.engaged else y) + increment, True
        return target + increment, False

    def sample(
        self,
        state: ReferenceState,
        y: float,
        rate: float,
        target: float,  # of the reference
        keeps: bool,  # whether the target is the value at engagement, which is then remembered
        sat: float,  # actuator increment of the last period less the part applied
        off: bool,  # hold the output
        feed: float = 0.0,
        highest: float = math.inf,  # maximum of the reference, without a ramp
        fastest: float = math.inf,  # maximum rate of the reference besides the ramp, unit per s
    ) -> LoopSample:
        """Actuator increment, reference and next state, from a measured value and its rate."""
        initial, previous, law = state
        pid, push = self.pid, 0.0
        if off or not law.engaged:
            initial = reference = y
        else:
            reference = previous
            if highest < reference:
                # at full weight: with b < 1 the output would lag behind a falling limit
                reference, push = highest, highest - previous
            step = (fastest if fastest < self.ramp else self.ramp) * pid.T
            move = target - reference
            reference += step if move > step else -step if move < -step else move
            if highest < reference:
                reference = highest
            if not keeps:
                initial = y
        measured = y
        if self.band is not None:
            error = reference - y
            measured += BEYOND * (error - clip(error, -self.band, self.band))
        u, law = pid.sample(
            law, reference, measured, rate, self.sign * sat, off, 0.0, feed, previous, push
        )
        return LoopSample(self.sign * u, reference, ReferenceState(initial, reference, law))


def attitude_loop(
    T: float,
    gains: AttitudeGains,
    authority: tuple[float, float],
    sign: float = 1.0,
    carry: bool = False,
) -> ReferenceLoop:
    """Aileron from roll angle, or elevator from pitch with sign -1: positive is nose down."""
    low, high = sorted(sign * x for x in authority)
    pid = PID(T, Kp=gains.Kp, Ki=gains.Ki, Kr=gains.Kr, b=gains.b, low=low, high=high, carry=carry)
    return ReferenceLoop(pid, gains.ramp, sign)


class HeadingState(NamedTuple):
    """State of a `HeadingLoop`."""

    initial: float = 0.0  # heading at engagement
    law: PIDState = PID.START
    bank: float = 0.0  # deg, of straight flight
    psi: float = 0.0  # heading and bank, filtered
    phi: float = 0.0


class HeadingLoop:
    """Bank reference from the heading error, as in `HeadingHold`.

    Integration starts once the proportional part alone commands less than the maximum bank. With
    the true airspeed V, the bank of straight flight is estimated, for example after an engine
    failure, from the bank that the turn does not explain, in turns of less than 0.5 deg of bank:

    .. math::
        \\tau \\dot\\phi_0 = \\phi - \\phi_0
        - \\arctan \\frac{V \\dot\\psi}{g}, \\quad \\tau = 10 \\, \\mathrm{s}
    """

    START = HeadingState()

    STRAIGHT = 10.0  # s, time constant of the estimated bank of straight flight
    TURNS = 0.5  # deg of bank; in steeper turns the estimate is frozen
    RATE = 1.0  # s, filter of the turn rate

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
        """Bank reference in deg and next state; while ``idle`` the loop is reset.

        ``vt`` is in ft/s; 0 means unknown.
        """
        if idle:
            return 0.0, self.START
        initial, law, bank, slow_psi, slow_phi = state
        target, increment = reference
        if target is not None or not law.engaged:
            initial = psi
        if not law.engaged:
            bank, slow_psi, slow_phi = self.bank, psi, self.bank
        else:
            # the same filter for both, so that they have the same delay
            slow_psi += self._share * wrap(psi - slow_psi)
            slow_phi += self._share * (phi - slow_phi)
            bank = self._straight(bank, wrap(psi - slow_psi), slow_phi, vt)
        error = wrap((initial if target is None else target) + increment - psi)
        proportional = self.pid.Kp * error
        if not (law.engaged and abs(proportional) < self.pid.high):
            # restart the law with an integral of 0
            law = PID.holding(proportional + bank)
        bank_reference, law = self.pid.sample(law, error, 0.0, feed=bank)
        return bank_reference, HeadingState(initial, law, bank, slow_psi, slow_phi)

    def _straight(self, bank: float, lag: float, phi: float, vt: float) -> float:
        """The bank of straight flight; the filtered heading lags by ``lag`` deg."""
        if vt <= 0.0:
            return self.bank
        turn = DEGREES * math.atan(vt / GRAVITY * RADIANS / self.RATE * lag)
        if abs(turn) < self.TURNS:
            bank += self._learning * (phi - turn - bank)
        return bank


class LateralState(NamedTuple):
    """State of the ailerons' loops: heading to bank, and bank to aileron."""

    heading: HeadingState = HeadingLoop.START
    roll: ReferenceState = ReferenceLoop.START


class SpeedLoop:
    """Throttle from airspeed, with the rate of climb fed forward, as in `AirspeedHold`.

    The gain is lower for large errors, because gusts cause larger errors than reference steps.
    """

    START = ReferenceLoop.START

    LAG = 2.0  # s, of the commanded rate of climb

    def __init__(
        self, T: float, gains: SpeedGains, authority: tuple[float, float], carry: bool = False
    ):
        low, high = authority
        self.pid = PID(T, low=low, high=high, carry=carry)
        self.loop = ReferenceLoop(self.pid, gains.ramp)
        self._lag = -math.expm1(-T / self.LAG)
        self.retune(gains)

    def retune(self, gains: SpeedGains) -> None:
        self.pid.retune(gains.Kp, gains.Ki, Kd=gains.Kd, b=gains.b, Tf=gains.Tf)
        self.loop.ramp, self.loop.band = gains.ramp, gains.band
        self.Kc = gains.Kc

    def follow(self, climb: float, hdot_cmd: float) -> float:
        """The rate of climb to feed forward next, from the present one and the commanded one."""
        return climb + self._lag * (hdot_cmd - climb)

    def sample(
        self,
        state: ReferenceState,
        vc: float,
        hdot: float,
        target: float,
        keeps: bool,
        sat: float,
        off: bool,
        boost: float = 0.0,
        feed: float = 0.0,
    ) -> LoopSample:
        """Throttle increment, reference in kt and next state; as in `ReferenceLoop`.

        ``hdot`` is the rate of climb to feed forward: the commanded one, because rising air raises
        the measured one, but requires less throttle. ``boost`` is added to the throttle and
        integrated as an error would be, because it removes the error that the integral needs; not
        at the aircraft's limit. ``feed`` is added without being integrated.
        """
        excess = sat - clip(sat, min(boost, 0.0), max(boost, 0.0))
        u, reference, state = self.loop.sample(
            state, vc, 0.0, target, keeps, excess, off, self.Kc * hdot + feed
        )
        if boost and not off:
            pid, law = self.pid, state.law
            command = clip(u + boost, pid.low, pid.high)
            integral = pid.unwind * (command - u) if sat == 0.0 else 0.0
            law = law._replace(integral=law.integral + integral, u=command)
            u, state = command, state._replace(law=law)
        return LoopSample(u, reference, state)


class YawState(NamedTuple):
    """State of a `YawLoop`."""

    engaged: bool = False
    slow: float = 0.0  # low-passed yaw rate
    u: float = 0.0
    integral: float = 0.0


class YawLoop:
    """Rudder from washed-out yaw rate, sideslip and roll, as in `YawDamper`.

    At engagement the output continues from its present value; while off it decays with tau. The
    integral removes a steady sideslip, after an engine failure for example, and releases that
    rudder when the asymmetry ends. If the sideslip is not connected (0), the integral decays.
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
        beta: float | None,
        p: float,
        phi: float,
    ) -> tuple[float, YawState]:
        """Rudder increment and next state, from rates in deg/s and angles in deg.

        Without the sideslip, ``beta`` None, the integral decays.
        """
        gains = self.gains
        engaged, slow, u, integral = state
        sideslip = 0.0 if beta is None else beta
        if off:
            u *= self._fade
            return u, YawState(u=u)
        turn = gains.Kroll * p + gains.Kbank * DEGREES * math.sin(RADIANS * phi)
        if not engaged:
            slow = r - u / gains.K if gains.K else r
            integral = gains.Kp * sideslip - turn
        v = gains.K * (r - slow) - (gains.Kp * sideslip - integral) + turn
        u = clip(v, self.low, self.high)
        if gains.Ki == 0.0 or beta is None:
            integral *= self._fade
        else:
            change = -gains.Ki * self.T * beta
            # while the rudder is at its limit, the integral may only move back from it
            if change * (v - u) <= 0.0:
                integral += change
        return u, YawState(True, slow + (1.0 - self._fade) * (r - slow), u, integral)
