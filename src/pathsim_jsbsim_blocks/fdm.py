"""The aircraft blocks: `JSBSimFDM` with any property as a port, `Aircraft` with fixed, short ones."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from threading import get_ident
from typing import Any

from pathsim.utils.register import Register

from .airframe import Airframe, capture_console
from .checks import did_you_mean, nearest, whole
from .errors import FlightError, ParameterError, PropertyError
from .sampling import SampledPlant
from .trim import TrimCondition, TrimState, trim

# whatever is not finite in the state reaches these within a step
_WATCHED = ("velocities/vt-fps", "position/h-sl-ft")


class _FlightBlock(SampledPlant):
    """What the aircraft blocks share: life, time, inputs and outputs of one JSBSim aircraft."""

    def __init__(self, T: float, substeps: int):
        self.substeps = whole("substeps", substeps, low=1)
        super().__init__(T)
        self.airframe: Airframe
        self.trim: TrimState

    def _airframe(self) -> Airframe:
        """A fresh airframe, as the block's parameters say."""
        raise NotImplementedError

    def _condition(self) -> TrimCondition:
        """The condition that the block's parameters ask for."""
        raise NotImplementedError

    def _connect(self) -> None:
        """Find the properties behind the ports in a fresh, trimmed airframe."""
        raise NotImplementedError

    def _write(self, u: list[float]) -> None:
        """Write the inputs of one sample period to the aircraft."""
        raise NotImplementedError

    def _read(self) -> list[float]:
        """Read the outputs."""
        raise NotImplementedError

    def _take_off(self, setup: Mapping[str, float] | None,
                  properties: Mapping[str, float] | None) -> None:
        self.airframe = self._airframe()
        self.trim = trim(self.airframe, self._condition(), setup)
        self._speed, self._height = (self.airframe.reader(name) for name in _WATCHED)
        self._connect()
        self.airframe.write(properties, "properties")
        self._thread = get_ident()
        self._substeps = self.substeps
        self._n_inputs = len(self.inputs._mapping)
        self._u: list[float] = []
        self.publish()

    @property
    def fdm(self):
        """The live ``jsbsim.FGFDMExec``, to look at; it is another one after a reset."""
        return self.airframe.fdm

    def __getitem__(self, key):
        if isinstance(key, int) and key >= max(len(self.inputs), len(self.outputs)):
            raise PropertyError(
                f"{type(self).__name__} has {len(self.inputs)} inputs and {len(self.outputs)} "
                f"outputs, no port {key}", aircraft=self.airframe.aircraft, name=str(key))
        if isinstance(key, str):
            ports = [*self.inputs._mapping, *self.outputs._mapping]
            if key not in ports:
                close = nearest(key, ports)
                raise PropertyError(
                    f"{type(self).__name__} has no port {key!r}" + did_you_mean(close),
                    aircraft=self.airframe.aircraft, name=key, nearest=close)
        return super().__getitem__(key)

    def reset(self) -> None:
        """Fly the same flight again: a fresh aircraft, loaded and trimmed as at first."""
        super().reset()
        self._take_off(self.setup, self.properties)

    def latch(self) -> None:
        u = self.inputs._data.tolist()
        if len(u) > self._n_inputs:
            raise ParameterError(
                f"input port {len(u) - 1} of {type(self).__name__} is wired, but the block has "
                f"{self._n_inputs} inputs", parameter="inputs", value=len(u))
        if not math.isfinite(sum(u)):
            for port, value in zip(self.inputs._mapping, u, strict=False):
                if not math.isfinite(value):
                    self._fail(port, value, "input")
        self._u = u

    def advance(self) -> None:
        if get_ident() != self._thread:
            # a diagram may go on in another thread, where JSBSim's console is another one
            self._thread = get_ident()
            capture_console()
        self._write(self._u)
        run = self.airframe.fdm.run
        for _ in range(self._substeps):
            run()

    def publish(self) -> None:
        y = self._read()
        if not math.isfinite(sum(y) + self._speed() + self._height()):
            for name, value in [*zip(self.outputs._mapping, y, strict=False),
                                *((name, self.airframe.fdm[name]) for name in _WATCHED)]:
                if not math.isfinite(value):
                    self._fail(name, value, "state")
        self.outputs._data[:] = y

    def _fail(self, name: str, value: float, what: str) -> None:
        # the last period flown ended at the instant before the next one
        time = self.clock.next - (what == "input") * self.clock.period
        raise FlightError(
            f"aircraft {self.airframe.aircraft!r}: {what} {name!r} is {value} at t = {time:.9g} s",
            aircraft=self.airframe.aircraft, time=time, name=name, value=value)


