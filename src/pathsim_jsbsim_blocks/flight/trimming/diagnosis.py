"""Why the end of a search is no trim: a search only reports what it reached."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...errors import TrimError
from ..airframe import Airframe
from ..model_xml import Engine
from ..settling import MOST_SUBSTEPS
from .check import HandsOff
from .condition import TrimCondition
from .effects import COMMANDS, NONE, Effect, effects
from .equations import RESIDUALS, Effort, SteadyFlight, size
from .failure import failure
from .initial import initialise
from .state import TrimState, not_finite

# psf at sea level; the mixture of best power there, of JSBSim's range from no fuel to full rich
_SEA_LEVEL = 2116.22
_BEST_POWER = 0.85

# reason of the error by the unknown at its limit, in order of priority: slow flight first needs too
# much alpha, and then more thrust and elevator than available
_LIMITS = {
    "alpha": "alpha limit",
    "throttle": "thrust",
    "gamma": "path angle",
    "speed": "speed",
    "pitch_trim": "elevator",
    "elevator": "elevator",
    "phi": "bank",
    "beta": "sideslip",
    "rate": "rate of turn",
    "aileron": "aileron",
    "rudder": "rudder",
}
# unknown of a command -> its primary acceleration
_ACCELERATIONS = {name: acceleration for names, acceleration in COMMANDS.values() for name in names}
_ANGLES = ("alpha", "phi", "beta", "gamma", "rate")

# residuals, in tolerances, with which the end of a search is a trim if a flight from it stays
_CLOSE = 10.0


class Ending(NamedTuple):
    """The end of a search: unknowns, residuals in tolerances and in their units, the state.

    ``light`` is a propeller that flown steps cannot follow, with the substeps that can; ``flown``
    the flight from there, of ``other``, if it was worth flying.
    """

    flight: SteadyFlight
    x: np.ndarray
    r: np.ndarray
    residuals: dict[str, float]
    state: TrimState
    light: tuple[int, int] | None
    touches: bool
    flown: HandsOff | None = None
    other: Airframe | None = None

    @property
    def converged(self) -> bool:
        return size(self.r) <= 1.0

    @property
    def excess(self) -> dict[str, float]:
        """Residuals above their tolerances."""
        balanced = {name: x for name, x in self.residuals.items() if name in self.flight.used}
        return {name: x for name, x in balanced.items() if abs(x) > RESIDUALS[name]}

    def worth_flying(self, airframe: Airframe) -> bool:
        """Whether the state may be a trim, as far as can be told without a flight."""
        runs = self.state.condition.mode == "glide" or not airframe.not_running()
        return (
            size(self.r) <= _CLOSE
            and runs
            and not (self.light or self.touches)
            and not not_finite(self.state)
        )

    def holds(self, airframe: Airframe) -> bool:
        """Whether the state is a trim."""
        starved = self.flown and self.flown.starved and self.state.condition.mode != "glide"
        moves = self.flown and self.flown.moves
        stays = self.converged or bool(self.flown and not self.flown.leaves)
        return self.worth_flying(airframe) and stays and not starved and not moves


def diagnose(airframe: Airframe, ending: Ending) -> TrimError:
    """The cause for which the end of a search is no trim, the first of these that was shown."""
    causes = _contact, _kind, _commands, _starved, _stopped, _light, _moves, _not_finite, _limit
    return next(error for cause in causes if (error := cause(airframe, ending)))


def _error(
    airframe: Airframe, ending: Ending, reason: str, why: str = "", **data: Any
) -> TrimError:
    return failure(airframe, ending.state.condition, reason, why, ending.residuals, **data)


def _contact(airframe: Airframe, ending: Ending) -> TrimError | None:
    if not ending.touches:
        return None
    why = "a wheel or another contact point touches the ground"
    return _error(airframe, ending, "ground", why)


def _kind(airframe: Airframe, ending: Ending) -> TrimError | None:
    """The error of a model that the search does not trim."""
    if ending.converged:
        return None
    if airframe.has_kind("rotor"):
        why = "it is a rotorcraft (its thruster is a rotor), which this search does not trim"
        return _error(airframe, ending, "rotorcraft", why)
    if not any(airframe.fdm[f"forces/fb{axis}-aero-lbs"] for axis in "xyz"):
        why = "the model has no aerodynamic force"
        return _error(airframe, ending, "aerodynamics", why)
    return None


def _commands(airframe: Airframe, ending: Ending) -> TrimError | None:
    """The error of a search that failed because commands act on nothing; it names all of them.

    A command is the cause if the residual of its acceleration remains, and the unknown at its limit
    is its own or none, or no residual is larger.
    """
    if ending.converged:
        return None
    flight, (bound, _) = ending.flight, _bound(ending)
    remains = dict(zip(flight.used, abs(ending.r).tolist(), strict=True))
    # the throttle of a stopped engine is not the cause
    idle = airframe.not_running()
    suspects = [
        command
        for command, (unknowns, acceleration) in COMMANDS.items()
        if not (r := remains.get(acceleration, 0.0)) <= 1.0  # NaN remains
        and (bound in ("", *unknowns) or r == max(remains.values()))
        and not (command == "throttle" and idle)
    ]
    if not any(not effect.moves for effect in effects(flight, ending.x, airframe, suspects)):
        return None
    dead = [
        effect
        for effect in effects(flight, ending.x, airframe)
        if not effect.moves and not (effect.command == "throttle" and idle)
    ]
    dead.sort(key=lambda effect: effect.command not in suspects)
    if not dead:
        return None
    why = "; ".join(_without_effect(airframe, effect) for effect in dead)
    if len(dead) > 1:
        why += "; start it with mode='none' and close the loop over the model's own commands"
    elif dead[0].command in ("roll", "yaw") and not dead[0].written_by_model:
        why += " (mode='longitudinal' leaves roll and yaw out)"
    return _error(
        airframe,
        ending,
        "no effect",
        why,
        command=dead[0].command,
        commands=[effect.command for effect in dead],
        properties={name: airframe.fdm[name] for effect in dead for name in effect.properties},
    )


def _without_effect(airframe: Airframe, effect: Effect) -> str:
    names = " to ".join(dict.fromkeys((effect.properties[0], effect.properties[-1])))
    why = f"the {effect.command} command, {names}, does not change {effect.acceleration}"
    command = effect.properties[0].partition("[")[0]
    sources = airframe.sources(command)
    if not sources and effect.command == "throttle":
        sources = airframe.sources(command.replace("-cmd-", "-pos-"))
        sources = () if command in sources else sources
    if effect.written_by_model or sources:
        writers = [name for name in sources if effect.command in name]
        why += ": the model writes it itself"
        why += f", from {', '.join(writers)}" if writers else ""
    elif effect.command == "throttle" and airframe.has_kind("rocket"):
        why += ": of JSBSim's rockets, a solid one has no throttle, and a liquid one gives no "
        why += "thrust while fuel is frozen, as in a trim"
    return why


def _starved(airframe: Airframe, ending: Ending) -> TrimError | None:
    if not (ending.flown and ending.flown.starved) or ending.state.condition.mode == "glide":
        return None
    engines = [e for e in airframe.engine_list if e.number in ending.flown.starved]
    trial = ending.other or airframe
    return no_fuel(trial, ending.state.condition, engines, ending.residuals)


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
    feeders = {tank for engine in airframe.engine_list for tank in engine.tanks}
    spare = [name for i, name in enumerate(airframe.tanks) if i not in feeders and fdm[name] > 0.0]
    if spare:
        why += f"; {', '.join(spare)} hold fuel that the model's own fuel system does not pass on"
    why += "; fuel=[...] of the condition fills tanks" if empty and not spare else ""
    reason = "fuel valve" if shut or spare else "fuel"
    return failure(
        airframe,
        condition,
        reason,
        why,
        residuals,
        engines=[engine.number for engine in engines],
        properties={**shut, **empty},
    )


def _stopped(airframe: Airframe, ending: Ending) -> TrimError | None:
    """The error of engines that do not run; it names a mixture with which they would."""
    idle = airframe.not_running()
    if not idle or ending.state.condition.mode == "glide":
        return None
    engines = f"engine{'s' * (len(idle) > 1)} {', '.join(map(str, idle))}"
    pistons = [e.number for e in airframe.engine_list if e.type == "piston" and e.number in idle]
    mixture = min(_BEST_POWER * airframe.fdm["atmosphere/P-psf"] / _SEA_LEVEL, 1.0)
    better = {f"fcs/mixture-cmd-norm[{i}]": round(mixture, 2) for i in pistons}
    if better and _runs(airframe, ending, better):
        present = airframe.fdm[next(iter(better))]
        what = "rich" if present > mixture else "lean"
        why = f"{engines} stopped: the mixture, {present:.3g}, is too {what}; it runs with "
        why += f"setup={better}"
        return _error(airframe, ending, "mixture", why, engines=idle, properties=better)
    why = f"{engines} had fuel and did not run"
    if pistons:
        why += ", neither by JSBSim's start nor by starter and ignition, with a leaner mixture too"
    return _error(airframe, ending, "engine", why, engines=idle)


def _runs(airframe: Airframe, ending: Ending, setup: Mapping[str, float]) -> bool:
    """Whether the engines of another aircraft at the condition run with other properties."""
    trial_airframe, condition = airframe.twin(), ending.state.condition
    trial_airframe.resemble(airframe)
    trial_airframe.write(setup)
    with trial_airframe.fuel_frozen(), trial_airframe.engines_stopped():
        initialise(trial_airframe, condition, condition.heading)
        trial = SteadyFlight(trial_airframe, condition, Effort(), ending.flight.in_time)
        trial.settled(trial.guess(3.0, 0.9))
    return not trial_airframe.not_running()


def _light(airframe: Airframe, ending: Ending) -> TrimError | None:
    """The error of a propeller that flown steps cannot follow."""
    if ending.light is None:
        return None
    engine, factor = ending.light
    why = f"the propeller of engine {engine} is too light for steps of 1/{1 / airframe.dt:.6g} s, "
    why += "in which its speed does not settle: "
    if factor > MOST_SUBSTEPS:
        why += "give it its moment of inertia, ixx"
    else:
        steps = f"steps of 1/{factor / airframe.dt:.6g} s"
        why += f"use substeps={factor * airframe.substeps} ({steps})"
    return _error(airframe, ending, "propeller", why)


def _moves(airframe: Airframe, ending: Ending) -> TrimError | None:
    if not (ending.flown and ending.flown.moves):
        return None
    return _error(airframe, ending, "no equilibrium", ending.flown.moves)


def _not_finite(airframe: Airframe, ending: Ending) -> TrimError | None:
    if not ending.converged or not (names := not_finite(ending.state)):
        return None
    return _error(
        airframe, ending, "no convergence", f"{', '.join(names)} not finite after the trim"
    )


def _limit(airframe: Airframe, ending: Ending) -> TrimError:
    """The error of the limit at which the search ended, or of none."""
    flight = ending.flight
    name, limit = _bound(ending)
    if not name:
        name, limit = _insufficient(ending)
    if name in _ANGLES:
        limit = math.degrees(limit)  # type: ignore[arg-type]
    reason = _LIMITS.get(name, "no convergence" if flight.propellers.steady else "propeller")
    return _error(airframe, ending, reason, limit=limit)


def _bound(ending: Ending) -> tuple[str, float | None]:
    """The unknown whose limit stops the search, and the limit; empty and None without one."""
    flight, x, r = ending.flight, ending.x, ending.r
    name = _binding(ending)
    if not name and "throttle" in flight.names:
        x_end = with_throttle_at_end(flight, x, r)
        i = flight.names.index("throttle")
        at_end = x[i] in (flight.low[i], flight.high[i]) or abs(r[0]) == abs(r).max()
        # even the whole range would not be enough
        if at_end and flight.settled(x_end)[0] * r[0] > 0.0:
            name, x = "throttle", x_end
    return name, float(x[flight.names.index(name)]) if name else None


def _insufficient(ending: Ending) -> tuple[str, float | None]:
    """The command that leaves the largest residual at both ends of its range, and the better end.

    The search may end before the end of a range where the model limits the command to a part of it.
    """
    largest = ending.flight.used[int(abs(ending.r).argmax())]
    for name in ending.flight.names:
        if _ACCELERATIONS.get(name) == largest:
            ends = _at_ends(ending, name)
            if min(ends.values()) > 0.0 and max(ends.values()) - min(ends.values()) > NONE:
                return name, min(ends, key=ends.__getitem__)
    return "", None


def _at_ends(ending: Ending, name: str) -> dict[float, float]:
    """Residual of a command's acceleration at the ends of its range; the present is positive."""
    flight, residuals = ending.flight, dict[float, float]()
    i, row = flight.names.index(name), flight.used.index(_ACCELERATIONS[name])
    for limit in (float(flight.low[i]), float(flight.high[i])):
        y = ending.x.copy()
        y[i] = limit
        residuals[limit] = float(flight.settled(y)[row] * np.sign(ending.r[row]))
    return residuals


