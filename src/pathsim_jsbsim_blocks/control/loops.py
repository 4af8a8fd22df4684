"""The loops of the holds and the autopilot, as plain classes made of the sampled PI-D law.

Every loop is a pure function of its state, and is written in the operations of `signals`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from .._core.checks import refuse
from .._core.units import GRAVITY
from .gains import AltitudeGains, AttitudeGains, HeadingGains, SpeedGains, YawGains
from .pid import PID, PIDState
from .signals import atan, exp, expm1, larger, limit, select, sin, smaller, wrap

# of an airspeed error beyond its band, the share that does not count
BEYOND = 0.8

_LEAST_RATE = 1e-9  # ft/s2 per deg, so that a loop without a gain is only very slow


class Reference(NamedTuple):
    """A target, None for the value found at engagement, and what is added to it."""

    target: float | None = None
    increment: float = 0.0


class Limits(NamedTuple):
    """What a `Protection` allows; None for what it does not limit."""

    theta_max: float | None = None  # deg
    theta_min: float | None = None
    climb_max: float | None = None  # ft/s
    climb_min: float | None = None
    boost: float | None = None  # throttle to add, or to take where negative


UNLIMITED = Limits()


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

    def __init__(self, pid: PID, ramp: float, sign: float = 1.0, carry: bool = False):
        self.pid = pid
        self.ramp = ramp  # largest rate of the reference, unit per s
        self.sign = sign  # -1 where a positive actuator command lowers the measured value
        self.carry = carry  # other gains, at any sample, leave the output where it is

    def retune(self, Kp: float, Ki: float, Kr: float, b: float, ramp: float) -> None:
        self.pid.retune(Kp, Ki, Kr=Kr, b=b)
        self.ramp = ramp

    @staticmethod
    def reference(state: ReferenceState, y: float) -> float:
        """Where the reference is: on its ramp, or at the measured value while off."""
        return select(state.law.engaged, state.reference, y)

    @staticmethod
    def towards(state: ReferenceState, y: float, reference: Reference) -> tuple[float, bool]:
        """Where the reference is to move, and whether that is the value found at engagement."""
        target, increment = reference
        if target is None:
            return select(state.law.engaged, state.found, y) + increment, True
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
        highest: float | None = None,  # the reference gives way to this limit at once
        fastest: float | None = None,  # rate of the reference beside the ramp, unit per s
    ) -> tuple[float, float, ReferenceState]:
        """Actuator increment, reference and next state, from a measured value and its rate."""
        found, before, law = state
        engaged = select(off, False, law.engaged)
        reference, step, push = before, self.ramp * self.pid.T, 0.0
        if highest is not None:
            # at full weight: with a b below 1 the output would lag behind a limit that falls
            reference = smaller(before, highest)
            push = select(engaged, reference - before, 0.0)
        if fastest is not None:
            step = smaller(step, fastest * self.pid.T)
        reference += limit(wanted - reference, -step, step)
        if highest is not None:
            reference = smaller(reference, highest)
        reference = select(engaged, reference, y)
        u, law = self.pid.sample(
            law,
            reference,
            y,
            rate,
            self.sign * sat,
            off,
            feed=feed,
            r_last=before,
            carry=self.carry,
            push=push,
        )
        found = select(engaged, select(keeps, found, y), y)
        return self.sign * u, reference, ReferenceState(found, reference, law)


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

    def retune(self, Kp: float, Ki: float, bank: float) -> None:
        self.pid.retune(Kp, Ki)
        self.bank = bank

    def lag(self, speed: float) -> float:
        """Time constant of a coordinated turn onto a heading at a speed in ft/s, s."""
        return speed / larger(GRAVITY * abs(self.pid.Kp), _LEAST_RATE)

    def sample(
        self,
        state: HeadingState,
        psi: float,
        reference: Reference,
        phi: float = 0.0,
        vt: float = 0.0,
    ) -> tuple[float, HeadingState]:
        """Bank reference in deg and next state; a ``vt`` of 0, in ft/s, is not known."""
        found, law, bank, slow_psi, slow_phi = state
        # both as late as the rate of the filtered heading
        share = -expm1(-self.pid.T / self.RATE)
        slow_psi = select(law.engaged, slow_psi + share * wrap(psi - slow_psi), psi)
        slow_phi = select(law.engaged, slow_phi + share * (phi - slow_phi), self.bank)
        turn = vt / GRAVITY * math.radians(1.0) / self.RATE * wrap(psi - slow_psi)
        turn = math.degrees(1.0) * atan(turn)
        learns = select(abs(turn) < self.TURNS, -expm1(-self.pid.T / self.STRAIGHT), 0.0)
        bank += learns * (slow_phi - turn - bank)
        bank = select(law.engaged & (vt > 0.0), bank, self.bank)
        target, increment = reference
        found = psi if target is not None else select(law.engaged, found, psi)
        error = wrap((found if target is None else target) + increment - psi)
        proportional = self.pid.Kp * error
        # an integral of 0
        afresh = PID.holding(proportional + bank)
        law = select(law.engaged & (abs(proportional) < self.pid.high), law, afresh)
        wanted, law = self.pid.sample(law, error, 0.0, feed=bank)
        return wanted, HeadingState(found, law, bank, slow_psi, slow_phi)


class AltitudeState(NamedTuple):
    """State of an `AltitudeLoop`."""

    found: float = 0.0  # altitude at engagement
    law: PIDState = PID.START


class AltitudeLoop:
    """Pitch reference from the altitude error over the rate of climb, as in `AltitudeHold`."""

    START = AltitudeState()

    CAPTURE = 0.1 * GRAVITY  # ft/s2, of the rate of climb

    # of descents: ft/s, share of the true airspeed, share of the sink rate at idle
    FASTEST, STEEPEST, OF_IDLE = 25.0, 0.06, 0.8

    def __init__(
        self,
        T: float,
        gains: AltitudeGains,
        hdot_max: float | None,
        theta_min: float,
        theta_max: float | None,
    ):
        self.Kh = gains.Kh
        self._own_hdot_max, self._own_theta_max = hdot_max is not None, theta_max is not None
        self.hdot_max = gains.hdot_max if hdot_max is None else hdot_max
        self.sink_max = self.hdot_max
        theta_max = gains.theta_max if theta_max is None else theta_max
        if theta_min > theta_max:
            whose = "" if self._own_theta_max else " of the gains"
            refuse(
                "theta_min",
                theta_min,
                f"theta_min, {theta_min:g} deg, must not be above theta_max{whose}, "
                f"{theta_max:g} deg",
            )
        self.pid = PID(T, Kp=gains.Kp, Ki=gains.Ki, low=theta_min, high=theta_max)

    def retune(self, Kh: float, Kp: float, Ki: float, hdot_max: float, theta_max: float) -> None:
        self.Kh = Kh
        self.pid.retune(Kp, Ki)
        if not self._own_hdot_max:
            self.hdot_max = self.sink_max = hdot_max
        if not self._own_theta_max:
            self.pid.high = theta_max

    def allow(self, theta: float) -> None:
        """A pitch angle that only a limit of one's own forbids."""
        if not self._own_theta_max:
            self.pid.high = larger(self.pid.high, theta)

    def descend(self, descent: float, vt: float) -> None:
        """Allow faster descents, from the sink rate at idle and the true airspeed, ft/s."""
        most = smaller(self.STEEPEST * vt, self.OF_IDLE * descent)
        if not self._own_hdot_max:
            self.sink_max = larger(self.hdot_max, smaller(most, self.FASTEST))

    def climb_rate(self, error: float, share: float = 1.0) -> float:
        """Rate of climb demanded in ft/s for an altitude error in ft; ``share`` as in `sample`."""
        return smaller(larger(self.Kh * error, -self.sink_max), share * self.hdot_max)

    def capture_rate(self, error: float) -> float:
        """Rate of climb in ft/s at which the capture of an altitude begins, at an error in ft.

        Far away the rate falls with a constant acceleration, then in proportion to the error.
        """
        Kh = larger(self.Kh, _LEAST_RATE)
        near, away = self.CAPTURE / Kh**2, abs(error)
        far = larger(self.CAPTURE * (2.0 * away - near), 0.0) ** 0.5
        rate = select(away < near, Kh * away, far)
        return select(error < 0.0, -rate, rate)

    def climb(
        self, law: PIDState, hdot_cmd: float, hdot: float, theta: float, cut: float = 0.0
    ) -> tuple[float, PIDState]:
        """Pitch reference for a rate of climb, and the next state of the law."""
        law = select(law.engaged, law, PID.holding(theta))
        return self.pid.sample(law, hdot_cmd, hdot, 0.0, cut)

    def sample(
        self,
        state: AltitudeState,
        h: float,
        hdot: float,
        reference: Reference,
        theta: float,
        share: float = 1.0,
        limits: Limits = UNLIMITED,
        cut: float = 0.0,
        climb: tuple[bool, float] | None = None,
    ) -> tuple[float, float, AltitudeState]:
        """Pitch reference in deg, rate of climb demanded in ft/s, and next state.

        ``theta`` is the pitch reference from which the loop continues at engagement; ``share`` is
        that of ``hdot_max`` which is allowed upwards, negative to demand a descent; ``limits`` are
        those of the rate of climb; ``cut`` is what was cut off the last pitch reference; ``climb``
        says whether a rate of climb is flown instead of the altitude, and which.
        """
        found, law = state
        target, increment = reference
        found = h if target is not None else select(law.engaged, found, h)
        error = (found if target is None else target) + increment - h
        hdot_cmd = self.climb_rate(error, share)
        if climb is not None:
            hdot_cmd = select(*climb, hdot_cmd)
        if limits.climb_max is not None:
            hdot_cmd = limit(hdot_cmd, limits.climb_min, limits.climb_max)
        theta_cmd, law = self.climb(law, hdot_cmd, hdot, theta, cut)
        return theta_cmd, hdot_cmd, AltitudeState(found, law)


