"""The first look at a model: its parts, whether it flies, and how to deal with its faults."""

from __future__ import annotations

import textwrap
import warnings
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .._core.checks import integer, mapping
from ..errors import BlocksError, ParameterError, PropertyError, TrimError
from ..flight import Airframe, TrimCondition, TrimState, has_retractable_gear
from ..flight.fleet import GLIDES, TRIES, first_trim, prepared
from ..flight.model_files import ModelFile
from ..flight.model_xml import Engine
from ..flight.trimming.effects import NONE, Effect, responses
from ..flight.trimming.equations import RESIDUALS
from ..flight.trimming.state import UNITS

if TYPE_CHECKING:
    from ..linear import LinearModel, Mode

# the next step, by the subject of a fault or the reason of a failed trim
_ADVICE = {
    "model": "correct the file; logger pathsim_jsbsim_blocks.jsbsim has all of JSBSim's messages",
    "properties": "pass their values, --create PROPERTY=VALUE (create={...})",
    "fuel": "fill the tanks: --set PROPERTY=LB (setup), or fuel=[...] of the condition",
    "fuel valve": "find the model's cocks, pathsim-jsbsim properties, and open them: --set (setup)",
    "commands": "see what moves the surfaces, pathsim-jsbsim properties NAME fcs, and command that",
    "signs": "negate them in the model's XML: gains and holds assume the signs of JSBSim's models",
    "no effect": "see the commands above",
    "propeller": "use the substeps or the inertia it names (--substeps), or start with mode='none'",
    "no convergence": "start it with mode='none', and see what does not come to rest",
    "mixture": "set that mixture: --set (setup)",
    "rotorcraft": "start it with mode='none', and fly it with a controller of your own",
    "aerodynamics": "start it with mode='none'",
    "trim": "try other conditions: pathsim-jsbsim trim NAME --altitude FT --speed KCAS",
    "hands off": "fly it with gains designed for it, or change its load (fuel, payload)",
    "linear model": "use the algebraic one (--method algebraic), or another airspeed",
}

# of the accelerations of positive commands
_SIGNS = {"udot": 1.0, "qdot": -1.0, "pdot": 1.0, "rdot": -1.0}

# modes that only integrate, or are not of the airframe
_OTHERS = ("altitude", "heading", "position", "engine")

# s, time to double below which an aircraft is not steady, whatever a flight shows: that of a spiral
# at level 3 of MIL-F-8785C
_DOUBLES = 4.0

# error of a flown linear model that is named
_MISFIT = 0.5


class Fault(NamedTuple):
    """A fault of a model, and the next step."""

    subject: str
    reason: str
    advice: str


@dataclass(frozen=True)
class AircraftReport:
    """The result of `aircraft_report`; its text fits on one screen.

    Attributes
    ----------
    aircraft : str
        the model's name
    faults : tuple[Fault, ...]
        each with ``subject``, ``reason`` and ``advice``, the next step. Subjects: "model" (it does
        not load), "properties", "fuel", "commands", "trim", "hands off" and "linear model"
    loads, retracts : bool
        whether it loads and initialises (if not, all else is empty), whether its gear retracts
    missing, sealed : tuple[str, ...]
        properties that it expects from outside, 0 in the rest; sockets and files, closed to it
    engines, tanks : tuple[Engine, ...], tuple[float, ...]
        ``number``, ``type``, ``thruster`` and ``tanks`` of each engine; contents in lb
    condition : TrimCondition or None
        level flight, or the glide of a glider, for the rest; tanks that were empty are half full
    effects : tuple[Effect, ...]
        of "throttle", "pitch", "roll" and "yaw": ``size``, the ``acceleration`` per 1 of the
        command (udot in ft/s2, qdot, pdot, rdot in rad/s2), and whether it ``moves`` any
    trim : TrimState or None
        with its ``drift`` after 10 s with controls fixed
    method, modes : str, tuple[Mode, ...]
        the linear model with which gains can be designed, "flown", else "algebraic", and its modes
    """

    aircraft: str
    faults: tuple[Fault, ...]
    loads: bool = False
    retracts: bool = False
    missing: tuple[str, ...] = ()
    sealed: tuple[str, ...] = ()
    engines: tuple[Engine, ...] = ()
    tanks: tuple[float, ...] = ()
    condition: TrimCondition | None = None
    effects: tuple[Effect, ...] = ()
    trim: TrimState | None = None
    method: str = ""
    modes: tuple[Mode, ...] = ()

    def __str__(self) -> str:
        lines = [f"{self.aircraft} {'loads' if self.loads else 'does not load'}"]
        for name, texts in self._rows().items() if self.loads else ():
            lines += _wrapped(f"  {name:<11}", "; ".join(texts) or "none")
        for fault in self.faults:
            lines += _wrapped(f"{fault.subject}: ", fault.reason)
            lines += _wrapped("  next: ", fault.advice)
        return "\n".join(lines)

    def _rows(self) -> dict[str, list[str]]:
        kinds = Counter(f"{engine.type}, {engine.thruster}" for engine in self.engines)
        states = [self.trim] if self.trim else []
        option = " --method algebraic" if self.method == "algebraic" else ""
        subjects = [fault.subject for fault in self.faults]
        unstable = "hands off" in subjects
        design = f"pathsim-jsbsim gains {self.aircraft}{option} designs them"
        return {
            "engines": [f"{number} {kind}" for kind, number in kinds.items()],
            "tanks": [f"{contents:.4g} lb" for contents in self.tanks],
            "gear": ["retracts" if self.retracts else "does not retract"],
            "sealed": [*self.sealed],
            "at": [f"{c.altitude:g} ft, {c.speed:g} KCAS" for c in [self.condition] if c],
            "commands": [_of_effect(effect) for effect in self.effects],
            "trim": [
                f"alpha {state.alpha:.2f} deg, path {round(state.gamma, 2) + 0.0:g} deg, "
                f"throttle {max(state.throttle, default=0.0):.2f}"
                for state in states
            ],
            "hands off": [
                f"{'not ' * (unstable and bool(state.steady))}{state.drift}" for state in states
            ],
            "modes": [_of_mode(mode) for mode in self.modes if mode.name not in _OTHERS],
            "gains": [design] if self.method and "signs" not in subjects else [],
        }


