"""Options that several commands have, and values of options."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from ..flight.trimming.condition import TrimCondition

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


def add_command(
    commands: Commands, name: str, function: Callable, text: str
) -> argparse.ArgumentParser:
    sub = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
    sub.set_defaults(command=function, parser=sub)
    return sub


def repeatable(
    sub: argparse.ArgumentParser, option: str, metavar: str, text: str, **more: Any
) -> None:
    help_text = f"{text} (repeatable)"
    sub.add_argument(option, metavar=metavar, action="append", default=[], help=help_text, **more)


def switch(sub: argparse.ArgumentParser, option: str, text: str) -> None:
    sub.add_argument(option, action="store_true", help=text)


def file_option(sub: argparse.ArgumentParser, *options: str, metavar: str, text: str) -> None:
    sub.add_argument(*options, metavar=metavar, type=Path, help=text)


def trust_options(sub: argparse.ArgumentParser) -> None:
    text = "open a model from outside without asking, now and later; its code runs "
    switch(sub, "--trust", text + "as you when the model runs")
    trust_toolbox_option(sub)


def trust_toolbox_option(sub: argparse.ArgumentParser) -> None:
    text = "import this toolbox if the model asks for it, even if it is not one of PathSim's"
    repeatable(sub, "--trust-toolbox", "PACKAGE[:IMPORT]", text)


def root_option(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--root", metavar="DIR", help="JSBSim root directory with models of your own")


def property_options(sub: argparse.ArgumentParser) -> None:
    repeatable(sub, "--set", "PROPERTY=VALUE", "a property to write before the trim")
    repeatable(
        sub, "--create", "PROPERTY=VALUE", "a property that the model expects from FlightGear"
    )


def condition_options(sub: argparse.ArgumentParser) -> None:
    root_option(sub)
    sub.add_argument("--altitude", type=float, default=5000.0, help="ft (default %(default)g)")
    speed = sub.add_mutually_exclusive_group()
    text = "KCAS (default %(default)g; docs/evidence/fleet.md has one for each aircraft)"
    speed.add_argument("--speed", type=float, default=100.0, help=text)
    speed.add_argument("--mach", type=float, help="instead of --speed")
    sub.add_argument("--gamma", type=float, default=0.0, help="flight path angle, deg")
    sub.add_argument("--heading", type=float, default=0.0, help="deg")
    sub.add_argument("--bank", type=float, default=0.0, help="deg, with --mode turn")
    sub.add_argument("--load-factor", type=float, default=1.0, help="g, with --mode pull-up")
    text = "full, longitudinal, ground, pull-up, turn, glide or none"
    sub.add_argument("--mode", default="full", help=text)
    sub.add_argument("--beta", type=float, default=0.0, help="sideslip angle, deg")
    sub.add_argument("--throttle", type=float, help="0 to 1; the path angle is then free")
    sub.add_argument("--thrust", type=float, help="lbf, instead of --throttle")
    sub.add_argument("--free", help="gamma or speed, with --throttle, --thrust or a glide")
    sub.add_argument("--latitude", type=float, help="deg, north positive")
    sub.add_argument("--longitude", type=float, help="deg, east positive")
    text = "engines that do not run, from 0, or all"
    sub.add_argument("--engines-off", type=engine_numbers, default=(), metavar="N,...", help=text)
    sub.add_argument("--solver", help="jsbsim or newton (default: JSBSim's where it can)")
    sub.add_argument("--gear", type=float, help="0 up to 1 down")
    sub.add_argument("--flaps", type=float, help="0 to 1")
    property_options(sub)


def condition_of(args: argparse.Namespace) -> TrimCondition:
    from ..flight.trimming.condition import TrimCondition

    # each option of a condition has the name of its field
    fields = {field.name for field in dataclasses.fields(TrimCondition)}
    return TrimCondition(**{name: value for name, value in vars(args).items() if name in fields})


def setup_and_model(args: argparse.Namespace) -> tuple[dict[str, float], dict[str, Any]]:
    """Properties to write before the trim, and the options with which a model is loaded."""
    model = {"root": args.root, "create": values_of("create", args.create)}
    return values_of("set", args.set), model


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


def engine_numbers(text: str) -> tuple[int, ...] | str:
    try:
        return text if text == "all" else tuple(map(int, text.split(",")))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"numbers of engines from 0, such as 0,2, or all, not {text!r}"
        ) from None


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
