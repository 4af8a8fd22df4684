"""`AltitudeHold`: the altitude, held with the elevator."""

from __future__ import annotations

from dataclasses import dataclass

from .._core.checks import number, optional, positive
from .._core.parameters import parameter
from .._core.ports import numbered
from ..control.controller import Authority, ReferenceKind, authority_limits, reference_kind
from ..control.gains import Gains
from .hold import GuidedHold, fill
from .vertical import Motion, Vertical, VerticalState

__all__ = ["AltitudeHold"]


@fill
@dataclass(eq=False, repr=False)
class AltitudeHold(GuidedHold):
    """Holds the altitude with the elevator, through rate-of-climb and pitch loops.

    .. math::
        \\dot h_\\mathrm{cmd} &= K_h (h_\\mathrm{ref} - h), \\quad
        |\\dot h_\\mathrm{cmd}| \\le \\dot h_\\mathrm{max} \\\\
        \\theta_\\mathrm{cmd} &= K_p (\\dot h_\\mathrm{cmd} - \\dot h)
        + K_i \\int (\\dot h_\\mathrm{cmd} - \\dot h) \\, dt

    with the pitch loop of ``PitchHold`` inside, sampled at T. It flies climbs and descents with the
    elevator alone: add an ``AirspeedHold`` for the airspeed. With ``alpha`` connected the angle of
    attack stays below its maximum, and with ``vc`` the airspeed above its minimum: a climb that the
    thrust cannot sustain is reduced or becomes a descent. Without these connections the aircraft
    may climb into a stall.

    Parameters
    ----------
    gains : str or dict
        name of a gain table ("c172p"), or {"altitude": ..., "pitch": ...}, each either the name
        of a table or numbers; altitude: Kh (1/s), Kp (deg/(ft/s)), Ki (deg/ft), hdot_max (ft/s),
        theta_max (deg); pitch: as in ``PitchHold``
    h_ref : float, optional
        altitude to hold in ft; default: the value at engagement
    hdot_max : float, optional
        maximum commanded rate of climb and descent, ft/s; default is the gain table's
    %(climb)s
    %(T)s
    %(reference)s
    %(alpha_max)s

    Inputs
    ------
    %(level)s
    h_ref
        ft, added to the parameter
    %(elev_off)s
    vc
        calibrated airspeed in kt, for gains that depend on it, and for the protection; if not
        connected (0), the gains are those of the table's nominal point, and the protection limits
        neither the airspeed nor the load factor
    alpha
        angle of attack in deg; if not connected (0), there is no stall protection

    Outputs
    -------
    %(elevator)s
    hdot_cmd
        commanded rate of climb, ft/s

    %(raises)s
    """

    gains: Gains = "c172p"
    h_ref: float | None = parameter(None, optional, low=-2000.0, high=1e6)
    hdot_max: float | None = parameter(None, optional, above=0.0)
    theta_min: float = parameter(-10.0, number, low=-90.0, high=90.0)
    theta_max: float | None = parameter(None, optional, low=-90.0, high=90.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: ReferenceKind = parameter("increment", reference_kind)
    alpha_max: float | None = parameter(None, optional, above=0.0, high=90.0)

    measured = ("h", "hdot", "theta", "q")
    commands = {"elevator": "off"}
    input_port_labels = numbered("h hdot theta q h_ref off elev_sat vc alpha")
    output_port_labels = {"elevator": 0, "theta_cmd": 1, "hdot_cmd": 2}

    START = Vertical.START

    def build(self) -> None:
        self.vertical = self.vertical_loops(*self.gains_of("altitude", "pitch", "envelope"))

    def law(self, u: list[float], state: VerticalState) -> tuple[list[float], VerticalState]:
        h, hdot, theta, q, h_ref, off, elev_sat, vc, alpha = u[:9]
        self.retune(vc, h)
        vertical, idle = self.vertical, off != 0.0
        motion = Motion(theta, q, h, hdot, vc, self.sensed("alpha", alpha), idle, elev_sat)
        bounds, guard = vertical.guard(state, motion, vc, full_throttle=True)
        reference = self.wanted("h_ref", h_ref, h)
        target, hdot_cmd, altitude, _ = vertical.for_climb(
            state, motion, bounds, reference=reference, idle=idle
        )
        elevator, theta_cmd, pitch, cut = vertical.fly(state, motion, bounds, target)
        return [elevator, theta_cmd, hdot_cmd], VerticalState(altitude, pitch, guard, cut)
