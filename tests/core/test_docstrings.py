"""Text that many docstrings share is filled in unchanged and never left out."""

import inspect

import pytest
from pathsim.blocks import Block

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks import air, axes

DOCUMENTED = {n: getattr(part, n) for part in (package, air, axes) for n in part.__all__}
OF_AIR = [
    thing
    for thing in DOCUMENTED.values()
    if inspect.isclass(thing) and issubclass(thing, Block) and ".air." in thing.__module__
]


def test_no_place_is_left_empty():
    assert [name for name, thing in DOCUMENTED.items() if "%(" in thing.__doc__] == []


@pytest.mark.parametrize("block", OF_AIR, ids=lambda b: b.__name__)
def test_pathview_shows_the_full_text(block):
    text = block.info()["description"]
    for shared in (
        "Parameters\n    ----------",
        "out_of_range : str",
        "Raises\n    ------",
        "FlightError\n        during the run",
    ):
        assert shared in text