class _AirspeedPID(PID):
    """The law with less gain for large errors: gusts are large, the error after a step is small."""

    band: float

    def sample(self, state: PIDState, r: float, y: float, *signals: Any, **more: Any) -> Any:
        error = r - y
        y += BEYOND * (error - limit(error, -self.band, self.band))
        return super().sample(state, r, y, *signals, **more)


class SpeedLoop:
    """Throttle from airspeed, with the rate of climb fed forward, as in `AirspeedHold`."""

    START = ReferenceLoop.START

    def __init__(
        self, T: float, gains: SpeedGains, authority: tuple[float, float], carry: bool = False
    ):
        low, high = authority
        self.Kc = gains.Kc
        self.pid = _AirspeedPID(
            T, Kp=gains.Kp, Ki=gains.Ki, Kd=gains.Kd, Tf=gains.Tf, b=gains.b, low=low, high=high
        )
        self.pid.band = gains.band
        self.loop = ReferenceLoop(self.pid, gains.ramp, carry=carry)

    def retune(
        self,
        Kp: float,
        Ki: float,
        Kd: float,
        Tf: float,
        b: float,
        ramp: float,
        Kc: float,
        band: float,
    ) -> None:
        self.pid.retune(Kp, Ki, Kd=Kd, b=b, Tf=Tf)
        self.loop.ramp, self.Kc, self.pid.band = ramp, Kc, band

    def sample(
        self,
        state: ReferenceState,
        vc: float,
        hdot: float,
        wanted: float,
        keeps: bool,
        sat: float,
        off: bool,
        boost: float | None = None,
    ) -> tuple[float, float, ReferenceState]:
        """Throttle increment, reference in kt and next state; as in `ReferenceLoop`.

        ``boost`` is added to the throttle. The integral takes it up as it does an error, or the
        boost would leave it no error to correct; at the aircraft's limit it stays.
        """
        rest = sat
        if boost is not None:
            rest -= limit(sat, smaller(boost, 0.0), larger(boost, 0.0))
        u, reference, state = self.loop.sample(
            state, vc, 0.0, wanted, keeps, rest, off, self.Kc * hdot
        )
        if boost is not None:
            raised = limit(u + select(off, 0.0, boost), self.pid.low, self.pid.high)
            taken = state.law.integral + select(sat == 0.0, self.pid.unwind * (raised - u), 0.0)
            state = state._replace(law=state.law._replace(integral=taken, u=raised))
            u = raised
        return u, reference, state


