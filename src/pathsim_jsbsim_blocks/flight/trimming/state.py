"""The trimmed state: `TrimState`, and how it is read from an airframe."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from ..._core.aircraft_ports import ALMOST_NORTH, OUTPUTS, SURFACES, property_of, throttles
from ..._core.extras import required
from ..airframe import Airframe
from .condition import TrimCondition

if TYPE_CHECKING:
    import pandas


class Drift(NamedTuple):
    """How far an aircraft is from its trim after a flight of ``duration`` s with controls fixed.

    ``height`` is in ft above the trimmed path, ``speed`` in kt calibrated above the trimmed one,
    ``bank`` in deg to the right of the trimmed one.
    """

    duration: float
    height: float
    speed: float
    bank: float

    @property
    def steady(self) -> bool:
        """Whether it is within 20 ft, 6 kt and 10 deg."""
        return abs(self.height) <= 20.0 and abs(self.speed) <= 6.0 and abs(self.bank) <= 10.0

    def __str__(self) -> str:
        return (
            f"{'steady' if self.steady else 'not steady'}: after {self.duration:g} s with controls "
            f"fixed {self.height:+.2f} ft, {self.speed:+.2f} kt, {self.bank:+.2f} deg of bank"
        )


# units of the fields of a condition and of a state, in the column order of study tables
UNITS = {
    "altitude": "ft",
    "speed": "KCAS",
    "mach": "",
    "tas": "ft/s",
    **dict.fromkeys(("gamma", "alpha", "beta", "theta", "phi", "psi"), "deg"),
    "throttle": "norm",
    "thrust": "lbf",
    "pitch_trim": "norm",
    "elevator_rad": "rad",
    "elevator_norm": "norm",
    **dict.fromkeys(("elevator", "aileron", "rudder"), "cmd norm"),
    **dict.fromkeys(("udot", "vdot", "wdot"), "ft/s2"),
    **dict.fromkeys(("pdot", "qdot", "rdot"), "rad/s2"),
    "weight": "lb",
    **dict.fromkeys(("cg_x", "cg_y", "cg_z", "empty_cg_x"), "in"),
    **dict.fromkeys(("heading", "bank", "alpha_min", "alpha_max"), "deg"),
    "load_factor": "g",
    "mode": "",
    "gear": "norm",
    "flaps": "norm",
    **dict.fromkeys(("wind_north", "wind_east"), "ft/s"),
    "payload": "lb",
    "fuel": "lb",
    "engines_off": "",
    **dict.fromkeys(("latitude", "longitude"), "deg"),
    **dict.fromkeys(("p", "q", "r"), "deg/s"),
    **dict.fromkeys(("nz", "ny"), "g"),
}


def _read(name: str) -> Any:
    """A field with the value of an aircraft's output, or of a property."""
    return dataclasses.field(metadata={"property": property_of(name)})


