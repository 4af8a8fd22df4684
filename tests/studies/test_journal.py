"""The file of a resumed study: a corruption gives the same table or a typed error."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from corruptions import PARTS, resumed_from_corruptions, run, thirds

from pathsim_jsbsim_blocks import ParameterError
from pathsim_jsbsim_blocks.errors import FileError, MissingExtraError
from pathsim_jsbsim_blocks.studies.journal import Journal, study_key

KEY = study_key({"study": "thirds"})


def test_a_corrupted_file_gives_the_same_table_or_is_refused(tmp_path):
    assert 20 < resumed_from_corruptions(tmp_path, seed=11, count=60) < 60


@pytest.mark.parametrize(
    "damage",
    [
        # a line that is no other one, of JSON or not
        *("nonsense", "{}", "[]", "7", "\0\0\0", "", "[0, []]", "[" * 100_000),
        # a value in it that is another one
        ("0.3333333333333333", "0.3333333333333334"),
        *(("true", "null"), ("[3, ", "[4, "), ("point 5", "point 6")),
        *(("0.3333", "NaN, 0.3333"), ("[2, ", "[2,  ")),
    ],
)
def test_a_damaged_line_is_refused_and_the_file_kept(tmp_path, damage):
    path = tmp_path / "thirds.jsonl"
    run(resume=path)
    text = path.read_text()
    if isinstance(damage, str):
        _, _, rest = text.partition("\n")
        damage = rest.partition("\n")[0], damage
    assert damage[0] in text
    damaged = text.replace(*damage, 1)
    path.write_text(damaged)
    with pytest.raises(ParameterError) as error:
        run(resume=path)
    assert (error.value.parameter, error.value.value) == ("resume", str(path))
    assert path.read_text() == damaged


# the first lines of versions 0.1.0 and 0.3.0
EARLIER = (
    '{"format": "pathsim-jsbsim study 1", "study": "x", "key": "0"}\n',
    '{"format": "pathsim-jsbsim study", "version": 4, "study": "x", "key": {}, "check": "0"}\n',
)


@pytest.mark.parametrize(
    "text",
    [None, "my notes\n", "my notes", "[" * 100_000 + "\n", *EARLIER],
    ids=lambda x: str(x)[:8],
)
def test_a_file_of_other_data_or_an_earlier_version_is_refused_and_kept(tmp_path, text):
    path = tmp_path / "notes.txt"
    if text is None:  # a file without its first line
        run(resume=path)
        text = path.read_text().partition("\n")[2]
    path.write_text(text)
    with pytest.raises(ParameterError) as error:
        run(resume=path)
    assert error.value.parameter == "resume"
    assert path.read_text() == text


def test_a_file_that_cannot_be_opened_is_refused(tmp_path):
    for path in (tmp_path / "none" / "x", tmp_path / ("x" * 300), tmp_path, "a\0"):
        with pytest.raises(ParameterError) as error:
            Journal(path, {})
        assert error.value.parameter == "resume"


def test_opening_removes_no_file_that_another_process_may_have_begun(tmp_path, monkeypatch):
    monkeypatch.delattr(Path, "unlink")
    monkeypatch.delattr(os, "remove")
    Journal(tmp_path / "thirds.jsonl", KEY).file.close()


SECOND = """
import sys
from pathsim_jsbsim_blocks import ParameterError
from pathsim_jsbsim_blocks.studies.journal import Journal, study_key
try:
    Journal(sys.argv[1], study_key({"study": "thirds"})).write([7, []])
except ParameterError as error:
    print(error)
"""


@pytest.mark.long
def test_a_second_process_is_refused_and_the_first_goes_on(tmp_path):
    path = tmp_path / "thirds.jsonl"
    journal = Journal(path, KEY)
    journal.write([0, thirds(PARTS[0])])
    said = subprocess.run([sys.executable, "-c", SECOND, str(path)], capture_output=True, text=True)
    assert "is in use: another process runs this study" in said.stdout, said.stderr
    # nor twice in this process
    with pytest.raises(ParameterError, match="is in use"):
        Journal(path, KEY)
    journal.write([1, thirds(PARTS[1])])
    journal.file.close()
    again = Journal(path, KEY)
    assert sorted(again.finished) == [0, 1]
    again.file.close()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full")
def test_a_full_disk_is_named(tmp_path):
    journal = Journal(tmp_path / "thirds.jsonl", KEY)
    with (
        open("/dev/full", "wb", buffering=0) as journal.file,
        pytest.raises(FileError, match=r"thirds.jsonl': No space left on device"),
    ):
        journal.write([0, []])
    # to read it would never end
    with pytest.raises(ParameterError) as error:
        run(resume="/dev/full")
    assert error.value.parameter == "resume"


def test_without_the_extra_no_file_is_made(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "filelock", None)
    with pytest.raises(MissingExtraError) as error:
        run(resume=tmp_path / "thirds.jsonl")
    assert error.value.extra == "studies"
    assert not list(tmp_path.iterdir())
