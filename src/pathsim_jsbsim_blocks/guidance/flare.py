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

_TREND = 2.0  # s, time constant of the acceleration

_STEEPEST = -10.0  # deg, pitch reference
# rad/s, of the rate of climb, and of Kp / Kr of the pitch loop, about its bandwidth
_BANDWIDTH, _OF_PITCH = 1.0, 0.3
_LIFT_SLOPE = 4.0  # g per rad of alpha; V over g times this is the lag of hdot behind the pitch
_DAMPING = 0.22  # of that lag, gain on the rate of the error
_SMOOTH = 0.2  # s, time constant of that rate
_GUST = 0.2  # s, time constant of vertical gusts; the pitch angle follows no faster
_RAMP = 15.0  # deg/s, of the pitch reference
_PULL = 8.0  # ft/s2, of the rate of climb demanded
_TRADE = 0.1  # 1/s, with which a go-around regains its airspeed
_FASTER = 1.1  # of that airspeed, beyond which it climbs faster
_KEEP = 1.0  # deg of bank per deg of heading, in a go-around
_ACROSS = 45.0  # deg, of the heading off the course
_TRACKING = 0.4  # rad/s, natural frequency of the distance from the centre line in the flare
_DECRAB = 3.0  # s before the touchdown
_YAW = 3.0  # deg/s, of the heading reference
_YAW_DAMPING = 0.5  # s
_RUDDER = 1.0  # 1/s, of the rudder
_IDLE = 0.2  # 1/s, of the throttle
_BALLOON = 10.0  # ft, climb in the flare that begins a go-around
_HOP = 1.0  # ft, height of the wheels from which a bounce is flown
_CLIMBS = 100.0  # ft, below which a go-around does not lower its nose
_CLEAR = 30.0  # ft, height above which no tail strikes
_LOWER = 2.0  # deg/s, of the nose in the roll-out
_TURN = 0.3  # 1/s, of the integral of the course over the ground in the roll-out
_STEER = 0.25  # 1/s, of the distance from the centre line in the roll-out
_BRAKE = 0.25  # 1/s
# ft/s, below which the brakes ease: they would tip an aircraft that the wind pushes back
_STOPS = 20.0


class FlareState(NamedTuple):
    """State of a `FlareHold`; what is not known yet follows from the first active sample."""

    vertical: VerticalState = Vertical.START
    lateral: LateralState = LateralState()
    beam: BeamState = BeamState()
    phase: float = 0.0
    integral: float = 0.0  # of the climb law, deg
    hdot_cmd: float = 0.0
    hdot: float = 0.0
    lift: float = 0.0  # rate of hdot, ft/s2, smoothed
    theta: float = 0.0  # reference of the roll-out, deg
    lowest: float = 0.0  # pitch reference in the flare: that at its beginning, deg
    psi: float = 0.0  # reference of the heading, deg
    rudder: float = 0.0
    turn: float = 0.0  # integral of the course over the ground, on the wheels
    throttle: float = 0.0
    brakes: float = 0.0
    v: float = 0.0  # airspeed, ft/s
    acceleration: float = 0.0  # smoothed
    kept: float = 0.0  # airspeed at the beginning of a go-around, ft/s
    gust: float = 0.0  # air that sinks, ft/s, smoothed
    floated: float = 0.0  # length of the flare over the ground, ft
    least: float = 0.0  # height reached in the flare, ft


APPROACH, FLARE, ROLL_OUT, GO_AROUND = 0.0, 1.0, 2.0, 3.0


