"""`design_gains`: the gains of all loops of an aircraft at one condition, with a report."""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
import math
import reprlib
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

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
from ..errors import DesignError, FlightError, LinearisationError
from ..flight import Airframe, TrimCondition, TrimState, level_flight
from ..flight.aircraft import Aircraft
from ..flight.options import AircraftOptions
from ..linear.model import LinearModel
from . import requirements as req
from .envelope import envelope
from .outer import (
    damped,
    design_altitude,
    design_feed,
    design_heading,
    design_rudder,
    design_speed,
    design_yaw,
    speed_report,
    with_altitude,
    with_speed,
)
from .plant import Plant
from .requirements import STEP_REQUIREMENTS
from .search import PITCH, ROLL, Loop, LoopReport, Neighbours, Unstable, closed, design_attitude
from .steps import STEPS, fly_step
from .turbulence import in_turbulence

if TYPE_CHECKING:
    from typing_extensions import Unpack

_INPUTS = ("elevator", "aileron", "rudder", "throttle")
# fraction of the largest effect of a command, above rounding errors
_NO_EFFECT = 1e-6
_OUTPUTS = ("theta", "phi", "psi", "p", "q", "r", "beta", "h", "hdot", "vc")


# gains of an aircraft without an engine, for flights with its other loops
_NO_ALTITUDE, _NO_SPEED = AltitudeGains(0.0, 0.0, 0.0), SpeedGains(0.0, 0.0)

SpeedAndAltitude = tuple[SpeedGains | None, LoopReport, AltitudeGains | None, LoopReport]


@known_keywords
@dataclass(frozen=True)
class DesignedGains(AircraftGains):
    """Gains from `design_gains` with the report of their design, for ``gains=`` of every hold.

    Parameters
    ----------
    pitch, roll : AttitudeGains
    heading : HeadingGains
    altitude : AltitudeGains or None
    speed : SpeedGains or None
    yaw : YawGains
    envelope : EnvelopeLimits, optional
    aircraft : str
        the model's name
    condition : TrimCondition
        flight condition of the design
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
        return f"{self.aircraft}: {self.condition}\n{report_table(self.report)}\n{COLUMNS}"


# legend of the report's columns
COLUMNS = """\
rad/s, dB, deg: crossover, gain and phase margin; Ms: peak of the sensitivity, +50 ms: delayed
settles, over: a step's settling time and overshoot in its unit, predicted; flown: on the aircraft
use: fraction of the control's remaining travel that the step uses; relaxed: requirements not met"""


def report_table(report: tuple[LoopReport, ...]) -> str:
    """The report as a table of fixed width."""
    columns = (
        ("rad/s", "crossover", 2),
        ("dB", "gain_margin", 1),
        ("deg", "phase_margin", 0),
        ("Ms", "Ms", 2),
        ("+50 ms", "Ms_delayed", 2),
        ("settles s", "settling", 1),
        ("flown s", "flown_settling", 1),
        ("over", "overshoot", 2),
        ("flown", "flown_overshoot", 2),
        ("use", "use", 2),
    )
    rows = [("loop", [head for head, *_ in columns], "relaxed")]
    for row in report:
        values = [(getattr(row, name), digits) for _, name, digits in columns]
        cells = [f"{x:.{digits}f}".replace("nan", "").replace("inf", "-") for x, digits in values]
        rows.append((row.loop, cells, row.relaxed))
    widths = [max(len(head) + 2, 6) for head, *_ in columns]
    return "\n".join(
        f"{loop:<13}{''.join(map(str.rjust, cells, widths))}  {note}".rstrip()
        for loop, cells, note in rows
    )


