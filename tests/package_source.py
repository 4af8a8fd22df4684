"""The package's own source, for tests of what it may contain."""

import ast
from pathlib import Path

import pathsim_jsbsim_blocks

SOURCE = Path(pathsim_jsbsim_blocks.__file__).parent


def nodes():
    """Every node of every module's syntax tree, with the module's file relative to the package."""
    for file in sorted(SOURCE.rglob("*.py")):
        name = file.relative_to(SOURCE).as_posix()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            yield name, node