@dataclass(frozen=True, kw_only=True)
class TrimState:
    """The trimmed state, with its residuals.

    Attributes
    ----------
    aircraft : str
        the model's name
    condition : TrimCondition
        the requested condition
    altitude, speed, mach, tas : float
        ft above mean sea level, KCAS, Mach number, true airspeed in ft/s
    alpha, beta, theta, phi, psi, gamma : float
        deg; psi is in [0, 360)
    throttle : tuple[float, ...]
        throttle command of each engine, 0 to 1
    thrust : float
        lbf, sum of the engines
    pitch_trim, elevator, aileron, rudder : float
        commands, -1 to 1; the trim uses the pitch trim for pitch, elevator stays 0 (but the Newton
        search uses it if a model has no pitch trim)
    elevator_rad, elevator_norm : float
        position of the elevator in rad and as a fraction of its travel (0 if the model has none)
    udot, vdot, wdot : float
        residual body accelerations in ft/s2
    pdot, qdot, rdot : float
        residual angular accelerations in rad/s2
    weight : float
        lb
    cg_x, cg_y, cg_z : float
        centre of gravity in inches, structural axes
    p, q, r : float
        body rates in deg/s
    nz, ny : float
        load factors in g: nz is +1 in level flight; ny is the side load, positive to the right,
        and not 0 in a turn without sideslip
    gear, flaps : float
        positions, 0 (up) to 1 (down)
    free : tuple[str, ...]
        the unknowns of the search; the other quantities were fixed
    drift : Drift or None
        deviation from the trim after a flight with controls fixed, if `trim` has flown one
    """

    aircraft: str
    condition: TrimCondition
    altitude: float = _read("h")
    speed: float = _read("vc")
    mach: float = _read("mach")
    tas: float = _read("vt")
    alpha: float = _read("alpha")
    beta: float = _read("beta")
    theta: float = _read("theta")
    phi: float = _read("phi")
    psi: float = _read("psi")
    gamma: float = _read("gamma")
    throttle: tuple[float, ...]
    thrust: float
    pitch_trim: float = _read("fcs/pitch-trim-cmd-norm")
    elevator: float = _read(SURFACES["elevator"])
    aileron: float = _read(SURFACES["aileron"])
    rudder: float = _read(SURFACES["rudder"])
    elevator_rad: float = _read("fcs/elevator-pos-rad")
    elevator_norm: float = _read("fcs/elevator-pos-norm")
    udot: float = _read("accelerations/udot-ft_sec2")
    vdot: float = _read("accelerations/vdot-ft_sec2")
    wdot: float = _read("accelerations/wdot-ft_sec2")
    pdot: float = _read("accelerations/pdot-rad_sec2")
    qdot: float = _read("accelerations/qdot-rad_sec2")
    rdot: float = _read("accelerations/rdot-rad_sec2")
    weight: float = _read("inertia/weight-lbs")
    cg_x: float = _read("inertia/cg-x-in")
    cg_y: float = _read("inertia/cg-y-in")
    cg_z: float = _read("inertia/cg-z-in")
    p: float
    q: float
    r: float
    nz: float = _read("nz")
    ny: float = _read("accelerations/Ny")
    gear: float = _read("gear")
    flaps: float = _read("flaps")
    free: tuple[str, ...]
    drift: Drift | None = None

    def __str__(self) -> str:
        """The state as a table: name, value and unit in each line."""
        rows: dict[str, Any] = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        units = UNITS
        if math.isfinite(self.turn_radius):
            rows |= {"turn_rate": self.turn_rate, "turn_radius": self.turn_radius}
            units = {**UNITS, "turn_rate": "deg/s", "turn_radius": "ft"}
        lines = [f"{self.aircraft}: {self.condition}"]
        for name, value in rows.items():
            values = value if isinstance(value, tuple) else (value,)
            if name in units and values:
                # adding 0 turns -0.0 into 0.0
                digits = [round(x, 6) + 0.0 for x in values]
                numbers = "".join(f"{x % 360.0 if name == 'psi' else x:14.6f}" for x in digits)
                degrees = f" ({math.degrees(value):.4f} deg)" if units[name] == "rad" else ""
                lines.append(f"  {name:<13}{numbers} {units[name]}{degrees}".rstrip())
        if self.free:
            lines.append(f"  {'free':<13} {', '.join(self.free)}")
        if self.drift is not None:
            lines.append(f"  {self.drift}")
        return "\n".join(lines)

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """The table, for the last line of a cell in IPython and Jupyter."""
        printer.text(str(self))

    def to_dict(self) -> dict[str, float]:
        """The state's numbers by name; those of each engine as ``throttle[0]``."""
        numbers: dict[str, float] = {}
        for name in (n for n in UNITS if n in vars(self)):
            value = getattr(self, name)
            if isinstance(value, tuple):
                numbers |= {f"{name}[{i}]": x for i, x in enumerate(value)}
            else:
                numbers[name] = value
        return numbers

    def to_frame(self) -> pandas.DataFrame:
        """The state as a pandas table: value and unit by name.

        Raises
        ------
        MissingExtraError
            without pandas
        """
        pandas = required("pandas", "tracks")
        numbers = self.to_dict()
        units = [UNITS[name.partition("[")[0]] for name in numbers]
        return pandas.DataFrame({"value": numbers.values(), "unit": units}, index=list(numbers))

    @property
    def steady(self) -> bool | None:
        """Whether the drift is within 20 ft, 6 kt and 10 deg; None without a drift."""
        return None if self.drift is None else self.drift.steady

    @property
    def turn_rate(self) -> float:
        """Rate of change of the heading in deg/s, right positive."""
        phi, theta = math.radians(self.phi), math.radians(self.theta)
        return (self.q * math.sin(phi) + self.r * math.cos(phi)) / math.cos(theta)

    @property
    def turn_radius(self) -> float:
        """Radius of the turn through the air in ft; infinite in straight flight."""
        rate = abs(math.radians(self.turn_rate))
        return self.tas * math.cos(math.radians(self.gamma)) / rate if rate > 1e-6 else math.inf


# field: property
STATE: dict[str, str] = {
    f.name: f.metadata["property"] for f in dataclasses.fields(TrimState) if f.metadata
}

_NUMBERS = [f.name for f in dataclasses.fields(TrimState) if f.name in UNITS]


def read_state(
    airframe: Airframe, condition: TrimCondition, free: tuple[str, ...] = ()
) -> TrimState:
    """Current state of an initialised airframe; ``free`` are the unknowns of the search."""
    fdm = airframe.fdm
    fields: dict[str, Any] = {name: fdm[source] for name, source in STATE.items()}
    fields |= {rate: OUTPUTS[rate].factor * fdm[property_of(rate)] for rate in "pqr"}
    if fields["psi"] > ALMOST_NORTH:
        fields["psi"] = 0.0
    thrusts = [fdm[name] for name in airframe.of_engines("thrust-lbs")]
    return TrimState(
        aircraft=airframe.aircraft,
        condition=condition,
        throttle=tuple(fdm[name] for name in throttles(airframe.engines)),
        # fsum refuses infinities of both signs
        thrust=math.fsum(thrusts) if all(map(math.isfinite, thrusts)) else math.nan,
        free=free,
        **fields,
    )


def not_finite(state: TrimState) -> list[str]:
    """Names of the fields of a state that are not finite."""
    fields = [(name, getattr(state, name)) for name in _NUMBERS]
    rows = [(name, x if isinstance(x, tuple) else (x,)) for name, x in fields]
    return [name for name, values in rows if not all(map(math.isfinite, values))]
