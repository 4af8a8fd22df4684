"""Open JSBSim aircraft models sealed and quiet, and check properties by name.

All workarounds for loading JSBSim models are here. *Sealed*: by default a model opens no socket and
writes no file, regardless of its XML, and the installed jsbsim package is never modified. *Quiet*:
JSBSim's output goes to the logger ``pathsim_jsbsim_blocks.jsbsim``.
"""

from __future__ import annotations

import contextlib
import copy
import functools
import itertools
import math
import os
import re
import shutil
import tempfile
import xml.etree.ElementTree as ET
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import jsbsim

from .._core.checks import as_path, did_you_mean, flag, mapping, nearest, number, positive
from ..errors import AircraftError, FileError, ParameterError, PropertyError
from .console import SEALED_PATH, capture_console, messages
from .flightgear import address, directive
from .integrators import integrator_properties
from .planet import gravity_properties, planet_xml
from .writable import Check, value_check, why_not


def aircraft_folder(root: str | None = None, aircraft: str = "") -> Path:
    """The folder with the aircraft models below a JSBSim root (default: jsbsim's own).

    Raises
    ------
    AircraftError
        if there is none, with the name of the model that was looked for
    """
    root = jsbsim.get_default_root_dir() if root is None else root
    folder = as_path("root", root) / "aircraft"
    # os.path, because a name too long for the system is an error of Path's
    if not os.path.isdir(folder):
        raise AircraftError(f"no folder {str(folder)!r} with aircraft models", aircraft=aircraft)
    return folder


def aircraft_names(root: str | None = None) -> list[str]:
    """Names of all aircraft models below a JSBSim root directory, sorted.

    Parameters
    ----------
    root : str, optional
        JSBSim root directory; default is the one shipped with jsbsim

    Raises
    ------
    AircraftError
        if it has no folder ``aircraft``
    """
    folder = aircraft_folder(root)
    return sorted(
        (p.name for p in folder.glob("*") if (p / f"{p.name}.xml").is_file()), key=str.lower
    )


def empty_weight_cg(aircraft: str, root: str | None = None) -> tuple[float, float, float]:
    """Empty-weight centre of gravity of a model, structural axes (x aft, y right, z up), inches."""
    location = _cg_location(_parsed(_model_file(aircraft, root), aircraft), aircraft)
    factor = _inches(location, aircraft)
    try:
        x, y, z = (float(str(location.findtext(axis))) * factor for axis in "xyz")
    except ValueError:
        raise AircraftError(
            f"the empty-weight CG of aircraft {aircraft!r} is not three numbers", aircraft=aircraft
        ) from None
    return x, y, z


def has_retractable_gear(aircraft: str, root: str | None = None) -> bool:
    """Whether any wheel is marked retractable."""
    file = _model_file(aircraft, root)
    state = file.stat()
    return _any_wheel_retracts(aircraft, file, (state.st_mtime_ns, state.st_size))


@functools.lru_cache
def _any_wheel_retracts(aircraft: str, file: Path, version: tuple[int, int]) -> bool:
    """Read the model once for each version of its file: every reset of a fast aircraft asks."""
    model = _parsed(file, aircraft)
    try:
        return any(
            float(wheel.text or 0)
            for wheel in model.iterfind("ground_reactions/contact/retractable")
        )
    except ValueError:
        raise AircraftError(
            f"aircraft {aircraft!r} marks a wheel as neither retractable (1) nor fixed (0)",
            aircraft=aircraft,
        ) from None


_INCHES = {"IN": 1.0, "FT": 12.0, "M": 1 / 0.0254}


def _parsed(file: Path, aircraft: str) -> ET.Element:
    try:
        return ET.parse(file).getroot()
    except (ET.ParseError, ValueError, LookupError) as error:  # an encoding that Python lacks
        raise AircraftError(
            f"the file of aircraft {aircraft!r} is not well-formed XML: {error} ({file})",
            aircraft=aircraft,
        ) from None
    except OSError as error:
        raise AircraftError(
            f"the file of aircraft {aircraft!r} cannot be read: {error.strerror} ({file})",
            aircraft=aircraft,
        ) from None


