"""Make what belongs to a diagram script: its model, its pictures and its place in the gallery.

    python docs/add_diagram.py NAME ...
    python docs/add_diagram.py --models     all models again, and nothing else

The first needs Chromium. Positions in a model that is there already are kept.
"""

import sys
import tempfile
from pathlib import Path

import generate
import screenshots

from pathsim_jsbsim_blocks.catalogue import diagram_names, find_diagram
from pathsim_jsbsim_blocks.cli import main as command
from pathsim_jsbsim_blocks.pathview import export_script


def write_models():
    """The models of all diagrams, with the ports that their blocks have now."""
    for name in diagram_names():
        export_script(find_diagram(name), check=0.5)


def main(names):
    for name in names:
        export_script(find_diagram(name))
        with tempfile.TemporaryDirectory() as folder:
            figure = Path(folder, f"{name}.png")
            command(["run", name, "--save", str(figure)])
            generate.shrink(figure, generate.DOCS / "pictures" / figure.name)
    screenshots.main(names)
    generate.write_pages()


if __name__ == "__main__":
    write_models() if sys.argv[1:] == ["--models"] else main(sys.argv[1:])
