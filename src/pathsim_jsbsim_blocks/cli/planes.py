"""``aircraft``, ``properties``, ``trim``, ``modes`` and ``gains``."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import math
import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..errors import BlocksError, DesignError, TrimError
from .arguments import (
    AIRCRAFT,
    CONDITION,
    CREATE,
    ROOT,
    SET,
    SUBSTEPS,
    command,
    condition_of,
    created,
    file,
    number,
    option,
    setup_and_model,
    switch,
)
from .console import tell
from .saving import check_file, saving_figures

if TYPE_CHECKING:
    from ..design import DesignedGains
    from ..flight.airframe import Airframe
    from ..linear import LinearModel


@command(
    "the aircraft models, and which of them load; of one, what it is and how it flies",
    option("name", "a report of this model", nargs="?"),
    ROOT,
    SET,
    CREATE,
    SUBSTEPS,
)
def aircraft(args: argparse.Namespace) -> int:
    from ..flight import Airframe, aircraft_names

    if args.name is not None:
        from ..studies import aircraft_report

        setup, model = setup_and_model(args)
        report = aircraft_report(args.name, setup=setup, **model)
        print(report)
        return int(not report.loads)
    names = aircraft_names(args.root)
    if not names:
        tell(f"no models in {args.root}: a model is aircraft/NAME/NAME.xml")
    for name in names:
        try:
            airframe = Airframe(name, root=args.root, create=created(args))
            airframe.run_ic()
            n = airframe.engines
            print(f"{name:<14} loads, {n} engine{'' if n == 1 else 's'}")
        except BlocksError as error:
            print(f"{name:<14} {error}")
    return int(not names)


@command(
    "the properties of an aircraft: name, access, value",
    AIRCRAFT,
    option("text", "show only names that contain this", nargs="?", default=""),
    switch("--trim", "values after the trim; implied by any option of the condition"),
    number("--after", "values after a flight from the trim, controls fixed", metavar="SECONDS"),
    *CONDITION,
)
def properties(args: argparse.Namespace) -> None:
    airframe = _in_state(args)
    names = airframe.property_names(args.text)
    if not names:
        # raises PropertyError with suggestions
        airframe.reader(args.text)
    for name in names:
        access = airframe.access(name)
        value = f"{airframe.reader(name)():.10g}" if "r" in access else ""
        print(f"{name:<60} {access}  {value}".rstrip())


def _in_state(args: argparse.Namespace) -> Airframe:
    """The aircraft, initialised, trimmed or flown for some time, depending on the arguments."""
    from pathsim import Simulation

    from .._core.checks import number
    from .._core.running import fly
    from ..flight.aircraft import Aircraft
    from ..flight.airframe import Airframe
    from ..flight.trimming.condition import TrimCondition

    after = 0.0 if args.after is None else number("after", args.after, low=0.0)
    condition, setup, model = condition_of(args), *setup_and_model(args)
    if not (args.trim or setup or args.after is not None or condition != TrimCondition()):
        airframe = Airframe(args.aircraft, **model)
        airframe.run_ic()
        return airframe
    plane = Aircraft(args.aircraft, condition=condition, setup=setup, **model)
    if after:
        fly(Simulation([plane], dt=plane.T, log=False), after)
    return plane.airframe


@contextlib.contextmanager
def _warnings_last() -> Iterator[None]:
    """Print warnings after the result, without the source line, which is not the user's."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        yield
    for warning in caught:
        print(f"  {warning.message}")


@command(
    "trim an aircraft and print the state found",
    AIRCRAFT,
    number(
        "--steady",
        "fly from the trim with controls fixed (default 10 s), and print the departure from it",
        metavar="SECONDS",
        nargs="?",
        const=10.0,
        default=0.0,
    ),
    *CONDITION,
    SUBSTEPS,
)
@_warnings_last()
def trim(args: argparse.Namespace) -> None:
    from ..flight.airframe import Airframe
    from ..flight.trimming import trim as trimmed

    condition, setup, model = condition_of(args), *setup_and_model(args)
    print(trimmed(Airframe(args.aircraft, **model), condition, setup, fly=args.steady))


@command(
    "natural modes about a trim, flying qualities by MIL-F-8785C, margins of the holds",
    AIRCRAFT,
    option("--method", "flown (default): from small pulses; algebraic: rigid", default="flown"),
    option("--class", "I, II-L (default: medium, land-based), II-C, III, IV", default="II-L"),
    option("--category", "flight phases: A, B (default: climb, cruise) or C", default="B"),
    file("--save", "draw the poles into this file", "FIG"),
    file("--json", "write the linear model"),
    *CONDITION,
    SUBSTEPS,
)
@_warnings_last()
def modes(args: argparse.Namespace) -> None:
    check_file("json", args.json)
    with saving_figures(args.save):
        _print_modes(args)


