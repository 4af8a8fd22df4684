"""``study``, ``chart``, ``check`` and ``daveml``."""

from __future__ import annotations

import argparse
import importlib.util
import inspect
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import FileError
from .arguments import (
    Commands,
    add_command,
    file_option,
    repeatable,
    root_option,
    switch,
    values_in_range,
)
from .saving import check_csv, check_file, saving_figures


def studies() -> Mapping[str, Any]:
    """The studies by name; none where jsbsim is not installed."""
    if importlib.util.find_spec("jsbsim") is None:
        return {}
    from ..studies import STUDIES

    return STUDIES


def add_study(commands: Commands) -> None:
    sub = add_command(commands, "study", study, "run a trim study: its table, its figure")
    text = "aoa_vs_cas, aoa_vs_cas_loading, climb_schedule, modes_over_speed, thrust_vectoring "
    sub.add_argument("name", help=text + "or trim_envelope")
    file_option(sub, "--save", metavar="FIG", text="write the figure to this file")
    file_option(sub, "--csv", metavar="FILE", text="write the table as CSV")
    _jobs(sub)
    switch(sub, "--wide", "the larger grid, if there is one")
    own = sub.add_argument_group("another aircraft or condition, if the study accepts it")
    own.add_argument("--aircraft", metavar="NAME", help="a JSBSim model")
    own.add_argument("--altitude", metavar="FT", type=float)
    own.add_argument("--speeds", metavar="FIRST:LAST:STEP", help="range of airspeeds, KCAS")
    own.add_argument("--speed", metavar="KCAS", type=float, help="one airspeed")
    own.add_argument("--gamma", metavar="DEG", type=float, help="flight path angle")


