"""`design_gains`: the gains of all loops of an aircraft at one condition, with a report."""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
import math
import reprlib
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from .._core.checks import flag, known_keywords, refuse, refuse_unknown
from .._core.units import GRAVITY
from ..control.gains import (
    AircraftGains,
    AltitudeGains,
    AttitudeGains,
    EnvelopeLimits,
    SpeedGains,
    YawGains,
)
from ..errors import DesignError, FlightError, LinearisationError, TrimError
from ..flight import Airframe, TrimCondition, TrimState, level_flight
from ..flight.aircraft import Aircraft
from ..linear.model import LinearModel
from .envelope import envelope
from .outer import (
    damped,
    design_altitude,
    design_feed,
    design_heading,
    design_rudder,
    design_speed,
    design_yaw,
    with_altitude,
    with_speed,
)
from .plant import Plant
from .requirements import (
    BAND,
    CLIMB,
    CLIMB_OF_EXCESS,
    CLIMB_OF_SPEED,
    GUST,
    MAX_FINAL_ERROR,
    NEAR_THE_LOWEST,
    NOSE_UP,
    RAMP_HIGH,
    RAMP_LOAD,
    RAMP_LOW,
    ROLL_RAMP,
    ROLL_SLIP,
    ROLL_SLOW,
    STEP_REQUIREMENTS,
    THETA_MAX,
)
from .search import PITCH, ROLL, Attitude, LoopReport, Neighbours, closed, design_attitude
from .steps import STEPS, fly_step
from .turbulence import in_turbulence

_INPUTS = ("elevator", "aileron", "rudder", "throttle")
_OUTPUTS = ("theta", "phi", "psi", "p", "q", "r", "beta", "h", "hdot", "vc")

# share of the throttle's remaining travel that a step up in airspeed may hold
_ENOUGH = 0.7

# weight of the throttle's stops in turbulence where a step in airspeed or altitude is not finished
RELAXED_STOP_WEIGHT = 0.05

# ft/s, of the excess climb: rates of climb whose feed-forward may use all of the throttle's
# remaining travel; the second where the steps are not finished at their end with the first, where
# it is at least so many ft/s (more feed keeps the throttle at its stop) and relaxes nothing
_RISE, _RISE_OF_EXCESS, _LEAST_RISE = 40.0, 2.0, 25.0

# ft/s; less is no climb to speak of: the altitude is then designed for a descent
_NO_CLIMB = 2.0


Held = tuple[SpeedGains, LoopReport, AltitudeGains, LoopReport]
Refuse = Callable[[str, str], DesignError]


@known_keywords
@dataclass(frozen=True)
class DesignedGains(AircraftGains):
    """Gains from `design_gains` with the report of their design; every ``gains=`` takes them.

    Parameters
    ----------
    pitch, roll : AttitudeGains
    heading : HeadingGains
    altitude : AltitudeGains
    speed : SpeedGains
    yaw : YawGains
    envelope : EnvelopeLimits, optional
    aircraft : str
        the model's name
    condition : TrimCondition
        at which they were designed
    report : tuple of LoopReport
    """

    aircraft: str = ""
    condition: TrimCondition = field(default_factory=TrimCondition)
    report: tuple[LoopReport, ...] = ()

    @property
    def gains(self) -> AircraftGains:
        """The gains alone."""
        return AircraftGains(
            **{f.name: getattr(self, f.name) for f in dataclasses.fields(AircraftGains)}
        )

    def __str__(self) -> str:
        return f"{self.aircraft}: {self.condition}\n{report_table(self.report)}"


def report_table(report: tuple[LoopReport, ...]) -> str:
    """The report as a table of fixed width."""
    head = (
        f"{'loop':<13}{'rad/s':>7}{'dB':>6}{'deg':>6}{'Ms':>6}{'+50 ms':>8}"
        f"{'settles s':>11}{'flown s':>9}{'over':>7}{'flown':>7}{'use':>6}  relaxed"
    )
    rows = [head]
    for r in report:

        def cell(x: float, width: int, digits: int) -> str:
            text = "" if math.isnan(x) else "-" if math.isinf(x) else f"{x:.{digits}f}"
            return f"{text:>{width}}"

        rows.append(
            f"{r.loop:<13}{cell(r.crossover, 7, 2)}{cell(r.gain_margin, 6, 1)}"
            f"{cell(r.phase_margin, 6, 0)}{cell(r.Ms, 6, 2)}{cell(r.Ms_delayed, 8, 2)}"
            f"{cell(r.settling, 11, 1)}{cell(r.flown_settling, 9, 1)}{cell(r.overshoot, 7, 2)}"
            f"{cell(r.flown_overshoot, 7, 2)}{cell(r.use, 6, 2)}  {r.relaxed}".rstrip()
        )
    return "\n".join(rows)


