"""`Airframe`: a JSBSim aircraft model, opened sealed and quiet.

All workarounds for loading JSBSim models are here. *Sealed*: by default a model opens no socket and
writes no file, regardless of its XML, and the installed jsbsim package is never modified. *Quiet*:
JSBSim's output goes to the logger ``pathsim_jsbsim_blocks.jsbsim``.
"""

from __future__ import annotations

import contextlib
import copy
import functools
import itertools
import os
import re
import tempfile
import weakref
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from pathlib import Path

import jsbsim

from .._core.callers import warn_user
from .._core.checks import (
    did_you_mean,
    flag,
    integer,
    mapping,
    must_be,
    number,
    optional,
    positive,
    refuse,
)
from ..errors import AircraftError
from .console import SEALED_PATH, capture_console, failure_of, never_free
from .flightgear import address, directive
from .integrators import INTEGRATORS, integrator_properties
from .model_files import ModelFile, default_root
from .planet import gravity_properties, planet_xml
from .powerplant import Powerplant
from .script import ScriptRun, StartFile
from .writable import ENGINE_RUNS

_TANK = re.compile(r"propulsion/tank(\[\d+\])?/contents-lbs$")
# JSBSim's name of an output to a socket
_SOCKET = re.compile(r":\d+/(TCP|UDP)$")
# airframes that are connected to FlightGear, or allowed a network
with_sockets: weakref.WeakSet[Airframe] = weakref.WeakSet()


