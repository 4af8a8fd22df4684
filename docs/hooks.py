"""What the site needs beyond Sphinx: formulas without scripts, the pages of the gallery, pictures.

Formulas become MathML, which browsers draw themselves: no script and no network.
"""

import inspect
import re
import tempfile
from pathlib import Path

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from generate import DOCS, diagram_page
from pathsim.blocks import Block
from sphinx.util import logging
from sphinx.util.inspect import stringify_signature

from pathsim_jsbsim_blocks.catalogue import diagram_names
from pathsim_jsbsim_blocks.cli import main as command

FUNCTION = r'<mo form="prefix" lspace="0.17em" rspace="0.17em">\1</mo>\2'


def mathml(writer, node):
    """Write a formula, in the text or on a line of its own."""
    block = isinstance(node, nodes.math_block)
    # docutils would take both digits of \frac12 for the numerator
    tex = re.sub(r"(\\[td]?frac)\s*(\d)\s*(\d)", r"\1{\2}{\3}", node.astext())
    # a blank line separates two equations, as in Sphinx's own formulas
    tex = re.sub(r"\n\s*\n", r" \\\\ ", tex.strip())
    if r"\\" in tex:
        tex = rf"\begin{{aligned}}{tex}\end{{aligned}}"
    try:
        formula = tex2mathml(tex, as_block=block)
    except MathError as error:
        logging.getLogger(__name__).warning("formula: %s", error, location=node)
        formula = writer.encode(tex)
    # browsers set functions without the thin spaces around them
    formula = re.sub(r"<mi>(\w+)</mi>(\s*)<mo>&ApplyFunction;</mo>", FUNCTION, formula)
    writer.body.append(f'<div class="formula">{formula}</div>' if block else formula)
    raise nodes.SkipNode


def write_diagram_pages(app):
    """A page for each diagram; the same text leaves the file, so that it is not built anew."""
    folder = DOCS / "gallery"
    folder.mkdir(exist_ok=True)
    for name in diagram_names():
        page, text = folder / f"{name}.rst", diagram_page(name)
        if not page.exists() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")


def write_flight(app, error):
    """The animated flight of the front page, which needs no network."""
    page = Path(app.outdir, "flight.html")
    whole = error is None and app.builder.format == "html" and app.config.root_doc == "index"
    if whole and not page.exists():
        with tempfile.TemporaryDirectory() as folder:
            figure = str(Path(folder, "flight.png"))
            command(["run", "autoland_c172p", "--track", str(page), "--save", figure])


def link_pages(app, name, source):
    """In the repository a link leads to a script or a source, on the site to its page."""
    up = "../" * name.count("/")
    source[0] = re.sub(
        rf"\({re.escape(up)}\.\./diagrams/\w+/(\w+)\.py\)", rf"({up}gallery/\1.rst)", source[0]
    )
    source[0] = re.sub(
        r"\[`(\w+)`\]\([./]*src/pathsim_jsbsim_blocks/[\w/]+\.py\)",
        r"{py:obj}`\1 <pathsim_jsbsim_blocks.\1>`",
        source[0],
    )
    source[0] = source[0].replace("(../CONTRIBUTING.md", "(contributing.md")
    if name == "gallery":
        source[0] += "\n```{toctree}\n:hidden:\n:glob:\n\ngallery/*\n```\n"


def open_in_full(app, doctree):
    """Pictures are links to themselves, as Sphinx does it for those with a size."""
    for image in doctree.findall(nodes.image):
        image.setdefault("width", "100%")
        if re.search(r"_pathview|drawing_|flight_report", image["uri"]):
            image["classes"].append("editor")
        elif not image["uri"].endswith(".svg"):
            image["classes"].append("plot")


def signature_of_block(app, what, name, thing, options, signature, returns):
    """A block has the signature of its fields: Sphinx would show the `__new__` of their base."""
    if what == "class" and issubclass(thing, Block):
        of_fields = inspect.signature(thing)
        return stringify_signature(
            of_fields, show_annotation=False, show_return_annotation=False
        ), None


def setup(app):
    app.add_html_math_renderer("mathml", (mathml, None), (mathml, None))
    app.connect("autodoc-process-signature", signature_of_block)
    app.connect("builder-inited", write_diagram_pages)
    app.connect("build-finished", write_flight)
    app.connect("source-read", link_pages)
    app.connect("doctree-read", open_in_full)
    return {"parallel_read_safe": True}
