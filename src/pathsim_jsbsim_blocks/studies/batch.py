"""Batches of whole diagrams: Monte-Carlo runs and parameter studies."""

from __future__ import annotations

import inspect
import json
import logging
import pickle
import random
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jsbsim
import numpy as np

from .._core.checks import did_you_mean, nearest, whole
from .._core.extras import required
from ..errors import ParameterError
from .grid import expand, plain
from .workers import WORKER_DIED, run_parts

if TYPE_CHECKING:
    import pandas as pd

log = logging.getLogger(__name__)


def run_batch(
    build: Callable[..., Mapping[str, Any]],
    cases: Any,
    *,
    seed: int = 0,
    jobs: int = -1,
    resume: str | Path | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Build, run and measure a diagram for every case.

    Each case is computed on its own, from its own seed, so that the table does not depend on the
    number of workers.

    Parameters
    ----------
    build : callable
        called as ``build(**case)``: builds the diagram, runs it, and returns what it measured as a
        dict of numbers or texts. A parameter ``seed`` receives the case's seed; the
        generators of `random` and of ``numpy.random`` are always seeded with it. It is sent to
        other processes: it must not refer to objects that live outside it, such as an aircraft
    cases : dict, DataFrame or list of dicts
        the parameters of each case; a dict of lists means their product, the last one fastest. A
        column ``seed`` replaces the seeds drawn
    seed : int
        seed of the batch; the seed of each case is drawn from it and the case's position
    jobs : int
        worker processes, -1 for all cores; under ``joblib.parallel_config("dask")`` the cluster's
        workers are used instead
    resume : Path, optional
        file that keeps finished cases: repeating a killed call with the same file resumes it. Of
        ``build`` only the name is compared: after changing what it does, name another file
    progress : bool
        show a progress bar on stderr

    Returns
    -------
    pandas.DataFrame
        one row for each case, in their order: its parameters, ``seed``, ``completed``, ``reason``
        (empty, or the error that ended the case: a trim not found, a flight that cannot continue,
        "worker died") and what ``build`` returned, NaN where it did not

    Raises
    ------
    ParameterError
        before the work begins: no cases, a case that ``build`` does not take, NaN, a ``build`` that
        cannot be sent to other processes, a file that cannot be written or belongs to another batch
    """
    pd = required("pandas", "studies")
    required("joblib", "studies")

    rows = _seeded(expand("cases", cases), whole("seed", seed, low=0))
    takes_seed = _check(build, rows)
    name = f"{getattr(build, '__module__', '')}.{getattr(build, '__qualname__', build)}"
    found = run_parts(
        partial(_run_cases, build, takes_seed),
        [[row] for row in rows],
        died={"completed": False, "reason": WORKER_DIED},
        describe=lambda case: ", ".join(f"{key}={value!r}" for key, value in case.items()),
        title=f"run_batch {name.rpartition('.')[2]}, {len(rows)} cases",
        job=lambda: {"build": name, "cases": rows, "jsbsim": jsbsim.__version__},
        jobs=jobs,
        resume=resume,
        progress=progress,
    )
    return pd.DataFrame([{**row, **result} for row, result in zip(rows, found, strict=True)])


def _seeded(rows: list[dict[str, Any]], seed: int) -> list[dict[str, Any]]:
    drawn = [
        int(child.generate_state(1)[0]) for child in np.random.SeedSequence(seed).spawn(len(rows))
    ]
    given = [
        whole(f"cases point {i}: seed", row.get("seed", drawn[i]), low=0)
        for i, row in enumerate(rows)
    ]
    return [{**row, "seed": given[i]} for i, row in enumerate(rows)]


def _check(build: Any, rows: list[dict[str, Any]]) -> bool:
    """Refuse what a worker cannot run; return whether ``build`` takes the seed."""
    import joblib

    if not callable(build):
        raise ParameterError(
            f"build must be a function, not {build!r}", parameter="build", value=build
        )
    try:
        parameters = inspect.signature(build).parameters
    except ValueError:  # many built-in functions
        raise ParameterError(
            f"build must be a function with known parameters, not {build!r}",
            parameter="build",
            value=build,
        ) from None
    free = any(p.kind is p.VAR_KEYWORD for p in parameters.values())
    takes_seed = free or "seed" in parameters
    for i, row in enumerate(rows):
        for key in row:
            if key not in parameters and key != "seed" and not free:
                raise ParameterError(
                    f"case {i} has {key!r}, which build does not take"
                    + did_you_mean(nearest(key, parameters)),
                    parameter=key,
                    value=row[key],
                )
        for key, p in parameters.items():
            needed = p.default is p.empty and p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)
            if needed and key not in row:
                raise ParameterError(
                    f"case {i} has no {key!r}, which build needs", parameter=key, value=None
                )
    try:
        pickle.dumps(joblib.wrap_non_picklable_objects(build))
    except Exception as error:
        raise ParameterError(
            f"build cannot be sent to other processes: {error}; create everything it needs inside "
            "it",
            parameter="build",
            value=build,
        ) from error
    return takes_seed


def _run_cases(
    build: Callable[..., Mapping[str, Any]], takes_seed: bool, cases: list[dict[str, Any]]
) -> list[dict[str, Any]]:
    return [_run_case(build, takes_seed, case) for case in cases]


def _run_case(
    build: Callable[..., Mapping[str, Any]], takes_seed: bool, case: dict[str, Any]
) -> dict[str, Any]:
    arguments = case if takes_seed else {k: v for k, v in case.items() if k != "seed"}
    # for blocks that draw from the global generators, PathSim's among them
    before = random.getstate(), np.random.get_state()  # noqa: NPY002
    random.seed(case["seed"])
    np.random.seed(case["seed"] % 2**32)  # noqa: NPY002
    try:
        return {"completed": True, "reason": "", **_measured(build(**arguments), case)}
    except Exception as error:
        log.info("case %s failed", case, exc_info=True)
        return {"completed": False, "reason": f"{type(error).__name__}: {error}"}
    finally:
        random.setstate(before[0])
        np.random.set_state(before[1])  # noqa: NPY002


def _measured(result: Any, case: dict[str, Any]) -> dict[str, Any]:
    if not isinstance(result, Mapping):
        raise ParameterError(
            f"build must return a dict of what it measured, not {result!r}",
            parameter="build",
            value=result,
        )
    for key in result:
        if key in (*case, "completed", "reason"):
            raise ParameterError(
                f"build returned {key!r}, which is a column of the cases",
                parameter="build",
                value=key,
            )
    return {str(key): _value(str(key), value) for key, value in result.items()}


def _value(key: str, value: Any) -> Any:
    if isinstance(value, (float, np.floating)):
        return float(value)  # NaN passes: "not measured" is a result
    # as a resumed batch would read it from its file
    return json.loads(json.dumps(plain(key, value)))
