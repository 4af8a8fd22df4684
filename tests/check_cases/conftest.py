import importlib
from pathlib import Path

import pytest


@pytest.fixture
def accuracy(monkeypatch):
    """The module of ``python docs/generate.py accuracy``, and the page that it wrote."""
    docs = Path(__file__).parents[2] / "docs"
    monkeypatch.syspath_prepend(docs)
    page = (docs / "evidence" / "accuracy.md").read_text(encoding="utf-8")
    return importlib.import_module("generate"), page
