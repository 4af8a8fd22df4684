"""What PathView knows: its own blocks, and those that it finds in a toolbox."""

from __future__ import annotations

import importlib
import importlib.metadata
import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from pathsim.blocks import Block

from .._core.checks import did_you_mean, nearest
from ..errors import MissingExtraError, ParameterError

_PYPI_NAME = re.compile(r"[A-Za-z0-9]([A-Za-z0-9._-]*[A-Za-z0-9])?")


@dataclass(frozen=True)
class Toolbox:
    """An installed package whose blocks PathView can offer.

    Attributes
    ----------
    package : str
        its name on PyPI
    import_path : str
        the module in which PathView looks for blocks
    """

    package: str
    import_path: str

    @classmethod
    def parse(cls, text: str) -> Toolbox:
        """From ``PKG`` or ``PKG:IMPORTPATH``; the default path is the name with underscores."""
        package, _, import_path = text.partition(":")
        toolbox = cls(package, import_path or package.replace("-", "_"))
        if not _PYPI_NAME.fullmatch(package) or not all(
                map(str.isidentifier, toolbox.import_path.split("."))):
            raise ParameterError(f"a toolbox is PACKAGE or PACKAGE:IMPORT.PATH, not {text!r}",
                                 parameter="toolbox", value=text)
        return toolbox

    @property
    def id(self) -> str:
        return "pypi:" + re.sub(r"[-_.]+", "-", self.package.lower())

    def blocks(self) -> dict[str, type[Block]]:
        """Its blocks by class name, found by PathView's own rule: public, and defined there.

        Raises
        ------
        ParameterError
            if the module cannot be imported
        """
        try:
            module = importlib.import_module(self.import_path)
        except ImportError as error:
            raise ParameterError(
                f"toolbox {self.package!r} is not installed ({error}); "
                f"pip install {self.package}", parameter="toolbox", value=self.package) from error
        found = {}
        for name in dir(module):
            value = getattr(module, name)
            if (not name.startswith("_") and isinstance(value, type) and issubclass(value, Block)
                    and f"{value.__module__}.".startswith(f"{module.__name__}.")):
                found[value.__name__] = value
        return found

    def requirement(self) -> dict[str, Any]:
        """Its entry in ``requiredToolboxes`` of a model.

        The installed version is left out, so that the same script always gives the same file.
        """
        return {"id": self.id, "displayName": self.package,
                "source": {"type": "pypi", "pkg": self.package}, "importPath": self.import_path}


OURS = Toolbox("pathsim-jsbsim-blocks", "pathsim_jsbsim_blocks")
FLIGHT = Toolbox("pathsim-flight", "pathsim_flight")


def toolbox_of(block: type[Block]) -> Toolbox | None:
    """The toolbox in which PathView finds a block class; None if there is none."""
    parts = block.__module__.split(".")
    for n in range(1, len(parts) + 1):
        candidate = Toolbox(_distribution(parts[0]), ".".join(parts[:n]))
        if not candidate.package:
            return None
        if candidate.blocks().get(block.__name__) is block:
            return candidate
    return None


@lru_cache
def _distribution(module: str) -> str:
    """Name on PyPI of the installed package that brings a module; empty if there is none."""
    names = importlib.metadata.packages_distributions().get(module)
    if names:
        return names[0]
    try:
        # an editable install does not list its modules
        return importlib.metadata.distribution(module.replace("_", "-")).metadata["Name"]
    except importlib.metadata.PackageNotFoundError:
        return ""


def core_registry() -> dict[str, dict[str, Any]]:
    """PathView's registry of PathSim's own blocks and events, as its converter reads it."""
    try:
        import pathview
        from pathview.converter import load_registry
    except ImportError as error:
        raise MissingExtraError("pathview", "pathview") from error
    return load_registry(Path(pathview.__file__).parent / "data" / "registry.json")


def with_toolboxes(registry: dict[str, dict[str, Any]],
                   toolboxes: list[Toolbox]) -> dict[str, dict[str, Any]]:
    """``registry`` with the blocks of toolboxes; as in PathView, the last one wins a class name."""
    blocks = dict(registry["blocks"])
    for toolbox in toolboxes:
        for name, block in toolbox.blocks().items():
            blocks[name] = {"blockClass": name, "importPath": toolbox.import_path,
                            "params": list(block.info()["parameters"])}
    return {**registry, "blocks": blocks}


def unknown_block(name: str, registry: dict[str, dict[str, Any]]) -> str:
    """What to say about a block type that is in no registry."""
    return (f"PathView does not know the block {name!r}"
            + did_you_mean(nearest(name, registry["blocks"])))
