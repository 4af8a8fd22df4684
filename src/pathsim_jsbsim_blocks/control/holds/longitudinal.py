"""Holds of the pitch angle with the elevator and of the airspeed with the throttle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ..._core.checks import optional, positive
from ..._core.parameters import parameter
from ..._core.ports import numbered
from ..airspeeds import ComplementaryAirspeed
from ..controller import Authority, Hold, ReferenceKind, authority_limits, fill, reference_kind
from ..gains import Gains
from ..loops import ReferenceLoop, ReferenceState, SpeedLoop, attitude_loop

__all__ = [
    "AirspeedHold",
    "PitchHold",
]


@fill
@dataclass(eq=False, repr=False)
class PitchHold(Hold):
    """Holds the pitch angle with the elevator.

    .. math::
        \\delta_e = -\\left[K_p (b \\, \\theta_\\mathrm{cmd} - \\theta)
        + K_i \\int (\\theta_\\mathrm{cmd} - \\theta) \\, dt - K_r q\\right]

    sampled at T. The reference theta_cmd starts at the pitch angle at engagement and moves to
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
        maximum elevator increment, of full travel
    %(T)s
    %(reference)s

    Inputs
    ------
    theta, q
        pitch angle in deg, pitch rate in deg/s
    theta_ref
        deg, added to the parameter
    %(elev_off)s
    %(vc)s

    Outputs
    -------
    elevator
        increment of the elevator command; positive is nose **down**
    theta_cmd
        reference on its ramp, deg

    %(raises)s
    """

    gains: Gains = "c172p"
    theta_ref: float | None = parameter(None, optional, low=-90.0, high=90.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: ReferenceKind = parameter("increment", reference_kind)

    measured = ("theta", "q")
    commands = {"elevator": "off"}
    input_port_labels = {"theta": 0, "q": 1, "theta_ref": 2, "off": 3, "elev_sat": 4, "vc": 5}
    output_port_labels = {"elevator": 0, "theta_cmd": 1}

    START = ReferenceLoop.START

    def build(self) -> None:
        (gains,) = self.gains_of("pitch")
        T, authority = self.clock.period, self._checked.authority
        self.pitch = attitude_loop(T, gains, authority, -1.0, self.scheduled)
        self.follows(pitch=self.pitch)

    def law(self, u: list[float], state: ReferenceState) -> tuple[list[float], ReferenceState]:
        theta, q, theta_ref, off, elev_sat, vc = u[:6]
        self.retune(vc)
        target, keeps = self.pitch.towards(state, theta, self.wanted("theta_ref", theta_ref))
        elevator, theta_cmd, state = self.pitch.sample(
            state, theta, q, target, keeps, elev_sat, off != 0.0
        )
        return [elevator, theta_cmd], state


class AirspeedState(NamedTuple):
    """State of an `AirspeedHold`."""

    speed: ReferenceState = SpeedLoop.START
    airspeed: float = ComplementaryAirspeed.START  # kt
    climb: float = 0.0  # rate of climb to feed forward, ft/s


@fill
@dataclass(eq=False, repr=False)
class AirspeedHold(Hold):
    """Holds the calibrated airspeed with the throttle (autothrottle).

    .. math::
        \\delta_t = K_p (b V_\\mathrm{cmd} - V') + K_i \\int (V_\\mathrm{cmd} - V') \\, dt
        - K_d \\dot V' + K_c \\dot h_\\mathrm{cmd}

    sampled at T. The reference V_cmd starts at the airspeed at engagement and moves to
    ``vc_ref`` (parameter plus port) no faster than the gain table's ramp. The extra throttle for a
    climb is fed forward: from the commanded rate of climb with a lag of 2 s or, if ``hdot_cmd`` is
    not connected, from the measured one, which rising air makes wrong. V' is the airspeed within
    the gain table's band about the reference; beyond, each further knot of error counts as 0.2 kt.

    With ``nx``, ``nz``, ``alpha``, ``theta``, ``phi`` and ``vt`` connected, the throttle follows
    the aircraft and not the gusts: above 0.1 rad/s the airspeed is the integral of the inertial
    acceleration along the path through the air, at most 4 kt above and 8 kt below the measured one.

    Parameters
    ----------
    gains : str, SpeedGains or dict
        name of a gain table ("c172p"), or numbers: Kp (1/kt), Ki (1/(kt s)), Kd (s/kt), Tf (s),
        b, ramp (kt/s), Kc (s/ft), band (kt)
    vc_ref : float, optional
        airspeed to hold, KCAS; default: the value at engagement
    authority : float or pair
        maximum throttle increment, of full range
    %(T)s
    %(reference)s

    Inputs
    ------
    vc
        calibrated airspeed in kt
    hdot
        rate of climb in ft/s, fed forward unless ``hdot_cmd`` is connected
    vc_ref
        kt, added to the parameter
    off
        0 engaged; otherwise the throttle is frozen
    thr_sat
        ``Aircraft`` output of that name, for anti-windup at idle and full throttle
    hdot_cmd
        commanded rate of climb in ft/s, of the hold that moves the elevator; 0, as of a hold that
        is off, is no command
    nx, nz
        load factors, g
    alpha, beta
        angles of attack and sideslip, deg; a ``beta`` that is not connected counts as 0
    theta, phi
        pitch and roll angle, deg
    vt
        true airspeed, ft/s

    Outputs
    -------
    throttle
        increment of the throttle command of every engine
    vc_cmd
        reference on its ramp, kt

    %(raises)s
    """

    gains: Gains = "c172p"
    vc_ref: float | None = parameter(None, optional, above=0.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: ReferenceKind = parameter("increment", reference_kind)

    measured = ("vc", "hdot")
    commands = {"throttle": "off"}
    input_port_labels = numbered(
        "vc hdot vc_ref off thr_sat hdot_cmd nx nz alpha beta theta phi vt"
    )
    output_port_labels = {"throttle": 0, "vc_cmd": 1}

    START = AirspeedState()

    def build(self) -> None:
        (gains,) = self.gains_of("speed")
        T = self.clock.period
        self.airspeed = ComplementaryAirspeed(T)
        self.speed = SpeedLoop(T, gains, self._checked.authority, self.scheduled)
        self.follows(speed=self.speed)

    def law(self, u: list[float], state: AirspeedState) -> tuple[list[float], AirspeedState]:
        vc, hdot, vc_ref, off, thr_sat, hdot_cmd, *motion = u[:13]
        self.retune(vc)
        wired = self.inputs.wired >= ComplementaryAirspeed.SIGNALS
        inertial, next_airspeed = self.airspeed.sample(state.airspeed, vc, *motion, connected=wired)
        airspeed = self.airspeed.within(inertial, vc)
        climb = hdot if hdot_cmd == 0.0 or not state.speed.law.has_slope else state.climb
        target, keeps = self.speed.loop.towards(
            state.speed, airspeed, self.wanted("vc_ref", vc_ref, vc)
        )
        throttle, vc_cmd, speed = self.speed.sample(
            state.speed, airspeed, climb, target, keeps, thr_sat, off != 0.0
        )
        if hdot_cmd != 0.0:
            climb = self.speed.follow(climb, hdot_cmd)
        return [throttle, vc_cmd], AirspeedState(speed, next_airspeed, climb)
