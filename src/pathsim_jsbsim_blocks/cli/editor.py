"""``view``, ``export`` and ``convert``."""

from __future__ import annotations

import argparse
import math
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from ..errors import UntrustedModelError
from .arguments import (
    ROOT,
    TOOLBOX,
    TRUST,
    command,
    file,
    is_jsbsim_script,
    option,
    repeatable,
    switch,
)
from .console import tell
from .saving import check_file

_Opened = TypeVar("_Opened")
_LONG = 60.0  # s


@command(
    "open a diagram in PathView",
    option("target", "a diagram, a model (.pvm) or a script; default is an empty one", nargs="?"),
    option("--port", "default is 8360, or a free one", type=int),
    switch("--no-browser", "only serve"),
    TRUST,
    TOOLBOX,
)
def view(args: argparse.Namespace) -> None:
    from .. import pathview

    def opened(trust: bool) -> None:
        options = {"trust": trust, "trust_toolboxes": args.trust_toolbox}
        pathview.view(args.target, args.port, browser=not args.no_browser, **options)

    asking(opened, args.trust)


def asking(open_model: Callable[[bool], _Opened], trust: bool) -> _Opened:
    """Open a model, after asking the user whether to trust it."""
    from ..pathview.trusted_models import remember

    try:
        return open_model(trust)
    except UntrustedModelError as error:
        if not says_yes(error):
            raise
        remember(error.digest)
        return open_model(False)  # the file may have changed by now


def says_yes(error: UntrustedModelError) -> bool:
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


def _seconds_or_all(text: str) -> float:
    return math.inf if text == "all" else float(text)


@command(
    "write a diagram script as a PathView model",
    option("script", "a diagram of the catalogue, or the path of a script"),
    file("-o --output", "default is NAME.pvm, beside the script or, for the catalogue, here"),
    option(
        "--check",
        "processing time for which the model flies beside the script's first run, or all: to the "
        "end of the run; default is 60",
        metavar="SECONDS",
        type=_seconds_or_all,
        default=60.0,
    ),
)
def export(args: argparse.Namespace) -> None:
    from ..catalogue import diagram_folder, find_diagram
    from ..pathview.export import export_with_proof
    from ..pathview.pvm import read
    from ..pathview.trusted_models import digest, remember

    check_file("output", args.output, ".pvm", ".json")
    script = find_diagram(args.script)
    in_catalogue = script.is_relative_to(diagram_folder())
    output = args.output or (Path(f"{script.stem}.pvm") if in_catalogue else None)
    text = f"{script} still runs after {_LONG:.0f} s; Ctrl-C ends the export"
    waiting = threading.Timer(_LONG, tell, [text])
    waiting.daemon = True
    waiting.start()
    try:
        model, proof = export_with_proof(script, output, args.check)
    finally:
        waiting.cancel()
    # trusted: all code in the model comes from the script, which has just run
    remember(digest(read(model)))
    print(f"model saved: {model} ({proof})")


@command(
    "write a PathView model or a JSBSim script as a Python script",
    file("model", "a model (.pvm or .json), or a JSBSim script (.xml)"),
    file(
        "-o --output",
        "default is NAME.py beside the model, for a JSBSim script here, if it does not exist yet",
    ),
    ROOT,
    repeatable("--toolbox", "one that the model itself does not name", "PACKAGE[:IMPORT]"),
    TOOLBOX,
)
def convert(args: argparse.Namespace) -> None:
    if is_jsbsim_script(args.model, args.root):
        script = _convert_script(args.model, args.output, args.root)
    else:
        from ..pathview import convert_model

        script = convert_model(args.model, args.output, args.toolbox, args.trust_toolbox)
    print(f"script saved: {script}")


def _convert_script(name: Path, output: Path | None, root: str | None) -> Path:
    """Write the diagram that `run` flies for a JSBSim script."""
    from .._core.checks import refuse
    from .._core.files import replacing
    from .script_diagram import diagram_of_script

    check_file("output", output, ".py")
    path, text = diagram_of_script(name, root)
    script = output or Path(f"{path.stem}.py")
    if output is None and script.exists():
        refuse("output", str(script), f"{script} exists: name the script to write (-o FILE.py)")
    with replacing(script) as part:
        part.write_text(text, encoding="utf-8")
    return script
