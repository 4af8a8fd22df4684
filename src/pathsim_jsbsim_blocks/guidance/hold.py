"""What the holds of guidance share: loops from the altitude to the elevator, and the protection."""

from __future__ import annotations

from .._core.docstrings import filler
from ..control.controller import FLYING, SECTIONS, Hold
from ..control.gain_tables import loop_gains
from ..control.gains import AltitudeGains, AttitudeGains, EnvelopeLimits
from ..control.loops import attitude_loop
from .climb_loops import AltitudeLoop
from .protection import Allowed, Protection
from .vertical import Vertical

FAR_BELOW = 0.5  # of the lowest airspeed, a demand that must be meant otherwise

# docstring sections shared by these holds
fill = filler(
    **SECTIONS,
    alpha_max="""
    alpha_max : float, optional
        largest angle of attack in deg, with the port ``alpha`` wired; default is the gain table's
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
    climbing="""
    hdot_cmd
        rate of climb demanded, ft/s
    captured
        1 from the capture of the altitude on, otherwise 0
    """,
)


class GuidedHold(Hold):
    """Base of the holds with a protection: of the altitude, of climbs, and of landings."""

    def altitude_loop(self, gains: AltitudeGains) -> AltitudeLoop:
        """The altitude loop; its limits are checked at every point of a schedule."""
        T, c = self.clock.period, self._checked
        limits = getattr(c, "hdot_max", None), c.theta_min, c.theta_max
        for point in self._schedule.points if self._schedule else ():
            AltitudeLoop(T, loop_gains(point.gains, "altitude")[0], *limits)
        return AltitudeLoop(T, gains, *limits)

    def vertical_loops(
        self, altitude: AltitudeGains, pitch: AttitudeGains, envelope: EnvelopeLimits | None
    ) -> Vertical:
        """The loops from the altitude to the elevator; they follow a schedule."""
        T, authority = self.clock.period, self._checked.authority
        vertical = Vertical(
            self.altitude_loop(altitude),
            attitude_loop(T, pitch, authority, -1.0, self.scheduled),
            self.protection_within(envelope),
        )
        self.follows(**vertical.loops)
        return vertical

    def protection_within(self, envelope: EnvelopeLimits | None) -> Protection | None:
        """The protection from the stall; None without an angle of attack to keep."""
        own = self._checked.alpha_max
        if own is None and envelope is None:
            return None
        return Protection(self.clock.period, own, envelope)

    def airspeed_within(self, allowed: Allowed, wanted: float, vc: float) -> float:
        """The airspeed wanted in kt, within the limits; one far below the lowest is warned of."""
        lowest = allowed.vc_min
        # below 0.9 of the present one: without a demand the two are the same
        if lowest >= FLYING and wanted < min(FAR_BELOW * lowest, 0.9 * vc):
            self._warn_once(
                "vc_ref",
                "vc_ref asks for {:.0f} kt, far below the lowest airspeed of this flight, "
                "{:.0f} kt, which is flown instead",
                *(wanted, lowest),
            )
        return max(min(wanted, allowed.vc_max), lowest)
