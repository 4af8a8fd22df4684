"""Data from the XML files of aircraft models."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import jsbsim

from .._core.checks import did_you_mean, nearest
from .._core.files import as_path
from ..errors import AircraftError, FileError
from .model_xml import ModelXml, XmlError


def default_root() -> Path:
    """The JSBSim root beside the module: JSBSim itself looks only in Python's own folders."""
    return Path(jsbsim.__file__).parent


def _aircraft_folder(root: str | None = None, aircraft: str = "") -> Path:
    """The folder with the aircraft models below a JSBSim root (default: jsbsim's own)."""
    folder = as_path("root", default_root() if root is None else root) / "aircraft"
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
    with file.faults():
        return file.xml.empty_cg


def has_retractable_gear(aircraft: str, root: str | None = None) -> bool:
    """Whether any wheel is marked retractable."""
    file = ModelFile(aircraft, root)
    with file.faults():
        return file.xml.retracts


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
        exists, names, others = False, list[str](), list[str]()
        with contextlib.suppress(OSError, ValueError):  # not a valid file name
            # refuse names with a slash, which could lead out of the folder
            is_name = Path(aircraft).name == aircraft
            exists = is_name and self.path.is_file()
            names = [] if exists else aircraft_names(root)
            if is_name and not exists:
                others = sorted(file.name for file in self.path.parent.glob("*.[xX][mM][lL]"))
        if not exists:
            close = nearest(aircraft, names)
            hint = did_you_mean(close) or ("; pathsim-jsbsim aircraft lists them" if names else "")
            if others:
                hint = f": its folder has {' and '.join(others[:3])}, not {self.path.name}"
            raise self.error(
                f"no aircraft {aircraft!r} among the {len(names)} model{'s' * (len(names) != 1)} "
                f"in {folder}{hint}",
                close,
            )

    def error(self, message: str, close: Sequence[str] = ()) -> AircraftError:
        return AircraftError(message, aircraft=self.aircraft, nearest=close)

    @property
    def xml(self) -> ModelXml:
        """The model's files as they are at this moment."""
        return ModelXml.of(self.path)

    @contextlib.contextmanager
    def faults(self) -> Iterator[None]:
        """Context in which a fault of the files is an AircraftError."""
        try:
            yield
        except XmlError as error:
            raise self.error(f"the file of aircraft {self.aircraft!r} {error}") from None

    @contextlib.contextmanager
    def staged(self, x: float) -> Iterator[str]:
        """Context with an aircraft path to a copy of the model: empty-weight CG at ``x``, in."""
        with contextlib.ExitStack() as stack:
            try:
                folder = tempfile.TemporaryDirectory(
                    prefix="jsbsim-aircraft-", ignore_cleanup_errors=True
                )
                stage = stack.enter_context(folder)
                copy = Path(stage, self.aircraft, self.path.name)
                shutil.copytree(self.path.parent, copy.parent)
                with self.faults():
                    model = self.xml.at_cg(x)
                copy.chmod(0o644)
                model.write(copy, encoding="utf-8", xml_declaration=True)
            except (OSError, shutil.Error) as error:
                raise FileError("copy", self.path.parent, error) from None
            yield stage
