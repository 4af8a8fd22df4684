"""Formulas of the site, as the browser draws them."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("sphinx")
DOCS = Path(__file__).parents[2] / "docs"
PAGES = {
    "03_diagrams": "notebooks/03_diagrams.ipynb",
    "00_inside_one_step": "notebooks/00_inside_one_step.ipynb",
    "05b_air_data": "notebooks/05b_air_data.ipynb",
    "08_thrust_vectoring": "notebooks/08_thrust_vectoring.ipynb",
    "10_climbs": "notebooks/10_climbs.ipynb",
    "axes": "reference/axes.rst",
    "wind": "reference/wind.rst",
    "frames": "concepts/frames.md",
}


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Pages of the site with overdots, matrices and long formulas."""
    folder = tmp_path_factory.mktemp("site")
    (folder / "source").mkdir()
    for file in PAGES.values():
        shutil.copy(DOCS / file, folder / "source")
    root = "root_doc=03_diagrams"
    command = [sys.executable, "-m", "sphinx", "-Q", "-c", DOCS, "-D", root]
    subprocess.run([*command, folder / "source", folder / "html"], check=True)
    return folder / "html"


def opened(browser, site, name, **options):
    page = browser.new_page(**options)
    page.goto((site / f"{name}.html").as_uri())
    page.evaluate("document.fonts.ready")
    assert page.evaluate("document.fonts.check('16px \"Formula Math\"')")
    return page


def darkness(page, box, folder):
    """The darkest grey in a box of the page, 0 for black to 255."""
    image = pytest.importorskip("PIL.Image")
    file = folder / "box.png"
    page.screenshot(path=file, clip=box, full_page=True)
    with image.open(file) as picture:
        return picture.convert("L").getextrema()[0]


@pytest.mark.long
def test_overdots_of_chapter_3_are_seen(browser, site, tmp_path):
    page = opened(browser, site, "03_diagrams", device_scale_factor=4)
    dotted = page.locator("mover")
    source = (DOCS / "notebooks/03_diagrams.py").read_text(encoding="utf-8")
    assert dotted.count() == len(re.findall(r"\\d?dot ", source))
    for i in range(dotted.count()):
        letter, dots = (dotted.nth(i).locator("> *").nth(k).bounding_box() for k in (0, 1))
        assert dots["y"] + dots["height"] / 2 < letter["y"] + letter["height"] / 2
        assert darkness(page, dots, tmp_path) < 100
    page.close()


@pytest.mark.long
def test_brackets_are_as_tall_as_their_matrices(browser, site):
    page = opened(browser, site, "frames")
    for row in page.locator("mrow:has(> mtable)").all():
        table = row.locator("> mtable").bounding_box()["height"]
        brackets = row.locator("> mo").all()
        assert [b for b in brackets if b.bounding_box()["height"] > 0.9 * table], row.inner_html()
    assert page.locator("mtable").count() >= 3
    page.close()


@pytest.mark.long
@pytest.mark.parametrize("name", PAGES)
def test_formulas_fit_the_page(browser, site, name):
    page = opened(browser, site, name, viewport={"width": 1280, "height": 900})
    widths = "x => x.map(e => [e.scrollWidth, e.clientWidth])"
    formulas = page.locator(".formula").evaluate_all(widths)
    assert formulas
    assert [pair for pair in formulas if pair[0] > pair[1]] == []
    page.close()
