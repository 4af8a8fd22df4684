"""Make what is generated in the documentation: the gallery with its figures, the API reference.

    python docs/generate.py
"""

import ast
import contextlib
import html
import importlib
import inspect
import io
import os
import runpy
import tempfile
from importlib.metadata import version
from pathlib import Path

import matplotlib

matplotlib.use("agg")

from pathsim.blocks import Block

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks.catalogue import diagram_names, find_diagram
from pathsim_jsbsim_blocks.flight.fleet import HEADER, fleet_table, format_row
from pathsim_jsbsim_blocks.studies import STUDIES

DOCS = Path(__file__).resolve().parent
README = DOCS.parent / "README.md"
GALLERY_BEGINS, GALLERY_ENDS = "<!-- gallery -->", "<!-- end of gallery -->"
MODULES = ["air", "axes", "flight", "plots", "catalogue", "studies", "pathview"]


def pictures():
    """One figure for each diagram: the first that its script shows."""
    (DOCS / "pictures").mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name in diagram_names():
            with contextlib.redirect_stdout(io.StringIO()):
                runpy.run_path(str(find_diagram(name)), run_name="__main__")
            shrink(Path(f"{name}.png"), DOCS / "pictures" / f"{name}.png")
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


def gallery(columns=3):
    """The README's gallery: a picture, the name and the first line of each script."""
    cells = []
    for name in diagram_names():
        summary = ast.get_docstring(ast.parse(find_diagram(name).read_text())).splitlines()[0]
        cells.append(f'<td width="33%" valign="top"><a href="diagrams/{name}.py">'
                     f'<img src="docs/pictures/{name}.png" alt="{name}"></a><br>'
                     f"<code>{name}</code> "
                     f'(<a href="docs/pictures/{name}_pathview.png">in PathView</a>)<br>'
                     f"{html.escape(summary)}</td>")
    rows = [cells[i:i + columns] for i in range(0, len(cells), columns)]
    return "<table>\n" + "\n".join(
        "<tr>\n" + "\n".join(row) + "\n</tr>" for row in rows) + "\n</table>"


def readme():
    """The README with the gallery as it is now."""
    before, _, rest = README.read_text(encoding="utf-8").partition(GALLERY_BEGINS)
    _, end, after = rest.partition(GALLERY_ENDS)
    if not end:
        raise ValueError(f"no {GALLERY_BEGINS} ... {GALLERY_ENDS} in {README}")
    return f"{before}{GALLERY_BEGINS}\n{gallery()}\n{GALLERY_ENDS}{after}"


def _entry(name, thing, level):
    signature = ""
    with contextlib.suppress(ValueError, TypeError):
        signature = str(inspect.signature(thing))
    text = inspect.getdoc(thing) or ""
    return f"{'#' * level} {name}\n\n```text\n{name}{signature}\n\n{text}\n```\n"


def reference():
    """The API reference, from the docstrings of all public names."""
    parts = ["# API reference\n\nMade from the docstrings by `docs/generate.py`.\n"]
    public = {n: o for n, o in vars(package).items()
              if inspect.isclass(o) and o.__module__.startswith(package.__name__)}
    parts.append("## Blocks\n")
    parts += [_entry(n, o, 3) for n, o in sorted(public.items()) if issubclass(o, Block)]
    parts.append("## Conditions, states, errors\n")
    parts += [_entry(n, o, 3) for n, o in sorted(public.items()) if not issubclass(o, Block)]
    for name in MODULES:
        module = importlib.import_module(f"{package.__name__}.{name}")
        own = {n: o for n, o in vars(module).items()
               if not n.startswith("_") and n not in public
               and (inspect.isfunction(o) or inspect.isclass(o))
               and o.__module__.startswith(module.__name__)}
        parts.append(f"## {package.__name__}.{name}\n\n{inspect.getdoc(module)}\n")
        parts += [_entry(n, o, 3) for n, o in sorted(own.items())]
    return "\n".join(parts)


def fleet_page():
    """How every aircraft that jsbsim brings does in level flight."""
    rows = list(fleet_table())
    trims = sum(row.error is None for row in rows)
    departs = sum("departs" in row.verdict for row in rows)
    return (f"# The fleet\n\nThe {len(rows)} aircraft that jsbsim {version('jsbsim')} brings; "
            f"{trims} of them trim in level flight, {departs} of these do not stay there.\n"
            "Each is trimmed by JSBSim where `level_flight` of `pathsim_jsbsim_blocks.flight` "
            "finds it a condition\n(gear up where it retracts, fuel frozen) and flown for 30 s "
            "with its controls held; the drift is its\nchange of altitude. `pathsim-jsbsim "
            f"aircraft --table` prints the table anew.\n\n{HEADER}"
            + "".join(f"{format_row(row)}\n" for row in rows))


def main():
    (DOCS / "fleet.md").write_text(fleet_page(), encoding="utf-8")
    (DOCS / "api.md").write_text(reference(), encoding="utf-8")
    README.write_text(readme(), encoding="utf-8")
    pictures()
    study_pictures()


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "agg")
    main()
