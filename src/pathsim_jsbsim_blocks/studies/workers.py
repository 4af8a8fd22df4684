"""Run the parts of a study on all cores or on a cluster, and survive the death of a worker.

Work goes through joblib: to local processes, or under ``joblib.parallel_config("dask")`` to the
cluster of that context. A study is cut into parts by its points alone, so that its table does not
depend on which worker computed what.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from .._core.callers import warn_user
from .._core.checks import whole
from .._core.extras import required
from ..errors import ParameterError
from .journal import Journal
from .parent import end_with

Row = dict[str, Any]
Part = list[Any]
Work = Callable[[Part], list[Row]]

WORKER_DIED = "worker died"

# result of a part whose worker died
_DIED = object()


def run_parts(
    work: Work,
    parts: list[Part],
    *,
    died: Row,
    describe: Callable[[Any], str],
    title: str,
    job: Callable[[], Any],
    jobs: int,
    resume: str | Path | None,
    progress: bool,
) -> list[Row]:
    """Rows of all points, in the order of the points.

    Parameters
    ----------
    work : callable
        computes the rows of one part; it must not raise for a point that merely fails
    parts : list of lists
        the points of each part, which one worker computes in their order
    died : dict
        the row of a point that kills its worker
    describe : callable
        a point in words, for messages
    title : str
        the study in words
    job : callable
        everything that the results depend on, as plain data, to identify a file to resume from
    jobs : int
        worker processes; -1 for all cores. Not used on a cluster
    resume : Path, optional
        file that keeps finished parts
    progress : bool
        show a progress bar on stderr
    """
    jobs = _count(jobs)
    if resume is not None:
        required("filelock", "studies")
    journal = Journal(resume, title, job()) if resume is not None else None
    try:
        return _run(
            work,
            parts,
            died,
            describe,
            journal,
            jobs,
            _bar(title, parts, journal.finished if journal else {}, progress),
        )
    finally:
        if journal:
            journal.close()


def _count(jobs: int) -> int:
    if jobs == -1:
        return -1
    try:
        return whole("jobs", jobs, low=1)
    except ParameterError as error:
        raise ParameterError(f"{error} (-1: all cores)", parameter="jobs", value=jobs) from None


def _bar(title: str, parts: list[Part], finished: dict[int, list[Row]], progress: bool) -> Any:
    from tqdm import tqdm

    return tqdm(
        total=sum(map(len, parts)),
        initial=sum(map(len, finished.values())),
        desc=title,
        unit=" points",
        disable=not progress,
    )


def _run(
    work: Work,
    parts: list[Part],
    died: Row,
    describe: Callable[[Any], str],
    journal: Journal | None,
    jobs: int,
    bar: Any,
) -> list[Row]:
    rows: dict[int, list[Row]] = dict(journal.finished) if journal else {}

    def keep(index: int, result: list[Row]) -> None:
        rows[index] = result
        # not stored: a resumed study retries the points that killed a worker
        if journal and died not in result:
            journal.add(index, result)
        bar.update(len(result))

    with bar:
        while pending := [i for i in range(len(parts)) if i not in rows]:
            suspects = []
            # a single part gains nothing from a second process
            for index, result in _results(work, parts, pending, 1 if len(parts) == 1 else jobs):
                if result is _DIED:
                    suspects.append(index)
                else:
                    keep(index, result)
            if suspects:
                warn_user(
                    "a worker process died while these points were under way: "
                    + "; ".join(_span(parts[i], describe) for i in suspects)
                    + ". They are computed again, one part at a time"
                )
            for index in suspects:
                keep(index, _alone(work, parts[index], died, describe))
    return [row for index in range(len(parts)) for row in rows[index]]


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
) -> Iterator[tuple[int, Any]]:
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
        initializer=end_with,
        initargs=(os.getpid(),),
    )
    try:
        for index, rows in parallel(tasks()):
            under_way.remove(index)
            yield index, rows
    except TerminatedWorkerError:
        yield from ((index, _DIED) for index in under_way)


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
