"""The models beside the diagram scripts are what the exporter makes of them."""

import math

import pytest
from how_many import EXPORTED, bounded

from pathsim_jsbsim_blocks.catalogue import diagram_folder, diagram_names, find_diagram
from pathsim_jsbsim_blocks.pathview import export_script


@pytest.mark.filterwarnings("ignore:.*same for .* only")
@pytest.mark.parametrize(
    ("name", "check"),
    [
        *((name, 0.5) for name in EXPORTED),
        *(
            pytest.param(name, bounded(20.0, math.inf), marks=pytest.mark.long)
            for name in diagram_names()
        ),
    ],
)
def test_a_model_is_current_and_flies_as_its_script(name, check, tmp_path):
    committed = find_diagram(name).with_suffix(".pvm")
    again = export_script(find_diagram(name), tmp_path / committed.name, check)
    assert again.read_bytes() == committed.read_bytes(), f"python docs/add_diagram.py {name}"


def test_every_model_has_a_script():
    models = sorted(diagram_folder().rglob("*.pvm"))
    assert models == sorted(find_diagram(n).with_suffix(".pvm") for n in diagram_names())
