"""Data from the XML files of aircraft models."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import jsbsim

from .._core.checks import as_path, did_you_mean, nearest
from ..errors import AircraftError, FileError
from .references import references

_INCHES = {"IN": 1.0, "FT": 12.0, "M": 1 / 0.0254}


def _aircraft_folder(root: str | None = None, aircraft: str = "") -> Path:
    """The folder with the aircraft models below a JSBSim root (default: jsbsim's own)."""
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
    folder = _aircraft_folder(root)
    return sorted(
        (p.name for p in folder.glob("*") if (p / f"{p.name}.xml").is_file()), key=str.lower
    )


def empty_weight_cg(aircraft: str, root: str | None = None) -> tuple[float, float, float]:
    """Empty-weight centre of gravity of a model, structural axes (x aft, y right, z up), inches."""
    file = ModelFile(aircraft, root)
    location, factor = file.cg(file.parsed())
    try:
        x, y, z = (float(str(location.findtext(axis))) * factor for axis in "xyz")
    except ValueError:
        raise file.error(
            f"the empty-weight CG of aircraft {aircraft!r} is not three numbers"
        ) from None
    return x, y, z


def has_retractable_gear(aircraft: str, root: str | None = None) -> bool:
    """Whether any wheel is marked retractable."""
    file = ModelFile(aircraft, root)
    wheels = file.parsed().iterfind("ground_reactions/contact/retractable")
    try:
        return any(float(wheel.text or 0) for wheel in wheels)
    except ValueError:
        raise file.error(
            f"aircraft {aircraft!r} marks a wheel as neither retractable (1) nor fixed (0)"
        ) from None


class ModelFile:
    """The file of one aircraft model below a JSBSim root; AircraftError if there is none."""

    def __init__(self, aircraft: str, root: str | None):
        if not isinstance(aircraft, str):
            raise AircraftError(
                f"the aircraft must be a model's name, not {aircraft!r}", aircraft=repr(aircraft)
            )
        self.aircraft = aircraft = str(aircraft)  # of numpy's strings
        folder = _aircraft_folder(root, aircraft)
        self.path = folder / aircraft / f"{aircraft}.xml"
        try:
            # refuse names with a slash, which could lead out of the folder
            exists = Path(aircraft).name == aircraft and self.path.is_file()
            names = [] if exists else aircraft_names(root)
        except (OSError, ValueError):  # not a valid file name
            exists, names = False, []
        if not exists:
            close = nearest(aircraft, names)
            raise self.error(
                f"no aircraft {aircraft!r} among the {len(names)} model{'s' * (len(names) != 1)} "
                f"in {folder}" + (did_you_mean(close) or "; pathsim-jsbsim aircraft lists them"),
                close,
            )

    def error(self, message: str, close: Sequence[str] = ()) -> AircraftError:
        return AircraftError(message, aircraft=self.aircraft, nearest=close)

    def parsed(self, path: Path | None = None) -> ET.Element:
        """The root element, of another file of the model if one is given."""
        path = self.path if path is None else path
        try:
            return ET.parse(path).getroot()
        except (ET.ParseError, ValueError, LookupError) as error:  # an encoding that Python lacks
            why = f"is not well-formed XML: {error}"
        except OSError as error:
            why = f"cannot be read: {error.strerror}"
        raise self.error(f"the file of aircraft {self.aircraft!r} {why} ({path})")

    def cg(self, model: ET.Element) -> tuple[ET.Element, float]:
        """Location of the empty-weight CG, and the inches in its unit."""
        for location in model.iterfind("mass_balance/location"):
            if location.get("name", "").upper() == "CG":
                break
        else:
            raise self.error(f"aircraft {self.aircraft!r} defines no empty-weight CG")
        unit = location.get("unit", "IN").upper()
        if unit not in _INCHES:
            raise self.error(
                f"aircraft {self.aircraft!r} gives its empty-weight CG in the unknown unit {unit!r}"
            )
        return location, _INCHES[unit]

    def references_beyond(self, exists: Callable[[str], bool]) -> list[str]:
        """Properties to which the model refers and which do not exist."""
        missing = []
        for name in references(self.path, self.path.parents[2]):
            with contextlib.suppress(RuntimeError):  # not a property's name
                if not exists(name):
                    missing.append(name)
        return missing

    @contextlib.contextmanager
    def staged(self, x: float) -> Iterator[str]:
        """Context with an aircraft path to a copy of the model: empty-weight CG at ``x``, in."""
        with tempfile.TemporaryDirectory(
            prefix="jsbsim-aircraft-", ignore_cleanup_errors=True
        ) as stage:
            copy = Path(stage, self.aircraft, self.path.name)
            try:
                shutil.copytree(self.path.parent, copy.parent)
                model = self.parsed()
                location, factor = self.cg(model)
                node = location.find("x")
                if node is None:
                    name = repr(self.aircraft)
                    raise self.error(f"the empty-weight CG of aircraft {name} has no x")
                node.text = repr(x / factor)
                copy.chmod(0o644)
                ET.ElementTree(model).write(copy, encoding="utf-8", xml_declaration=True)
            except (OSError, shutil.Error) as error:
                raise FileError("copy", self.path.parent, error) from None
            yield stage
