"""Make what belongs to a diagram script: its model, its pictures and its place in the gallery.

    python docs/add_diagram.py NAME ...
    python docs/add_diagram.py --models     all models again, and nothing else

The first needs Chromium. Blocks are placed anew: a kept position of an older model may be too close
for a block that has become larger.
"""

import sys
import tempfile
from pathlib import Path

import generate
import screenshots

from pathsim_jsbsim_blocks.catalogue import diagram_names, find_diagram
from pathsim_jsbsim_blocks.pathview import export_script


def write_model(name, check=60.0):
    """The model of a diagram, with the ports that its blocks have now."""
    script = find_diagram(name)
    with tempfile.TemporaryDirectory() as folder:  # without the positions of the model beside it
        model = export_script(script, Path(folder, f"{name}.pvm"), check)
        script.with_suffix(".pvm").write_bytes(model.read_bytes())


def main(names):
    for name in names:
        write_model(name)
        generate.picture(name)
    screenshots.main(names)
    generate.write_pages()


if __name__ == "__main__":
    if sys.argv[1:] == ["--models"]:
        for diagram in diagram_names():
            write_model(diagram, check=0.5)
    else:
        main(sys.argv[1:])
