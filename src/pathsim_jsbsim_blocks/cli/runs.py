"""``list`` and ``run``."""

from __future__ import annotations

import argparse
import ast
import contextlib
import inspect
import traceback
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import BlocksError
from .arguments import Commands, add_command, file_option, repeatable, trust_options
from .console import directory_is_gone, report, tell
from .editor import asking
from .results import run_study, studies
from .saving import SignalsWriter, recording_scopes, save, saving_figures, signals_writer

GROUPS = {
    "published": "Diagrams that follow the published notebooks, in their order",
    "beyond": "Diagrams beyond them",
    "check_cases": "NASA's check cases",
}


def add_list(commands: Commands) -> None:
    add_command(commands, "list", list_names, "the diagrams and studies of the catalogue")


def list_names(args: argparse.Namespace) -> None:
    from ..catalogue import diagram_groups, find_diagram

    parts = {}
    for group, names in diagram_groups().items():
        texts = [find_diagram(name).read_text(encoding="utf-8") for name in names]
        docs = [ast.get_docstring(ast.parse(text)) or "" for text in texts]
        parts[GROUPS[group]] = dict(zip(names, docs, strict=True))
    parts["Studies"] = {n: inspect.getdoc(study.table) or "" for n, study in studies().items()}
    width = max(len(name) for part in parts.values() for name in part)
    for number, (title, part) in enumerate(parts.items()):
        print(f"{chr(10) * (number > 0)}{title}")
        for name, doc in part.items():
            print(f"  {name:<{width}}  {doc.partition(chr(10))[0]}")


def add_run(commands: Commands) -> None:
    text = "run a diagram or a study: print its results and show its figures"
    sub = add_command(commands, "run", run, text)
    text = "a diagram or a study of the catalogue, or the path of a script or a model (.pvm)"
    sub.add_argument("name", help=text)
    text = "build with another value: NAME is BLOCK.PARAMETER (hold.theta_ref=5) or a variable "
    repeatable(sub, "--set", "NAME=VALUE", text + "at the top of the script")
    sub.add_argument("--duration", metavar="SECONDS", type=float, help="simulated time to run for")
    file_option(sub, "--save", metavar="FIG", text="write the figure to this file")
    text = "write all recorded signals as CSV, including those of a run that crashes or is "
    file_option(sub, "--csv", metavar="FILE", text=text + "interrupted")
    text = "at most so many rows per second in the CSV, each as recorded; default is all"
    sub.add_argument("--csv-rate", metavar="HZ", type=float, help=text)
    text = "write the flights of all aircraft: .html (a report), .kml (Google Earth), .acmi "
    text += "(Tacview), .czml (Cesium), .csv or .parquet"
    repeatable(sub, "--track", "FILE", text, type=Path)
    text = "fly in real time and send to FlightGear (default 127.0.0.1:5550)"
    sub.add_argument("--flightgear", metavar="HOST:PORT", nargs="?", const="", help=text)
    trust_options(sub)


def run(args: argparse.Namespace) -> int:
    from .._core.checks import positive
    from .._core.pathsim_internals import keep_warnings_visible
    from ..catalogue import find_diagram
    from ..scripts.runs import with_duration, with_progress
    from ..scripts.script import Script, main_program

    keep_warnings_visible()  # those of a script without a block of ours too
    if args.name in studies():
        _refuse_options_of_scripts(args)
        run_study(args.name, args.save, args.csv)
        return 0
    settings, duration, source = _settings(args.set), args.duration, None
    if duration is not None:
        positive("duration", duration)
    # a script may change the directory
    if Path(args.name).suffix in (".pvm", ".json"):
        script = Path(args.name).absolute()
        source = _code_of_model(script, args)
    else:
        script = find_diagram(args.name, studies()).absolute()
    signals = signals_writer(args.csv, args.csv_rate)
    status = 0
    try:
        with (
            saving_figures(args.save),
            main_program(script) as module,
            _tracking(args.track),
            with_progress(),
            _to_flightgear(args.flightgear),
            contextlib.ExitStack() as timed,
        ):
            try:
                diagram = Script(script, settings, source)
                constant = duration is not None and diagram.has_constant("DURATION")
                if constant:
                    settings = {**settings, **_once("DURATION", "duration", settings, duration)}
                    diagram = Script(script, settings, source)
                runs = timed.enter_context(with_duration(None if constant else duration))
                diagram.run(module)
                objects = list(vars(module).values())
                if not runs.begun:
                    _report_no_run(objects, duration, constant)
            except SystemExit as error:  # a script may end normally with sys.exit
                save(args.save, signals, recording_scopes(_variables_at(error)))
                raise
            except BaseException as error:
                status = _report_failure(error, script, args.save, signals)
                raise
            save(args.save, signals, recording_scopes(objects))
    except BaseException:
        if not status:
            raise
    return status


def _refuse_options_of_scripts(args: argparse.Namespace) -> None:
    from .._core.checks import refuse

    for option, reason in (
        ("track", "flies no aircraft"),
        ("flightgear", "flies no aircraft"),
        ("set", "is no script"),
        ("duration", "is no script"),
        ("csv_rate", "has no time"),
    ):
        if getattr(args, option) not in (None, []):
            why = f"the study {args.name} {reason}: it takes no --{option.replace('_', '-')}"
            refuse(option, str(getattr(args, option)), why)


