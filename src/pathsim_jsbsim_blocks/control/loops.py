"""The loops of the holds and the autopilot, as plain classes made of the sampled PI-D law.

Every loop is a pure function of its state, a tuple of floats and tuples, and returns the next one.
"""

from __future__ import annotations

import math
from typing import Any

from .._core.checks import number, positive
from ..errors import ParameterError
from .gains import AltitudeGains, AttitudeGains, HeadingGains, SpeedGains, YawGains
from .pid import PID

State = tuple

# of an airspeed error beyond its band, the share that does not count
BEYOND = 0.8


class ReferenceLoop:
    """Holds a measured value at a reference that moves no faster than a ramp.

    At engagement the reference starts at the measured value and the output at its present value,
    so neither jumps. Then the reference moves to its target.

    Parameters
    ----------
    pid : PID
        law from the reference and the measured value to the output
    ramp : float
        largest rate of the reference, unit per s
    sign : float
        -1 where a positive actuator command lowers the measured value
    """

    START: State = (0.0, 0.0, PID.START)  # value found at engagement, reference, law

    def __init__(self, pid: PID, ramp: float, sign: float = 1.0):
        self.pid = pid
        self.sign = sign
        self.limit_rate(ramp)

    def limit_rate(self, ramp: float) -> None:
        self.ramp = ramp
        self._step = ramp * self.pid.T

    @staticmethod
    def reference(state: State, y: float) -> float:
        """Where the reference is: on its ramp, or at the measured value while off."""
        return state[1] if state[2][0] > 0.0 else y

    @staticmethod
    def destination(state: State, y: float, target: float | None, increment: float) -> float:
        """Where the reference is to move: the target, or the value found at engagement."""
        if target is None:
            target = state[0] if state[2][0] > 0.0 else y
        return target + increment

    def sample(
        self,
        state: State,
        y: float,
        rate: float,
        target: float | None,
        increment: float,
        sat: float,
        off: bool,
        feed: float = 0.0,
    ) -> tuple[float, float, State]:
        """Actuator increment, reference and next state.

        Parameters
        ----------
        y, rate : float
            measured value and its rate
        target : float, optional
            reference; None for the value found at engagement
        increment : float
            added to the reference
        sat : float
            actuator increment of the last period less what was applied
        off : bool
            hold the output
        """
        found, reference, law = state
        if law[0] <= 0.0 or off:
            found = reference = y
        else:
            if target is not None:
                found = y
            step, most = (found if target is None else target) + increment - reference, self._step
            if step < -most:
                step = -most
            if step > most:
                step = most
            reference += step
        u, law = self.pid.sample(law, reference, y, rate, self.sign * sat, off, 0.0, feed)
        return self.sign * u, reference, (found, reference, law)


class ScheduledLoop(ReferenceLoop):
    """A `ReferenceLoop` whose gains may change at every sample without moving the output."""

    def retune(self, Kp: float, Ki: float, Kr: float, b: float, ramp: float) -> None:
        self.pid.retune(Kp, Ki, Kr=Kr, b=b)
        self.limit_rate(ramp)

    def retune_speed(
        self, Kp: float, Ki: float, Kd: float, Tf: float, b: float, ramp: float
    ) -> None:
        self.pid.retune(Kp, Ki, Kd=Kd, b=b, Tf=Tf)
        self.limit_rate(ramp)

    def sample(self, state: State, *signals: Any) -> tuple[float, float, State]:
        found, reference, law = state
        u, reference, (found, _, law) = super().sample(
            (found, reference, self.pid.taken(law, reference)), *signals
        )
        return u, reference, (found, reference, self.pid.released(law, reference))


class HeadingLoop:
    """Bank reference from the heading error, turning through the smaller angle.

    .. math::
        \\phi_\\mathrm{cmd} = \\phi_0 + K_p \\, e + K_i \\int e \\, dt, \\quad
        e = \\mathrm{wrap}(\\psi_\\mathrm{ref} - \\psi), \\quad
        |\\phi_\\mathrm{cmd}| \\le \\phi_\\mathrm{max}

    Integration starts once the proportional part alone demands less than the largest bank.
    """

    START: State = (0.0, PID.START)  # heading found at engagement, law

    def __init__(self, T: float, gains: HeadingGains, bank_max: float):
        bank_max = positive("bank_max", bank_max)
        self.pid = PID(T, Kp=gains.Kp, Ki=gains.Ki, low=-bank_max, high=bank_max)
        self.bank = gains.bank

    def retune(self, Kp: float, Ki: float, bank: float) -> None:
        self.pid.retune(Kp, Ki)
        self.bank = bank

    def sample(
        self, state: State, psi: float, target: float | None, increment: float
    ) -> tuple[float, State]:
        """Bank reference in deg and next state; ``target`` None is the heading found."""
        found, law = state
        engaged = law[0] > 0.0
        if target is not None or not engaged:
            found = psi
        error = wrap((found if target is None else target) + increment - psi)
        proportional = self.pid.Kp * error
        if not engaged or abs(proportional) >= self.pid.high:
            law = PID.holding(proportional + self.bank)  # an integral of 0
        phi, law = self.pid.sample(law, error, 0.0, feed=self.bank)
        return phi, (found, law)


