"""Checkpoints with a digest, so that damaged files are refused before anything is loaded.

PathSim writes a JSON and an NPZ file and checks neither: a changed number silently gives another
flight. Blocks cannot check the files themselves, since each sees only its own data, and only after
PathSim has read the files and loaded others. The functions here therefore replace PathSim's
methods; diagrams without sampled blocks are not affected.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from pathlib import Path
from typing import Any

from pathsim import Simulation

from ..errors import BlocksError, FileError
from .checks import refuse
from .pathsim_internals import ClockEvent, in_step, replace_checkpoints

_save, _load = Simulation.save_checkpoint, Simulation.load_checkpoint


def _samples(simulation: Simulation) -> bool:
    """Whether a block in the diagram samples."""
    return any(
        isinstance(event, ClockEvent) for block in simulation.blocks for event in block.events
    )


def save_checkpoint(
    simulation: Simulation, path: str | os.PathLike[str], recordings: bool = True
) -> None:
    """Save a diagram as ``path.json`` and ``path.npz``, with a digest over both.

    Existing files are replaced once both new ones are complete.

    Parameters
    ----------
    path : str or Path
        with or without an ending
    recordings : bool
        whether to save what scopes have recorded

    Raises
    ------
    FileError
        if a file cannot be written, such as on a full disk
    ParameterError
        if a block cannot be saved
    """
    if not _samples(simulation):
        return _save(simulation, path, recordings)
    base = _base(path)
    part = f"{base}.part-{os.getpid()}"
    written = [Path(f"{part}{ending}") for ending in (".json", ".npz")]
    try:
        _save(simulation, part, recordings)
        data = json.loads(written[0].read_text(encoding="utf-8"))
        data["digest"] = _digest(data, written[1].read_bytes())
        written[0].write_text(json.dumps(data, indent=2), encoding="utf-8")
        for file in written:
            file.replace(f"{base}{file.suffix}")
    except FileError:
        raise
    except OSError as error:
        raise FileError("write", base, error) from None
    finally:
        for file in written:
            with contextlib.suppress(OSError):
                file.unlink()


def load_checkpoint(simulation: Simulation, path: str | os.PathLike[str]) -> None:
    """Continue from a checkpoint, in a diagram built like the one that was saved.

    Parameters
    ----------
    path : str or Path
        with or without an ending

    Raises
    ------
    ParameterError
        if the files are damaged or belong to another diagram or flight, and inside an event or
        callback of a run
    FileError
        if the files cannot be read
    """
    if not _samples(simulation):
        return _load(simulation, path)
    base = _base(path)
    if in_step(simulation):
        # the step would go on with the time of the run and the state of the checkpoint
        why = "a checkpoint cannot be loaded inside a step: stop the run first"
        refuse("checkpoint", base, why)
    try:
        data = json.loads(Path(f"{base}.json").read_text(encoding="utf-8"))
        intact = data["digest"] == _digest(data, Path(f"{base}.npz").read_bytes())
    except OSError as error:
        raise FileError("read", error.filename or base, error) from None
    except (ValueError, TypeError, KeyError, RecursionError):
        intact = False
    if not intact:
        why = f"the checkpoint {base!r} is damaged: its files have changed since they were saved"
        refuse("checkpoint", base, why)
    try:
        _load(simulation, base)
    except BlocksError:
        raise
    except (ValueError, TypeError, KeyError, IndexError, AttributeError) as error:
        refuse("checkpoint", base, f"the checkpoint {base!r} belongs to another diagram: {error}")


def _base(path: str | os.PathLike[str]) -> str:
    base = os.fspath(path)
    return base.rpartition(".")[0] if base.endswith((".json", ".npz")) else base


def _digest(data: dict[str, Any], arrays: bytes) -> str:
    """Digest of the JSON file's data, whatever its formatting, and of the NPZ file's bytes."""
    content = {key: value for key, value in data.items() if key != "digest"}
    digest = hashlib.sha256(json.dumps(content, sort_keys=True).encode())
    digest.update(arrays)
    return digest.hexdigest()


replace_checkpoints(save_checkpoint, load_checkpoint)
