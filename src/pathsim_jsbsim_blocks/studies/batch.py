"""Batches of whole diagrams: Monte-Carlo runs and parameter studies."""

from __future__ import annotations

import copy
import inspect
import json
import logging
import pickle
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.checks import did_you_mean, integer, must_be, nearest, positive, refuse
from .._core.extras import required
from ..catalogue import find_diagram
from .grid import cell, encodable, expand, plain
from .journal import of_function
from .workers import WORKER_DIED, run_parts

if TYPE_CHECKING:
    import pandas as pd

    from .._seeding import Seeding

log = logging.getLogger(__name__)

_OWN = ("completed", "reason")  # columns that the table adds to those of the cases


def run_batch(
    build: Callable[..., Mapping[str, Any]] | str | Path,
    cases: Any,
    *,
    measure: Callable[[Any], Mapping[str, Any]] | None = None,
    duration: float | None = None,
    seed: int = 0,
    jobs: int = -1,
    resume: str | Path | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Build, run and measure a diagram for every case.

    Each case is computed independently, from its own seed, so that the table does not depend on the
    number of workers.

    Parameters
    ----------
    build : callable, str or Path
        the name of a diagram in the catalogue, or the path of a script: each case names its blocks
        and constants, ``{"hold.theta_ref": [2, 3, 4]}``, as for ``load_diagram``. The script is
        imported, its ``sim`` flown and ``measure`` called. Every block with random numbers, such
        as turbulence, sensors and PathSim's noise sources, gets its own seed from that of the case;
        a seed written in the script has no effect.
        Or a function, called as ``build(**case)``, which builds the diagram, runs it, and returns
        its measurements as a dict of numbers or texts. A parameter ``seed`` receives the case's
        seed; the generators of `random` and ``numpy.random`` are always seeded with it, and any
        other is made from it. It is sent to other processes, so it must not refer to outside
        objects such as an aircraft; variables of its module have the values of the import
    cases : dict, DataFrame or list of dicts
        the parameters of each case; a dict of lists means their product, the last one fastest; the
        progress bar shows the number: ``60 x 60 = 3,600 cases``. For pairs pass a list of dicts. A
        column ``seed`` replaces the seeds drawn, and one such as ``"turbulence.seed"``, or a
        variable that the script passes as ``seed=``, the seed of that block
    measure : callable, optional
        required for a script: called after the flight with the script's module, it returns the
        measurements: ``lambda m: {"pitch": m.pitch.read()[1][0, -1]}``. It is sent to other
        processes too
    duration : float, optional
        for a script: simulated time in s; default is its ``DURATION``
    seed : int
        seed of the batch; the seed of each case is drawn from it and the case's position
    jobs : int
        worker processes, at most 1024, -1 for all cores; 1 stays in this process, for debugging.
        Under ``joblib.parallel_config("dask")`` the cluster's workers are used instead
    resume : Path, optional
        file that keeps finished cases: repeating a killed call with the same file resumes it. It is
        refused, with the difference, for other cases, arguments of a `functools.partial`, versions
        of this package, PathSim, JSBSim and Python, ``.py`` files below the top package of the
        function or the folder of the script, and XML files below a JSBSim root among the arguments.
        Functions must belong to a module or script. Other data are not compared, nor are variables
        of modules
    progress : bool
        show a progress bar on stderr

    Returns
    -------
    pandas.DataFrame
        one row for each case, in their order: its parameters, ``seed`` if random numbers were drawn
        from it or the cases set it, ``completed``, ``reason``
        (empty, or the error that ended the case: no trim, a flight that cannot continue, "worker
        died") and the measurements, NaN if there are none. Lists and dicts remain lists and dicts
        in Parquet and become JSON text in CSV

    Raises
    ------
    KeyboardInterrupt
        on Ctrl-C, with the number of cases done and the file to resume with
    ParameterError
        before the work begins: no cases, a column ``completed`` or ``reason`` in them, bytes, a
        case that ``build`` does not accept (for a script: a block, parameter or constant that it
        does not have, naming the nearest), NaN, a ``build`` that cannot be sent to other processes,
        a joblib backend other than loky and Dask, a file that cannot be written or belongs to
        another batch; with ``resume`` also a function
        that is not defined in a file, and more than 2,000 files. Later: a case that draws from a
        generator which outlives it, such as one of the function's module
    """
    pd = required("pandas", "studies")

    points, count = expand("cases", cases)
    for key in _OWN:
        if any(key in row for row in points):
            refuse(key, cases, f"the cases have a column {key!r}, which is one of the table's own")
    rows = _seeded(points, integer("seed", seed, low=0))
    if isinstance(build, (str, Path)):
        script = find_diagram(str(build)).absolute()
        roots = _check_script(script, rows, measure, duration)
        name, run = script.stem, partial(_fly_script, script, measure, duration)
    else:
        for option, value in (("measure", measure), ("duration", duration)):
            if value is not None:
                why = f"{option} is only for a script: a function build must do this itself"
                refuse(option, value, why)
        name, run = _name(build), partial(_call, build, _check(build, rows))

    def job() -> dict[str, Any]:
        values = dict.fromkeys(x for row in rows for x in row.values() if isinstance(x, str))
        if measure is None:
            return {"cases": rows, **of_function("build", build, (), values)}
        parts = of_function("measure", measure, [script.parent], [*values, *roots])
        return {"cases": rows, "build": script.name, "duration": duration, **parts}

    results = run_parts(
        partial(_run_cases, run, measure or build),
        [[row] for row in rows],
        death={"completed": False, "reason": WORKER_DIED},
        describe=lambda case: ", ".join(f"{key}={value!r}" for key, value in case.items()),
        title=f"run_batch {name}, {count} cases",
        job=job,
        jobs=jobs,
        resume=resume,
        progress=progress,
    )
    if not any("seed" in row for row in [*points, *results]):
        rows = points
    both = ({**row, **result} for row, result in zip(rows, results, strict=True))
    return pd.DataFrame([{key: cell(value) for key, value in row.items()} for row in both])


def _call(
    build: Callable[..., Any], takes_seed: bool, seeding: Seeding, case: dict[str, Any]
) -> Any:
    seeding.used = takes_seed
    return build(**(case if takes_seed else _without_seed(case)))


def _without_seed(case: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in case.items() if key != "seed"}


def _fly_script(
    script: Path, measure: Any, duration: float | None, seeding: Seeding, case: dict[str, Any]
) -> Any:
    from .._core.running import fly
    from ..scripts.script import Script

    diagram = Script(script, _without_seed(case))
    with seeding.alone():
        module = diagram.load()
    seeding.seed_blocks(module.sim, diagram.seeded)
    fly(module.sim, module.DURATION if duration is None else duration, progress=False)
    return measure(module)


def _check_script(
    script: Path, rows: list[dict[str, Any]], measure: Any, duration: Any
) -> set[Any]:
    """Refuse a script that cannot be flown and cases without effect on it.

    Returns the JSBSim roots of its aircraft.
    """
    from pathsim import Simulation

    from .._core.wiring import contents
    from .._seeding import Seeding
    from ..scripts.script import Script
    from ..scripts.settings import SettingError

    if not callable(measure):
        must_be("measure", measure, "a function of the script's module")
    _check_sent("measure", measure)
    if duration is not None:
        positive("duration", duration)
    roots = set()
    for names in {tuple(row) for row in rows}:
        row = next(r for r in rows if tuple(r) == names)
        try:
            with Seeding(row["seed"]):
                module = Script(script, _without_seed(row)).load()
        except SettingError:
            raise
        except (Exception, SystemExit):
            continue  # an impossible value ends only its own case
        why = ""
        if not isinstance(getattr(module, "sim", None), Simulation):
            why = "builds no Simulation named sim when it is imported"
        elif module.sim.time:
            why = 'runs when it is imported: move the run below if __name__ == "__main__":'
        if why:
            refuse("build", str(script), f"{script.name} {why}")
        if duration is None and not hasattr(module, "DURATION"):
            refuse("duration", None, f"{script.name} has no DURATION: give duration=...")
        aircraft = (getattr(block, "airframe", None) for block in contents(module.sim)[0])
        roots |= {airframe.root for airframe in aircraft if airframe is not None}
    return roots


def _seeded(rows: list[dict[str, Any]], seed: int) -> list[dict[str, Any]]:
    cases = []
    for i, child in enumerate(np.random.SeedSequence(seed).spawn(len(rows))):
        number = rows[i].get("seed", int(child.generate_state(1)[0]))
        cases.append({**rows[i], "seed": integer(f"cases point {i}: seed", number, low=0)})
    return cases


def _check(build: Any, rows: list[dict[str, Any]]) -> bool:
    """Refuse cases that ``build`` does not accept; return whether it takes the seed."""
    if not callable(build):
        must_be("build", build, "a function")
    try:
        signature = inspect.signature(build)
    except ValueError:  # many built-in functions
        must_be("build", build, "a function with known parameters")
    parameters = signature.parameters
    free = any(p.kind is p.VAR_KEYWORD for p in parameters.values())
    takes_seed = free or "seed" in parameters
    for i, row in enumerate(rows):
        arguments = row if takes_seed else _without_seed(row)
        for key in [] if free else [key for key in arguments if key not in parameters]:
            close = did_you_mean(nearest(key, parameters))
            refuse(key, row[key], f"case {i} has {key!r}, which build does not take{close}")
        try:
            signature.bind(**arguments)
        except TypeError as error:
            refuse("cases", row, f"case {i} does not fit build: {error}")
    _check_sent("build", build)
    return takes_seed


def _check_sent(parameter: str, function: Any) -> None:
    """Refuse a function that cannot be sent to other processes."""
    joblib = required("joblib", "studies")

    try:
        pickle.dumps(joblib.wrap_non_picklable_objects(function))
    except Exception as error:
        why = f"cannot be sent to other processes: {error}; create everything it needs inside it"
        refuse(parameter, function, f"{parameter} {why}")


def _run_cases(
    run: Callable[..., Any], function: Any, cases: list[dict[str, Any]]
) -> list[dict[str, Any]]:
    return [_run_case(run, function, case) for case in cases]


def _name(function: Any) -> str:
    return getattr(getattr(function, "func", function), "__name__", type(function).__name__)


def _run_case(run: Callable[..., Any], function: Any, case: dict[str, Any]) -> dict[str, Any]:
    from .._seeding import Seeding, outside_generators

    generators = {x: (r, pickle.dumps(r)) for x, r in outside_generators(function).items()}
    with Seeding(case["seed"]) as seeding:
        try:
            row = {
                "completed": True,
                "reason": "",
                **_measured(run(seeding, copy.deepcopy(case)), case),
            }
        except (Exception, SystemExit) as error:
            log.info("case %s failed", case, exc_info=True)
            reason = f"{type(error).__name__}: {error}".encode(errors="backslashreplace").decode()
            row = {"completed": False, "reason": reason}
    for name, (generator, bytes_at_start) in generators.items():
        if pickle.dumps(generator) != bytes_at_start:
            why = f"draws from {name!r}, which the cases of a worker share; use the case's own, "
            refuse("build", name, f"{_name(function)} {why}numpy.random.default_rng(seed)")
    return {"seed": case["seed"], **row} if seeding.used else row


def _measured(result: Any, case: dict[str, Any]) -> dict[str, Any]:
    if not isinstance(result, Mapping):
        refuse("build", result, f"build must return a dict of measurements, not {result!r}")
    row = {encodable("build", str(key)): value for key, value in result.items()}
    for key in row:
        if key in (*case, *_OWN):
            refuse("build", key, f"build returned {key!r}, which is a column of the cases")
    return {key: _value(key, value) for key, value in row.items()}


def _value(key: str, value: Any) -> Any:
    if isinstance(value, (float, np.floating)):
        return float(value)  # NaN passes: "not measured" is a result
    # through JSON, so that a resumed batch gives the same table
    return json.loads(json.dumps(plain(key, value)))