def design_gains(
    aircraft: str,
    condition: TrimCondition | None = None,
    *,
    method: Literal["flown", "algebraic"] = "flown",
    T: float = 1 / 120,
    substeps: int = 1,
    check: bool = True,
    near: Sequence[AircraftGains] = (),
    **options: Unpack[AircraftOptions],
) -> DesignedGains:
    """Gains of all loops of an aircraft at one condition of level flight, by loop shaping.

    The linear model is identified from small pulses in flight, so it includes control system,
    actuators, engines and sampling. The loops are shaped in sequence, each with the previous ones
    closed: pitch, roll, rudder, heading, airspeed, altitude. A search over crossover, phase margin
    and integral time selects the candidates with a sensitivity peak Ms of at most 1.4 (1.8 with
    50 ms of additional delay) and margins of at least 7 dB and 45 deg, and computes their steps on
    the linear model with ramps and limits. Airspeed and altitude are also judged in moderate
    turbulence: altitude within 60 ft, pitch angle within 5 deg rms, and the throttle at a stop for
    at most 5 % of the time. If no candidate meets all requirements, the margins are relaxed in
    steps, and the report lists the unmet ones. In a glide (``mode="glide"``) the loops that require
    an engine, airspeed and altitude, and the limits of the envelope are omitted; without an
    effective rudder those of yaw are.

    Parameters
    ----------
    aircraft : str
        name of the JSBSim model
    condition : TrimCondition, optional
        level flight, or a glide; default: the condition of `level_flight`
    method : str
        of the linear model, as in `Aircraft.linear_model`: "algebraic" if servos have hysteresis
        that small pulses do not overcome. The model then has no actuators or hysteresis, and the
        report gives the limit cycle that remains in the flown steps
    T : float
        sample period of the loops in s
    substeps : int
        JSBSim steps per sample period
    check : bool
        fly the steps in pitch and roll on the nonlinear aircraft too, and shape the loops again if
        the pitch angle or the bank overshoots too far
    near : list of AircraftGains, optional
        gains at neighbouring conditions: among gains of equal quality, those that differ from them
        by at most a factor of 1.5 are preferred
    **options
        ``setup``, ``properties``, ``root``, ``create``, ``allow_network`` or ``allow_files``, as
        in `Aircraft`

    Returns
    -------
    DesignedGains
        with margins, predicted and flown steps in ``report``; use it as ``gains=`` of any hold

    Raises
    ------
    DesignError
        if no gains hold the aircraft, with the reason
    TrimError
        if it does not trim at the condition
    AircraftError, PropertyError, ParameterError
        for unknown names and values out of range

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
        level = level_flight(aircraft, options.get("root"), create=options.get("create"))
        condition = level.condition
        options = {**options, "create": level.create}

    def fresh() -> Aircraft:
        return Aircraft(aircraft, condition=condition, T=T, substeps=substeps, **options)

    plane = fresh()
    trim = plane.trim
    model = plant_model(plane, method)

    def airframe() -> Airframe:
        return Airframe(
            aircraft,
            T / substeps,
            root=options.get("root"),
            empty_cg_x=condition.empty_cg_x,
            create=options.get("create"),
        )

    setup = {**condition.setup, **(options.get("setup") or {})}
    limits = None
    if _has_power(trim):
        limits = envelope(airframe, replace(condition, setup=setup), trim, trim.speed)

    def shaped(*attitudes: Loop) -> DesignedGains:
        loops = _loops(model, condition.altitude, trim, limits, Neighbours(near), *attitudes)
        gains = DesignedGains(**loops, envelope=limits, aircraft=aircraft, condition=condition)
        return _flown(fresh, gains) if check else gains

    with _refused(aircraft, condition):
        first = shaped(PITCH, ROLL)
        excess = _overshoots(first)
        if not max(excess) > 1.0:
            return first
        # the aircraft has a kink at the trim: tighten the linear overshoot limit by the excess
        again = shaped(*map(_tightened, (PITCH, ROLL), excess))
    return min(first, again, key=lambda gains: max(_overshoots(gains)))


def _overshoots(gains: DesignedGains) -> list[float]:
    """Overshoots of pitch and roll in flight, as fractions of the allowed ones."""
    flown = zip((PITCH, ROLL), gains.report, strict=False)
    return [row.flown_overshoot / loop.required.overshoot for loop, row in flown]


def _tightened(loop: Loop, excess: float) -> Loop:
    if not excess > 1.0:
        return loop
    overshoot = 0.9 * loop.required.overshoot / excess
    return replace(loop, required=replace(loop.required, overshoot=overshoot))


@contextlib.contextmanager
def _refused(aircraft: str, condition: TrimCondition) -> Iterator[None]:
    try:
        yield
    except Unstable as error:
        raise DesignError(
            f"no gains for {aircraft!r} at {condition}: {error}",
            aircraft=aircraft,
            reason="unstable",
            loop=error.loop,
        ) from error


def check_options(
    function: Callable[..., Any],
    options: Mapping[str, Any],
    kind: type[AircraftOptions] = AircraftOptions,
) -> None:
    """Refuse keywords that are neither the function's own nor among its options."""
    names = [name for name in inspect.signature(function).parameters if name != "options"]
    refuse_unknown(function.__name__, options, [*names, *kind.__annotations__])


