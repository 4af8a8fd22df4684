"""The notebooks of the course: made from their sources, with the outputs that a run gives."""

import base64
import importlib
import io
import itertools
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from how_many import bounded

for package in ("jupytext", "nbclient", "ipykernel"):
    pytest.importorskip(package)
nbformat = pytest.importorskip("nbformat")

DOCS = Path(__file__).parents[1] / "docs"
sys.path.append(str(DOCS))
notebooks = importlib.import_module("notebooks")
sys.path.remove(str(DOCS))

NUMBER = re.compile(r"-?\d[\d,]*\.?\d*(?:e[+-]?\d+)?")


def committed(name):
    return nbformat.read(notebooks.FOLDER / f"{name}.ipynb", as_version=4)


@pytest.mark.parametrize("name", notebooks.names())
def test_a_notebook_has_the_cells_of_its_source(name):
    # after a change: python docs/notebooks.py NAME
    found, expected = committed(name), notebooks.source(name)
    assert [(c.cell_type, c.source) for c in found.cells] == [
        (c.cell_type, c.source) for c in expected.cells
    ]
    assert (DOCS / "index.md").read_text(encoding="utf-8").count(f"notebooks/{name}\n") == 1
    # it says how to run it, and shows its equations
    text = (notebooks.FOLDER / f"{name}.py").read_text(encoding="utf-8")
    opening = text.partition("# %%\n")[0]
    assert 'pip install ".[course]"' in opening
    assert "pathsim-jsbsim course" in opening
    assert text.count("$$") >= 2


@pytest.mark.parametrize("name", notebooks.names())
def test_a_chapter_asks(name):
    cells = notebooks.source(name).cells
    for head in ("*Aim:*", "*Assumed:*", "*Time:*", "minutes"):
        assert head in cells[0].source, head
    after = {"**Predict.**": [], "**Exercise.**": []}
    for cell, following in itertools.pairwise(cells):
        for question, answers in after.items():
            if question in cell.source:
                assert following.cell_type == "code", question
                answers.append(following.source)
    assert after["**Predict.**"]
    assert any("assert " in answer for answer in after["**Exercise.**"])


def test_every_block_picture_is_in_a_chapter():
    text = "".join(p.read_text(encoding="utf-8") for p in notebooks.FOLDER.glob("*.py"))
    used = set(re.findall(r"\(figures/(\w+)\.svg\)", text))
    assert used == {p.stem for p in (notebooks.FOLDER / "figures").glob("*.svg")}
    assert used == set(notebooks.block_pictures.PICTURES)


def test_the_wheel_has_every_chapter():
    project = (DOCS.parent / "pyproject.toml").read_text(encoding="utf-8")
    for file in (*(f"{name}.ipynb" for name in notebooks.names()), "figures"):
        assert f'"docs/notebooks/{file}" = "pathsim_jsbsim_blocks/course/{file}"\n' in project


def shown(notebook):
    """Of each cell: the words, the numbers and how many figures; none of a cell of versions."""
    for cell in notebook.cells:
        if cell.cell_type != "code" or "versions" in cell.metadata.get("tags", ()):
            continue
        outputs = [output.get("data", {}) for output in cell.outputs]
        figures = sum("image/png" in data for data in outputs)
        # what is printed and what is warned of have no order between them
        text = "".join(
            output.get("text", "") or output.get("data", {}).get("text/plain", "")
            for output in sorted(cell.outputs, key=lambda output: output.get("name") == "stderr")
        )
        numbers = [float(number.replace(",", "")) for number in NUMBER.findall(text)]
        yield NUMBER.sub("#", text).split(), numbers, figures


def thumbnails(notebook):
    """Each figure in grey, eight times smaller: a line moved by a pixel is no difference."""
    image = pytest.importorskip("PIL.Image")
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):
            if "image/png" in output.get("data", {}):
                png = base64.b64decode(output["data"]["image/png"])
                with image.open(io.BytesIO(png)) as picture:
                    grey = picture.convert("L")
                    yield np.asarray(
                        grey.resize((100, 100 * grey.height // grey.width), image.Resampling.BOX),
                        dtype=float,
                    )


def alike(figure, other):
    if abs(len(figure) - len(other)) > 1:
        return False
    rows = min(len(figure), len(other))
    return np.abs(figure[:rows] - other[:rows]).max() < 60


# that of the chart takes a minute, which its page and its command take too
NAMES = [n for n in notebooks.names() if n != bounded("11_performance", "")]


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_shows_what_a_run_shows(name, tmp_path):
    run, stored = notebooks.executed(name, tmp_path), committed(name)
    again, before = list(shown(run)), list(shown(stored))
    assert [(words, figures) for words, _, figures in again] == [
        (words, figures) for words, _, figures in before
    ]
    # chapter 0 reads numbers only
    assert sum(figures for _, _, figures in before) > 0 or name == "00_inside_one_step"
    for (_, numbers, _), (_, expected, _) in zip(again, before, strict=True):
        # half of the last digit printed, where a last bit tips it
        assert numbers == pytest.approx(expected, rel=1e-3, abs=1e-3)
    for drawn, kept in zip(thumbnails(run), thumbnails(stored), strict=True):
        assert alike(drawn, kept)
    assert list(tmp_path.iterdir()) == []