def _of_effect(effect: Effect) -> str:
    unit = "ft/s2" if effect.command == "throttle" else "rad/s2"
    size = f"{effect.acceleration} {effect.size:+.3g} {unit}"
    return f"{effect.command} {size if effect.moves else 'none'}"


def _of_mode(mode: Mode) -> str:
    stable = mode.pole.real < 0.0
    if mode.oscillatory:
        growth = "" if stable else f", doubles in {mode.time_to_double:.3g} s"
        return f"{mode.name} {mode.frequency:.3g} rad/s, damping {mode.damping:.2f}{growth}"
    time = mode.time_to_half if stable else mode.time_to_double
    return f"{mode.name} {'halves' if stable else 'doubles'} in {time:.3g} s"


def _wrapped(head: str, text: str) -> list[str]:
    indent = " " * len(head)
    # names of properties have hyphens
    return textwrap.wrap(head + text, 100, subsequent_indent=indent, break_on_hyphens=False)


def aircraft_report(
    aircraft: str,
    root: str | None = None,
    create: Mapping[str, float] | str | None = None,
    setup: Mapping[str, float] | None = None,
    substeps: int = 1,
) -> AircraftReport:
    """Report a model's parts, whether it loads, trims and stays, and its faults with next steps.

    Parameters
    ----------
    aircraft : str
        name of the model
    root : str, optional
        JSBSim root directory; default is the one shipped with jsbsim
    create : dict or "missing", optional
        as for `Airframe`; other missing properties are created as 0
    setup : dict, optional
        properties to write before each trim
    substeps : int
        JSBSim steps per 1/120 s

    Raises
    ------
    AircraftError
        if there is no such model; faults of a model are in the report
    ParameterError, PropertyError
        for impossible names and values in ``create`` and ``setup``
    """
    file, setup = ModelFile(aircraft, root), mapping("setup", setup)
    substeps = integer("substeps", substeps, low=1)
    with warnings.catch_warnings():
        # the report itself covers missing properties, nonlinearity and the extended gear
        warnings.simplefilter("ignore")
        try:
            airframe, clean = prepared(aircraft, root, create, substeps)
            for name in setup:
                airframe.writer(name)
            clean = replace(clean, setup={**clean.setup, **setup})
            model: dict[str, Any] = {"aircraft": file.aircraft, "root": root}
            model |= {"create": airframe.created, "substeps": substeps}
            tanks = tuple(map(airframe.fdm.get_property_value, airframe.tanks))
            flown = _flown(airframe, clean, model)
        except BlocksError as error:
            if (create or setup) and isinstance(error, (ParameterError, PropertyError)):
                raise
            lacking = getattr(error, "missing", ())
            return AircraftReport(file.aircraft, (_fault("model", str(error)),), missing=lacking)
    values = create if isinstance(create, Mapping) else {}
    missing = tuple(name for name in airframe.created if name not in values)
    if missing:
        texts = [f"missing: {', '.join(missing)}; 0 in this report"]
        texts += _changes_at_one(model, flown.get("condition"), missing)
        fault = _fault("properties", "; ".join(texts))
        flown["faults"] = (fault, *flown["faults"])
    return AircraftReport(
        file.aircraft,
        loads=True,
        retracts=has_retractable_gear(aircraft, root),
        missing=missing,
        sealed=file.xml.outlets,
        engines=airframe.engine_list,
        tanks=tanks,
        **flown,
    )


def _fault(subject: str, reason: str, advice: str = "") -> Fault:
    return Fault(subject, reason, _ADVICE.get(advice, _ADVICE[subject]))


