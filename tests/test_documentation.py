"""Documentation that runs: all code blocks of the README and the pages, all docstring examples."""

import ast
import doctest
import importlib
import json
import pkgutil
import re
import shlex
import sys
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from all_holds import HOLDS
from printed import run_code

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks.catalogue import (
    diagram_groups,
    diagram_names,
    diagram_notebook,
    find_diagram,
)
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.pathview.toolboxes import Toolbox

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S)


@pytest.fixture(autouse=True)
def _in_an_empty_directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    plt.switch_backend("agg")


FIVE = ("damped_oscillator", "step_response", "van_der_pol", "elevator_doublet", "pitch_hold")

# what a user reads first is run with all tests, the other pages with the long ones
FIRST = ("README.md", "tutorial.md")


def marks(pages, command=""):
    # the diagrams of the README fly in tests/diagrams
    quick = {*pages} & {*FIRST} and command.partition(" run ")[2] not in FIVE[:4]
    return () if quick else pytest.mark.long


@pytest.mark.parametrize(
    "page",
    [pytest.param(p, id=p.name, marks=marks([p.name])) for p in PAGES if blocks(p, "python")],
)
def test_python_blocks_run_in_their_order(page, tmp_path):
    if page.name == "fmu.md":  # no library for each platform
        pytest.importorskip("pythonfmu3")
    # as a script, because resume is for functions of a file
    script = tmp_path / f"{page.stem}.py"
    code = "\n".join(blocks(page, "python"))
    script.write_text(code, encoding="utf-8")
    names = {"__name__": page.stem, "__file__": str(script)}
    assert run_code(code, script, names) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_outputs_in_comments_are_compared(page):
    code = "\n".join(blocks(page, "python"))
    lines = code.splitlines()
    calls = (n for n in ast.walk(ast.parse(code)) if isinstance(n, ast.Call))
    prints = [n for n in calls if getattr(n.func, "id", "") == "print"]
    comments = [lines[n.end_lineno - 1].partition("  # ")[2] for n in prints]
    assert [c for c in comments if re.search(r"\d", c) and not c.startswith("prints: ")] == []


def sessions():
    """The commands of each block of a page."""
    for page in PAGES:
        table = re.findall(r"^\| `pathsim-jsbsim .*", page.read_text(encoding="utf-8"), re.M)
        for block in [*blocks(page, "sh"), "\n".join(re.findall("`([^`]+)`", "".join(table)))]:
            lines = (line.partition("  #")[0] for line in block.replace("\\\n", " ").splitlines())
            yield page.name, [c.strip() for c in lines if c.startswith("pathsim-jsbsim ")]


def _uses_pathview(command):
    return command.split()[1] in ("view", "export", "convert") or ".pvm" in command


def commands():
    """Each command once, with the pages that have it."""
    found = {}
    for page, session in sessions():
        for command in session:
            if not _uses_pathview(command):
                found.setdefault(command, []).append(page)
    return found.items()


COMMANDS = [
    pytest.param(c, id=f"{', '.join(pages)}: {c}", marks=marks(pages, c))
    for c, pages in commands()
    if c != "pathsim-jsbsim check"  # a step of .ci/run
]
PATHVIEW = [
    pytest.param(commands, id=f"{page}: {commands[0]}", marks=marks([page]))
    for page, session in sessions()
    if (commands := [c for c in session if _uses_pathview(c)])
]


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_run(command):
    arguments = shlex.split(command)[1:]
    if arguments == ["course"]:  # otherwise JupyterLab runs until it is stopped
        arguments.append("--no-open")
    assert main(arguments) == 0


