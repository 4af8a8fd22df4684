"""JSBSim's scripts (``<runscript>``) and reset files (``<initialize>``), which start a flight.

JSBSim reads and flies them; here is what must be known before it does. A reset file is loaded by a
script without events: JSBSim's own function for these files ends the process if the file is wrong.
"""

from __future__ import annotations

import contextlib
import math
import os
import re
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NoReturn

import jsbsim

from .._core.callers import warn_user
from .._core.checks import did_you_mean, nearest, refuse
from .._core.files import as_path
from ..errors import AircraftError
from .model_files import ModelFile, default_root
from .model_xml import names_in
from .property_tree import PropertyTree
from .writable import why_not

# what an event may write and an input may not: the clock of the block follows a reset
_RESET = "simulation/reset"
_TRIM = "simulation/do_simple_trim"
_LINEARISE = "simulation/do_linearization"
# the level of the console is the same for all aircraft of the process: left out
_CONSOLE = "simulation/jsbsim-debug"
_EVENTS_ONLY = (_RESET, _TRIM, _LINEARISE, _CONSOLE)

# root elements of JSBSim's files: what each is, and how it is used
_KINDS = {
    "runscript": ("a script", "JSBSimFDM(script=FILE) flies it"),
    "initialize": (
        "a reset file",
        "JSBSimFDM(aircraft_model=NAME, initialize=FILE) starts from it, and "
        "TrimCondition.from_file(FILE, NAME) trims there",
    ),
    "fdm_config": ("an aircraft", "pathsim-jsbsim aircraft NAME describes it"),
}


def _plain(name: str) -> str:
    """A property's name as JSBSim's catalogue spells it."""
    return re.sub(r"\[0+\]", "", name.strip().removeprefix("/fdm/jsbsim/"))


