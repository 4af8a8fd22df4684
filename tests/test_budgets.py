"""Size is a cost: lines of each folder, and words of the pages, stay within ``budgets.toml``."""

import re
import sys
from pathlib import Path

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    tomllib = pytest.importorskip("tomli")

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "pathsim_jsbsim_blocks"
BUDGETS = tomllib.loads((ROOT / "budgets.toml").read_text(encoding="utf-8"))


def lines(root):
    """Lines of Python in each folder, those beside the folders under "."."""
    sizes = {}
    for file in root.rglob("*.py"):
        parts = file.relative_to(root).parts
        folder = parts[0] if len(parts) > 1 else "."
        sizes[folder] = sizes.get(folder, 0) + file.read_bytes().count(b"\n")
    return sizes


def core():
    """Files of the core: those of the modules that import nothing beyond it, by the contract."""
    tools = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    contract = tools["importlinter"]["contracts"][0]
    assert contract["name"] == "the core imports nothing beyond"
    for module in contract["source_modules"]:
        place = SOURCE / module.rpartition(".")[2]
        yield from place.rglob("*.py") if place.is_dir() else [place.with_suffix(".py")]


def totals():
    """Lines of Python of the core, of the whole package, and of the tools that make the docs."""
    sizes = {"core": core(), "src": SOURCE.rglob("*.py"), "docs": (ROOT / "docs").rglob("*.py")}
    return {
        name: sum(file.read_bytes().count(b"\n") for file in files) for name, files in sizes.items()
    }


@pytest.mark.parametrize(("table", "root"), [("src", SOURCE), ("tests", ROOT / "tests")])
def test_lines_of_each_folder(table, root):
    sizes, most = lines(root), BUDGETS[table]
    assert sizes.keys() == most.keys(), "budgets.toml has a line for each folder"
    assert {name: n for name, n in sizes.items() if n > most[name]} == {}


def test_lines_of_the_core_of_the_package_and_of_the_tools_of_the_docs():
    sizes, most = totals(), BUDGETS["totals"]
    assert sizes.keys() == most.keys()
    assert {name: n for name, n in sizes.items() if n > most[name]} == {}


# tutorials, chapters, reference and generated pages are free
FREE = {"tutorial", "drawing", "conventions", "messages", "command-line", "gallery"}
FREE |= {"published-examples", "index", "changelog", "contributing", "security"}


def test_words_of_the_readme_and_of_how_to_pages():
    most = BUDGETS["words"]
    docs = ROOT / "docs"
    pages = [ROOT / "README.md", *docs.glob("*.md"), *(docs / "concepts").glob("*.md")]
    words = {p.name: len(p.read_text(encoding="utf-8").split()) for p in pages}
    how_to = {name: n for name, n in words.items() if name.removesuffix(".md") not in FREE}
    assert {name: n for name, n in how_to.items() if n > most.get(name, most["how-to"])} == {}


BESIDE = re.compile(r"<!--.*?-->|```.*?```|^(?:\||!\[|#)[^\n]*$", re.DOTALL | re.MULTILINE)


def test_words_of_evidence_beside_its_tables():
    """Pictures, headings and code do not count either: the method stands on the how-to page."""
    pages = (ROOT / "docs" / "evidence").glob("*.md")
    words = {p.name: len(BESIDE.sub("", p.read_text(encoding="utf-8")).split()) for p in pages}
    assert {name: n for name, n in words.items() if n > BUDGETS["words"]["evidence"]} == {}


if __name__ == "__main__":  # .ci/run shows them
    print(*(f"{name}: {n:,} lines" for name, n in totals().items()), sep=", ")
