"""Futures of a flight: functions that run in copies of this process."""

from __future__ import annotations

import contextlib
import gc
import os
import pickle
import random
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, NamedTuple

from .._core.checks import integer, must_be
from .._core.progress import progress_bar
from ..errors import BranchError
from ..flight.airframe import with_sockets
from ..flight.forked import Fork, Forks

# a progress bar for more futures than these
_FEW = 10

# packages whose code a thread runs while it flies; and what does not fly in this process: copies,
# and PathView's server
_FLYING = ("pathsim", "pathsim_jsbsim_blocks")
_ELSEWHERE = (Forks.__module__, "pathsim_jsbsim_blocks.pathview.")


class _Answer(NamedTuple):
    """What a copy sends back: a result, or else an error or the reason why there is none."""

    result: Any = None
    error: BaseException | None = None
    reason: str = ""
    # where it was raised
    traceback: str = ""


class _InFuture(Exception):
    """The traceback of an error in its copy, which pickling loses."""

    def __str__(self) -> str:
        return f"\n\n{self.args[0].rstrip()}"


def branch(futures: Iterable[Callable[[], Any]], jobs: int | None = None) -> list[Any]:
    """Run each function in a copy of this process as it is now; return their results in order.

    JSBSim cannot save its state, but the operating system copies the process that holds it, in
    some 10 ms. A function flies on, changes what it likes and returns what it measured; the
    flight here is unchanged, and the copies end with the call. A future may branch again.

    All random generators, Python's and NumPy's global ones too, are in each future as they are
    now: a function that needs other numbers seeds them. Not kept apart are files, which all
    futures share, and there are no snapshots that outlive the call.

    Parameters
    ----------
    futures : iterable of callable
        functions without arguments. They need not be pickled, their results must
    jobs : int, optional
        copies at the same time; default, and -1, one for each core

    Returns
    -------
    list
        what each function returned

    Raises
    ------
    Exception
        an error of a future, as it is; of several, that of the first in the list. The others are
        ended
    BranchError
        for a future that a signal or an exit has ended, a result or an error that cannot be
        pickled, and where no branch is possible: without ``os.fork`` (Windows), with an aircraft
        that is connected to FlightGear or allowed a network, since its copies would send too, and
        beside other threads that run PathSim, which the copies would lack
    ParameterError
        for a future that is no function, and invalid ``jobs``
    """
    functions = _functions(futures)
    most = _cores() if jobs in (None, -1) else integer("jobs", jobs, low=1)
    _refuse_here()
    # Python seeds its generator anew in a copy
    state = random.getstate()
    answers: dict[int, _Answer] = {}
    bar = progress_bar(
        len(functions),
        None if len(functions) > _FEW else False,
        desc="branch",
        unit=" futures",
    )
    with Forks() as forks, bar:
        numbers: dict[Fork, int] = {}
        # the first future without a result: those before it run to their end, so that the error
        # does not depend on which copy was faster
        failure = len(functions)
        start = 0
        while start < failure or forks.running:
            if start < failure and len(forks.running) < most:
                function = functions[start]
                numbers[forks.start(partial(_run, function, state))] = start
                start += 1
                continue
            fork = forks.next()
            number = numbers.pop(fork)
            answers[number] = answer = _answer_of(fork)
            bar.update(1)
            if answer.error is not None or answer.reason:
                failure = min(failure, number)
                for successor in [f for f, i in numbers.items() if i > failure]:
                    del numbers[successor]
                    forks.kill(successor)
    if failure < len(functions):
        _raise(failure, answers[failure])
    return [answers[i].result for i in range(len(functions))]


def _functions(futures: Any) -> list[Callable[[], Any]]:
    if callable(futures) or isinstance(futures, (str, bytes)) or not isinstance(futures, Iterable):
        must_be("futures", futures, "a list of functions without arguments")
    functions = list(futures)
    for i, function in enumerate(functions):
        if not callable(function):
            must_be(f"futures[{i}]", function, "a function without arguments")
    return functions


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _refuse_here() -> None:
    """Raise where the copies could not fly, or would act outside."""
    why = ""
    if not hasattr(os, "fork"):
        why = "this system has no os.fork, which copies a process: Linux and macOS have it"
    elif threads := _flying_threads():
        why = f"another thread runs PathSim ({', '.join(threads)}), and a copy would lack it: end "
        why += "it, or branch in a process of its own"
    elif with_sockets:
        gc.collect()  # a simulation that is no longer used
        if names := sorted({repr(airframe.aircraft) for airframe in with_sockets}):
            why = f"aircraft {', '.join(names)} is connected to FlightGear or allowed a network, "
            why += "and its copies would send too: build it without flightgear and allow_network"
    if why:
        raise BranchError(f"no branch is possible: {why}")


def _flying_threads() -> list[str]:
    """Names of other threads that run PathSim."""
    threads = {thread.ident: thread.name for thread in threading.enumerate()}
    names = []
    for ident, frame in sys._current_frames().items():
        if ident == threading.get_ident():
            continue
        while frame is not None:
            module = frame.f_globals.get("__name__", "")
            if module.partition(".")[0] in _FLYING and not module.startswith(_ELSEWHERE):
                names.append(threads.get(ident, str(ident)))
                break
            frame = frame.f_back  # type: ignore[assignment]
    return names


def _run(function: Callable[[], Any], state: Any) -> bytes:
    """Run a future in its copy; its pickled answer."""
    random.setstate(state)
    try:
        answer = _Answer(result=function())
    except SystemExit as error:
        answer = _Answer(reason=f"ended by sys.exit({error.code!r})")
    except BaseException as error:
        answer = _Answer(error=error, traceback=traceback.format_exc())
        with contextlib.suppress(BaseException):
            # an error can be pickled and not restored, if its class takes other arguments
            return _restorable(answer)
        text = f"{type(error).__name__}: {error}"
        answer = answer._replace(error=None, reason=f"raised an error that cannot be sent: {text}")
    try:
        return pickle.dumps(answer)
    except BaseException as error:
        reason = f"returned a result that cannot be pickled: {type(error).__name__}: {error}"
        return pickle.dumps(_Answer(reason=reason))


def _restorable(answer: _Answer) -> bytes:
    content = pickle.dumps(answer)
    pickle.loads(content)
    return content


def _answer_of(fork: Fork) -> _Answer:
    status = fork.status
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        names = {s.value: s.name for s in signal.Signals}  # a real-time signal has none
        return _Answer(reason=f"killed by {names.get(number, f'signal {number}')}")
    if not fork.answer:
        return _Answer(reason=f"ended with exit status {os.WEXITSTATUS(status)}, without a result")
    try:
        return pickle.loads(fork.answer)
    except Exception as error:
        return _Answer(reason=f"returned a result that cannot be restored: {error}")


def _raise(number: int, answer: _Answer) -> None:
    cause = _InFuture(answer.traceback) if answer.traceback else None
    if answer.error is not None:
        raise answer.error from cause
    message = f"future {number} of branch: {answer.reason}"
    raise BranchError(message, future=number, reason=answer.reason) from cause