class Seen(NamedTuple):
    """What a `FlareHold` measures and is told at a sample, in the units of its ports."""

    height: float  # of the wheels
    hdot: float
    theta: float
    alpha: float
    psi: float
    r: float
    vc: float
    given: list[float]  # commands of the approach
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
    ``PitchHold`` and ``RollHold`` inside, sampled at T. The vertical gust w is known from the angle
    of attack, with the port ``alpha`` wired; theta_0 grows as the airspeed falls.

    It stands between the holds of the approach and the aircraft: the ports ``elevator`` to
    ``throttle`` are theirs, and pass through until the flare begins, where the law above asks for
    no more sink than there is. It takes over without a bump.

    In the flare the throttle moves to idle, the rudder turns the nose to the runway's course, and a
    bank of at most ``bank_max`` keeps the aircraft on the centre line. Of a sink that has ended
    earlier than the law above asks, half is asked for again, and the nose is never lower than at
    the beginning. The bandwidth omega is at most 1 rad/s, and 0.3 Kp / Kr of the pitch loop; below
    the airspeeds that the gains are for it falls with the square of the airspeed. With the wheels
    on the ground it lowers the nose, steers along the centre line with nose wheel and rudder, and
    brakes; the brakes ease to none at the stop. The approach's rudder is left out. A bounce is
    flared again.

    A go-around, at any height and on the ground too, applies full throttle, keeps the heading with
    a bank of at most ``bank_max``, and climbs at ``climb``: less where that costs airspeed, more
    where the airspeed is 10 % higher than at the beginning. Below 100 ft the nose is never lower
    than at its beginning, unless the angle of attack is at its limit. On the ground it is raised at
    the airspeed of the touchdown.

    Gains with which no landings were flown warn once when the block is made, as do those with which
    an aircraft lands in some flares only, with the reason.

    It begins by itself where, below the height ``decide``, the aircraft is more than ``across_max``
    beside the centre line or heads more than 45 deg off ``course``, where the flare would begin at
    more than ``sink_max``, where it is longer than ``float_max``, and where it climbs by 10 ft, in
    a bounce too.

    Parameters
    ----------
    gains : str or dict
        as in ``AltitudeHold`` and ``RollHold``: name of a table, or {"altitude": ..., "pitch": ...,
        "roll": ...}
    course : float
        true course of the runway, deg
    gear_height : float
        the port ``h_agl`` with the wheels on the ground, ft
    sink : float
        sink rate of the touchdown that the flare aims at, ft/s
    tau : float
        time constant of the flare, s
    bank_max : float
        largest bank in the flare and in a go-around, deg
    align : float
        rudder per heading error in the flare and on the ground, 1/deg; it grows as the roll-out
        slows down. 0 lands with the crab angle, and does not steer
    climb : float
        rate of climb of the go-around, ft/s
    decide : float
        height below which it goes around by itself, ft
    across_max : float
        largest distance from the centre line there, ft
    sink_max : float
        largest sink rate at which the flare begins, ft/s
    float_max : float
        largest length of the flare over the ground, ft
    authority : float or pair
        largest increment of elevator and ailerons, of full travel
    %(T)s
    %(alpha_max)s
    theta_max : float
        highest pitch reference up to 30 ft, deg: below the angle at which the tail strikes

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
        not 0 with a wheel on the ground
    go_around
        not 0 begins a go-around
    alpha
        angle of attack in deg; without a wire (0) vertical gusts are not countered, and there is no
        protection from the stall, which ends on the wheels
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
        rate of climb demanded, ft/s

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
            none = f"no landings were flown with these gains of the {table.aircraft}, for "
            none += f"{self._slowest:.0f} KCAS and more; below, the controls have less effect"
            self._warn_once("gains", "{}", table.no_landing or none)

    def law(self, u: list[float], state: FlareState) -> tuple[list[float], FlareState]:
        h, hdot, theta, q, psi, phi, p, r, vc, ft, dist, *given, wow, go_around, alpha, off = u[:19]
        self.retune(vc)
        beam, *_ = state.beam.next(ft, dist, self.clock.period, 0.5)
        height, switches = h - self._checked.gear_height, (wow != 0.0, go_around != 0.0, off != 0.0)
        seen = Seen(height, hdot, theta, alpha, psi, r, vc, given, *switches)
        before = state.phase
        state = self._in_air(self._phase(state._replace(beam=beam), seen), seen)
        if before == APPROACH:
            state = self._taken_over(state, seen)
        if state.phase != before or before == APPROACH:
            state = self._begun(state, seen)
        slow = state.phase == GO_AROUND and seen.down and state.v < state.kept
        rolls = state.phase == ROLL_OUT or slow

        vertical, now = self.vertical, Motion(theta, q, h, hdot, vc, alpha)
        allowed, guard = vertical.guard(state.vertical, now, 0.0, full_throttle=True)
        if rolls and seen.down:
            # on the wheels an angle of attack shows no stall
            allowed = allowed._replace(theta_max=math.inf)
        # after `retune`: the flare is flown faster than a climb
        vertical.pitch.ramp, vertical.pitch.pid.b = _RAMP, 1.0
        wanted, state = self._pitch(state, seen, rolls)
        elevator, theta_cmd, pitch, cut = vertical.fly(state.vertical, now, allowed, wanted)
        bank = self._bank(state, psi)
        aileron, phi_cmd, roll = self.roll.sample(
            state.lateral.roll, phi, p, bank, False, 0.0, False
        )
        steering, state = self._yaw(state, seen, rolls)
        throttle, brakes = self._power(state, seen.down)

        outputs = [elevator, aileron, state.rudder, throttle, brakes, steering]
        if state.phase == APPROACH:
            outputs = [*given, 0.0, 0.0]
        state = state._replace(
            vertical=state.vertical._replace(pitch=pitch, guard=guard, cut=cut),
            lateral=state.lateral._replace(roll=roll),
            throttle=throttle,
            brakes=brakes,
        )
        return [*outputs, state.phase, theta_cmd, phi_cmd, state.hdot_cmd], state

    def _steepest(self, height: float) -> float:
        """Lowest rate of climb of the flare at a height, ft/s."""
        return min(-height / self._checked.tau, 0.0) - self._checked.sink

    def _phase(self, state: FlareState, seen: Seen) -> FlareState:
        """The state in the phase that begins or goes on."""
        c, before, phase = self._checked, state.phase, state.phase
        height, hdot = seen.height, seen.hdot
        across = abs(wrap(seen.psi - c.course)) > _ACROSS
        low = hdot <= self._steepest(height) or height <= c.sink * c.tau
        if phase == APPROACH and low:
            phase = FLARE
        if phase == FLARE and seen.down:
            phase = ROLL_OUT
        elif phase == ROLL_OUT and not seen.down and height > _HOP:
            phase = FLARE
        floated, least = state.floated, height
        if before == FLARE:
            floated += self.clock.period * state.beam.along
            least = min(state.least, height)
        astray = (
            (height < c.decide and (abs(state.beam.ft) > c.across_max or across))
            or (before == APPROACH and low and hdot < -c.sink_max)
            or floated > c.float_max
            or height > least + _BALLOON
        )
        if seen.go_around or (phase < ROLL_OUT and astray):
            phase = GO_AROUND
        if seen.off:
            phase, floated = APPROACH, 0.0
        return state._replace(phase=phase, floated=floated, least=least)

    def _in_air(self, state: FlareState, seen: Seen) -> FlareState:
        """The state with the airspeed and the vertical gust of the sample."""
        T, first = self.clock.period, state.v == 0.0
        v = max(seen.vc * KNOT, SLOWEST)
        gained = 0.0 if first else v - state.v
        acceleration = state.acceleration
        acceleration += -math.expm1(-T / _TREND) * (gained / T - acceleration)
        gust = 0.0
        if seen.alpha != 0.0:
            # what the aircraft climbs through the air less what it climbs
            sinks = v / DEGREES * (seen.theta - seen.alpha) - seen.hdot
            share = 1.0 if first else -math.expm1(-T / _GUST)
            gust = state.gust + share * (sinks - state.gust)
        integral = state.integral
        if state.phase != GO_AROUND:
            # the same lift takes an angle of attack inverse to the square of the airspeed
            integral -= 2.0 * DEGREES / _LIFT_SLOPE * gained / v
        return state._replace(
            v=v,
            acceleration=acceleration,
            gust=gust,
            integral=integral,
            kept=state.kept if state.phase >= ROLL_OUT else v,
        )

    def _taken_over(self, state: FlareState, seen: Seen) -> FlareState:
        """The state that goes on from the commands of the approach."""
        elevator, aileron, rudder, throttle = seen.given
        return state._replace(
            vertical=state.vertical._replace(pitch=ReferenceState(law=PID.holding(-elevator))),
            lateral=state.lateral._replace(roll=ReferenceState(law=PID.holding(aileron))),
            lowest=seen.theta,
            kept=state.v,
            psi=seen.psi,
            rudder=rudder,
            throttle=throttle,
        )

    def _begun(self, state: FlareState, seen: Seen) -> FlareState:
        """The state of a phase that begins at the present pitch angle and rate of climb."""
        goes = state.phase == GO_AROUND
        return state._replace(
            integral=seen.theta - DEGREES * (seen.hdot + state.gust) / state.v,
            hdot_cmd=seen.hdot,
            theta=seen.theta,
            lowest=seen.theta if goes else state.lowest,
        )

    def _bandwidth(self, v: float) -> float:
        """Of the rate of climb in rad/s, at an airspeed in ft/s: the pitch loop must follow.

        Below the slowest point of the gains the elevator has less effect than they reckon with.
        """
        pitch = self.vertical.pitch.pid
        if pitch.Kr <= 0.0:
            return _BANDWIDTH
        slower = min(v / max(KNOT * self._slowest, 1.0), 1.0)
        return min(_BANDWIDTH, _OF_PITCH * pitch.Kp / pitch.Kr * slower**2)

    def _pitch(self, state: FlareState, seen: Seen, rolls: bool) -> tuple[float, FlareState]:
        """Pitch angle of the phase, and the next state."""
        c, T, v, height, hdot = self._checked, self.clock.period, state.v, seen.height, seen.hdot
        goes, steepest = state.phase == GO_AROUND, self._steepest(height)
        if goes:
            # the rate of climb at which the airspeed comes back to what it was
            spare = hdot + v / GRAVITY * (state.acceleration + _TRADE * (v - state.kept))
            fast = spare - v / GRAVITY * _TRADE * (_FASTER - 1.0) * state.kept
            target = clip(spare, 0.3 * c.climb, max(fast, c.climb))
        else:
            # of a sink that ended early half is asked for again
            target = clip(hdot, steepest, 0.5 * (steepest - c.sink))
        step = clip(target - state.hdot_cmd, -_PULL * T, _PULL * T)
        hdot_cmd = state.hdot_cmd + step
        error, lift = hdot_cmd - hdot, state.lift
        if state.hdot != 0.0:
            lift += -math.expm1(-T / _SMOOTH) * ((hdot - state.hdot) / T - lift)
        lag = v / (GRAVITY * _LIFT_SLOPE)
        ahead = hdot_cmd + state.gust
        if not goes and hdot < steepest:
            ahead += lag * -hdot / c.tau
        bandwidth = self._bandwidth(v)
        ahead += lag * (bandwidth * error + _DAMPING * (step / T - lift))
        asked = state.integral + DEGREES / v * ahead
        altitude, highest = self.vertical.altitude, c.theta_max
        lowest = min(state.lowest, c.theta_max)
        if goes and height > _CLEAR:
            highest = altitude.theta_max
        if goes and height > _CLIMBS:
            lowest = altitude.pid.low
        # at its stop the elevator does not follow any further
        pitch, loop = state.vertical.pitch, self.vertical.pitch.pid
        if pitch.law.u >= loop.high:
            highest = min(highest, pitch.reference)
        elif pitch.law.u <= loop.low:
            lowest = max(lowest, pitch.reference)
        theta = min(max(asked, lowest), highest)
        gained = bandwidth * T * (DEGREES / v * error + theta - asked)
        if rolls:
            hdot_cmd = hdot
            theta = max(state.theta - (_LOWER * T if seen.down else 0.0), min(state.theta, 0.0))
        return theta, state._replace(
            integral=state.integral + gained,
            hdot_cmd=hdot_cmd,
            theta=theta,
            hdot=hdot,
            lift=lift,
        )

    def _bank(self, state: FlareState, psi: float) -> float:
        """Bank in deg: to the centre line in the flare, for the heading in a go-around."""
        most = self._checked.bank_max
        if state.phase == FLARE:
            pull = _TRACKING * (_TRACKING * state.beam.ft + 1.4 * state.beam.aside)
            return clip(-DEGREES / GRAVITY * pull, -most, most)
        if state.phase == GO_AROUND:
            return clip(_KEEP * wrap(state.psi - psi), -most, most)
        return 0.0

    def _yaw(self, state: FlareState, seen: Seen, rolls: bool) -> tuple[float, FlareState]:
        """Steering of the nose wheel, and the state with the rudder and the heading's reference."""
        c, T, beam = self._checked, self.clock.period, state.beam
        target, psi_cmd, align, turn = c.course, state.psi, c.align, 0.0
        speed = max(beam.along, SLOWEST)
        if rolls:
            target -= clip(DEGREES * _STEER * beam.ft / speed, -5.0, 5.0)
            # the slower it rolls, the less nose wheel and rudder turn it
            align *= state.kept / state.v
        if rolls or seen.height < _DECRAB * max(-seen.hdot, c.sink):
            psi_cmd += clip(wrap(target - psi_cmd), -_YAW * T, _YAW * T)
        psi_cmd, error = wrap(psi_cmd), 0.0
        if rolls or state.phase != GO_AROUND:
            error = align * (wrap(seen.psi - psi_cmd) + _YAW_DAMPING * seen.r)
        if rolls:
            # the approach's rudder is left out: on the wheels its sideslip integral winds up
            off = wrap(c.course + DEGREES * math.atan(beam.aside / speed) - target)
            turn = clip(state.turn + _TURN * align * off * T, -1.0, 1.0)
        asked = error + (turn if rolls else seen.given[2])
        moved = state.rudder + clip(asked - state.rudder, -_RUDDER * T, _RUDDER * T)
        steering = clip(-asked, -1.0, 1.0) if rolls else 0.0
        return steering, state._replace(rudder=clip(moved, -1.0, 1.0), psi=psi_cmd, turn=turn)

    def _power(self, state: FlareState, down: bool) -> tuple[float, float]:
        """Throttle and brakes."""
        T, brakes = self.clock.period, 0.0
        if state.phase == ROLL_OUT and down and state.theta <= 0.0:
            brakes = min(state.brakes + _BRAKE * T, clip(state.beam.along / _STOPS, 0.0, 1.0))
        throttle = 1.0 if state.phase == GO_AROUND else max(state.throttle - _IDLE * T, -1.0)
        return throttle, brakes