def _flown(airframe: Airframe, clean: TrimCondition, model: Mapping[str, Any]) -> dict[str, Any]:
    """Condition, effects, trim, modes and faults; empty tanks that engines need are half filled."""
    mode, tries = ("full", TRIES) if airframe.engines else ("glide", GLIDES)
    try:
        flight = first_trim(airframe, clean, tries, fly=10.0, mode=mode)
    except TrimError as error:
        if error.reason == "fuel" and not error.properties.keys() & clean.setup.keys():
            half = _half_full(model, error.properties)
            report = _flown(airframe, replace(clean, setup={**clean.setup, **half}), model)
            fault = _fault("fuel", f"engines need fuel in empty tanks; in this report setup={half}")
            return {**report, "faults": (fault, *report["faults"])}
        report = _moved(model, error.condition)
        why = str(error).partition(f"{error.condition}: ")[2] or str(error)
        report["faults"] += (_fault("trim", why, error.reason),)
        return report
    except BlocksError as error:
        return {"faults": (_fault("trim", str(error)),)}
    report = {**_moved(model, flight.condition), "trim": flight.trim}
    method, modes, faults = _modes(model, flight.condition)
    causes = [] if flight.trim.steady else [str(flight.trim.drift)]
    causes += [_of_mode(mode) for mode in modes if _is_unstable(mode)]
    if causes:
        report["faults"] += (_fault("hands off", "; ".join(causes)),)
    return {**report, "method": method, "modes": modes, "faults": (*report["faults"], *faults)}


def _is_unstable(mode: Mode) -> bool:
    """Whether a motion grows so fast that the aircraft is not steady."""
    return mode.name not in _OTHERS and mode.time_to_double < _DOUBLES


def _half_full(model: Mapping[str, Any], tanks: Iterable[str]) -> dict[str, float]:
    """Contents of half-full tanks in lb; JSBSim limits a value written to the capacity."""
    fdm, contents = Airframe(**model).fdm, dict[str, float]()
    for tank in tanks:
        fdm[tank] = 1e9
        contents[tank] = round(0.5 * fdm[tank], 2)
    return contents


def _moved(model: Mapping[str, Any], condition: TrimCondition) -> dict[str, Any]:
    """Condition, effects of the commands, and a fault if some have none."""
    try:
        effects = tuple(responses(Airframe(**model), condition)[1])
    except BlocksError as error:
        return {"condition": condition, "faults": (_fault("commands", str(error), "trim"),)}
    note = " (the model writes it itself)"
    idle = [
        f"{e.properties[0]} has no effect on {e.acceleration}{note * e.written_by_model}"
        for e in effects
        if not e.moves
    ]
    angles = [
        f"{effect.properties[0]} changes {effect.acceleration} with the opposite sign"
        for effect in effects
        if effect.moves and effect.size * _SIGNS[effect.acceleration] < 0.0
    ]
    texts = {"commands": "; ".join(idle), "signs": "; ".join(angles)}
    faults = tuple(_fault(subject, text) for subject, text in texts.items() if text)
    return {"condition": condition, "effects": effects, "faults": faults}


def _changes_at_one(
    model: Mapping[str, Any], condition: TrimCondition | None, names: Iterable[str]
) -> list[str]:
    """What created properties change if they are 1 instead of 0, where this can be computed."""
    if condition is None:
        return []

    def at(create: Mapping[str, float]) -> dict[tuple[str, str], float]:
        accelerations, effects = responses(Airframe(**{**model, "create": create}), condition)
        values = {("", name): x for name, x in accelerations.items()}
        return values | {(f"effect of {e.command} on ", e.acceleration): e.size for e in effects}

    texts = []
    try:
        before = at(model["create"])
        for name in names:
            after = at({**model["create"], name: 1.0})
            # in tolerances of the search
            changes = {
                k: np.nan_to_num((after[k] - x) / RESIDUALS[k[1]]) for k, x in before.items()
            }
            what, acceleration = largest = max(changes, key=lambda k: abs(changes[k]))
            if abs(changes[largest]) > NONE:
                change = f"{after[largest] - before[largest]:+.3g} {UNITS[acceleration]}"
                texts.append(f"{name} at 1 changes {what}{acceleration} by {change}")
    except BlocksError:
        # the report has the reason
        return []
    return texts


def _modes(
    model: Mapping[str, Any], condition: TrimCondition
) -> tuple[str, tuple[Mode, ...], tuple[Fault, ...]]:
    """The method that has a linear model, its modes, and the fault of the flown one."""
    from ..design.designed import plant_model
    from ..flight import Aircraft

    faults = tuple[Fault, ...]()
    for method in ("flown", "algebraic"):
        try:
            linear = plant_model(Aircraft(**model, condition=condition), method)
        except BlocksError as error:
            faults = faults or (_fault("linear model", str(error.__cause__ or error)),)
        else:
            return method, tuple(linear.modes()), (*faults, *_misfit(linear))
    return "", (), faults


def _misfit(linear: LinearModel) -> tuple[Fault, ...]:
    """The fault of a flown model that is far from the flights from which it was identified."""
    errors = np.nan_to_num(linear.fit)
    pairs = np.argwhere(errors > _MISFIT)
    if not len(pairs):
        return ()
    texts = [f"{linear.outputs[i]} after {linear.inputs[j]} {errors[i, j]:.0%}" for i, j in pairs]
    return (_fault("linear model", f"errors of the flown one: {', '.join(texts)}"),)