def _print_modes(args: argparse.Namespace) -> None:
    from ..flight import linear_model
    from ..linear import flying_qualities

    condition, setup, options = condition_of(args), *setup_and_model(args)
    model = linear_model(args.aircraft, condition, args.method, setup=setup, **options)
    qualities = flying_qualities(model, args.category, vars(args)["class"])
    print(f"{args.aircraft}: {condition}")
    print(
        f"  {'mode':<18} {'rad/s':>8} {'damping':>8} {'period s':>9} {'half s':>8} {'double s':>8}"
    )
    for mode in model.modes():
        numbers = (mode.period, mode.time_to_half, mode.time_to_double)
        cells = " ".join(f"{'' if math.isnan(x) else f'{x:.2f}':>8}" for x in numbers)
        damping = f"{mode.damping:8.3f}" if mode.oscillatory else " " * 8
        states = ", ".join(name for name, part in mode.participation.items() if part > 0.1)
        print(f"  {mode.name:<18} {mode.frequency:8.4f} {damping}  {cells}  {states}")
    print(f"  MIL-F-8785C, class {vars(args)['class']}, category {args.category}")
    for quality in qualities:
        level = f"level {quality.level}" if quality.level < 4 else "worse than level 3"
        value = "stable" if math.isinf(quality.value) else f"{quality.value:.3f} {quality.unit}"
        print(f"  {quality.name:<35} {value:<20} {level} ({quality.paragraph})")
    _print_margins(model)
    if args.json is not None:
        model.save(args.json)
        print(f"model saved: {args.json}")
    if args.save is not None:
        from ..linear import pole_map
        from ..plots import show

        show(pole_map(model, title=f"{args.aircraft}: {condition}"), "")


def _print_margins(model: LinearModel) -> None:
    """Margins of the holds with the gain table of the aircraft, where there is one."""
    from ..control.controller import Hold
    from ..control.gain_tables import table, tables
    from ..control.holds import AirspeedHold, HeadingHold, PitchHold, RollHold, YawDamper
    from ..linear import margins

    name = model.aircraft
    if name not in tables():
        return
    pitch = PitchHold(name, T=model.dt)
    loops: list[tuple[Hold, ...]] = [
        (pitch,),
        (RollHold(name, T=model.dt),),
        # as in the Autopilot: without it some Dutch rolls are unstable in this loop
        (HeadingHold(name, T=model.dt), YawDamper(name, T=model.dt)),
    ]
    if table(name).points[0].gains.speed:
        loops.append((AirspeedHold(name, T=model.dt), pitch))
    print(f"  margins with the gains of {name!r}")
    for loop in loops:
        print(f"  {margins(model, *loop)}")


@command(
    "design gains of the autopilot for an aircraft, and report how good they are",
    AIRCRAFT,
    number(
        "--altitude", "ft, one or several (default: of the level flight that is found)", nargs="+"
    ),
    number("--speed", "KCAS, one or several (default likewise)", nargs="+"),
    number("--gear", "0 (up) to 1 (down) (default: up where it retracts)"),
    number("--flaps", "0 to 1"),
    option("--method", "method of the linear model, as for modes", default="flown"),
    file("--save", "write the gains, as gains= takes them", "FILE.json"),
    ROOT,
    SET,
    CREATE,
    SUBSTEPS,
)
def gains(args: argparse.Namespace) -> int:
    from ..design import design_schedule
    from ..flight import level_flight
    from ..flight.fleet import prepared

    check_file("save", args.save, ".json")
    if args.altitude is None or args.speed is None:
        flight = level_flight(
            args.aircraft, args.root, create=created(args), substeps=args.substeps
        )
        condition, properties = flight.condition, flight.create
    else:
        airframe, condition = prepared(args.aircraft, args.root, created(args), args.substeps)
        properties = airframe.created
        if not airframe.engines:
            condition = dataclasses.replace(condition, mode="glide")
    setup, model = setup_and_model(args)
    model["create"] = properties
    fields = {"setup": {**condition.setup, **setup}, "gear": args.gear, "flaps": args.flaps}
    fields = {name: value for name, value in fields.items() if value is not None}
    condition = dataclasses.replace(condition, **fields)
    altitudes, speeds = args.altitude or [condition.altitude], args.speed or [condition.speed]
    # condition of the gains for holds without `vc` and `h` connected
    middle = {"altitude": altitudes[0], "speed": sorted(speeds)[(len(speeds) - 1) // 2]}
    if args.altitude is not None or args.speed is not None:
        condition = dataclasses.replace(condition, **middle)

    def show(result: DesignedGains | Exception) -> None:
        if isinstance(result, Exception):
            tell(str(result))
        else:
            print(f"{result}\n", flush=True)

    try:
        model["method"] = args.method
        gains = design_schedule(args.aircraft, condition, altitudes, speeds, progress=show, **model)
    except (DesignError, TrimError):  # all conditions failed, which is reported already
        return 1
    if args.save is not None:
        gains.save(args.save)
        print(f"gains saved: {args.save}")
    return 0
