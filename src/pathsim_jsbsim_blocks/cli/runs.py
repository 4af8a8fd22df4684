"""``list`` and ``run``."""

from __future__ import annotations

import argparse
import ast
import contextlib
import inspect
import linecache
import traceback
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from ..errors import BlocksError, ParameterError
from .arguments import (
    FIGURE,
    ROOT,
    TOOLBOX,
    TRUST,
    command,
    file,
    is_jsbsim_script,
    number,
    option,
    repeatable,
)
from .console import directory_is_gone, report, tell
from .editor import asking
from .plain import plain_text
from .saving import SignalsWriter, recording_scopes, save, saving_figures, signals_writer

GROUPS = {
    "published": "Diagrams that follow the published notebooks, in their order",
    "beyond": "Diagrams beyond them",
    "check_cases": "NASA's check cases",
}


@command("the diagrams and studies of the catalogue")
def list_(args: argparse.Namespace) -> None:
    from ..catalogue import diagram_groups, find_diagram
    from ..studies import STUDIES

    parts = {}
    for group, names in diagram_groups().items():
        texts = [find_diagram(name).read_text(encoding="utf-8") for name in names]
        docs = [ast.get_docstring(ast.parse(text)) or "" for text in texts]
        parts[GROUPS[group]] = dict(zip(names, docs, strict=True))
    parts["Studies"] = {n: inspect.getdoc(study.table) or "" for n, study in STUDIES.items()}
    width = max(len(name) for part in parts.values() for name in part)
    for i, (title, part) in enumerate(parts.items()):
        print(f"{chr(10) * (i > 0)}{title}")
        for name, doc in part.items():
            print(f"  {name:<{width}}  {plain_text(doc).partition(chr(10))[0]}")


@command(
    "run a diagram: print its results and show its figures",
    option(
        "name",
        "a diagram of the catalogue, or the path of a script, a model (.pvm) or a JSBSim script "
        "(.xml, also below the JSBSim root: scripts/c1723.xml)",
    ),
    repeatable(
        "--set",
        "build with another value: NAME is BLOCK.PARAMETER (hold.theta_ref=5) or a variable at the "
        "top of the script",
        "NAME=VALUE",
    ),
    number("--duration", "simulated time to run for", metavar="SECONDS"),
    FIGURE,
    file("--csv", "write all recorded signals, also of a run that crashes or is interrupted"),
    number("--csv-rate", "most rows per second in the CSV", metavar="HZ"),
    repeatable(
        "--track",
        "write the flights of all aircraft: .html (a report), .kml (Google Earth), .acmi "
        "(Tacview), .csv or .parquet",
        "FILE",
        type=Path,
    ),
    option(
        "--flightgear",
        "fly in real time and send to FlightGear (default 127.0.0.1:5550)",
        metavar="HOST:PORT",
        nargs="?",
        const="",
    ),
    TRUST,
    TOOLBOX,
    ROOT,
)
def run(args: argparse.Namespace) -> int:
    from .._core.callers import keep_warnings_visible
    from .._core.checks import positive
    from ..scripts.runs import intercepted_runs
    from ..scripts.script import Script, main_program
    from .contexts import with_duration, with_progress

    keep_warnings_visible()  # also for a script without blocks of this package
    settings, duration, source = _settings(args.set), args.duration, None
    if duration is not None:
        positive("duration", duration)
    notices: contextlib.AbstractContextManager[None] = contextlib.nullcontext()
    # a script may change the directory
    if is_jsbsim_script(args.name, args.root):
        from .script_diagram import diagram_of_script, printed_notices

        script, source = diagram_of_script(args.name, args.root)
        notices = printed_notices()
    elif Path(args.name).suffix in (".pvm", ".json"):
        script = Path(args.name).absolute()
        source = _code_of_model(script, args)
    else:
        script = _script(args.name).absolute()
    if source is not None:
        # so that tracebacks and warnings show the lines of the diagram
        lines = source.splitlines(keepends=True)
        linecache.cache[str(script)] = (len(source), None, lines, str(script))
    signals = signals_writer(args.csv, args.csv_rate)
    status, last = 0, deque[Any](maxlen=1)  # the last simulation run, maybe a function's variable
    try:
        with (
            saving_figures(args.save),
            main_program(script) as module,
            notices,
            _tracking(args.track),
            with_progress(),
            _to_flightgear(args.flightgear),
            _telling_of_no_aircraft(args),
            intercepted_runs(lambda run: last.append(run.simulation)),
            contextlib.ExitStack() as context,
        ):
            try:
                diagram = Script(script, settings, source)
                constant = duration is not None and diagram.has_constant("DURATION")
                if constant:
                    settings["DURATION"] = duration
                    diagram = Script(script, settings, source)
                context.enter_context(with_duration(None if constant else duration))
                diagram.run(module)
                objects = list(vars(module).values())
                if not last:
                    _report_no_run(objects, duration, constant)
            except SystemExit as error:  # a script may end normally with sys.exit
                save(args.save, signals, recording_scopes(_variables_at(error, last)))
                raise
            except BaseException as error:
                status = _report_failure(error, script, args.save, signals, last)
                raise
            save(args.save, signals, recording_scopes([*objects, *last]))
    except BaseException:
        if not status:
            raise
    return status


def _script(name: str) -> Path:
    """The script of a diagram; studies are loaded only to explain an unknown name."""
    from .._core.checks import refuse
    from ..catalogue import find_diagram

    try:
        return find_diagram(name)
    except ParameterError:
        from ..studies import STUDIES

        if name in STUDIES:
            refuse("name", name, f"{name} is a study: pathsim-jsbsim study {name}")
        return find_diagram(name, STUDIES)


