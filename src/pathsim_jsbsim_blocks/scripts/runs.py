"""Contexts in which the runs of a script are counted, changed or watched.

They replace public methods of ``Simulation`` that start or step a run, only for calls of the thread
that entered the context, and restore them at its end; `fly` looks into `running.in_place`. One
thread at a time is in such contexts, which may be nested; a second one waits. No other part of the
package replaces anything in PathSim.
"""

from __future__ import annotations

import contextlib
import functools
import inspect
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

from pathsim import Simulation

from .._core.running import in_place

# called with the original method, the simulation, the method's name or "fly", and the arguments
Around = Callable[[Callable[..., Any], Simulation, str, dict[str, Any]], Any]


_one_thread = threading.RLock()


@contextlib.contextmanager
def replaced_runs(around: Around, *methods: str) -> Iterator[None]:
    """Context in which ``around`` is called for each ``Simulation.run`` and `fly`.

    ``methods`` are further ones of ``Simulation``; calls of one by another do not count.
    """
    running: list[Simulation] = []
    thread, outer = threading.get_ident(), getattr(in_place, "fly", None)

    def through(
        name: str, usual: Callable[..., Any], sim: Simulation, values: dict[str, Any]
    ) -> Any:
        if sim in running or threading.get_ident() != thread:
            return usual(sim, **values)
        running.append(sim)
        try:
            return around(usual, sim, name, values)
        finally:
            running.remove(sim)

    def replacing(name: str, usual: Callable[..., Any]) -> Callable[..., Any]:
        signature = inspect.signature(usual)

        @functools.wraps(usual)
        def replaced(sim: Simulation, *args: Any, **kwargs: Any) -> Any:
            call = signature.bind(sim, *args, **kwargs)
            call.apply_defaults()
            return through(name, usual, sim, dict([*call.arguments.items()][1:]))

        return replaced

    def flight(fly: Callable[..., Any], sim: Simulation, **arguments: Any) -> Any:
        usual = fly if outer is None else functools.partial(outer, fly)
        return through("fly", usual, sim, arguments)

    with _one_thread, contextlib.ExitStack() as stack:
        for name in ("run", *methods):
            new = replacing(name, getattr(Simulation, name))
            stack.enter_context(patch.object(Simulation, name, new))
        stack.callback(setattr, in_place, "fly", outer)
        in_place.fly = flight
        yield


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