def check_near(value: Any, kind: type) -> None:
    """Refuse anything but a list of gains."""
    if not isinstance(value, Sequence) or not all(isinstance(gains, kind) for gains in value):
        refuse("near", value, f"near must be a list of {kind.__name__}, not {reprlib.repr(value)}")


def _has_power(trim: TrimState) -> bool:
    """Whether an engine holds the airspeed."""
    return bool(trim.throttle) and trim.condition.mode != "glide"


def plant_model(
    plane: Aircraft,
    method: Literal["flown", "algebraic"] = "flown",
    inputs: Sequence[str] = _INPUTS,
) -> LinearModel:
    """Linear model of the aircraft about its trim, for which the loops are shaped.

    It has no throttle without power, and no rudder if this has no effect.
    """
    inputs = [name for name in inputs if name != "throttle" or _has_power(plane.trim)]
    others = [name for name in inputs if name != "rudder"]
    try:
        with warnings.catch_warnings():
            # warnings of nonlinearity: the steps are flown on the aircraft itself anyway
            warnings.simplefilter("ignore", RuntimeWarning)
            model = plane.linear_model(method, inputs, _OUTPUTS)
        effects = abs(model.B).max(axis=0)
        if "rudder" in inputs and effects[inputs.index("rudder")] < _NO_EFFECT * effects.max():
            return plant_model(plane, method, others)
        return model
    except LinearisationError as error:
        if (error.reason, error.name) == ("no response", "rudder"):
            return plant_model(plane, method, others)
        name = plane.airframe.aircraft
        raise DesignError(
            f"no gains for {name!r}: {error}",
            aircraft=name,
            reason=error.reason,
            loop={"elevator": "pitch", "aileron": "roll", "throttle": "speed"}.get(error.name, ""),
        ) from error


def _loops(
    model: LinearModel,
    altitude: float,
    trim: TrimState,
    limits: EnvelopeLimits | None,
    neighbours: Neighbours,
    pitch_loop: Loop,
    roll_loop: Loop,
) -> dict[str, Any]:
    """Gains of all loops, shaped in sequence, and the report."""
    vt = float(model.x0[model.states.index("vt")])
    plant = in_turbulence(Plant.of(model), model, altitude)
    ramp = math.degrees(req.RAMP_LOAD * GRAVITY / vt)
    ramp = min(max(ramp, req.RAMP_LOW), req.RAMP_HIGH)
    low, high = max(-1.0, -1.0 - trim.pitch_trim), min(1.0, 1.0 - trim.pitch_trim)
    travel = low - trim.elevator, high - trim.elevator
    pitch, pitch_row = design_attitude(plant, pitch_loop, ramp, travel, neighbours)
    plant = closed(plant, PITCH, pitch, "theta_cmd")
    roll, roll_row, yaw, yaw_row, plant = _roll_and_yaw(plant, roll_loop, trim, vt, neighbours)
    heading, heading_row = design_heading(
        plant, roll.ramp, roll_row.settling, vt, trim.phi, neighbours
    )
    outer: SpeedAndAltitude
    if limits is None:
        outer = None, _left_out("speed", "engine"), None, _left_out("altitude", "engine")
    else:
        outer = _speed_and_altitude(plant, trim, limits, ramp, neighbours)
    speed, speed_row, climb, climb_row = outer
    report = [pitch_row, roll_row, yaw_row, heading_row, speed_row, climb_row]
    return {
        "pitch": pitch,
        "roll": roll,
        "heading": heading,
        "altitude": climb,
        "speed": speed,
        "yaw": yaw,
        "report": tuple(row for row in report if row is not None),
    }


def _left_out(loop: str, control: str) -> LoopReport:
    """The report of a loop that the aircraft has no control for."""
    nan = math.nan
    return LoopReport(loop, nan, nan, nan, nan, nan, relaxed=f"left out: no {control}")


