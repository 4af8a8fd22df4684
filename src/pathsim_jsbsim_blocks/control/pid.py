"""The sampled PI-D law, as a plain class and as a block."""

from __future__ import annotations

import math

from .._core.checks import limits, number, positive
from .._core.parameters import parameter
from .._core.tunable import TunableLaw

State = tuple[float, float, float, float, float, float]


class PID:
    """Sampled PI-D law with output limits, back-calculation, tracking and bumpless engagement.

    .. math::
        v_k &= K_p (b r_k - y_k) + I_k - K_d d_k - K_r \\omega_k + f_k + F_k, \\qquad
        u_k = \\min(\\max(v_k, u_\\mathrm{low}), u_\\mathrm{high}) \\\\
        I_{k+1} &= I_k + K_i T (r_k - y_k) + \\frac{T}{T_t} (u_k - v_k - s_k) \\\\
        d_k &= d_{k-1} + (1 - e^{-T/T_f}) \\left(\\frac{y_k - y_{k-1}}{T} - d_{k-1}\\right), \\qquad
        F_{k+1} = e^{-T/T_e} F_k

    with the reference r, the measured value y, its measured rate omega, a feed-forward f, and s,
    the last output less what the actuator applied of it. The law itself is stateless: `sample`
    takes the state, a tuple of floats, and returns the next.

    While it is off, the output holds its last value; changes of ``track`` (a pilot's command, say)
    move it. At engagement the output continues from its present value: the integral is set to the
    held output, and F initially cancels the damping terms. F then decays, because an integral that
    absorbed a transient rate would have to unwind.

    Parameters
    ----------
    T : float
        sample period in s
    Kp : float
        proportional gain
    Ki : float
        integral gain, 1/s
    Kd : float
        gain on the filtered derivative of y, s
    Kr : float
        gain on the measured rate of y, s
    b : float
        weight of the reference in the proportional part; below 1 for less overshoot at the same
        damping
    Tf : float
        time constant of the derivative's filter in s; 0 for none
    Tt : float, optional
        time constant of the back-calculation in s, at least T; default Kp / Ki, with which,
        for b = 1, the output leaves a limit as the error changes its sign (2 T where that is less)
    Te : float
        time constant in s with which the damping terms are faded in after engagement
    low : float
        lowest output
    high : float
        highest output

    References
    ----------
    Astrom, Hagglund: *Advanced PID Control*, ISA, 2006, chapters 3 and 13.
    """

    # phase (-2 from rest, -1 never sampled, 0 off, 1 engaged, 2 engaged with the proportional part
    # in the integral), integral, output, what is added to track while off and F while engaged, y, d
    START: State = (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    FROM_REST: State = (-2.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def __init__(
        self,
        T: float,
        *,
        Kp: float = 0.0,
        Ki: float = 0.0,
        Kd: float = 0.0,
        Kr: float = 0.0,
        b: float = 1.0,
        Tf: float = 0.0,
        Tt: float | None = None,
        Te: float = 0.3,
        low: float = -math.inf,
        high: float = math.inf,
    ):
        self.T = positive("T", T)
        self.Kp = number("Kp", Kp)
        self.Ki = number("Ki", Ki)
        self.Kd = number("Kd", Kd)
        self.Kr = number("Kr", Kr)
        self.b = number("b", b)
        Tf = number("Tf", Tf, low=0.0)
        if Tt is not None:
            Tt = number("Tt", Tt, low=self.T)
        elif self.Ki:
            Tt = max(self.Kp / self.Ki, 2 * self.T)
        self.low, self.high = limits(low, high)
        self._KiT = self.Ki * self.T
        self._filter = _share(self.T, Tf)
        self._fade = math.exp(-self.T / positive("Te", Te))
        # without integral action, back-calculation would leave a permanent offset
        self.unwind = self.T / Tt if Tt and self.Ki else 0.0

    def retune(
        self,
        Kp: float,
        Ki: float,
        Kd: float = 0.0,
        Kr: float = 0.0,
        b: float = 1.0,
        Tf: float = 0.0,
    ) -> None:
        """Other gains, which are not checked, and the default of Tt for them."""
        self.Kp, self.Ki, self.Kd, self.Kr, self.b = Kp, Ki, Kd, Kr, b
        self._KiT = Ki * self.T
        self._filter = _share(self.T, Tf)
        self.unwind = self.T / max(Kp / Ki, 2 * self.T) if Ki else 0.0

    def released(self, state: State, r: float) -> State:
        """The state with the proportional part in the integral, so that other gains take over."""
        phase, integral, u, offset, y, slope = state
        if phase != 1.0:
            return state
        return (2.0, integral + self.Kp * (self.b * r - y), u, offset, y, slope)

    def taken(self, state: State, r: float) -> State:
        """The inverse of `released`, with these gains."""
        phase, integral, u, offset, y, slope = state
        if phase != 2.0:
            return state
        return (1.0, integral - self.Kp * (self.b * r - y), u, offset, y, slope)

    def moved(self, state: State, change: float) -> State:
        """The state for a reference that has moved by ``change``, as if its weight b were 1."""
        phase, integral, u, offset, y, slope = state
        if phase == 1.0:
            change *= 1.0 - self.b
        return (phase, integral + self.Kp * change, u, offset, y, slope)

    @staticmethod
    def holding(u: float) -> State:
        """State of a law that is off and whose output is ``u``."""
        return (-1.0, 0.0, u, u, 0.0, 0.0)

    def sample(
        self,
        state: State,
        r: float,
        y: float,
        rate: float = 0.0,
        sat: float = 0.0,
        off: bool = False,
        track: float = 0.0,
        feed: float = 0.0,
    ) -> tuple[float, State]:
        """Output at one instant and the state after it.

        Parameters
        ----------
        state : tuple of float
            `START` (bumpless engagement from 0), `FROM_REST` (the textbook law from the first
            sample on, with an integral of 0), or the state that the last sample returned
        r, y, rate : float
            reference, measured value, measured rate
        sat : float
            last output less what the actuator applied of it; 0 while it is not saturated
        off : bool
            hold the output
        track : float
            added to the output held
        feed : float
            feed-forward, added to the output while engaged
        """
        phase, integral, u, offset, y_last, slope = state
        if phase >= 0.0:
            slope += self._filter * ((y - y_last) / self.T - slope)
        if off:
            if phase > 0.0:
                offset = u - track
            u = min(max(offset + track, self.low), self.high)
            return u, (0.0, 0.0, u, offset, y, slope)
        direct = self.Kp * (self.b * r - y) + feed
        damping = self.Kd * slope + self.Kr * rate
        if phase != 1.0:
            if phase == -2.0:
                integral, offset = 0.0, 0.0
            elif phase == 2.0:
                integral -= direct - feed
            elif self.Ki:
                integral, offset = u - direct, damping
            else:
                # without integral action, let the held offset decay
                integral, offset = 0.0, u - direct + damping
        u = v = direct + integral + (offset - damping)
        if u < self.low:
            u = self.low
        if u > self.high:
            u = self.high
        integral += self._KiT * (r - y) + self.unwind * (u - v - sat)
        return u, (1.0, integral, u, self._fade * offset, y, slope)


def _share(T: float, Tf: float) -> float:
    """Share of the way that a low-pass with the time constant Tf goes in T; 1 without one."""
    return -math.expm1(-T / Tf) if Tf else 1.0


class DiscretePID(TunableLaw):
    """Sampled PI-D controller with anti-windup and bumpless engagement.

    .. math::
        u = K_p (b r - y) + K_i \\int (r - y) \\, dt - K_d \\frac{dy}{dt} - K_r \\omega + f

    limited to [low, high], sampled at T and held between samples; the output at t_k follows from
    the inputs at t_k. While the output is limited, by the limits here or (``sat``) by the
    actuator, back-calculation unwinds the integral with the time constant Tt. See the class
    ``PID`` for the difference equation. Parameters may be changed while the diagram runs; a new T
    takes effect at the next reset.

    Parameters
    ----------
    Kp : float
        proportional gain; all gains may be negative
    Ki : float
        integral gain, 1/s
    Kd : float
        gain on the filtered derivative of y, s
    Kr : float
        gain on the measured rate, s
    b : float
        weight of the reference in the proportional part; below 1 for less overshoot
    Tf : float
        time constant of the derivative's filter in s; 0 for none
    Tt : float, optional
        time constant of the back-calculation in s, at least T; default Kp / Ki
    Te : float
        time constant in s with which the damping terms are faded in after engagement
    low : float
        lowest output
    high : float
        highest output
    T : float
        sample period in s

    Inputs
    ------
    r
        reference
    y
        measured value, in the unit of r
    rate
        measured rate of y, its unit per s
    sat
        last output less what the actuator applied of it (an ``Aircraft`` output such as
        ``elev_sat``); 0 while it is not saturated
    off
        0 engaged; otherwise the output holds its last value
    track
        while off, added to the held output: passes a manual command through
    feed
        feed-forward, added to the output while engaged

    Outputs
    -------
    u
        controller output

    Raises
    ------
    ParameterError
        if a parameter is set to something that is not a number or is out of range

    References
    ----------
    Astrom, Hagglund: *Advanced PID Control*, ISA, 2006, chapters 3 and 13.
    """

    Kp: float = parameter(1.0)
    Ki: float = parameter(0.0)
    Kd: float = parameter(0.0)
    Kr: float = parameter(0.0)
    b: float = parameter(1.0)
    Tf: float = parameter(0.0)
    Tt: float | None = parameter(None)
    Te: float = parameter(0.3)
    low: float = parameter(-1.0)
    high: float = parameter(1.0)
    T: float = parameter(1 / 120, positive)

    measured = ("y",)
    input_port_labels = {"r": 0, "y": 1, "rate": 2, "sat": 3, "off": 4, "track": 5, "feed": 6}
    output_port_labels = {"u": 0}

    def build(self) -> None:
        gains = {name: getattr(self, name) for name in self._fields if name != "T"}
        self._pid = PID(self.clock.period, **gains)

    def initial_state(self) -> State:
        return PID.FROM_REST

    def law(self, u: list[float], state: State) -> tuple[list[float], State]:
        r, y, rate, sat, off, track, feed = u[:7]
        output, state = self._pid.sample(state, r, y, rate, sat, off != 0.0, track, feed)
        return [output], state
