"""The blocks available in PathView: PathSim's own, and those of toolboxes."""

from __future__ import annotations

import importlib
import importlib.metadata
import importlib.util
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from pathsim.blocks import Block

from .._core.checks import did_you_mean, nearest, refuse
from ..errors import DiagramError, MissingExtraError, ParameterError
from .shape import Json

_PYPI_NAME = re.compile(r"[A-Za-z0-9]([A-Za-z0-9._-]*[A-Za-z0-9])?")


@dataclass(frozen=True)
class Toolbox:
    """An installed package whose blocks PathView can offer."""

    package: str  # name on PyPI
    import_path: str  # the module in which PathView looks for blocks

    @classmethod
    def parse(cls, text: str) -> Toolbox:
        """From ``PKG`` or ``PKG:IMPORTPATH``; the default path is the name with underscores."""
        package, _, import_path = text.partition(":")
        toolbox = cls(package, import_path or package.replace("-", "_"))
        if not _PYPI_NAME.fullmatch(package) or not all(
            map(str.isidentifier, toolbox.import_path.split("."))
        ):
            refuse("toolbox", text, f"a toolbox is PACKAGE or PACKAGE:IMPORT.PATH, not {text!r}")
        return toolbox

    @property
    def id(self) -> str:
        return "pypi:" + re.sub(r"[-_.]+", "-", self.package.lower())

    @property
    def belongs(self) -> bool:
        """Whether the installed package of this name contains the module."""
        top = self.import_path.partition(".")[0]
        return self.id in {Toolbox(name, top).id for name in _distributions(top)}

    @property
    def missing(self) -> bool:
        """Whether there is no such module, checked without importing anything."""
        return importlib.util.find_spec(self.import_path.partition(".")[0]) is None

    def blocks(self) -> dict[str, type[Block]]:
        """Its blocks by class name, found by PathView's own rule: public, and defined there."""
        blocks = filter(None, map(self.block, dir(self._module())))
        return {block.__name__: block for block in blocks}

    def block(self, name: str) -> type[Block] | None:
        """Its block of a public name; of a package whose names load one by one, no other loads."""
        module = self._module()
        value = getattr(module, name, None) if name in dir(module) else None
        if name.startswith("_") or not isinstance(value, type) or not issubclass(value, Block):
            return None
        return value if f"{value.__module__}.".startswith(f"{module.__name__}.") else None

    def _module(self) -> Any:
        try:
            return importlib.import_module(self.import_path)
        except (Exception, SystemExit) as error:
            why = f"cannot be imported: {type(error).__name__}: {error}"
            if isinstance(error, ImportError):
                why = f"is not installed ({error}); pip install {self.package}"
            refuse("toolbox", self.package, f"toolbox {self.package!r} {why}")

    def requirement(self) -> dict[str, Any]:
        """Its entry in a model, without the version: the same script gives the same file."""
        return {
            "id": self.id,
            "displayName": self.package,
            "source": {"type": "pypi", "pkg": self.package},
            "importPath": self.import_path,
        }


OURS = Toolbox("pathsim-jsbsim-blocks", "pathsim_jsbsim_blocks")
FLIGHT = Toolbox("pathsim-flight", "pathsim_flight")

# the toolboxes of PathSim's own project, as PathView's catalogue lists them
_PROJECT = ("batt", "chem", "flight", "fmi", "rf", "vehicle")
_KNOWN = [OURS, *(Toolbox.parse(f"pathsim-{name}") for name in _PROJECT)]


def why_not_import(toolbox: Toolbox, trusted: Sequence[Toolbox] = ()) -> str:
    """The reason not to import a toolbox that only a file requires; empty if there is none.

    An import runs the module's code, so the file may name only modules of known toolboxes, unless
    the user trusts the package.
    """
    if toolbox in (OURS, FLIGHT, *trusted):
        return ""
    what = f"requires the toolbox {toolbox.package!r} (module {toolbox.import_path})"
    if toolbox.id not in {t.id for t in (*_KNOWN, *trusted)}:
        return (
            f"{what}, which is not a known PathSim toolbox, and importing it runs its code; "
            f"if you trust it: --trust-toolbox {toolbox.package}"
        )
    if any(part.startswith("_") for part in toolbox.import_path.split(".")):
        return f"{what}, which is a private module"
    if not toolbox.belongs and not toolbox.missing:
        return (
            f"{what}, but that module does not belong to that package; if you trust it: "
            f"--trust-toolbox {toolbox.package}:{toolbox.import_path}"
        )
    return ""