def design_gains(
    aircraft: str,
    condition: TrimCondition | None = None,
    *,
    T: float = 1 / 120,
    substeps: int = 1,
    check: bool = True,
    near: Sequence[AircraftGains] = (),
    **options: Any,
) -> DesignedGains:
    """Gains of all loops of an aircraft at one condition of level flight, by loop shaping.

    The linear model is identified from small pulses in flight, so that control system, actuators,
    engines and sampling are in it. The loops are shaped one after the other, each with those before
    it closed: pitch, roll, rudder, heading, airspeed, altitude. A search over crossover, phase
    margin and integral time keeps the candidates with a sensitivity peak Ms of at most 1.4 (1.8
    with 50 ms of additional delay) and margins of at least 7 dB and 45 deg, and computes their
    steps on the linear model with ramps and limits. Those of airspeed and altitude are judged in
    moderate turbulence, too: altitude within 60 ft, pitch angle within 5 deg rms, and the throttle
    at a stop in 5 % of the time. Where no candidate meets all of these, the margins are relaxed in
    steps, and the report says what is not met.

    Parameters
    ----------
    aircraft : str
        name of the JSBSim model
    condition : TrimCondition, optional
        level flight; default: where `level_flight` trims it. Where JSBSim's search fails and the
        Newton search does not, the gains are designed for the latter's trim
    T : float
        sample period of the loops in s
    substeps : int
        JSBSim steps per sample period
    check : bool
        fly the steps in pitch and roll on the nonlinear aircraft too, and shape the loops once more
        where the pitch angle overshoots too far there
    near : list of AircraftGains, optional
        gains at conditions around this one: of gains that are as good, those are found that differ
        from them by no more than a factor of 1.5
    **options
        ``setup``, ``properties``, ``root``, ``create``, ``allow_network`` or ``allow_files``, as
        of `Aircraft`

    Returns
    -------
    DesignedGains
        with the margins, predicted and flown steps in ``report``; ``gains=`` of every hold takes it

    Raises
    ------
    DesignError
        for an aircraft that cannot be held, with the reason
    TrimError
        if it does not trim there
    AircraftError, PropertyError, ParameterError
        for unknown names and values that cannot be

    References
    ----------
    Astrom, Murray: *Feedback Systems*, 2nd ed., 2021, chapters 11 and 12 (loop shaping, Ms).

    Examples
    --------
    >>> gains = design_gains("A320", TrimCondition(altitude=5000, speed=281, gear=0.0))
    >>> max(loop.Ms for loop in gains.report) < 1.9
    True
    """
    check_options(design_gains, options)
    flag("check", check)
    check_near(near, AircraftGains)
    if condition is None:
        found = level_flight(aircraft, options.get("root"))
        condition = found.condition
        options = {"create": found.create, **options}

    def fresh() -> Aircraft:
        return Aircraft(aircraft, condition=condition, T=T, substeps=substeps, **options)

    try:
        plane = fresh()
    except TrimError as error:
        # the Newton search may have found what JSBSim's has not
        if condition.solver or error.nearest != replace(condition, solver="newton"):
            raise
        condition = error.nearest
        plane = fresh()
    trim = plane.trim
    if not trim.throttle:
        raise DesignError(
            f"no gains for {aircraft!r}: it has no engine to hold an airspeed with",
            aircraft=aircraft,
            reason="no throttle",
            loop="speed",
        )
    model = _model(plane)
    vt = float(model.x0[model.states.index("vt")])

    def airframe() -> Airframe:
        return Airframe(
            aircraft,
            T / substeps,
            root=options.get("root"),
            empty_cg_x=condition.empty_cg_x,
            create=options.get("create"),
        )

    setup = {**condition.setup, **(options.get("setup") or {})}
    limits = envelope(airframe, replace(condition, setup=setup), trim, trim.speed)
    shaped = partial(_loops, aircraft, condition, model, trim, vt, limits, Neighbours(near))
    designed = shaped(PITCH)
    if not check:
        return designed
    designed = _flown(fresh, designed)
    excess = designed.report[0].flown_overshoot / PITCH.required.overshoot
    if excess <= 1.0:
        return designed
    # a kink at the trim: ask the linear model for as much less
    less = replace(PITCH.required, overshoot=0.9 * PITCH.required.overshoot / excess)
    again = _flown(fresh, shaped(replace(PITCH, required=less)))
    return min(designed, again, key=lambda found: found.report[0].flown_overshoot)