class Airframe(Powerplant):
    """One JSBSim aircraft, loaded sealed and quiet, not yet initialised.

    Parameters
    ----------
    aircraft : str
        name of the model (its folder below ``aircraft/``)
    dt : float
        JSBSim's time step in s, or that of ``substeps`` steps together; it is set before the model
        is loaded, because filters and actuators keep the step they were loaded with
    substeps : int
        number of equal steps into which ``dt`` is divided, as of `Aircraft`
    root : str, optional
        JSBSim root directory; default is the one shipped with jsbsim
    empty_cg_x : float, optional
        x of the empty-weight centre of gravity in inches aft, structural axes. The model is then
        loaded from a private copy, which is then removed; the installed model is unchanged
    create, allow_network, allow_files, integrators, planet, gravity, flightgear
        as of `Aircraft`
    start : StartFile, optional
        script or reset file with which the model is loaded, and which gives its time step

    Attributes
    ----------
    fdm : jsbsim.FGFDMExec
        the executive: one object, one model. `renew` replaces it
    created : dict
        properties created for the model, with their initial values
    tanks, stopped
        as of `Powerplant`
    run, sim_time : callable
        JSBSim's step, and its clock in s; with a script, those of a `ScriptRun`

    Raises
    ------
    AircraftError
        if the model is unknown, JSBSim cannot load it, or it refers to properties that do not exist
    PropertyError
        for malformed names in ``create``, and properties that cannot be written
    ParameterError
        for integrators, a planet or a gravity that JSBSim does not have
    """

    def __init__(
        self,
        aircraft: str,
        dt: float = 1 / 120,
        *,
        substeps: int = 1,
        root: str | None = None,
        empty_cg_x: float | None = None,
        create: Mapping[str, float] | str | None = None,
        allow_network: bool = False,
        allow_files: bool = False,
        integrators: str | Mapping[str, str] = "default",
        planet: str | Mapping[str, float] | None = None,
        gravity: str | None = None,
        flightgear: str | None = None,
        start: StartFile | None = None,
    ):
        self.substeps = integer("substeps", substeps, low=1)
        self.dt = positive("dt", dt) / self.substeps
        self.start = start
        self.root = root
        self._file = ModelFile(aircraft, root)
        self.aircraft = self._file.aircraft
        self._network = flag("allow_network", allow_network)
        self._files = flag("allow_files", allow_files)
        self._flightgear = optional("flightgear", flightgear, of=address)
        self.empty_cg_x = None if empty_cg_x is None else number("empty_cg_x", empty_cg_x)
        if isinstance(create, str) and create == "missing":
            create = {"missing": True}
        if isinstance(create, str):
            must_be("create", create, "a dict of names and values, or 'missing'")
        values = dict(mapping("create", create))
        self._creates_missing = flag("create['missing']", values.pop("missing", False))
        # whether a trial has shown that it initialises with what is created
        self._is_complete = not self._creates_missing
        self.created = {name: number(f"create[{name!r}]", x) for name, x in values.items()}
        self._planet = None if planet is None else planet_xml(planet)
        self._equations = integrator_properties(integrators)
        if gravity is not None:
            self._equations |= gravity_properties(gravity)
        self._written: dict[str, float] = {}
        # created after loading, if the model lacks them
        self._declared: Mapping[str, float] = {}
        self.stopped: frozenset[int] = frozenset()
        self._open()

    def renew(self) -> None:
        """Reload the model and reapply what `create` and `write` have set.

        Changes made by JSBSim and direct writes to ``fdm`` are lost. Existing readers and writers
        still belong to the previous executive.
        """
        settings, self._written = self._written, {}
        names = self._names
        self._open()
        self._names = names  # still valid: the model is the same
        self.write(settings)

    def twin(self, step: float | None = None) -> Airframe:
        """Another airframe of the same model, sealed, with what `create` and `write` have set.

        It has no script, whose events would act in a trim. With a maximum ``step`` in s it has
        JSBSim's own integrators.
        """
        twin = copy.copy(self)
        if step is not None:
            twin.dt = min(self.dt, step)
            twin._equations = {k: x for k, x in self._equations.items() if k not in INTEGRATORS}
        if self.start is not None:
            twin.start, twin._declared = None, self.start.declared
        twin._written = dict(self._written)
        twin._network = twin._files = False
        twin._flightgear = None
        twin.renew()
        return twin

    def resemble(self, source: Airframe) -> None:
        """Copy the properties written to another airframe of the model, its fuel, stopped engines.

        Direct writes to its ``fdm`` are not copied.
        """
        self.write(source._written)
        for tank in self.tanks:
            self.writer(tank)(source.reader(tank)())
        self.stopped = source.stopped

    def _open(self) -> None:
        self._load_with_all()
        for name, value in self._declared.items():
            self.make(name, value)
        # in this order: a model may define a planet, and a planet resets the integrators
        if self._planet is not None:
            self._do("put aircraft {!r} on this planet", self._load_planet)
        for name, value in self._equations.items():
            self.fdm[name] = value
        self._open_powerplant()
        self._choose_outputs()
        for name, start in self.created.items():
            self.writer(name)(start)
        self.script_run: ScriptRun | None = None
        self.run: Callable[[], object] = self.fdm.run
        self.sim_time: Callable[[], float] = self.fdm.get_sim_time
        if self.start is not None and self.start.is_script:
            self.script_run = ScriptRun(self.fdm, self.start.path.name)
            self.run, self.sim_time = self.script_run.step, self.script_run.time

    def _load_with_all(self) -> None:
        """Load the model with all properties to which it refers; AircraftError names those missing.

        Loading stops at the first one needed at once; it is then repeated with that one as 0.
        """
        lacking: dict[str, float] = {}
        while True:
            failure = self._load_in_new_executive({**lacking, **self.created})
            missing = self._missing()
            if missing:
                # its destructor reads them, and would crash the process
                never_free(self.fdm)
            names_in_failure = re.findall(r"[\w/\[\].-]+", failure)
            to_create = [name for name in missing if not failure or name in names_in_failure]
            if failure and not to_create:
                raise self._cannot("load aircraft {!r}", failure)
            lacking |= dict.fromkeys(to_create, 0.0)
            if failure or (to_create and self._creates_missing):
                continue
            if self._is_complete:
                break
            # a trial, after which the model is loaded once more
            names = [name for name in self._initialised()[0] if name not in lacking]
            lacking |= dict.fromkeys(names, 0.0)
            self._is_complete = not names
        if lacking and not self._creates_missing:
            raise self._lacks(lacking)
        if lacking:
            self.created = self.created | lacking
            _warn_once(f"aircraft {self.aircraft!r}: {self.created_as_zero()}", self._file.path)

    def _missing(self) -> list[str]:
        """Properties to which the model or its script refers and which do not exist."""
        missing, events = [], () if self.start is None else self.start.references
        for name in (*self._xml.references, *events):
            with contextlib.suppress(RuntimeError):  # not a property's name
                if not self._properties.hasNode(name):
                    missing.append(name)
        return missing

    def _load_in_new_executive(self, properties: Mapping[str, float]) -> str:
        """Load the model after creating properties; return why it failed, or an empty text."""
        capture_console()
        self._xml = self._file.xml
        self.fdm = jsbsim.FGFDMExec(os.fspath(default_root() if self.root is None else self.root))
        if self.root is None:
            self.fdm.set_output_path(os.getcwd())
        # the constructor sets the level from JSBSIM_DEBUG
        jsbsim.FGJSBBase().debug_lvl = 0
        if not self._network:
            self.fdm.disable_input()
        if not self._files:
            self.fdm.disable_output()
            self.fdm.set_output_path(SEALED_PATH)
        self.fdm.set_dt(self.dt)
        self._open_tree()
        for name, value in properties.items():
            self.make(name, value)
        with contextlib.ExitStack() as stack:
            if self.empty_cg_x is not None:
                stage = self._file.staged(self.empty_cg_x)
                self.fdm.set_aircraft_path(stack.enter_context(stage))
            failure = self._load()
        self._open_tree()
        return failure

    def _choose_outputs(self) -> None:
        """Switch off the outputs of the model that are not allowed; send to FlightGear."""
        fdm, self._outputs = self.fdm, list[str]()
        for i in itertools.count():
            switch = f"simulation/output[{i}]/enabled"
            if not self._properties.hasNode(switch):
                break
            if self._network if _SOCKET.search(fdm.get_output_filename(i)) else self._files:
                self._outputs.append(switch)
            else:
                fdm.set_output_filename(i, os.devnull)
            fdm[switch] = 0.0
        if self._flightgear is not None:
            xml = directive(*self._flightgear)
            send = lambda: _with_file(xml, fdm.set_output_directive)  # noqa: E731
            self._do("send aircraft {!r} to FlightGear", send)
        if self._network or self._flightgear is not None:
            with_sockets.add(self)
        if self._outputs or self._flightgear is not None:
            fdm.enable_output()
        else:
            fdm.disable_output()

    def start_outputs(self) -> None:
        """Switch on the model's outputs that are allowed: they are of a flight, not of its trim."""
        for switch in self._outputs:
            self.fdm[switch] = 1.0

    def _load(self) -> str:
        if self.start is None:
            return failure_of(lambda: self.fdm.load_model(self.aircraft))
        with self.start.staged() as path:
            failure = failure_of(lambda: self.fdm.load_script(path))
        if failure:
            return f"{self.start}: {failure.replace(path, self.start.path.name)}"
        self.dt = self.fdm.get_delta_t()
        return ""

    def _load_planet(self) -> bool:
        return _with_file(str(self._planet), lambda file: self.fdm.load_planet(file, False))

    def _do(self, what: str, action: Callable[[], bool]) -> None:
        """Raise AircraftError with JSBSim's message if an action of JSBSim fails."""
        if failure := failure_of(action):
            raise self._cannot(what, failure)

    def _cannot(self, what: str, failure: str) -> AircraftError:
        message = f"JSBSim cannot {what.format(self.aircraft)}: {failure}"
        return AircraftError(message, aircraft=self.aircraft)

    def _lacks(self, lacking: Mapping[str, float]) -> AircraftError:
        """The error of a model that refers to properties that do not exist."""
        # a typo in the model's own XML would become a term that is always 0
        bare = [name for name in lacking if not name.startswith("/")]
        close = {name: [n for n in self._similar(name) if n not in lacking][:2] for name in bare}
        hints = {name: f" ({did_you_mean(n)[2:]})" for name, n in close.items() if n}
        if self.start is not None:
            hints = {n: hints.get(n, "") + self.start.place_of(n) for n in lacking}
        names = ", ".join(f"{name!r}{hints.get(name, '')}" for name in lacking)
        create = self.created | dict(lacking)
        return AircraftError(
            f"aircraft {self.aircraft!r} refers to properties that do not exist: {names}. If they "
            f"come from outside (FlightGear), create them with create={create}, or as 0 with "
            "create='missing'",
            aircraft=self.aircraft,
            nearest=[name for similar in close.values() for name in similar],
            missing=lacking,
        )

    def created_as_zero(self) -> str:
        """The properties that were created as 0 for the model; empty if none was."""
        zeros = ", ".join(repr(name) for name, value in self.created.items() if not value)
        return f"created as 0, which they may not be in FlightGear: {zeros}" if zeros else ""

    def run_ic(self) -> None:
        """Initialise the model from its ``ic/`` properties.

        Raises
        ------
        AircraftError
            if JSBSim cannot
        """
        missing, failure = self._initialised()
        if missing:
            raise self._lacks(dict.fromkeys(missing, 0.0))
        if failure:
            raise self._cannot("initialise aircraft {!r}", failure)

    def _initialised(self) -> tuple[list[str], str]:
        """Initialise: missing properties that only JSBSim recognises, and why it failed."""
        failure = failure_of(self.fdm.run_ic)
        missing = re.findall(r"property (\S+) does not exist", failure)
        if missing:
            never_free(self.fdm)
        return missing, failure

    @property
    def components(self) -> tuple[ET.Element, ...]:
        """Components of the model's systems, as elements of the files that were loaded."""
        return self._xml.components

    def sources(self, name: str) -> tuple[str, ...]:
        """Properties from which the model's systems write a property, and that none writes."""
        return self._xml.sources(name)

    def write(self, values: Mapping[str, float] | None, what: str = "properties") -> None:
        """Write a dict of properties in its order, all checked first.

        Raises
        ------
        PropertyError, ParameterError
            for an unknown property or an impossible value (then no property is written), or for
            more fuel than a tank holds
        """
        values = mapping(what, values)
        items = []
        for name, value in values.items():
            node, check = self._node(name, "w")
            items.append((node.set_double_value, number(f"{what}[{name!r}]", value)))
            if check is not None:
                check(f"{what}[{name!r}]", value)
        for put, value in items:
            put(value)
        for name in filter(_TANK.search, values):
            # JSBSim limits the contents to the capacity without a message
            full = self.fdm[name]
            if full < values[name] - 1e-6:
                why = f"{what}[{name!r}] is {values[name]!r}, but this tank of {self.aircraft!r} "
                refuse(what, values[name], f"{why}holds {full:.6g} lb")
        for name, value in values.items():
            if value == 0.0 and (engine := ENGINE_RUNS.fullmatch(name)):
                self.stop_engine(int(engine[1] or 0))
            # in the order of the last writes, which `renew` repeats
            self._written.pop(name, None)
            self._written[name] = value


@functools.cache
def _warn_once(message: str, model: Path) -> None:
    """Warn once per process: a block reopens its model for a reset or a linear model."""
    warn_user(message)


def _with_file(xml: str, read: Callable[[str], bool]) -> bool:
    """Let JSBSim read an XML text, which it accepts only as a file."""
    with tempfile.TemporaryDirectory(prefix="jsbsim-") as folder:
        file = Path(folder, "given.xml")
        file.write_text(xml, encoding="utf-8")
        return read(str(file))
