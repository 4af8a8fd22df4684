"""Variables are nouns of the domain: few are participles or adverbs such as ``found`` and ``there``."""

import ast
from pathlib import Path

import pathsim_jsbsim_blocks

WORDS = {"found", "given", "known", "wanted", "kept", "seen", "made", "here", "there", "near",
         "shown", "whole", "told", "said"}  # fmt: skip
MOST = 9  # keywords and arguments whose names are public, such as `near`


def test_variables_are_nouns():
    source = Path(pathsim_jsbsim_blocks.__file__).parent
    nodes = (n for path in source.rglob("*.py") for n in ast.walk(ast.parse(path.read_bytes())))
    names = [getattr(n, "id", getattr(n, "arg", "")) for n in nodes]
    assert sum(name in WORDS for name in names) <= MOST
