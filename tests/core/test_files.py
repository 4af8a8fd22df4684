"""Files that are written whole or not at all."""

import os
import threading
from pathlib import Path

import pytest

from pathsim_jsbsim_blocks import ParameterError
from pathsim_jsbsim_blocks._core.files import ending, replacing, writable, write_whole
from pathsim_jsbsim_blocks.errors import FileError


def test_a_file_is_written_and_replaced(tmp_path):
    for name in ("short", 255 * "x"):
        file = tmp_path / name
        write_whole(file, "one\n")
        file.chmod(0o640)
        write_whole(file, "two\n")
        assert file.read_bytes() == b"two\n"
        assert os.name == "nt" or file.stat().st_mode & 0o777 == 0o640
    assert sorted(os.listdir(tmp_path)) == ["short", 255 * "x"]


@pytest.mark.parametrize("before", [None, "one"])
def test_an_exception_while_a_file_is_written_leaves_the_one_before(before, tmp_path):
    file = tmp_path / "table.csv"
    if before:
        file.write_text(before)

    def fail():
        with replacing(file) as part:
            assert (part.parent, part.suffix) == (tmp_path, ".csv")
            part.write_text("two")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert [path.read_text() for path in tmp_path.iterdir()] == ([before] if before else [])


def test_a_file_in_a_folder_that_takes_no_new_one_is_written(tmp_path, monkeypatch):
    def denied(path, mode="r", *args, **kwargs):
        if "x" in mode:
            raise PermissionError(13, "Permission denied", str(path))
        return opened(path, mode, *args, **kwargs)

    opened = Path.open
    file = tmp_path / "file"
    file.write_text("one")
    monkeypatch.setattr(Path, "open", denied)
    write_whole(file, "two")
    with pytest.raises(FileError) as error:
        write_whole(tmp_path / "new", "two")
    assert (error.value.path, error.value.reason) == (str(tmp_path / "new"), "Permission denied")
    monkeypatch.undo()
    assert file.read_text() == "two"
    assert os.listdir(tmp_path) == ["file"]


def test_a_look_whether_a_file_can_be_written_changes_none(tmp_path):
    assert writable("file", tmp_path / "new.csv") == tmp_path / "new.csv"
    assert list(tmp_path.iterdir()) == []
    path = tmp_path / "old.csv"
    path.write_text("kept")
    writable("file", str(path))
    assert path.read_text() == "kept"


@pytest.mark.skipif(os.name == "nt" or not hasattr(os, "mkfifo"), reason="no pipes in folders")
def test_a_pipe_is_not_opened(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    # opening it to write would wait for a reader
    checking = threading.Thread(target=writable, args=("file", path), daemon=True)
    checking.start()
    checking.join(10)
    assert not checking.is_alive()


def test_no_file_can_be_written_there(tmp_path):
    for path in (tmp_path, tmp_path / "none" / "x.csv", tmp_path / ("x" * 300)):
        with pytest.raises(ParameterError) as error:
            writable("file", path)
        assert (error.value.parameter, error.value.value) == ("file", str(path))


def test_another_ending_is_refused_with_the_nearest_one(tmp_path):
    path = tmp_path / "gains.jsn"
    with pytest.raises(
        ParameterError, match=r"must end in \.json or \.csv, not 'gains\.jsn'.*gains\.json'"
    ):
        ending("file", path, ".json", ".csv")
    assert ending("file", path.with_suffix(".CSV"), ".json", ".csv").suffix == ".CSV"
