"""Shared parts of the guidance holds: loops from altitude to elevator, and the protection."""

from __future__ import annotations

from .._core.docstrings import filler
from ..control.controller import FLYING, SECTIONS, Hold
from ..control.gain_tables import loop_gains
from ..control.gains import AltitudeGains, AttitudeGains, EnvelopeLimits
from ..control.loops import attitude_loop
from .climb_loops import AltitudeLoop
from .protection import Allowed, Protection
from .vertical import Vertical

FAR_BELOW = 0.5  # fraction of the minimum airspeed; a command below it is probably a mistake

# docstring sections shared by these holds
fill = filler(
    **SECTIONS,
    alpha_max="""
    alpha_max : float, optional
        maximum angle of attack in deg, with ``alpha`` connected; default is the gain table's
    """,
    climb="""
    theta_min : float
        minimum pitch reference in deg
    theta_max : float, optional
        maximum pitch reference in deg; default is the gain table's
    authority : float or pair
        maximum elevator increment, of full travel
    """,
    level="""
    h, hdot
        altitude in ft, rate of climb in ft/s
    theta, q
        pitch angle in deg, pitch rate in deg/s
    """,
)


class GuidedHold(Hold):
    """Base of the holds with a protection: altitude, climbs and landings."""

    def altitude_loop(self, gains: AltitudeGains) -> AltitudeLoop:
        """The altitude loop; its limits are checked at every point of a schedule."""
        T, c = self.clock.period, self._checked
        limits = getattr(c, "hdot_max", None), c.theta_min, c.theta_max
        # theta_max depends on the point: a wrong theta_min must not be reported only in flight
        for point in self._schedule.points if self._schedule else ():
            AltitudeLoop(T, loop_gains(point.gains, "altitude")[0], *limits)
        return AltitudeLoop(T, gains, *limits)

    def vertical_loops(
        self, altitude: AltitudeGains, pitch: AttitudeGains, envelope: EnvelopeLimits | None
    ) -> Vertical:
        """The loops from altitude to elevator, registered to follow a schedule."""
        T, authority = self.clock.period, self._checked.authority
        vertical = Vertical(
            self.altitude_loop(altitude),
            attitude_loop(T, pitch, authority, -1.0, self.scheduled),
            self.protection_within(envelope),
        )
        self.follows(**vertical.loops)
        return vertical

    def protection_within(self, envelope: EnvelopeLimits | None) -> Protection | None:
        """The protection; None without a maximum angle of attack."""
        alpha_max = self._checked.alpha_max
        if alpha_max is None and envelope is None:
            return None
        return Protection(self.clock.period, alpha_max, envelope)

    def airspeed_within(self, bounds: Allowed, target: float, vc: float) -> float:
        """The target airspeed in kt within the limits; warns if it is far below the minimum."""
        minimum = bounds.vc_min
        # without a command the target is the present airspeed, which may itself be too low
        if minimum >= FLYING and target < min(FAR_BELOW * minimum, 0.9 * vc):
            self._warn_once(
                "vc_ref",
                "vc_ref commands {:.0f} kt, far below the minimum airspeed of this flight, "
                "{:.0f} kt, which is flown instead",
                *(target, minimum),
            )
        return max(min(target, bounds.vc_max), minimum)
