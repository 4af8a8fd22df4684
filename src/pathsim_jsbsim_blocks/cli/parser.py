"""The commands, in the order of the help."""

from __future__ import annotations

import argparse

from .. import __version__
from . import editor, learning, planes, results, runs


def command_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="pathsim-jsbsim",
        description="Fly JSBSim aircraft in PathSim block diagrams, and open them in PathView.",
    )
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for module in (learning, runs, planes, results, editor):
        for add in module.COMMANDS:
            add(commands)
    return parser
