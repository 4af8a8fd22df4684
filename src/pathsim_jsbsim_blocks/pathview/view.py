"""Start PathView with this package's blocks registered and a diagram open."""

from __future__ import annotations

import os
import signal
import tempfile
import threading
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import NoReturn
from unittest.mock import patch

from ..catalogue import find_diagram
from . import pvm
from .convert import Json, registry_for, to_python
from .export import script_model
from .server import Server


def view(target: str | Path | None = None, port: int | None = None, browser: bool = True) -> None:
    """Serve PathView on 127.0.0.1 until Ctrl-C, with a diagram open and its toolboxes registered.

    Parameters
    ----------
    target : str or Path, optional
        a diagram of the catalogue, a model (.pvm, .json) or a script (.py); default is an empty
        diagram
    port : int, optional
        default is 8360, or a free port if that is in use
    browser : bool
        open the user's browser

    Raises
    ------
    DiagramError
        if the diagram cannot be shown as it is
    ParameterError
        if there is no such diagram, a toolbox that it needs is not installed, or the port is in use
    """
    name = "" if target is None else f"{Path(target).stem}.pvm"
    models = {} if target is None else {name: _load(target)}
    with _interrupts(), _temporary_files(), Server(models, port) as server:
        print(f"PathView: {server.url(name)}\nCtrl-C ends it", flush=True)
        if browser:
            threading.Thread(target=webbrowser.open, args=[server.url(name)], daemon=True).start()
        server.run()


def _load(target: str | Path) -> Json:
    """A model, checked as a whole: PathView runs a diagram without the blocks it does not know."""
    path = Path(target)
    if path.suffix not in (".pvm", ".json"):
        script = find_diagram(str(target))
        path = script.with_suffix(".pvm")
        existing = pvm.read(path) if path.exists() else None
        if existing is None or str(target) != script.stem:
            return script_model(script, existing)
    content = pvm.read(path)
    to_python(content, registry_for(content, path), path)
    return content


@contextmanager
def _temporary_files() -> Iterator[None]:
    """One folder for what PathView's workers put aside: they are killed and cannot tidy up."""
    with (tempfile.TemporaryDirectory(prefix="pathsim-jsbsim-", ignore_cleanup_errors=True) as new,
          patch.dict(os.environ, TMPDIR=new, TMP=new, TEMP=new)):
        yield


@contextmanager
def _interrupts() -> Iterator[None]:
    """A closed terminal and ``kill`` end the server as Ctrl-C does."""
    def interrupt(number: int, frame: FrameType | None) -> NoReturn:
        raise KeyboardInterrupt

    names = ("SIGINT", "SIGTERM", "SIGHUP")
    # only the main thread may handle signals
    numbers = [getattr(signal, n) for n in names if hasattr(signal, n)
               and threading.current_thread() is threading.main_thread()]
    before = {n: signal.signal(n, interrupt) for n in numbers}
    try:
        with suppress(KeyboardInterrupt):
            yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
