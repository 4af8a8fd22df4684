"""Run the parts of a study on all cores or on a cluster, and name a point that kills its worker.

Work goes through joblib: to local processes, or under ``joblib.parallel_config("dask")`` to the
cluster of that context. A study is cut into parts by its points alone, so that its table does not
depend on which worker computed what.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from .._core.callers import warn_user
from .._core.checks import flag, integer, number, refuse
from .._core.extras import required
from ..errors import ParameterError
from .journal import Journal, study_key

Row = dict[str, Any]
Part = list[Any]
Work = Callable[[Part], list[Row]]

WORKER_DIED = "worker died"

# processes; more than any machine has cores
_MOST_JOBS = 1024

# result of a part whose worker died
_DIED = object()


def run_parts(
    work: Work,  # must not raise for a point that merely fails
    parts: list[Part],  # points that one worker computes in order
    *,
    death: Row,  # row for a point that kills its worker
    describe: Callable[[Any], str],  # text of a point, for messages
    title: str,  # text of the study
    job: Callable[[], Mapping[str, Any]],  # all that rows depend on, as plain data by name
    jobs: int,  # worker processes, -1 for all cores; not used on a cluster
    resume: str | Path | None,  # file that keeps finished parts
    progress: bool,  # show a bar on stderr
) -> list[Row]:
    """Rows of all points, in the order of the points."""
    from tqdm import tqdm

    joblib = required("joblib", "studies")
    flag("progress", progress)
    if jobs == -1:
        jobs = joblib.cpu_count()
    else:
        try:
            jobs = integer("jobs", number("jobs", jobs, high=_MOST_JOBS), low=1)
        except ParameterError as error:
            refuse("jobs", jobs, f"{error} (-1: all cores)")
    journal = None
    if resume is not None:
        journal = Journal(resume, study_key({"study": title, **job()}))
    rows = dict(journal.finished) if journal else {}
    points, done = _points(parts), _points(rows.values())
    try:
        bar = tqdm(total=points, initial=done, desc=title, unit=" points", disable=not progress)
        stream = _computed(work, parts, {*rows}, death, describe, jobs)
        with bar, contextlib.closing(stream) as results:
            for index, result in results:
                rows[index] = result
                # a resumed study tries the points again that killed a worker
                if journal and death not in result:
                    journal.write([index, result])
                bar.update(len(result))
    except KeyboardInterrupt:
        outcome = "lost; resume=FILE (--resume FILE) keeps them"
        outcome = outcome if resume is None else f"resume with --resume {str(resume)!r}"
        done = _points(rows.values())
        raise KeyboardInterrupt(f"{done} of {points} points done, {outcome}") from None
    finally:
        if journal:
            journal.file.close()
    return [row for index in range(len(parts)) for row in rows[index]]


def _points(parts: Iterable[list[Any]]) -> int:
    return sum(map(len, parts))


def _computed(
    work: Work,
    parts: list[Part],
    done: set[int],
    death: Row,
    describe: Callable[[Any], str],
    jobs: int,
) -> Generator[tuple[int, list[Row]]]:
    """Index and rows of each unfinished part; parts whose worker dies are repeated one by one."""
    while pending := [i for i in range(len(parts)) if i not in done]:
        suspects = []
        # no more workers than parts: each takes seconds to start
        for index, result in _results(work, parts, pending, min(jobs, len(parts))):
            if result is _DIED:
                suspects.append(index)
            else:
                done.add(index)
                yield index, result
        if suspects:
            points = "; ".join(_span(parts[i], describe) for i in suspects)
            died_at = f"a worker process died while it computed these points: {points}"
            warn_user(f"{died_at}. They are computed again, one part at a time")
        for index in suspects:
            done.add(index)
            yield index, _alone(work, parts[index], death, describe)


def _span(part: Part, describe: Callable[[Any], str]) -> str:
    more = f" to {describe(part[-1])}" if len(part) > 1 else ""
    return f"{describe(part[0])}{more}"


def _alone(work: Work, part: Part, death: Row, describe: Callable[[Any], str]) -> list[Row]:
    """Rows of a part computed on its own, to find the point that kills its worker."""
    [(_, result)] = _results(work, [part], [0], 2)
    if result is not _DIED:
        return result
    if len(part) == 1:
        warn_user(f"{WORKER_DIED} at {describe(part[0])}")
        return [death]
    return [row for point in part for row in _alone(work, [point], death, describe)]


def _results(work: Work, parts: list[Part], pending: list[int], jobs: int) -> Iterator[Any]:
    """Index and rows of each pending part as it is finished, or ``_DIED`` for some."""
    import joblib
    from joblib.externals.loky.process_executor import TerminatedWorkerError
    from joblib.parallel import LokyBackend, get_active_backend

    backend = get_active_backend()[0]
    client = getattr(backend, "client", None)
    if type(client).__module__.startswith("distributed."):
        # joblib waits indefinitely for a task whose Dask workers died, so call the client
        yield from _on_dask(client, work, parts, pending)
        return
    if not isinstance(backend, LokyBackend):  # threads would share the seeded generators
        name = type(backend).__name__
        refuse("jobs", name, f"studies run on joblib's loky or on a Dask cluster, not on {name}")
    under_way: list[int] = []

    def tasks() -> Iterator[Any]:
        for index in pending:
            under_way.append(index)
            yield joblib.delayed(lambda i, part: (i, work(part)))(index, parts[index])

    # workers stay alive for the next study; other arguments (e.g. another folder) start new ones
    parallel = joblib.Parallel(
        n_jobs=jobs,
        batch_size=1,
        return_as="generator_unordered",
        initializer=_begin_worker,
        initargs=(os.getpid(), os.getcwd()),
    )
    with _ctrl_c_waits():
        results = parallel(tasks())
    try:
        for index, rows in results:
            under_way.remove(index)
            yield index, rows
    except TerminatedWorkerError:
        yield from ((index, _DIED) for index in under_way)
    finally:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # joblib warns about the tasks that it drops
            results.close()


@contextlib.contextmanager
def _ctrl_c_waits() -> Iterator[None]:
    """Ctrl-C takes effect afterwards; processes started within ignore it, also while they import.

    At a terminal it reaches all processes; the caller ends the workers.
    """
    from multiprocessing import resource_tracker

    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # loky needs it; started later, it would unblock the signal
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _begin_worker(caller: int, folder: str) -> None:
    from tqdm import tqdm

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # where it is not blocked, as on Windows
    # tqdm's default lock is a system semaphore, which leaks when the worker is killed
    tqdm.set_lock(threading.RLock())
    with contextlib.suppress(OSError):
        os.chdir(folder)
    threading.Thread(target=_end_with, args=(caller,), daemon=True).start()


def _end_with(caller: int) -> None:
    """End this process once its caller has been killed; loky would wait for minutes."""
    while os.getppid() == caller:
        time.sleep(0.5)
    os._exit(1)


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
