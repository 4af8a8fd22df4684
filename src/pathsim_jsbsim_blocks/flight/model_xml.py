"""What the XML files of a model say, each file parsed once: JSBSim's Python does not tell it."""

from __future__ import annotations

import copy
import re
import threading
import xml.etree.ElementTree as ET
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

# "#" stands for the number of the engine
_STEP = r"[A-Za-z_][\w.-]*(?:\[(?:\d+|#)\])?"
_PATH = re.compile(rf"-?(/?{_STEP}(?:/{_STEP})+)")
_NAME = re.compile(rf"-?({_STEP})")
_TEST = re.compile(
    r"^\s*(\S+)[ \t]+(?:[!=]=|[<>]=?|EQ|NE|[LG][ET]|eq|ne|[lg][et])[ \t]+(\S+)[ \t]*$", re.MULTILINE
)

# elements whose text is a property, even without a slash
_PROPERTIES = ("property", "p", "input", "independentVar")

# sections of a model that have no effect on its flight
_UNUSED = ("fileheader", "input", "output")

# folders of engine files, the model's own first (FGPropulsion)
_ENGINES = ("Engines", "engines", "Engine", "engine")

# types by the root elements of the files of engines and thrusters
_KINDS = {
    "piston_engine": "piston",
    "turbine_engine": "turbine",
    "turboprop_engine": "turboprop",
    "rocket_engine": "rocket",
    "electric_engine": "electric",
    "brushless_dc_motor": "electric",
    **{name: name for name in ("propeller", "nozzle", "direct", "rotor")},
}

_INCHES = {"IN": 1.0, "FT": 12.0, "M": 1 / 0.0254}

# the models read last; the trees of a large one take some megabytes
_RECENT: dict[tuple[Path, Path], ModelXml] = {}
_MODELS = 16
_ONE_AT_A_TIME = threading.Lock()  # threads load aircraft side by side


class Engine(NamedTuple):
    """One engine of a model.

    Attributes
    ----------
    number : int
        its number, from 0
    type : str
        "piston", "turbine", "turboprop", "rocket", "electric", or "unknown" if its file cannot be
        read
    thruster : str
        "propeller", "nozzle", "direct", "rotor" or "unknown"
    tanks : tuple[int, ...]
        numbers of the tanks that feed it
    oxidizer : tuple[int, ...]
        those of them that hold oxidizer
    """

    number: int
    type: str
    thruster: str
    tanks: tuple[int, ...]
    oxidizer: tuple[int, ...] = ()

    @property
    def burns(self) -> bool:
        """Whether it needs fuel."""
        return self.type in ("piston", "turbine", "turboprop", "rocket")

    @property
    def is_marked(self) -> bool:
        """Whether JSBSim marks it as running, ``propulsion/engine[i]/set-running``, or stopped."""
        return self.type in ("piston", "turbine", "turboprop")

    @property
    def follows_throttle(self) -> bool:
        """Whether only its throttle can stop it."""
        return self.type in ("electric", "rocket")


class XmlError(Exception):
    """A fault of a model's file, as a predicate of the model."""


