"""What the controller blocks share: references, schedules, and sections of their pages."""

from __future__ import annotations

from typing import Any

from .._core._pathsim import port_names
from .._core.callers import warn_user
from .._core.checks import number, one_of
from .._core.docs import filler
from .._core.tunable import TunableLaw
from ..errors import ParameterError
from .gains import AltitudeGains, EnvelopeLimits, loop_gains, schedule_of
from .loops import AltitudeLoop, ReferenceLoop, ScheduledLoop
from .protection import UNPROTECTED, Protection, Unprotected

# largest increment, or lower and upper
Authority = float | tuple[float, float]

# ft and kt; from these on an increment that is larger than the measured value is doubted
LOW, SLOW = 1000.0, 30.0

# docstring sections shared by the holds
fill = filler(
    T="""
    T : float
        sample period in s
    """,
    reference="""
    reference : str
        what a wired reference port is: "increment", added to the parameter or to the value found
        at engagement (0 changes nothing), or "absolute", the reference itself
    """,
    alpha_max="""
    alpha_max : float, optional
        largest angle of attack in deg, with the port ``alpha`` wired; default is the gain table's
    """,
    vc="""
    vc
        calibrated airspeed in kt, for gains that depend on it; without a wire (0) the gains are
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


def authority_limits(parameter: str, value: Any) -> tuple[float, float]:
    """Lower and upper limit of an actuator increment, from one number or from both."""
    if isinstance(value, (list, tuple)):
        if len(value) != 2:
            raise ParameterError(
                f"{parameter} must be one number or a lower and an upper limit, not {value!r}",
                parameter=parameter,
                value=value,
            )
        return number(parameter, value[0], high=0.0), number(parameter, value[1], low=0.0)
    most = number(parameter, value, low=0.0)
    return -most, most


def reference_kind(parameter: str, value: Any) -> str:
    """What a wired reference port is."""
    return one_of(parameter, value, ("increment", "absolute"))


class Hold(TunableLaw):
    """Base of the holds: references by increment or absolute, and gains over the airspeed.

    A port that asks by increment for more than the measured value, as 5500 on ``h_ref`` at 5000 ft
    does, is warned of once: it is meant to be absolute.
    """

    reference = "increment"
    _doubted = False
    _protection: Protection | None = None

    def gains_of(self, *loops: str) -> tuple[Any, ...]:
        """Gains of the loops, at the nominal point of a schedule."""
        self._schedule = schedule_of(self.gains)
        self._loop = ReferenceLoop if self._schedule is None else ScheduledLoop
        self._absolute = self.reference == "absolute"
        return loop_gains(self.gains, *loops)

    def altitude_loop(
        self,
        gains: AltitudeGains,
        hdot_max: float | None,
        theta_min: float,
        theta_max: float | None,
    ) -> AltitudeLoop:
        """The altitude loop; its limits are checked at every point of a schedule."""
        T, points = self.clock.period, self._schedule.points if self._schedule else ()
        for point in points:
            AltitudeLoop(T, point.gains.altitude, hdot_max, theta_min, theta_max)
        return AltitudeLoop(T, gains, hdot_max, theta_min, theta_max)

    def target(self, port: str, value: float, parameter: float | None) -> tuple[Any, float]:
        """Reference and increment from the value at a port, which may be absolute."""
        if self._absolute and port_names(self.inputs)[port] in self.inputs.wired:
            return value, 0.0
        return parameter, value

    def protection(self, alpha: float) -> Protection | Unprotected:
        """The protection, or one that limits nothing: without limits, or with ``alpha`` unwired."""
        return self._protection if alpha and self._protection is not None else UNPROTECTED

    def doubt(self, port: str, value: float, measured: float, unit: str) -> None:
        """Warn once of an increment that is larger than the measured value."""
        if self._absolute or self._doubted:
            return
        self._doubted = True
        warn_user(
            f"{type(self).__name__}: {value:g} {unit} at {port} is an increment and asks for "
            f"{measured + value:.0f} {unit}; reference='absolute' makes the port the reference "
            "itself"
        )

    def follow(self, vc: float, h: float | None = None, **loops: Any) -> None:
        """Let loops have the gains of the schedule at an airspeed and altitude."""
        assert self._schedule is not None
        row = self._schedule.row(vc, h)
        for loop, start, end in self._schedule.columns:
            if loops.get(loop) is not None:
                loops[loop].retune(*row[start:end])


def protection_from(
    T: float, alpha_max: float | None, envelope: EnvelopeLimits | None
) -> Protection | None:
    """The protection from the stall; None without an angle of attack to keep."""
    if alpha_max is None and envelope is None:
        return None
    return Protection(T, alpha_max, envelope)