class StartFile:
    """A script or a reset file from which a flight starts, both as a script for JSBSim.

    Attributes
    ----------
    path : Path
        absolute path of the file
    aircraft : str
        name of the model
    dt : float
        JSBSim's step, s
    steps : float
        number of steps to the end of the script, not rounded down
    is_script : bool
        whether it has events and an end
    writes : dict
        properties that events write, with the name of the first event that does
    declared : dict
        properties that the script creates or sets at the start, with their values
    """

    def __init__(
        self,
        path: Path,
        document: ET.Element,
        *,
        is_script: bool = True,
        inputs: Iterable[str] = (),
    ):
        self.path = path
        self.is_script = is_script
        self._document = document
        use, run = document.find("use"), document.find("run")
        if use is None or not use.get("aircraft") or not use.get("initialize"):
            self.refuse("has no <use aircraft=... initialize=...>")
        if run is None:
            self.refuse("has no <run>")
        self.aircraft = str(use.get("aircraft"))
        self.reset_file = str(use.get("initialize"))
        start = self._number("start in <run>", run.get("start", "0"))
        end = self._number("end in <run>", run.get("end", ""))
        self.dt = self._number("dt in <run>", run.get("dt", ""))
        if self.dt <= 0.0:
            self.refuse(f"has a step of {self.dt:g} s")
        if end < start:
            self.refuse(f"ends at {end:g} s, before its start at {start:g} s")
        # JSBSim ends a script after 0.99 of a step more
        self.steps = (end - start) / self.dt + 0.99
        self.writes: dict[str, str] = {}
        self._names: dict[str, str] = {}
        self._reported: dict[str, str] = {}
        for event in run.iterfind("event"):
            self._read(event)
        pairs = [(_plain(p.text or ""), p.get("value", "0")) for p in run.iterfind("property")]
        self.declared = {n: self._number(n, value) for n, value in pairs if n}
        # an input of the block owns its property
        self._without = {_CONSOLE, *map(_plain, inputs)} & {*self.writes}

    def _read(self, event: ET.Element) -> None:
        label = event.get("name", "")
        for write in event.iterfind("set"):
            name = _plain(write.get("name", ""))
            if not name:
                self.refuse(f"has a <set> without a name in event {label!r}")
            if not write.get("value", "").strip() and write.find("function") is None:
                # JSBSim would end the process
                self.refuse(f"sets {name} to no value and no function in event {label!r}")
            self.writes.setdefault(name, label)
            self._names.setdefault(name, label)
        for element in _conditions_and_functions(event):
            for name in names_in(element):
                self._names.setdefault(_plain(name), label)
        for element_shown in event.iterfind("notify/property"):
            self._reported.setdefault(_plain(element_shown.text or ""), label)

    def __str__(self) -> str:
        return f"{'script' if self.is_script else 'initialize'} {self.path.name}"

    def name(self, root: str | None) -> str:
        """The shortest name by which the file is found: below the JSBSim root, or its path."""
        folder = _root(root)
        is_below = self.path.is_relative_to(folder)
        return self.path.relative_to(folder).as_posix() if is_below else str(self.path)

    def refuse(self, why: str) -> NoReturn:
        parameter = "script" if self.is_script else "initialize"
        refuse(parameter, str(self.path), f"{self.path.name} {why}")

    def _number(self, what: str, text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            self.refuse(f"has {text!r} as {what}, not a number")
        return value

    def place_of(self, name: str) -> str:
        """The event that refers to a property, for a message; empty if none does."""
        label = self._names.get(name)
        return "" if label is None else f" in event {label!r} of {self.path.name}"

    @property
    def references(self) -> list[str]:
        """Properties that events read or write, whether they exist or not."""
        return [name for name in self._names if name not in self._without]

    def check(self, tree: PropertyTree, files: bool) -> None:
        """Refuse events that would stop the process or the clock, or write a file.

        A property that is only reported and does not exist is a warning: JSBSim fails if the event
        happens.
        """
        for name, label in self.writes.items():
            why = "" if name in _EVENTS_ONLY else why_not(name, tree.has)
            if name == _LINEARISE and not files:
                why = "it writes a file, which allow_files=True permits"
            if why and name not in self._without:
                self.refuse(f"writes {name} in event {label!r}: {why}")
        for name in [n for n in self._reported if n and not tree.has(n)]:
            event = f"event {self._reported[name]!r} of {self.path.name}"
            warn_user(
                f"{event} reports {name!r}, which aircraft {tree.aircraft!r} does not have: the "
                f"event ends the flight{did_you_mean(nearest(name, tree.property_names()))}",
                once=True,
            )

    @contextlib.contextmanager
    def staged(self) -> Iterator[str]:
        """The path of a script for JSBSim: the file, or a copy without the writes left out."""
        if self.is_script and not self._without:
            yield str(self.path)
            return
        for event in self._document.iterfind("run/event"):
            for write in event.findall("set"):
                if _plain(write.get("name", "")) in self._without:
                    event.remove(write)
        for output in self._document.iterfind("output[@file]"):
            # JSBSim looks for it beside the script
            output.set("file", str(self.path.parent / output.get("file", "")))
        with tempfile.TemporaryDirectory(prefix="jsbsim-script-") as folder:
            copy = Path(folder, self.path.name)
            ET.ElementTree(self._document).write(copy, encoding="utf-8", xml_declaration=True)
            yield str(copy)


def script_file(script: object, root: str | None, inputs: Iterable[str] = ()) -> StartFile:
    """A JSBSim script, a path or a name below the JSBSim root, without writes to ``inputs``."""
    name, folder = as_path("script", script), _root(root)
    path = next((p for p in (name.absolute(), folder / name) if os.path.isfile(p)), None)
    if path is None:
        places = {p.stem: p.relative_to(folder).as_posix() for p in folder.glob("scripts/*.xml")}
        places |= {p.stem: str(p) for p in name.parent.glob("*.xml") if p.is_file()}
        close = did_you_mean(places[stem] for stem in nearest(name.stem, places))
        refuse("script", str(script), f"no script {str(script)!r} here or below {folder}{close}")
    file = StartFile(path, _parsed("script", path, "runscript"), inputs=inputs)
    try:
        model = ModelFile(file.aircraft, root)
    except AircraftError as error:
        roots = [p for p in path.parents if os.path.isdir(p / "aircraft" / file.aircraft)]
        hint = f"; its JSBSim root is {str(roots[0])!r}" if roots else ""
        raise error.reworded(f"{file}: {error}{hint}") from None
    _reset_path("script", file.reset_file, model.path.parent, f"{file}: ")
    return file


def reset_file(file: object, aircraft: str, dt: float, root: str | None) -> StartFile:
    """A JSBSim reset file, a path or the name of a file beside the model."""
    path = as_path("initialize", file).absolute()
    if not os.path.isfile(path):
        path = _reset_path("initialize", str(file), _root(root) / "aircraft" / str(aircraft))
    if os.path.isfile(path):
        _parsed("initialize", path, "initialize")
    script = ET.Element("runscript", name=str(aircraft))
    ET.SubElement(script, "use", aircraft=str(aircraft), initialize=str(path))
    ET.SubElement(script, "run", start="0", end="1e12", dt=repr(dt))
    return StartFile(path, script, is_script=False)


def _reset_path(parameter: str, name: str, folder: Path, place: str = "") -> Path:
    """The path at which JSBSim finds a reset file of the aircraft in a folder."""
    path = folder / (name if Path(name).suffix else f"{name}.xml")
    # an aircraft that does not exist has an error of its own
    if os.path.isdir(folder) and not os.path.isfile(path):
        files = [p.stem for p in sorted(folder.glob("*.xml")) if b"<initialize" in p.read_bytes()]
        close = nearest(Path(name).stem, files)
        hint = did_you_mean(close) if close else f"; it has {', '.join(files) or 'none'}"
        refuse(parameter, name, f"{place}aircraft {folder.name!r} has no reset file {name!r}{hint}")
    return path


def _root(root: str | None) -> Path:
    return Path(default_root() if root is None else root).absolute()


def _parsed(parameter: str, path: Path, tag: str) -> ET.Element:
    why = ""
    try:
        document = ET.parse(path).getroot()
        if document.tag == tag:
            return document
        kind, use = _KINDS.get(document.tag, ("no file of JSBSim's", f"{parameter} needs <{tag}>"))
        why = f"is {kind} (<{document.tag}>), not {_KINDS[tag][0]}: {use}"
    except (ET.ParseError, ValueError, LookupError) as error:
        why = f"is not well-formed XML: {error}"
    except OSError as error:
        why = f"cannot be read: {error.strerror}"
    refuse(parameter, str(path), f"{path.name} {why}")


def _conditions_and_functions(event: ET.Element) -> list[ET.Element]:
    reports = {*event.iterfind("notify"), *event.iterfind("notify//*")}
    elements = (element for element in event.iter() if element not in reports)
    return [element for element in elements if element.tag not in ("set", "description")]


class ScriptRun:
    """JSBSim's steps with the events of a script, and its clock, which never goes back."""

    def __init__(self, fdm: jsbsim.FGFDMExec, name: str):
        self._fdm, self._name = fdm, name
        self._start = fdm.get_sim_time()
        # time flown before an event started the aircraft again, s
        self._before = 0.0
        self._warned: set[str] = set()

    def time(self) -> float:
        return self._before + self._fdm.get_sim_time()

    def step(self) -> None:
        """A step; warn once when the script has ended. JSBSim's errors name the script."""
        fdm = self._fdm
        time_at_start = fdm.get_sim_time()
        try:
            going = fdm.run()
        except jsbsim.BaseError as error:
            raise type(error)(f"script {self._name}: {error}") from None
        if fdm.get_sim_time() < time_at_start:
            self._before += time_at_start + fdm.get_delta_t() - fdm.get_sim_time()
        if not going:
            time = self.time() - self._start
            self.warn("end", f"script {self._name} ends at t = {time:.6g} s: the aircraft flies on")

    def warn(self, kind: str, message: str) -> None:
        """Warn once of each kind in a flight."""
        if kind not in self._warned:
            self._warned.add(kind)
            warn_user(message)
