"""Base of sampled laws: parameters that may be changed while the diagram runs."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

from ._pathsim import port_names
from .callers import warn_user
from .checks import positive
from .ports import NamedPorts
from .sampling import SampledLaw


class _Parameter:
    """Attribute for a parameter of ``__init__``; setting it rebuilds the laws."""

    def __init__(self, name: str):
        self.name = name

    def __get__(self, block: Any, owner: type) -> Any:
        if block is None:
            return self
        try:
            return block.__dict__[self.name]
        except KeyError:
            raise AttributeError(self.name) from None

    def __set__(self, block: TunableLaw, value: Any) -> None:
        # a subclass may add its own parameters after the constructor of its base
        if block.configured and self.name in block.__dict__:
            block.set(**{self.name: value})
        else:
            block.__dict__[self.name] = value


class TunableLaw(NamedPorts, SampledLaw):
    """Base of sampled laws whose parameters take effect at the next sample.

    A subclass implements `build`, which makes the plain laws from the parameters, and ends its
    ``__init__`` with ``self.configure()``. A parameter set later is checked in the same way; a
    refused value leaves the block unchanged.
    """

    configured = False
    # inputs that must be connected
    measured: tuple[str, ...] = ()
    # outputs that must be connected, and the input that can switch each off; "" if none can
    commands: Mapping[str, str] = {}
    _wires_seen = False

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        for name in list(inspect.signature(cls.__init__).parameters)[1:]:
            setattr(cls, name, _Parameter(name))

    def build(self) -> None:
        """Build the laws from the parameters, for the period ``self.clock.period``."""
        raise NotImplementedError

    def configure(self) -> None:
        # a new T takes effect at the next reset, for the clock and the laws
        positive("T", self.T)
        self.build()
        self.configured = True

    def start_step(self, t: float) -> None:
        super().start_step(t)
        if not self._wires_seen:
            self._wires_seen = True
            self._warn_of_missing_wires()

    def _warn_of_missing_wires(self) -> None:
        ports = port_names(self.inputs)
        missing = [name for name in self.measured if ports[name] not in self.inputs.wired]
        if missing:
            warn_user(
                f"{type(self).__name__} measures 0 where no wire comes in: {', '.join(missing)}"
            )

    def _put(self, values: dict[str, Any]) -> None:
        self.__dict__.update(values)
        self.configure()

    def reset(self) -> None:
        super().reset()
        self.configure()
