"""`Aircraft`: a trimmed JSBSim aircraft with fixed, short ports."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial

from .block import FlightBlock, fill
from .condition import TrimCondition

_DEG = 180.0 / math.pi

# port: (property, or None for a command's excess over its limit; factor to the port's unit).
# Models store the port numbers, so new ports are appended
_OUTPUTS: dict[str, tuple[str | None, float]] = {
    "theta": ("attitude/theta-deg", 1.0),
    "phi": ("attitude/phi-deg", 1.0),
    "psi": ("attitude/psi-deg", 1.0),
    "p": ("velocities/p-rad_sec", _DEG),
    "q": ("velocities/q-rad_sec", _DEG),
    "r": ("velocities/r-rad_sec", _DEG),
    "alpha": ("aero/alpha-deg", 1.0),
    "beta": ("aero/beta-deg", 1.0),
    "gamma": ("flight-path/gamma-deg", 1.0),
    "h": ("position/h-sl-ft", 1.0),
    "hdot": ("velocities/h-dot-fps", 1.0),
    "vc": ("velocities/vc-kts", 1.0),
    "vt": ("velocities/vt-fps", 1.0),
    "mach": ("velocities/mach", 1.0),
    "nx": ("accelerations/Nx", 1.0),
    "nz": ("accelerations/Nz", 1.0),
    "lat": ("position/lat-geod-deg", 1.0),
    "lon": ("position/long-gc-deg", 1.0),
    "elev_sat": (None, 1.0),
    "ail_sat": (None, 1.0),
    "rud_sat": (None, 1.0),
    "thr_sat": (None, 1.0),
}


@fill
class Aircraft(FlightBlock):
    """Trimmed JSBSim aircraft with short ports; inputs are increments on the trimmed commands.

    The aircraft is trimmed when the block is built. An input that is not wired (0) means "stay
    trimmed". The sum of trimmed command and increment is limited to the command's range. At t = 0
    the outputs are the trimmed state; at t_k = k T they are the state at exactly t_k; inputs are
    read at t_k and held over [t_k, t_k+1).

    Parameters
    ----------
    aircraft : str
        name of the JSBSim model
    altitude : float
        ft above mean sea level
    speed : float
        KCAS; not used if ``mach`` is given
    mach : float, optional
        Mach number instead of ``speed``
    gamma : float
        flight path angle in deg
    heading : float
        true heading in deg
    bank : float
        bank angle in deg, right positive, with ``mode="turn"``
    mode : str
        "full", "longitudinal", "ground" (at rest on the gear, at any speed), "pull-up",
        "turn" or "none"
    %(configuration)s
    T : float
        sample period in s
    substeps : int
        JSBSim steps per sample period
    condition : TrimCondition, optional
        replaces the parameters from ``altitude`` to ``flaps`` where they are not sufficient
    %(written)s
    root : str, optional
        JSBSim root directory; default is the one shipped with jsbsim
    %(surroundings)s

    Inputs
    ------
    elevator
        increment of the elevator command, of full travel; positive is nose **down**
    aileron
        increment of the aileron command; positive rolls right
    rudder
        increment of the rudder command; positive yaws the nose left on most models
    throttle
        increment of the throttle command of every engine, 1 is the full range

    Outputs
    -------
    theta, phi, psi
        pitch, roll and heading angle, deg
    p, q, r
        body rates, deg/s
    alpha, beta, gamma
        angle of attack, sideslip angle, flight path angle, deg
    h
        altitude above mean sea level, ft
    hdot
        rate of climb, ft/s
    vc
        calibrated airspeed, kt
    vt
        true airspeed, ft/s
    mach
        Mach number
    nx, nz
        load factors, g; nz is +1 in level flight
    lat, lon
        geodetic latitude and longitude, deg
    elev_sat, ail_sat, rud_sat, thr_sat
        increment demanded minus increment applied in the last
        period: not 0 while a command is at the end of its range (feedback against wind-up)

    %(raises)s

    Examples
    --------
    >>> plane = Aircraft("c172p", altitude=5000, speed=90)
    >>> round(float(plane.outputs["alpha"]), 2)
    1.29
    """

    input_port_labels = {"elevator": 0, "aileron": 1, "rudder": 2, "throttle": 3}
    output_port_labels = {name: i for i, name in enumerate(_OUTPUTS)}

    _trim_keywords = {
        name: name
        for name in (
            "altitude",
            "speed",
            "mach",
            "gamma",
            "heading",
            "bank",
            "mode",
            "gear",
            "flaps",
        )
    }

    def __init__(
        self,
        aircraft: str = "c172p",
        altitude: float = 5000.0,
        speed: float = 100.0,
        mach: float | None = None,
        gamma: float = 0.0,
        heading: float = 0.0,
        bank: float = 0.0,
        mode: str = "full",
        gear: float | None = None,
        flaps: float | None = None,
        T: float = 1 / 120,
        substeps: int = 1,
        condition: TrimCondition | None = None,
        setup: Mapping[str, float] | None = None,
        properties: Mapping[str, float] | None = None,
        root: str | None = None,
        create: Mapping[str, float] | None = None,
        record_inputs: bool = False,
        allow_network: bool = False,
        allow_files: bool = False,
    ) -> None:
        super().__init__(
            T,
            substeps,
            condition=condition,
            setup=setup,
            properties=properties,
            root=root,
            create=create,
            record_inputs=record_inputs,
            allow_network=allow_network,
            allow_files=allow_files,
        )
        self.aircraft = aircraft
        self.altitude = altitude
        self.speed = speed
        self.mach = mach
        self.gamma = gamma
        self.heading = heading
        self.bank = bank
        self.mode = mode
        self.gear = gear
        self.flaps = flaps
        self.take_off()

    def _model(self) -> str:
        return self.aircraft

    def _connect(self) -> None:
        state = self.trim
        self._surfaces = [  # port, writer, trimmed command, lowest and highest command
            (
                "elev_sat",
                self.airframe.writer("fcs/elevator-cmd-norm"),
                state.elevator,
                # JSBSim limits the sum of command and pitch trim
                *_range(state.pitch_trim),
            ),
            ("ail_sat", self.airframe.writer("fcs/aileron-cmd-norm"), state.aileron, -1.0, 1.0),
            ("rud_sat", self.airframe.writer("fcs/rudder-cmd-norm"), state.rudder, -1.0, 1.0),
        ]
        self._throttles = [
            (self.airframe.writer(f"fcs/throttle-cmd-norm[{i}]"), throttle)
            for i, throttle in enumerate(state.throttle)
        ]
        self._saturation = {port: 0.0 for port, (name, _) in _OUTPUTS.items() if name is None}
        self._readers = [
            partial(self._saturation.__getitem__, port)
            if name is None
            else self.airframe.reader(name)
            for port, (name, _) in _OUTPUTS.items()
        ]
        self._factors = [factor for _, factor in _OUTPUTS.values()]

    def _write(self, u: list[float]) -> None:
        for increment, (port, write, trimmed, low, high) in zip(u, self._surfaces, strict=False):
            command = trimmed + increment
            limited = min(max(command, low), high)
            write(limited)
            self._saturation[port] = command - limited
        excess = 0.0
        for write, trimmed in self._throttles:
            command = trimmed + u[3]
            limited = min(max(command, 0.0), 1.0)
            write(limited)
            excess = command - limited
        self._saturation["thr_sat"] = excess

    def _read(self) -> list[float]:
        return [factor * read() for read, factor in zip(self._readers, self._factors, strict=True)]


def _range(trim: float) -> tuple[float, float]:
    """Range of a command in [-1, 1] whose sum with a trim setting is in [-1, 1] too."""
    return max(-1.0, -1.0 - trim), min(1.0, 1.0 - trim)