def _inches(location: ET.Element, aircraft: str) -> float:
    unit = location.get("unit", "IN").upper()
    if unit not in _INCHES:
        raise AircraftError(
            f"aircraft {aircraft!r} gives its empty-weight CG in the unknown unit {unit!r}",
            aircraft=aircraft,
        )
    return _INCHES[unit]


def _cg_location(model: ET.Element, aircraft: str) -> ET.Element:
    for location in model.iterfind("mass_balance/location"):
        if location.get("name", "").upper() == "CG":
            return location
    raise AircraftError(f"aircraft {aircraft!r} defines no empty-weight CG", aircraft=aircraft)


def _model_file(aircraft: str, root: str | None) -> Path:
    if not isinstance(aircraft, str):
        raise AircraftError(
            f"the aircraft must be a model's name, not {aircraft!r}", aircraft=repr(aircraft)
        )
    folder = aircraft_folder(root, aircraft)
    file = folder / aircraft / f"{aircraft}.xml"
    try:
        # a slash in the name could lead out of the folder
        known = Path(aircraft).name == aircraft and file.is_file()
        names = [] if known else aircraft_names(root)
    except (OSError, ValueError):  # not a valid file name
        known, names = False, []
    if not known:
        close = nearest(aircraft, names)
        raise AircraftError(
            f"no aircraft {aircraft!r} among the {len(names)} model{'s' * (len(names) != 1)} in "
            f"{folder}" + (did_you_mean(close) or "; pathsim-jsbsim aircraft lists them"),
            aircraft=aircraft,
            nearest=close,
        )
    return file


_TANK = re.compile(r"propulsion/tank(\[\d+\])?/contents-lbs$")
ENGINE_RUNS = re.compile(r"propulsion/engine(?:\[(\d+)\])?/set-running$")
# without the flow of fuel, which is that of the pass before
_INTERNAL = re.compile(
    r"fcs/|systems/|propulsion/(?!.*/fuel-flow-rate-)|accelerations/[uvwpqr]dot-"
)
_GROUND = "ic/terrain-elevation-ft"
# how JSBSim names an output that goes to a socket
_SOCKET = re.compile(r":\d+/(TCP|UDP)$")


