"""The command ``pathsim-jsbsim``."""

from __future__ import annotations

import argparse
import contextlib
import io
import re
import sys
from collections.abc import Sequence
from typing import NoReturn

from ..errors import BlocksError, UntrustedModelError
from .console import GONE, directory_is_gone
from .parser import command_parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status.

    0 done, 1 failed with a message, 2 wrong usage or a model that is not trusted.
    """
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        # names that the terminal's encoding lacks
        sys.stdout.reconfigure(errors="backslashreplace")
    args, unknown = command_parser().parse_known_args(argv)
    if unknown:
        _refuse(args.parser, unknown)
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
        if directory_is_gone():
            message = GONE
        elif not isinstance(error, BlocksError) and error.strerror:
            message = f"{error.filename or 'the output'}: {error.strerror}"
        print(f"pathsim-jsbsim: {message}", file=sys.stderr)
        return 1
    except KeyboardInterrupt as error:
        print(
            "pathsim-jsbsim: " + ": ".join(filter(None, ["interrupted", str(error)])),
            file=sys.stderr,
        )
        return 130


def _refuse(command: argparse.ArgumentParser, unknown: Sequence[str]) -> NoReturn:
    """End with status 2, the usage of the command and the nearest option."""
    from .._core.checks import did_you_mean, nearest

    options = re.findall(r"--[\w-]+", command.format_help())
    close = did_you_mean(nearest(unknown[0], options, 1) if unknown[0].startswith("-") else [])
    command.error(f"unrecognized arguments: {' '.join(unknown)}{close}")
