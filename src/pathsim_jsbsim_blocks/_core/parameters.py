"""Parameters of blocks: fields of the standard library's dataclass, each with a check.

    @dataclass(eq=False)
    class Gain(Parametric):
        factor: float = parameter(1.0, number)

The fields define the constructor, with signature and defaults, and thus ``info()`` and the editor's
form. `Parametric` checks them when the block is built and when one is set later.
"""

from __future__ import annotations

import copy
import dataclasses
import difflib
import functools
import inspect
import reprlib
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from ..errors import KeywordError
from .callers import keep_warnings_visible
from .checks import did_you_mean, nearest_ports, refuse, refuse_unknown
from .own import editable, own
from .pathsim_internals import NamedRegister, port_names
from .pathsim_types import Block
from .ports import label

# similarity of two names, 0 to 1, above which one is probably a typo of the other
_TYPO = 0.85

# returns the valid value of a parameter, from its name and the value passed
Check = Callable[..., Any]


def parameter(default: Any, check: Check | None = None, **bounds: Any) -> Any:
    """A field: a default, and a check such as `number` with its bounds."""
    check = partial(check, **bounds) if check and bounds else check
    return dataclasses.field(default=default, metadata={"check": check})


@functools.cache
def _keywords(cls: type) -> list[str]:
    """Keywords of the constructor, including those that it passes on."""
    if cls.__hash__ is None or any(isinstance(x, dataclasses.Field) for x in vars(cls).values()):
        raise TypeError(f"{cls.__name__} needs the decorator @dataclass(eq=False)")
    names: list[str] = []
    for base in cls.__mro__:
        if "__init__" in vars(base):
            parameters = list(inspect.signature(vars(base)["__init__"]).parameters.values())[1:]
            kinds = [p.kind for p in parameters]
            names += [p.name for p in parameters if p.kind is not p.VAR_KEYWORD]
            if inspect.Parameter.VAR_KEYWORD not in kinds:
                break
    return names


class _Signature:
    """The signature of a class's constructor, for `inspect`.

    Python 3.11.2 shows that of an inherited ``__new__`` before that of an inherited ``__init__``.
    """

    def __get__(self, block: Any, cls: type) -> inspect.Signature:
        bare = inspect.signature(cls.__init__)  # type: ignore[misc]
        return bare.replace(parameters=list(bare.parameters.values())[1:])


