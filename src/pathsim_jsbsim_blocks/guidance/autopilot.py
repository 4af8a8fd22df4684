"""`Autopilot`: all holds in one block."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from .._core.checks import heading, number, optional, positive
from .._core.parameters import parameter
from .._core.ports import numbered
from ..control.airspeeds import ComplementaryAirspeed
from ..control.controller import Authority, ReferenceKind, authority_limits, reference_kind
from ..control.gains import Gains
from ..control.loops import (
    HeadingLoop,
    LateralState,
    Reference,
    ReferenceLoop,
    ReferenceState,
    SpeedLoop,
    YawLoop,
    YawState,
    attitude_loop,
)
from ..control.pid import clip
from .climb_loops import SpeedOnPitchLoop
from .hold import GuidedHold, fill
from .protection import Allowed, Protection, ProtectionState, share_of_climb
from .vertical import ClimbState, Motion, Vertical, VerticalState


class AutopilotInputs(NamedTuple):
    """Inputs of an `Autopilot` at one sample, in the order of its ports."""

    theta: float
    phi: float
    psi: float
    p: float
    q: float
    r: float
    h: float
    hdot: float
    vc: float
    theta_ref: float
    h_ref: float
    phi_ref: float
    psi_ref: float
    vc_ref: float
    pitch_mode: float
    roll_mode: float
    pitch_off: float
    roll_off: float
    speed_off: float
    yaw_off: float
    elev_sat: float
    ail_sat: float
    thr_sat: float
    alpha: float
    beta: float
    v_mode: float
    hdot_ref: float
    thr_ref: float
    h_agl: float
    vt: float
    nx: float
    nz: float


class LeverState(NamedTuple):
    """State of the throttle while the elevator holds the airspeed."""

    initial: float = 0.0  # increment at engagement of the mode
    spare: float = 0.0  # increment beyond that
    rate: float = 0.0  # rate of climb with it, ft/s


class AutopilotState(NamedTuple):
    """State of an `Autopilot`."""

    vertical: VerticalState = Vertical.START
    lateral: LateralState = LateralState()
    speed: ReferenceState = SpeedLoop.START
    yaw: YawState = YawLoop.START
    climb: ClimbState = ClimbState()
    v_pitch: ReferenceState = SpeedOnPitchLoop.START  # airspeed loop of the elevator
    lever: LeverState = LeverState()
    airspeed: float = ComplementaryAirspeed.START  # kt
    rate: float = 0.0  # rate of climb to feed forward, ft/s


@fill
@dataclass(eq=False, repr=False)
class Autopilot(GuidedHold):
    """Autopilot with autothrottle and yaw damper in one block; the fastest to simulate.

    The loops are those of ``AltitudeHold`` or ``PitchHold``, ``HeadingHold`` or ``RollHold``,
    ``AirspeedHold`` and ``YawDamper``, sampled at T. With every port at 0 it holds the altitude,
    heading and airspeed at engagement. Mode changes are bumpless: a new mode holds the values at
    its engagement plus its reference port.

    With ``alpha`` connected and a gain table that has limits of the flight envelope, references are
    limited so that no command leads to a stall, to the ground or beyond the maximum airspeed; then
    bank is reduced before height, and height before airspeed. The minimum airspeed follows from the
    angle of attack, so it allows for weight, flaps and load factor.

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
        maximum bank reference of the heading hold in deg
    hdot_max : float, optional
        maximum rate of climb and descent of the altitude hold, ft/s; default is the gain table's,
        faster for descents if the sink rate at idle allows it
    theta_min : float
        minimum pitch reference of the altitude hold in deg
    theta_max : float, optional
        maximum pitch reference of the altitude hold in deg; default is the gain table's
    elevator_authority : float or pair
        maximum elevator increment, of full travel
    aileron_authority : float or pair
        maximum aileron increment, of full travel
    rudder_authority : float or pair
        maximum rudder increment, of full travel
    throttle_authority : float or pair
        maximum throttle increment, of full travel

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
        angle of attack in deg; if not connected (0), there is no stall protection
    beta
        angle of sideslip in deg; if not connected (0), turns are not coordinated, and the sideslip
        after an engine failure remains
    v_mode
        with ``pitch_mode`` at 0: 0 holds the altitude, 1 the rate of climb, 2 the airspeed with
        the elevator at fixed throttle; 1 and 2 until the altitude ``h_ref``, if commanded, is
        captured
    hdot_ref, thr_ref
        added to the parameters, ft/s and full travel
    h_agl
        height above the ground in ft: with ``alpha`` connected, no descent below 100 ft; if not
        connected (0), the height is not limited
    vt
        true airspeed in ft/s, to estimate the bank of straight flight, after an engine failure for
        example; if not connected (0), that bank is the gain table's
    nx, nz
        load factors in g: with ``alpha`` and ``vt`` connected, the throttle follows the airspeed
        without gusts, as in ``AirspeedHold``

    Outputs
    -------
    elevator, aileron, rudder, throttle
        increments of the commands; positive elevator is nose **down**, positive aileron rolls right
    theta_cmd, phi_cmd, vc_cmd
        references on their ramps, deg, deg and kt
    hdot_cmd
        commanded rate of climb, ft/s; 0 in pitch hold
    captured
        1 from the capture of the altitude on, otherwise 0

    %(raises)s
    """

    gains: Gains = "c172p"
    theta_ref: float | None = parameter(None, optional, low=-90.0, high=90.0)
    h_ref: float | None = parameter(None, optional, low=-2000.0, high=1e6)
    phi_ref: float | None = parameter(None, optional, low=-90.0, high=90.0)
    psi_ref: float | None = parameter(None, optional, of=heading)
    vc_ref: float | None = parameter(None, optional, above=0.0)
    bank_max: float = parameter(25.0, number, above=0.0, high=80.0)
    hdot_max: float | None = parameter(None, optional, above=0.0)
    theta_min: float = parameter(-10.0, number, low=-90.0, high=90.0)
    theta_max: float | None = parameter(None, optional, low=-90.0, high=90.0)
    elevator_authority: Authority = parameter(1.0, authority_limits)
    aileron_authority: Authority = parameter(1.0, authority_limits)
    rudder_authority: Authority = parameter(1.0, authority_limits)
    throttle_authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: ReferenceKind = parameter("increment", reference_kind)
    alpha_max: float | None = parameter(None, optional, above=0.0, high=90.0)
    hdot_ref: float | None = parameter(None, optional)
    thr_ref: float | None = parameter(None, optional, low=-1.0, high=1.0)

    measured = ("theta", "phi", "psi", "p", "q", "r", "h", "hdot", "vc")
    # no warning for an unconnected rudder: an aircraft may have its own yaw damper
    commands = {"elevator": "pitch_off", "aileron": "roll_off", "throttle": "speed_off"}
    input_port_labels = numbered(" ".join(AutopilotInputs._fields))
    output_port_labels = numbered(
        "elevator aileron rudder throttle theta_cmd phi_cmd vc_cmd hdot_cmd captured"
    )

    START = AutopilotState()

    def build(self) -> None:
        pitch, roll, heading, altitude, speed, yaw, envelope = self.gains_of(
            "pitch", "roll", "heading", "altitude", "speed", "yaw", "envelope"
        )
        T, c, carry = self.clock.period, self._checked, self.scheduled
        self.vertical = Vertical(
            self.altitude_loop(altitude),
            attitude_loop(T, pitch, c.elevator_authority, -1.0, carry),
            self.protection_within(envelope),
        )
        self.heading = HeadingLoop(T, heading, c.bank_max)
        self.roll = attitude_loop(T, roll, c.aileron_authority, carry=carry)
        self.speed = SpeedLoop(T, speed, c.throttle_authority, carry)
        self.airspeed = ComplementaryAirspeed(T)
        self.yaw = YawLoop(T, yaw, c.rudder_authority)
        level = self.vertical.altitude
        self.on_pitch = SpeedOnPitchLoop(T, speed.ramp, level.pid.low, level.theta_max)
        lateral = {"roll": self.roll, "heading": self.heading, "yaw": self.yaw}
        self.follows(speed=self.speed, **lateral, **self.vertical.loops)

    def law(self, u: list[float], state: AutopilotState) -> tuple[list[float], AutopilotState]:
        port = AutopilotInputs(*u[:32])
        h, vc, alpha = port.h, port.vc, self.sensed("alpha", port.alpha)
        pitching, pitch_off = port.pitch_mode != 0.0, port.pitch_off != 0.0
        self.retune(vc, h)
        vertical, loops = self.vertical, state.vertical
        motion = Motion(port.theta, port.q, h, port.hdot, vc, alpha, pitch_off, port.elev_sat)
        mode = 0.0 if pitching else port.v_mode
        captured = mode == state.climb.mode and state.climb.captured
        on_pitch = mode == 2.0 and not captured and not pitch_off

        inertial, next_airspeed = self.airspeed.sample(
            *(state.airspeed, vc, port.nx, port.nz, port.alpha),
            *(port.beta, port.theta, port.phi, port.vt),
            connected=self.inputs.wired >= ComplementaryAirspeed.SIGNALS,
        )
        airspeed = self.airspeed.within(inertial, vc)
        # a held pitch angle has no commanded rate of climb
        measures = pitching or pitch_off
        feed = port.hdot if measures or not state.speed.law.has_slope else state.rate

        # one airspeed reference, whichever of throttle and elevator holds it
        engaged = state.v_pitch if state.v_pitch.law.engaged else state.speed
        vc_cmd = self.speed.loop.reference(engaged, airspeed)
        bounds, guard = vertical.guard(
            loops,
            motion,
            vc,
            full_throttle=port.thr_sat > 0.0,
            vc_cmd=vc_cmd,
            hold_pitch=pitching,
            phi=port.phi,
            h_agl=self.sensed("h_agl", port.h_agl),
            eases=mode == 0.0 or captured,
            airspeed=inertial,
        )
        throttle, vc_cmd, rate, speed, v_pitch, lever = self._airspeed(
            state, port, engaged, bounds, on_pitch, airspeed, feed
        )

        protection = vertical.protection(alpha)
        # the protection already reduces a climb at low airspeed
        fraction = 1.0 if protection else share_of_climb(vc, vc_cmd)
        elevator, theta_cmd, hdot_cmd, levels, climb = self._elevator(
            state, port, motion, bounds, guard, mode, rate, fraction
        )
        aileron, phi_cmd, lateral = self._ailerons(state.lateral, port, bounds, protection, guard)
        beta, yaw_off = self.sensed("beta", port.beta), port.yaw_off != 0.0
        rudder, yaw = self.yaw.sample(state.yaw, port.r, yaw_off, beta, port.p, port.phi)
        outputs = [elevator, aileron, rudder, throttle, theta_cmd, phi_cmd, vc_cmd, hdot_cmd]
        state = AutopilotState(
            vertical=levels,
            lateral=lateral,
            speed=speed,
            yaw=yaw,
            climb=climb,
            v_pitch=v_pitch,
            lever=lever,
            airspeed=next_airspeed,
            rate=feed if measures else self.speed.follow(feed, hdot_cmd),
        )
        return [*outputs, float(climb.captured)], state

    def _airspeed(
        self,
        state: AutopilotState,
        port: AutopilotInputs,
        engaged: ReferenceState,
        bounds: Allowed,
        on_pitch: bool,
        airspeed: float,
        feed: float,
    ) -> tuple[float, float, Reference, ReferenceState, ReferenceState, LeverState]:
        """Throttle increment, airspeed reference in kt, commanded rate of climb, and next states.

        The throttle holds ``airspeed``, which is without gusts, with the rate of climb ``feed`` fed
        forward. While ``on_pitch``, the elevator holds the measured airspeed by a rate of climb.
        """
        h, hdot, vc, off = port.h, port.hdot, port.vc, port.speed_off != 0.0
        reference = self.wanted("vc_ref", port.vc_ref, vc)
        target, keeps = self.speed.loop.towards(engaged, airspeed, reference)
        target = self.airspeed_within(bounds, target, vc)
        throttle, vc_cmd, speed = self.speed.sample(
            state.speed,
            airspeed,
            feed,
            target,
            keeps,
            port.thr_sat,
            off or on_pitch,
            boost=bounds.boost,
            feed=bounds.feed,
        )
        climb = self.wanted("hdot_ref", port.hdot_ref)
        lever_ref, v_pitch = None, ReferenceLoop.START
        if on_pitch:
            cut = state.vertical.altitude.cut
            rate, vc_cmd, v_pitch = self.on_pitch.sample(
                state.v_pitch, vc, h, hdot, target, keeps, cut, False
            )
            climb = rate, 0.0
            lever_ref = None if off else self._lever_reference(port.thr_ref, bounds, rate)
        # pass the airspeed at engagement from one loop to the other, so that both hold the same
        if state.v_pitch.law.engaged:
            speed = speed._replace(initial=engaged.initial)
        elif on_pitch and state.speed.law.engaged:
            v_pitch = v_pitch._replace(initial=engaged.initial)
        throttle, speed, lever = self._lever(state, throttle, speed, hdot, port.thr_sat, lever_ref)
        return throttle, vc_cmd, climb, speed, v_pitch, lever

    def _elevator(
        self,
        state: AutopilotState,
        port: AutopilotInputs,
        motion: Motion,
        bounds: Allowed,
        guard: ProtectionState,
        mode: float,
        rate: Reference,
        fraction: float,
    ) -> tuple[float, float, float, VerticalState, ClimbState]:
        """Elevator increment, pitch reference in deg, rate of climb in ft/s, and next states.

        ``fraction`` is that of the rate of climb towards a held altitude.
        """
        vertical, loops, pitching = self.vertical, state.vertical, port.pitch_mode != 0.0
        target, hdot_cmd, altitude, climb = vertical.for_climb(
            loops,
            motion,
            bounds,
            reference=self.wanted("h_ref", port.h_ref, port.h),
            idle=motion.off or pitching,
            last=state.climb,
            mode=mode,
            rate=rate,
            fraction=fraction,
        )
        keeps = False
        if pitching:
            reference = self.wanted("theta_ref", port.theta_ref)
            target, keeps = vertical.pitch.towards(loops.pitch, port.theta, reference)
        elevator, theta_cmd, pitch, cut = vertical.fly(loops, motion, bounds, target, keeps)
        return elevator, theta_cmd, hdot_cmd, VerticalState(altitude, pitch, guard, cut), climb

    def _ailerons(
        self,
        state: LateralState,
        port: AutopilotInputs,
        bounds: Allowed,
        protection: Protection | None,
        guard: ProtectionState,
    ) -> tuple[float, float, LateralState]:
        """Aileron increment, bank reference in deg, and the next state."""
        rolling, off = port.roll_mode != 0.0, port.roll_off != 0.0
        bank, heading = self.heading.sample(
            state.heading,
            port.psi,
            self.wanted("psi_ref", port.psi_ref),
            idle=off or rolling,
            phi=port.phi,
            vt=port.vt,
        )
        keeps = False
        if rolling:
            reference = self.wanted("phi_ref", port.phi_ref)
            bank, keeps = self.roll.towards(state.roll, port.phi, reference)
        if protection:
            bank = protection.bank(bounds, guard, bank, port.phi)
        aileron, phi_cmd, roll = self.roll.sample(
            state.roll, port.phi, port.p, bank, keeps, port.ail_sat, off
        )
        return aileron, phi_cmd, LateralState(heading, roll)

    def _lever_reference(self, thr_ref: float, bounds: Allowed, rate: float) -> Reference:
        """The commanded throttle, reduced above the maximum airspeed; increased near the minimum if
        the rate of climb that would hold the airspeed is not allowed.
        """
        target, increment = self.wanted("thr_ref", thr_ref)
        command = (target or 0.0) + increment
        if abs(command) > 1.0:
            self._warn_once(
                "thr_ref",
                "thr_ref is {:g}; it is an increment of the throttle, whose range is 0 to 1",
                command,
            )
        boost = bounds.boost if rate < bounds.climb_min else min(bounds.boost, 0.0)
        return target, increment + boost

    def _lever(
        self,
        state: AutopilotState,
        throttle: float,
        speed: ReferenceState,
        hdot: float,
        sat: float,
        reference: Reference | None,
    ) -> tuple[float, ReferenceState, LeverState]:
        """Throttle, from ``reference`` while the elevator holds the airspeed, and the next states.

        Afterwards the loop continues from the throttle before the climb. The increment beyond that
        sustains the climb, so it is removed in proportion to the rate of climb.
        """
        initial, spare, rate = state.lever
        if not state.v_pitch.law.engaged:
            initial = state.speed.law.u + spare
        low, high = self._checked.throttle_authority
        if reference:
            target, increment = reference
            throttle = (initial if target is None else target) + increment
            spare = throttle - sat - initial
            speed = speed._replace(law=speed.law._replace(u=initial, memory=initial))
            return clip(throttle, low, high), speed, LeverState(initial, spare, hdot)
        fraction = clip(hdot / (rate or 1.0), 0.0, 1.0)
        spare *= fraction
        if fraction < 1.0:
            rate = hdot
        return clip(throttle + spare, low, high), speed, LeverState(initial, spare, rate)
