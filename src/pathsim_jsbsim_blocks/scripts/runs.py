"""Contexts in which the runs of a script are counted, changed or watched.

They replace public methods of ``Simulation`` that start or step a run, only for calls of the thread
that entered the context, and restore them at its end; `fly` looks into `running.in_place`. No other
part of the package replaces anything in PathSim.
"""

from __future__ import annotations

import contextlib
import functools
import inspect
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from pathsim import Simulation

from .._core.running import in_place

# called with the original method, the simulation, the method's name or "fly", and the arguments
Around = Callable[[Callable[..., Any], Simulation, str, dict[str, Any]], Any]


@dataclass
class _Layer:
    """A context of one thread."""

    around: Around
    methods: tuple[str, ...]


_layers: dict[int, list[_Layer]] = {}  # by thread, outermost first
_usual: dict[str, Callable[..., Any]] = {}  # the methods that are replaced
_running = threading.local()
_lock = threading.Lock()


@contextlib.contextmanager
def replaced_runs(around: Around, *methods: str) -> Iterator[None]:
    """Context in which ``around`` is called for each ``Simulation.run`` and `fly`.

    ``methods`` are further ones of ``Simulation``; calls of one by another do not count.
    """
    thread, layer = threading.get_ident(), _Layer(around, ("fly", "run", *methods))
    outer = getattr(in_place, "fly", None)
    with _lock:
        _layers.setdefault(thread, []).append(layer)
        _put_in_place()
    in_place.fly = _flight
    try:
        yield
    finally:
        in_place.fly = outer
        with _lock:
            _layers[thread].remove(layer)
            _put_in_place()


def _put_in_place() -> None:
    """Replace the methods that a context of any thread needs, and put back the others."""
    needed = {m for layers in _layers.values() for layer in layers for m in layer.methods}
    for name in needed - {"fly"} - _usual.keys():
        _usual[name] = getattr(Simulation, name)
        setattr(Simulation, name, _replacing(name, _usual[name]))
    for name in _usual.keys() - needed:
        setattr(Simulation, name, _usual.pop(name))


def _replacing(name: str, usual: Callable[..., Any]) -> Callable[..., Any]:
    signature = inspect.signature(usual)

    @functools.wraps(usual)
    def replaced(sim: Simulation, *args: Any, **kwargs: Any) -> Any:
        call = signature.bind(sim, *args, **kwargs)
        call.apply_defaults()
        return _through(name, usual, sim, dict([*call.arguments.items()][1:]))

    return replaced


def _flight(fly: Callable[..., Any], sim: Simulation, **arguments: Any) -> Any:
    return _through("fly", fly, sim, arguments)


def _through(
    name: str, usual: Callable[..., Any], sim: Simulation, values: dict[str, Any], depth: int = 0
) -> Any:
    """Call a method through the contexts of this thread, the innermost first."""
    running = vars(_running).setdefault("simulations", [])
    layers = [x for x in _layers.get(threading.get_ident(), ())[::-1] if name in x.methods]
    if sim in running or depth == len(layers):
        running.append(sim)
        try:
            return usual(sim, **values)
        finally:
            running.remove(sim)

    def further(sim: Simulation, **arguments: Any) -> Any:
        return _through(name, usual, sim, arguments, depth + 1)

    return layers[depth].around(further, sim, name, values)


@dataclass
class RunStart:
    """The start of a run: its simulation, the method's name or "fly", and the arguments."""

    simulation: Simulation
    method: str
    arguments: dict[str, Any]


def intercepted_runs(
    begin: Callable[[RunStart], None], *methods: str
) -> contextlib.AbstractContextManager[None]:
    """Context in which ``begin`` is called before each run; it may change arguments, or raise."""

    def around(
        usual: Callable[..., Any], sim: Simulation, name: str, values: dict[str, Any]
    ) -> Any:
        begin(RunStart(sim, name, values))
        return usual(sim, **values)

    return replaced_runs(around, *methods)
