"""What the controller blocks share: references, schedules, and sections of their pages."""

from __future__ import annotations

import copy
from collections.abc import Hashable
from typing import Any

from .._core.callers import warn_user
from .._core.checks import must_be, number, one_of
from .._core.docstrings import filler
from .._core.pathsim_internals import port_names
from .described import DescribedLaw, as_described
from .gain_tables import loop_gains, schedule_of
from .gains import AltitudeGains, EnvelopeLimits
from .loops import AltitudeLoop, HeadingLoop, Reference, SpeedOnPitchLoop, attitude_loop
from .protection import Protection

# largest increment, or lower and upper
Authority = float | tuple[float, float]

# ft and kt; below these an increment may well be larger than the measured value
LEAST_ALTITUDE, LEAST_AIRSPEED = 1000.0, 30.0

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
    bank="""
    bank_max : float
        largest bank reference in deg
    authority : float or pair
        largest aileron increment, of full travel
    """,
    climb="""
    theta_min : float
        lowest pitch reference in deg
    theta_max : float, optional
        highest pitch reference in deg; default is the gain table's
    authority : float or pair
        largest elevator increment, of full travel
    """,
    level="""
    h, hdot
        altitude in ft, rate of climb in ft/s
    theta, q
        pitch angle in deg, pitch rate in deg/s
    """,
    capture="""
    h_ref : float, optional
        altitude to capture, ft; default: none, or with a port that is not 0 so much above the
        altitude at engagement
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
    climbing="""
    hdot_cmd
        rate of climb demanded, ft/s
    captured
        1 from the capture of the altitude on, otherwise 0
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
            must_be(parameter, value, "one number or a lower and an upper limit")
        return number(parameter, value[0], high=0.0), number(parameter, value[1], low=0.0)
    most = number(parameter, value, low=0.0)
    return -most, most


def reference_kind(parameter: str, value: Any) -> str:
    """What a wired reference port is."""
    return one_of(parameter, value, ("increment", "absolute"))


