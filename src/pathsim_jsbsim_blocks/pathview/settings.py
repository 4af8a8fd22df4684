"""Simulation settings of a script: live values, and the script's own expressions for them."""

from __future__ import annotations

import ast
import inspect
from typing import Any

from pathsim import Simulation, Subsystem

from .first_run import FirstRun, named_arguments

_PARAMETERS = {
    "dt": "dt",
    "dt_min": "dt_min",
    "dt_max": "dt_max",
    "rtol": "tolerance_lte_rel",
    "atol": "tolerance_lte_abs",
    "ftol": "tolerance_fpi",
}
_STRUCTURE = ("blocks", "connections", "events")


def fieldless(script: FirstRun, part: Simulation | Subsystem, *fields: str) -> None:
    """Refuse a part with a parameter that has no field in PathView and not its default."""
    kind = Simulation if isinstance(part, Simulation) else Subsystem
    for name, parameter in inspect.signature(kind).parameters.items():
        value = getattr(part, name, parameter.default)
        if name not in (*_STRUCTURE, *fields) and value != parameter.default:
            why = f"{name} = {value!r}, for which PathView has no field; only the default"
            why = f"{script.called(part)} has {why} {parameter.default!r} can be in a model"
            script.refuse(why, script.built_at(part))


def live_settings(script: FirstRun) -> dict[str, tuple[Any, ast.expr | None]]:
    """Numbers of the live simulation by PathView's names, with the script's expressions if any.

    PathView's defaults differ from PathSim's.
    """
    sim, run = script.simulation, script.run_start
    # a recorder of diagnostics changes no flight
    fieldless(script, sim, *_PARAMETERS.values(), "Solver", "solver_kwargs", "log", "diagnostics")
    construction = script.construction(sim)
    arguments = run.arguments if run else {"duration": script.namespace.get("DURATION")}
    if sim.engine.is_adaptive and arguments.get("adaptive") is False:
        script.refuse(
            "run(adaptive=False) with an adaptive solver; PathView always adapts the step",
            script.run_call,
        )
    nodes: dict[str, ast.expr] = {}
    if construction and construction.arguments is not None:
        nodes = named_arguments(construction.node, list(inspect.signature(Simulation).parameters))
    nodes |= script.run_arguments()
    for name in ast.walk(script.tree) if run is None else ():
        if isinstance(name, ast.Name) and name.id == "DURATION":
            nodes["duration"] = ast.copy_location(ast.Name(name.id, ast.Load()), name)
    duration = arguments.get("duration")
    if duration is None:
        duration = inspect.signature(sim.run).parameters["duration"].default
    live = {ours: getattr(sim, theirs, None) for ours, theirs in _PARAMETERS.items()}
    defaults = sim.Solver()
    for ours in ("rtol", "atol"):
        theirs = _PARAMETERS[ours]
        live[ours] = sim.solver_kwargs.get(theirs, getattr(defaults, theirs))
    return {
        "duration": (duration, nodes.get("duration")),
        **{ours: (live[ours], nodes.get(theirs)) for ours, theirs in _PARAMETERS.items()},
    }
