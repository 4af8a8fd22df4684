"""The environment for users of conda installs this checkout with extras that exist."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_the_conda_environment_installs_the_checkout_with_its_extras():
    text = (ROOT / "environment.yml").read_text(encoding="utf-8")
    (extras,) = re.findall(r"^      - \.\[(.+)\]$", text, re.M)
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    for extra in extras.split(","):
        assert re.search(rf"^{extra} = \[", project, re.M)
    (python,) = re.findall(r"^  - python=(3\.\d+)$", text, re.M)
    assert f"Python :: {python}" in project