def _jobs(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--jobs", metavar="N", type=int, default=-1, help="cores (default all)")
    text = "keep finished points in this file, and resume from it"
    file_option(sub, "--resume", metavar="FILE", text=text)


def study(args: argparse.Namespace) -> None:
    names = ("jobs", "resume", "aircraft", "altitude", "speed", "gamma")
    options = {name: getattr(args, name) for name in names}
    if args.speeds is not None:
        options["speeds"] = values_in_range("speeds", args.speeds)
    run_study(args.name, args.save, args.csv, wide=args.wide or None, **options)


def run_study(name: str, figure_file: Path | None, csv_file: Path | None, **options: Any) -> None:
    """Compute a study, print its result and show its figure; options that are None are left out."""
    from .._core.checks import one_of, refuse
    from ..plots import show
    from ..studies import STUDIES

    study = STUDIES[one_of("study", name, STUDIES)]
    options = {option: value for option, value in options.items() if value is not None}
    taken = inspect.signature(study.table).parameters
    for option, value in options.items():
        if option not in taken:
            known = ", ".join(f"--{x}" for x in taken if x != "progress")
            refuse(option, value, f"the study {name} takes no --{option}; it takes {known}")
    check_csv(csv_file)
    with saving_figures(figure_file):
        table = study.table(**options)
        trimmed = int(table["trimmed"].sum())
        print(f"{name}: {trimmed} of {len(table)} points trim")
        if csv_file is not None:
            _save_table(table, csv_file)
        figure = study.figure(table)
        if "aircraft" in options:
            figure.suptitle(f"{options['aircraft']}: {figure.get_suptitle()}")
        show(figure, name)


def add_chart(commands: Commands) -> None:
    text = "what an aircraft can do: stall, level flight, climb, glide, range, turns, ceilings, V-n"
    sub = add_command(commands, "chart", chart, text)
    sub.add_argument("aircraft")
    for name, unit in (("altitude", "ft"), ("weight", "lb"), ("flaps", "0 to 1")):
        help_text = f"{unit}, one or several"
        sub.add_argument(f"--{name}", metavar=name.upper(), type=float, nargs="+", help=help_text)
    text = "write the page (.pdf, .png, .svg) or the table (.csv) to this file"
    repeatable(sub, "--save", "FILE", text, type=Path)
    text = "compare with these values of a handbook, at their conditions"
    file_option(sub, "--handbook", metavar="FILE.csv", text=text)
    _jobs(sub)
    root_option(sub)


def chart(args: argparse.Namespace) -> None:
    from .._core.checks import refuse
    from ..plots import show
    from ..studies import against_handbook, performance_chart, performance_table

    for path in args.save:
        check_file("save", path, ".pdf", ".png", ".svg", ".csv")
    options = {"root": args.root, "jobs": args.jobs, "resume": args.resume}
    at = ["quantity", "altitude_ft", "weight_lb", "flaps_norm"]
    found = ["unit", "difference_percent", "reason"]
    if args.handbook is not None:
        for name in ("altitude", "weight", "flaps"):
            if getattr(args, name) is not None:
                refuse(name, getattr(args, name), f"--handbook has its own: leave out --{name}")
        written, table = against_handbook(args.aircraft, args.handbook, **options)
        _print_table(written[[*at, "speed_kcas", "value", "model", *found]])
        terms = written.columns[written.columns.get_loc("reason") + 1 : -1]
        _print_table(written[["altitude_ft", "weight_lb", *terms]].drop_duplicates())
    else:
        axes = {"altitudes": args.altitude, "weights": args.weight, "flaps": args.flaps}
        written = table = performance_table(args.aircraft, **axes, **options)
        # a curve is drawn, its best value is printed
        single = ~table.duplicated(["chart", *at[:3]], keep=False)
        kept = single | table.value.isna() | table.chart.isin(["V-n", "stall"])
        _print_table(table[kept][[*at, "load_factor", "speed_kcas", "value", *found]])
    for path in args.save:
        if path.suffix.lower() == ".csv":
            _save_table(written, path)
        else:
            with saving_figures(path):
                show(performance_chart(table), "")


def _print_table(table: Any) -> None:
    number = lambda x: f"{x:.0f}" if abs(x) >= 1000.0 else f"{x:.4g}"  # noqa: E731
    print(table.to_string(index=False, na_rep="", float_format=number), "\n")


def _save_table(table: Any, path: Path) -> None:
    from .._core.files import replacing

    try:
        with replacing(path) as file:
            table.to_csv(file, index=False)
    except OSError as error:
        raise FileError("write", path, error) from None
    print(f"table saved: {path}")


def add_check(commands: Commands) -> None:
    text = "fly NASA's check cases and compare with NASA's simulators"
    sub = add_command(commands, "check", check, text)
    text = "1 to 12, 13.1 to 13.4, 15, 16 (default all)"
    sub.add_argument("case", nargs="*", type=float, help=text)
    text = "steps per second (default 100, and 200 from 11 on)"
    sub.add_argument("--rate", metavar="HZ", type=int, help=text)
    text = "default, which is JSBSim's own, or precise (default %(default)s)"
    sub.add_argument("--integrators", default="precise", help=text)
    file_option(sub, "--save", metavar="FIG", text="write the figures: FIG, FIG with _2, ...")


def check(args: argparse.Namespace) -> int:
    from ..check_cases import CASES, compare, comparison_figure, comparison_table, fly_case
    from ..plots import show

    cases, passed = args.case or [*CASES], 0
    rates: list[int] = []
    with saving_figures(args.save):
        for case in cases:
            rates.append(args.rate or (200 if case > 10 else 100))
            scopes = fly_case(case, rates[-1], args.integrators)
            deviations = compare(case, *scopes)
            passed += all(d.passes for d in deviations)
            print(comparison_table(case, deviations), flush=True)
            if args.save is not None:
                show(comparison_figure(case, *scopes), "")
    hertz = " and ".join(f"{rate} Hz" for rate in sorted({*rates}))
    print(f"{passed} of {len(cases)} cases pass: at {hertz}, {args.integrators} integrators")
    return int(passed < len(cases))


def add_daveml(commands: Commands) -> None:
    text = "the variables of a DAVE-ML model, and whether it passes its own check data"
    sub = add_command(commands, "daveml", print_daveml, text)
    sub.add_argument("file", metavar="FILE", help="the model, or the name of one of the package")


def print_daveml(args: argparse.Namespace) -> int:
    from ..daveml import DaveModel

    model = DaveModel(args.file)
    print(f"{model.path}: {len(model.variables)} variables")
    rows = [("varID", "name", "kind", "unit", "sign", "limits", "value")]
    for v in model.variables.values():
        kind = f"{v.kind}, output" if v.is_output else v.kind
        limits = "" if v.low == -math.inf and v.high == math.inf else f"{v.low:g} to {v.high:g}"
        value = "" if v.initial is None or v.kind in ("calculation", "table") else f"{v.initial:g}"
        rows.append((v.id, v.name, kind, v.units, v.sign, limits, value))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(x.ljust(width) for x, width in zip(row, widths, strict=True)).rstrip())
    checks = model.verify()
    failed = [check for check in checks if not check.passes]
    for c in failed:
        print(
            f"FAIL: shot {c.shot!r}: {c.variable} is {c.value:.9g}, not {c.expected:.9g} "
            f"+- {c.tolerance:.3g}"
        )
    shots = len({check.shot for check in checks})
    if not checks:
        print("the file has no check data")
    else:
        print(f"{len(checks) - len(failed)} of {len(checks)} values in {shots} check shots pass")
    return int(bool(failed))


COMMANDS = (add_study, add_chart, add_check, add_daveml)
