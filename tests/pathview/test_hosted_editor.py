"""PathView's hosted editor runs in the browser, where jsbsim cannot be installed."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from scripts_of_tests import kinds

from pathsim_jsbsim_blocks.catalogue import diagram_names, find_diagram
from pathsim_jsbsim_blocks.pathview.toolboxes import OURS, core_registry

# in a process of its own: finds no jsbsim, and reports what PathView would find and run
HOSTED = """
import importlib.machinery, json, logging, sys

found = importlib.machinery.PathFinder.find_spec
importlib.machinery.PathFinder.find_spec = classmethod(
    lambda cls, name, *args: None if name.partition(".")[0] == "jsbsim" else found(name, *args))

from pathlib import Path
from pathsim_jsbsim_blocks.errors import DiagramError
from pathsim_jsbsim_blocks.pathview.generate import checked, to_python
from pathsim_jsbsim_blocks.pathview.pvm import read
from pathsim_jsbsim_blocks.pathview.toolboxes import registry_for

logging.disable()
runs = []
for path in map(Path, sys.argv[1:]):
    content = read(path)
    try:
        registry = registry_for(content, path)
        code = to_python(checked(content, registry, path), registry, path)
        namespace = {"__name__": "hosted"}
        exec(code, namespace)
    except (DiagramError, ImportError):
        continue
    namespace["sim"].run(10 * namespace["sim"].dt)
    runs.append(path.stem)
print(json.dumps({"runs": runs}))
"""


AIRCRAFT = {"Aircraft", "JSBSimFDM", "LinearAircraft", "JSBSimWrapper"}


def test_the_diagrams_without_aircraft_run_as_the_documentation_says():
    models = [find_diagram(n).with_suffix(".pvm") for n in diagram_names()]
    answer = subprocess.run(
        [sys.executable, "-c", HOSTED, *models],
        text=True,
        check=True,
        stdout=subprocess.PIPE,
        timeout=300,
    )
    runs = json.loads(answer.stdout)["runs"]
    assert runs
    assert runs == [
        model.stem
        for model in models
        if not AIRCRAFT & {kind for _, kind in kinds(json.loads(model.read_text("utf-8"))["graph"])}
    ]
    page = Path(__file__).parents[2] / "docs" / "pathview.md"
    if not page.exists():
        pytest.skip("the documentation is not installed")
    section = page.read_text(encoding="utf-8").partition("## The hosted editor")[2]
    named = re.findall(r"`(\w+)`", section.partition("diagrams run:")[2].partition("\n\n")[0])
    assert sorted(named) == runs


def test_no_block_has_the_name_of_one_of_pathviews():
    """PathView knows blocks by class name: ours would replace its own."""
    assert not set(OURS.blocks()) & set(core_registry()["blocks"])