class ModelXml:
    """The XML files of one model below a JSBSim root, as they were when they were read.

    A fact raises `XmlError` if a faulty file does not tell it; no other use of the files does.
    """

    def __init__(self, path: Path, root: Path):
        self.path, self.root = path, root
        # by file: time of change and size, also of a missing file, which may appear; the tree
        self._stamps: dict[Path, tuple[int, int]] = {}
        self._trees: dict[Path, ET.Element] = {}

    @classmethod
    def of(cls, path: Path) -> ModelXml:
        """The files of the model at ``root/aircraft/name/name.xml``, read again after a change."""
        key = path, path.parents[2]
        with _ONE_AT_A_TIME:
            xml = _RECENT.pop(key, None)
            # a list: another thread may read a further file of the model meanwhile
            if xml is None or any(_stamp(file) != stamp for file, stamp in [*xml._stamps.items()]):
                xml = cls(*key)
            _RECENT[key] = xml
            if len(_RECENT) > _MODELS:
                del _RECENT[next(iter(_RECENT))]
            return xml

    def _tree(self, path: Path) -> ET.Element:
        """The root element of a file."""
        if path not in self._trees:
            self._stamps[path] = _stamp(path)
            try:
                self._trees[path] = ET.parse(path).getroot()
            except (ET.ParseError, ValueError, LookupError) as error:  # an encoding Python lacks
                raise XmlError(f"is not well-formed XML: {error} ({path})") from None
            except OSError as error:
                raise XmlError(f"cannot be read: {error.strerror} ({path})") from None
        return self._trees[path]

    def _find(self, element: str, file: str) -> Path | None:
        """The file that JSBSim reads for a name in an element; None if there is none."""
        name, folder = file if file.endswith(".xml") else f"{file}.xml", self.path.parent
        folders = [folder]
        if element in ("engine", "thruster"):
            folders = [*(folder / part for part in _ENGINES), self.root / "engine"]
        elif element == "system":
            folders = [folder, folder / "Systems", folder / "systems", self.root / "systems"]
        for path in (place / name for place in folders):
            self._stamps[path] = _stamp(path)
            if path.is_file():
                return path
        return None

    @cached_property
    def _elements(self) -> tuple[tuple[ET.Element, str], ...]:
        """All elements with an effect, in order, each with its engine's number or ""."""
        files, elements = [(self.path, "")], list[tuple[ET.Element, str]]()
        for path, engine in files:
            try:
                tree = self._tree(path)
            except XmlError:
                continue  # JSBSim's message about the file comes first
            for element, number in _within(tree):
                elements.append((element, number or engine))
                if (name := element.get("file")) and (file := self._find(element.tag, name)):
                    reference = file, number or engine
                    if reference not in files:
                        files.append(reference)
        return tuple(elements)

    @cached_property
    def references(self) -> tuple[str, ...]:
        """Properties to which the files refer, whether they exist or not, in order."""
        names: dict[str, None] = {}
        for element, engine in self._elements:
            for name in names_in(element):
                names[name.replace("#", engine)] = None
        return tuple(name for name in names if "[]" not in name)

    @cached_property
    def components(self) -> tuple[ET.Element, ...]:
        """Components of all channels of the control system, autopilot and systems."""
        channels = (element for element, _ in self._elements if element.tag == "channel")
        return tuple(component for channel in channels for component in channel)

    @cached_property
    def supercharged(self) -> bool:
        """Whether a piston engine has a supercharger."""
        elements = self._elements  # reads all files
        speeds = (element.findtext("numboostspeeds") for element, _ in elements)
        return any(float(text or 0.0) > 0.0 for text in speeds)

    def sources(self, name: str) -> tuple[str, ...]:
        """Properties from which the systems write a property, and that no system writes."""
        outputs = dict[str, list[str]]()
        for element, _ in self._elements:
            if element.tag in ("system", "channel") or not element.get("name"):
                continue
            inputs = [x for part in element.iter() if part.tag != "output" for x in names_in(part)]
            names = [output.text or "" for output in element.iterfind("output")]
            for output in (*names, element.get("name", "")):
                outputs.setdefault(output.strip(), []).extend(inputs)
        sources, queue = dict[str, None](), [name]
        for each in queue:
            for source in outputs.get(each, ()):
                if source in outputs:
                    queue += [source] if source not in queue else []
                else:
                    sources[source] = None
        return tuple(sources)

    def engines(self, number: int) -> tuple[Engine, ...]:
        """The engines, of which JSBSim has loaded ``number``; of unknown type if these differ."""
        engines = self._engines
        if len(engines) == number:
            return engines
        return tuple(Engine(i, "unknown", "unknown", ()) for i in range(number))

    @cached_property
    def _engines(self) -> tuple[Engine, ...]:
        """The engines; none if Python cannot read what JSBSim has read."""
        try:
            tree = self._tree(self.path)
            propulsion = tree.find("propulsion")
            name = "" if propulsion is None else propulsion.get("file", "")
            if name and (file := self._find("propulsion", name)):
                tree = self._tree(file)
                propulsion = tree if tree.tag == "propulsion" else tree.find("propulsion")
            if propulsion is None:
                return ()
            types, engines = [tank.get("type") for tank in propulsion.findall("tank")], []
            for i, element in enumerate(propulsion.findall("engine")):
                feeds = (int(float(feed.text or 0)) for feed in element.findall("feed"))
                kinds = self._kind(element), self._kind(element.find("thruster"))
                tanks = tuple(tank for tank in feeds if tank in range(len(types)))
                oxidizer = tuple(tank for tank in tanks if types[tank] == "OXIDIZER")
                engines.append(Engine(i, *kinds, tanks, oxidizer))
        except (XmlError, ValueError):
            return ()
        return tuple(engines)

    def _kind(self, element: ET.Element | None) -> str:
        """The type of an engine or thruster, from an element in it or the root of its file."""
        if element is None:
            return "unknown"
        tags = [child.tag for child in element]
        if (name := element.get("file")) and (file := self._find("engine", name)):
            tags.append(self._tree(file).tag)
        return next((_KINDS[tag] for tag in tags if tag in _KINDS), "unknown")

    @cached_property
    def retracts(self) -> bool:
        """Whether any wheel is marked retractable."""
        wheels = self._tree(self.path).iterfind("ground_reactions/contact/retractable")
        try:
            return any(float(wheel.text or 0) for wheel in wheels)
        except ValueError:
            raise XmlError("marks a wheel as neither retractable (1) nor fixed (0)") from None

    @cached_property
    def empty_cg(self) -> tuple[float, float, float]:
        """Empty-weight centre of gravity, structural axes (x aft, y right, z up), inches."""
        location, factor = _cg(self._tree(self.path))
        try:
            x, y, z = (float(str(location.findtext(axis))) * factor for axis in "xyz")
        except ValueError:
            raise XmlError("has an empty-weight CG that is not three numbers") from None
        return x, y, z

    def at_cg(self, x: float) -> ET.ElementTree:
        """The model's file with another x of the empty-weight CG, inches."""
        model = copy.deepcopy(self._tree(self.path))
        location, factor = _cg(model)
        node = location.find("x")
        if node is None:
            raise XmlError("has an empty-weight CG without x")
        node.text = repr(x / factor)
        return ET.ElementTree(model)

    @cached_property
    def outlets(self) -> tuple[str, ...]:
        """Sockets and files in the inputs and outputs."""
        outlets = []
        for element in self._tree(self.path):
            name = element.get("file") or element.get("name")
            if element.tag in ("input", "output") and (port := element.get("port")):
                outlets.append(f"{element.tag} by port {port}")
            elif element.tag == "output" and name and element.get("type") != "NONE":
                outlets.append(f"output to {name}")
        return tuple(outlets)


