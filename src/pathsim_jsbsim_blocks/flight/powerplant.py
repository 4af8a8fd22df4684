"""`Powerplant`: engines, propellers and tanks of an aircraft as it flies."""

from __future__ import annotations

import contextlib
import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping

from .integrators import INTEGRATORS
from .model_xml import Engine, ModelXml
from .property_tree import PropertyTree

_MIXTURE = re.compile(r"fcs/mixture-cmd-norm(\[\d+\])?$")

# s, too short for any motion
_INSTANT = 1e-12


class Powerplant(PropertyTree):
    """Engines, propellers and tanks of one aircraft.

    Attributes
    ----------
    tanks : list of str
        names of the contents of each tank
    stopped : frozenset of int
        engines that do not run, set by a trim
    """

    dt: float
    tanks: list[str]
    stopped: frozenset[int]
    _xml: ModelXml
    _written: dict[str, float]

    def _open_powerplant(self) -> None:
        """Use the engines and tanks of a new executive."""
        self._of_engines: dict[str, list[str]] = {}
        names = map("propulsion/tank[{}]/contents-lbs".format, itertools.count())
        self.tanks = list(itertools.takewhile(self.has, names))

    def of_engines(self, quantity: str) -> list[str]:
        """Names of a quantity of each engine that has it."""
        if quantity not in self._of_engines:
            names = (f"propulsion/engine[{i}]/{quantity}" for i in range(self.engines))
            self._of_engines[quantity] = [name for name in names if self.has(name)]
        return self._of_engines[quantity]

    @property
    def engine_list(self) -> tuple[Engine, ...]:
        """The engines with their types, from the files that were loaded."""
        return self._xml.engines(self.engines)

    def has_kind(self, *kinds: str) -> bool:
        """Whether an engine or a thruster is of one of these kinds."""
        return any({engine.type, engine.thruster} & {*kinds} for engine in self.engine_list)

    def fuel_of(self, engine: Engine) -> float:
        """The usable fuel in the open tanks that feed an engine, or its oxidizer if less, lb."""
        fdm, usable = self.fdm, {False: 0.0}
        for tank in engine.tanks:
            path, is_oxidizer = f"propulsion/tank[{tank}]", tank in engine.oxidizer
            usable.setdefault(is_oxidizer, 0.0)
            # a priority of 0 shuts a tank
            if fdm[f"{path}/priority"] > 0.0:
                unusable = fdm[f"{path}/unusable-volume-gal"] * fdm[f"{path}/density-lbs_per_gal"]
                usable[is_oxidizer] += max(fdm[f"{path}/contents-lbs"] - unusable, 0.0)
        return min(usable.values())

    def burning(self) -> list[Engine]:
        """Engines that burn fuel from tanks and are not stopped."""
        burning = [engine for engine in self.engine_list if engine.burns and engine.tanks]
        return [engine for engine in burning if engine.number not in self.stopped]

    def fuel(self) -> list[float]:
        """Usable fuel of each engine that burns it, lb."""
        return [self.fuel_of(engine) for engine in self.burning()]

    def without_fuel(self) -> list[Engine]:
        """Engines that are not stopped and get no fuel from any tank."""
        return [engine for engine in self.burning() if self.fuel_of(engine) <= 0.0]

    def marks(self) -> dict[int, bool]:
        """Whether each engine runs, for those that JSBSim marks as running or stopped."""
        runs = "propulsion/engine[{}]/set-running".format
        return {e.number: bool(self.fdm[runs(e.number)]) for e in self.engine_list if e.is_marked}

    def running_readers(self) -> list[Callable[[], float]]:
        """Functions that tell whether each engine runs; always, if it follows its throttle."""
        runs = "propulsion/engine[{}]/set-running".format
        return [
            (lambda: 1.0) if engine.follows_throttle else self.reader(runs(engine.number))
            for engine in self.engine_list
        ]

    def not_running(self) -> list[int]:
        """Engines that are not stopped and do not run, of those that JSBSim marks."""
        return [i for i, runs in self.marks().items() if not runs and i not in self.stopped]

    def starved(self) -> list[int]:
        """Engines that have stopped for lack of fuel."""
        marks = self.marks()
        if all(marks.values()) and not self.has_kind("rocket"):
            return []
        return [e.number for e in self.without_fuel() if not marks.get(e.number)]

    def freeze_fuel(self, frozen: bool = True) -> None:
        """Stop fuel consumption; with False restore the setting made by `write`."""
        name = "propulsion/fuel_freeze"
        if self.engines:
            # write-only
            self.fdm[name] = 1.0 if frozen else self._written.get(name, 0.0)

    @contextlib.contextmanager
    def fuel_frozen(self) -> Iterator[None]:
        """Context with `freeze_fuel`."""
        try:
            self.freeze_fuel()
            yield
        finally:
            self.freeze_fuel(False)

    def start_engines(self) -> None:
        """Start the engines, but stop those in `stopped`."""
        if self.engines and not self.stopped:
            self.fdm["propulsion/set-running"] = -1
        for i in range(self.engines if self.stopped else 0):
            if i in self.stopped:
                self.stop_engine(i)
            else:
                self.fdm["propulsion/set-running"] = i
        # JSBSim starts engines at full rich mixture: restore the mixtures written
        for name, value in self._written.items():
            if _MIXTURE.match(name):
                self.fdm[name] = value

    def stop_engine(self, i: int) -> None:
        """Stop an engine without ignition and fuel, so that windmilling cannot restart it."""
        self._command(i, {"magneto_cmd": 0.0, "cutoff_cmd": 1.0})
        self.fdm[f"propulsion/engine[{i}]/set-running"] = 0.0

    def crank(self, i: int, starter: bool) -> None:
        """Switch the ignition of an engine on, and its starter on or off."""
        self._command(i, {"magneto_cmd": 3.0, "starter_cmd": float(starter)})

    def _command(self, i: int, commands: Mapping[str, float]) -> None:
        """Write commands for one engine, those that its type has."""
        fdm = self.fdm
        active = fdm["propulsion/active_engine"]
        fdm["propulsion/active_engine"] = i
        for command, value in commands.items():
            if self.has(f"propulsion/{command}"):
                fdm[f"propulsion/{command}"] = value
        fdm["propulsion/active_engine"] = active

    @contextlib.contextmanager
    def governors_off(self) -> Iterator[None]:
        """Context with propeller governors off, for JSBSim's starting and settling of engines.

        JSBSim does this in steps of 0.5 s, at which a governor would jump between the pitch stops
        until the engine stalls.
        """
        on = [name for name in self.of_engines("constant-speed-mode") if self.fdm[name]]
        try:
            for name in on:
                self.fdm[name] = 0.0
            yield
        finally:
            for name in on:
                self.fdm[name] = 1.0

    def run_no_time(self) -> None:
        """A step of JSBSim without motion; its systems take a step of the usual length."""
        self.fdm.set_dt(_INSTANT)
        self.fdm.run()
        self.fdm.set_dt(self.dt)

    def start_turbines(self) -> None:
        """Make the step in which JSBSim starts turbines at idle, and restore their speeds."""
        speeds = {name: self.fdm[name] for name in self.of_engines("n1")}
        self.run_no_time()
        for name, speed in speeds.items():
            self.fdm[name] = speed

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Context in which the flight state is frozen while engines and systems run.

        No fuel is burnt, and actuators are at their commanded positions.
        """
        fdm = self.fdm
        methods = {name: fdm[name] for name in INTEGRATORS}
        fdm.set_trim_status(True)
        try:
            for name in methods:
                fdm[name] = 0.0
            yield
        finally:
            for name, method in methods.items():
                fdm[name] = method
            fdm.set_trim_status(False)

    @contextlib.contextmanager
    def engines_stopped(self) -> Iterator[None]:
        """Context that removes the thrust of stopped jet engines outside of a flight.

        Without a time step JSBSim gives a turbine the thrust of its throttle, running or not.
        """
        names = [f"propulsion/engine[{i}]/reverser-angle-rad" for i in self.stopped]
        angles = {name: self.fdm[name] for name in names if self.has(name)}
        try:
            for name in angles:
                self.fdm[name] = 0.5 * math.pi
            yield
        finally:
            for name, angle in angles.items():
                self.fdm[name] = angle
