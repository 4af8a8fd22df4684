"""Mutated models: a typed error, or a script that says what the model says; nothing runs."""

import ast
import json

import pytest
from how_many import bounded
from mutated_models import (
    NESTED,
    Watch,
    assert_says_what_the_model_says,
    convert_mutants,
)

from pathsim_jsbsim_blocks.pathview import convert_model
from pathsim_jsbsim_blocks.pathview.toolboxes import core_registry

pytest.importorskip("pathview")


@pytest.mark.long
def test_mutated_models_execute_nothing(tmp_path):
    outcomes = convert_mutants(bounded(2000, 20_000), 7, tmp_path)
    assert outcomes["script"] > 250
    assert outcomes["DiagramError"] > 250


def test_the_watch_sees_what_is_executed():
    watch = Watch()
    with watch:
        exec("1 + 1")
    assert [event for event, _ in watch.seen] == ["exec"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("# Subsystem: plant", "# Subsystem: plant\nprint()"),
        ("step = StepSource(", "step = print("),
        ("import numpy as np", "import numpy as np\nprint()"),
    ],
)
def test_the_comparison_sees_a_script_that_says_something_else(old, new, tmp_path):
    path = tmp_path / "model.pvm"
    path.write_text(json.dumps(NESTED))
    code = convert_model(path).read_text(encoding="utf-8")
    registry = core_registry()
    assert_says_what_the_model_says(code, NESTED, registry)
    changed = code.replace(old, new)
    if changed == code:
        pytest.fail(f"{old!r} is not in the script")
    ast.parse(changed)
    with pytest.raises((AssertionError, KeyError, AttributeError, TypeError)):
        assert_says_what_the_model_says(changed, NESTED, registry)
