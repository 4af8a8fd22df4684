"""Landing: flare, touchdown and roll-out, or a go-around."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from ..._core.checks import number, optional, positive
from ..._core.parameters import parameter
from ..._core.ports import numbered
from ..._core.units import GRAVITY, KNOT
from ..channels import Lateral, LateralState, Vertical, VerticalState
from ..controller import Authority, Hold, authority_limits, fill
from ..gains import Gains
from ..loops import AltitudeLoop, ReferenceState, attitude_loop
from ..pid import PID
from ..signals import larger, limit, select, smaller, wrap
from .approach import SLOWEST, BeamState

__all__ = ["FlareHold"]

_DEGREES = math.degrees(1.0)

_TREND = 2.0  # s, time constant of the acceleration

_STEEPEST = -10.0  # deg, pitch reference
_BANDWIDTH = 1.0  # rad/s, of the rate of climb
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
_CLEAR = 30.0  # ft, height above which no tail strikes
_FREE = 90.0  # deg, no limit of the pitch reference
_LOWER = 2.0  # deg/s, of the nose in the roll-out
_STEER = 0.25  # 1/s, of the distance from the centre line in the roll-out
_BRAKE = 0.25  # 1/s


class FlareState(NamedTuple):
    """State of a `FlareHold`; what is not known yet follows from the first active sample."""

    vertical: VerticalState = Vertical.START
    lateral: LateralState = Lateral.START
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
    throttle: float = 0.0
    brakes: float = 0.0
    v: float = 0.0  # airspeed, ft/s
    acceleration: float = 0.0  # smoothed
    kept: float = 0.0  # airspeed at the beginning of a go-around, ft/s
    gust: float = 0.0  # air that sinks, ft/s, smoothed
    floated: float = 0.0  # length of the flare over the ground, ft
    least: float = 0.0  # height reached in the flare, ft


APPROACH, FLARE, ROLL_OUT, GO_AROUND = 0.0, 1.0, 2.0, 3.0


@fill
@dataclass(eq=False, repr=False)
class FlareHold(Hold):
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
    bank of at most ``bank_max`` keeps the aircraft on the centre line. Where the sink has ended
    earlier than the law above asks, that is kept down to the sink of the touchdown, and the nose is
    never lower than at the beginning. With the wheels on the ground it lowers the nose, steers
    along the centre line and brakes.

    A go-around, at any height and on the ground too, applies full throttle, keeps the heading with
    a bank of at most ``bank_max``, and climbs at ``climb``: less where that costs airspeed, more
    where the airspeed is 10 % higher than at the beginning. On the ground the nose is raised at the
    airspeed of the touchdown.

    It begins by itself where, below the height ``decide``, the aircraft is more than ``across_max``
    beside the centre line or heads more than 45 deg off ``course``, where the flare would begin at
    more than ``sink_max``, where it is longer than ``float_max``, and where it climbs by 10 ft.

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
        rudder per heading error in the flare and on the ground, 1/deg; 0 lands with the crab angle
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
    course: float = parameter(0.0, number)
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
    alpha_max: float | None = parameter(None, optional)
    theta_max: float = parameter(10.0, number)

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
        T, c = self.clock.period, self.checked
        names = "altitude", "pitch", "roll", "envelope"
        altitude, pitch, roll, envelope = self.gains_of(*names)
        self.loops = {
            "altitude": AltitudeLoop(T, altitude, None, _STEEPEST, None),
            "pitch": attitude_loop(T, pitch, c.authority, -1.0, self.scheduled),
            "roll": attitude_loop(T, roll, c.authority, carry=self.scheduled),
            "envelope": self.protection_within(envelope),
        }

    def channels(self, u: list[Any], state: Any, form: Any) -> tuple[list[Any], Any]:
        h, hdot, theta, q, psi, phi, p, r, vc, ft, dist, *given, wow, go_around, alpha, off = u
        beam, *_ = state.beam.next(ft, dist, self.clock.period, 0.5)
        state, height = state._replace(beam=beam), h - self.checked.gear_height
        flew = state.phase != APPROACH
        across = abs(wrap(psi - self.checked.course)) > _ACROSS
        state = self._phase(state, height, hdot, across, wow != 0.0, go_around != 0.0, off != 0.0)
        state = self._in_air(state, hdot, theta, alpha if form[1] else None, vc)
        state = self._begun(state, flew, hdot, theta, psi, given)
        slow = (state.phase == GO_AROUND) & (wow != 0.0) & (state.v < state.kept)
        rolls = (state.phase == ROLL_OUT) | slow

        vertical = Vertical(
            self.loops, form[1], state.vertical, theta, q, h, hdot, vc, alpha, False, 0.0
        )
        vertical.guard(0.0, True)
        if (most := vertical.limits.theta_max) is not None:
            # on the wheels an angle of attack shows no stall
            free = select(rolls & (wow != 0.0), _FREE, most)
            vertical.limits = vertical.limits._replace(theta_max=free)
        vertical.pitch.ramp, vertical.pitch.pid.b = _RAMP, 1.0
        wanted, state = self._pitch(state, height, hdot, wow != 0.0, rolls)
        elevator, theta_cmd, after = vertical.fly(wanted)
        lateral = Lateral(self.loops, state.lateral, psi, phi, p, False, 0.0)
        aileron, phi_cmd, turned = lateral.fly(self._bank(state, psi))
        rudder, steering, state = self._yaw(state, height, hdot, psi, r, given[2], rolls)
        throttle, brakes = self._power(state, wow != 0.0)

        approach = state.phase == APPROACH
        commands = zip(given, (elevator, aileron, rudder, throttle), strict=True)
        outputs = [select(approach, *x) for x in commands]
        outputs += [select(approach, 0.0, x) for x in (brakes, steering)]
        state = state._replace(
            vertical=after, lateral=turned, rudder=rudder, throttle=throttle, brakes=brakes
        )
        return [*outputs, state.phase, theta_cmd, phi_cmd, state.hdot_cmd], state

    def _steepest(self, height: Any) -> Any:
        """Lowest rate of climb of the flare at a height, ft/s."""
        return smaller(-height / self.checked.tau, 0.0) - self.checked.sink

    def _phase(
        self, state: Any, height: Any, hdot: Any, across: Any, down: Any, go_around: Any, off: Any
    ) -> Any:
        """The state in the phase that begins or goes on."""
        c, before = self.checked, state.phase
        low = (hdot <= self._steepest(height)) | (height <= c.sink * c.tau)
        phase = select((before == APPROACH) & low, FLARE, before)
        phase = select((phase == FLARE) & down, ROLL_OUT, phase)
        floated = state.floated + select(before == FLARE, self.clock.period * state.beam.along, 0.0)
        astray = (height < c.decide) & ((abs(state.beam.ft) > c.across_max) | across)
        astray |= (before == APPROACH) & low & (hdot < -c.sink_max)
        least = select(before == FLARE, smaller(state.least, height), height)
        astray |= (floated > c.float_max) | (height > least + _BALLOON)
        phase = select(go_around | ((phase < ROLL_OUT) & astray), GO_AROUND, phase)
        phase, floated = select(off, APPROACH, phase), select(off, 0.0, floated)
        return state._replace(phase=phase, floated=floated, least=least)

    def _in_air(self, state: Any, hdot: Any, theta: Any, alpha: Any, vc: Any) -> Any:
        """The state with the airspeed and the vertical gust of the sample."""
        T, first = self.clock.period, state.v == 0.0
        v = larger(vc * KNOT, SLOWEST)
        gained = select(first, 0.0, v - state.v)
        share = -math.expm1(-T / _TREND)
        acceleration = state.acceleration + share * (gained / T - state.acceleration)
        gust = 0.0
        if alpha is not None:
            # what the aircraft climbs through the air less what it climbs
            sinks = v / _DEGREES * (theta - alpha) - hdot
            share = select(first, 1.0, -math.expm1(-T / _GUST))
            gust = state.gust + share * (sinks - state.gust)
        goes = state.phase == GO_AROUND
        # the same lift takes an angle of attack inverse to the square of the airspeed
        lost = select(goes, 0.0, -2.0 * _DEGREES / _LIFT_SLOPE * gained / v)
        kept = select(state.phase >= ROLL_OUT, state.kept, v)
        return state._replace(
            v=v,
            acceleration=acceleration,
            gust=gust,
            integral=state.integral + lost,
            kept=kept,
        )

    def _begun(
        self, state: Any, flew: Any, hdot: Any, theta: Any, psi: Any, given: list[Any]
    ) -> Any:
        """The state of a flare that goes on from the commands of the approach, if it is new."""
        elevator, aileron, rudder, throttle = given
        anew = state._replace(
            vertical=state.vertical._replace(pitch=ReferenceState(law=PID.holding(-elevator))),
            lateral=state.lateral._replace(roll=ReferenceState(law=PID.holding(aileron))),
            integral=theta - _DEGREES * (hdot + state.gust) / state.v,
            hdot_cmd=hdot,
            theta=theta,
            lowest=theta,
            psi=psi,
            rudder=rudder,
            throttle=throttle,
        )
        return select(flew, state, anew)

    def _pitch(self, state: Any, height: Any, hdot: Any, down: Any, rolls: Any) -> tuple[Any, Any]:
        """Pitch angle of the phase, and the next state."""
        c, T, v = self.checked, self.clock.period, state.v
        goes = state.phase == GO_AROUND
        # the rate of climb at which the airspeed comes back to what it was
        spare = hdot + v / GRAVITY * (state.acceleration + _TRADE * (v - state.kept))
        fast = spare - v / GRAVITY * _TRADE * (_FASTER - 1.0) * state.kept
        steepest = self._steepest(height)
        # a sink that ended early is not asked for again
        flared = limit(hdot, steepest, -c.sink)
        climb = limit(spare, 0.3 * c.climb, larger(fast, c.climb))
        target = select(goes, climb, flared)
        step = limit(target - state.hdot_cmd, -_PULL * T, _PULL * T)
        hdot_cmd = state.hdot_cmd + step
        error = hdot_cmd - hdot
        share = -math.expm1(-T / _SMOOTH)
        lift = state.lift + select(
            state.hdot == 0.0, 0.0, share * ((hdot - state.hdot) / T - state.lift)
        )
        lag = v / (GRAVITY * _LIFT_SLOPE)
        slows = select(goes, False, hdot < steepest)
        ahead = hdot_cmd + state.gust + select(slows, lag * -hdot / c.tau, 0.0)
        ahead += lag * (_BANDWIDTH * error + _DAMPING * (step / T - lift))
        asked = state.integral + _DEGREES / v * ahead
        limits = self.loops["altitude"].pid
        highest = select(goes & (height > _CLEAR), limits.high, c.theta_max)
        lowest = select(goes, limits.low, smaller(state.lowest, c.theta_max))
        wanted = limit(asked, lowest, highest)
        gained = _BANDWIDTH * T * (_DEGREES / v * error + wanted - asked)
        lowered = larger(state.theta - select(down, _LOWER * T, 0.0), smaller(state.theta, 0.0))
        theta = select(rolls, lowered, wanted)
        state = state._replace(
            integral=state.integral + gained,
            hdot_cmd=select(rolls, hdot, hdot_cmd),
            theta=theta,
            hdot=hdot,
            lift=lift,
        )
        return theta, state

    def _bank(self, state: Any, psi: Any) -> Any:
        """Bank in deg: to the centre line in the flare, for the heading in a go-around."""
        most = self.checked.bank_max
        pull = _TRACKING * (_TRACKING * state.beam.ft + 1.4 * state.beam.aside)
        bank = limit(-_DEGREES / GRAVITY * pull, -most, most)
        kept = limit(_KEEP * wrap(state.psi - psi), -most, most)
        kept = select(state.phase == GO_AROUND, kept, 0.0)
        return select(state.phase == FLARE, bank, kept)

    def _yaw(
        self, state: Any, height: Any, hdot: Any, psi: Any, r: Any, rudder: Any, rolls: Any
    ) -> tuple[Any, Any, Any]:
        """Rudder, steering of the nose wheel, and the next state."""
        c, step = self.checked, _YAW * self.clock.period
        flies = select(rolls, False, state.phase == GO_AROUND)
        aside = limit(_DEGREES * _STEER * state.beam.ft / state.v, -5.0, 5.0)
        target = c.course - select(rolls, aside, 0.0)
        near = rolls | (height < _DECRAB * larger(-hdot, c.sink))
        turn = select(near, limit(wrap(target - state.psi), -step, step), 0.0)
        psi_cmd = wrap(state.psi + turn)
        error = select(flies, 0.0, c.align * (wrap(psi - psi_cmd) + _YAW_DAMPING * r))
        most = _RUDDER * self.clock.period
        moved = state.rudder + limit(rudder + error - state.rudder, -most, most)
        moved = limit(moved, -1.0, 1.0)
        steering = select(rolls, limit(-error, -1.0, 1.0), 0.0)
        return moved, steering, state._replace(psi=psi_cmd)

    def _power(self, state: Any, down: Any) -> tuple[Any, Any]:
        """Throttle and brakes."""
        T = self.clock.period
        idle = larger(state.throttle - _IDLE * T, -1.0)
        braked = smaller(state.brakes + _BRAKE * T, 1.0)
        braked = select((state.phase == ROLL_OUT) & down & (state.theta <= 0.0), braked, 0.0)
        return select(state.phase == GO_AROUND, 1.0, idle), braked
