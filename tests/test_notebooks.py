"""The notebooks of the course: made from their sources, with the outputs that a run gives."""

import importlib
import re
import sys
from pathlib import Path

import pytest
from how_many import bounded, first

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


def shown(notebook):
    """Of each cell: the words, the numbers and how many figures; none of a cell of versions."""
    for cell in notebook.cells:
        if cell.cell_type != "code" or "versions" in cell.metadata.get("tags", ()):
            continue
        outputs = [output.get("data", {}) for output in cell.outputs]
        figures = sum("image/png" in data for data in outputs)
        text = "".join(
            output.get("text", "") or output.get("data", {}).get("text/plain", "")
            for output in cell.outputs
        )
        numbers = [float(number.replace(",", "")) for number in NUMBER.findall(text)]
        yield NUMBER.sub("#", text).split(), numbers, figures


# all of them take minutes
@pytest.mark.parametrize("name", first(bounded(notebooks.names()[:5], notebooks.names())))
def test_a_notebook_shows_what_a_run_shows(name, tmp_path):
    again = list(shown(notebooks.executed(name, tmp_path)))
    before = list(shown(committed(name)))
    assert [(words, figures) for words, _, figures in again] == [
        (words, figures) for words, _, figures in before
    ]
    assert sum(figures for _, _, figures in before) > 0
    for (_, numbers, _), (_, expected, _) in zip(again, before, strict=True):
        # half of the last digit printed, where a last bit tips it
        assert numbers == pytest.approx(expected, rel=1e-3, abs=1e-3)
    assert list(tmp_path.iterdir()) == []
