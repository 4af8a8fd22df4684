"""Make what is generated in the documentation: the gallery, its figures, the table of the fleet.

python docs/generate.py
"""

import ast
import contextlib
import io
import os
import runpy
import tempfile
from importlib.metadata import version
from pathlib import Path

import matplotlib

matplotlib.use("agg")

from pathsim_jsbsim_blocks.catalogue import diagram_names, find_diagram
from pathsim_jsbsim_blocks.flight.fleet import HEADER, fleet_table, format_row
from pathsim_jsbsim_blocks.studies import STUDIES

DOCS = Path(__file__).resolve().parent
GALLERY_INTRODUCTION = """\
# Gallery

Each diagram is a script and a model for PathView. `pathsim-jsbsim run NAME` flies it,
`pathsim-jsbsim view NAME` opens it in the editor.
"""


def picture(name):
    """The figures of a diagram, as its script names them."""
    (DOCS / "pictures").mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        with contextlib.redirect_stdout(io.StringIO()):
            runpy.run_path(str(find_diagram(name)), run_name="__main__")
        for drawn in sorted(Path().glob(f"{name}*.png")):
            shrink(drawn, DOCS / "pictures" / drawn.name)
        os.chdir(DOCS)


def study_pictures():
    """The figure of each study."""
    (DOCS / "pictures").mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, study in STUDIES.items():
            drawn = Path(folder, f"{name}.png")
            study.figure(study.table(progress=False)).savefig(drawn, dpi=110)
            shrink(drawn, DOCS / "pictures" / f"study_{name}.png")


def shrink(source, target, width=800):
    """Write a picture small enough for a README."""
    from PIL import Image

    with Image.open(source) as image:
        height = round(image.height * width / image.width)
        small = image.convert("RGB").resize((width, height), Image.Resampling.LANCZOS)
        # median cut, the default, loses colours of few pixels, such as that of a single mark
        small.quantize(128, Image.Quantize.FASTOCTREE).save(target, optimize=True)


def gallery():
    """One section for each diagram: what it shows, its figure, its model, its script."""
    parts = [GALLERY_INTRODUCTION]
    for name in diagram_names():
        summary, _, rest = ast.get_docstring(
            ast.parse(find_diagram(name).read_text(encoding="utf-8"))
        ).partition("\n")
        parts.append(f"""\
## {name}

**{summary}**

{rest.strip().replace("``", "`")}

![Time histories of {name}](pictures/{name}.png)
{track(name)}
:::{{dropdown}} The diagram in PathView
[![The diagram {name} in PathView](pictures/{name}_pathview.png)](pictures/{name}_pathview.png)
:::

:::{{dropdown}} The script
```{{literalinclude}} ../diagrams/{name}.py
:language: python
```
:::
""")
    return "\n".join(parts)


def track(name):
    """The ground track of a diagram that draws one."""
    file = f"pictures/{name}_track.png"
    return f"\n![Ground track of {name}]({file})\n" if (DOCS / file).is_file() else ""


def fleet_page():
    """How every aircraft that jsbsim brings does in level flight."""
    rows = list(fleet_table())
    trims = sum(row.error is None for row in rows)
    departs = sum("departs" in row.verdict for row in rows)
    return (
        f"# The fleet\n\nThe {len(rows)} aircraft that jsbsim {version('jsbsim')} brings; "
        f"{trims} of them trim in level flight, {departs} of these do not stay there.\n"
        "Each is trimmed by JSBSim where `level_flight` of "
        "`pathsim_jsbsim_blocks.flight.fleet` finds it a condition\n"
        "(gear up where it retracts, fuel frozen) and flown for 30 s with its "
        "controls held; the drift is its\nchange of altitude. `pathsim-jsbsim aircraft "
        f"--table` reprints the table.\n\n{HEADER}"
        + "".join(f"{format_row(row)}\n" for row in rows)
    )


def main():
    (DOCS / "fleet.md").write_text(fleet_page(), encoding="utf-8")
    (DOCS / "gallery.md").write_text(gallery(), encoding="utf-8")
    for name in diagram_names():
        picture(name)
    study_pictures()


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "agg")
    main()
