"""Make what is generated in the documentation: the figures of the gallery and the API reference.

    python docs/generate.py
"""

import contextlib
import importlib
import inspect
import io
import os
import runpy
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("agg")

from pathsim.blocks import Block  # noqa: E402

import pathsim_jsbsim_blocks as package  # noqa: E402
from pathsim_jsbsim_blocks.catalogue import diagram_names, find_diagram  # noqa: E402

DOCS = Path(__file__).resolve().parent
MODULES = ["atmosphere", "airspeed", "axes", "trim", "airframe", "plots", "catalogue", "studies",
           "pathview", "fleet"]


def pictures():
    """One figure for each diagram: the first that its script shows."""
    (DOCS / "pictures").mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name in diagram_names():
            with contextlib.redirect_stdout(io.StringIO()):
                runpy.run_path(str(find_diagram(name)), run_name="__main__")
            _shrink(Path(f"{name}.png"), DOCS / "pictures" / f"{name}.png")
        os.chdir(DOCS)


def _shrink(source, target, width=800):
    from PIL import Image

    with Image.open(source) as image:
        height = round(image.height * width / image.width)
        image.convert("RGB").resize((width, height), Image.Resampling.LANCZOS).quantize(64).save(
            target, optimize=True)


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


def main():
    (DOCS / "api.md").write_text(reference(), encoding="utf-8")
    pictures()


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "agg")
    main()
