"""``aircraft``, ``properties``, ``trim``, ``modes`` and ``gains``."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import math
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import BlocksError, DesignError, ParameterError, TrimError
from .arguments import condition_of, values_of
from .saving import saving_figures

if TYPE_CHECKING:
    from ..design import DesignedGains
    from ..flight.airframe import Airframe


def list_aircraft(args: argparse.Namespace) -> None:
    from ..flight.airframe import Airframe, aircraft_names

    if args.table:
        if args.root is not None:
            raise ParameterError(
                "--table covers the models that jsbsim brings; it takes no --root",
                parameter="root",
                value=args.root,
            )
        from ..flight.fleet import HEADER, fleet_table, format_row

        print(HEADER, end="")
        for row in fleet_table():
            print(format_row(row), flush=True)
        return
    if args.points is not None:
        _draw_points(args.name, args.root, args.points)
        return
    for name in aircraft_names(args.root) if args.name is None else [args.name]:
        try:
            airframe = Airframe(name, root=args.root)
            airframe.run_ic()
            n = airframe.engines
            print(f"{name:<14} loads, {n} engine{'' if n == 1 else 's'}")
        except BlocksError as error:
            if args.name is not None:
                raise
            print(f"{name:<14} {error}")


def _draw_points(name: str | None, root: str | None, path: Path) -> None:
    from ..flight.airframe import Airframe
    from ..flight.points import aircraft_points
    from ..plots import aircraft_points as draw
    from ..plots import show

    if name is None:
        raise ParameterError(
            "--points needs the name of an aircraft", parameter="points", value=str(path)
        )
    airframe = Airframe(name, root=root)
    airframe.run_ic()
    points = aircraft_points(airframe)
    for kind, found in points.items():
        for x, y, z in found:
            print(f"{kind:<28} x {x:9.2f}  y {y:9.2f}  z {z:9.2f} in")
    with saving_figures(path):
        show(draw(points, f"{name}: named points"), "")


def list_properties(args: argparse.Namespace) -> None:
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
    """The aircraft, initialised, trimmed or flown for some time as the arguments require."""
    from pathsim import Simulation

    from .._core.checks import number
    from .._core.running import fly
    from ..flight.aircraft import Aircraft
    from ..flight.airframe import Airframe
    from ..flight.condition import TrimCondition

    after = 0.0 if args.after is None else number("after", args.after, low=0.0)
    setup, create = values_of("set", args.set), values_of("create", args.create)
    condition = condition_of(args)
    if not (args.trim or setup or args.after is not None or condition != TrimCondition()):
        airframe = Airframe(args.aircraft, root=args.root, create=create)
        airframe.run_ic()
        return airframe
    plane = Aircraft(args.aircraft, condition=condition, setup=setup, root=args.root, create=create)
    if after:
        fly(Simulation([plane], dt=plane.T, log=False), after)
    return plane.airframe


@contextlib.contextmanager
def _warnings_last() -> Iterator[None]:
    """Print what is warned of after the result: there is no line of the user's to show."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("default")
        yield
    for warning in said:
        print(f"  {warning.message}")


@_warnings_last()
def print_trim(args: argparse.Namespace) -> None:
    from ..flight._trim import trim
    from ..flight.airframe import Airframe

    setup, create = values_of("set", args.set), values_of("create", args.create)
    condition = condition_of(args)
    airframe = Airframe(args.aircraft, root=args.root, create=create)
    print(trim(airframe, condition, setup, steady=args.steady))


@_warnings_last()
def print_modes(args: argparse.Namespace) -> None:
    from .._core.checks import writable

    if args.json is not None:
        writable("json", args.json)
    with saving_figures(args.save):
        _print_modes(args)


def _print_modes(args: argparse.Namespace) -> None:
    from ..flight.linear import linear_model
    from ..linear import flying_qualities

    condition = condition_of(args)
    model = linear_model(
        args.aircraft,
        condition,
        args.method,
        setup=values_of("set", args.set),
        root=args.root,
        create=values_of("create", args.create),
    )
    qualities = flying_qualities(model, args.category, args.aircraft_class)
    print(f"{args.aircraft}: {condition}")
    print(
        f"  {'mode':<18} {'rad/s':>8} {'damping':>8} {'period s':>9} {'half s':>8} {'double s':>8}"
    )
    for mode in model.modes():
        numbers = (mode.period, mode.time_to_half, mode.time_to_double)
        cells = " ".join(f"{'' if math.isnan(x) else f'{x:.2f}':>8}" for x in numbers)
        damping = f"{mode.damping:8.3f}" if mode.oscillatory else " " * 8
        states = ", ".join(name for name, share in mode.participation.items() if share > 0.1)
        print(f"  {mode.name:<18} {mode.frequency:8.4f} {damping}  {cells}  {states}")
    print(f"  MIL-F-8785C, class {args.aircraft_class}, category {args.category}")
    for quality in qualities:
        level = f"level {quality.level}" if quality.level < 4 else "worse than level 3"
        value = "stable" if math.isinf(quality.value) else f"{quality.value:.3f} {quality.unit}"
        print(f"  {quality.name:<35} {value:<20} {level} ({quality.paragraph})")
    if args.json is not None:
        model.save(args.json)
        print(f"model saved: {args.json}")
    if args.save is not None:
        from ..plots import pole_map, show

        show(pole_map(model, title=f"{args.aircraft}: {condition}"), "")


def print_gains(args: argparse.Namespace) -> int:
    from .._core.checks import ending, writable
    from ..design import design_schedule
    from ..flight import level_flight
    from ..flight.fleet import prepared

    if args.save is not None:
        ending("save", writable("save", args.save), ".json")
    if args.altitude is None or args.speed is None:
        flight = level_flight(args.aircraft, args.root)
        condition, needed = flight.condition, flight.create
    else:
        _, needed, condition = prepared(args.aircraft, args.root)
    create = {**needed, **values_of("create", args.create)}
    setup = {**condition.setup, **values_of("set", args.set)}
    given = {"gear": args.gear, "flaps": args.flaps}
    condition = dataclasses.replace(
        condition,
        setup=setup,
        **{name: value for name, value in given.items() if value is not None},
    )
    altitudes, speeds = args.altitude or [condition.altitude], args.speed or [condition.speed]
    # holds that do not know the airspeed or the altitude have the gains there
    middle = {"altitude": altitudes[0], "speed": sorted(speeds)[(len(speeds) - 1) // 2]}
    if args.altitude is not None or args.speed is not None:
        condition = dataclasses.replace(condition, **middle)

    def tell(found: DesignedGains | Exception) -> None:
        if isinstance(found, Exception):
            print(f"pathsim-jsbsim: {found}", file=sys.stderr)
        else:
            print(f"{found}\n", flush=True)

    try:
        found = design_schedule(
            args.aircraft,
            condition,
            altitudes,
            speeds,
            progress=tell,
            root=args.root,
            create=create,
        )
    except (DesignError, TrimError):  # at no condition: told already
        return 1
    if args.save is not None:
        found.save(args.save)
        print(f"gains saved: {args.save}")
    return 0
