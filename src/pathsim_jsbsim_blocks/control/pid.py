"""The sampled PI-D law, as a plain class and as a block."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import NamedTuple

from .._core.checks import check_range, number, positive
from .._core.parameters import parameter
from .._core.sampling import SampledLaw


def clip(x: float, low: float, high: float) -> float:
    """``x`` within a range."""
    return high if x > high else low if x < low else x


class PIDState(NamedTuple):
    """State of a `PID`; while it is off, only ``u`` and ``memory`` matter."""

    has_slope: bool = False  # y and slope are valid
    engaged: bool = False
    carries: bool = False  # the integral includes the proportional part
    integral: float = 0.0
    u: float = 0.0
    memory: float = 0.0  # while off the output without track, while engaged F
    y: float = 0.0
    slope: float = 0.0


class PID:
    """Sampled PI-D law with output limits, back-calculation, tracking and bumpless engagement.

    .. math::
        v_k &= K_p (b r_k - y_k) + I_k - K_d d_k - K_r \\omega_k + f_k + F_k, \\qquad
        u_k = \\min(\\max(v_k, u_\\mathrm{low}), u_\\mathrm{high}) \\\\
        I_{k+1} &= I_k + K_i T (r_k - y_k) + \\frac{T}{T_t} (u_k - v_k - s_k) \\\\
        d_k &= d_{k-1} + (1 - e^{-T/T_f}) \\left(\\frac{y_k - y_{k-1}}{T} - d_{k-1}\\right), \\qquad
        F_{k+1} = e^{-T/T_e} F_k

    with the reference r, the measured value y, its measured rate omega, a feed-forward f, and s,
    the last output less the part that the actuator applied. The law itself is stateless: `sample`
    takes the state and returns the next.

    While it is off, the output holds its last value, plus changes of ``track`` (e.g. a pilot's
    command). At engagement the output continues from its present value: the integral is set to the
    held output, and F initially cancels the damping terms. F then decays, because an integral that
    absorbed a transient rate would have to unwind.

    Parameters
    ----------
    T : float
        sample period in s
    Kp, Ki, Kd, Kr, b, Tf, Tt, Te, low, high : float
        as in `DiscretePID`, but by default without gains and limits. Tt defaults to Kp / Ki, at
        least 2 T: for b = 1 the output then leaves a limit when the error changes sign
    carry : bool
        store the proportional part with the integral, so that gain changes cause no jump

    References
    ----------
    Astrom, Hagglund: *Advanced PID Control*, ISA, 2006, chapters 3 and 13.
    """

    START = PIDState()
    FROM_REST = PIDState(engaged=True)

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
        carry: bool = False,
    ):
        self.T = positive("T", T)
        self.low, self.high = check_range(low, high)
        self.carry = carry
        self._fade = math.exp(-self.T / positive("Te", Te))
        self.retune(
            number("Kp", Kp),
            number("Ki", Ki),
            number("Kd", Kd),
            number("Kr", Kr),
            number("b", b),
            number("Tf", Tf, low=0.0),
        )
        if Tt is not None:
            Tt = number("Tt", Tt, low=self.T)
            self.unwind = self.T / Tt if self.Ki else 0.0

    def retune(
        self,
        Kp: float,
        Ki: float,
        Kd: float = 0.0,
        Kr: float = 0.0,
        b: float = 1.0,
        Tf: float = 0.0,
    ) -> None:
        """Change the gains, without checks, with the default of Tt."""
        self.Kp, self.Ki, self.Kd, self.Kr, self.b = Kp, Ki, Kd, Kr, b
        # gain of the derivative's low-pass filter per sample
        self._filter = -math.expm1(-self.T / Tf) if Tf else 1.0
        # without integral action, back-calculation would leave a permanent offset
        self.unwind = self.T / max(Kp / Ki, 2 * self.T) if Ki else 0.0

    @staticmethod
    def holding(u: float) -> PIDState:
        """State of a law that is off, with output ``u``."""
        return PIDState(u=u, memory=u)

    def sample(
        self,
        state: PIDState,
        r: float,
        y: float,
        rate: float = 0.0,
        sat: float = 0.0,
        off: bool = False,
        track: float = 0.0,
        feed: float = 0.0,
        r_last: float = 0.0,
        push: float = 0.0,
    ) -> tuple[float, PIDState]:
        """Output at one instant and the state after it.

        Parameters
        ----------
        state : PIDState
            `START` (bumpless engagement from 0), `FROM_REST` (the textbook law from the first
            sample on, with an integral of 0), or the state returned by the last sample
        r, y, rate : float
            reference, measured value, measured rate
        sat : float
            last output less the part that the actuator applied; 0 while it is not saturated
        off : bool
            hold the output
        track : float
            added to the held output
        feed : float
            feed-forward, added to the output while engaged
        r_last : float
            reference of the last sample, for a state that carries the proportional part
        push : float
            the part of the change of r that acts with full weight, as if b were 1
        """
        has_slope, engaged, carries, integral, u, memory, y_last, slope = state
        if has_slope:
            slope += self._filter * ((y - y_last) / self.T - slope)
        if off:
            offset = u - track if has_slope and engaged else memory
            u = clip(offset + track, self.low, self.high)
            return u, PIDState(True, False, self.carry, 0.0, u, offset, y, slope)

        direct = self.Kp * (self.b * r - y) + feed
        damping = self.Kd * slope + self.Kr * rate
        if engaged:
            fading = memory
            if carries:
                integral -= self.Kp * (self.b * r_last - y_last)
            if push:
                integral += self.Kp * (1.0 - self.b) * push
        elif self.Ki:
            integral, fading = u - direct, damping
        else:  # without integral action, let the held offset decay
            integral, fading = 0.0, u - direct + damping
        v = direct + integral + (fading - damping)
        u = self.high if v > self.high else self.low if v < self.low else v
        integral += self.Ki * self.T * (r - y) + self.unwind * (u - v - sat)
        if self.carry:
            integral += direct - feed
        return u, PIDState(True, True, self.carry, integral, u, self._fade * fading, y, slope)


@dataclass(eq=False, repr=False)
class DiscretePID(SampledLaw):
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
    low : float
        minimum output
    high : float
        maximum output
    T : float
        sample period in s

    Other Parameters
    ----------------
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

    Inputs
    ------
    r
        reference
    y
        measured value, in the unit of r
    rate
        measured rate of y, its unit per s
    sat
        last output less the part that the actuator applied (an ``Aircraft`` output such as
        ``elev_sat``); 0 while it is not saturated
    off
        0 engaged; otherwise the output holds its last value
    track
        while off, added to the held output, to pass a manual command through
    feed
        feed-forward, added to the output while engaged

    Outputs
    -------
    u
        controller output

    Raises
    ------
    ParameterError
        for a parameter that is not a number or is out of range

    References
    ----------
    Astrom, Hagglund: *Advanced PID Control*, ISA, 2006, chapters 3 and 13.
    """

    Kp: float = 1.0
    Ki: float = 0.0
    Kd: float = 0.0
    Kr: float = 0.0
    b: float = 1.0
    Tf: float = 0.0
    Tt: float | None = None
    Te: float = 0.3
    low: float = -1.0
    high: float = 1.0
    T: float = parameter(1 / 120, positive)

    measured = ("y",)
    input_port_labels = {"r": 0, "y": 1, "rate": 2, "sat": 3, "off": 4, "track": 5, "feed": 6}
    output_port_labels = {"u": 0}

    def build(self) -> None:
        gains = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "T"}
        self._pid = PID(self.clock.period, **gains)

    def initial_state(self) -> PIDState:
        return PID.FROM_REST

    def law(self, u: list[float], state: PIDState) -> tuple[list[float], PIDState]:
        r, y, rate, sat, off, track, feed = u[:7]
        output, state = self._pid.sample(state, r, y, rate, sat, off != 0.0, track, feed)
        return [output], state
