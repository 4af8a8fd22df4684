"""The command ``pathsim-jsbsim``."""

from __future__ import annotations

import argparse
import ast
import contextlib
import csv
import dataclasses
import importlib.util
import inspect
import io
import itertools
import math
import os
import sys
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from . import __version__
from .errors import BlocksError, FileError, ParameterError, UntrustedModelError

if TYPE_CHECKING:
    from .flight.airframe import Airframe
    from .flight.condition import TrimCondition

_Opened = TypeVar("_Opened")

_GONE = "the working directory no longer exists: change to another one"


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status.

    0 done, 1 failed with a message, 2 wrong usage or a model that is not trusted.
    """
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        # names that the terminal's encoding lacks
        sys.stdout.reconfigure(errors="backslashreplace")
    args = _parser().parse_args(argv)
    try:
        status = args.command(args) or 0
        sys.stdout.flush()
        return status
    except UntrustedModelError as error:
        print(f"pathsim-jsbsim: {error}, then pass --trust", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # the reader of the pipe (head) has closed it
        sys.stderr.close()
        return 1
    except (BlocksError, OSError) as error:
        # output that could not be written would be tried again at the end of the process
        with contextlib.suppress(OSError):
            sys.stdout.flush()
        message = str(error)
        if _directory_is_gone():
            message = _GONE
        elif not isinstance(error, BlocksError) and error.strerror:
            message = f"{error.filename or 'the output'}: {error.strerror}"
        print(f"pathsim-jsbsim: {message}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("pathsim-jsbsim: interrupted", file=sys.stderr)
        return 130


def _directory_is_gone() -> bool:
    try:
        os.getcwd()
    except OSError:
        return True
    return False


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="pathsim-jsbsim",
        description="Fly JSBSim aircraft in PathSim block diagrams, and open them in PathView.",
    )
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")

    def command(name: str, function: Callable, text: str) -> argparse.ArgumentParser:
        sub = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        sub.set_defaults(command=function)
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
            type=_engines,
            default=(),
            metavar="N,...",
            help="engines that do not run, from 0, or all",
        )
        sub.add_argument("--solver", help="jsbsim or newton (default: JSBSim's where it can)")
        sub.add_argument("--gear", type=float, help="0 up to 1 down")
        sub.add_argument("--flaps", type=float, help="0 to 1")
        written(sub)

    command("list", _list, "the diagrams and studies of the catalogue")

    sub = command("run", _run, "run a diagram or a study: print its results and show its figures")
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
        help="write all recorded signals, including those of a run that crashes or is interrupted",
    )
    sub.add_argument(
        "--track",
        metavar="FILE",
        type=Path,
        help="write the flights of all aircraft: .html (a report), .kml (Google Earth), .acmi "
        "(Tacview), .czml (Cesium), .csv or .parquet",
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

    sub = command("aircraft", _aircraft, "the aircraft models, and which of them load")
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
        help="trim each in level flight or a glide and fly it for 30 s, controls held",
    )

    sub = command(
        "properties",
        _properties,
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
        help="values after this time of flight from the trim, controls held",
    )
    trim_condition(sub)

    sub = command("trim", _trim, "trim an aircraft and print the state found")
    sub.add_argument("aircraft")
    sub.add_argument(
        "--steady",
        type=float,
        nargs="?",
        const=10.0,
        default=0.0,
        metavar="SECONDS",
        help="fly from the trim (default 10 s), controls held, and say how far it is from it then",
    )
    trim_condition(sub)

    sub = command(
        "modes",
        _modes,
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
        _gains,
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

    sub = command("study", _study, "run a trim study: its table, its figure")
    sub.add_argument(
        "name",
        help="aoa_vs_cas, aoa_vs_cas_loading, climb_schedule, modes_over_speed, thrust_vectoring "
        "or trim_envelope",
    )
    sub.add_argument("--save", metavar="FIG", type=Path, help="write the figure to this file")
    sub.add_argument("--csv", metavar="FILE", type=Path, help="write the table")
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

    sub = command("check", _check, "fly NASA's check cases and compare with NASA's simulators")
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

    sub = command("view", _view, "open a diagram in PathView")
    sub.add_argument(
        "target",
        nargs="?",
        help="a diagram, a model (.pvm) or a script; default is an empty diagram",
    )
    sub.add_argument("--port", type=int, help="default is 8360, or a free one")
    sub.add_argument("--no-browser", action="store_true", help="only serve")
    trust(sub)
    trust_toolbox(sub)

    sub = command("export", _export, "write a diagram script as a PathView model")
    sub.add_argument("script", help="a diagram of the catalogue, or the path of a script")
    sub.add_argument(
        "-o",
        "--output",
        metavar="FILE.pvm",
        type=Path,
        help="default is NAME.pvm, beside the script or, for the catalogue, here",
    )

    sub = command("convert", _convert, "write a PathView model as a Python script")
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


def _studies() -> Mapping[str, Any]:
    """The studies by name; none where jsbsim is not installed."""
    if importlib.util.find_spec("jsbsim") is None:
        return {}
    from .studies import STUDIES

    return STUDIES


def _list(args: argparse.Namespace) -> None:
    from .catalogue import diagram_folder, diagram_names

    summaries = {}
    for name in diagram_names():
        text = (diagram_folder() / f"{name}.py").read_text(encoding="utf-8")
        summaries[name] = (ast.get_docstring(ast.parse(text)) or "").partition("\n")[0]
    for name, study in _studies().items():
        summaries[name] = "Study: " + (inspect.getdoc(study.table) or "").partition("\n")[0]
    width = max(map(len, summaries))
    for name, summary in summaries.items():
        print(f"{name:<{width}}  {summary}")


def _run(args: argparse.Namespace) -> int:
    from ._core._pathsim import keep_warnings_visible
    from ._core.checks import positive, writable
    from ._core.running import runs_of, shown_runs
    from ._core.template import Template, main_program
    from .catalogue import find_diagram

    keep_warnings_visible()  # those of a script without a block of ours too
    if args.name in _studies():
        for option, reason in (
            ("track", "flies no aircraft"),
            ("flightgear", "flies no aircraft"),
            ("set", "is no script"),
            ("duration", "is no script"),
        ):
            if getattr(args, option) not in (None, []):
                raise ParameterError(
                    f"the study {args.name} {reason}: it takes no --{option}",
                    parameter=option,
                    value=str(getattr(args, option)),
                )
        _run_study(args.name, args.save, args.csv)
        return 0
    settings, duration, source = _settings(args.set), args.duration, None
    if duration is not None:
        positive("duration", duration)
    # a script may change the directory
    if Path(args.name).suffix in (".pvm", ".json"):
        script = Path(args.name).absolute()
        source = _code_of_model(script, args)
    else:
        script = find_diagram(args.name, _studies()).absolute()
    csv_file = args.csv
    if csv_file is not None:
        csv_file = writable("csv", csv_file).absolute()
    status = 0
    try:
        with (
            _saving(args.save),
            _as_main(script),
            _tracking(args.track),
            shown_runs(),
            _to_flightgear(args.flightgear),
            _model_figures(script) if source is not None else contextlib.nullcontext(),
            contextlib.ExitStack() as timed,
        ):
            try:
                template = Template(script, settings, source)
                constant = duration is not None and template.has_constant("DURATION")
                if constant:
                    settings = {**settings, **_once("DURATION", "duration", settings, duration)}
                    template = Template(script, settings, source)
                runs = timed.enter_context(runs_of(None if constant else duration))
                objects = main_program(template).values()
                if not runs.begun:
                    _no_run(objects, duration, constant)
            except SystemExit as error:  # a script may end normally with sys.exit
                _save(args.save, csv_file, _recording_scopes(_left_by(error)))
                raise
            except BaseException as error:
                status = _stopped(error, script, args.save, csv_file)
                raise
            _save(args.save, csv_file, _recording_scopes(objects))
    except BaseException:
        if not status:
            raise
    return status


def _no_run(objects: Iterable[Any], duration: float | None, constant: bool) -> None:
    """Say that a script made no run; an error if the duration had no effect.

    ``constant`` tells whether the script has a constant for the duration.
    """
    from pathsim import Simulation

    simulations = [x for x in objects if isinstance(x, Simulation)]
    resting = bool(simulations) and all(x.time == 0.0 for x in simulations)
    if not resting and (duration is None or constant):
        return
    said = (
        "the script makes no run with sim.run or fly"
        + (" that --duration could set" if duration is not None else "")
        + (': add sim.run(10) under if __name__ == "__main__":' if resting else "")
    )
    if duration is not None:
        raise ParameterError(said, parameter="duration", value=duration)
    print(f"pathsim-jsbsim: {said}", file=sys.stderr)


def _settings(items: Sequence[str]) -> dict[str, Any]:
    """The values of ``--set NAME=VALUE``, as texts."""
    from ._core.template import Text

    settings: dict[str, Any] = {}
    for item in items:
        name, equals, text = item.partition("=")
        if not (equals and text.strip()):
            raise ParameterError(
                f"--set needs NAME=VALUE, such as hold.theta_ref=5, not {item!r}",
                parameter="set",
                value=item,
            )
        settings.update(_once(name.strip(), "set", settings, Text(text.strip())))
    return settings


def _once(name: str, option: str, settings: Mapping[str, Any], value: Any) -> dict[str, Any]:
    """A setting that is not among those given already."""
    if name in settings:
        raise ParameterError(
            f"--{option}: {name} is set twice, to {settings[name]} and {value}",
            parameter=option,
            value=str(value),
        )
    return {name: value}


def _code_of_model(path: Path, args: argparse.Namespace) -> str:
    """The script of a model, which the user trusts."""
    import linecache

    from .pathview import pvm
    from .pathview.opening import trusted_code

    def code(trust: bool) -> str:
        return trusted_code(pvm.read(path), path, trust, args.trust_toolbox)

    source = _asking(code, args.trust)
    # tracebacks show the lines of the script
    linecache.cache[str(path)] = (len(source), None, source.splitlines(True), str(path))
    return source


@contextlib.contextmanager
def _model_figures(model: Path) -> Iterator[None]:
    """Save the figures that a model shows, where there is no display."""
    import matplotlib.pyplot as plt

    from .plots import show

    usual = plt.show
    names = itertools.chain([model.stem], (f"{model.stem}_{n}" for n in itertools.count(2)))

    def shown(*args: Any, **kwargs: Any) -> None:
        plt.show = usual
        try:
            for n in plt.get_fignums():
                show(plt.figure(n), next(names))
        finally:
            plt.show = shown

    plt.show = shown
    try:
        yield
    finally:
        plt.show = usual


@contextlib.contextmanager
def _tracking(path: Path | None) -> Iterator[None]:
    """Write the flights within this context to a file, also those before a failure."""
    if path is None:
        yield
        return
    from .flight.recording import recorded_flights, tracks
    from .tracks.files import save_tracks, track_file

    path = track_file("track", path).absolute()
    ended = False
    with recorded_flights() as recordings:
        try:
            yield
            ended = True
        finally:
            try:
                flown = tracks(recordings)
                if flown:
                    save_tracks(path, flown)
                    print(f"track saved: {path}")
                elif ended:
                    raise ParameterError(
                        "the script flies no aircraft", parameter="track", value=str(path)
                    )
            except BlocksError as failure:
                if ended:
                    raise
                print(f"pathsim-jsbsim: {failure}", file=sys.stderr)


@contextlib.contextmanager
def _to_flightgear(address: str | None) -> Iterator[None]:
    """Fly in real time and send all aircraft to FlightGear; report the pace kept."""
    if address is None:
        yield
        return
    from ._core.realtime import in_real_time
    from .flight.flightgear import sending_to

    with in_real_time() as pace, sending_to(address):
        try:
            yield
        finally:
            print(pace)


def _save(
    figure: Path | None, csv_file: Path | None, scopes: Sequence[Any], until: str = ""
) -> None:
    """Write the open figures and the signals; a failure of one does not prevent the other.

    ``until``, if given, is the title of a further figure of all that was recorded.
    """
    with contextlib.ExitStack() as last:
        if csv_file is not None:
            last.callback(_write_csv, scopes, csv_file)
        if figure is not None:
            _save_open_figures()
            if until:
                from .plots import show, time_histories

                show(time_histories(*scopes, title=until), "")


def _stopped(error: BaseException, script: Path, figure: Path | None, csv_file: Path | None) -> int:
    """Save what a script recorded before it stopped, and print the reason."""
    scopes = _recording_scopes(_left_by(error))
    saved = ""
    if scopes and (figure is not None or csv_file is not None):
        until = f"until t = {max(scope.recording_time[-1] for scope in scopes):.9g} s"
        try:
            _save(figure, csv_file, scopes, until)
            saved = f"; what was recorded {until} is saved"
        except BlocksError as failure:
            saved = f"; what was recorded {until} is not all saved: {failure}"
    status, message = 1, str(error)
    if isinstance(error, KeyboardInterrupt):
        status, message = 130, "interrupted"
    elif _directory_is_gone():
        message = _GONE
    elif isinstance(error, SyntaxError):
        line = f":{error.lineno}" if error.lineno else ""
        message = f"{error.filename or script}{line}: {error.msg}"
    elif not isinstance(error, BlocksError):
        message = f"{script}: {type(error).__name__}: {error}"
        inside = error.__traceback__
        while inside is not None and inside.tb_frame.f_code.co_filename != str(script):
            inside = inside.tb_next
        if inside is not None:
            # the script's own fault: show its lines, as python does
            traceback.print_exception(type(error), error, inside)
            message = f"{script} failed"
    print(f"pathsim-jsbsim: {message}{saved}", file=sys.stderr)
    return status


def _left_by(error: BaseException) -> list[Any]:
    """Variables of the script that an exception ended, those of its functions included."""
    return [
        x
        for frame, _ in traceback.walk_tb(error.__traceback__)
        for x in list(frame.f_locals.values())
    ]


def _save_open_figures() -> None:
    """Save the figures that a script left open, as ``sim.plot()`` does."""
    import matplotlib.pyplot as plt

    from .plots import show

    for n in plt.get_fignums():
        show(plt.figure(n), "")


def _saving(path: Path | None) -> contextlib.AbstractContextManager[None]:
    from .plots import saving_to

    return contextlib.nullcontext() if path is None else saving_to(path.absolute())


@contextlib.contextmanager
def _as_main(script: Path) -> Iterator[None]:
    """Arguments and import path as ``python script.py`` sets them."""
    argv, path = sys.argv, sys.path[:]
    sys.argv = [str(script)]
    sys.path.insert(0, str(script.resolve().parent))
    try:
        yield
    finally:
        sys.argv, sys.path[:] = argv, path


def _recording_scopes(objects: Iterable[Any]) -> list[Any]:
    """Scopes with a recording, of all simulations among ``objects``."""
    from pathsim import Simulation, Subsystem
    from pathsim.blocks import Scope

    def scopes(blocks: Iterable[Any]) -> Iterator[Scope]:
        for block in blocks:
            if isinstance(block, Scope):
                yield block
            elif isinstance(block, Subsystem):
                yield from scopes(block.blocks)

    simulations = {id(x): x for x in objects if isinstance(x, Simulation)}
    return [
        scope
        for simulation in simulations.values()
        for scope in scopes(simulation.blocks)
        if scope.read()[0] is not None
    ]


def _write_csv(scopes: Sequence[Any], path: Path) -> None:
    from ._core.scopes import recording, signal_label

    if not scopes:
        raise ParameterError(
            "the script has no simulation that a Scope recorded", parameter="csv", value=str(path)
        )
    columns: list[tuple[str, dict[float, float]]] = []
    for scope in scopes:
        time, data = recording(scope)
        for i, values in enumerate(data):
            column = dict(zip(time.tolist(), values.tolist(), strict=True))
            columns.append((signal_label(scope, i), column))
    times = sorted({t for _, column in columns for t in column})
    try:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["time [s]", *(label for label, _ in columns)])
            writer.writerows([t, *(column.get(t, "") for _, column in columns)] for t in times)
    except OSError as error:
        raise FileError("write", path, error) from None
    print(f"signals saved: {path}")


def _aircraft(args: argparse.Namespace) -> None:
    from .flight.airframe import Airframe, aircraft_names

    if args.table:
        if args.root is not None:
            raise ParameterError(
                "--table covers the models that jsbsim brings; it takes no --root",
                parameter="root",
                value=args.root,
            )
        from .flight.fleet import HEADER, fleet_table, format_row

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
    from .flight.airframe import Airframe
    from .flight.points import aircraft_points
    from .plots import aircraft_points as draw
    from .plots import show

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
    with _saving(path):
        show(draw(points, f"{name}: named points"), "")


def _properties(args: argparse.Namespace) -> None:
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

    from ._core.checks import number
    from ._core.running import fly
    from .flight.aircraft import Aircraft
    from .flight.airframe import Airframe
    from .flight.condition import TrimCondition

    after = 0.0 if args.after is None else number("after", args.after, low=0.0)
    setup, create = _values("set", args.set), _values("create", args.create)
    condition = _condition(args)
    if not (args.trim or setup or args.after is not None or condition != TrimCondition()):
        airframe = Airframe(args.aircraft, root=args.root, create=create)
        airframe.run_ic()
        return airframe
    plane = Aircraft(args.aircraft, condition=condition, setup=setup, root=args.root, create=create)
    if after:
        fly(Simulation([plane], dt=plane.T, log=False), after)
    return plane.airframe


def _condition(args: argparse.Namespace) -> TrimCondition:
    from .flight.condition import TrimCondition

    # each option of a condition has the name of its field
    fields = {field.name for field in dataclasses.fields(TrimCondition)}
    return TrimCondition(**{name: value for name, value in vars(args).items() if name in fields})


def _trim(args: argparse.Namespace) -> None:
    from .flight._trim import UNITS, trim
    from .flight.airframe import Airframe

    setup, create = _values("set", args.set), _values("create", args.create)
    condition = _condition(args)
    airframe = Airframe(args.aircraft, root=args.root, create=create)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        state = trim(airframe, condition, setup, steady=args.steady)
    print(f"{args.aircraft}: {condition}")
    rows: dict[str, Any] = {f.name: getattr(state, f.name) for f in dataclasses.fields(state)}
    free, drift = rows.pop("free"), rows.pop("drift")
    if math.isfinite(state.turn_radius):
        rows |= {"turn_rate": state.turn_rate, "turn_radius": state.turn_radius}
    units = {**UNITS, "turn_rate": "deg/s", "turn_radius": "ft"}
    for name, value in rows.items():
        values = value if isinstance(value, tuple) else (value,)
        if values and isinstance(values[0], float):
            # adding 0 turns -0.0 into 0.0
            shown = [round(x, 6) + 0.0 for x in values]
            numbers = "".join(f"{x % 360.0 if name == 'psi' else x:14.6f}" for x in shown)
            degrees = f" ({math.degrees(values[0]):.4f} deg)" if units[name] == "rad" else ""
            print(f"  {name:<13}{numbers} {units[name]}{degrees}".rstrip())
    if free:
        print(f"  {'free':<13} {', '.join(free)}")
    if drift is not None:
        print(
            f"  {'steady' if state.steady else 'not steady'}: after {drift.duration:g} s with "
            f"controls held {drift.height:+.2f} ft, {drift.speed:+.2f} kt, "
            f"{drift.bank:+.2f} deg of bank"
        )
    for warning in said:
        print(f"  {warning.message}")


def _modes(args: argparse.Namespace) -> None:
    from .flight.linear import linear_model
    from .linear import flying_qualities

    condition = _condition(args)
    model = linear_model(
        args.aircraft,
        condition,
        args.method,
        setup=_values("set", args.set),
        create=_values("create", args.create),
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
        from .plots import pole_map, show

        with _saving(args.save):
            show(pole_map(model, title=f"{args.aircraft}: {condition}"), "")


def _engines(text: str) -> tuple[int, ...] | str:
    try:
        return text if text == "all" else tuple(map(int, text.split(",")))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"numbers of engines from 0, such as 0,2, or all, not {text!r}"
        ) from None


def _gains(args: argparse.Namespace) -> None:
    from ._core.checks import writable
    from .design import design_schedule
    from .flight import TrimCondition, level_flight

    if args.save is not None and writable("save", args.save).suffix != ".json":
        raise ParameterError(
            f"gains= reads files that end in .json; did you mean "
            f"{str(Path(args.save).with_suffix('.json'))!r}?",
            parameter="save",
            value=str(args.save),
        )
    create = _values("create", args.create)
    condition = TrimCondition()
    if args.altitude is None or args.speed is None or args.gear is None:
        flight = level_flight(args.aircraft, args.root)
        condition, create = flight.condition, {**flight.create, **create}
    setup = {**condition.setup, **_values("set", args.set)}
    given = {"gear": args.gear, "flaps": args.flaps}
    condition = dataclasses.replace(
        condition,
        setup=setup,
        **{name: value for name, value in given.items() if value is not None},
    )
    altitudes, speeds = args.altitude or [condition.altitude], args.speed or [condition.speed]
    # the middle of what is asked for, where the level flight of the fleet is not in it
    middle = {"altitude": altitudes[0], "speed": sorted(speeds)[(len(speeds) - 1) // 2]}
    if args.altitude is not None or args.speed is not None:
        condition = dataclasses.replace(condition, **middle)
    found = design_schedule(
        args.aircraft,
        condition,
        altitudes,
        speeds,
        progress=lambda design: print(f"{design}\n", flush=True),
        root=args.root,
        create=create,
    )
    if args.save is not None:
        found.save(args.save)
        print(f"gains saved: {args.save}")


def _values(option: str, items: Iterable[str]) -> dict[str, float]:
    values = {}
    for item in items:
        name, _, value = item.partition("=")
        try:
            values[name] = float(value)
        except ValueError:
            raise ParameterError(
                f"--{option} needs PROPERTY=VALUE with a number, not {item!r}",
                parameter=option,
                value=item,
            ) from None
    return values


def _study(args: argparse.Namespace) -> None:
    speeds = None if args.speeds is None else _range("speeds", args.speeds)
    _run_study(
        args.name,
        args.save,
        args.csv,
        jobs=args.jobs,
        resume=args.resume,
        wide=args.wide or None,
        aircraft=args.aircraft,
        altitude=args.altitude,
        speeds=speeds,
        speed=args.speed,
        gamma=args.gamma,
    )


def _run_study(name: str, figure_file: Path | None, csv_file: Path | None, **options: Any) -> None:
    """Compute a study, print its result and show its figure; options that are None are left out."""
    from ._core.checks import one_of, writable
    from .plots import show
    from .studies import STUDIES

    study = STUDIES[one_of("study", name, STUDIES)]
    options = {option: value for option, value in options.items() if value is not None}
    taken = inspect.signature(study.table).parameters
    for option, value in options.items():
        if option not in taken:
            raise ParameterError(
                f"the study {name} takes no --{option}; it takes "
                + ", ".join(f"--{x}" for x in taken if x != "progress"),
                parameter=option,
                value=value,
            )
    if csv_file is not None:
        writable("csv", csv_file)
    with _saving(figure_file):
        table = study.table(**options)
        trimmed = int(table["trimmed"].sum())
        print(f"{name}: {trimmed} of {len(table)} points trim")
        if csv_file is not None:
            try:
                table.to_csv(csv_file, index=False)
            except OSError as error:
                raise FileError("write", csv_file, error) from None
            print(f"table saved: {csv_file}")
        figure = study.figure(table)
        if "aircraft" in options:
            figure.suptitle(f"{options['aircraft']}: {figure.get_suptitle()}")
        show(figure, name)


def _check(args: argparse.Namespace) -> int:
    from .check_cases import CASES, compare, comparison_figure, comparison_table, fly_case
    from .plots import show

    cases, passed = args.case or [*CASES], 0
    with _saving(args.save):
        for case in cases:
            scopes = fly_case(case, args.rate, args.integrators)
            deviations = compare(case, *scopes)
            passed += all(d.passes for d in deviations)
            print(comparison_table(case, deviations), flush=True)
            if args.save is not None:
                show(comparison_figure(case, *scopes), "")
    print(f"{passed} of {len(cases)} cases pass: at {args.rate} Hz, {args.integrators} integrators")
    return int(passed < len(cases))


def _range(option: str, text: str) -> list[float]:
    """The numbers of FIRST:LAST:STEP, including the last."""
    try:
        first, last, step = map(float, text.split(":"))
        count = int((last - first) / step + 1e-9)
        if not 0 <= count < 10_000:
            raise ValueError
    except (ValueError, OverflowError, ZeroDivisionError):
        raise ParameterError(
            f"--{option} needs FIRST:LAST:STEP, such as 60:120:10, not {text!r}",
            parameter=option,
            value=text,
        ) from None
    return [first + i * step for i in range(count + 1)]


def _view(args: argparse.Namespace) -> None:
    from .pathview import view

    def opened(trust: bool) -> None:
        view(
            args.target,
            args.port,
            browser=not args.no_browser,
            trust=trust,
            trust_toolboxes=args.trust_toolbox,
        )

    _asking(opened, args.trust)


def _asking(opened: Callable[[bool], _Opened], trust: bool) -> _Opened:
    """Open a model, after the question to the user whether to trust it."""
    from .pathview.trusted_models import remember

    try:
        return opened(trust)
    except UntrustedModelError as error:
        if not _says_yes(error):
            raise
        remember(error.digest)
        return opened(False)  # the file may have changed by now


def _says_yes(error: UntrustedModelError) -> bool:
    """Whether the user, at a terminal, trusts a model."""
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        return False
    print(
        f"{error.path!a} is {error.reason}:\n"
        f"  pathsim-jsbsim convert FILE.pvm -o FILE.py     (writes its code, runs none of it)\n"
        "Open it, now and later? [y/N] ",
        end="",
        file=sys.stderr,
        flush=True,
    )
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _export(args: argparse.Namespace) -> None:
    from .catalogue import diagram_folder, find_diagram
    from .pathview import export_script
    from .pathview.pvm import read
    from .pathview.trusted_models import digest, remember

    script = find_diagram(args.script)
    own = script.parent == diagram_folder()
    output = args.output or (Path(f"{script.stem}.pvm") if own else None)
    model = export_script(script, output)
    # all code in the model comes from the script, which has just run here
    remember(digest(read(model)))
    print(f"model saved: {model}")


def _convert(args: argparse.Namespace) -> None:
    from .pathview import convert_model

    script = convert_model(args.model, args.output, args.toolbox, args.trust_toolbox)
    print(f"script saved: {script}")


if __name__ == "__main__":
    sys.exit(main())
