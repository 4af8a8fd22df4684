"""Run the parts of a study on all cores or on a cluster, and survive the death of a worker.

Work goes through joblib: to local processes, or under ``joblib.parallel_config("dask")`` to the
cluster of that context. A study is cut into parts by its points alone, so that its table does not
depend on which worker computed what.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from .._core.callers import warn_user
from .._core.checks import flag, refuse, whole
from ..errors import ParameterError
from .identity import study_key
from .journal import Journal
from .parent import end_with

Row = dict[str, Any]
Part = list[Any]
Work = Callable[[Part], list[Row]]

WORKER_DIED = "worker died"

# result of a part whose worker died
_DIED = object()


def run_parts(
    work: Work,  # must not raise for a point that merely fails
    parts: list[Part],  # the points that one worker computes in their order
    *,
    died: Row,  # of a point that kills its worker
    describe: Callable[[Any], str],  # a point in words, for messages
    title: str,  # the study in words
    job: Callable[[], Mapping[str, Any]],  # all that rows depend on, as plain data by name
    jobs: int,  # worker processes, -1 for all cores; not used on a cluster
    resume: str | Path | None,  # file that keeps finished parts
    progress: bool,  # show a bar on stderr
) -> list[Row]:
    """Rows of all points, in the order of the points."""
    from tqdm import tqdm

    flag("progress", progress)
    if jobs != -1:
        try:
            jobs = whole("jobs", jobs, low=1)
        except ParameterError as error:
            refuse("jobs", jobs, f"{error} (-1: all cores)")
    journal = Journal(resume, title, study_key(job())) if resume is not None else None
    rows = dict(journal.finished) if journal else {}

    def keep(index: int, result: list[Row]) -> None:
        rows[index] = result
        # not stored: a resumed study retries the points that killed a worker
        if journal and died not in result:
            journal.add(index, result)
        bar.update(len(result))

    points, done = _points(parts), _points(rows.values())
    try:
        bar = tqdm(total=points, initial=done, desc=title, unit=" points", disable=not progress)
        with _one_interrupt(), bar:
            while pending := [i for i in range(len(parts)) if i not in rows]:
                _run(work, parts, pending, keep, died, describe, jobs)
    except KeyboardInterrupt:
        kept = "lost: name a file to resume from and they are kept"
        kept = kept if resume is None else f"resume with {str(resume)!r}"
        done = _points(rows.values())
        raise KeyboardInterrupt(f"{done} of {points} points done, {kept}") from None
    finally:
        if journal:
            journal.close()
    return [row for index in range(len(parts)) for row in rows[index]]


@contextlib.contextmanager
def _one_interrupt() -> Iterator[None]:
    """Raise KeyboardInterrupt once: a second Ctrl-C would cut short the end of the workers."""

    def interrupt(*_: Any) -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        raise KeyboardInterrupt

    usual = signal.getsignal(signal.SIGINT)
    in_main = threading.current_thread() is threading.main_thread()
    if usual is not signal.default_int_handler or not in_main:
        yield
        return
    signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)


def _points(parts: Iterable[list[Any]]) -> int:
    return sum(map(len, parts))


def _run(
    work: Work,
    parts: list[Part],
    pending: list[int],
    keep: Callable[[int, list[Row]], None],
    died: Row,
    describe: Callable[[Any], str],
    jobs: int,
) -> None:
    suspects = []
    # a single part gains nothing from a second process
    results = _results(work, parts, pending, 1 if len(parts) == 1 else jobs)
    with contextlib.closing(results):
        for index, result in results:
            if result is _DIED:
                suspects.append(index)
            else:
                keep(index, result)
    if suspects:
        points = "; ".join(_span(parts[i], describe) for i in suspects)
        died_at = f"a worker process died while these points were under way: {points}"
        warn_user(f"{died_at}. They are computed again, one part at a time")
    for index in suspects:
        keep(index, _alone(work, parts[index], died, describe))


def _span(part: Part, describe: Callable[[Any], str]) -> str:
    more = f" to {describe(part[-1])}" if len(part) > 1 else ""
    return f"{describe(part[0])}{more}"


def _alone(work: Work, part: Part, died: Row, describe: Callable[[Any], str]) -> list[Row]:
    """Rows of a part computed on its own, to find the point that kills its worker."""
    [(_, result)] = _results(work, [part], [0], 2)
    if result is not _DIED:
        return result
    if len(part) == 1:
        warn_user(f"{WORKER_DIED} at {describe(part[0])}")
        return [died]
    return [row for point in part for row in _alone(work, [point], died, describe)]


def _results(
    work: Work, parts: list[Part], pending: list[int], jobs: int
) -> Generator[tuple[int, Any]]:
    """Index and rows of each pending part as it is finished, or ``_DIED`` for some."""
    import joblib
    from joblib.externals.loky.process_executor import TerminatedWorkerError
    from joblib.parallel import get_active_backend

    client = getattr(get_active_backend()[0], "client", None)
    if type(client).__module__.startswith("distributed."):
        # joblib waits indefinitely for a task whose Dask workers died, so call the client
        yield from _on_dask(client, work, parts, pending)
        return
    under_way: list[int] = []
    caller, here = os.getpid(), _folder()

    def indexed(index: int, part: Part) -> tuple[int, list[Row]]:
        # joblib keeps workers for the next study, in the folder where they were started
        if here is not None and os.getpid() != caller:
            with contextlib.suppress(OSError):
                os.chdir(here)
        return index, work(part)

    def tasks() -> Iterator[Any]:
        for index in pending:
            under_way.append(index)
            yield joblib.delayed(indexed)(index, parts[index])

    parallel = joblib.Parallel(
        n_jobs=jobs,
        batch_size=1,
        return_as="generator_unordered",
        initializer=_begin_worker,
        initargs=(os.getpid(),),
    )
    with contextlib.nullcontext() if jobs == 1 else _interrupts_held():
        results = parallel(tasks())
    try:
        for index, rows in results:
            under_way.remove(index)
            yield index, rows
    except TerminatedWorkerError:
        yield from ((index, _DIED) for index in under_way)
    finally:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # joblib tells how many tasks it drops
            results.close()


@contextlib.contextmanager
def _interrupts_held() -> Iterator[None]:
    """Delay Ctrl-C; processes that are started within the context never receive it."""
    if sys.platform == "win32":
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # starting it would unblock SIGINT
    usual = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, usual)


def _begin_worker(caller: int) -> None:
    from tqdm import tqdm

    end_with(caller)
    # Ctrl-C at a terminal reaches all processes; the caller ends the workers
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # tqdm's default lock is a system semaphore, which leaks when the worker is killed
    tqdm.set_lock(threading.RLock())


def _folder() -> str | None:
    """The working directory, or None if it was deleted."""
    try:
        return os.getcwd()
    except FileNotFoundError:
        return None


def _on_dask(
    client: Any, work: Work, parts: list[Part], pending: list[int]
) -> Iterator[tuple[int, Any]]:
    from distributed import KilledWorker, as_completed

    futures = {client.submit(work, parts[index], pure=False): index for index in pending}
    try:
        for future in as_completed(list(futures)):
            error = future.exception()
            if error is None:
                yield futures[future], future.result()
            elif isinstance(error, KilledWorker):
                yield futures[future], _DIED
            else:
                raise error
    finally:
        client.cancel(list(futures))
