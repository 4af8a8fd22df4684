"""The commands and their options."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from .. import __version__
from .arguments import engine_numbers
from .editor import convert, export, view_model
from .planes import list_aircraft, list_properties, print_gains, print_modes, print_trim
from .results import check, print_daveml, study
from .runs import list_names, run


def command_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="pathsim-jsbsim",
        description="Fly JSBSim aircraft in PathSim block diagrams, and open them in PathView.",
    )
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")

    def command(name: str, function: Callable, text: str) -> argparse.ArgumentParser:
        sub = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        sub.set_defaults(command=function, parser=sub)
        return sub

    def trust(sub: argparse.ArgumentParser) -> None:
        sub.add_argument(
            "--trust",
            action="store_true",
            help="open a model from outside without asking, now and later; its code runs "
            "as you when the model runs",
        )

    def trust_toolbox(sub: argparse.ArgumentParser) -> None:
        sub.add_argument(
            "--trust-toolbox",
            metavar="PACKAGE[:IMPORT]",
            action="append",
            default=[],
            help="import this toolbox if the model asks for it, even if it is not one "
            "of PathSim's (repeatable)",
        )

    def models(sub: argparse.ArgumentParser) -> None:
        sub.add_argument(
            "--root", metavar="DIR", help="JSBSim root directory with models of your own"
        )

    def written(sub: argparse.ArgumentParser) -> None:
        sub.add_argument(
            "--set",
            metavar="PROPERTY=VALUE",
            action="append",
            default=[],
            help="a property to write before the trim (repeatable)",
        )
        sub.add_argument(
            "--create",
            metavar="PROPERTY=VALUE",
            action="append",
            default=[],
            help="a property that the model expects from FlightGear (repeatable)",
        )

    def trim_condition(sub: argparse.ArgumentParser) -> None:
        models(sub)
        sub.add_argument("--altitude", type=float, default=5000.0, help="ft (default %(default)g)")
        speed = sub.add_mutually_exclusive_group()
        speed.add_argument(
            "--speed",
            type=float,
            default=100.0,
            help="KCAS (default %(default)g; docs/fleet.md has one for each aircraft)",
        )
        speed.add_argument("--mach", type=float, help="instead of --speed")
        sub.add_argument("--gamma", type=float, default=0.0, help="flight path angle, deg")
        sub.add_argument("--heading", type=float, default=0.0, help="deg")
        sub.add_argument("--bank", type=float, default=0.0, help="deg, with --mode turn")
        sub.add_argument("--load-factor", type=float, default=1.0, help="g, with --mode pull-up")
        sub.add_argument(
            "--mode",
            default="full",
            help="full, longitudinal, ground, pull-up, turn, glide or none",
        )
        sub.add_argument("--beta", type=float, default=0.0, help="sideslip angle, deg")
        sub.add_argument("--throttle", type=float, help="0 to 1; the path angle is then free")
        sub.add_argument("--thrust", type=float, help="lbf, instead of --throttle")
        sub.add_argument("--free", help="gamma or speed, with --throttle, --thrust or a glide")
        sub.add_argument("--latitude", type=float, help="deg, north positive")
        sub.add_argument("--longitude", type=float, help="deg, east positive")
        sub.add_argument(
            "--engines-off",
            type=engine_numbers,
            default=(),
            metavar="N,...",
            help="engines that do not run, from 0, or all",
        )
        sub.add_argument("--solver", help="jsbsim or newton (default: JSBSim's where it can)")
        sub.add_argument("--gear", type=float, help="0 up to 1 down")
        sub.add_argument("--flaps", type=float, help="0 to 1")
        written(sub)

    command("list", list_names, "the diagrams and studies of the catalogue")

    sub = command("run", run, "run a diagram or a study: print its results and show its figures")
    sub.add_argument(
        "name",
        help="a diagram or a study of the catalogue, or the path of a script or a model (.pvm)",
    )
    sub.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="build with another value: NAME is BLOCK.PARAMETER (hold.theta_ref=5) or a variable "
        "at the top of the script (repeatable)",
    )
    sub.add_argument("--duration", metavar="SECONDS", type=float, help="simulated time to run for")
    sub.add_argument("--save", metavar="FIG", type=Path, help="write the figure to this file")
    sub.add_argument(
        "--csv",
        metavar="FILE",
        type=Path,
        help="write all recorded signals as CSV, including those of a run that crashes or is "
        "interrupted",
    )
    sub.add_argument(
        "--csv-rate",
        metavar="HZ",
        type=float,
        help="at most so many rows per second in the CSV, each as recorded; default is all",
    )
    sub.add_argument(
        "--track",
        metavar="FILE",
        type=Path,
        action="append",
        default=[],
        help="write the flights of all aircraft: .html (a report), .kml (Google Earth), .acmi "
        "(Tacview), .czml (Cesium), .csv or .parquet (repeatable)",
    )
    sub.add_argument(
        "--flightgear",
        metavar="HOST:PORT",
        nargs="?",
        const="",
        help="fly in real time and send to FlightGear (default 127.0.0.1:5550)",
    )
    trust(sub)
    trust_toolbox(sub)

    sub = command("aircraft", list_aircraft, "the aircraft models, and which of them load")
    sub.add_argument("name", nargs="?", help="one model only")
    models(sub)
    sub.add_argument(
        "--points",
        metavar="FIG",
        type=Path,
        help="draw the points that the model names: CG, wheels, tanks, ...",
    )
    sub.add_argument(
        "--table",
        action="store_true",
        help="trim each in level flight or a glide and fly it for 30 s, controls fixed",
    )

    sub = command(
        "properties",
        list_properties,
        "the properties of an aircraft: name, access, value as initialised, after the "
        "trim or in flight",
    )
    sub.add_argument("aircraft")
    sub.add_argument("text", nargs="?", default="", help="show only names that contain this")
    sub.add_argument(
        "--trim",
        action="store_true",
        help="values after the trim; implied by any option of the condition",
    )
    sub.add_argument(
        "--after",
        metavar="SECONDS",
        type=float,
        help="values after this time of flight from the trim, controls fixed",
    )
    trim_condition(sub)

    sub = command("trim", print_trim, "trim an aircraft and print the state found")
    sub.add_argument("aircraft")
    sub.add_argument(
        "--steady",
        type=float,
        nargs="?",
        const=10.0,
        default=0.0,
        metavar="SECONDS",
        help="fly from the trim (default 10 s), controls fixed, and say how far it is from it then",
    )
    trim_condition(sub)

    sub = command(
        "modes",
        print_modes,
        "the natural modes of an aircraft about a trim, and its flying qualities by MIL-F-8785C",
    )
    sub.add_argument("aircraft")
    sub.add_argument(
        "--method",
        default="flown",
        help="flown (identified from small pulses in flight) or algebraic (of the rigid aircraft)",
    )
    sub.add_argument(
        "--class",
        dest="aircraft_class",
        default="II-L",
        help="I, II-L, II-C, III or IV (default %(default)s: medium, land-based)",
    )
    sub.add_argument(
        "--category",
        default="B",
        help="flight phases: A, B or C (default %(default)s: climb, cruise)",
    )
    sub.add_argument("--save", metavar="FIG", type=Path, help="draw the poles into this file")
    sub.add_argument("--json", metavar="FILE", type=Path, help="write the linear model")
    trim_condition(sub)

    sub = command(
        "gains",
        print_gains,
        "design gains of the autopilot for an aircraft, and report how good they are",
    )
    sub.add_argument("aircraft")
    for option, unit in (("altitude", "ft"), ("speed", "KCAS")):
        sub.add_argument(
            f"--{option}",
            metavar=unit.upper(),
            type=float,
            nargs="+",
            help=f"{unit}, one or several (default: where docs/fleet.md has it in level flight)",
        )
    sub.add_argument("--gear", type=float, help="0 up to 1 down (default: up where it retracts)")
    sub.add_argument("--flaps", type=float, help="0 to 1")
    sub.add_argument(
        "--save", metavar="FILE.json", type=Path, help="write the gains, as gains= takes them"
    )
    models(sub)
    written(sub)

    sub = command("study", study, "run a trim study: its table, its figure")
    sub.add_argument(
        "name",
        help="aoa_vs_cas, aoa_vs_cas_loading, climb_schedule, modes_over_speed, thrust_vectoring "
        "or trim_envelope",
    )
    sub.add_argument("--save", metavar="FIG", type=Path, help="write the figure to this file")
    sub.add_argument("--csv", metavar="FILE", type=Path, help="write the table as CSV")
    sub.add_argument("--jobs", metavar="N", type=int, default=-1, help="cores (default all)")
    sub.add_argument(
        "--resume",
        metavar="FILE",
        type=Path,
        help="keep finished points in this file, and resume from it",
    )
    sub.add_argument("--wide", action="store_true", help="the larger grid, if there is one")
    own = sub.add_argument_group("another aircraft or condition, if the study accepts it")
    own.add_argument("--aircraft", metavar="NAME", help="a JSBSim model")
    own.add_argument("--altitude", metavar="FT", type=float)
    own.add_argument("--speeds", metavar="FIRST:LAST:STEP", help="range of airspeeds, KCAS")
    own.add_argument("--speed", metavar="KCAS", type=float, help="one airspeed")
    own.add_argument("--gamma", metavar="DEG", type=float, help="flight path angle")

    sub = command("check", check, "fly NASA's check cases and compare with NASA's simulators")
    sub.add_argument("case", nargs="*", type=int, help="1 to 10 (default all)")
    sub.add_argument(
        "--rate", metavar="HZ", type=int, default=100, help="steps per second (default %(default)s)"
    )
    sub.add_argument(
        "--integrators",
        default="precise",
        help="default, which is JSBSim's own, or precise (default %(default)s)",
    )
    sub.add_argument(
        "--save", metavar="FIG", type=Path, help="write the figures: FIG, FIG with _2, ..."
    )

    sub = command(
        "daveml",
        print_daveml,
        "the variables of a DAVE-ML model, and whether it passes its own check data",
    )
    sub.add_argument("file", metavar="FILE", help="the model, or the name of one of the package")

    sub = command("view", view_model, "open a diagram in PathView")
    sub.add_argument(
        "target",
        nargs="?",
        help="a diagram, a model (.pvm) or a script; default is an empty diagram",
    )
    sub.add_argument("--port", type=int, help="default is 8360, or a free one")
    sub.add_argument("--no-browser", action="store_true", help="only serve")
    trust(sub)
    trust_toolbox(sub)

    sub = command("export", export, "write a diagram script as a PathView model")
    sub.add_argument("script", help="a diagram of the catalogue, or the path of a script")
    sub.add_argument(
        "-o",
        "--output",
        metavar="FILE.pvm",
        type=Path,
        help="default is NAME.pvm, beside the script or, for the catalogue, here",
    )

    sub = command("convert", convert, "write a PathView model as a Python script")
    sub.add_argument("model", metavar="FILE", type=Path, help=".pvm or .json")
    sub.add_argument(
        "-o",
        "--output",
        metavar="FILE.py",
        type=Path,
        help="default is NAME.py beside the model, if that does not exist yet",
    )
    sub.add_argument(
        "--toolbox",
        metavar="PACKAGE[:IMPORT]",
        action="append",
        default=[],
        help="a toolbox that the model itself does not name (repeatable)",
    )
    trust_toolbox(sub)
    return parser