def _binding(ending: Ending) -> str:
    """The unknown at a limit that stops the search; empty if none does."""
    flight, x, r = ending.flight, ending.x, ending.r
    more = {"alpha": r[flight.used.index("wdot")] > 0.0}
    if ending.state.condition.thrust is None:
        more["throttle"] = r[0] < 0.0
    ends = zip(flight.names, x <= flight.low, x >= flight.high, strict=True)
    # only limits in the direction that would help, not where a search is merely stuck: the other
    # end of the range would reverse the residual
    names = [n for n, low, high in ends if (low or high) and more.get(n, high) == high]
    return min((n for n in names if not _reverses(ending, n)), key=[*_LIMITS].index, default="")


def _reverses(ending: Ending, name: str) -> bool:
    """Whether one end of a command's range reverses the residual of its acceleration."""
    if name == "throttle" or (acceleration := _ACCELERATIONS.get(name)) not in ending.flight.used:
        return False
    remains = abs(ending.r[ending.flight.used.index(acceleration)]) > 1.0
    return bool(remains and min(_at_ends(ending, name).values()) < 0.0)


def with_throttle_at_end(flight: SteadyFlight, x: np.ndarray, r: np.ndarray) -> np.ndarray:
    """The unknowns with the throttle at the limit that reduces the residual along the path."""
    i, x = flight.names.index("throttle"), x.copy()
    x[i] = (flight.low if r[0] > 0.0 else flight.high)[i]
    return x