@pytest.mark.parametrize("session", PATHVIEW)
def test_commands_with_files_of_ones_own_run_one_after_another(session, tmp_path, monkeypatch):
    pytest.importorskip("pathview")
    shown = []
    # serving has tests of its own, in a browser
    load = importlib.import_module("pathsim_jsbsim_blocks.pathview._view")._load
    monkeypatch.setattr(
        "pathsim_jsbsim_blocks.pathview.view",
        lambda target, port, browser, **trust: shown.append(target and load(target, **trust)),
    )
    monkeypatch.syspath_prepend(tmp_path / "site")
    for number, words in enumerate(map(shlex.split, session), 1):
        _, command, *options = words
        target = tmp_path / options[0] if options else tmp_path
        # scripts of JSBSim are found below its root
        if target.suffix not in ("", ".xml") and not target.exists():
            diagram = find_diagram("hello_jsbsim" if "--track" in options else "step_response")
            target.write_bytes(diagram.with_suffix(target.suffix).read_bytes())
        for package_name in (b for a, b in pairwise(options) if a == "--toolbox"):
            folder = tmp_path.joinpath("site", *Toolbox.parse(package_name).import_path.split("."))
            folder.mkdir(parents=True)
            (folder / "__init__.py").touch()
        before = set(tmp_path.iterdir())
        assert main(words[1:]) == 0
        new = set(tmp_path.iterdir()) - before
        if command == "run":  # a table or a track, and the figures where there is no display
            written = next(b for a, b in pairwise(options) if a in ("--csv", "--track"))
            assert tmp_path / written in new
        else:
            assert len(new) == (command != "view"), f"command {number} writes {new}"
    assert len(shown) == sum(command.split()[1] == "view" for command in session)


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_and_pictures_are_there(page):
    for target in re.findall(
        r"\]\(([^)#]+)[^)]*\)|src=\"([^\"]+)\"", page.read_text(encoding="utf-8")
    ):
        path = target[0] or target[1]
        # docs/hooks.py writes the flight into the site
        if not path.startswith("http") and path != "flight.html":
            assert (page.parent / path).exists(), path


def slugs(page):
    """The anchors of a page or notebook, as GitHub makes them of its headings."""
    text = page.read_text(encoding="utf-8")
    if page.suffix == ".ipynb":
        text = "\n".join("".join(cell["source"]) for cell in json.loads(text)["cells"])
    for heading in re.findall(
        r"^#+ (.*)$", re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S), re.M
    ):
        words = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).lower()
        yield re.sub(r"[^\w -]", "", words).replace(" ", "-")


CHAPTERS = sorted((ROOT / "docs" / "notebooks").glob("*.py"))


@pytest.mark.parametrize("page", [*PAGES, *CHAPTERS], ids=lambda p: p.name)
def test_anchors_are_headings(page):
    text = page.read_text(encoding="utf-8")
    for target, anchor in re.findall(r"\]\(([^)#\s]*)#([^)\s]+)\)", text):
        if not target.startswith("http"):
            other = page.parent / target if target else page
            assert anchor in {*slugs(other)}, f"{target}#{anchor}"


# what a link promises with these words, and how a section of a page or a chapter shows it
SHOWN = {
    r"(?:figure|picture|chart|plot)s?": r"!\[|^```\{image\}|image/png|\.pdf",
    r"tables?": r"^\||image/png|text/html|\.csv|^```\{csv-table\}",
}


def section(page, anchor):
    """The text of a page below a heading, up to the next of its rank; of a chapter its outputs too."""
    text = page.read_text(encoding="utf-8")
    if page.suffix == ".ipynb":
        cells = json.loads(text)["cells"]
        outputs = [json.dumps(cell.get("outputs", "")) for cell in cells]
        text = "\n".join(
            f"{''.join(c['source'])}\n{o}" for c, o in zip(cells, outputs, strict=True)
        )
    parts = re.split(r"^(#+ .*)$", text, flags=re.M)
    if not anchor:
        return text
    headings, bodies = parts[1::2], parts[2::2]
    names = [re.sub(r"[^\w -]", "", h.lstrip("# ").lower()).replace(" ", "-") for h in headings]
    start = names.index(anchor)
    rank = len(headings[start].split()[0])
    end = next(
        (i for i in range(start + 1, len(names)) if len(headings[i].split()[0]) <= rank), None
    )
    return "".join(bodies[start:end])


