"""Text that many docstrings share is filled in unchanged and never left out."""

import inspect

import pytest
from pathsim.blocks import Block

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks import air, axes

DOCUMENTED = {n: getattr(part, n) for part in (package, air, axes) for n in part.__all__}


@pytest.mark.parametrize("name", DOCUMENTED)
def test_no_place_is_left_empty(name):
    assert "%(" not in DOCUMENTED[name].__doc__


BLOCKS = [o for o in DOCUMENTED.values() if inspect.isclass(o) and issubclass(o, Block)]


@pytest.mark.parametrize(
    "block", [b for b in BLOCKS if ".air." in b.__module__], ids=lambda b: b.__name__
)
def test_pathview_shows_the_full_text(block):
    text = block.info()["description"]
    for shared in (
        "Parameters\n    ----------",
        "out_of_range : str",
        "Raises\n    ------",
        "FlightError\n        during the run",
    ):
        assert shared in text