class AltitudeLoop:
    """Pitch reference from the altitude error over the rate of climb.

    .. math::
        \\dot h_\\mathrm{cmd} = K_h (h_\\mathrm{ref} - h), \\quad
        |\\dot h_\\mathrm{cmd}| \\le \\dot h_\\mathrm{max} \\\\
        \\theta_\\mathrm{cmd} = K_p (\\dot h_\\mathrm{cmd} - \\dot h)
        + K_i \\int (\\dot h_\\mathrm{cmd} - \\dot h) \\, dt, \\quad
        \\theta_\\mathrm{min} \\le \\theta_\\mathrm{cmd} \\le \\theta_\\mathrm{max}
    """

    START: State = (0.0, PID.START)  # altitude found at engagement, law

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
        self.hdot_max = gains.hdot_max if hdot_max is None else positive("hdot_max", hdot_max)
        theta_min = number("theta_min", theta_min)
        theta_max = gains.theta_max if theta_max is None else number("theta_max", theta_max)
        if theta_min > theta_max:
            whose = "" if self._own_theta_max else " of the gains"
            raise ParameterError(
                f"theta_min, {theta_min:g} deg, must not be above theta_max{whose}, "
                f"{theta_max:g} deg",
                parameter="theta_min",
                value=theta_min,
            )
        self.pid = PID(T, Kp=gains.Kp, Ki=gains.Ki, low=theta_min, high=theta_max)

    def retune(self, Kh: float, Kp: float, Ki: float, hdot_max: float, theta_max: float) -> None:
        self.Kh = Kh
        self.pid.retune(Kp, Ki)
        if not self._own_hdot_max:
            self.hdot_max = hdot_max
        if not self._own_theta_max:
            self.pid.high = theta_max

    def climb_rate(self, error: float, climb: float = 1.0) -> float:
        """Rate of climb demanded in ft/s for an altitude error in ft; ``climb`` as in `sample`."""
        return min(max(self.Kh * error, -self.hdot_max), climb * self.hdot_max)

    def sample(
        self,
        state: State,
        h: float,
        hdot: float,
        target: float | None,
        increment: float,
        theta: float,
        climb: float = 1.0,
        most: float = math.inf,
        cut: float = 0.0,
    ) -> tuple[float, float, State]:
        """Pitch reference in deg, rate of climb demanded in ft/s, and next state.

        ``target`` None is the altitude found at engagement; ``theta`` is the pitch reference from
        which the loop continues at engagement; ``climb`` is the share of ``hdot_max`` that is
        allowed upwards, negative to demand a descent; ``most`` is the highest rate of climb, ft/s;
        ``cut`` is what was cut off the last pitch reference.
        """
        found, law = state
        engaged = law[0] > 0.0
        if target is not None or not engaged:
            found = h
        if not engaged:
            law = PID.holding(theta)
        error = (found if target is None else target) + increment - h
        hdot_cmd = self.climb_rate(error, climb)
        if hdot_cmd > most:
            hdot_cmd = most
        theta_cmd, law = self.pid.sample(law, hdot_cmd, hdot, 0.0, cut)
        return theta_cmd, hdot_cmd, (found, law)


class _AirspeedPID(PID):
    """The law with less gain for large errors: gusts are large, the error after a step is small."""

    band: float

    def sample(self, state: Any, r: float, y: float, *signals: Any) -> tuple[float, Any]:
        error, band = r - y, self.band
        if error < -band:
            y += BEYOND * (error + band)
        if error > band:
            y += BEYOND * (error - band)
        return super().sample(state, r, y, *signals)