def _chosen(condition: TrimCondition | None, flat: Mapping[str, Any],
            defaults: Mapping[str, Any]) -> TrimCondition | None:
    """Refuse a condition next to flat trim keywords that are not at their defaults."""
    if condition is None:
        return None
    if not isinstance(condition, TrimCondition):
        raise ParameterError(f"condition must be a TrimCondition, not {condition!r}",
                             parameter="condition", value=condition)
    for name, value in flat.items():
        if value != defaults[name]:
            raise ParameterError(
                f"both condition and {name}={value!r} are given: put {name} into the condition",
                parameter=name, value=value)
    return condition


def _names(parameter: str, names: Sequence[str] | None) -> list[str]:
    if names is None:
        return []
    if isinstance(names, str) or not isinstance(names, Sequence):
        raise ParameterError(f"{parameter} must be a list of property names, not {names!r}",
                             parameter=parameter, value=names)
    for name in names:
        if list(names).count(name) > 1:
            raise ParameterError(f"{parameter} lists {name!r} twice", parameter=parameter,
                                 value=names)
    return list(names)


class JSBSimFDM(_FlightBlock):
    """JSBSim aircraft with any of its properties as ports.

    The aircraft is trimmed when the block is built. At t = 0 the outputs are the trimmed state; at
    t_k = k T they are the state at exactly t_k; inputs are read at t_k and held over [t_k, t_k+1).
    Input values replace the property's value (absolute): an input that is not wired writes 0.

    The first eight parameters are those of pathsim-flight's ``JSBSimWrapper``, which this block
    replaces: that one runs a step ahead of the clock and does not reset.

    Parameters
    ----------
    T : float
        sample period in s; the aircraft advances once per T, in ``substeps`` equal JSBSim steps
    input_properties : list of str
        properties written from the input ports, in this order
    output_properties : list of str
        properties shown at the output ports, in this order
    JSBSim_path : str, optional
        JSBSim root directory; default is the one that the jsbsim package brings
    aircraft_model : str
        name of the model
    trim_airspeed : float
        speed to trim at, KCAS
    trim_altitude : float
        altitude to trim at, ft above mean sea level
    trim_gamma : float
        flight path angle to trim at, deg
    trim_heading : float
        true heading to trim at, deg
    trim_mode : str
        "full", "longitudinal", "ground", "pull-up", "turn" or "none"
    gear, flaps : float, optional
        0 (up) to 1 (down); default is the model's own setting
    condition : TrimCondition, optional
        instead of the trim parameters above, where they do not say enough
    setup : dict, optional
        properties written before initialisation and trim (fuel, payload)
    properties : dict, optional
        properties written after the trim (turbulence)
    substeps : int
        JSBSim steps per sample period
    create : dict, optional
        properties that the model expects from its surroundings (FlightGear), with their values
    allow_network, allow_files : bool
        let the model open sockets or write files that its XML asks for

    Inputs
    ------
    as ``input_properties`` : the property names are the port names, in the property's unit

    Outputs
    -------
    as ``output_properties`` : the property names are the port names, in the property's unit

    Raises
    ------
    AircraftError, PropertyError, ParameterError, TrimError
        when the block is built: unknown names and values that cannot be, or no trim
    FlightError
        in flight, when an input or the state is not finite

    Examples
    --------
    >>> fdm = JSBSimFDM(input_properties=["fcs/elevator-cmd-norm"],
    ...                 output_properties=["attitude/theta-deg"], aircraft_model="c172p",
    ...                 trim_airspeed=90, trim_altitude=5000)
    >>> round(float(fdm.outputs["attitude/theta-deg"]), 2)
    1.28
    """

    input_port_labels = None
    output_port_labels = None

    def __init__(self, T=1 / 120, input_properties=None, output_properties=None,
                 JSBSim_path=None, aircraft_model="737", trim_airspeed=200, trim_altitude=1000,
                 trim_gamma=0, trim_heading=0.0, trim_mode="full", gear=None, flaps=None,
                 condition=None, setup=None, properties=None, substeps=1, create=None,
                 allow_network=False, allow_files=False):
        super().__init__(T, substeps)
        self.input_properties = _names("input_properties", input_properties)
        self.output_properties = _names("output_properties", output_properties)
        self.JSBSim_path = JSBSim_path
        self.aircraft_model = aircraft_model
        self.trim_airspeed = trim_airspeed
        self.trim_altitude = trim_altitude
        self.trim_gamma = trim_gamma
        self.trim_heading = trim_heading
        self.trim_mode = trim_mode
        self.gear = gear
        self.flaps = flaps
        self.condition = condition
        self.setup = setup
        self.properties = properties
        self.create = create
        self.allow_network = allow_network
        self.allow_files = allow_files
        self.inputs = Register(len(self.input_properties),
                               {n: i for i, n in enumerate(self.input_properties)})
        self.outputs = Register(len(self.output_properties),
                                {n: i for i, n in enumerate(self.output_properties)})
        self._take_off(setup, properties)

    def _airframe(self) -> Airframe:
        return Airframe(self.aircraft_model, self.T / self.substeps, root=self.JSBSim_path,
                        empty_cg_x=self._condition().empty_cg_x, create=self.create,
                        allow_network=self.allow_network, allow_files=self.allow_files)

    def _condition(self) -> TrimCondition:
        flat = {"trim_airspeed": self.trim_airspeed, "trim_altitude": self.trim_altitude,
                "trim_gamma": self.trim_gamma, "trim_heading": self.trim_heading,
                "trim_mode": self.trim_mode, "gear": self.gear, "flaps": self.flaps}
        return _chosen(self.condition, flat, _FDM_DEFAULTS) or TrimCondition(
            altitude=self.trim_altitude, speed=self.trim_airspeed, gamma=self.trim_gamma,
            heading=self.trim_heading, mode=self.trim_mode, gear=self.gear, flaps=self.flaps)

    def _connect(self) -> None:
        self._writers = [self.airframe.writer(name) for name in self.input_properties]
        self._readers = [self.airframe.reader(name) for name in self.output_properties]

    def _write(self, u: list[float]) -> None:
        for write, value in zip(self._writers, u, strict=True):
            write(value)

    def _read(self) -> list[float]:
        return [read() for read in self._readers]