def _roll_and_yaw(
    plant: Plant, loop: Loop, trim: TrimState, vt: float, neighbours: Neighbours
) -> tuple[AttitudeGains, LoopReport, YawGains, LoopReport | None, Plant]:
    """Gains of ailerons and rudder, shaped for a turn, and the plant with both loops closed."""
    slip = math.sin(math.radians(trim.alpha))  # rate of sideslip per roll rate
    slow = slip * req.ROLL_RAMP > req.ROLL_SLIP
    ramp = max(req.ROLL_SLIP / slip, req.ROLL_SLOW) if slow else req.ROLL_RAMP
    travel = -1.0 - trim.aileron, 1.0 - trim.aileron
    rudder = 1.0 - abs(trim.rudder)

    def rolled(yaw: YawGains) -> tuple[AttitudeGains, LoopReport]:
        return design_attitude(damped(plant, yaw), loop, ramp, travel, neighbours)

    if "rudder" not in plant.inputs:
        yaw = YawGains(K=0.0)
        gains, report = design_attitude(plant, loop, ramp, travel, neighbours)
        rolling = closed(plant, ROLL, gains, "phi_cmd")
        return gains, report, yaw, _left_out("yaw", "rudder"), rolling
    damper = design_yaw(plant, rudder)
    rolling = closed(plant, ROLL, rolled(damper)[0], "phi_cmd")
    yaw, outcome = design_rudder(rolling, damper, rudder, vt, ramp, neighbours)
    gains, report = rolled(yaw)
    return gains, report, yaw, outcome, closed(damped(plant, yaw), ROLL, gains, "phi_cmd")


def _speed_and_altitude(
    plant: Plant,
    trim: TrimState,
    limits: EnvelopeLimits,
    ramp: float,
    neighbours: Neighbours,
) -> SpeedAndAltitude:
    """Gains of throttle and rate of climb, each judged with the other loop closed."""
    room = (-trim.throttle[0], 1.0 - trim.throttle[0])
    climb_max = max(limits.climb_max, req.NO_CLIMB)
    rise = min(max(req.RISE_OF_EXCESS * climb_max, req.LEAST_RISE), req.RISE)
    feed, per_knot = design_feed(plant, room, rise)
    step = STEP_REQUIREMENTS["speed"].size
    if per_knot * step >= req.THROTTLE_USE * room[1]:
        step = -step  # not enough throttle for a step up
    hdot_max = min(req.CLIMB, req.CLIMB_OF_EXCESS * climb_max)
    speed = design_speed(plant, trim.speed, room, feed, neighbours)
    altitude, climbing = design_altitude(with_speed(plant, speed), ramp, hdot_max, room, neighbours)
    if not math.isfinite(climbing.settling):
        raise Unstable("altitude", "no gains of the altitude loop settle a step")
    speed = design_speed(plant, trim.speed, room, feed, neighbours, altitude)
    quick = speed_report(with_altitude(plant, altitude), speed, room, step)
    altitude = replace(altitude, theta_max=max(req.THETA_MAX, trim.theta + req.NOSE_UP))
    return speed, quick, altitude, climbing


def _flown(fresh: Callable[[], Aircraft], design: DesignedGains) -> DesignedGains:
    """The report with the steps in pitch and roll flown on the nonlinear aircraft."""
    report = list(design.report)
    # the autopilot requires gains for all loops
    gains = replace(
        design, altitude=design.altitude or _NO_ALTITUDE, speed=design.speed or _NO_SPEED
    )
    for i, row in enumerate(report):
        if row.loop in ("pitch", "roll"):
            step = STEPS[row.loop]
            try:
                flight = fly_step(fresh, gains, step, seconds=10.0)
            except FlightError as error:
                text = f"the step in {row.loop} ends the flight: {error}"
                raise Unstable(row.loop, text) from error
            flown, note = flight.quality, row.relaxed
            if math.isinf(flown.settling):
                late = flight.outputs[step.output][flight.time > flight.time[-1] - 5.0]
                swing = f"limit cycle of +-{(late.max() - late.min()) / 2:.2f} {step.required.unit}"
                note = f"{note}, {swing}" if note else swing
            report[i] = replace(
                row,
                flown_settling=flown.settling,
                flown_overshoot=flown.overshoot,
                relaxed=note,
            )
    return replace(design, report=tuple(report))