class SpeedOnPitchLoop:
    """Rate of climb from true airspeed, as in `SpeedOnPitchHold`.

    Height is exchanged for speed at the throttle as it is. At constant energy dV/dt = -g/V dh/dt,
    so that omega and zeta are those of the airspeed for any aircraft whose rate of climb follows
    its demand faster.
    """

    START = ReferenceLoop.START

    FREQUENCY = 0.15  # rad/s, below the crossover of the rate of climb
    DAMPING = 0.9

    def __init__(self, T: float, ramp: float, pitch: PID):
        # the path is at most as steep as the pitch angle may be
        self.steepest = math.radians(pitch.high), math.radians(pitch.low)
        self.loop = ReferenceLoop(PID(T), ramp, -1.0)

    def sample(
        self,
        state: ReferenceState,
        vc: float,
        per_knot: float,
        hdot: float,
        wanted: float,
        keeps: bool,
        sat: float,
        off: bool,
    ) -> tuple[float, float, ReferenceState]:
        """Rate of climb in ft/s, reference in kt and next state; as in `ReferenceLoop`.

        ``per_knot`` is the true airspeed in ft/s for each kt of calibrated airspeed.
        """
        pid, v = self.loop.pid, vc * per_knot
        gain = v * per_knot * self.FREQUENCY / GRAVITY
        pid.retune(2.0 * self.DAMPING * gain, self.FREQUENCY * gain)
        pid.low, pid.high = (-v * angle for angle in self.steepest)
        law = select(state.law.engaged, state.law, PID.holding(-hdot))
        return self.loop.sample(state._replace(law=law), vc, 0.0, wanted, keeps, sat, off)


