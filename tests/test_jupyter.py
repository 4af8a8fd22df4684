"""Figures in a notebook: each is drawn once, and no file is written."""

import pytest

from pathsim_jsbsim_blocks.catalogue import diagram_names, find_diagram

nbclient = pytest.importorskip("nbclient")
nbformat = pytest.importorskip("nbformat")
pytest.importorskip("ipykernel")

BUILD = """
from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.plots import show
diagram = load_diagram("hello_jsbsim")
diagram.sim.run(diagram.DURATION)
"""

CELLS = {  # code: figures that it draws
    f"%run {find_diagram('hello_jsbsim').as_posix()}": 1,
    BUILD: 0,
    "figure = diagram.figure()": 0,
    "diagram.figure()": 1,
    "show(diagram.figure(), 'flight')": 1,
    "figure": 1,
}


@pytest.mark.long
def test_a_notebook_draws_each_figure_once_and_writes_no_file(tmp_path):
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(c) for c in CELLS])
    resources = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(
        notebook, timeout=120, kernel_name="python3", resources=resources
    ).execute()
    drawn = [
        sum("image/png" in output.get("data", {}) for output in cell.outputs)
        for cell in notebook.cells
    ]
    assert drawn == [*CELLS.values()]
    assert list(tmp_path.iterdir()) == []


def test_diagrams_take_their_figures_from_plots():
    # a figure of pyplot's own would be drawn once more at the end of its cell
    own = [n for n in diagram_names() if "pyplot" in find_diagram(n).read_text(encoding="utf-8")]
    assert own == []
