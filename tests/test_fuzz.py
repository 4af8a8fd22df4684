"""Random arguments everywhere: our own errors or a valid object, and nothing else happens."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import settings

FUZZ = Path(__file__).with_name("fuzz_public_names.py")


@pytest.mark.long
def test_random_arguments_end_in_our_own_errors_and_leave_nothing_behind(tmp_path):
    work, temporary, storage = (tmp_path / name for name in ("work", "tmp", "hypothesis"))
    work.mkdir()
    temporary.mkdir()
    report = tmp_path / "report.json"
    done = subprocess.run(
        [sys.executable, str(FUZZ), str(report), str(settings().max_examples // 33)],
        cwd=work,
        capture_output=True,
        timeout=600,
        env={
            **os.environ,
            "TMPDIR": str(temporary),
            "PYTHONDONTWRITEBYTECODE": "1",
            "HYPOTHESIS_STORAGE_DIRECTORY": str(storage),
        },
    )
    # an abort would show here
    assert done.returncode == 0, done.stderr.decode()
    assert json.loads(report.read_text(encoding="utf-8")) == []
    assert (done.stdout, done.stderr) == (b"", b"")
    assert os.listdir(work) == []
    assert os.listdir(temporary) == []
