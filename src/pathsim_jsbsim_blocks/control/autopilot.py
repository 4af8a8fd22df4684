"""All holds in one block."""

from __future__ import annotations

from .._core.checks import number, optional, positive
from .._core.parameters import parameter
from .controller import (
    LOW,
    SLOW,
    Authority,
    Hold,
    authority_limits,
    fill,
    protection_from,
    reference_kind,
)
from .gains import Gains
from .loops import (
    AltitudeLoop,
    HeadingLoop,
    ReferenceLoop,
    SpeedLoop,
    State,
    YawLoop,
    pitch_loop,
    roll_loop,
)
from .protection import Protection


@fill
class Autopilot(Hold):
    """Autopilot with autothrottle and yaw damper in one block; the fastest to simulate.

    The loops are those of ``AltitudeHold`` or ``PitchHold``, ``HeadingHold`` or ``RollHold``,
    ``AirspeedHold`` and ``YawDamper``, sampled at T. With every port at 0 it holds the altitude,
    heading and airspeed found at engagement. Mode changes are bumpless; a mode that takes over
    holds the values it finds, plus its reference port.

    With the port ``alpha`` wired, and a gain table that has limits of the flight envelope,
    references are limited to prevent a stall: the pitch angle gives way before the angle of attack
    exceeds its limit; the airspeed demanded is at least the lowest; a climb is limited to what the
    thrust sustains, and becomes a descent at too low an airspeed.

    Parameters
    ----------
    gains : str, AircraftGains or dict
        name of a gain table ("c172p"), or {"pitch": ..., "roll": ..., "heading": ...,
        "altitude": ..., "speed": ..., "yaw": ...}, each either the name of a table or numbers as
        in the holds
    theta_ref : float, optional
        pitch angle to hold in deg; default: the value at engagement of the mode
    h_ref : float, optional
        altitude to hold in ft; default: the value at engagement
    phi_ref : float, optional
        roll angle to hold in deg; default: the value at engagement
    psi_ref : float, optional
        heading to hold in deg; default: the value at engagement
    vc_ref : float, optional
        airspeed to hold in KCAS; default: the value at engagement. Airspeed has priority over
        altitude: below 90 % of it, a climb that full throttle cannot sustain is reduced
    bank_max : float
        largest bank reference of the heading hold in deg
    hdot_max : float, optional
        largest rate of climb and descent of the altitude hold, ft/s; default is the gain table's
    theta_min : float
        lowest pitch reference of the altitude hold in deg
    theta_max : float, optional
        highest pitch reference of the altitude hold in deg; default is the gain table's
    elevator_authority : float or pair
        largest elevator increment, of full travel
    aileron_authority : float or pair
        largest aileron increment, of full travel
    rudder_authority : float or pair
        largest rudder increment, of full travel
    throttle_authority : float or pair
        largest throttle increment, of full travel
    %(T)s
    %(reference)s
    %(alpha_max)s

    Inputs
    ------
    theta, phi, psi
        pitch, roll and heading angle in deg
    p, q, r
        body rates in deg/s
    h, hdot, vc
        altitude in ft, rate of climb in ft/s, calibrated airspeed in kt
    theta_ref, h_ref, phi_ref, psi_ref, vc_ref
        added to the parameters, same units; see ``reference``
    pitch_mode
        0 altitude hold; otherwise pitch hold
    roll_mode
        0 heading hold; otherwise roll hold
    pitch_off, roll_off, speed_off
        0 engaged; otherwise the command is frozen
    yaw_off
        0 engaged; otherwise the rudder increment decays to 0
    elev_sat, ail_sat, thr_sat
        ``Aircraft`` outputs of these names, for anti-windup
    alpha
        angle of attack in deg; without a wire (0) there is no protection from the stall
    beta
        angle of sideslip in deg; without a wire (0) turns are not coordinated

    Outputs
    -------
    elevator, aileron, rudder, throttle
        increments of the commands; positive elevator is nose **down**, positive aileron rolls right
    theta_cmd, phi_cmd, vc_cmd
        references on their ramps, deg, deg and kt
    hdot_cmd
        rate of climb demanded, ft/s; 0 in pitch hold

    %(raises)s
    """

    gains: Gains = parameter("c172p")
    theta_ref: float | None = parameter(None, optional)
    h_ref: float | None = parameter(None, optional)
    phi_ref: float | None = parameter(None, optional)
    psi_ref: float | None = parameter(None, optional)
    vc_ref: float | None = parameter(None, optional)
    bank_max: float = parameter(25.0, positive)
    hdot_max: float | None = parameter(None, optional, above=0.0)
    theta_min: float = parameter(-10.0, number)
    theta_max: float | None = parameter(None, optional)
    elevator_authority: Authority = parameter(1.0, authority_limits)
    aileron_authority: Authority = parameter(1.0, authority_limits)
    rudder_authority: Authority = parameter(1.0, authority_limits)
    throttle_authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: str = parameter("increment", reference_kind)
    alpha_max: float | None = parameter(None, optional)

    measured = ("theta", "phi", "psi", "p", "q", "r", "h", "hdot", "vc")
    # an aircraft may have a yaw damper of its own
    commands = {"elevator": "pitch_off", "aileron": "roll_off", "throttle": "speed_off"}
    input_port_labels = {
        name: i
        for i, name in enumerate(
            (
                "theta",
                "phi",
                "psi",
                "p",
                "q",
                "r",
                "h",
                "hdot",
                "vc",
                "theta_ref",
                "h_ref",
                "phi_ref",
                "psi_ref",
                "vc_ref",
                "pitch_mode",
                "roll_mode",
                "pitch_off",
                "roll_off",
                "speed_off",
                "yaw_off",
                "elev_sat",
                "ail_sat",
                "thr_sat",
                "alpha",
                "beta",
            )
        )
    }
    output_port_labels = {
        name: i
        for i, name in enumerate(
            (
                "elevator",
                "aileron",
                "rudder",
                "throttle",
                "theta_cmd",
                "phi_cmd",
                "vc_cmd",
                "hdot_cmd",
            )
        )
    }

    def build(self) -> None:
        T = self.clock.period
        pitch, roll, heading, altitude, speed, yaw, envelope = self.gains_of(
            "pitch", "roll", "heading", "altitude", "speed", "yaw", "envelope"
        )
        c = self.checked
        self._targets = [c.theta_ref, c.h_ref, c.phi_ref, c.psi_ref, c.vc_ref]
        self._pitch = pitch_loop(T, pitch, c.elevator_authority, self._loop)
        self._roll = roll_loop(T, roll, c.aileron_authority, self._loop)
        self._speed = SpeedLoop(T, speed, c.throttle_authority, self._loop)
        self._yaw = YawLoop(T, yaw, c.rudder_authority)
        self._heading = HeadingLoop(T, heading, c.bank_max)
        self._altitude = self.altitude_loop(altitude, c.hdot_max, c.theta_min, c.theta_max)
        self._protection = protection_from(T, c.alpha_max, envelope)

    def initial_state(self) -> State:
        return (
            AltitudeLoop.START,
            ReferenceLoop.START,
            HeadingLoop.START,
            ReferenceLoop.START,
            SpeedLoop.START,
            YawLoop.START,
            (Protection.START, 0.0),
        )

    def law(self, u: list[float], state: State) -> tuple[list[float], State]:
        (
            theta,
            phi,
            psi,
            p,
            q,
            r,
            h,
            hdot,
            vc,
            theta_ref,
            h_ref,
            phi_ref,
            psi_ref,
            vc_ref,
            pitch_mode,
            roll_mode,
            pitch_off,
            roll_off,
            speed_off,
            yaw_off,
            elev_sat,
            ail_sat,
            thr_sat,
            alpha,
            beta,
        ) = u[:25]
        altitude, pitch, heading, roll, speed, yaw, (guard, cut) = state
        theta_target, h_target, phi_target, psi_target, vc_target = self._targets
        if self._absolute:
            theta_target, theta_ref = self.target("theta_ref", theta_ref, theta_target)
            h_target, h_ref = self.target("h_ref", h_ref, h_target)
            phi_target, phi_ref = self.target("phi_ref", phi_ref, phi_target)
            psi_target, psi_ref = self.target("psi_ref", psi_ref, psi_target)
            vc_target, vc_ref = self.target("vc_ref", vc_ref, vc_target)
        elif h_ref > h or vc_ref > vc:
            if h_ref > h >= LOW:
                self.doubt("h_ref", h_ref, h, "ft")
            elif vc_ref > vc >= SLOW:
                self.doubt("vc_ref", vc_ref, vc, "kt")
        if self._schedule is not None:
            self.follow(
                vc,
                h,
                pitch=self._pitch,
                roll=self._roll,
                heading=self._heading,
                altitude=self._altitude,
                speed=self._speed,
                yaw=self._yaw,
                envelope=self._protection,
            )
        protection = self.protection(alpha)
        theta_max, climb, boost, guard = protection.sample(
            guard,
            theta,
            alpha,
            h,
            hdot,
            vc,
            thr_sat > 0.0,
            ReferenceLoop.reference(speed, vc),
            pitch_mode != 0.0,
        )
        wanted = ReferenceLoop.destination(speed, vc, vc_target, vc_ref)
        vc_ref += max(protection.vc_min - wanted, 0.0)

        throttle, vc_cmd, speed = self._speed.sample(
            speed, vc, hdot, vc_target, vc_ref, thr_sat, speed_off != 0.0, boost
        )
        hdot_cmd = 0.0
        if pitch_mode or pitch_off:
            altitude = AltitudeLoop.START
        else:
            theta_ref = 0.0
            theta_target, hdot_cmd, altitude = self._altitude.sample(
                altitude,
                h,
                hdot,
                h_target,
                h_ref,
                ReferenceLoop.reference(pitch, theta),
                protection.share_of_climb(vc, vc_cmd),
                climb,
                cut,
            )
        pitch, theta_ref, cut = protection.limit(
            self._pitch, pitch, theta, theta_target, theta_ref, theta_max, h, vc
        )
        elevator, theta_cmd, pitch = self._pitch.sample(
            pitch, theta, q, theta_target, theta_ref, elev_sat, pitch_off != 0.0
        )

        if roll_mode or roll_off:
            heading = HeadingLoop.START
        else:
            phi_ref = 0.0
            phi_target, heading = self._heading.sample(heading, psi, psi_target, psi_ref)
        wanted = ReferenceLoop.destination(roll, phi, phi_target, phi_ref)
        most = protection.bank(guard, h, phi)
        phi_ref += min(max(wanted, -most), most) - wanted
        aileron, phi_cmd, roll = self._roll.sample(
            roll, phi, p, phi_target, phi_ref, ail_sat, roll_off != 0.0
        )

        rudder, yaw = self._yaw.sample(yaw, r, yaw_off != 0.0, beta, p, phi)
        return (
            [elevator, aileron, rudder, throttle, theta_cmd, phi_cmd, vc_cmd, hdot_cmd],
            (altitude, pitch, heading, roll, speed, yaw, (guard, cut)),
        )
