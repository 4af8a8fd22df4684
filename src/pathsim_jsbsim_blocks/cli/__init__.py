"""The command ``pathsim-jsbsim``."""

from __future__ import annotations

import argparse
import contextlib
import io
import re
import sys
from collections.abc import Sequence
from typing import NoReturn

from ..errors import BlocksError
from .arguments import COMMANDS
from .console import report
from .parser import command_parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status.

    0 done, 1 failed with a message, 2 wrong usage or a model that is not trusted, 130 interrupted.
    """
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        # escape characters that the terminal's encoding lacks
        sys.stdout.reconfigure(errors="backslashreplace")
    arguments = sys.argv[1:] if argv is None else argv
    parser = command_parser()
    if not arguments:
        parser.print_help()
        return 0
    if arguments[0][:1] != "-" and arguments[0] not in COMMANDS:
        _refuse_command(parser, arguments[0])
    args, unknown = parser.parse_known_args(arguments)
    if unknown:
        _refuse(args.parser, unknown)
    try:
        status = args.command(args) or 0
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        # the reader of the pipe (head) has closed it
        sys.stderr.close()
        return 1
    except (BlocksError, OSError, KeyboardInterrupt) as error:
        # otherwise failed output would be written again at the end of the process
        with contextlib.suppress(OSError):
            sys.stdout.flush()
        return report(error)


def _refuse_command(parser: argparse.ArgumentParser, name: str) -> NoReturn:
    """End with status 2 and the nearest command."""
    from .._core.checks import did_you_mean, nearest

    close = did_you_mean(nearest(name, COMMANDS, 1)) or "; pathsim-jsbsim --help lists them"
    parser.error(f"no command {name!r}{close}")


def _refuse(command: argparse.ArgumentParser, unknown: Sequence[str]) -> NoReturn:
    """End with status 2, the usage of the command and the nearest option."""
    from .._core.checks import did_you_mean, nearest

    options = re.findall(r"--[\w-]+", command.format_help())
    close = did_you_mean(nearest(unknown[0], options, 1) if unknown[0].startswith("-") else [])
    command.error(f"unrecognized arguments: {' '.join(unknown)}{close}")
