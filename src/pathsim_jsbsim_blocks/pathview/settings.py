"""Simulation settings of a script: its own expressions where given, live values otherwise."""

from __future__ import annotations

import ast
import inspect

import pathsim.solvers
from pathsim import Simulation

from ..scripts.first_run import FirstRun, named_arguments

_SETTINGS = {
    "dt": "dt",
    "dt_min": "dt_min",
    "dt_max": "dt_max",
    "tolerance_lte_rel": "rtol",
    "tolerance_lte_abs": "atol",
    "tolerance_fpi": "ftol",
}


def setting_expressions(script: FirstRun) -> dict[str, ast.expr]:
    """Settings that a script writes itself, by PathView's names."""
    found: dict[str, ast.expr] = {}
    made = script.construction(script.simulation)
    if made and made.given is not None:
        given = named_arguments(made.node, list(inspect.signature(Simulation).parameters))
        found = {
            ours: given[theirs]
            for theirs, ours in _SETTINGS.items()
            if theirs in given and ast.unparse(given[theirs]) != "None"
        }
    given = script.run_arguments()
    if "duration" in given:
        found["duration"] = given["duration"]
    elif script.begun is None and "DURATION" in script.namespace:
        names = (n for n in ast.walk(script.tree) if isinstance(n, ast.Name))
        place = next((n for n in names if n.id == "DURATION"), None)
        if place is not None:
            found["duration"] = ast.copy_location(ast.Name("DURATION", ast.Load()), place)
    stays = script.begun is not None and script.begun.arguments.get("adaptive") is False
    if stays and script.simulation.engine.is_adaptive:
        script.refuse(
            "run(adaptive=False) with an adaptive solver; PathView always adapts the step",
            script.run_call,
        )
    return found


def setting_values(script: FirstRun) -> dict[str, str]:
    """All settings from the live simulation: PathView's defaults differ from PathSim's."""
    sim, kwargs = script.simulation, script.simulation.solver_kwargs
    solver: type = sim.Solver
    name, reason = solver.__name__, ""
    if sim.iterations_max != inspect.signature(Simulation).parameters["iterations_max"].default:
        reason = "PathView cannot represent iterations_max"
    elif unknown := sorted(set(kwargs) - _SETTINGS.keys()):
        reason = f"PathView cannot represent the solver's {', '.join(unknown)}"
    elif getattr(pathsim.solvers, name, None) is not solver:
        reason = f"solver {name!r} is not one of pathsim.solvers"
    if reason:
        script.refuse(reason, script.built_at(sim))
    constant, defaults = script.namespace.get("DURATION"), solver()
    duration = script.begun.arguments.get("duration") if script.begun else constant
    if duration is None:
        duration = inspect.signature(sim.run).parameters["duration"].default
    live = {
        "duration": duration,
        "dt": sim.dt,
        "dt_min": sim.dt_min,
        "dt_max": sim.dt_max,
        "rtol": kwargs.get("tolerance_lte_rel", defaults.tolerance_lte_rel),
        "atol": kwargs.get("tolerance_lte_abs", defaults.tolerance_lte_abs),
        "ftol": sim.tolerance_fpi,
    }
    return {"solver": name, **{k: "" if v is None else repr(float(v)) for k, v in live.items()}}
