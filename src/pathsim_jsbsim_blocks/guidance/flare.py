"""Landing: flare, touchdown and roll-out, or a go-around."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from .._core.checks import heading, number, optional, positive
from .._core.parameters import parameter
from .._core.ports import numbered
from .._core.units import GRAVITY, KNOT
from ..control.controller import Authority, authority_limits
from ..control.gain_tables import named
from ..control.gains import Gains
from ..control.loops import DEGREES, LateralState, ReferenceState, attitude_loop, wrap
from ..control.pid import PID, clip
from .approach import SLOWEST, BeamState
from .climb_loops import AltitudeLoop
from .hold import GuidedHold, fill
from .vertical import Motion, Vertical, VerticalState

__all__ = ["FlareHold"]

_TREND = 2.0  # time constant of the acceleration, s

_STEEPEST = -10.0  # minimum pitch reference, deg
# maximum bandwidth of the rate of climb, rad/s, and as a fraction of the pitch loop's, Kp / Kr
_BANDWIDTH, _OF_PITCH = 1.0, 0.3
_LIFT_SLOPE = 4.0  # lift-curve slope, g/rad; V / (g times this) is the lag of hdot behind pitch
_DAMPING = 0.22  # gain on the rate of the error, as a fraction of that lag
_SMOOTH = 0.2  # time constant of that rate, s
_GUST = 0.2  # time constant of vertical gusts, s; the pitch angle follows no faster
_RAMP = 15.0  # rate of the pitch reference, deg/s
_PULL = 8.0  # rate of the commanded rate of climb, ft/s2
_TRADE = 0.1  # rate at which a go-around regains its airspeed, 1/s
_FASTER = 1.1  # factor on that airspeed above which a go-around climbs faster
_KEEP = 1.0  # bank per heading error in a go-around, deg/deg
_ACROSS = 45.0  # heading error from the course that begins a go-around, deg
_TRACKING = 0.4  # natural frequency of the distance from the centre line in the flare, rad/s
_DECRAB = 3.0  # time before the touchdown, s
_YAW = 3.0  # rate of the heading reference, deg/s
_YAW_DAMPING = 0.5  # yaw rate gain over that of the heading error, s
_RUDDER = 1.0  # rate of the rudder, 1/s
_IDLE = 0.2  # rate of the throttle towards idle, 1/s
_BALLOON = 10.0  # climb in the flare that begins a go-around, ft
_HOP = 1.0  # height of the wheels above which a bounce is flared again, ft
_CLIMBS = 100.0  # height below which a go-around does not lower the nose, ft
_CLEAR = 30.0  # height above which no tail strike is possible, ft
_LOWER = 2.0  # rate at which the nose is lowered in the roll-out, deg/s
_TURN = 0.3  # integral gain of the course over the ground in the roll-out, 1/s
_STEER = 0.25  # gain of the distance from the centre line in the roll-out, 1/s
_BRAKE = 0.25  # rate of the brakes, 1/s
# ft/s; below it brakes are released: they could tip an aircraft that the wind pushes backwards
_STOPS = 20.0


class FlareState(NamedTuple):
    """State of a `FlareHold`; the first active sample sets references and estimates."""

    vertical: VerticalState = Vertical.START
    lateral: LateralState = LateralState()
    beam: BeamState = BeamState()
    phase: float = 0.0
    integral: float = 0.0  # integral of the climb law, deg
    hdot_cmd: float = 0.0
    hdot: float = 0.0
    lift: float = 0.0  # rate of hdot, ft/s2, smoothed
    theta: float = 0.0  # pitch reference of the roll-out, deg
    lowest: float = 0.0  # minimum pitch reference: the pitch angle at the start of the phase, deg
    psi: float = 0.0  # heading reference, deg
    rudder: float = 0.0
    turn: float = 0.0  # integral of the course error over the ground in the roll-out
    throttle: float = 0.0
    brakes: float = 0.0
    v: float = 0.0  # airspeed, ft/s
    acceleration: float = 0.0  # ft/s2, smoothed
    v_ref: float = 0.0  # airspeed at touchdown or at the start of a go-around, ft/s
    gust: float = 0.0  # sink rate of the air, ft/s, smoothed
    length: float = 0.0  # length of the flare over the ground, ft
    least: float = 0.0  # minimum height in the flare, ft


APPROACH, FLARE, ROLL_OUT, GO_AROUND = 0.0, 1.0, 2.0, 3.0


class FlareInputs(NamedTuple):
    """Inputs of a `FlareHold` at one sample, in the units of its ports."""

    height: float  # height of the wheels
    hdot: float
    theta: float
    alpha: float | None
    psi: float
    r: float
    vc: float
    approach: list[float]  # commands of the approach
    down: bool
    go_around: bool
    off: bool


@fill
@dataclass(eq=False, repr=False)
class FlareHold(GuidedHold):
    """Lands: flare, decrab, idle, touchdown and roll-out; or goes around.

    .. math::
        \\dot h_\\mathrm{cmd} &= -\\frac{h_w}{\\tau} - \\dot h_0 \\\\
        \\theta_\\mathrm{cmd} &= \\theta_0 + \\frac{1}{V} \\left[\\dot h_\\mathrm{cmd}
        + w + \\tau_l (\\ddot h_\\mathrm{cmd} + \\omega e) + \\omega \\int e \\, dt\\right] \\\\
        e &= \\dot h_\\mathrm{cmd} - \\dot h, \\quad w = V (\\theta - \\alpha) - \\dot h

    with the height h_w of the wheels above the runway, and the pitch and roll loops of
    ``PitchHold`` and ``RollHold`` inside, sampled at T. The vertical gust w follows from the angle
    of attack, with ``alpha`` connected; theta_0 grows as the airspeed falls.

    Connect it between the holds of the approach and the aircraft: the ports ``elevator`` to
    ``throttle`` pass the commands of the approach through until the flare begins, when the law
    above commands no more than the present sink rate. The transition is bumpless.

    In the flare the throttle moves to idle, the rudder turns the nose to the runway's course, and a
    bank of at most ``bank_max`` keeps the aircraft on the centre line. If the sink rate is arrested
    early, half of it is commanded again, and the nose is never lower than at the start of the
    flare. The bandwidth omega is at most 1 rad/s, and 0.3 Kp / Kr of the pitch loop; below the
    airspeed range of the gains it decreases with the square of the airspeed. With the wheels on the
    ground it lowers the nose, steers along the centre line with nose wheel and rudder, and brakes;
    the brakes are released as the aircraft stops. The approach's rudder is ignored. A bounce is
    flared again.

    A go-around, at any height and also on the ground, applies full throttle, holds the heading with
    a bank of at most ``bank_max``, and climbs at ``climb``: less if that costs airspeed, more if
    the airspeed is 10 % higher than at its start. Below 100 ft the nose is never lower than at its
    start, unless the angle of attack is at its maximum. On the ground the nose is raised at the
    airspeed of the touchdown.

    If no landings were flown with the gains, or the aircraft lands with them in only some flares, a
    warning with the reason is given once when the block is built.

    A go-around begins automatically if, below the height ``decide``, the aircraft is more than
    ``across_max`` from the centre line or its heading more than 45 deg off ``course``, if the flare
    would begin at more than ``sink_max``, if it is longer than ``float_max``, and if the aircraft
    climbs by 10 ft in it or in a bounce.

    Parameters
    ----------
    gains : str or dict
        as in ``AltitudeHold`` and ``RollHold``: name of a table, or {"altitude": ..., "pitch": ...,
        "roll": ...}
    course : float
        true course of the runway, deg
    gear_height : float
        value of ``h_agl`` with the wheels on the ground, ft
    sink : float
        target sink rate at touchdown, ft/s
    tau : float
        time constant of the flare, s
    bank_max : float
        maximum bank in the flare and in a go-around, deg
    align : float
        rudder per heading error in the flare and on the ground, 1/deg; it increases as the aircraft
        slows down in the roll-out. With 0 the aircraft lands crabbed and is not steered
    climb : float
        rate of climb of the go-around, ft/s
    decide : float
        height below which it goes around automatically, ft
    across_max : float
        maximum distance from the centre line below that height, ft
    sink_max : float
        maximum sink rate at which the flare begins, ft/s
    float_max : float
        maximum length of the flare over the ground, ft
    authority : float or pair
        maximum increment of elevator and ailerons, of full travel
    %(T)s
    %(alpha_max)s
    theta_max : float
        maximum pitch reference up to 30 ft, deg: below the angle of a tail strike

    Inputs
    ------
    h_agl, hdot
        height above the runway in ft, rate of climb in ft/s
    theta, q, psi, phi, p, r
        attitude in deg, rates in deg/s
    vc
        calibrated airspeed in kt
    loc_ft, loc_dist
        outputs ``ft`` and ``dist`` of a ``Localizer``
    elevator, aileron, rudder, throttle
        commands of the approach, passed through until the flare
    wow
        not 0 if a wheel is on the ground
    go_around
        not 0 begins a go-around
    alpha
        angle of attack in deg; if not connected (0), vertical gusts are not corrected for and there
        is no stall protection. On the wheels the protection ends
    off
        0 engaged; otherwise the approach's commands pass through, and a landing or go-around is
        over: the next approach begins

    Outputs
    -------
    elevator, aileron, rudder, throttle
        increments of the commands
    brakes, steering
        0 to 1, and -1 to 1: ``input_properties`` of ``Aircraft``
    phase
        0 approach, 1 flare, 2 roll-out, 3 go-around
    theta_cmd, phi_cmd
        pitch and bank reference, deg
    hdot_cmd
        commanded rate of climb, ft/s

    %(raises)s
    """

    gains: Gains = "c172p"
    course: float = parameter(0.0, heading)
    gear_height: float = parameter(4.0, number, low=0.0)
    sink: float = parameter(2.0, number, above=0.0)
    tau: float = parameter(3.0, number, above=0.0)
    bank_max: float = parameter(4.0, number, low=0.0, high=30.0)
    align: float = parameter(0.05, number, low=0.0)
    climb: float = parameter(10.0, number, above=0.0)
    decide: float = parameter(100.0, number, low=0.0)
    across_max: float = parameter(30.0, number, above=0.0, infinite=True)
    sink_max: float = parameter(math.inf, number, above=0.0, infinite=True)
    float_max: float = parameter(math.inf, number, above=0.0, infinite=True)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    alpha_max: float | None = parameter(None, optional, above=0.0, high=90.0)
    theta_max: float = parameter(10.0, number, low=-90.0, high=90.0)

    measured = (
        *("h_agl", "hdot", "theta", "q", "psi", "phi", "p", "r", "vc"),
        *("loc_ft", "loc_dist", "wow"),
    )
    commands = {"elevator": "", "aileron": "", "rudder": "", "throttle": ""}
    input_port_labels = numbered(
        "h_agl hdot theta q psi phi p r vc loc_ft loc_dist elevator aileron rudder throttle wow "
        "go_around alpha off"
    )
    output_port_labels = numbered(
        "elevator aileron rudder throttle brakes steering phase theta_cmd phi_cmd hdot_cmd"
    )

    START = FlareState()

    def build(self) -> None:
        T, c = self.clock.period, self._checked
        altitude, pitch, roll, envelope = self.gains_of("altitude", "pitch", "roll", "envelope")
        self.vertical = Vertical(
            AltitudeLoop(T, altitude, None, _STEEPEST, None),
            attitude_loop(T, pitch, c.authority, -1.0, self.scheduled),
            self.protection_within(envelope),
        )
        self.roll = attitude_loop(T, roll, c.authority, carry=self.scheduled)
        self.follows(roll=self.roll, **self.vertical.loops)
        table, self._slowest = named(self.gains), 0.0  # KCAS
        if table:
            self._slowest = min(point.speed for point in table.points)
        if table and (table.no_landing or not table.landing):
            text = f"no landings were flown with these gains of the {table.aircraft}, for "
            text += f"{self._slowest:.0f} KCAS and more; below, the controls are less effective"
            self._warn_once("gains", "{}", table.no_landing or text)

    def law(self, u: list[float], state: FlareState) -> tuple[list[float], FlareState]:
        h, hdot, theta, q, psi, phi, p, r, vc, ft, dist = u[:11]
        *approach, wow, go_around, alpha, off = u[11:19]
        self.retune(vc)
        beam, *_ = state.beam.next(ft, dist, self.clock.period, 0.5)
        height, switches = h - self._checked.gear_height, (wow != 0.0, go_around != 0.0, off != 0.0)
        incidence = self.sensed("alpha", alpha)
        port = FlareInputs(height, hdot, theta, incidence, psi, r, vc, approach, *switches)
        last_phase = state.phase
        state = self._in_air(self._phase(state._replace(beam=beam), port), port)
        if last_phase == APPROACH:
            state = self._taken_over(state, port)
        if state.phase != last_phase or last_phase == APPROACH:
            state = self._begun(state, port)
        slow = state.phase == GO_AROUND and port.down and state.v < state.v_ref
        rolls = state.phase == ROLL_OUT or slow

        vertical, motion = self.vertical, Motion(theta, q, h, hdot, vc, incidence)
        bounds, guard = vertical.guard(state.vertical, motion, 0.0, full_throttle=True)
        if rolls and port.down:
            # on the wheels the angle of attack is that of the ground attitude
            bounds = bounds._replace(theta_max=math.inf)
        # set after `retune`, because the flare requires a faster pitch reference than a climb
        vertical.pitch.ramp, vertical.pitch.pid.b = _RAMP, 1.0
        target, state = self._pitch(state, port, rolls)
        elevator, theta_cmd, pitch, cut = vertical.fly(state.vertical, motion, bounds, target)
        bank = self._bank(state, psi)
        aileron, phi_cmd, roll = self.roll.sample(
            state.lateral.roll, phi, p, bank, False, 0.0, False
        )
        steering, state = self._yaw(state, port, rolls)
        throttle, brakes = self._power(state, port.down)

        outputs = [elevator, aileron, state.rudder, throttle, brakes, steering]
        if state.phase == APPROACH:
            outputs = [*approach, 0.0, 0.0]
        state = state._replace(
            vertical=state.vertical._replace(pitch=pitch, guard=guard, cut=cut),
            lateral=state.lateral._replace(roll=roll),
            throttle=throttle,
            brakes=brakes,
        )
        return [*outputs, state.phase, theta_cmd, phi_cmd, state.hdot_cmd], state

    def _steepest(self, height: float) -> float:
        """Minimum rate of climb of the flare at a height, ft/s."""
        return min(-height / self._checked.tau, 0.0) - self._checked.sink

    def _phase(self, state: FlareState, port: FlareInputs) -> FlareState:
        """The state in the present or the next phase."""
        c, last_phase, phase = self._checked, state.phase, state.phase
        height, hdot = port.height, port.hdot
        off_course = abs(wrap(port.psi - c.course)) > _ACROSS
        low = hdot <= self._steepest(height) or height <= c.sink * c.tau
        if phase == APPROACH and low:
            phase = FLARE
        if phase == FLARE and port.down:
            phase = ROLL_OUT
        elif phase == ROLL_OUT and not port.down and height > _HOP:
            phase = FLARE
        length, least = state.length, height
        if last_phase == FLARE:
            length += self.clock.period * state.beam.closure
            least = min(state.least, height)
        astray = (
            (height < c.decide and (abs(state.beam.ft) > c.across_max or off_course))
            or (last_phase == APPROACH and low and hdot < -c.sink_max)
            or length > c.float_max
            or height > least + _BALLOON
        )
        if port.go_around or (phase < ROLL_OUT and astray):
            phase = GO_AROUND
        if port.off:
            phase, length = APPROACH, 0.0
        return state._replace(phase=phase, length=length, least=least)

    def _in_air(self, state: FlareState, port: FlareInputs) -> FlareState:
        """The state with the airspeed and the vertical gust of the sample."""
        T, first = self.clock.period, state.v == 0.0
        v = max(port.vc * KNOT, SLOWEST)
        change = 0.0 if first else v - state.v
        acceleration = state.acceleration
        acceleration += -math.expm1(-T / _TREND) * (change / T - acceleration)
        gust = 0.0
        if port.alpha is not None:
            # rate of climb through the air less rate of climb
            sink = v / DEGREES * (port.theta - port.alpha) - port.hdot
            gain = 1.0 if first else -math.expm1(-T / _GUST)
            gust = state.gust + gain * (sink - state.gust)
        integral = state.integral
        if state.phase != GO_AROUND:
            # at the same lift the angle of attack varies inversely with the square of the airspeed
            integral -= 2.0 * DEGREES / _LIFT_SLOPE * change / v
        return state._replace(
            v=v,
            acceleration=acceleration,
            gust=gust,
            integral=integral,
            v_ref=state.v_ref if state.phase >= ROLL_OUT else v,
        )

    def _taken_over(self, state: FlareState, port: FlareInputs) -> FlareState:
        """The state that continues from the commands of the approach."""
        elevator, aileron, rudder, throttle = port.approach
        return state._replace(
            vertical=state.vertical._replace(pitch=ReferenceState(law=PID.holding(-elevator))),
            lateral=state.lateral._replace(roll=ReferenceState(law=PID.holding(aileron))),
            lowest=port.theta,
            v_ref=state.v,
            psi=port.psi,
            rudder=rudder,
            throttle=throttle,
        )

    def _begun(self, state: FlareState, port: FlareInputs) -> FlareState:
        """The state of a phase that begins at the present pitch angle and rate of climb."""
        climbs = state.phase == GO_AROUND
        return state._replace(
            integral=port.theta - DEGREES * (port.hdot + state.gust) / state.v,
            hdot_cmd=port.hdot,
            theta=port.theta,
            lowest=port.theta if climbs else state.lowest,
        )

    def _bandwidth(self, v: float) -> float:
        """Bandwidth of the rate of climb in rad/s at an airspeed in ft/s: the pitch loop limits it.

        Below the minimum airspeed of the gains the elevator is less effective than in their design.
        """
        pitch = self.vertical.pitch.pid
        if pitch.Kr <= 0.0:
            return _BANDWIDTH
        slower = min(v / max(KNOT * self._slowest, 1.0), 1.0)
        return min(_BANDWIDTH, _OF_PITCH * pitch.Kp / pitch.Kr * slower**2)

    def _pitch(self, state: FlareState, port: FlareInputs, rolls: bool) -> tuple[float, FlareState]:
        """Pitch angle of the phase, and the next state."""
        c, T, v, height, hdot = self._checked, self.clock.period, state.v, port.height, port.hdot
        climbs, steepest = state.phase == GO_AROUND, self._steepest(height)
        if climbs:
            # the rate of climb that regains the airspeed at the start of the go-around
            spare = hdot + v / GRAVITY * (state.acceleration + _TRADE * (v - state.v_ref))
            fast = spare - v / GRAVITY * _TRADE * (_FASTER - 1.0) * state.v_ref
            target = clip(spare, 0.3 * c.climb, max(fast, c.climb))
        else:
            # the upper limit commands half of the sink again if it was arrested early
            target = clip(hdot, steepest, 0.5 * (steepest - c.sink))
        step = clip(target - state.hdot_cmd, -_PULL * T, _PULL * T)
        hdot_cmd = state.hdot_cmd + step
        error, lift = hdot_cmd - hdot, state.lift
        if state.hdot != 0.0:
            lift += -math.expm1(-T / _SMOOTH) * ((hdot - state.hdot) / T - lift)
        lag = v / (GRAVITY * _LIFT_SLOPE)
        feed = hdot_cmd + state.gust
        if not climbs and hdot < steepest:
            feed += lag * -hdot / c.tau
        bandwidth = self._bandwidth(v)
        feed += lag * (bandwidth * error + _DAMPING * (step / T - lift))
        command = state.integral + DEGREES / v * feed
        altitude, highest = self.vertical.altitude, c.theta_max
        lowest = min(state.lowest, c.theta_max)
        if climbs and height > _CLEAR:
            highest = altitude.theta_max
        if climbs and height > _CLIMBS:
            lowest = altitude.pid.low
        # anti-windup: a reference beyond a saturated elevator would have to return first
        pitch, loop = state.vertical.pitch, self.vertical.pitch.pid
        if pitch.law.u >= loop.high:
            highest = min(highest, pitch.reference)
        elif pitch.law.u <= loop.low:
            lowest = max(lowest, pitch.reference)
        theta = min(max(command, lowest), highest)
        change = bandwidth * T * (DEGREES / v * error + theta - command)
        if rolls:
            hdot_cmd = hdot
            theta = max(state.theta - (_LOWER * T if port.down else 0.0), min(state.theta, 0.0))
        return theta, state._replace(
            integral=state.integral + change,
            hdot_cmd=hdot_cmd,
            theta=theta,
            hdot=hdot,
            lift=lift,
        )

    def _bank(self, state: FlareState, psi: float) -> float:
        """Bank in deg: to the centre line in the flare, to the heading in a go-around."""
        limit = self._checked.bank_max
        if state.phase == FLARE:
            pull = _TRACKING * (_TRACKING * state.beam.ft + 1.4 * state.beam.aside)
            return clip(-DEGREES / GRAVITY * pull, -limit, limit)
        if state.phase == GO_AROUND:
            return clip(_KEEP * wrap(state.psi - psi), -limit, limit)
        return 0.0

    def _yaw(self, state: FlareState, port: FlareInputs, rolls: bool) -> tuple[float, FlareState]:
        """Steering of the nose wheel, and the state with the rudder and the heading's reference."""
        c, T, beam = self._checked, self.clock.period, state.beam
        target, psi_cmd, align, turn = c.course, state.psi, c.align, 0.0
        speed = max(beam.closure, SLOWEST)
        if rolls:
            target -= clip(DEGREES * _STEER * beam.ft / speed, -5.0, 5.0)
            # nose wheel and rudder become less effective as the aircraft slows down
            align *= state.v_ref / state.v
        if rolls or port.height < _DECRAB * max(-port.hdot, c.sink):
            psi_cmd += clip(wrap(target - psi_cmd), -_YAW * T, _YAW * T)
        psi_cmd, error = wrap(psi_cmd), 0.0
        if rolls or state.phase != GO_AROUND:
            error = align * (wrap(port.psi - psi_cmd) + _YAW_DAMPING * port.r)
        if rolls:
            # without the approach's rudder: on the wheels its sideslip integral winds up
            off = wrap(c.course + DEGREES * math.atan(beam.aside / speed) - target)
            turn = clip(state.turn + _TURN * align * off * T, -1.0, 1.0)
        command = error + (turn if rolls else port.approach[2])
        rudder = state.rudder + clip(command - state.rudder, -_RUDDER * T, _RUDDER * T)
        steering = clip(-command, -1.0, 1.0) if rolls else 0.0
        return steering, state._replace(rudder=clip(rudder, -1.0, 1.0), psi=psi_cmd, turn=turn)

    def _power(self, state: FlareState, down: bool) -> tuple[float, float]:
        """Throttle and brakes."""
        T, brakes = self.clock.period, 0.0
        if state.phase == ROLL_OUT and down and state.theta <= 0.0:
            brakes = min(state.brakes + _BRAKE * T, clip(state.beam.closure / _STOPS, 0.0, 1.0))
        throttle = 1.0 if state.phase == GO_AROUND else max(state.throttle - _IDLE * T, -1.0)
        return throttle, brakes