def _settings(items: Sequence[str]) -> dict[str, Any]:
    """The values of ``--set NAME=VALUE``, as texts."""
    from .._core.checks import refuse
    from ..scripts.settings import Text

    settings: dict[str, Any] = {}
    for item in items:
        name, equals, text = item.partition("=")
        if not (equals and text.strip()):
            refuse("set", item, f"--set needs NAME=VALUE, such as hold.theta_ref=5, not {item!r}")
        settings[name.strip()] = Text(text.strip())
    return settings


def _code_of_model(path: Path, args: argparse.Namespace) -> str:
    """The script of a model, after checking that the user trusts it."""
    from ..pathview import pvm
    from ..pathview.trusted_models import trusted

    def code(trust: bool) -> str:
        return trusted(pvm.read(path), path, trust, args.trust_toolbox)[1]

    return asking(code, args.trust)


def _telling_of_no_aircraft(args: argparse.Namespace) -> contextlib.AbstractContextManager[Any]:
    """Context that reports, before a run, if no aircraft of this package flies in it."""
    from ..scripts.runs import intercepted_runs

    texts = set[str]()

    def check(run: Any) -> None:
        from pathsim_flight import JSBSimWrapper

        from .._core.wiring import contents
        from ..flight.block import FlightBlock

        kinds = [type(block) for block in contents(run.simulation)[0]]
        text = "no JSBSim aircraft flies in this run"
        if JSBSimWrapper in kinds:
            text = "JSBSimWrapper of pathsim-flight leaves no track: use JSBSimFDM in its place"
        elif any(issubclass(kind, FlightBlock) for kind in kinds):
            return
        if text not in texts:
            tell(text)
        texts.add(text)

    wants_track = args.track or args.flightgear is not None
    return intercepted_runs(check) if wants_track else contextlib.nullcontext()


@contextlib.contextmanager
def _tracking(paths: Sequence[Path]) -> Iterator[None]:
    """Write the flights within this context to files, also those before a failure."""
    if not paths:
        yield
        return
    from ..tracks.files import track_file
    from ..tracks.recording import recorded_flights

    paths = [track_file("track", path).absolute() for path in paths]
    complete = False
    with recorded_flights() as recordings:
        try:
            yield
            complete = True
        finally:
            try:
                _save_tracks(paths, recordings, complete)
            except BlocksError as failure:
                if complete:
                    raise
                report(failure)


def _save_tracks(paths: Sequence[Path], recordings: Any, complete: bool) -> None:
    from .._core.checks import refuse
    from ..tracks.files import save_tracks
    from ..tracks.recording import tracks

    flown = tracks(recordings)
    if complete and not flown:
        refuse("track", str(paths[0]), "the script flies no aircraft")

    def save_to(path: Path) -> None:
        save_tracks(path, flown)
        print(f"track saved: {path}")

    with contextlib.ExitStack() as files:  # a failing file does not prevent the others
        for path in reversed(paths if flown else []):
            files.callback(save_to, path)


@contextlib.contextmanager
def _to_flightgear(address: str | None) -> Iterator[None]:
    """Fly in real time and send all aircraft to FlightGear; print the pace at the end."""
    if address is None:
        yield
        return
    from ..flight.flightgear import sending_to
    from .contexts import in_real_time

    with in_real_time() as pace, sending_to(address):
        try:
            yield
        finally:
            print(pace)


def _report_no_run(objects: Iterable[Any], duration: float | None, constant: bool) -> None:
    """Report that a script made no run; raise if ``--duration`` had no effect.

    ``constant`` tells whether the script has a constant for the duration.
    """
    from pathsim import Simulation

    from .._core.checks import refuse

    why, advice = "the script calls neither sim.run nor fly", ""
    simulations = [x for x in objects if isinstance(x, Simulation)]
    if simulations and all(x.time == 0.0 for x in simulations):
        advice = ': add sim.run(10) under if __name__ == "__main__":'
    if duration is not None and (advice or not constant):
        refuse("duration", duration, f"{why}, so --duration has no effect{advice}")
    if advice:
        tell(why + advice)


def _report_failure(
    error: BaseException,
    script: Path,
    figure: Path | None,
    signals: SignalsWriter | None,
    last: Iterable[Any],
) -> int:
    """Save what a script recorded before it stopped, and print the reason.

    ``last`` is the simulation of its last run.
    """
    scopes = recording_scopes(_variables_at(error, last))
    outcome = ""
    if scopes and (figure is not None or signals is not None):
        until = f"until t = {max(scope.recording_time[-1] for scope in scopes):.9g} s"
        try:
            save(figure, signals, scopes, until)
            outcome = f"; the recording {until} is saved"
        except BlocksError as failure:
            outcome = f"; the recording {until} is not completely saved: {failure}"
    if isinstance(error, (BlocksError, KeyboardInterrupt)) or directory_is_gone():
        return report(error, outcome)
    if isinstance(error, SyntaxError):
        line = f":{error.lineno}" if error.lineno else ""
        message = f"{error.filename or script}{line}: {error.msg}"
    else:
        message = f"{script}: {type(error).__name__}: {error}"
        call = error.__traceback__
        while call is not None and call.tb_frame.f_code.co_filename != str(script):
            call = call.tb_next
        if call is not None:
            # an error in the script: show its lines, as python does
            traceback.print_exception(type(error), error, call)
            message = f"{script} failed"
    tell(message + outcome)
    return 1


def _variables_at(error: BaseException, last: Iterable[Any]) -> list[Any]:
    """The last simulation, and the variables of all functions that an exception ended."""
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    return [*last, *(x for frame in frames for x in list(frame.f_locals.values()))]
