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
    Commands,
    add_command,
    file_option,
    repeatable,
    switch,
    trust_options,
    trust_toolbox_option,
)
from .console import tell
from .saving import check_file

_Opened = TypeVar("_Opened")
_LONG = 60.0  # s


def add_view(commands: Commands) -> None:
    sub = add_command(commands, "view", view_model, "open a diagram in PathView")
    text = "a diagram, a model (.pvm) or a script; default is an empty diagram"
    sub.add_argument("target", nargs="?", help=text)
    sub.add_argument("--port", type=int, help="default is 8360, or a free one")
    switch(sub, "--no-browser", "only serve")
    trust_options(sub)


def view_model(args: argparse.Namespace) -> None:
    from ..pathview import view

    def opened(trust: bool) -> None:
        options = {"trust": trust, "trust_toolboxes": args.trust_toolbox}
        view(args.target, args.port, browser=not args.no_browser, **options)

    asking(opened, args.trust)


def asking(opened: Callable[[bool], _Opened], trust: bool) -> _Opened:
    """Open a model, after the question to the user whether to trust it."""
    from ..pathview.trusted_models import remember

    try:
        return opened(trust)
    except UntrustedModelError as error:
        if not says_yes(error):
            raise
        remember(error.digest)
        return opened(False)  # the file may have changed by now


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


def add_export(commands: Commands) -> None:
    sub = add_command(commands, "export", export, "write a diagram script as a PathView model")
    sub.add_argument("script", help="a diagram of the catalogue, or the path of a script")
    text = "default is NAME.pvm, beside the script or, for the catalogue, here"
    file_option(sub, "-o", "--output", metavar="FILE.pvm", text=text)
    text = "processing time for which the model flies beside the script's first run, or all: "
    text += "to the end of the run; default is 60"
    sub.add_argument("--check", metavar="SECONDS", type=_seconds_or_all, default=60.0, help=text)


def _seconds_or_all(text: str) -> float:
    return math.inf if text == "all" else float(text)


def export(args: argparse.Namespace) -> None:
    from ..catalogue import diagram_folder, find_diagram
    from ..pathview.export import export_with_proof
    from ..pathview.pvm import read
    from ..pathview.trusted_models import digest, remember

    check_file("output", args.output, ".pvm", ".json")
    script = find_diagram(args.script)
    own = script.is_relative_to(diagram_folder())
    output = args.output or (Path(f"{script.stem}.pvm") if own else None)
    text = f"{script} still runs after {_LONG:.0f} s; Ctrl-C ends the export"
    waiting = threading.Timer(_LONG, tell, [text])
    waiting.daemon = True
    waiting.start()
    try:
        model, proof = export_with_proof(script, output, args.check)
    finally:
        waiting.cancel()
    # all code in the model comes from the script, which has just run here
    remember(digest(read(model)))
    print(f"model saved: {model} ({proof})")


def add_convert(commands: Commands) -> None:
    sub = add_command(commands, "convert", convert, "write a PathView model as a Python script")
    sub.add_argument("model", metavar="FILE", type=Path, help=".pvm or .json")
    text = "default is NAME.py beside the model, if that does not exist yet"
    file_option(sub, "-o", "--output", metavar="FILE.py", text=text)
    text = "a toolbox that the model itself does not name"
    repeatable(sub, "--toolbox", "PACKAGE[:IMPORT]", text)
    trust_toolbox_option(sub)


def convert(args: argparse.Namespace) -> None:
    from ..pathview import convert_model

    script = convert_model(args.model, args.output, args.toolbox, args.trust_toolbox)
    print(f"script saved: {script}")


COMMANDS = (add_view, add_export, add_convert)
