"""Make what belongs to a diagram script: its model, its pictures and its place in the gallery.

    python docs/add_diagram.py NAME ...

Needs Chromium. Positions in a model that is there already are kept.
"""

import os
import sys

import generate
import screenshots

from pathsim_jsbsim_blocks.catalogue import find_diagram
from pathsim_jsbsim_blocks.pathview import export_script


def main(names):
    for name in names:
        export_script(find_diagram(name))
        generate.picture(name)
    screenshots.main(names)
    (generate.DOCS / "gallery.md").write_text(generate.gallery(), encoding="utf-8")


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "agg")
    main(sys.argv[1:])