_FDM_DEFAULTS = {name: p["default"] for name, p in JSBSimFDM.info()["parameters"].items()}


_DEG = 180.0 / math.pi

_OUTPUTS = {  # port: (property, factor to the port's unit)
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
}


class Aircraft(_FlightBlock):
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
        "full", "longitudinal", "ground", "pull-up", "turn" or "none"
    gear, flaps : float, optional
        0 (up) to 1 (down); default is the model's own setting
    T : float
        sample period in s
    substeps : int
        JSBSim steps per sample period
    condition : TrimCondition, optional
        instead of the parameters from ``altitude`` to ``flaps``, where they do not say enough
    setup : dict, optional
        properties written before initialisation and trim (fuel, payload)
    properties : dict, optional
        properties written after the trim (turbulence)
    JSBSim_path : str, optional
        JSBSim root directory; default is the one that the jsbsim package brings
    create : dict, optional
        properties that the model expects from its surroundings (FlightGear), with their values
    allow_network, allow_files : bool
        let the model open sockets or write files that its XML asks for

    Inputs
    ------
    elevator : increment of the elevator command, of full travel; positive is nose **down**
    aileron : increment of the aileron command; positive rolls right
    rudder : increment of the rudder command; positive yaws the nose left on most models
    throttle : increment of the throttle command of every engine, 1 is the full range

    Outputs
    -------
    theta, phi, psi : pitch, roll and heading angle, deg
    p, q, r : body rates, deg/s
    alpha, beta, gamma : angle of attack, sideslip angle, flight path angle, deg
    h : altitude above mean sea level, ft
    hdot : rate of climb, ft/s
    vc : calibrated airspeed, kt
    vt : true airspeed, ft/s
    mach : Mach number
    nx, nz : load factors, g; nz is +1 in level flight
    lat, lon : geodetic latitude and longitude, deg
    elev_sat, ail_sat, rud_sat, thr_sat : increment demanded minus increment applied in the last
        period: not 0 while a command is at the end of its range (feedback against wind-up)

    Raises
    ------
    AircraftError, PropertyError, ParameterError, TrimError
        when the block is built: unknown names and values that cannot be, or no trim
    FlightError
        in flight, when an input or the state is not finite

    Examples
    --------
    >>> plane = Aircraft("c172p", altitude=5000, speed=90)
    >>> round(float(plane.outputs["alpha"]), 2)
    1.28
    """

    input_port_labels = {"elevator": 0, "aileron": 1, "rudder": 2, "throttle": 3}
    output_port_labels = {
        name: i for i, name in enumerate(
            [*_OUTPUTS, "elev_sat", "ail_sat", "rud_sat", "thr_sat"])}

    def __init__(self, aircraft="c172p", altitude=5000.0, speed=100.0, mach=None, gamma=0.0,
                 heading=0.0, bank=0.0, mode="full", gear=None, flaps=None, T=1 / 120, substeps=1,
                 condition=None, setup=None, properties=None, JSBSim_path=None,
                 create=None, allow_network=False, allow_files=False):
        super().__init__(T, substeps)
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
        self.condition = condition
        self.setup = setup
        self.properties = properties
        self.JSBSim_path = JSBSim_path
        self.create = create
        self.allow_network = allow_network
        self.allow_files = allow_files
        self._take_off(setup, properties)

    def _airframe(self) -> Airframe:
        return Airframe(self.aircraft, self.T / self.substeps, root=self.JSBSim_path,
                        empty_cg_x=self._condition().empty_cg_x, create=self.create,
                        allow_network=self.allow_network, allow_files=self.allow_files)

    def _condition(self) -> TrimCondition:
        flat = {name: getattr(self, name) for name in (
            "altitude", "speed", "mach", "gamma", "heading", "bank", "mode", "gear", "flaps")}
        return _chosen(self.condition, flat, _AIRCRAFT_DEFAULTS) or TrimCondition(**flat)

    def _connect(self) -> None:
        state = self.trim
        self._surfaces = [  # writer, trimmed command, lowest and highest command
            (self.airframe.writer("fcs/elevator-cmd-norm"), state.elevator,
             # JSBSim limits the sum of command and pitch trim
             *_range(state.pitch_trim)),
            (self.airframe.writer("fcs/aileron-cmd-norm"), state.aileron, -1.0, 1.0),
            (self.airframe.writer("fcs/rudder-cmd-norm"), state.rudder, -1.0, 1.0),
        ]
        self._throttles = [(self.airframe.writer(f"fcs/throttle-cmd-norm[{i}]"), throttle)
                           for i, throttle in enumerate(state.throttle)]
        self._readers = [self.airframe.reader(name) for name, _ in _OUTPUTS.values()]
        self._factors = [factor for _, factor in _OUTPUTS.values()]
        self._saturation = [0.0] * 4

    def _write(self, u: list[float]) -> None:
        saturation = []
        for increment, (write, trimmed, low, high) in zip(u, self._surfaces, strict=False):
            command = trimmed + increment
            limited = min(max(command, low), high)
            write(limited)
            saturation.append(command - limited)
        excess = 0.0
        for write, trimmed in self._throttles:
            command = trimmed + u[3]
            limited = min(max(command, 0.0), 1.0)
            write(limited)
            excess = command - limited
        self._saturation = [*saturation, excess]

    def _read(self) -> list[float]:
        return [factor * read() for read, factor in zip(self._readers, self._factors, strict=True)
                ] + self._saturation


def _range(trim: float) -> tuple[float, float]:
    """Range of a command in [-1, 1] whose sum with a trim setting is in [-1, 1] too."""
    return max(-1.0, -1.0 - trim), min(1.0, 1.0 - trim)


_AIRCRAFT_DEFAULTS = {name: p["default"] for name, p in Aircraft.info()["parameters"].items()}