class Hold(DescribedLaw):
    """Base of the holds: references by increment or absolute, and gains over the airspeed.

    A port that asks by increment for more than the measured value, as 5500 on ``h_ref`` at 5000 ft
    does, is warned of once: it is meant to be absolute.

    `build` fills ``loops``, by the names of a gain table: loops with a method ``retune``, which
    takes the gains of a schedule as signals.
    """

    reference = "increment"
    _warned_of_increment = False

    def configure(self) -> None:
        self.loops: dict[str, Any] = {}
        super().configure()
        ports = self.input_port_labels or {}
        self._alpha = ports.get("alpha")
        self._formed = self._alpha is not None or self.reference == "absolute"
        # where the airspeed and the altitude that choose the gains come in
        self._vc, self._h = ports.get("vc", 0), ports.get("h")
        increments = ("h_ref", "h", LEAST_ALTITUDE, "ft"), ("vc_ref", "vc", LEAST_AIRSPEED, "kt")
        self._increments = [
            (ports[port], ports[measured], least, port, unit)
            for port, measured, least, unit in increments
            if port in ports and self.reference == "increment" and not self._warned_of_increment
        ]

    def gains_of(self, *names: str) -> tuple[Any, ...]:
        """Gains of the loops, at the nominal point of a schedule."""
        self._schedule = schedule_of(self.gains)
        return loop_gains(self.gains, *names)

    @property
    def scheduled(self) -> bool:
        """Whether gains follow the airspeed."""
        return self._schedule is not None

    def altitude_loop(self, gains: AltitudeGains) -> AltitudeLoop:
        """The altitude loop; its limits are checked at every point of a schedule."""
        T, c = self.clock.period, self.checked
        limits = getattr(c, "hdot_max", None), c.theta_min, c.theta_max
        for point in self._schedule.points if self._schedule else ():
            AltitudeLoop(T, point.gains.altitude, *limits)
        return AltitudeLoop(T, gains, *limits)

    def vertical_loops(self, *speed: str) -> dict[str, Any]:
        """The loops from the altitude, and with "speed" the airspeed, to the elevator."""
        altitude, pitch, envelope, *others = self.gains_of("altitude", "pitch", "envelope", *speed)
        T, level = self.clock.period, self.altitude_loop(altitude)
        loops = {
            "altitude": level,
            "pitch": attitude_loop(T, pitch, self.checked.authority, -1.0, self.scheduled),
            "envelope": self.protection_within(envelope),
        }
        for gains in others:
            loops["climb"] = SpeedOnPitchLoop(T, gains.ramp, level.pid)
        return loops

    def lateral_loops(self) -> dict[str, Any]:
        """The loops from the heading to the bank, and from there to the ailerons."""
        T, c = self.clock.period, self.checked
        heading, roll = self.gains_of("heading", "roll")
        return {
            "heading": HeadingLoop(T, heading, c.bank_max),
            "roll": attitude_loop(T, roll, c.authority, carry=self.scheduled),
        }

    def protection_within(self, envelope: EnvelopeLimits | None) -> Protection | None:
        """The protection from the stall; None without an angle of attack to keep."""
        own = self.checked.alpha_max
        if own is None and envelope is None:
            return None
        return Protection(self.clock.period, own, envelope)

    def wanted(self, port: str, value: float) -> Reference:
        """Reference from the value at a port, which may be absolute."""
        if self.reference == "absolute" and port_names(self.inputs)[port] in self.inputs.wired:
            return Reference(value)
        return Reference(getattr(self.checked, port), value)

    @as_described
    def law(self, u: list[float], state: tuple[Any, ...]) -> tuple[list[float], tuple[Any, ...]]:
        for port, measured, least, name, unit in self._increments:
            if u[port] > u[measured] >= least:
                self._warn_of_increment(name, u[port], u[measured], unit)
        form = self.form(u) if self._formed else None
        if self._schedule is None:
            return self.flown(u, state, form, self._inputs)
        h = None if self._h is None else u[self._h]
        u = [*u[: self._inputs], *self.gains_at(u[self._vc], h)]
        return self.flown(u, state, form, len(u))

    def form(self, u: list[float]) -> Hashable:
        """What decides on the law beside parameters.

        Which absolute references are wired, and whether there is an angle of attack to protect.
        """
        wired = len(self.inputs.wired) if self.reference == "absolute" else None
        return wired, self._alpha is not None and u[self._alpha] != 0.0

    def gains_at(self, vc: float, h: float | None = None) -> list[float]:
        """The gains of a schedule at an airspeed and altitude, loop by loop; none without one."""
        return self._schedule.row(vc, h) if self._schedule else []

    def follow(self, gains: list[Any]) -> None:
        """Let the loops have the gains of `gains_at`."""
        for name, start, end in self._schedule.columns if self._schedule else ():
            if self.loops.get(name) is not None:
                self.loops[name].retune(*gains[start:end])

    def describe(self, u: list[Any], state: Any, form: Any) -> tuple[list[Any], Any]:
        size = self._schedule.columns[-1][2] if self._schedule else 0
        loops, self.loops = self.loops, copy.deepcopy(self.loops)
        try:
            self.follow(u[len(u) - size :])
            return self.channels(u[: len(u) - size], state, form)
        finally:
            self.loops = loops

    def channels(self, u: list[Any], state: Any, form: Any) -> tuple[list[Any], Any]:
        """The law as of `describe`, with the loops as they are."""
        raise NotImplementedError

    def _warn_of_increment(self, port: str, value: float, measured: float, unit: str) -> None:
        """Warn once of an increment that is larger than the measured value."""
        self._warned_of_increment, self._increments = True, []
        warn_user(
            f"{type(self).__name__}: {value:g} {unit} at {port} is an increment and asks for "
            f"{measured + value:.0f} {unit}; reference='absolute' makes the port the reference "
            "itself"
        )