class YawState(NamedTuple):
    """State of a `YawLoop`."""

    engaged: bool = False
    slow: float = 0.0  # low-passed yaw rate
    u: float = 0.0
    integral: float = 0.0


class YawLoop:
    """Rudder from washed-out yaw rate, sideslip and roll, as in `YawDamper`.

    At engagement the output continues from its present value; while off it decays with tau.
    """

    START = YawState()

    def __init__(self, T: float, gains: YawGains, authority: tuple[float, float]):
        self.T = T
        self.low, self.high = authority
        self.retune(gains.K, gains.tau, gains.Kp, gains.Ki, gains.Kroll, gains.Kbank)

    def retune(
        self, K: float, tau: float, Kp: float, Ki: float, Kroll: float, Kbank: float
    ) -> None:
        self.K, self.Kp, self.Ki, self.Kroll, self.Kbank = K, Kp, Ki, Kroll, Kbank
        self._fade = exp(-self.T / tau)

    def sample(
        self,
        state: YawState,
        r: float,
        off: bool,
        beta: float = 0.0,
        p: float = 0.0,
        phi: float = 0.0,
    ) -> tuple[float, YawState]:
        """Rudder increment and next state, from rates in deg/s and angles in deg."""
        engaged, slow, u, integral = state
        faded = u * self._fade
        turn = self.Kroll * p + self.Kbank * math.degrees(1.0) * sin(math.radians(1.0) * phi)
        before = select(self.K == 0.0, 0.0, u / select(self.K == 0.0, 1.0, self.K))
        slow = select(engaged, slow, r - before)
        integral = select(engaged, integral, self.Kp * beta - turn)
        v = self.K * (r - slow) - (self.Kp * beta - integral) + turn
        u = limit(v, self.low, self.high)
        # where the rudder is at its limit the integral may only come back from it
        change = -self.Ki * self.T * beta
        learnt = integral + select(change * (v - u) <= 0.0, change, 0.0)
        integral = select(self.Ki == 0.0, integral * self._fade, learnt)
        slow += (1.0 - self._fade) * (r - slow)
        on = YawState(True, slow, u, integral)
        state = select(off, YawState(u=faded), on)
        return state.u, state


def attitude_loop(
    T: float,
    gains: AttitudeGains,
    authority: tuple[float, float],
    sign: float = 1.0,
    carry: bool = False,
) -> ReferenceLoop:
    """Aileron from roll angle; elevator from pitch, with a sign of -1: positive is nose down."""
    low, high = sorted(sign * x for x in authority)
    pid = PID(T, Kp=gains.Kp, Ki=gains.Ki, Kr=gains.Kr, b=gains.b, low=low, high=high)
    return ReferenceLoop(pid, gains.ramp, sign, carry)