def broken_promises(page):
    """Links whose text names a figure or a table that the section of their target lacks."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    for link, target, anchor in re.findall(r"(?<!!)\[([^]\[]*)\]\(([^)#\s]*)#?([^)\s]*)\)", text):
        other = page.parent / target if target else page
        if target.startswith("http") or other.suffix not in (".md", ".ipynb"):
            continue
        words = re.sub(r"`[^`]*`", "", link)
        for promise, sign in SHOWN.items():
            if re.search(rf"\b{promise}\b", words, re.I) and not re.search(
                sign, section(other, anchor), re.M
            ):
                yield link


@pytest.mark.parametrize("page", [*PAGES, *CHAPTERS], ids=lambda p: p.name)
def test_a_link_keeps_the_promise_of_its_text(page):
    assert [*broken_promises(page)] == []


def test_a_link_to_a_missing_figure_is_listed(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "# One\n[the figure](#two), [a figure](#three), [a table](#two), [`figure()`](#two)\n"
        "## Two\n![x](x.png)\n## Three\nNo.\n"
    )
    assert [*broken_promises(page)] == ["a figure", "a table"]


def test_pages_have_every_folder_and_every_hold():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    folders = [m.name for m in pkgutil.iter_modules(package.__path__) if m.ispkg]
    assert [name for name in folders if f"`{name}/`" not in text] == []
    text = (ROOT / "docs" / "autopilots.md").read_text(encoding="utf-8")
    assert [n for n in HOLDS if n != "Autopilot" and f"| `{n}` |" not in text] == []


def test_every_published_diagram_is_mapped_to_its_notebook():
    follow = diagram_groups()["published"]
    assert [n for n in diagram_names() if diagram_notebook(n)] == sorted(follow)
    page = (ROOT / "docs" / "published-examples.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| \[(\d+) .*", page.partition("\n## ")[0], re.M)
    lines = page.partition("\n## ")[0].splitlines()
    table = {n: line for n in rows for line in lines if line.startswith(f"| [{n} ")}
    for name in follow:
        assert f"`{name}`" in table[str(diagram_notebook(name))], name
    beyond = {*diagram_names()} - {*follow}
    assert not [n for n in beyond if f"`{n}`" in page.partition("\n## ")[0]]
    readme = PAGES[0].read_text(encoding="utf-8")
    assert f"all {len(diagram_names())} diagrams, {len(follow)} of them from" in readme


def test_the_conda_environment_installs_the_checkout_with_its_extras():
    text = (ROOT / "environment.yml").read_text(encoding="utf-8")
    (extras,) = re.findall(r"^      - \.\[(.+)\]$", text, re.M)
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    for extra in extras.split(","):
        assert re.search(rf"^{extra} = \[", project, re.M)
    (python,) = re.findall(r"^  - python=(3\.\d+)$", text, re.M)
    assert f"Python :: {python}" in project


MODULES = [
    m.name
    for m in pkgutil.walk_packages(package.__path__, package.__name__ + ".")
    if ".diagrams" not in m.name
]


# flown for seconds, as design/test_design.py does
SLOW = f"{package.__name__}.design.designed"


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.long] * (n == SLOW)) for n in MODULES]
)
def test_docstring_examples(name):
    failed, tried = doctest.testmod(importlib.import_module(name))
    assert (failed, tried > 0 or name != SLOW) == (0, True)


def test_the_block_reference_has_every_public_name():
    text = "".join(p.read_text(encoding="utf-8") for p in (ROOT / "docs" / "reference").glob("*"))
    public = [
        n
        for n in package.__all__
        if isinstance(o := getattr(package, n), type) and not issubclass(o, Exception)
    ]
    assert [n for n in public if f"autoclass:: {n}\n" not in text] == []


# what users import from; the others are for the package alone
SUBJECTS = sorted(
    m.name
    for m in pkgutil.iter_modules(package.__path__)
    if m.name[0] != "_" and m.name not in ("cli", "guidance", "scripts")
)


@pytest.mark.parametrize("subject", SUBJECTS)
def test_what_users_call_has_one_documented_place(subject):
    module = importlib.import_module(f"{package.__name__}.{subject}")
    assert f"\n- ``{subject}``: " in package.__doc__ or subject == "sources"
    if not hasattr(module, "__path__"):
        return
    pages = "".join(p.read_text("utf-8") for p in (ROOT / "docs" / "reference").glob("*.rst"))
    whole = re.findall(r"automodule:: (\S+)\n   :members:((?: [\w,]+)*)\n", pages)
    members = [n for m, names in whole for n in names.replace(",", " ").split() or [m]]
    for name in module.__all__:
        origin = getattr(getattr(module, name), "__module__", module.__name__)
        single = re.search(rf"auto\w+:: (\S+\.)?{name}\n", pages)
        assert single or {name, origin, module.__name__} & {*members}, name


def test_the_block_reference_finds_its_names():
    # automodule also sets the module that bare names are looked up in
    for page in sorted((ROOT / "docs" / "reference").glob("*.rst")):
        module = ""
        for directive, name in re.findall(r"^\.\. (\w+):: (\S+)$", page.read_text("utf-8"), re.M):
            if directive in ("currentmodule", "module", "automodule"):
                module = name
            elif directive.startswith("auto"):
                path = name if name.startswith(f"{package.__name__}.") else f"{module}.{name}"
                pkgutil.resolve_name(path)


def test_generated_pages_are_current_and_made_by_one_command(monkeypatch):
    # after a change: python docs/generate.py pages
    monkeypatch.syspath_prepend(ROOT / "docs")
    generate = importlib.import_module("generate")
    assert generate.gallery() == (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    blocks = (ROOT / "docs" / "reference" / "blocks.md").read_text(encoding="utf-8")
    assert f"<!-- blocks -->\n{generate.blocks_tables()}\n<!-- end -->" in blocks
    if sys.version_info >= (3, 11):  # with tomllib
        layers = importlib.import_module("layers").layers_picture()
        assert layers == (ROOT / "docs/pictures/layers.svg").read_text(encoding="utf-8")
    generated = {
        "monte-carlo": generate.scale_table(),
        "trim": generate.searches(),
        "linear-models": generate.throttle_table(),
        "command-line": generate.commands_tables(),
        "evidence/designed-gains": generate.requirements_table(),
    }
    for page, text in generated.items():
        assert text in (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8"), page
    # what docs/gain_tables.py judges flights by, and design_gains the linear model
    for limit in ("| target | 1.4 | 1.8 | 7 dB | 45 deg |", "| 4 s | 6 s | 0.25 deg |"):
        assert limit in generated["evidence/designed-gains"]
    for name in diagram_names():
        assert f".. image:: ../pictures/{name}.png" in generate.diagram_page(name), name
    # a formula stays a directive, which Sphinx typesets
    assert "\n.. math::\n    \\ddot x" in generate.diagram_page("van_der_pol")
    steps = importlib.import_module("everything").STEPS.values()
    run = {word for command in steps for word in command}
    scripts = {f"docs/{p.name}" for p in (ROOT / "docs").glob("*.py")}
    # these are part of others, or print what no page has
    others = ("block_pictures", "conf", "everything", "fleet", "hooks", "layers", "tables")
    assert scripts - run == {f"docs/{name}.py" for name in others}


def test_numbers_of_evidence_are_those_of_their_tables(monkeypatch):
    # each page in words is made of the table beside it
    monkeypatch.syspath_prepend(ROOT / "docs")
    generate = importlib.import_module("generate")
    charts = importlib.import_module("performance_charts")
    pages = {n: (generate.EVIDENCE / f"{n}.md").read_text(encoding="utf-8") for n in TABLES}
    number = re.compile(r"jsbsim [\d.]+ brings")  # the jsbsim that is installed
    assert number.sub("", generate.fleet_page()) == number.sub("", pages["fleet"])
    assert f"-->\n{generate.modes_counts()}\n<!--" in pages["fleet"]
    assert charts.page() == pages["performance"]


TABLES = ("fleet", "performance")


@pytest.mark.long
def test_formulas_of_the_site_need_no_script(monkeypatch):
    pytest.importorskip("sphinx")
    from docutils import nodes

    monkeypatch.syspath_prepend(ROOT / "docs")
    hooks = importlib.import_module("hooks")

    class Writer:
        body = []

    aligned, word, half = r"a &= \frac{b}{c} \\ d &= e", r"\alpha", r"\tfrac12 \rho"
    for node in (nodes.math_block("", aligned), nodes.math("", word), nodes.math("", half)):
        with pytest.raises(nodes.SkipNode):
            hooks.mathml(Writer, node)
    lines, word, half = (re.sub(r"\s", "", text) for text in Writer.body)
    assert lines.count("<mtr>") == 2
    assert "<mfrac>" in lines
    assert "<mi>\N{GREEK SMALL LETTER ALPHA}</mi>" in word
    assert "<mn>1</mn><mn>2</mn></mfrac>" in half
