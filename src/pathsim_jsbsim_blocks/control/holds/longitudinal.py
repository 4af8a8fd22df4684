"""Holds that act on the elevator and the throttle: pitch, altitude, airspeed."""

from __future__ import annotations

from ..._core.checks import number, optional, positive
from ..._core.parameters import parameter
from ..controller import (
    LOW,
    SLOW,
    Authority,
    Hold,
    authority_limits,
    fill,
    protection_from,
    reference_kind,
)
from ..gains import Gains
from ..loops import (
    AltitudeLoop,
    ReferenceLoop,
    SpeedLoop,
    State,
    pitch_loop,
)
from ..protection import Protection

# the package and PathView export these names
__all__ = ["AirspeedHold", "AltitudeHold", "PitchHold"]


@fill
class PitchHold(Hold):
    """Holds the pitch angle with the elevator.

    .. math::
        \\delta_e = -\\left[K_p (b \\, \\theta_\\mathrm{cmd} - \\theta)
        + K_i \\int (\\theta_\\mathrm{cmd} - \\theta) \\, dt - K_r q\\right]

    sampled at T. The reference theta_cmd starts at the pitch angle found at engagement and moves to
    ``theta_ref`` (parameter plus port) no faster than the gain table's ramp, so engagement is
    bumpless.

    Parameters
    ----------
    gains : str, AttitudeGains or dict
        name of a gain table ("c172p"), or numbers: Kp (1/deg), Ki (1/(deg s)), Kr (s/deg), b,
        ramp (deg/s)
    theta_ref : float, optional
        pitch angle to hold in deg; default: the value at engagement
    authority : float or pair
        largest elevator increment, of full travel
    %(T)s
    %(reference)s

    Inputs
    ------
    theta, q
        pitch angle in deg, pitch rate in deg/s
    theta_ref
        deg, added to the parameter
    off
        0 engaged; otherwise the elevator is frozen
    elev_sat
        ``Aircraft`` output of that name, for anti-windup at the end of travel
    %(vc)s

    Outputs
    -------
    elevator
        increment of the elevator command; positive is nose **down**
    theta_cmd
        reference on its ramp, deg

    %(raises)s
    """

    gains: Gains = parameter("c172p")
    theta_ref: float | None = parameter(None, optional)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: str = parameter("increment", reference_kind)

    measured = ("theta", "q")
    commands = {"elevator": "off"}
    input_port_labels = {"theta": 0, "q": 1, "theta_ref": 2, "off": 3, "elev_sat": 4, "vc": 5}
    output_port_labels = {"elevator": 0, "theta_cmd": 1}

    def build(self) -> None:
        (gains,) = self.gains_of("pitch")
        self._theta_ref = self.checked.theta_ref
        self._pitch = pitch_loop(self.clock.period, gains, self.checked.authority, self._loop)

    def initial_state(self) -> State:
        return ReferenceLoop.START

    def law(self, u: list[float], state: State) -> tuple[list[float], State]:
        theta, q, theta_ref, off, elev_sat, vc = u[:6]
        target = self._theta_ref
        if self._absolute:
            target, theta_ref = self.target("theta_ref", theta_ref, target)
        if self._schedule is not None:
            self.follow(vc, pitch=self._pitch)
        elevator, theta_cmd, state = self._pitch.sample(
            state, theta, q, target, theta_ref, elev_sat, off != 0.0
        )
        return [elevator, theta_cmd], state