class Airframe:
    """One JSBSim aircraft, loaded sealed and quiet, not yet initialised.

    Parameters
    ----------
    aircraft : str
        name of the model (its folder below ``aircraft/``)
    dt : float
        JSBSim's time step in s; it is set before the model is loaded, because filters and
        actuators keep the step they were loaded with
    root : str, optional
        JSBSim root directory; default is the one shipped with jsbsim
    empty_cg_x : float, optional
        x of the empty-weight centre of gravity in inches aft, structural axes. The model is then
        loaded from a private copy, which is removed again; the installed one is not touched
    create : dict, optional
        properties, with their values, that the model expects from its environment (FlightGear)
        and JSBSim does not create; the error of a model that lacks one names it
    allow_network : bool
        let the model open the sockets that its XML asks for (FlightGear, telnet input)
    allow_files : bool
        let the model write the output files that its XML asks for (CSV)
    integrators : str or dict
        as in the aircraft blocks: "default", "precise", or methods by state
    planet : str or dict, optional
        as in the aircraft blocks; default is the model's own, or WGS-84
    gravity : str, optional
        as in the aircraft blocks: "J2" or "point mass"
    flightgear : str, optional
        ``"HOST:PORT"`` where FlightGear listens

    Attributes
    ----------
    fdm : jsbsim.FGFDMExec
        the executive: one object, one model. `renew` replaces it
    stopped : frozenset of int
        engines that do not run, set by a trim

    Raises
    ------
    AircraftError
        if the model is unknown or JSBSim cannot load it
    ParameterError
        for integrators, a planet or a gravity that JSBSim does not have
    """

    def __init__(
        self,
        aircraft: str,
        dt: float = 1 / 120,
        *,
        root: str | None = None,
        empty_cg_x: float | None = None,
        create: Mapping[str, float] | None = None,
        allow_network: bool = False,
        allow_files: bool = False,
        integrators: str | Mapping[str, str] = "default",
        planet: str | Mapping[str, float] | None = None,
        gravity: str | None = None,
        flightgear: str | None = None,
    ):
        self.dt = positive("dt", dt)
        self.root = root
        self.aircraft = aircraft
        self._model_file = _model_file(aircraft, root)
        self._network = flag("allow_network", allow_network)
        self._files = flag("allow_files", allow_files)
        self._flightgear = None if flightgear is None else address("flightgear", flightgear)
        self._cg = None if empty_cg_x is None else number("empty_cg_x", empty_cg_x)
        self._given = dict(mapping("create", create))
        self._planet = None if planet is None else planet_xml(planet)
        self._equations = integrator_properties(integrators)
        if gravity is not None:
            self._equations |= gravity_properties(gravity)
        self._written: dict[str, float] = {}
        self._names: list[str] | None = None
        self.stopped: frozenset[int] = frozenset()
        self._stand_in: Airframe | None = None
        self._open()

    def renew(self) -> None:
        """Reload the model and reapply what `create` and `write` have set.

        Changes made by JSBSim and direct writes to ``fdm`` are lost. Existing readers and writers
        still belong to the previous executive.
        """
        written, self._written = self._written, {}
        names = self._names
        self._open()
        self._names = names  # those of the same model
        self.write(written)

    def twin(self) -> Airframe:
        """Another airframe of the same model, sealed, with what `create` and `write` have set."""
        other = copy.copy(self)
        other._written = dict(self._written)
        other._network = other._files = False
        other._flightgear = other._stand_in = None
        other.renew()
        return other

    def stand_in(self) -> Airframe:
        """A twin for short flights, kept for the next one, with this airframe's fuel and engines.

        It knows nothing of direct writes to ``fdm``.
        """
        if self._stand_in is None:
            self._stand_in = self.twin()
        other = self._stand_in
        other.write(self._written)
        for tank in self.tanks:
            other.writer(tank)(self.reader(tank)())
        other.stopped = self.stopped
        return other

    def _open(self) -> None:
        capture_console()
        self.fdm = jsbsim.FGFDMExec(None if self.root is None else os.fspath(self.root))
        if not self._network:
            self.fdm.disable_input()
        if not self._files:
            self.fdm.disable_output()
            self.fdm.set_output_path(SEALED_PATH)
        self.fdm.set_dt(self.dt)
        staged = None
        if self._cg is not None:
            staged = _stage_with_cg(self._model_file, self.aircraft, self._cg)
            self.fdm.set_aircraft_path(staged)
        try:
            self._load()
        finally:
            if staged is not None:
                shutil.rmtree(staged, ignore_errors=True)
        # in this order: a model brings its planet, and a planet resets the integrators
        if self._planet is not None:
            self._load_planet(self._planet)
        for name, value in self._equations.items():
            self.fdm[name] = value
        self._properties = self.fdm.get_property_manager()
        self._choose_outputs()
        self._names = None
        # a trim map reads and writes the same few properties at every point
        self._readers: dict[str, Callable[[], float]] = {}
        self._writers: dict[str, tuple[Callable[[float], Any], Check | None]] = {}
        self._internal: list[jsbsim.FGPropertyNode] | None = None
        self._of_engines: dict[str, list[str]] = {}
        self._tanks: list[str] | None = None
        self._feeds: list[list[str]] | None = None
        self._created: set[str] = set()
        self._ground_before: float | None = None
        self._create()

    def _choose_outputs(self) -> None:
        """Switch off the outputs of the model that are not allowed; send to FlightGear."""
        fdm, allowed = self.fdm, self._flightgear is not None
        for i in itertools.count():
            switch = f"simulation/output[{i}]/enabled"
            if not self._properties.hasNode(switch):
                break
            if self._network if _SOCKET.search(fdm.get_output_filename(i)) else self._files:
                allowed = True
            else:
                fdm[switch] = 0.0
                fdm.set_output_filename(i, os.devnull)
        if self._flightgear is not None:
            failure = _failure_with_file(directive(*self._flightgear), fdm.set_output_directive)
            if failure:
                raise AircraftError(
                    f"JSBSim cannot send aircraft {self.aircraft!r} to FlightGear: {failure}",
                    aircraft=self.aircraft,
                )
        if allowed:
            fdm.enable_output()
        else:
            fdm.disable_output()

    def _load(self) -> None:
        failure = _failure_of(lambda: self.fdm.load_model(self.aircraft))
        if failure:
            raise AircraftError(
                f"JSBSim cannot load aircraft {self.aircraft!r}: {failure}", aircraft=self.aircraft
            )

    def _load_planet(self, xml: str) -> None:
        failure = _failure_with_file(xml, lambda file: self.fdm.load_planet(file, False))
        if failure:
            raise AircraftError(
                f"JSBSim cannot put aircraft {self.aircraft!r} on this planet: {failure}",
                aircraft=self.aircraft,
            )

    def _create(self) -> None:
        for name, value in self._given.items():
            x = number(f"create[{name!r}]", value)
            if self._known(name):
                self.writer(name)(x)
            else:
                self.fdm[name] = x
                self._created.add(self.canonical(name))
        self._names = None

    def run_ic(self) -> None:
        """Initialise the model from its ``ic/`` properties.

        Raises
        ------
        AircraftError
            if JSBSim cannot; if the model lacks a property, the message says how to create it
        """
        failure = _failure_of(self.fdm.run_ic)
        if failure:
            said = re.search(r"property (\S+) does not exist", failure)
            missing = said[1] if said else ""
            advice = (
                f". It expects this property from its environment; create it with "
                f"create={{{missing!r}: 0.0}}"
                if missing
                else ""
            )
            raise AircraftError(
                f"JSBSim cannot initialise aircraft {self.aircraft!r}: {failure}{advice}",
                aircraft=self.aircraft,
                missing=missing,
            )

    def raise_ground(self, elevation: float) -> None:
        """Put the ground at an elevation in ft above mean sea level."""
        self._ground_before = self.fdm[_GROUND]
        if self._ground_before != elevation:
            self.fdm[_GROUND] = elevation

    def lower_ground(self) -> None:
        """Restore the ground elevation from before `raise_ground`."""
        if self._ground_before is not None:
            self.fdm[_GROUND], self._ground_before = self._ground_before, None

    @property
    def engines(self) -> int:
        """Number of the model's engines."""
        return self.fdm.get_propulsion().get_num_engines()

    def of_engines(self, quantity: str) -> list[str]:
        """Names of a quantity of each engine that has it."""
        if quantity not in self._of_engines:
            names = (f"propulsion/engine[{i}]/{quantity}" for i in range(self.engines))
            self._of_engines[quantity] = [name for name in names if self.has(name)]
        return self._of_engines[quantity]

    @property
    def tanks(self) -> list[str]:
        """Names of the contents of each tank."""
        if self._tanks is None:
            names = map("propulsion/tank[{}]/contents-lbs".format, itertools.count())
            self._tanks = list(itertools.takewhile(self.has, names))
        return self._tanks

    def starved(self) -> list[int]:
        """Engines that have stopped while all the tanks that feed them are empty."""
        stopped = [
            i
            for i, name in enumerate(self.of_engines("set-running"))
            if i not in self.stopped and not self.reader(name)()
        ]
        if not stopped:
            return []
        if self._feeds is None:
            model = _parsed(self._model_file, self.aircraft)
            self._feeds = [
                [self.tanks[int(feed.text or 0)] for feed in engine.iterfind("feed")]
                for engine in model.iterfind("propulsion/engine")
            ]
        feeds = dict(enumerate(self._feeds))
        return [i for i in stopped if feeds.get(i) and all(map(self._is_empty, feeds[i]))]

    def _is_empty(self, tank: str) -> bool:
        unusable, density = (
            self.fdm[tank.replace("contents-lbs", name)]
            for name in ("unusable-volume-gal", "density-lbs_per_gal")
        )
        return self.fdm[tank] <= unusable * density

    def start_engines(self) -> None:
        """Start the engines, but stop those in `stopped`."""
        if self.engines and not self.stopped:
            self.fdm["propulsion/set-running"] = -1
            return
        for i in range(self.engines):
            if i in self.stopped:
                self._stop_engine(i)
            else:
                self.fdm["propulsion/set-running"] = i

    def _stop_engine(self, i: int) -> None:
        """Stop an engine so that the wind does not start it again: no ignition, no fuel."""
        fdm = self.fdm
        before = fdm["propulsion/active_engine"]
        fdm["propulsion/active_engine"] = i
        for command, off in (("magneto_cmd", 0.0), ("cutoff_cmd", 1.0)):
            if self.has(f"propulsion/{command}"):
                fdm[f"propulsion/{command}"] = off
        fdm["propulsion/active_engine"] = before
        fdm[f"propulsion/engine[{i}]/set-running"] = 0.0

    @contextlib.contextmanager
    def engines_stopped(self) -> Iterator[None]:
        """Keep stopped jet engines without thrust where JSBSim takes no step in time.

        Outside of a flight JSBSim lets a turbine have the thrust of its throttle, running or not.
        """
        names = [f"propulsion/engine[{i}]/reverser-angle-rad" for i in self.stopped]
        before = {name: self.fdm[name] for name in names if self.has(name)}
        try:
            for name in before:
                self.fdm[name] = 0.5 * math.pi
            yield
        finally:
            for name, angle in before.items():
                self.fdm[name] = angle

    def has(self, name: str) -> bool:
        """Whether a property exists."""
        try:
            # first, because the error of an unknown name searches for similar ones
            if not self._known(name):
                return False
            self._find(name)
        except PropertyError:
            return False
        return True

    def canonical(self, name: str) -> str:
        """Spelling of a property's name that `property_names` uses.

        Raises
        ------
        PropertyError
            if the name is malformed or unknown
        """
        return self._path(self._find(name))

    def property_names(self, text: str = "") -> list[str]:
        """Names of the model's properties that contain ``text``, sorted.

        Index 0 is omitted: ``propulsion/tank/contents-lbs`` is that of tank 0.
        """
        if not isinstance(text, str):
            raise ParameterError(f"text must be text, not {text!r}", parameter="text", value=text)
        return [n for n in self._catalogue() if text.lower() in n.lower()]

    def _catalogue(self) -> list[str]:
        if self._names is None:
            self._names = sorted(
                {line.partition(" (")[0] for line in self.fdm.get_property_catalog()} - {""}
                | self._created
            )
        return self._names

    def reader(self, name: str) -> Callable[[], float]:
        """A function that reads a property.

        Raises
        ------
        PropertyError
            if the name is malformed or unknown, or the property cannot be read
        """
        # what is no text is refused by `_node`
        if not isinstance(name, str) or name not in self._readers:
            self._readers[name] = self._node(name, "r", "read").get_double_value
        return self._readers[name]

    def writer(self, name: str) -> Callable[[float], Any]:
        """A function that writes a property; errors as in `reader`.

        Where JSBSim can use some values only, the function refuses the others with a
        `ParameterError` or `PropertyError`.
        """
        put, check = self._writable(name)
        if check is None:
            return put

        def put_checked(value: float) -> None:
            check(name, value)
            put(value)

        return put_checked

    def _writable(self, name: str) -> tuple[Callable[[float], Any], Check | None]:
        """What writes a property, and what refuses values of it."""
        # what is no text is refused by `_node`
        if not isinstance(name, str) or name not in self._writers:
            node = self._node(name, "w", "written")
            check = value_check(self._path(node), self.aircraft, self.engines)
            self._writers[name] = node.set_double_value, check
        return self._writers[name]

    def reader_of(self, names: Iterable[str]) -> Callable[[], list[float]]:
        """A function that reads several properties at once; errors as in `reader`."""
        nodes = [self._node(name, "r", "read") for name in names]
        get = jsbsim.FGPropertyNode.get_double_value
        return lambda: list(map(get, nodes))

    def writer_of(self, names: Iterable[str]) -> Callable[[list[float]], Any]:
        """A function that writes several properties at once, none if one is refused.

        Errors as in `writer`.
        """
        names = list(names)
        nodes = [self._node(name, "w", "written") for name in names]
        checks = [(i, n, c) for i, n in enumerate(names) if (c := self._writable(n)[1])]
        put = jsbsim.FGPropertyNode.set_double_value

        def write(values: list[float]) -> None:
            for i, name, check in checks:
                check(name, values[i])
            list(map(put, nodes, values))

        return write

    def internal(self) -> list[float]:
        """State of engines and systems, and the six accelerations that follow from it."""
        if self._internal is None:
            names = filter(_INTERNAL.match, self._catalogue())
            nodes = map(self._properties.get_node, names)
            self._internal = [node for node in nodes if node is not None]
        return list(map(jsbsim.FGPropertyNode.get_double_value, self._internal))

    def write(self, values: Mapping[str, float] | None, what: str = "properties") -> None:
        """Write a dict of properties in its order, all checked first.

        Raises
        ------
        PropertyError, ParameterError
            for an unknown property or a value that is not possible (nothing is written), or for
            more fuel than a tank holds
        """
        values = mapping(what, values)
        items = []
        for name, value in values.items():
            put, check = self._writable(name)
            items.append((put, number(f"{what}[{name!r}]", value)))
            if check is not None:
                check(f"{what}[{name!r}]", value)
        for put, value in items:
            put(value)
        for name in filter(_TANK.search, values):
            # JSBSim limits the contents to the capacity without a message
            full = self.fdm[name]
            if full < values[name] - 1e-6:
                raise ParameterError(
                    f"{what}[{name!r}] is {values[name]!r}, but this tank of "
                    f"{self.aircraft!r} holds {full:.6g} lb",
                    parameter=what,
                    value=values[name],
                )
        for name, value in values.items():
            if value == 0.0 and (engine := ENGINE_RUNS.match(name)):
                self._stop_engine(int(engine[1] or 0))
            # in the order of the last writes, which `renew` repeats
            self._written.pop(name, None)
            self._written[name] = value

    def access(self, name: str) -> str:
        """``"rw"``, ``"r-"`` or ``"-w"``: how an existing property can be used."""
        return _access(self._find(name))

    def _node(self, name: str, way: str, verb: str) -> jsbsim.FGPropertyNode:
        node = self._find(name)
        if way == "w" and (why := why_not(self._path(node), self.has)):
            raise PropertyError(
                f"property {name!r} of aircraft {self.aircraft!r} cannot be written: {why}",
                aircraft=self.aircraft,
                name=name,
            )
        if way not in _access(node):
            close = [
                n
                for n in nearest(name.rpartition("/")[2], self._catalogue(), 9)
                if way in self.access(n) and not (way == "w" and why_not(n, self.has))
            ][:3]
            raise PropertyError(
                f"property {name!r} of aircraft {self.aircraft!r} cannot be {verb}"
                + did_you_mean(close),
                aircraft=self.aircraft,
                name=name,
                nearest=close,
            )
        return node

    def _known(self, name: str) -> bool:
        """Whether the tree has such a node; refuses malformed names."""
        try:
            if not isinstance(name, str):
                raise ValueError("it must be text")
            # JSBSim would read up to the NUL, and take the index modulo 2**32
            if "\0" in name or re.search(r"\[\d{10,}\]", name):
                raise ValueError("a NUL or an index beyond all elements")
            # JSBSim finds the node behind a minus, and aborts the process when it is taken
            if name.startswith("-"):
                return False
            # the only call that does not abort the process on a malformed name
            return self._properties.hasNode(name)
        except (RuntimeError, ValueError) as error:
            close = self._similar(re.sub(r"[^\w/\[\]-]", "", str(name)))
            raise PropertyError(
                f"{name!r} is not a valid property name: {error}" + did_you_mean(close),
                aircraft=self.aircraft,
                name=str(name),
                nearest=close,
            ) from None

    def _similar(self, name: str) -> list[str]:
        """Existing names like ``name``; index 0 is written where ``name`` has it."""
        close = nearest(name.replace("[0]", ""), self._catalogue())
        for branch in re.findall(r"([\w-]+)\[0\]", name):
            close = [re.sub(rf"(?<![\w-]){branch}(?![\w[-])", f"{branch}[0]", n) for n in close]
        return close

    def _path(self, node: jsbsim.FGPropertyNode) -> str:
        return node.get_fully_qualified_name().removeprefix("/fdm/jsbsim/")

    def _find(self, name: str) -> jsbsim.FGPropertyNode:
        known = self._known(name)
        if not known or not name.strip():
            close = self._similar(name)
            raise PropertyError(
                f"aircraft {self.aircraft!r} has no property {name!r}" + did_you_mean(close),
                aircraft=self.aircraft,
                name=name,
                nearest=close,
            )
        node = self._properties.get_node(name)
        assert node is not None
        names, place = self._catalogue(), self._path(node)
        at_the_root = "/fdm/jsbsim/".startswith(f"{place.rstrip('/')}/")
        trunk = "" if at_the_root else f"{place}/"
        i, j = bisect_left(names, place), bisect_left(names, trunk)
        below = [n for n in names[j : j + 3] if n.startswith(trunk)]
        if below and (at_the_root or names[i] != place):
            raise PropertyError(
                f"{name!r} is a branch of the property tree of aircraft {self.aircraft!r}, not a "
                "property" + did_you_mean(below),
                aircraft=self.aircraft,
                name=name,
                nearest=below,
            )
        return node


