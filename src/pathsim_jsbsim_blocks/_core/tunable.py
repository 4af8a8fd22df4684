"""Base of sampled laws: parameters that may be changed while the diagram runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from .callers import warn_user
from .parameters import Parametric
from .sampling import SampledLaw


class TunableLaw(Parametric, SampledLaw):
    """Base of sampled laws whose parameters take effect at the next sample.

    `build` makes the plain laws, for the period ``self.clock.period``: a new T takes effect at the
    next reset.
    """

    # inputs that must be connected
    measured: ClassVar[tuple[str, ...]] = ()
    # outputs that must be connected, and the input that can switch each off; "" if none can
    commands: ClassVar[Mapping[str, str]] = {}
    _wires_seen = False

    def begin(self) -> None:
        SampledLaw.__init__(self, self.T)

    def run_begins(self) -> None:
        """Warn once of inputs that must be connected and are not."""
        if self._wires_seen:
            return
        self._wires_seen = True

        missing = [name for name in self.needed() if name not in self.inputs.wired]
        if missing:
            warn_user(
                f"{type(self).__name__} measures 0 where no wire comes in: {', '.join(missing)}"
            )

    def needed(self) -> tuple[str, ...]:
        """Inputs that must be connected, given the others that are."""
        return self.measured

    def reset(self) -> None:
        period = self.clock.period
        super().reset()
        if self.clock.period != period:
            self.configure()