def toolbox_of(block: type[Block]) -> Toolbox | None:
    """The toolbox in which PathView finds a block class; None if there is none."""
    parts = block.__module__.split(".")
    for n in range(1, len(parts) + 1):
        packages = _distributions(parts[0])
        if not packages:
            return None
        candidate = Toolbox(packages[0], ".".join(parts[:n]))
        if candidate.block(block.__name__) is block:
            return candidate
    return None


@lru_cache
def _distributions(module: str) -> tuple[str, ...]:
    """Names on PyPI of the installed packages that contain a top-level module."""
    names = importlib.metadata.packages_distributions().get(module)
    if names:
        return tuple(names)
    try:
        # an editable install does not list its modules
        return (importlib.metadata.distribution(module.replace("_", "-")).metadata["Name"],)
    except importlib.metadata.PackageNotFoundError:
        return ()


def core_registry() -> dict[str, dict[str, Any]]:
    """PathView's registry of PathSim's own blocks and events, as its converter reads it."""
    try:
        import pathview
        from pathview.converter import load_registry
    except ImportError as error:
        raise MissingExtraError("pathview", "pathview") from error
    return load_registry(Path(pathview.__file__).parent / "data" / "registry.json")


def with_toolboxes(
    registry: dict[str, dict[str, Any]], toolboxes: list[Toolbox]
) -> dict[str, dict[str, Any]]:
    """``registry`` with the blocks of toolboxes; as in PathView, the last class of a name wins."""
    blocks = dict(registry["blocks"])
    for toolbox in toolboxes:
        for name, block in toolbox.blocks().items():
            params = list(block.info()["parameters"])
            path = toolbox.import_path
            blocks[name] = {"blockClass": name, "importPath": path, "params": params}
    return {**registry, "blocks": blocks}


def registry_for(
    content: Json, path: Path, toolboxes: Sequence[str] = (), trust_toolboxes: Sequence[str] = ()
) -> Json:
    """The blocks that a model may use; the last of its own toolboxes to define a name wins."""
    requirements = required_toolboxes(content, path)
    extra = [Toolbox.parse(t) for t in toolboxes]
    trust = [*extra, *map(Toolbox.parse, trust_toolboxes)]
    for toolbox in requirements:
        if reason := why_not_import(toolbox, trust):
            raise DiagramError(reason, path=path)
    defaults = [t for t in (FLIGHT, OURS, *extra) if t not in requirements]
    return with_toolboxes(core_registry(), [*defaults, *requirements])


def required_toolboxes(content: Json, path: Path) -> list[Toolbox]:
    """The toolboxes that a model names itself."""
    toolboxes = []
    for entry in content.get("requiredToolboxes") or []:
        source, why = entry.get("source"), "requires a toolbox that is not a package"
        if not isinstance(source, dict) or source.get("type") not in ("pypi", "url"):
            raise DiagramError(f"{why}: {entry!r}", path=path)
        package = source.get("pkg") or entry.get("displayName") or ""
        try:
            toolboxes.append(Toolbox.parse(f"{package}:{entry.get('importPath') or ''}"))
        except ParameterError as error:
            raise DiagramError(f"{why}: {error}", path=path) from error
    return toolboxes


def unknown_block(name: str, registry: dict[str, dict[str, Any]]) -> str:
    """Error text for an unknown block type, with a toolbox of PathSim's project that has it."""
    text = f"PathView does not know the block {name!r}"
    for toolbox in _KNOWN:
        if not toolbox.missing and toolbox.block(name):
            return f"{text}; it is in {toolbox.package}: --toolbox {toolbox.package}"
    return text + did_you_mean(nearest(name, registry["blocks"]))
