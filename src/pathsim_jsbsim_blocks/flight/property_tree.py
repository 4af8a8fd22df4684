"""Find, check, read and write properties of a JSBSim model by name."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import jsbsim

from .._core.checks import did_you_mean, must_be, nearest
from ..errors import PropertyError
from .model_xml import Engine
from .writable import Check, value_check, why_not


class PropertyTree:
    """Properties of one aircraft by name."""

    aircraft: str
    fdm: jsbsim.FGFDMExec

    def _open_tree(self) -> None:
        """Use the properties of a new executive."""
        self._properties = self.fdm.get_property_manager()
        self._names: list[str] | None = None
        # a trim map reads and writes the same few properties at every point
        self._nodes: dict[tuple[str, str], tuple[jsbsim.FGPropertyNode, Check | None]] = {}

    @property
    def engines(self) -> int:
        return self.fdm.get_propulsion().get_num_engines()

    @property
    def engine_list(self) -> Sequence[Engine]:
        raise NotImplementedError

    def property_error(self, name: str, message: str, close: Sequence[str] = ()) -> PropertyError:
        """The error of a property, with the nearest right ones."""
        return PropertyError(
            message + did_you_mean(close), aircraft=self.aircraft, name=name, nearest=close
        )

    def has(self, name: str) -> bool:
        """Whether a property exists."""
        try:
            # checked first, because the error for an unknown name searches for similar ones
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
            must_be("text", text, "text")
        return [n for n in self._catalogue() if text.lower() in n.lower()]

    def _catalogue(self) -> list[str]:
        if self._names is None:
            names = {line.partition(" (")[0] for line in self.fdm.get_property_catalog()}
            self._names = sorted(names - {""})
        return self._names

    def reader(self, name: str) -> Callable[[], float]:
        """A function that reads a property.

        Raises
        ------
        PropertyError
            if the name is malformed or unknown, or the property cannot be read
        """
        return self._node(name, "r")[0].get_double_value

    def writer(self, name: str) -> Callable[[float], Any]:
        """A function that writes a property; errors as in `reader`.

        Where JSBSim can use some values only, the function refuses the others with a
        `ParameterError` or `PropertyError`.
        """
        node, check = self._node(name, "w")
        if check is None:
            return node.set_double_value

        def put_checked(value: float) -> None:
            check(name, value)
            node.set_double_value(value)

        return put_checked

    def reader_of(self, names: Iterable[str]) -> Callable[[], list[float]]:
        """A function that reads several properties at once; errors as in `reader`."""
        nodes = [self._node(name, "r")[0] for name in names]
        get = jsbsim.FGPropertyNode.get_double_value
        return lambda: list(map(get, nodes))

    def writer_of(self, names: Iterable[str]) -> Callable[[list[float]], Any]:
        """A function that writes several properties at once, none if one is refused.

        Errors as in `writer`.
        """
        targets = [(name, *self._node(name, "w")) for name in names]
        nodes = [node for _, node, _ in targets]
        checks = [(i, name, check) for i, (name, _, check) in enumerate(targets) if check]
        put = jsbsim.FGPropertyNode.set_double_value

        def write(values: list[float]) -> None:
            for i, name, check in checks:
                check(name, values[i])
            list(map(put, nodes, values))

        return write

    def make(self, name: str, value: float) -> None:
        """Create a property, unless it exists."""
        if not self._known(name):
            if name.startswith("-"):
                self._find(name)  # refused
            self.fdm[name] = value

    def access(self, name: str) -> str:
        """``"rw"``, ``"r-"`` or ``"-w"``: how an existing property can be used."""
        return _access(self._find(name))

    def _node(self, name: str, way: str) -> tuple[jsbsim.FGPropertyNode, Check | None]:
        """A property to read ("r") or write ("w"), and a check of values to write."""
        # `_usable` refuses a name that is not text
        if not isinstance(name, str) or (name, way) not in self._nodes:
            node, check = self._usable(name, way), None
            if way == "w":
                check = value_check(self._path(node), self.aircraft, lambda: self.engine_list)
            self._nodes[name, way] = node, check
        return self._nodes[name, way]

    def _usable(self, name: str, way: str) -> jsbsim.FGPropertyNode:
        node, subject = self._find(name), f"property {name!r} of aircraft {self.aircraft!r}"
        if way == "w" and (why := why_not(self._path(node), self.has)):
            raise self.property_error(name, f"{subject} cannot be written: {why}")
        if way not in _access(node):
            close = [
                n
                for n in nearest(name.rpartition("/")[2], self._catalogue(), 9)
                if way in self.access(n) and not (way == "w" and why_not(n, self.has))
            ][:3]
            verb = "read" if way == "r" else "written"
            raise self.property_error(name, f"{subject} cannot be {verb}", close)
        return node

    def _known(self, name: str) -> bool:
        """Whether the tree has such a node; refuses malformed names."""
        try:
            if not isinstance(name, str):
                raise ValueError("it must be text")
            # JSBSim would read up to the NUL, and take the index modulo 2**32
            if "\0" in name or re.search(r"\[\d{10,}\]", name):
                raise ValueError("a NUL or an index beyond all elements")
            # hasNode ignores a leading minus, but get_node would abort the process
            if name.startswith("-"):
                return False
            # the only call that does not abort the process on a malformed name
            return self._properties.hasNode(str(name))
        except (RuntimeError, ValueError) as error:
            close = self._similar(re.sub(r"[^\w/\[\]-]", "", str(name)))
            raise self.property_error(
                str(name), f"{name!r} is not a valid property name: {error}", close
            ) from None

    def _similar(self, name: str) -> list[str]:
        """Existing names like ``name``; index 0 is written if ``name`` has it."""
        close = nearest(name.replace("[0]", ""), self._catalogue())
        for branch in re.findall(r"([\w-]+)\[0\]", name):
            close = [re.sub(rf"(?<![\w-]){branch}(?![\w[-])", f"{branch}[0]", n) for n in close]
        return close

    def _path(self, node: jsbsim.FGPropertyNode) -> str:
        return node.get_fully_qualified_name().removeprefix("/fdm/jsbsim/")

    def _find(self, name: str) -> jsbsim.FGPropertyNode:
        exists = self._known(name)
        if not exists or not name.strip():
            message = f"aircraft {self.aircraft!r} has no property {name!r}"
            raise self.property_error(name, message, self._similar(name))
        node = self._properties.get_node(str(name))
        assert node is not None
        names, place = self._catalogue(), self._path(node)
        at_the_root = "/fdm/jsbsim/".startswith(f"{place.rstrip('/')}/")
        trunk = "" if at_the_root else f"{place}/"
        i, j = bisect_left(names, place), bisect_left(names, trunk)
        children = [n for n in names[j : j + 3] if n.startswith(trunk)]
        if children and (at_the_root or names[i] != place):
            message = f"{name!r} is a branch of the property tree of aircraft {self.aircraft!r}"
            raise self.property_error(name, f"{message}, not a property", children)
        return node


def _access(node: jsbsim.FGPropertyNode) -> str:
    return ("r" if node.get_attribute(jsbsim.Attribute.READ) else "-") + (
        "w" if node.get_attribute(jsbsim.Attribute.WRITE) else "-"
    )