class SpeedLoop:
    """Throttle from airspeed, with the rate of climb fed forward.

    .. math::
        \\delta_t = K_p (b V_\\mathrm{cmd} - V') + K_i \\int (V_\\mathrm{cmd} - V') \\, dt
        - K_d \\dot V' + K_c \\dot h

    V' is the airspeed within the gains' band about the reference. Beyond, each knot of error
    counts as 0.2 kt, so that gusts do not move the throttle from stop to stop.
    """

    START: State = ReferenceLoop.START

    def __init__(
        self,
        T: float,
        gains: SpeedGains,
        authority: tuple[float, float],
        kind: type[ReferenceLoop] = ReferenceLoop,
    ):
        low, high = authority
        self.Kc = gains.Kc
        self.pid = _AirspeedPID(
            T, Kp=gains.Kp, Ki=gains.Ki, Kd=gains.Kd, Tf=gains.Tf, b=gains.b, low=low, high=high
        )
        self.pid.band = gains.band
        self.loop = kind(self.pid, gains.ramp)

    def retune(self, *gains: float) -> None:
        *others, self.Kc, self.pid.band = gains
        self.loop.retune_speed(*others)  # type: ignore[attr-defined]

    def sample(
        self,
        state: State,
        vc: float,
        hdot: float,
        target: float | None,
        increment: float,
        sat: float,
        off: bool,
        boost: float = 0.0,
    ) -> tuple[float, float, State]:
        """Throttle increment, reference in kt and next state; as in `ReferenceLoop`.

        ``boost`` is added to the throttle. The integral takes it up as it does an error, or the
        boost would leave it no error to correct; at the aircraft's limit it stays.
        """
        rest = sat - min(max(sat, 0.0), boost)
        u, reference, state = self.loop.sample(
            state, vc, 0.0, target, increment, rest, off, self.Kc * hdot
        )
        if boost and not off:
            found, reference, (phase, integral, before, *others) = state
            u = min(u + boost, self.pid.high)
            if not sat:
                integral += self.pid.unwind * (u - before)
            state = (found, reference, (phase, integral, u, *others))
        return u, reference, state


class YawLoop:
    """Rudder from washed-out yaw rate, so steady turns are not opposed, sideslip and roll.

    .. math::
        \\delta_r = K \\, \\frac{\\tau s}{1 + \\tau s} \\, r
        - K_p \\beta - K_i \\int \\beta \\, dt
        + K_\\mathrm{roll} \\, p + K_\\mathrm{bank} \\frac{180}{\\pi} \\sin \\phi

    At engagement the output continues from its present value; while off it decays with tau.
    """

    START: State = (0.0, 0.0, 0.0, 0.0)  # engaged, low-passed yaw rate, output, integral

    def __init__(self, T: float, gains: YawGains, authority: tuple[float, float]):
        self.T = T
        self.low, self.high = authority
        self.retune(gains.K, gains.tau, gains.Kp, gains.Ki, gains.Kroll, gains.Kbank)

    def retune(
        self, K: float, tau: float, Kp: float, Ki: float, Kroll: float, Kbank: float
    ) -> None:
        self.K, self.Kp, self.Ki, self.Kroll, self.Kbank = K, Kp, Ki, Kroll, Kbank
        self._fade = math.exp(-self.T / tau)

    def sample(
        self,
        state: State,
        r: float,
        off: bool,
        beta: float = 0.0,
        p: float = 0.0,
        phi: float = 0.0,
    ) -> tuple[float, State]:
        """Rudder increment and next state, from rates in deg/s and angles in deg."""
        engaged, slow, u, integral = state
        if off:
            u *= self._fade
            return u, (0.0, 0.0, u, 0.0)
        turn = 0.0
        if self.Kroll or self.Kbank:
            turn = self.Kroll * p + self.Kbank * math.degrees(math.sin(math.radians(phi)))
        if not engaged:
            slow = r - u / self.K if self.K else r
            integral = self.Kp * beta - turn
        v = self.K * (r - slow) - (self.Kp * beta - integral) + turn
        u = min(max(v, self.low), self.high)
        if self.Ki:
            # where the rudder is at its limit the integral may only come back from it
            change = -self.Ki * self.T * beta
            if change * (v - u) <= 0.0:
                integral += change
        else:
            integral *= self._fade
        return u, (1.0, slow + (1.0 - self._fade) * (r - slow), u, integral)


def wrap(angle: float) -> float:
    """The same angle in [-180, 180) deg."""
    return (angle + 180.0) % 360.0 - 180.0


def pitch_loop(
    T: float,
    gains: AttitudeGains,
    authority: tuple[float, float],
    kind: type[ReferenceLoop] = ReferenceLoop,
) -> ReferenceLoop:
    """Elevator from pitch angle; positive elevator is nose down, so the law's sign is reversed."""
    low, high = authority
    pid = PID(T, Kp=gains.Kp, Ki=gains.Ki, Kr=gains.Kr, b=gains.b, low=-high, high=-low)
    return kind(pid, gains.ramp, sign=-1.0)


def roll_loop(
    T: float,
    gains: AttitudeGains,
    authority: tuple[float, float],
    kind: type[ReferenceLoop] = ReferenceLoop,
) -> ReferenceLoop:
    """Aileron from roll angle."""
    low, high = authority
    pid = PID(T, Kp=gains.Kp, Ki=gains.Ki, Kr=gains.Kr, b=gains.b, low=low, high=high)
    return kind(pid, gains.ramp)
