"""The commands, in the order of the help."""

from __future__ import annotations

import argparse

from .. import __version__
from .editor import add_convert, add_export, add_view
from .learning import add_course, add_help
from .planes import add_aircraft, add_gains, add_modes, add_properties, add_systems, add_trim
from .results import add_chart, add_check, add_daveml, add_study
from .runs import add_list, add_run

_COMMANDS = (
    add_course,
    add_help,
    add_list,
    add_run,
    add_aircraft,
    add_properties,
    add_systems,
    add_trim,
    add_modes,
    add_gains,
    add_study,
    add_chart,
    add_check,
    add_daveml,
    add_view,
    add_export,
    add_convert,
)


def command_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="pathsim-jsbsim",
        description="Fly JSBSim aircraft in PathSim block diagrams, and open them in PathView.",
    )
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for add in _COMMANDS:
        add(commands)
    return parser
