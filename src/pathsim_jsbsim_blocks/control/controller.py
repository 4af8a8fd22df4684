"""Base of the controller blocks: parameters that may be changed while the diagram runs."""

from __future__ import annotations

import inspect
from typing import Any

from ..checks import positive
from ..errors import ParameterError
from ..ports import NamedPorts
from ..sampling import SampledLaw


class _Parameter:
    """Attribute for a parameter of ``__init__``: when it is set, the laws are built anew."""

    def __init__(self, name: str):
        self.name = name

    def __get__(self, block: Any, owner: type) -> Any:
        if block is None:
            return self
        try:
            return block.__dict__[self.name]
        except KeyError:
            raise AttributeError(self.name) from None

    def __set__(self, block: Controller, value: Any) -> None:
        values = block.__dict__
        before = values.get(self.name)
        values[self.name] = value
        if block.configured:
            try:
                block.configure()
            except ParameterError:
                values[self.name] = before
                block.configure()
                raise


class Controller(NamedPorts, SampledLaw):
    """Base of sampled controllers whose parameters take effect at the next sample.

    A subclass implements `build`, which makes the plain laws from the parameters, and ends its
    ``__init__`` with ``self.configure()``. A parameter set later is checked and takes effect in
    the same way; a value that is refused leaves the block as it was.
    """

    configured = False

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        for name in list(inspect.signature(cls.__init__).parameters)[1:]:
            setattr(cls, name, _Parameter(name))

    def build(self) -> None:
        """Make the laws from the parameters, for the period ``self.clock.period``."""
        raise NotImplementedError

    def configure(self) -> None:
        # the clock takes a new period at the next reset, and the laws with it
        positive("T", self.T)
        self.build()
        self.configured = True

    def reset(self) -> None:
        super().reset()
        self.configure()