def check_options(function: Callable[..., Any], options: Mapping[str, Any]) -> None:
    """Refuse keywords that neither the function, `design_gains` nor `Aircraft` has."""
    owners: tuple[Callable[..., Any], ...] = (function, design_gains, Aircraft)
    names = [name for owner in owners for name in inspect.signature(owner).parameters]
    refuse_unknown(function.__name__, options, [x for x in dict.fromkeys(names) if x != "options"])


def check_near(near: Any, kind: type) -> None:
    """Refuse anything but a list of gains."""
    if not isinstance(near, Sequence) or not all(isinstance(gains, kind) for gains in near):
        refuse("near", near, f"near must be a list of {kind.__name__}, not {reprlib.repr(near)}")


def _model(plane: Aircraft) -> LinearModel:
    try:
        with warnings.catch_warnings():
            # kinks at the trim; the steps are flown on the aircraft itself
            warnings.simplefilter("ignore", RuntimeWarning)
            return plane.linear_model(inputs=_INPUTS, outputs=_OUTPUTS)
    except LinearisationError as error:
        name = plane.airframe.aircraft
        raise DesignError(
            f"no gains for {name!r}: {error}",
            aircraft=name,
            reason=error.reason,
            loop={"elevator": "pitch", "aileron": "roll", "throttle": "speed"}.get(error.name, ""),
        ) from error


def _loops(
    aircraft: str,
    condition: TrimCondition,
    model: LinearModel,
    trim: TrimState,
    vt: float,
    limits: EnvelopeLimits,
    near: Neighbours,
    pitching: Attitude,
) -> DesignedGains:
    """Shape one loop after the other."""

    def refuse(loop: str, why: str) -> DesignError:
        return DesignError(
            f"no gains for {aircraft!r} at {condition}: {why}",
            aircraft=aircraft,
            reason="unstable",
            loop=loop,
        )

    plant = in_turbulence(Plant.of(model), model, condition.altitude)
    pitch, pitched, plant = _pitch(plant, pitching, trim, vt, near, refuse)
    roll, rolled, yaw, coordinated, plant = _roll_and_yaw(plant, trim, vt, near, refuse)
    turning = design_heading(plant, roll.ramp, rolled.settling, vt, trim.phi, near)
    if turning is None:
        raise refuse("heading", "no gains from the heading to the bank settle a turn")
    heading, steered = turning
    speed, quick, altitude, climbing = _speed_and_altitude(
        plant, trim, vt, limits, pitch.ramp, near, refuse
    )
    return DesignedGains(
        pitch=pitch,
        roll=roll,
        heading=heading,
        altitude=altitude,
        speed=speed,
        yaw=yaw,
        envelope=limits,
        aircraft=aircraft,
        condition=condition,
        report=tuple(
            report
            for report in (pitched, rolled, coordinated, steered, quick, climbing)
            if report is not None
        ),
    )


def _pitch(
    plant: Plant, pitching: Attitude, trim: TrimState, vt: float, near: Neighbours, refuse: Refuse
) -> tuple[AttitudeGains, LoopReport, Plant]:
    """Gains of the pitch loop, how good they are, and the plant with it closed."""
    ramp = min(max(math.degrees(RAMP_LOAD * GRAVITY / vt), RAMP_LOW), RAMP_HIGH)
    low, high = max(-1.0, -1.0 - trim.pitch_trim), min(1.0, 1.0 - trim.pitch_trim)
    travel = low - trim.elevator, high - trim.elevator
    found = design_attitude(plant, pitching, ramp, travel, near)
    if found is None:
        raise refuse("pitch", "no gains of the elevator settle a step in pitch")
    return *found, closed(plant, PITCH, found[0], "theta_cmd")


def _roll_and_yaw(
    plant: Plant, trim: TrimState, vt: float, near: Neighbours, refuse: Refuse
) -> tuple[AttitudeGains, LoopReport, YawGains, LoopReport | None, Plant]:
    """The same of ailerons, and of the rudder, which is shaped for the turn; then roll again."""
    slip = math.sin(math.radians(trim.alpha))  # per roll
    slow = slip * ROLL_RAMP > ROLL_SLIP
    ramp = max(ROLL_SLIP / slip, ROLL_SLOW) if slow else ROLL_RAMP
    rudder = 1.0 - abs(trim.rudder)

    def rolled(yaw: YawGains) -> tuple[AttitudeGains, LoopReport]:
        travel = (-1.0 - trim.aileron, 1.0 - trim.aileron)
        found = design_attitude(damped(plant, yaw), ROLL, ramp, travel, near)
        if found is None:
            raise refuse("roll", "no gains of the ailerons settle a step in roll")
        return found

    damper = design_yaw(plant, rudder)
    rolling = closed(plant, ROLL, rolled(damper)[0], "phi_cmd")
    yaw, outcome = design_rudder(rolling, damper, rudder, vt, ramp, near)
    gains, found = rolled(yaw)
    return gains, found, yaw, outcome, closed(damped(plant, yaw), ROLL, gains, "phi_cmd")


