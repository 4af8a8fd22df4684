"""Parameters of blocks, declared once: as typed fields of the class.

    class Gain(Parametric):
        factor: float = parameter(1.0, number)

From its fields a class gets its constructor, with signature and defaults, and by that ``info()``,
repr and the editor's form; attributes that take effect when they are set; and the checks, at
construction and later.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, ClassVar

from .ports import NamedPorts

if TYPE_CHECKING:
    from typing_extensions import dataclass_transform
else:

    def dataclass_transform(**options: Any) -> Callable[[type], type]:
        return lambda cls: cls


# the value for a parameter, from its name and what was given
Check = Callable[..., Any]


class Parameter:
    """Attribute for a parameter; to set it is to configure the block anew."""

    name: str

    def __init__(self, default: Any = inspect.Parameter.empty, check: Check | None = None):
        self.default = default
        self.check = check

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, block: Any, owner: type) -> Any:
        if block is None:
            return self
        try:
            return block.__dict__[self.name]
        except KeyError:
            raise AttributeError(self.name) from None

    def __set__(self, block: Parametric, value: Any) -> None:
        # a subclass may add its own parameters after the constructor of its base
        if block.configured and self.name in block.__dict__:
            block.set(**{self.name: value})
        else:
            block.__dict__[self.name] = value


def parameter(default: Any, check: Check | None = None, **bounds: Any) -> Any:
    """A field: a default, and a check such as `number` with its bounds."""
    return Parameter(default, partial(check, **bounds) if check and bounds else check)


@dataclass_transform()
class Parametric(NamedPorts):
    """Base of blocks whose parameters are fields and may be changed while the diagram runs.

    A subclass implements `build`, which puts the parameters into effect: it finds their checked
    values in ``self.checked``. Parameters set later are checked in the same way; where a value is
    refused, the block stays as it was. A subclass may have a constructor of its own in place of
    fields, which stores its parameters.
    """

    configured = False
    checked: ClassVar[SimpleNamespace]
    _fields: ClassVar[dict[str, Parameter]] = {}

    def __init_subclass__(cls, **keywords: Any) -> None:
        own = {name: x for name, x in vars(cls).items() if isinstance(x, Parameter)}
        if "__init__" in vars(cls):
            for name in list(inspect.signature(cls.__init__).parameters)[1:]:
                if not isinstance(getattr(cls, name, None), Parameter):
                    field = Parameter()
                    field.__set_name__(cls, name)
                    setattr(cls, name, field)
        elif own:
            cls._fields = {**cls._fields, **own}
            cls.__init__ = _constructor(cls)  # type: ignore[method-assign, misc]
        super().__init_subclass__(**keywords)

    def begin(self) -> None:
        """Make the block itself, once its parameters are stored."""
        NamedPorts.__init__(self)

    def build(self) -> None:
        """Put the parameters into effect."""

    def configure(self) -> None:
        """Check the parameters and put them into effect."""
        checks = {name: field.check for name, field in self._fields.items() if field.check}
        values = {name: check(name, self.__dict__[name]) for name, check in checks.items()}
        self.checked = SimpleNamespace(**values)  # type: ignore[misc]
        self.build()
        self.configured = True

    def _put(self, values: dict[str, Any]) -> None:
        self.__dict__.update(values)
        self.configure()


def _constructor(cls: type[Parametric]) -> Callable[..., None]:
    types = inspect.get_annotations(cls)
    made = [inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD)]
    for name, field in cls._fields.items():
        annotation = types.get(name, inspect.Parameter.empty)
        made.append(made[0].replace(name=name, default=field.default, annotation=annotation))
    signature = inspect.Signature(made, return_annotation=None)

    def __init__(self: Parametric, *arguments: Any, **keywords: Any) -> None:
        given = signature.bind(self, *arguments, **keywords)
        given.apply_defaults()
        self.__dict__.update(list(given.arguments.items())[1:])
        self.begin()
        self.configure()

    __init__.__signature__ = signature  # type: ignore[attr-defined]
    __init__.__qualname__ = f"{cls.__qualname__}.__init__"
    __init__.__module__ = cls.__module__
    return __init__