@dataclasses.dataclass(eq=False, repr=False)
class Parametric(Block):
    """Base of all blocks of this package: parameters are fields, ports have names.

    A subclass is a dataclass, ``@dataclass(eq=False)``. It may implement `_begin`, to initialise
    PathSim's block, and `build`, to apply the parameters' checked values, ``self._checked``.
    Setting a parameter later calls `build` again; if a value is refused, the block is unchanged.
    A parameter is the block's own: what the caller later does to a dict, list or array that was
    passed has no effect, and what is read back cannot be edited.
    """

    # no annotations: these are class variables, not fields
    _built = False
    _checked = SimpleNamespace()
    __signature__ = _Signature()

    def __new__(cls, *arguments: Any, **keywords: Any) -> Any:
        names = _keywords(cls)  # type: ignore[arg-type]  # mypy: no hash without eq
        refuse_unknown(cls.__name__, keywords, names, cls.input_port_labels or ())
        return super().__new__(cls)

    def __post_init__(self) -> None:
        self._begin()
        for side in ("inputs", "outputs"):
            register = getattr(self, side)
            if not isinstance(register, NamedRegister):
                setattr(self, side, NamedRegister(len(register), port_names(register)))
        self._configure()

    def _begin(self) -> None:
        """Initialise PathSim's block, after the parameters are stored."""
        super().__init__()

    def build(self) -> None:
        """Apply the parameters."""

    def _configure(self) -> None:
        """Check and apply the parameters."""
        checks = [(f.name, f.metadata.get("check")) for f in dataclasses.fields(self)]
        values = {name: check(name, getattr(self, name)) for name, check in checks if check}
        self._checked = SimpleNamespace(**values)
        self.build()
        self._built = True

    def set_solver(self, Solver: Any, parent: Any, **solver_args: Any) -> None:
        """Called by PathSim when the block is added to a simulation."""
        keep_warnings_visible()
        super().set_solver(Solver, parent, **solver_args)

    if not TYPE_CHECKING:  # otherwise checkers would accept setting any attribute

        def __setattr__(self, name: str, value: Any) -> None:
            if name not in self.__dataclass_fields__:
                if self._built and name not in self.__dict__ and not hasattr(type(self), name):
                    self._refuse_typo(name, value)
                object.__setattr__(self, name, value)
            elif self._built:
                self._change({name: value})
            else:
                object.__setattr__(self, name, own(value))

    def set(self, **values: Any) -> None:
        """Set several parameters at once, as PathSim's ``@mutable`` blocks do.

        They are checked together: ``pid.set(low=2.0, high=3.0)`` works in either order. If one is
        refused, none is set.

        Raises
        ------
        ParameterError
            for a parameter that the block does not have, naming the nearest, and for bad values
        """
        refuse_unknown(type(self).__name__, values, self._parameters(), port_names(self.inputs))
        self._change(values)

    def _parameters(self) -> dict[str, None]:
        return dict.fromkeys([*self.info()["parameters"], *self.__dataclass_fields__])

    def _refuse_typo(self, name: str, value: Any) -> None:
        """Refuse a new attribute whose name is almost that of a parameter or port."""
        names = [*self._parameters(), *self._ipython_key_completions_()]
        close = difflib.get_close_matches(name, names, 1, _TYPO)
        if close and not name.startswith("_") and name not in self._parameters():
            hint = f": {name!r} is a port" if name in close else did_you_mean(close)
            message = f"{type(self).__name__} has no parameter {name!r}{hint}"
            raise KeywordError(message, parameter=name, value=value)

    def _change(self, values: dict[str, Any]) -> None:
        """Apply changed parameters; restore the old ones if they are refused."""
        previous = {name: getattr(self, name) for name in values}
        self.__dict__.update({name: own(value) for name, value in values.items()})
        try:
            self._configure()
        except BaseException:
            self.__dict__.update(previous)
            self._configure()
            raise

    def __copy__(self) -> Any:
        """A copy with its own ports and clock, as ``copy.deepcopy`` makes it."""
        return copy.deepcopy(self)

    def __repr__(self) -> str:
        arguments = []
        for name, parameter in inspect.signature(type(self)).parameters.items():
            value = getattr(self, name, parameter.default)
            # by its text, because comparing arrays gives an array
            if repr(value) != repr(parameter.default):
                arguments.append(f"{name}={reprlib.repr(editable(value))}")
        return f"{type(self).__name__}({', '.join(arguments)})"

    @classmethod
    def info(cls) -> dict[str, Any]:
        """PathSim's metadata of the block, with port labels that fit PathView."""
        metadata = dict(super().info())
        for side in ("input_port_labels", "output_port_labels"):
            metadata[side] = metadata[side] and {label(n): i for n, i in metadata[side].items()}
        return metadata

    def __getitem__(self, key: Any) -> Any:
        names = self._ipython_key_completions_()
        for port in key if isinstance(key, (list, tuple)) else [key]:
            if isinstance(port, str) and port not in names:
                close = nearest_ports(port, names)
                hint = did_you_mean(close) if close else f"; its ports are {', '.join(names)}."
                message = f"{type(self).__name__} has no port {port!r}{hint}"
                refuse("port", port, f"{message} {self._further_ports(port)}".rstrip(". "))
        return super().__getitem__(key)

    def _ipython_key_completions_(self) -> list[str]:
        return [*port_names(self.inputs), *port_names(self.outputs)]

    def _further_ports(self, port: str) -> str:
        """How to get a port that the block does not have yet, for the error message."""
        return ""