@fill
class AltitudeHold(Hold):
    """Holds the altitude with the elevator, through rate-of-climb and pitch loops.

    .. math::
        \\dot h_\\mathrm{cmd} = K_h (h_\\mathrm{ref} - h), \\quad
        |\\dot h_\\mathrm{cmd}| \\le \\dot h_\\mathrm{max} \\\\
        \\theta_\\mathrm{cmd} = K_p (\\dot h_\\mathrm{cmd} - \\dot h)
        + K_i \\int (\\dot h_\\mathrm{cmd} - \\dot h) \\, dt

    with the pitch loop of ``PitchHold`` inside, sampled at T. It flies climbs and descents with the
    elevator alone: add an ``AirspeedHold`` for the airspeed. With the port ``alpha`` wired it keeps
    the angle of attack below its limit, and with ``vc`` the airspeed above its lowest: a climb that
    the thrust does not sustain is reduced, and becomes a descent. Without these wires it climbs
    into the stall.

    Parameters
    ----------
    gains : str or dict
        name of a gain table ("c172p"), or {"altitude": ..., "pitch": ...}, each either the name
        of a table or numbers; altitude: Kh (1/s), Kp (deg/(ft/s)), Ki (deg/ft), hdot_max (ft/s),
        theta_max (deg); pitch: as in ``PitchHold``
    h_ref : float, optional
        altitude to hold in ft; default: the value at engagement
    hdot_max : float, optional
        largest rate of climb and descent demanded, ft/s; default is the gain table's
    theta_min : float
        lowest pitch reference in deg
    theta_max : float, optional
        highest pitch reference in deg; default is the gain table's
    authority : float or pair
        largest elevator increment, of full travel
    %(T)s
    %(reference)s
    %(alpha_max)s

    Inputs
    ------
    h, hdot
        altitude in ft, rate of climb in ft/s
    theta, q
        pitch angle in deg, pitch rate in deg/s
    h_ref
        ft, added to the parameter
    off
        0 engaged; otherwise the elevator is frozen
    elev_sat
        ``Aircraft`` output of that name, for anti-windup at the end of travel
    vc
        calibrated airspeed in kt, for gains that depend on it, and for the protection; without a
        wire (0) the gains are those of the table's nominal point, and the protection limits neither
        the airspeed nor the load factor
    alpha
        angle of attack in deg; without a wire (0) there is no protection from the stall

    Outputs
    -------
    elevator
        increment of the elevator command; positive is nose **down**
    theta_cmd
        pitch reference on its ramp, deg
    hdot_cmd
        rate of climb demanded, ft/s

    %(raises)s
    """

    gains: Gains = parameter("c172p")
    h_ref: float | None = parameter(None, optional)
    hdot_max: float | None = parameter(None, optional, above=0.0)
    theta_min: float = parameter(-10.0, number)
    theta_max: float | None = parameter(None, optional)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: str = parameter("increment", reference_kind)
    alpha_max: float | None = parameter(None, optional)

    measured = ("h", "hdot", "theta", "q")
    commands = {"elevator": "off"}
    input_port_labels = {
        "h": 0,
        "hdot": 1,
        "theta": 2,
        "q": 3,
        "h_ref": 4,
        "off": 5,
        "elev_sat": 6,
        "vc": 7,
        "alpha": 8,
    }
    output_port_labels = {"elevator": 0, "theta_cmd": 1, "hdot_cmd": 2}

    def build(self) -> None:
        altitude, pitch, envelope = self.gains_of("altitude", "pitch", "envelope")
        self._h_ref = self.checked.h_ref
        self._altitude = self.altitude_loop(
            altitude, self.checked.hdot_max, self.checked.theta_min, self.checked.theta_max
        )
        self._pitch = pitch_loop(self.clock.period, pitch, self.checked.authority, self._loop)
        self._protection = protection_from(self.clock.period, self.checked.alpha_max, envelope)

    def initial_state(self) -> State:
        return AltitudeLoop.START, ReferenceLoop.START, (Protection.START, 0.0)

    def law(self, u: list[float], state: State) -> tuple[list[float], State]:
        h, hdot, theta, q, h_ref, off, elev_sat, vc, alpha = u[:9]
        altitude, pitch, (guard, cut) = state
        h_target, target, hdot_cmd = self._h_ref, None, 0.0
        if self._absolute:
            h_target, h_ref = self.target("h_ref", h_ref, h_target)
        elif h_ref > h >= LOW:
            self.doubt("h_ref", h_ref, h, "ft")
        if self._schedule is not None:
            self.follow(
                vc, h, altitude=self._altitude, pitch=self._pitch, envelope=self._protection
            )
        protection = self.protection(alpha)
        theta_max, climb, _, guard = protection.sample(guard, theta, alpha, h, hdot, vc, True)
        if off:
            altitude = AltitudeLoop.START
        else:
            target, hdot_cmd, altitude = self._altitude.sample(
                altitude,
                h,
                hdot,
                h_target,
                h_ref,
                ReferenceLoop.reference(pitch, theta),
                1.0,
                climb,
                cut,
            )
        pitch, theta_ref, cut = protection.limit(
            self._pitch, pitch, theta, target, 0.0, theta_max, h, vc
        )
        elevator, theta_cmd, pitch = self._pitch.sample(
            pitch, theta, q, target, theta_ref, elev_sat, off != 0.0
        )
        return [elevator, theta_cmd, hdot_cmd], (altitude, pitch, (guard, cut))


