"""Shared parts of the controller blocks: references, schedules, and sections of docstrings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Literal

from .._core.callers import warn_user
from .._core.checks import must_be, number, one_of
from .._core.docstrings import filler
from .._core.pathsim_internals import values
from .._core.sampling import SampledLaw
from .gain_tables import loop_gains, named, schedule_of
from .loops import HeadingLoop, Reference, ReferenceLoop, attitude_loop

# meaning of a connected reference port
ReferenceKind = Literal["increment", "absolute"]

# maximum increment in both directions, or lower and upper limit
Authority = float | tuple[float, float]

_TRAVEL = 2.0  # from stop to stop, of a command in -1 to 1

FLYING = 30.0  # kt, minimum airspeed of a flight

# increments above this fraction of the measured value are taken for absolute values by mistake, if
# the measured value is at least the second number
MEANT_ABSOLUTE = {"h_ref": (0.8, 1000.0, "ft"), "vc_ref": (0.5, FLYING, "kt")}

# docstring sections shared by the holds
SECTIONS = dict(
    T="""
    T : float
        sample period in s; a new one acts at the next reset
    """,
    reference="""
    reference : str
        meaning of a connected reference port: "increment", added to the parameter or to the value
        at engagement (0 changes nothing), or "absolute", the reference itself
    """,
    bank="""
    bank_max : float
        maximum bank reference in deg
    authority : float or pair
        maximum aileron increment, of full travel
    """,
    elev_off="""
    off
        0 engaged; otherwise the elevator is frozen
    elev_sat
        ``Aircraft`` output of that name, for anti-windup at the end of travel
    """,
    elevator="""
    elevator
        increment of the elevator command; positive is nose **down**
    theta_cmd
        pitch reference on its ramp, deg
    """,
    ail_off="""
    off
        0 engaged; otherwise the ailerons are frozen
    ail_sat
        ``Aircraft`` output of that name, for anti-windup at the end of travel
    """,
    aileron="""
    aileron
        increment of the aileron command; positive rolls right
    phi_cmd
        bank reference on its ramp, deg
    """,
    vc="""
    vc
        calibrated airspeed in kt, for gains that depend on it; if not connected (0), the gains are
        those of the table's nominal point
    """,
    raises="""
    Raises
    ------
    ParameterError
        for an unknown gain table or gain, naming the nearest, and for invalid numbers
    FileError
        for a gain table's file that cannot be read
    """,
)
fill = filler(**SECTIONS)


def authority_limits(parameter: str, value: Any) -> tuple[float, float]:
    """Lower and upper limit of an actuator increment, from one number or a pair."""
    if isinstance(value, (list, tuple)):
        if len(value) != 2:
            must_be(parameter, value, "one number or a lower and an upper limit")
        low = number(parameter, value[0], low=-_TRAVEL, high=0.0)
        high = number(parameter, value[1], low=0.0, high=_TRAVEL)
        if low == high:
            must_be(parameter, value, "limits that are not both 0")
        return low, high
    most = number(parameter, value, above=0.0, high=_TRAVEL)
    return -most, most


def reference_kind(parameter: str, value: Any) -> str:
    """Check the meaning of a connected reference port."""
    return one_of(parameter, value, ("increment", "absolute"))


class Hold(SampledLaw):
    """Base of the holds: incremental or absolute references, and scheduled gains.

    A subclass has its initial state as ``START``. `build` makes its loops, and passes those that
    follow a gain schedule to `follows`; `law` calls `retune` before it uses them.

    A warning is given once for an increment close to the measured value, such as 4500 on ``h_ref``
    at 5000 ft: it is probably meant as an absolute value.
    """

    START: ClassVar[Any]
    gains: Any
    reference: ReferenceKind = "increment"
    _warned_of: frozenset[str] = frozenset()  # ports and parameters
    # aircraft of the gains, if they name any
    tuned_for: Sequence[str] = ()

    def initial_state(self) -> Any:
        return self.START

    def _act(self, t: float) -> tuple[int, Any, Any]:
        index, y, state = super()._act(t)
        # a limit that is NaN would limit nothing
        is_nan = math.isnan(sum(values(self.inputs)))
        return index, [math.nan] * len(y) if is_nan else y, state

    def gains_of(self, *names: str) -> tuple[Any, ...]:
        """Gains of the loops; of a schedule those of the nominal point."""
        self._schedule = schedule_of(self.gains)
        gains = loop_gains(self.gains, *names)
        parts = self.gains.values() if isinstance(self.gains, Mapping) else [self.gains]
        self.tuned_for = sorted({table.aircraft for table in map(named, parts) if table})
        return gains

    @property
    def scheduled(self) -> bool:
        """Whether gains depend on the airspeed."""
        return self._schedule is not None

    def follows(self, **loops: Any) -> None:
        """Register loops that follow a schedule, by their names in it; None for an absent loop."""
        self._following = {name: loop for name, loop in loops.items() if loop is not None}
        # airspeed and altitude of the current gains; a list, changed in place at each sample
        self._tuned_for: list[float | None] = []

    def retune(self, vc: float, h: float | None = None) -> None:
        """Set the loops' gains from the schedule at an airspeed (kt) and altitude (ft).

        Without an altitude they are those at the nominal altitude, without an airspeed (0) those of
        the nominal point.
        """
        if self._schedule is None or self._tuned_for == [vc, h]:
            return
        place = self._schedule.place(vc, h)
        for name, loop in self._following.items():
            loop.retune(self._schedule.gains_at(name, place))
        self._tuned_for[:] = vc, h

    def lateral_loops(self) -> tuple[HeadingLoop, ReferenceLoop]:
        """The loops from heading to bank, and from bank to the ailerons."""
        T, c = self.clock.period, self._checked
        heading, roll = self.gains_of("heading", "roll")
        loops = (
            HeadingLoop(T, heading, c.bank_max),
            attitude_loop(T, roll, c.authority, carry=self.scheduled),
        )
        self.follows(heading=loops[0], roll=loops[1])
        return loops

    def wanted(self, port: str, value: float, measured: float = 0.0) -> Reference:
        """Reference from the value at a port, which may be absolute."""
        if self.reference == "absolute" and port in self.inputs.wired:
            return value, 0.0
        if value > 0.0 and port in MEANT_ABSOLUTE:
            share, least, unit = MEANT_ABSOLUTE[port]
            if measured >= least and value >= share * measured:
                self._warn_once(
                    port,
                    "{:g} {} at {} is an increment and commands {:.0f} {}; with "
                    "reference='absolute' the port is the reference itself",
                    *(value, unit, port, measured + value, unit),
                )
        return getattr(self._checked, port), value

    def sensed(self, port: str, value: float) -> float | None:
        """The value at a port, or None if it is not connected: only a wire can measure 0."""
        return value if value != 0.0 or port in self.inputs.wired else None

    def _warn_once(self, about: str, text: str, *values: Any) -> None:
        # called at each sample, so format the text only for a new warning
        if about not in self._warned_of:
            self._warned_of |= {about}
            warn_user(f"{type(self).__name__}: {text.format(*values)}")
