"""Text that many docstrings share is filled in unchanged and never left out."""

import inspect

import pytest
from pathsim.blocks import Block

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks import air, axes
from pathsim_jsbsim_blocks._core.docstrings import filler

fill = filler(
    speed="""
    speed
        in m/s

        of the air
    """
)


def test_a_text_takes_the_indentation_of_its_place():
    @fill
    def f():
        """Sum 100 %(speed)s of it.

            %(speed)s
        %(speed)s
        """

    assert inspect.cleandoc(f.__doc__) == (
        "Sum 100 %(speed)s of it.\n\n"
        "    speed\n        in m/s\n\n        of the air\n"
        "speed\n    in m/s\n\n    of the air"
    )


def test_a_place_without_a_text_is_an_error():
    with pytest.raises(KeyError, match="sped"):

        @fill
        def f():
            """%(sped)s"""


def test_without_docstrings_there_is_nothing_to_fill():
    def f():
        pass

    assert fill(f).__doc__ is None


DOCUMENTED = {
    n: o
    for part in (package, air, axes)
    for n, o in vars(part).items()
    if not n.startswith("_") and (inspect.isfunction(o) or inspect.isclass(o))
}


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
