"""``study``, ``chart``, ``check`` and ``daveml``."""

from __future__ import annotations

import argparse
import inspect
import math
from pathlib import Path
from typing import Any

from .arguments import (
    AIRCRAFT,
    CREATE,
    FIGURE,
    JOBS,
    RESUME,
    ROOT,
    command,
    created,
    file,
    number,
    option,
    repeatable,
    switch,
    values_in_range,
)
from .saving import check_file, saving_figures


@command(
    "run a study: its table, its figure",
    option("name", "a study; pathsim-jsbsim list names them"),
    FIGURE,
    file("--csv", "write the table as CSV"),
    JOBS,
    RESUME,
    switch("--wide", "the larger grid, if there is one"),
    option("--aircraft", "another aircraft, if the study takes one; likewise the options below"),
    number("--altitude", "ft"),
    option("--speeds", "range of airspeeds, KCAS", metavar="FIRST:LAST:STEP"),
    number("--speed", "one airspeed, KCAS"),
    number("--gamma", "flight path angle, deg"),
)
def study(args: argparse.Namespace) -> None:
    from .._core.checks import one_of, refuse
    from ..plots import show
    from ..studies import STUDIES

    entry = STUDIES[one_of("study", args.name, STUDIES)]
    check_file("csv", args.csv, ".csv", "")  # a pipe has no ending
    options = {**vars(args), "wide": args.wide or None}
    if args.speeds is not None:
        options["speeds"] = values_in_range("speeds", args.speeds)
    parameters = [*inspect.signature(entry.table).parameters]
    for name in ("wide", "aircraft", "altitude", "speeds", "speed", "gamma"):
        if options[name] is not None and name not in parameters:
            options_text = ", ".join(f"--{x}" for x in parameters if x != "progress")
            why = f"the study {args.name} has no option --{name}; it has {options_text}"
            refuse(name, options[name], why)
    with saving_figures(args.save):
        table = entry.table(**{x: options[x] for x in parameters if options.get(x) is not None})
        count = f"{len(table)} rows"
        if "trimmed" in table:
            count = f"{table.trimmed.sum()} of {len(table)} points trim"
        print(f"{args.name}: {count}")
        if args.csv is not None:
            _save_table(table, args.csv)
        figure = entry.figure(table)
        if args.aircraft is not None:
            figure.suptitle(f"{args.aircraft}: {figure.get_suptitle()}")
        show(figure, args.name)


@command(
    "performance: stall, level flight, climb, glide, range, turns, ceilings, V-n; about a minute",
    AIRCRAFT,
    number("--altitude", "ft, one or several", nargs="+"),
    number("--weight", "lb, one or several", nargs="+"),
    number("--flaps", "0 to 1, one or several", nargs="+"),
    repeatable("--save", "write page (.pdf, .png, .svg) or table (.csv)", "FILE", type=Path),
    JOBS,
    RESUME,
    ROOT,
    CREATE,
)
def chart(args: argparse.Namespace) -> None:
    from ..plots import show
    from ..studies import performance_chart, performance_table

    for path in args.save:
        check_file("save", path, ".pdf", ".png", ".svg", ".csv")
    options = {"root": args.root, "create": created(args), "jobs": args.jobs, "resume": args.resume}
    axes = {"altitudes": args.altitude, "weights": args.weight, "flaps": args.flaps}
    table = performance_table(args.aircraft, **axes, **options)
    at = ["quantity", "altitude_ft", "weight_lb", "flaps_norm"]
    result = ["load_factor", "speed_kcas", "value", "unit", "difference_percent", "reason"]
    faults = table[table.fault != ""]
    # print single values; curves are only drawn
    is_single = ~table.duplicated(["chart", *at[:3]], keep=False)
    rows_to_print = is_single | table.value.isna() | table.chart.isin(["V-n", "stall"])
    _print_table(table[rows_to_print][[*at, *result]])
    if len(faults):
        print("faults of the model, values that break an invariant of physics:")
        _print_table(faults[[*at, "speed_kcas", "value", "unit", "fault"]])
    for path in args.save:
        if path.suffix.lower() == ".csv":
            _save_table(table, path)
        else:
            with saving_figures(path):
                show(performance_chart(table), "")


def _print_table(table: Any) -> None:
    number = lambda x: f"{x:.0f}" if abs(x) >= 1000.0 else f"{x:.4g}"  # noqa: E731
    print(table.to_string(index=False, na_rep="", float_format=number), "\n")


def _save_table(table: Any, path: Path) -> None:
    from .._core.files import replacing

    with replacing(path) as file:
        table.to_csv(file, index=False)
    print(f"table saved: {path}")


def _case(text: str) -> float:
    """The number of a case, also from the name of its diagram: check_case_13_1."""
    try:
        return float(text.removeprefix("check_case_").replace("_", "."))
    except ValueError:
        why = f"a case is a number such as 13.1, or check_case_13_1, not {text!r}"
        raise argparse.ArgumentTypeError(why) from None


@command(
    "fly NASA's check cases and compare with NASA's simulators",
    option("case", "1 to 12, 13.1 to 13.4, 15, 16 (default all)", nargs="*", type=_case),
    option("--rate", "steps per second (default 100, and 200 from 11 on)", type=int),
    option("--integrators", "precise (default), or default: JSBSim's own", default="precise"),
    file("--save", "write the figures: FIG, FIG with _2, ...", "FIG"),
)
def check(args: argparse.Namespace) -> int:
    from ..check_cases import CASES, compare, comparison_figure, comparison_table, fly_case
    from ..plots import show

    cases, passes = args.case or [*CASES], 0
    rates: list[int] = []
    with saving_figures(args.save):
        for case in cases:
            rates.append((200 if case > 10 else 100) if args.rate is None else args.rate)
            scopes = fly_case(case, rates[-1], args.integrators)
            deviations = compare(case, *scopes)
            passes += all(d.passes for d in deviations)
            print(comparison_table(case, deviations), flush=True)
            if args.save is not None:
                show(comparison_figure(case, *scopes), "")
    hertz = " and ".join(f"{rate} Hz" for rate in sorted({*rates}))
    print(f"{passes} of {len(cases)} cases pass: at {hertz}, {args.integrators} integrators")
    return int(passes < len(cases))


@command(
    "the variables of a DAVE-ML model, and whether it passes its own check data",
    option("file", "a file, or the name of a model of the package"),
)
def daveml(args: argparse.Namespace) -> int:
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
    failures = [check for check in checks if not check.passes]
    for c in failures:
        print(
            f"FAIL: shot {c.shot!r}: {c.variable} is {c.value:.9g}, not {c.expected:.9g} "
            f"+- {c.tolerance:.3g}"
        )
    shots = len({check.shot for check in checks})
    if not checks:
        print("the file has no check data")
    else:
        print(f"{len(checks) - len(failures)} of {len(checks)} values in {shots} check shots pass")
    return int(bool(failures))