def _access(node: jsbsim.FGPropertyNode) -> str:
    return ("r" if node.get_attribute(jsbsim.Attribute.READ) else "-") + (
        "w" if node.get_attribute(jsbsim.Attribute.WRITE) else "-"
    )


def _failure_of(action: Callable[[], bool]) -> str:
    """Why an action of JSBSim failed, in one line; empty if it did not."""

    def attempt() -> str:
        try:
            return "" if action() else "no"
        except Exception as error:
            return " ".join(str(error).split())

    failure, said = messages(attempt)
    return (" ".join(said) or failure)[:1000] if failure else ""


def _failure_with_file(xml: str, read: Callable[[str], bool]) -> str:
    """Why JSBSim could not read an XML text, which it takes from files only."""
    with tempfile.TemporaryDirectory(prefix="jsbsim-") as folder:
        file = Path(folder, "given.xml")
        file.write_text(xml, encoding="utf-8")
        return _failure_of(lambda: read(str(file)))


def _stage_with_cg(model_file: Path, aircraft: str, x: float) -> str:
    """A temporary aircraft path with a copy of one model, its empty-weight CG moved to ``x``."""
    stage = tempfile.mkdtemp(prefix="jsbsim-aircraft-")
    try:
        copy = Path(stage) / aircraft
        shutil.copytree(model_file.parent, copy)
        model = _parsed(model_file, aircraft)
        location = _cg_location(model, aircraft)
        node = location.find("x")
        if node is None:
            raise AircraftError(
                f"the empty-weight CG of aircraft {aircraft!r} has no x", aircraft=aircraft
            )
        node.text = repr(x / _inches(location, aircraft))
        (copy / model_file.name).chmod(0o644)
        ET.ElementTree(model).write(copy / model_file.name, encoding="utf-8", xml_declaration=True)
    except (OSError, shutil.Error) as error:
        shutil.rmtree(stage, ignore_errors=True)
        raise FileError("copy", model_file.parent, error) from None
    except BaseException:
        shutil.rmtree(stage, ignore_errors=True)
        raise
    return stage
