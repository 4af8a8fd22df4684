"""`Autopilot`: all holds in one block."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from .._core.checks import number, optional, positive
from .._core.parameters import parameter
from .._core.ports import numbered
from .channels import ClimbState, Lateral, LateralState, Vertical, VerticalState
from .controller import Authority, Hold, authority_limits, fill, reference_kind
from .gains import Gains
from .loops import (
    HeadingLoop,
    Limits,
    Reference,
    ReferenceLoop,
    ReferenceState,
    SpeedLoop,
    SpeedOnPitchLoop,
    YawLoop,
    YawState,
    attitude_loop,
)
from .protection import true_airspeed
from .signals import limit, select, smaller


class LeverState(NamedTuple):
    """State of a throttle that is given."""

    found: float = 0.0  # as it began
    spare: float = 0.0  # what is given beyond that
    rate: float = 0.0  # of climb with it, ft/s


class AutopilotState(NamedTuple):
    """State of an `Autopilot`."""

    vertical: VerticalState = Vertical.START
    lateral: LateralState = Lateral.START
    speed: ReferenceState = SpeedLoop.START
    yaw: YawState = YawLoop.START
    climb: ClimbState = ClimbState()
    pitched: ReferenceState = SpeedOnPitchLoop.START  # the airspeed, held by the elevator
    lever: LeverState = LeverState()


@fill
@dataclass(eq=False, repr=False)
class Autopilot(Hold):
    """Autopilot with autothrottle and yaw damper in one block; the fastest to simulate.

    The loops are those of ``AltitudeHold`` or ``PitchHold``, ``HeadingHold`` or ``RollHold``,
    ``AirspeedHold`` and ``YawDamper``, on request of ``VerticalSpeedHold`` or ``SpeedOnPitchHold``,
    sampled at T. With every port at 0 it holds the altitude, heading and airspeed found at
    engagement. Mode changes are bumpless; a mode that takes over holds the values it finds, plus
    its reference port.

    With the port ``alpha`` wired, and a gain table that has limits of the flight envelope,
    references are limited so that no demand leads into the stall, to the ground or beyond the
    highest airspeed; then bank comes before height, and height before airspeed. The lowest airspeed
    follows from the angle of attack: weight, flaps and load factor are in it.

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
    %(T)s
    %(reference)s
    %(alpha_max)s
    hdot_ref : float, optional
        rate of climb to hold in ft/s; default: the value at engagement of the mode
    thr_ref : float, optional
        throttle increment while the elevator holds the airspeed; default: that at engagement of
        the mode

    Other Parameters
    ----------------
    bank_max : float
        largest bank reference of the heading hold in deg
    hdot_max : float, optional
        largest rate of climb and descent of the altitude hold, ft/s; default is the gain table's,
        and for descents what it allows at idle
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
    v_mode
        with ``pitch_mode`` at 0: 0 altitude hold, 1 the rate of climb, 2 the airspeed with the
        elevator at a given throttle; 1 and 2 until the altitude ``h_ref``, if there is one, is
        captured
    hdot_ref, thr_ref
        added to the parameters, ft/s and full travel
    h_agl
        height above the ground in ft, with ``alpha`` wired: no descent below 100 ft; without a wire
        (0) the ground is not known
    vt
        true airspeed in ft/s, with which the bank of straight flight follows what the aircraft
        needs, with a failed engine for example; without a wire (0) it is that of the gains

    Outputs
    -------
    elevator, aileron, rudder, throttle
        increments of the commands; positive elevator is nose **down**, positive aileron rolls right
    theta_cmd, phi_cmd, vc_cmd
        references on their ramps, deg, deg and kt
    hdot_cmd
        rate of climb demanded, ft/s; 0 in pitch hold
    captured
        1 from the capture of the altitude on, otherwise 0

    %(raises)s
    """

    gains: Gains = "c172p"
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
    hdot_ref: float | None = parameter(None, optional)
    thr_ref: float | None = parameter(None, optional)

    measured = ("theta", "phi", "psi", "p", "q", "r", "h", "hdot", "vc")
    # an aircraft may have a yaw damper of its own
    commands = {"elevator": "pitch_off", "aileron": "roll_off", "throttle": "speed_off"}
    input_port_labels = numbered(
        "theta phi psi p q r h hdot vc theta_ref h_ref phi_ref psi_ref vc_ref pitch_mode "
        "roll_mode pitch_off roll_off speed_off yaw_off elev_sat ail_sat thr_sat alpha beta "
        "v_mode hdot_ref thr_ref h_agl vt"
    )
    output_port_labels = numbered(
        "elevator aileron rudder throttle theta_cmd phi_cmd vc_cmd hdot_cmd captured"
    )

    REFERENCES = ("theta_ref", "h_ref", "phi_ref", "psi_ref", "vc_ref", "hdot_ref", "thr_ref")
    START = AutopilotState()

    def build(self) -> None:
        pitch, roll, heading, altitude, speed, yaw, envelope = self.gains_of(
            "pitch", "roll", "heading", "altitude", "speed", "yaw", "envelope"
        )
        T, c, carry = self.clock.period, self.checked, self.scheduled
        self.loops = {
            "pitch": attitude_loop(T, pitch, c.elevator_authority, -1.0, carry),
            "roll": attitude_loop(T, roll, c.aileron_authority, carry=carry),
            "heading": HeadingLoop(T, heading, c.bank_max),
            "altitude": self.altitude_loop(altitude),
            "speed": SpeedLoop(T, speed, c.throttle_authority, carry),
            "yaw": YawLoop(T, yaw, c.rudder_authority),
            "envelope": self.protection_within(envelope),
        }
        self.loops["climb"] = SpeedOnPitchLoop(T, speed.ramp, self.loops["altitude"].pid)

    def channels(self, u: list[Any], state: Any, form: Any) -> tuple[list[Any], Any]:
        theta, phi, psi, p, q, r, h, hdot, vc = u[:9]
        named = zip(self.REFERENCES, [*u[9:14], *u[26:28]], strict=True)
        references = [self.wanted(*x) for x in named]
        theta_ref, h_ref, phi_ref, psi_ref, vc_ref, hdot_ref, thr_ref = references
        pitching, rolling, *offs = (x != 0.0 for x in u[14:20])
        pitch_off, roll_off, speed_off, yaw_off = offs
        elev_sat, ail_sat, thr_sat, alpha, beta, v_mode = u[20:26]
        h_agl, vt = u[28:]
        mode = select(pitching, 0.0, v_mode)
        captured = select(mode == state.climb.mode, state.climb.captured, False)
        on_pitch = select(captured | pitch_off, False, mode == 2.0)

        vertical = Vertical(
            self.loops, form[1], state.vertical, theta, q, h, hdot, vc, alpha, pitch_off, elev_sat
        )
        protection = vertical.protection
        # the loop of the throttle and that of the elevator hold one airspeed
        held = select(state.pitched.law.engaged, state.pitched, state.speed)
        vc_cmd = ReferenceLoop.reference(held, vc)
        vertical.guard(vc, thr_sat > 0.0, vc_cmd, pitching, phi, h_agl)
        limits, guard = vertical.limits, vertical.state.guard
        wanted, keeps = ReferenceLoop.towards(held, vc, vc_ref)
        wanted = protection.airspeed(guard, wanted, phi, h)
        throttle, vc_cmd, speed = self.loops["speed"].sample(
            state.speed, vc, hdot, wanted, keeps, thr_sat, speed_off | on_pitch, limits.boost
        )
        rate, vc_pitch, pitched = self.loops["climb"].sample(
            state.pitched,
            vc,
            true_airspeed(1.0, h),
            hdot,
            wanted,
            keeps,
            state.climb.cut,
            select(on_pitch, False, True),
        )
        vc_cmd = select(on_pitch, vc_pitch, vc_cmd)
        by_elevator, by_throttle = state.pitched.law.engaged, state.speed.law.engaged
        speed = speed._replace(found=select(by_elevator, held.found, speed.found))
        pitched = pitched._replace(found=select(by_throttle, held.found, pitched.found))
        thr_ref = self._allowed(thr_ref, limits, rate)
        throttle, speed, lever = self._lever(
            state, select(speed_off, False, on_pitch), throttle, speed, hdot, thr_sat, thr_ref
        )

        share = protection.share_of_climb(vc, vc_cmd)
        wanted, hdot_cmd, climb = vertical.for_climb(
            state.climb, mode, hdot_ref, h_ref, pitch_off | pitching, share, (on_pitch, rate)
        )
        direct, keeps = vertical.pitch.towards(state.vertical.pitch, theta, theta_ref)
        elevator, theta_cmd, after = vertical.fly(
            select(pitching, direct, wanted), select(pitching, keeps, False)
        )

        lateral = Lateral(self.loops, state.lateral, psi, phi, p, roll_off, ail_sat, vt)
        wanted = lateral.for_heading(psi_ref, roll_off | rolling)
        direct, keeps = lateral.roll.towards(state.lateral.roll, phi, phi_ref)
        bank = protection.bank(limits, guard, select(rolling, direct, wanted), phi)
        aileron, phi_cmd, turned = lateral.fly(bank, select(rolling, keeps, False))

        rudder, yaw = self.loops["yaw"].sample(state.yaw, r, yaw_off, beta, p, phi)
        outputs = [elevator, aileron, rudder, throttle, theta_cmd, phi_cmd, vc_cmd, hdot_cmd]
        outputs.append(select(climb.captured, 1.0, 0.0))
        return outputs, AutopilotState(after, turned, speed, yaw, climb, pitched, lever)

    @staticmethod
    def _allowed(given: Reference, limits: Limits, rate: Any) -> Reference:
        """A throttle that is given, less above the highest airspeed; more near the lowest one where
        the rate of climb that holds the airspeed is forbidden.
        """
        if limits.boost is None:
            return given
        boost = select(rate < limits.climb_min, limits.boost, smaller(limits.boost, 0.0))
        return given._replace(increment=given.increment + boost)

    def _lever(
        self,
        state: Any,
        given: Any,
        throttle: Any,
        speed: Any,
        hdot: Any,
        sat: Any,
        reference: Reference,
    ) -> tuple[Any, Any, LeverState]:
        """Throttle, given while the elevator holds the airspeed, and the next states.

        Afterwards the loop goes on from the throttle before. What was given beyond that climbs, and
        goes as the rate of climb does.
        """
        found, spare, rate = state.lever
        found = select(state.pitched.law.engaged, found, state.speed.law.u + spare)
        target, increment = reference
        lever = (found if target is None else target) + increment
        share = limit(hdot / select(rate == 0.0, 1.0, rate), 0.0, 1.0)
        spare = select(given, lever - sat - found, spare * share)
        rate = select(given | (share < 1.0), hdot, rate)
        throttle = select(given, lever, throttle + spare)
        law = speed.law._replace(u=found, held=found)
        speed = select(given, speed._replace(law=law), speed)
        limited = limit(throttle, *self.checked.throttle_authority)
        return limited, speed, LeverState(found, spare, rate)