@fill
class AirspeedHold(Hold):
    """Holds the calibrated airspeed with the throttle (autothrottle).

    .. math::
        \\delta_t = K_p (b V_\\mathrm{cmd} - V') + K_i \\int (V_\\mathrm{cmd} - V') \\, dt
        - K_d \\dot V' + K_c \\dot h

    sampled at T. The reference V_cmd starts at the airspeed found at engagement and moves to
    ``vc_ref`` (parameter plus port) no faster than the gain table's ramp. With the rate of climb
    connected, the extra throttle for a climb is fed forward. V' is the airspeed within the gain
    table's band about the reference; beyond, each further knot of error counts as 0.2 kt, so that
    gusts do not move the throttle from stop to stop.

    Parameters
    ----------
    gains : str, SpeedGains or dict
        name of a gain table ("c172p"), or numbers: Kp (1/kt), Ki (1/(kt s)), Kd (s/kt), Tf (s),
        b, ramp (kt/s), Kc (s/ft), band (kt)
    vc_ref : float, optional
        airspeed to hold, KCAS; default: the value at engagement
    authority : float or pair
        largest throttle increment, of full range
    %(T)s
    %(reference)s

    Inputs
    ------
    vc
        calibrated airspeed in kt
    hdot
        rate of climb in ft/s, fed forward
    vc_ref
        kt, added to the parameter
    off
        0 engaged; otherwise the throttle is frozen
    thr_sat
        ``Aircraft`` output of that name, for anti-windup at idle and full throttle

    Outputs
    -------
    throttle
        increment of the throttle command of every engine
    vc_cmd
        reference on its ramp, kt

    %(raises)s
    """

    gains: Gains = parameter("c172p")
    vc_ref: float | None = parameter(None, optional)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: str = parameter("increment", reference_kind)

    measured = ("vc", "hdot")
    commands = {"throttle": "off"}
    input_port_labels = {"vc": 0, "hdot": 1, "vc_ref": 2, "off": 3, "thr_sat": 4}
    output_port_labels = {"throttle": 0, "vc_cmd": 1}

    def build(self) -> None:
        (gains,) = self.gains_of("speed")
        self._vc_ref = self.checked.vc_ref
        self._speed = SpeedLoop(self.clock.period, gains, self.checked.authority, self._loop)

    def initial_state(self) -> State:
        return SpeedLoop.START

    def law(self, u: list[float], state: State) -> tuple[list[float], State]:
        vc, hdot, vc_ref, off, thr_sat = u[:5]
        target = self._vc_ref
        if self._absolute:
            target, vc_ref = self.target("vc_ref", vc_ref, target)
        elif vc_ref > vc >= SLOW:
            self.doubt("vc_ref", vc_ref, vc, "kt")
        if self._schedule is not None:
            self.follow(vc, speed=self._speed)
        throttle, vc_cmd, state = self._speed.sample(
            state, vc, hdot, target, vc_ref, thr_sat, off != 0.0
        )
        return [throttle, vc_cmd], state
