"""The condition of a trim: `TrimCondition`, checked on construction and immutable."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NoReturn, get_args

import numpy as np

from ..._core.checks import flag, integer, known_keywords, mapping, must_be, number, one_of, refuse
from ..._core.own import own

# JSBSim's numbers for simulation/do_simple_trim
MODES = {"longitudinal": 0, "full": 1, "ground": 2, "pull-up": 3, "turn": 5}

Mode = Literal["full", "longitudinal", "turn", "pull-up", "ground", "glide", "none"]
Solver = Literal["jsbsim", "newton"]
SOLVERS = get_args(Solver)

# ft; maximum altitude without a trim, beyond any orbit
_HIGHEST = 1e9

# bounds of the numeric fields, for `number`
_BOUNDS: Mapping[str, Mapping[str, Any]] = {
    name: bounds
    for names, bounds in (
        # US Standard Atmosphere, 1976 (84.852 km)
        ("altitude", {"low": -2000.0, "high": 278_386.0}),
        # beyond any aircraft: the Shuttle's orbit is Mach 25
        ("speed", {"low": 0.0, "high": 2000.0}),
        ("mach", {"above": 0.0, "high": 30.0}),
        ("gamma alpha_min alpha_max latitude", {"low": -90.0, "high": 90.0}),
        ("bank", {"low": -89.0, "high": 89.0}),
        ("beta", {"low": -30.0, "high": 30.0}),
        ("longitude", {"low": -180.0, "high": 360.0}),
        ("gear flaps throttle", {"low": 0.0, "high": 1.0}),
        ("heading load_factor wind_north wind_east empty_cg_x thrust", {}),
    )
    for name in names.split()
}

# unknowns that can balance the forces along the flight path
FREE = ("throttle", "gamma", "speed")


@known_keywords
@dataclass(frozen=True)
class TrimCondition:
    """The condition of a trim.

    Fields left at None are not written: ``flaps=None`` after ``flaps=1`` keeps an airframe's flaps.

    Parameters
    ----------
    altitude : float
        altitude above mean sea level in ft, geometric, up to 278,386, near the end of the standard
        atmosphere (1e9 in mode "none")
    speed : float
        calibrated airspeed in kt, up to 2000; not used if ``mach`` is given
    mach : float, optional
        Mach number instead of ``speed``, up to 30
    gamma : float
        flight path angle in deg, positive in a climb
    heading : float
        true heading in deg
    bank : float
        bank angle in deg, right wing down positive (mode "turn" only)
    mode : str
        "full" (all six accelerations), "longitudinal", "ground" (at rest on the gear, ``altitude``
        is the ground's), "pull-up", "turn", "glide" (throttle closed or no engine, ``gamma`` free
        and its value only the first guess), or "none" (initialise only: engines then start at full
        power, whatever the throttle). On the ground the aircraft is let down with brakes on until
        it rests; ``speed``, ``mach`` and ``gamma`` do not apply, and udot is not part of the trim:
        engines idle and brakes are off, so it may creep (c172p: 0.1 ft/s2)
    gear : float, optional
        landing gear, 0 up to 1 down; default is the model's own setting, which is often down even
        if the gear is retractable (737, B747): set 0 above 200 KCAS
    flaps : float, optional
        flap command, 0 to 1; default is the model's own setting
    wind_north, wind_east : float
        steady wind in ft/s, the direction it blows to; speed and path angle are relative to the
        air. JSBSim trims the velocity over the ground, which changes throughout a turn in wind,
        and its ground trim rarely converges in a crosswind
    payload : dict or list, optional
        point masses in lb: ``{index: lb}`` or a list from index 0
    fuel : dict or list, optional
        contents of the tanks in lb: ``{index: lb}`` or a list from index 0
    beta : float
        sideslip angle in deg of a steady-heading sideslip, positive with the wind from the right
        (modes "full", "longitudinal" and "glide")
    latitude, longitude : float, optional
        geodetic position in deg, north and east positive; default is the model's own (0, 0)

    Other Parameters
    ----------------
    load_factor : float
        lift over weight in g (mode "pull-up" only). It is the load factor in wind axes: at 2 the
        body's nz is 2.01 to 2.02, and a wdot of up to 1 ft/s2 remains
    alpha_min, alpha_max : float, optional
        limits of the angle of attack in deg for the trim; default is the model's own
    empty_cg_x : float, optional
        x of the empty-weight CG in inches aft, structural axes; default is the model's own
    setup : dict, optional
        further properties to write before the model is initialised; a block's own ``setup`` is
        written after these. One that has another value after the trim is refused, but for commands
        that the trim solves for. In mode "none" initial conditions given here (``ic/vd-fps``,
        ``ic/p-rad_sec``) replace those of the fields above
    throttle : float, optional
        command of every engine, 0 to 1, instead of the one that holds speed and path
    thrust : float, optional
        sum of the engines in lbf, likewise
    free : str, optional
        the unknown that balances the forces along the path: "throttle", "gamma" or "speed".
        Default is the throttle, or ``gamma`` if the throttle or the thrust is set. The condition's
        own value is then the first guess
    engines_off : list of int or "all"
        engines that do not run, from 0: jets without thrust, propellers that the wind may turn
        (feather them in ``setup``, ``fcs/feather-cmd-norm[i]``, if the model can). With one
        engine out in flight (Newton search) it finds bank, aileron and rudder at the sideslip angle
        ``beta``. Without any engine use mode "glide". In ``setup``,
        ``propulsion/engine[i]/set-running`` of 0 means the same. Electric motors and rockets are
        refused: only their throttle stops them
    solver : str, optional
        "newton" (the default in flight; `pathsim_jsbsim_blocks.flight.trim` describes it) or
        "jsbsim": JSBSim's own search, from which published numbers come; on the ground it may
        balance an aircraft on two wheels. It trims neither glides nor sideslips nor engines out
        (nor to a given throttle). It is refused in flight below 200 ft above the ground (it may end
        the process) and with constant-speed propellers (it may never end)
    coordinated : bool
        in a turn leave the sideslip free to remove the lateral acceleration, instead of a turn
        without sideslip whose rate is free (mode "turn", Newton search). Some models have no
        coordinated turn (T37)

    Raises
    ------
    ParameterError
        for values that are impossible for any aircraft
    """

    altitude: float = 5000.0
    speed: float = 100.0
    mach: float | None = None
    gamma: float = 0.0
    heading: float = 0.0
    bank: float = 0.0
    load_factor: float = 1.0
    mode: Mode = "full"
    gear: float | None = None
    flaps: float | None = None
    alpha_min: float | None = None
    alpha_max: float | None = None
    wind_north: float = 0.0
    wind_east: float = 0.0
    payload: Mapping[int, float] | list[float] | None = None
    fuel: Mapping[int, float] | list[float] | None = None
    empty_cg_x: float | None = None
    setup: Mapping[str, float] = field(default_factory=dict)
    beta: float = 0.0
    throttle: float | None = None
    thrust: float | None = None
    free: str | None = None
    latitude: float | None = None
    longitude: float | None = None
    solver: Solver | None = None
    engines_off: tuple[int, ...] | list[int] | str = ()
    coordinated: bool = False

    def __post_init__(self) -> None:
        self._put("mode", one_of("mode", self.mode, [*MODES, "glide", "none"]))
        for f in dataclasses.fields(self):
            value = getattr(self, f.name)
            bounds = _BOUNDS.get(f.name)
            is_default = value is f.default is None or (f.name == "speed" and self.mach is not None)
            if bounds is None or is_default:
                continue
            if f.name == "altitude" and self.mode == "none":
                bounds = {**bounds, "high": _HIGHEST}
            if f.name == "speed" and self.mode not in ("ground", "none"):
                bounds = {**bounds, "above": 0.0}
            self._put(f.name, number(f.name, value, **bounds))
        low, high = self.alpha_min, self.alpha_max
        if low is not None and high is not None and low >= high:
            self._refuse("alpha_min", f"must be below alpha_max={high!r} deg")
        self._put("payload", _weights("payload", self.payload))
        self._put("fuel", _weights("fuel", self.fuel))
        self._put("setup", own(mapping("setup", self.setup)))
        if not (isinstance(self.engines_off, str) and self.engines_off == "all"):
            self._put("engines_off", _indices("engines_off", self.engines_off))
        self._check_mode()
        self._check_balance()

    def _put(self, name: str, value: Any) -> None:
        # bypasses the frozen dataclass
        object.__setattr__(self, name, value)

    @classmethod
    def from_file(
        cls,
        file: str | os.PathLike[str],
        aircraft: str,
        *,
        root: str | None = None,
        create: Mapping[str, float] | str | None = None,
        **changes: Any,
    ) -> TrimCondition:
        """The condition in a JSBSim reset file (``<initialize>``, versions 1 and 2).

        A trim begins with the file's place, altitude, airspeed, path angle, heading and wind. In
        mode "none" the condition is the state in the file, but the block starts the engines;
        ``initialize`` of `JSBSimFDM` starts exactly as JSBSim does.

        Parameters
        ----------
        file : str
            path, or the name of a file beside the model ("reset00")
        aircraft : str
            name of the JSBSim model, into which JSBSim reads the file
        root, create : optional
            as of `Aircraft`
        **changes
            fields that differ. ``mode`` is by default the trim for which the file asks, or "none"

        Raises
        ------
        AircraftError, ParameterError
            if JSBSim cannot read the file, and for a state that is no condition
        """
        # loads JSBSim, which a condition does not need
        from .reset_file import reset_fields

        fields = reset_fields(file, aircraft, root, create, changes.get("mode"), MODES)
        for name in {*fields, "mach", "gamma", "bank", "latitude", "longitude"} & {*changes} - {
            "mode",
            "setup",
        }:
            if fields["mode"] == "none" and name != "engines_off":
                why = f"{name} is that of the file in mode 'none': change it by setup, or trim"
                refuse(name, changes[name], f"{why} (mode='full')")
        setup = {**fields.get("setup", {}), **mapping("setup", changes.get("setup"))}
        return cls(**{**fields, **changes, "setup": setup})

    def _refuse(self, name: str, why: str) -> NoReturn:
        value = getattr(self, name)
        refuse(name, value, f"{name}={value!r} {why}")

    def _check_mode(self) -> None:
        """Check the fields that only some modes allow."""
        if self.bank != 0.0 and self.mode not in ("turn", "none"):
            self._refuse("bank", f"needs mode='turn', not {self.mode!r}")
        if self.load_factor != 1.0 and self.mode != "pull-up":
            self._refuse("load_factor", f"needs mode='pull-up', not {self.mode!r}")
        if self.beta != 0.0 and self.mode not in ("full", "longitudinal", "glide"):
            self._refuse("beta", f"needs mode 'full', 'longitudinal' or 'glide', not {self.mode!r}")
        if flag("coordinated", self.coordinated) and self.mode != "turn":
            self._refuse("coordinated", f"needs mode='turn', not {self.mode!r}")

    def _check_balance(self) -> None:
        """Check the unknowns of the search, and that the solver can move them."""
        for name, choices in (("free", FREE), ("solver", SOLVERS)):
            if getattr(self, name) is not None:
                one_of(name, getattr(self, name), choices)
        settings = [name for name in ("throttle", "thrust") if getattr(self, name) is not None]
        if settings and (self.mode in ("ground", "glide", "none") or len(settings) == 2):
            rival = "thrust" if settings[1:] else f"mode={self.mode!r}"
            self._refuse(settings[0], f"cannot be combined with {rival}")
        has_throttle = self.mode != "glide" and not settings
        if self.free is not None and (self.free == "throttle") != has_throttle:
            why = "cannot be combined with a fixed throttle or thrust: free gamma or speed"
            if has_throttle:
                why = "needs a throttle or thrust to hold, or mode='glide'"
            self._refuse("free", why)
        if self.solver == "newton" and self.mode == "none":
            self._refuse("solver", "cannot be combined with mode='none', which does not trim")
        engine_out = self.engines_off and self.mode not in ("ground", "none")
        if self.solver == "jsbsim" and (self.beta or not has_throttle or engine_out):
            why = "cannot trim a glide, a sideslip, a fixed throttle or an engine out: use "
            self._refuse("solver", f"{why}'newton'")

    @property
    def balance(self) -> str:
        """The unknown that balances forces along the flight path: "throttle", "gamma", "speed"."""
        sets_thrust = self.mode == "glide" or self.throttle is not None or self.thrust is not None
        return self.free or ("gamma" if sets_thrust else "throttle")

    @property
    def searched_by(self) -> str:
        """The solver for this condition: "newton" or "jsbsim"."""
        return self.solver or "newton"

    def __deepcopy__(self, memo: Any) -> TrimCondition:
        return self

    def __str__(self) -> str:
        always = ("altitude", "speed", "mach", "gamma", "mode")
        hidden = ["mach" if self.mach is None else "speed"]
        hidden += ["speed", "mach", "gamma"] * (self.mode == "ground")
        parts = []
        for f in dataclasses.fields(self):
            value = getattr(self, f.name)
            if isinstance(value, Mapping):
                parts += [f"{f.name}={value!r}"] * bool(value)
            elif f.name not in hidden and (f.name in always or value != f.default):
                parts.append(f"{f.name}={value!r}")
        return ", ".join(parts)


def check_condition(condition: Any) -> None:
    """Refuse anything but a `TrimCondition`."""
    if not isinstance(condition, TrimCondition):
        must_be("condition", condition, "a TrimCondition")


def _indices(parameter: str, value: Any) -> tuple[int, ...]:
    if isinstance(value, (str, bytes, bytearray)) or not np.iterable(value):
        must_be(parameter, value, "'all' or a list of engines from 0")
    return tuple(sorted({integer(parameter, i, low=0) for i in value}))


def _weights(parameter: str, value: Any) -> dict[int, float]:
    """Weights in lb, a list or a dict of indices, as a mapping from the index."""
    if value is None:
        value = {}
    if isinstance(value, (list, tuple)):
        value = dict(enumerate(value))
    if not isinstance(value, Mapping):
        must_be(parameter, value, "a list or a dict of weights in lb")
    indices = [integer(f"{parameter} index", i, low=0) for i in value]
    weights = [number(f"{parameter}[{i}]", w, low=0.0) for i, w in value.items()]
    return own(dict(zip(indices, weights, strict=True)))
