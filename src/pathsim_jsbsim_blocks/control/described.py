"""Base of the blocks whose law is described by operations on signals."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, ClassVar, TypeVar

from .._core.tunable import TunableLaw
from .signals import Law, compiled, flat

Method = TypeVar("Method", bound=Callable[..., Any])


def as_described(law: Method) -> Method:
    """Mark a method `law` that computes nothing beside what `describe` says and schedules."""
    law.described = True  # type: ignore[attr-defined]
    return law


class DescribedLaw(TunableLaw):
    """Base of sampled laws that are written in the operations of `signals`.

    A subclass implements `describe`, a pure function in which only parameters, gains and the form
    decide by ``if``. It is compiled when it is first flown, and again after a change of parameters.
    """

    # state before the first sample
    START: ClassVar[tuple[Any, ...]]
    # whether ports with names of an aircraft's are meant for these: a PID's r is no yaw rate
    of_aircraft: ClassVar[bool] = False

    def describe(self, u: list[Any], state: Any, form: Any) -> tuple[list[Any], Any]:
        """Outputs and next state from inputs and state; ``form`` is what else decides."""
        raise NotImplementedError

    def form(self, u: list[float]) -> Hashable:
        """What decides on the law beside parameters, at these inputs."""
        return None

    def configure(self) -> None:
        self._laws: dict[Hashable, Law] = {}
        self.__dict__.pop("law", None)
        self._inputs = len(self.input_port_labels or ())
        super().configure()

    def initial_state(self) -> tuple[Any, ...]:
        return flat(self.START)

    @as_described
    def law(self, u: list[float], state: tuple[Any, ...]) -> tuple[list[float], tuple[Any, ...]]:
        result = self.flown(u, state, None, self._inputs)
        if type(self).law is DescribedLaw.law:
            # saves two calls at every sample
            self.__dict__["law"] = self._laws[None]
        return result

    def flown(
        self, u: list[float], state: tuple[Any, ...], form: Hashable, inputs: int
    ) -> tuple[list[float], tuple[Any, ...]]:
        """The law as described, of the first inputs."""
        law = self._laws.get(form)
        if law is None:
            law = compiled(lambda u, x: self.describe(u, x, form), inputs, self.START)
            self._laws[form] = law
        return law(u, state)
