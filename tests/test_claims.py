"""Numbers in prose: each has its source on the page, in its code, in a generated table or in a file named beside it."""

import re
from pathlib import Path

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Scope
from printed import run_code

from pathsim_jsbsim_blocks import Aircraft, PitchHold

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
# how-to pages, tutorials and concepts; evidence is generated
PAGES = sorted([*DOCS.glob("*.md"), *(DOCS / "concepts").glob("*.md")])

UNITS = (
    "ft/s2|ft/min|ft/s|ft|kt|knots|KCAS|KTAS|deg/s|deg|Hz|rad/s2|rad/s|ms|us|s|min|h|%|lbf|lb|in|g|m/s|m|km|MB|kB|"
    "bytes|px|dB|K|kg|psi"
)
QUANTITY = re.compile(rf"(?<![\w.,/^-])-?(\d[\d,]*(?:\.\d+)?)[ -](?:{UNITS})(?![\w/])")
NUMBER = re.compile(r"(?<![\w.])\d[\d_,]*(?:\.\d+)?(?:e-?\d+)?")
GENERATED = re.compile(r"<!-- (?!from )[^>]*? -->\n.*?\n<!-- end -->", re.S)
SOURCE = re.compile(r"<!-- from (\S+) -->")


def value(text):
    return float(re.sub("[_,]", "", text))


def numbers(text):
    return {value(x) for x in NUMBER.findall(text) if x.strip("_,")}


def paragraphs(text):
    """The prose of a page: paragraphs and list items, without code, headings and tables."""
    text = GENERATED.sub("", re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S))
    text = re.sub(r"^[|#].*$", "", text, flags=re.M)
    return re.split(r"\n\s*\n|\n(?=\s*(?:-|\d+\.) )", text)


def unsourced(text):
    """The quantities in the prose of a page that neither its code nor a file named beside them has."""
    code = re.findall(r"^```(?:python|sh)\n(.*?)^```$", text, re.M | re.S)
    sources = numbers("\n".join([*code, *re.findall(r"`([^`\n]*)`", text)]))
    for paragraph in paragraphs(text):
        files = [(ROOT / name).read_text(encoding="utf-8") for name in SOURCE.findall(paragraph)]
        known = sources | numbers("\n".join(files))
        plain = re.sub(r"`[^`]*`|\]\([^)]*\)|<!--.*?-->", "", paragraph, flags=re.S)
        for quantity in QUANTITY.finditer(plain):
            same = {value(quantity[1]), value(quantity[1]) / (100 if "%" in quantity[0] else 1)}
            if not same & known:
                yield quantity[0]


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_a_number_with_a_unit_has_its_source_on_the_page(page):
    # an assertion in a code block, or `<!-- from FILE -->` in the paragraph: FILE has the number
    assert [*unsourced(page.read_text(encoding="utf-8"))] == []


def test_a_quantity_without_source_is_listed():
    page = "It climbs 300 ft.\n\n```python\nassert gain == 2.5\n```\n\nA gain of 2.5 deg loses 1,200 ft in 10 s.\n"
    assert [*unsourced(page)] == ["300 ft", "1,200 ft", "10 s"]
    between = "A wing. <!-- from LICENSE -->\n\nIt rolls 77.5 deg.\n\n<!-- table -->\n1 kt\n<!-- end -->\n"
    assert [*unsourced(between)] == ["77.5 deg"]
    named = "It falls 7.3 ft. <!-- from tests/data/no_such_file.csv -->\n"
    with pytest.raises(FileNotFoundError):
        [*unsourced(named)]


def test_a_printed_line_that_differs_is_a_fault(tmp_path):
    script = tmp_path / "page.py"
    code = (
        "for x in (1.5, 2.5):\n    print('x is', x)  # prints: x is 1.5\n# prints: x is ...\n"
        "print(\n    3\n)  # prints: 4\nprint('as it likes')\n"
    )
    script.write_text(code, encoding="utf-8")
    (fault,) = run_code(code, script, {})
    assert fault == "print(\n3\n"


@pytest.mark.long
def test_the_drawn_pitch_hold_alone_ends_in_a_spiral_dive():
    # drawing.md: it begins 70 s after the start, slowed by the pitch hold
    plane = Aircraft("c172p", altitude=5000, speed=90)
    hold = PitchHold(gains="c172p", theta_ref=3.0)
    scope, measured = Scope(), ("theta", "q")
    wires = [Connection(plane[name], scope[i]) for i, name in enumerate(("h", "vc", "phi"))]
    wires += [Connection(plane[measured], hold[measured])]
    wires += [Connection(hold["elevator"], plane["elevator"])]
    Simulation([plane, hold, scope], wires, dt=1 / 120, log=False).run(110)
    time, (h, vc, phi) = scope.read()
    dive = time[np.argmax(h)]
    assert dive == pytest.approx(70, abs=5)
    assert vc[time >= dive][0] < 83
    assert abs(phi[time >= 60][0]) < 30 < 60 < abs(phi[time >= 90][0])
    spiral = {
        speed: mode.pole.real
        for speed in (70, 90)
        for mode in Aircraft("c172p", altitude=5000, speed=speed).linear_model().modes()
        if mode.name == "spiral"
    }
    assert spiral[90] < 0 < spiral[70]
