"""``course`` and ``help``."""

from __future__ import annotations

import argparse
import inspect
import os
import re
import textwrap
from pathlib import Path
from typing import Any

from .arguments import command, option, switch
from .console import tell
from .plain import plain_text


@command(
    "copy the chapters of the course, and open them in JupyterLab",
    option(
        "folder",
        "default %(default)s; existing files are kept",
        nargs="?",
        type=Path,
        default=Path("jsbsim-course"),
    ),
    switch("--no-open", "only copy"),
)
def course(args: argparse.Namespace) -> None:
    from .._core.extras import required

    versions = _copied(args.folder)
    print(f"the course is in {args.folder.resolve()}")
    if versions:
        print(f"your versions are kept: {', '.join(versions)}; for a new copy rename them first")
    if args.no_open:
        return
    required("jupyterlab", "course")
    from jupyterlab.labapp import LabApp

    first = min(path.name for path in chapters().glob("*.ipynb"))
    options = []
    if hasattr(os, "geteuid") and os.geteuid() == 0:  # as in a container
        options = ["--allow-root"]
        tell("JupyterLab starts with --allow-root: its cells run as root")
    try:
        # in this process, so that ending the command ends the server
        LabApp.launch_instance([str(args.folder / first), *options])
    except SystemExit as error:
        if error.code:
            tell(f"JupyterLab did not start; pass --no-open, then run jupyter lab {args.folder}")
        raise


def chapters() -> Path:
    """The folder of the course: in the package if it is installed, otherwise in the repository."""
    package = Path(__file__).resolve().parents[1]
    in_package = package / "course"
    return in_package if in_package.is_dir() else package.parents[1] / "docs" / "notebooks"


# a link to a page of the documentation, which the copy does not include
_PAGE = re.compile(r"\[([^][\"\n]+)\]\(\.\./([\w/-]+)\.\w+(?:#[\w-]+)?\)")


def _copied(folder: Path) -> list[str]:
    """Copy chapters and figures; return existing files that differ, which are not overwritten."""
    from .._core.files import replacing

    versions = []
    for source in sorted([*chapters().glob("*.ipynb"), *chapters().glob("figures/*.svg")]):
        name = source.relative_to(chapters())
        content = _PAGE.sub(r"\1 (docs/\2)", source.read_text(encoding="utf-8")).encode()
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists():
            with replacing(target) as part:
                part.write_bytes(content)
        elif target.read_bytes() != content:
            versions.append(str(name))
    return versions


@command(
    "the manual page of a block, or all blocks",
    option("block", "such as Aircraft, or Scope of PathSim", nargs="?"),
)
def help_(args: argparse.Namespace) -> None:
    import pathsim.blocks

    import pathsim_jsbsim_blocks as package

    from .._core.checks import did_you_mean, nearest, refuse

    def is_block(value: Any) -> bool:
        return inspect.isclass(value) and issubclass(value, pathsim.blocks.Block)

    ours = {name: getattr(package, name) for name in dir(package)}
    theirs = {name: x for name, x in vars(pathsim.blocks).items() if is_block(x)}
    if args.block is None:
        for name, block in ours.items():
            if is_block(block):
                print(f"{name:<19} {plain_text(inspect.getdoc(block) or '').partition(chr(10))[0]}")
        return
    subject = {**theirs, **ours}.get(args.block)
    if subject is None:
        names = did_you_mean(nearest(args.block, [*ours, *theirs], 2))
        refuse("block", args.block, f"no block {args.block!r}{names}")
    print(plain_text(inspect.getdoc(subject) or "").rstrip())
    if is_block(subject):
        _print_below("In a diagram", *_use(args.block, subject))
    if not (inspect.isclass(subject) and issubclass(subject, Exception)):
        parameters = inspect.signature(subject).parameters.values()
        signature = inspect.Signature([p.replace(annotation=p.empty) for p in parameters])
        _print_below("Signature", f"{args.block}{signature}")


def _print_below(title: str, *lines: str) -> None:
    print(f"\n{title}\n{'-' * len(title)}")
    print("\n".join(textwrap.fill(line, 96, subsequent_indent="    ") for line in lines))


def _use(name: str, block: Any) -> list[str]:
    """How a diagram builds and connects a block."""
    inputs = [f"Connection(other, block[{port!r}])" for port in block.input_port_labels or ()]
    outputs = [f"Connection(block[{port!r}], other)" for port in block.output_port_labels or ()]
    return [f"block = {name}()", *inputs, *outputs]
