"""Start PathView with this package's blocks registered and a diagram open."""

from __future__ import annotations

import os
import signal
import tempfile
import threading
import webbrowser
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from unittest.mock import patch

from ..catalogue import find_diagram
from . import pvm
from .export import script_model
from .markup import refuse_markup
from .server import Server
from .shape import Json
from .trusted_models import trusted


def view(
    target: str | Path | None = None,
    port: int | None = None,
    browser: bool = True,
    trust: bool = False,
    trust_toolboxes: Sequence[str] = (),
) -> None:
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
    trust : bool
        whether a model from another source may be opened: its parameters and code are Python and
        run with the model. Models of this package, and models trusted before, always open
    trust_toolboxes : sequence of str
        further toolboxes, not PathSim's own, that may be imported if the model requires them

    Raises
    ------
    DiagramError
        if the diagram cannot be shown as it is
    UntrustedModelError
        if the model is from another source and not trusted
    ParameterError
        if there is no such diagram, a toolbox that it needs is not installed, or the port is in use
    """
    name = "" if target is None else f"{Path(target).stem}.pvm"
    models = {} if target is None else {name: _load(target, trust, trust_toolboxes)}
    with _interrupts(), _temporary_files(), Server(models, port) as server:
        print(f"PathView: {server.url(name)}\nCtrl-C ends it", flush=True)
        if browser:
            threading.Thread(target=webbrowser.open, args=[server.url(name)], daemon=True).start()
        server.run()


def _load(target: str | Path, trust: bool, trust_toolboxes: Sequence[str]) -> Json:
    """A model, checked as a whole, because PathView silently drops unknown blocks."""
    path = Path(target)
    if path.suffix not in (".pvm", ".json"):
        script = find_diagram(str(target))
        path = script.with_suffix(".pvm")
        existing = pvm.read(path) if path.exists() else None
        if existing is None or str(target) != script.stem:
            content, _ = script_model(script, existing)
            refuse_markup(content, script)
            return content
    content = pvm.read(path)
    refuse_markup(content, path)
    return pvm.with_event_imports(trusted(content, path, trust, trust_toolboxes)[0])


@contextmanager
def _temporary_files() -> Iterator[None]:
    """One temporary folder for PathView's workers, which are killed without cleanup."""
    with (
        tempfile.TemporaryDirectory(prefix="pathsim-jsbsim-", ignore_cleanup_errors=True) as new,
        patch.dict(os.environ, TMPDIR=new, TMP=new, TEMP=new),
    ):
        yield


@contextmanager
def _interrupts() -> Iterator[None]:
    """Closing the terminal or ``kill`` ends the server as Ctrl-C does."""
    with ExitStack() as stack:
        # only the main thread may handle signals
        in_main = threading.current_thread() is threading.main_thread()
        for name in ("SIGINT", "SIGTERM", "SIGHUP") if in_main else ():
            if number := getattr(signal, name, None):
                handler = signal.signal(number, signal.default_int_handler)
                stack.callback(signal.signal, number, handler)
        stack.enter_context(suppress(KeyboardInterrupt))
        yield
