"""The parser of the command; its help lists the commands by group, the most frequent first."""

from __future__ import annotations

import argparse

from .. import __version__
from . import editor, learning, planes, results, runs
from .arguments import COMMANDS

__all__ = ["command_parser", "editor", "learning", "planes", "results", "runs"]

_GROUPS = {
    "fly": ("run", "view", "trim"),
    "look": ("list", "help", "course", "aircraft", "properties", "modes"),
    "study": ("study", "chart", "gains", "check"),
    "exchange": ("export", "convert", "daveml"),
}


def command_parser() -> argparse.ArgumentParser:
    text = "Fly JSBSim aircraft in PathSim block diagrams, and open them in PathView.\n"
    for group, names in _GROUPS.items():
        text += "".join([f"\n{group}:\n", *(f"  {x:<11} {COMMANDS[x].text}\n" for x in names)])
    parser = argparse.ArgumentParser(
        prog="pathsim-jsbsim",
        description=text,
        epilog="pathsim-jsbsim COMMAND --help shows the options of a command.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND", help="one of those above")
    for name in [name for names in _GROUPS.values() for name in names]:
        function, text, options = COMMANDS[name]
        sub = commands.add_parser(name, description=text[0].upper() + text[1:] + ".")
        sub.set_defaults(command=function, parser=sub)
        for names, keywords in options:
            sub.add_argument(*names, **keywords)
    return parser