def _settings(items: Sequence[str]) -> dict[str, Any]:
    """The values of ``--set NAME=VALUE``, as texts."""
    from .._core.checks import refuse
    from ..scripts.settings import Text

    settings: dict[str, Any] = {}
    for item in items:
        name, equals, text = item.partition("=")
        if not (equals and text.strip()):
            refuse("set", item, f"--set needs NAME=VALUE, such as hold.theta_ref=5, not {item!r}")
        settings.update(_once(name.strip(), "set", settings, Text(text.strip())))
    return settings


def _once(name: str, option: str, settings: Mapping[str, Any], value: Any) -> dict[str, Any]:
    """A setting that is not among those given already."""
    from .._core.checks import refuse

    if name in settings:
        why = f"--{option}: {name} is set twice, to {settings[name]} and {value}"
        refuse(option, str(value), why)
    return {name: value}


def _code_of_model(path: Path, args: argparse.Namespace) -> str:
    """The script of a model, which the user trusts."""
    import linecache

    from ..pathview import pvm
    from ..pathview.trusted_models import trusted_code

    def code(trust: bool) -> str:
        return trusted_code(pvm.read(path), path, trust, args.trust_toolbox)

    source = asking(code, args.trust)
    # tracebacks show the lines of the script
    linecache.cache[str(path)] = (len(source), None, source.splitlines(True), str(path))
    return source


@contextlib.contextmanager
def _tracking(paths: Sequence[Path]) -> Iterator[None]:
    """Write the flights within this context to files, also those before a failure."""
    from .._core.checks import refuse

    if not paths:
        yield
        return
    from ..flight.recording import recorded_flights, tracks
    from ..tracks.files import save_tracks, track_file

    def save_to(path: Path, flown: Sequence[Any]) -> None:
        save_tracks(path, flown)
        print(f"track saved: {path}")

    paths = [track_file("track", path).absolute() for path in paths]
    ended = False
    with recorded_flights() as recordings:
        try:
            yield
            ended = True
        finally:
            try:
                flown = tracks(recordings)
                if flown:
                    with contextlib.ExitStack() as files:  # one that fails prevents no other
                        for path in reversed(paths):
                            files.callback(save_to, path, flown)
                elif ended:
                    refuse("track", str(paths[0]), "the script flies no aircraft")
            except BlocksError as failure:
                if ended:
                    raise
                report(failure)


@contextlib.contextmanager
def _to_flightgear(address: str | None) -> Iterator[None]:
    """Fly in real time and send all aircraft to FlightGear; report the pace kept."""
    if address is None:
        yield
        return
    from ..flight.flightgear import sending_to
    from ..scripts.runs import in_real_time

    with in_real_time() as pace, sending_to(address):
        try:
            yield
        finally:
            print(pace)


def _report_no_run(objects: Iterable[Any], duration: float | None, constant: bool) -> None:
    """Say that a script made no run; an error if the duration had no effect.

    ``constant`` tells whether the script has a constant for the duration.
    """
    from pathsim import Simulation

    from .._core.checks import refuse

    simulations = [x for x in objects if isinstance(x, Simulation)]
    resting = bool(simulations) and all(x.time == 0.0 for x in simulations)
    if not resting and (duration is None or constant):
        return
    message = (
        "the script makes no run with sim.run or fly"
        + (" that --duration could set" if duration is not None else "")
        + (': add sim.run(10) under if __name__ == "__main__":' if resting else "")
    )
    if duration is not None:
        refuse("duration", duration, message)
    tell(message)


def _report_failure(
    error: BaseException, script: Path, figure: Path | None, signals: SignalsWriter | None
) -> int:
    """Save what a script recorded before it stopped, and print the reason."""
    scopes = recording_scopes(_variables_at(error))
    saved = ""
    if scopes and (figure is not None or signals is not None):
        until = f"until t = {max(scope.recording_time[-1] for scope in scopes):.9g} s"
        try:
            save(figure, signals, scopes, until)
            saved = f"; what was recorded {until} is saved"
        except BlocksError as failure:
            saved = f"; what was recorded {until} is not all saved: {failure}"
    if isinstance(error, (BlocksError, KeyboardInterrupt)) or directory_is_gone():
        return report(error, saved)
    if isinstance(error, SyntaxError):
        line = f":{error.lineno}" if error.lineno else ""
        message = f"{error.filename or script}{line}: {error.msg}"
    else:
        message = f"{script}: {type(error).__name__}: {error}"
        inside = error.__traceback__
        while inside is not None and inside.tb_frame.f_code.co_filename != str(script):
            inside = inside.tb_next
        if inside is not None:
            # the script's own fault: show its lines, as python does
            traceback.print_exception(type(error), error, inside)
            message = f"{script} failed"
    tell(message + saved)
    return 1


def _variables_at(error: BaseException) -> list[Any]:
    """Variables of the script that an exception ended, those of its functions included."""
    return [
        x
        for frame, _ in traceback.walk_tb(error.__traceback__)
        for x in list(frame.f_locals.values())
    ]


COMMANDS = (add_list, add_run)
