"""Commands, their options, and the conversion of options' values."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from ..flight.trimming.condition import TrimCondition


# names of an option or an argument, and the keywords of `add_argument`
Option: TypeAlias = tuple[tuple[str, ...], dict[str, Any]]


class Command(NamedTuple):
    """A command: its function, a one-line description, and its options."""

    function: Callable[[argparse.Namespace], int | None]
    text: str
    options: tuple[Option, ...]


COMMANDS: dict[str, Command] = {}  # by name


def command(text: str, *options: Option) -> Callable[[Any], Any]:
    """A decorator that registers a function as a command; a final underscore is dropped."""

    def register(function: Any) -> Any:
        COMMANDS[function.__name__.rstrip("_")] = Command(function, text, options)
        return function

    return register


def option(name: str, text: str, **keywords: Any) -> Option:
    return tuple(name.split()), {"help": text, **keywords}


def number(name: str, text: str, **keywords: Any) -> Option:
    return option(name, text, type=float, **keywords)


def switch(name: str, text: str) -> Option:
    return option(name, text, action="store_true")


def file(name: str, text: str, metavar: str = "FILE", **keywords: Any) -> Option:
    return option(name, text, metavar=metavar, type=Path, **keywords)


def repeatable(name: str, text: str, metavar: str, **keywords: Any) -> Option:
    more = {"metavar": metavar, "action": "append", "default": [], **keywords}
    return option(name, f"{text} (repeatable)", **more)


def engine_numbers(text: str) -> tuple[int, ...] | str:
    try:
        return text if text == "all" else tuple(map(int, text.split(",")))
    except ValueError:
        why = f"numbers of engines from 0, such as 0,2, or all, not {text!r}"
        raise argparse.ArgumentTypeError(why) from None


# shared options

AIRCRAFT = option("aircraft", "name of a JSBSim model")
ROOT = option("--root", "JSBSim root directory with models of your own", metavar="DIR")
FIGURE = file("--save", "write the figure to this file", "FIG")
JOBS = option("--jobs", "cores (default all)", metavar="N", type=int, default=-1)
RESUME = file("--resume", "keep finished points in this file, and resume from it")
TRUST = switch(
    "--trust",
    "open a model from outside without asking, now and later; its code runs as you when it runs",
)
TOOLBOX = repeatable(
    "--trust-toolbox",
    "import this toolbox if the model requires it, even if it is not one of PathSim's",
    "PACKAGE[:IMPORT]",
)
SET = repeatable("--set", "a property to write before the trim", "PROPERTY=VALUE")
CREATE = repeatable(
    "--create",
    "a property that the model expects from FlightGear; missing creates all of them, as 0",
    "PROPERTY=VALUE",
)

SUBSTEPS = option(
    "--substeps", "steps of JSBSim per 1/120 s (default 1)", metavar="N", type=int, default=1
)

# options of a trim are named as the fields of TrimCondition, which has their defaults
_NUMBERS = {
    "altitude": "ft (default 5000)",
    "speed": "KCAS (default 100; the command aircraft NAME finds one)",
    "mach": "instead of --speed",
    "gamma": "flight path angle, deg",
    "heading": "deg",
    "bank": "deg, with --mode turn",
    "load-factor": "g, with --mode pull-up",
    "beta": "sideslip angle, deg",
    "throttle": "0 to 1; the path angle is then free",
    "thrust": "lbf, instead of --throttle",
    "wind-north": "ft/s, towards the north",
    "wind-east": "ft/s, towards the east",
    "latitude": "deg, north positive",
    "longitude": "deg, east positive",
    "gear": "0 (up) to 1 (down)",
    "flaps": "0 to 1",
}
_TEXTS = {
    "mode": "full (default), longitudinal, ground, pull-up, turn, glide or none",
    "free": "gamma or speed, with --throttle, --thrust or a glide",
    "solver": "newton (default) or jsbsim, as in the published notebooks",
}
CONDITION = (
    ROOT,
    *(number(f"--{name}", text) for name, text in _NUMBERS.items()),
    *(option(f"--{name}", text) for name, text in _TEXTS.items()),
    option(
        "--engines-off", "engines not running, from 0, or all", type=engine_numbers, metavar="N,N"
    ),
    SET,
    CREATE,
)


def is_jsbsim_script(name: str | Path, root: str | None) -> bool:
    """Whether a file is a script of JSBSim; others have no use for ``--root``."""
    from .._core.checks import refuse

    if Path(name).suffix == ".xml":
        return True
    if root is not None:
        refuse("root", root, "--root is for JSBSim scripts (.xml)")
    return False


def condition_of(args: argparse.Namespace) -> TrimCondition:
    from .._core.checks import refuse
    from ..flight.trimming.condition import TrimCondition

    if args.mach is not None and args.speed is not None:
        refuse("mach", args.mach, "--mach and --speed exclude each other")
    names = {field.name for field in dataclasses.fields(TrimCondition)}
    fields = {n: x for n, x in vars(args).items() if n in names and x is not None}
    return TrimCondition(**fields)


def setup_and_model(args: argparse.Namespace) -> tuple[dict[str, float], dict[str, Any]]:
    """Properties to write before the trim, and the options with which a model is loaded."""
    model = {"root": args.root, "create": created(args)}
    # of the commands that have the option
    model |= {"substeps": args.substeps} if "substeps" in args else {}
    return values_of("set", args.set), model


def created(args: argparse.Namespace) -> dict[str, float] | str:
    """The argument ``create`` of an `Airframe`."""
    values = values_of("create", (item for item in args.create if item != "missing"))
    return {"missing": True, **values} if "missing" in args.create else values


def values_of(option: str, items: Iterable[str]) -> dict[str, float]:
    from .._core.checks import refuse

    values = {}
    for item in items:
        name, _, value = item.partition("=")
        try:
            values[name] = float(value)
        except ValueError:
            refuse(option, item, f"--{option} needs PROPERTY=VALUE with a number, not {item!r}")
    return values


def values_in_range(option: str, text: str) -> list[float]:
    """The numbers of FIRST:LAST:STEP, including the last."""
    from .._core.checks import refuse

    try:
        first, last, step = map(float, text.split(":"))
        count = int((last - first) / step + 1e-9)
        if not 0 <= count < 10_000:
            raise ValueError
    except (ValueError, OverflowError, ZeroDivisionError):
        refuse(option, text, f"--{option} needs FIRST:LAST:STEP, such as 60:120:10, not {text!r}")
    return [first + i * step for i in range(count + 1)]
