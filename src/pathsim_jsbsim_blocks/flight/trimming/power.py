"""Engines without thrust: whether they have fuel, and why they do not run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...errors import TrimError
from ..airframe import Airframe
from ..model_xml import Engine
from .condition import TrimCondition
from .equations import Effort, SteadyFlight
from .failure import failure
from .initial import initialise

# s of held flight, in which a model's pumps fill the tanks of its engines (Short_S23: 0.1)
_FILLING = 2.0

# psf at sea level; the mixture of best power there, of JSBSim's range from no fuel to full rich
_SEA_LEVEL = 2116.22
_BEST_POWER = 0.85


def fill(airframe: Airframe) -> list[Engine]:
    """Engines without fuel after the model's own fuel system has had time to supply it.

    Meanwhile frozen fuel keeps the engines and their pumps running.
    """
    if not airframe.without_fuel():
        return []
    with airframe.held():
        for _ in range(round(_FILLING / airframe.dt)):
            airframe.fdm.run()
            if not airframe.without_fuel():
                break
    return airframe.without_fuel()


def no_fuel(
    airframe: Airframe,
    condition: TrimCondition,
    engines: Sequence[Engine],
    residuals: Mapping[str, float] | None = None,
) -> TrimError:
    """The error of engines that get no fuel: empty tanks, or tanks that the model has shut."""
    fdm, shut, empty = airframe.fdm, dict[str, float](), dict[str, float]()
    for path in (f"propulsion/tank[{i}]" for engine in engines for i in engine.tanks):
        if not fdm[f"{path}/priority"]:
            shut[f"{path}/priority"] = 0.0
        else:
            empty[f"{path}/contents-lbs"] = fdm[f"{path}/contents-lbs"]
    numbers = ", ".join(str(engine.number) for engine in engines)
    why = f"no fuel for engine{'s' * (len(engines) > 1)} {numbers}: "
    why += ", ".join(f"{name} = {x:.3g}" for name, x in {**shut, **empty}.items())
    why += " (shut by the model or the setup: open its valves)" if shut else ""
    # only tanks that feed no engine can be behind a closed valve
    fed = {tank for engine in airframe.engine_list for tank in engine.tanks}
    others = [name for i, name in enumerate(airframe.tanks) if i not in fed and fdm[name] > 0.0]
    if others:
        why += f"; {', '.join(others)} hold fuel that the model's own fuel system does not pass on"
    why += "; fuel=[...] of the condition fills tanks" if empty and not others else ""
    reason = "fuel valve" if shut or others else "fuel"
    return failure(
        airframe,
        condition,
        reason,
        why,
        residuals,
        engines=[engine.number for engine in engines],
        properties={**shut, **empty},
    )


def not_running(
    airframe: Airframe,
    condition: TrimCondition,
    flight: SteadyFlight,
    residuals: Mapping[str, float],
) -> TrimError:
    """The error of engines that do not run; it names a mixture with which they would."""
    still = airframe.not_running()
    numbers = ", ".join(map(str, still))
    engines = f"engine{'s' * (len(still) > 1)} {numbers}"
    pistons = [e.number for e in airframe.engine_list if e.type == "piston" and e.number in still]
    mixture = min(_BEST_POWER * airframe.fdm["atmosphere/P-psf"] / _SEA_LEVEL, 1.0)
    better = {f"fcs/mixture-cmd-norm[{i}]": round(mixture, 2) for i in pistons}
    if better and _runs(airframe, condition, flight, better):
        now = airframe.fdm[next(iter(better))]
        what = "rich" if now > mixture else "lean"
        why = f"{engines} stopped: the mixture, {now:.3g}, is too {what}; it runs with "
        why += f"setup={better}"
        return failure(
            airframe, condition, "mixture", why, residuals, engines=still, properties=better
        )
    why = f"{engines} had fuel and did not run"
    if pistons:
        why += ", neither by JSBSim's start nor by starter and ignition, with a leaner mixture too"
    return failure(airframe, condition, "engine", why, residuals, engines=still)


def _runs(
    airframe: Airframe, condition: TrimCondition, flight: SteadyFlight, setup: Mapping[str, float]
) -> bool:
    """Whether the engines of another aircraft at the condition run with other properties."""
    other = airframe.twin()
    other.resemble(airframe)
    other.write(setup)
    with other.fuel_frozen(), other.engines_stopped():
        initialise(other, condition, condition.heading)
        trial = SteadyFlight(other, condition, Effort(), flight.in_time)
        trial.settled(trial.guess(3.0, 0.9))
    return not other.not_running()
