"""Make the notebooks of the course: each docs/notebooks/NAME.py is executed into NAME.ipynb.

python docs/notebooks.py [NAME ...]

The block diagrams are drawn again, too (block_pictures.py).
"""

import os
import sys
from pathlib import Path

import block_pictures
import jupytext
import nbclient
import nbformat

FOLDER = Path(__file__).resolve().parent / "notebooks"


def names():
    """The chapters in their order."""
    return sorted(path.stem for path in FOLDER.glob("*.py"))


def source(name):
    """A chapter as a notebook without outputs."""
    text = jupytext.read(FOLDER / f"{name}.py", fmt="py:percent")
    notebook = nbformat.v4.new_notebook(cells=text.cells)
    notebook.metadata["kernelspec"] = {
        "name": "python3",
        "display_name": "Python 3",
        "language": "python",
    }
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"cell-{number}"  # the same file for the same source
    return notebook


def executed(name, folder=None):
    """A chapter with its outputs."""
    notebook = source(name)
    # a warning names the file of its line, which is otherwise a temporary one of the kernel
    os.environ["IPYKERNEL_CELL_NAME"] = "cell"
    os.environ.pop("MPLBACKEND", None)  # a figure is shown by the kernel's own backend alone
    nbclient.NotebookClient(
        notebook,
        timeout=600,
        kernel_name="python3",
        record_timing=False,
        resources={"metadata": {"path": str(folder or FOLDER)}},
    ).execute()
    notebook.metadata.pop("language_info", None)  # names the Python that ran it
    return notebook


def main(chosen):
    block_pictures.main()
    for name in chosen or names():
        before = os.times()
        nbformat.write(executed(name), FOLDER / f"{name}.ipynb")
        took = [b - a for a, b in zip(before, os.times(), strict=True)]
        print(f"{name}: {took[4]:.0f} s, {sum(took[2:4]):.0f} s of the processor", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