def _stamp(path: Path) -> tuple[int, int]:
    """Time of change and size of a file; zeros if there is none."""
    try:
        stat = path.stat()
    except OSError:
        return 0, 0
    return stat.st_mtime_ns, stat.st_size


def _cg(model: ET.Element) -> tuple[ET.Element, float]:
    """Location of the empty-weight CG, and the inches in its unit."""
    locations = model.iterfind("mass_balance/location")
    location = next((x for x in locations if x.get("name", "").upper() == "CG"), None)
    if location is None:
        raise XmlError("defines no empty-weight CG")
    unit = location.get("unit", "IN").upper()
    if unit not in _INCHES:
        raise XmlError(f"gives its empty-weight CG in the unknown unit {unit!r}")
    return location, _INCHES[unit]


def _within(tree: ET.Element) -> list[tuple[ET.Element, str]]:
    """Elements of a file with an effect, each with the number of the enclosing engine, or ""."""
    stack, elements = [(tree, "")], []
    while stack:
        element, engine = stack.pop()
        elements.append((element, engine))
        number, children = 0, []
        for child in element:
            if child.tag == "engine":
                children.append((child, str(number)))
                number += 1
            elif not (element is tree and child.tag in _UNUSED):
                children.append((child, engine))
        stack += reversed(children)
    return elements


def names_in(element: ET.Element) -> list[str]:
    """Properties in an element's text, tests and attributes."""
    text = element.text or ""
    texts = text.strip(), element.get("execute", ""), element.get("value", "")
    for child in element:
        text += f"\n{child.tail or ''}"
    words = [word for test in _TEST.findall(text) for word in test]
    pattern = _NAME if element.tag in _PROPERTIES else _PATH
    # a test may name a property without a slash, which JSBSim looks up when it initialises
    matches = [_PATH.fullmatch(word) or _NAME.fullmatch(word) for word in words]
    matches += [_PATH.fullmatch(word) or pattern.fullmatch(word) for word in texts if word]
    return [match[1] for match in matches if match]