def _speed_and_altitude(
    plant: Plant,
    trim: TrimState,
    vt: float,
    limits: EnvelopeLimits,
    ramp: float,
    near: Neighbours,
    refuse: Refuse,
) -> Held:
    """Gains of throttle and rate of climb: those that finish the steps, if any do.

    Where they do not, the throttle's stops in turbulence count for less, and then more throttle is
    fed forward too.
    """
    room = (-trim.throttle[0], 1.0 - trim.throttle[0])
    climb_max = max(limits.climb_max, _NO_CLIMB)
    feed, per_knot = design_feed(plant, room, _RISE)
    step = STEP_REQUIREMENTS["speed"].size
    if per_knot * step >= _ENOUGH * room[1]:
        step = -step
    hdot_max = min(CLIMB, CLIMB_OF_SPEED * vt, CLIMB_OF_EXCESS * climb_max)
    band = BAND if trim.speed > limits.vc_min + NEAR_THE_LOWEST else GUST

    def shaped(level: Plant, stops: float, feed: float) -> Held:
        throttle = design_speed(level, room, feed, step, stops, band, near)
        if throttle is None:
            raise refuse("speed", "no gains of the throttle hold the airspeed")
        held = with_speed(plant, throttle[0])
        climb = design_altitude(held, ramp, hdot_max, room, stops, near)
        if climb is None:
            raise refuse("altitude", "no gains from the rate of climb to the pitch are stable")
        return *throttle, *climb

    def hold(stops: float, feed: float) -> Held:
        # the airspeed with the attitude held, the altitude, and both with the other held
        first = shaped(plant, stops, feed)
        held = shaped(with_altitude(plant, first[2]), stops, feed)
        if not math.isfinite(held[1].settling):
            raise refuse("speed", f"no gains of the throttle settle a step of {step:g} kt")
        if not math.isfinite(held[3].settling):
            raise refuse("altitude", "no gains from the rate of climb to the pitch angle settle")
        return held

    held = hold(1.0, feed)
    if _finished(held) < len(MAX_FINAL_ERROR):
        with contextlib.suppress(DesignError):
            held = max(held, hold(RELAXED_STOP_WEIGHT, feed), key=_finished)
    rise = _RISE_OF_EXCESS * climb_max
    if _finished(held) < len(MAX_FINAL_ERROR) and _LEAST_RISE <= rise < _RISE:
        with contextlib.suppress(DesignError):
            more = hold(RELAXED_STOP_WEIGHT, design_feed(plant, room, rise)[0])
            if not any(step.relaxed for step in more[1::2]):
                held = min(held, more, key=_excess)
    speed, quick, altitude, climbing = held
    altitude = replace(altitude, theta_max=max(THETA_MAX, trim.theta + NOSE_UP))
    return speed, quick, altitude, climbing


def _finished(held: Held) -> int:
    """How many of the steps in airspeed and altitude are finished at their end."""
    return sum(step.late <= late for step, late in zip(held[1::2], MAX_FINAL_ERROR, strict=True))


def _excess(held: Held) -> float:
    """Largest error at the end of these steps, in what it may be."""
    return max(step.late / late for step, late in zip(held[1::2], MAX_FINAL_ERROR, strict=True))


def _flown(fresh: Callable[[], Aircraft], designed: DesignedGains) -> DesignedGains:
    """The report with the steps in pitch and roll flown on the nonlinear aircraft."""
    report = []
    for row in designed.report:
        if row.loop in ("pitch", "roll"):
            try:
                flown = fly_step(fresh, designed, STEPS[row.loop], seconds=10.0).quality
            except FlightError as error:
                raise DesignError(
                    f"no gains for {designed.aircraft!r} at {designed.condition}: "
                    f"the step in {row.loop} ends the flight: {error}",
                    aircraft=designed.aircraft,
                    reason="unstable",
                    loop=row.loop,
                ) from error
            row = replace(
                row,
                flown_settling=math.inf if math.isnan(flown.settling) else flown.settling,
                flown_overshoot=flown.overshoot,
            )
        report.append(row)
    return replace(designed, report=tuple(report))
