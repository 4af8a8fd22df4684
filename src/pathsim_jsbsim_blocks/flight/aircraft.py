"""`Aircraft`: a trimmed JSBSim aircraft with fixed, short ports."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from .._core.aircraft_ports import (
    ALMOST_NORTH,
    EXCESS,
    OUTPUTS,
    SHORT_INPUTS,
    SHORT_OUTPUTS,
    SURFACES,
    WIND,
    throttles,
)
from .._core.callers import warn_user
from .._core.checks import flag, integer, number, optional, positive
from .._core.parameters import parameter
from .._core.ports import numbered
from ..errors import KeywordError
from .airframe import Airframe
from .block import FlightBlock, Read, Write
from .channels import Channel, port_channel, unit_of
from .flightgear import address
from .options import AircraftOptions
from .property_ports import behind
from .trimming.condition import Mode, Solver, TrimCondition

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .block import LinearModel

_STOP_TO_STOP = 2.0  # travel of a normalised command, -1 to 1


@dataclass(eq=False, repr=False)
class Aircraft(FlightBlock):
    """Trimmed JSBSim aircraft with short ports; inputs are increments on the trimmed commands.

    The aircraft is trimmed when the block is built. An unconnected input (0) stays at its trim
    value. The sum of trimmed command and increment is limited to the command's range. At t = 0 the
    outputs are the trimmed state; at t_k = k T they are the state at exactly t_k; inputs are read
    at t_k and held over [t_k, t_k+1). Parameters that are set later are checked immediately, by a
    trim of another aircraft, and act at the next reset.

    Parameters
    ----------
    aircraft : str
        name of the JSBSim model
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
    T : float
        sample period in s
    condition : TrimCondition, optional
        replaces the parameters from ``altitude`` to ``flaps``, ``latitude`` and ``longitude`` if
        they are not sufficient
    setup : dict, optional
        properties written before initialisation and trim (fuel, payload); one whose
        value then changes is refused, except commands that the trim solves for
    properties : dict, optional
        properties written after the trim (turbulence)
    input_properties : list of str, optional
        further inputs, which come after the fixed ones: short names ("flaps", "gear", "speedbrake",
        "spoilers", "brakes", "left_brake", "right_brake", "steering", and "throttle[0]",
        "throttle[1]", ... for single engines) or properties of JSBSim. Each is an **increment** on
        the value after the trim, in the property's unit, so that 0 changes nothing: -1 at "gear"
        retracts a gear that is down. Short names are commands in 0 to 1 (steering -1 to 1), and the
        sum is limited to that; "throttle[1]" comes on top of ``throttle``
    output_properties : list of str, optional
        further outputs, after the fixed ones: "flaps", "gear", "speedbrake", "spoilers" (positions,
        0 to 1), "throttle[0]", "thrust[0]" (lbf), "h_agl" (height of the centre of gravity above
        the ground, ft), or properties of JSBSim in their unit
    sink_max : float
        maximum sink rate at ground contact, ft/s; ``inf`` sets no limit. Like ``scrape_max`` it
        applies only to models with wheels
    scrape_max : float
        maximum depth to which parts other than wheels may press into the ground, ft: with the
        default of 0 they may not touch it; ``inf`` sets no limit
    solver : str, optional
        "newton" (the default in flight) or "jsbsim", the search of published numbers, as in
        `TrimCondition`

    Other Parameters
    ----------------
    substeps : int
        JSBSim steps per sample period
    root : str, optional
        JSBSim root directory; default is the one shipped with jsbsim
    create : dict or "missing", optional
        properties, with their values, that the model expects from its environment (FlightGear):
        they exist before it is loaded. If some are missing, the error lists them all; "missing"
        creates them as 0, and a warning lists them
    allow_network : bool
        let the model open the sockets that its XML defines (FlightGear, telnet input)
    allow_files : bool
        let the model write the output files that its XML defines (CSV)
    integrators : str or dict
        "default" (JSBSim's own: Euler for rotation), "precise" (a third of the error in flight at
        the same T; rocks on the ground, at 60 Hz by 2 g), or methods by state:
        ``{"rate_rotational": "adams-bashforth 3"}``. States: ``rate_rotational``,
        ``rate_translational``, ``position_rotational``, ``position_translational``. Methods:
        "none" (the state stays), "euler", "trapezoidal", "adams-bashforth 2" to
        "adams-bashforth 5"; for ``position_rotational`` also "buss 1", "buss 2",
        "local linearization"
    planet : str or dict, optional
        "WGS-84", "round" (a sphere of the same area, rotating), "round, fixed" (not rotating), or
        changes to WGS-84: ``semimajor_axis``, ``semiminor_axis`` (ft), ``rotation_rate``
        (rad/s), ``GM`` (ft3/s2), ``J2``; default is the model's own, or WGS-84
    gravity : str, optional
        "J2" (of the ellipsoid) or "point mass"; default is JSBSim's, J2
    flightgear : str, optional
        ``"HOST:PORT"`` where FlightGear listens, such as "127.0.0.1:5550": JSBSim sends its native
        FDM packets there by UDP, 60 per second of flight, without waiting for a reply
    latitude : float, optional
        where the flight starts: geodetic latitude in deg, north positive; default is the model's
        own (0)
    longitude : float, optional
        likewise in deg, east positive

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
    wind_north, wind_east, wind_down
        velocity of the air in ft/s, the direction it moves to, added to the condition's wind
        (JSBSim's ``atmosphere/gust-north-fps``, ...); 0 adds none

    Outputs
    -------
    theta, phi, psi
        pitch, roll and heading angle, deg; `Aircraft` shows a heading in [0, 360)
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
        commanded minus applied increment of the last period: not 0 while a command is at the end of
        its range (feedback against wind-up). For the throttle it is the mean over the running
        engines, or over all if none runs

    Raises
    ------
    AircraftError, PropertyError, ParameterError, TrimError
        when the block is built: unknown names, impossible values, or no trim
    FlightError
        in flight, if an input or the state is not finite, the aircraft has crashed or is under the
        ground, or other code runs or holds it; with `Aircraft` also at ground contact beyond
        ``sink_max`` or ``scrape_max``

    Examples
    --------
    >>> plane = Aircraft("c172p", altitude=5000, speed=90)
    >>> round(float(plane.outputs["alpha"]), 2)
    1.29
    """

    aircraft: str = "c172p"
    altitude: float = 5000.0
    speed: float = 100.0
    mach: float | None = None
    gamma: float = 0.0
    heading: float = 0.0
    bank: float = 0.0
    mode: Mode = "full"
    gear: float | None = None
    flaps: float | None = None
    T: float = parameter(1 / 120, positive)
    substeps: int = parameter(1, integer, low=1)
    condition: TrimCondition | None = None
    setup: Mapping[str, float] | None = None
    properties: Mapping[str, float] | None = None
    root: str | None = None
    create: Mapping[str, float] | str | None = None
    allow_network: bool = parameter(False, flag)
    allow_files: bool = parameter(False, flag)
    integrators: str | Mapping[str, str] = "default"
    planet: str | Mapping[str, float] | None = None
    gravity: str | None = None
    flightgear: str | None = parameter(None, optional, of=address)
    latitude: float | None = None
    longitude: float | None = None
    input_properties: Sequence[str] | None = None
    output_properties: Sequence[str] | None = None
    sink_max: float = parameter(15.0, number, low=0.0, infinite=True)
    scrape_max: float = parameter(0.0, number, low=0.0, infinite=True)
    solver: Solver | None = None

    input_port_labels = numbered("elevator aileron rudder throttle wind_north wind_east wind_down")
    output_port_labels = {name: i for i, name in enumerate(OUTPUTS)}

    _short = SHORT_INPUTS, SHORT_OUTPUTS
    _warned_of_units = False

    def __new__(cls, *arguments: Any, **keywords: Any) -> Any:
        for name in {"script", "initialize"} & {*keywords}:
            why = f"{cls.__name__} has no parameter {name!r}: its increments on trimmed commands "
            why += "would erase what a script writes; use JSBSimFDM"
            raise KeywordError(why, parameter=name, value=keywords[name])
        return super().__new__(cls, *arguments, **keywords)

    def _model(self) -> str:
        return self.aircraft

    def channels(self) -> tuple[list[Channel], list[Channel]]:
        inputs = [Channel(port, (name,), 1.0, "norm") for port, name in SURFACES.items()]
        engines = tuple(throttles(self.airframe.engines))
        outputs = [port_channel(port) for port in OUTPUTS]
        for port in self._further(self.outputs):
            names = behind(port, SHORT_OUTPUTS)
            outputs.append(Channel(port, names, 1.0, unit_of(names[0])))
        return [*inputs, Channel("throttle", engines, 1.0, "norm")], outputs

    def _further_ports(self, port: str) -> str:
        kinds = zip(("input_properties", "output_properties"), self._short, strict=True)
        ways = [f"{kind}=[{port!r}]" for kind, short in kinds if port in short]
        if ways:
            return f"{port!r} is one with {' or '.join(ways)}"
        return (
            "Other properties are ports with input_properties=[...] and output_properties=[...], "
            "or of JSBSimFDM"
        )

    def _warn_of_units(self, port: int, increment: float) -> None:
        """Warn once about an increment that is probably in degrees or percent."""
        if self._warned_of_units or abs(increment) <= _STOP_TO_STOP:
            return
        self._warned_of_units = True
        name = list(self.input_port_labels)[port]
        warn_user(
            f"{type(self).__name__}: {increment:g} at {name!r} exceeds the full travel: "
            "commands are normalised (-1 to 1, throttle 0 to 1), not degrees or percent"
        )

    def trimmed_inputs(self) -> list[float]:
        return [0.0] * len(self.channels()[0])

    def _connect(self) -> tuple[Write, Read]:
        writes = {**SURFACES, **WIND}
        self._check_properties(
            {self.airframe.canonical(name): port for port, name in writes.items()}
        )
        # excess of elevator, aileron, rudder and throttle over their limits
        excess = [0.0] * list(OUTPUTS.values()).count(EXCESS)
        return self._writer(excess), self._reader(excess)

    def _writer(self, excess: list[float]) -> Write:
        state, writer, canonical = self.trim, self.airframe.writer, self.airframe.canonical
        # JSBSim limits the sum of command and pitch trim
        least, most = max(-1.0, -1.0 - state.pitch_trim), min(1.0, 1.0 - state.pitch_trim)
        surfaces = [  # writer, trimmed command, minimum and maximum command
            (writer(SURFACES["elevator"]), state.elevator, least, most),
            (writer(SURFACES["aileron"]), state.aileron, -1.0, 1.0),
            (writer(SURFACES["rudder"]), state.rudder, -1.0, 1.0),
        ]
        extras = [
            (self.input_port_labels[name], behind(name, SHORT_INPUTS))
            for name in self._further(self.inputs)
        ]
        # ports of single engines; 0, the elevator's, stands for none
        port_of_engine = {canonical(names[0]): port for port, names in extras}
        commands = throttles(len(state.throttle))
        engines = [
            (writer(name), throttle, port_of_engine.get(canonical(name), 0))
            for name, throttle in zip(commands, state.throttle, strict=True)
        ]
        engine_ports = {port for _, _, port in engines}
        plain = [(port, names) for port, names in extras if port not in engine_ports]
        increments = [_Further(port, names, self.airframe) for port, names in plain]
        gusts = [writer(name) for name in WIND.values()]
        north = east = down = 0.0
        # excess of each engine
        overrun = [0.0] * len(engines)
        running = self.airframe.running_readers()

        def mean_of_running() -> float:
            values = [x for x, runs in zip(overrun, running, strict=True) if runs()] or overrun
            return sum(values) / len(values)

        def write(u: list[float]) -> None:
            nonlocal north, east, down
            for i, (put, trimmed, low, high) in enumerate(surfaces):
                command = value = trimmed + u[i]
                if value < low:
                    value = low
                if value > high:
                    value = high
                put(value)
                excess[i] = command - value
                if value != command:
                    self._warn_of_units(i, u[i])
            over = False
            for i, (put, trimmed, port) in enumerate(engines):
                command = trimmed + u[3]
                if port:
                    command += u[port]
                value = 0.0 if command < 0.0 else 1.0 if command > 1.0 else command
                put(value)
                overrun[i] = command - value
                if value != command:
                    over = True
                    self._warn_of_units(3, u[3])
            excess[3] = mean_of_running() if over else 0.0
            # write only changes: a gust in the block's properties stays if no port is connected
            if u[4] != north or u[5] != east or u[6] != down:
                for put, speed, last in zip(gusts, u[4:7], (north, east, down), strict=True):
                    if speed != last:
                        put(speed)
                north, east, down = u[4:7]
            for command_ in increments:
                command_.move(u)

        return write

    def _reader(self, excess: list[float]) -> Read:
        ports = list(OUTPUTS.values())
        names = [port.property for port in ports if port.property is not None]
        names += [behind(name, SHORT_OUTPUTS)[0] for name in self._further(self.outputs)]
        read_all = self.airframe.reader_of(names)
        first_excess, psi = ports.index(EXCESS), list(OUTPUTS).index("psi")
        factors = [(i, port.factor) for i, port in enumerate(ports) if port.factor != 1.0]

        def read() -> list[float]:
            y = read_all()
            y[first_excess:first_excess] = excess
            for i, factor in factors:
                y[i] *= factor
            if y[psi] > ALMOST_NORTH:
                y[psi] = 0.0
            return y

        return read


class _Further:
    """An input for further properties: increments on their values after the trim.

    A property that the model itself changes, such as the contents of a tank, is changed by the
    difference of the increment, so that 0 is neutral again.
    """

    def __init__(self, port: int, names: Sequence[str], airframe: Airframe):
        self._port = port
        self._writers = [airframe.writer(name) for name in names]
        self._readers = [
            airframe.reader(name) if "r" in airframe.access(name) else (lambda: 0.0)
            for name in names
        ]
        command = names in SHORT_INPUTS.values()
        self._high = 1.0 if command else math.inf
        self._low = -1.0 if names == SHORT_INPUTS["steering"] else 0.0 if command else -math.inf
        # the increment, the values without it and those that were read after the last write; one
        # assignment, which no interrupt can split
        values = self._read()
        self._written = 0.0, values, values
        # the values without the increment, while a write is not complete
        self._starts: list[float] | None = None

    def _read(self) -> list[float]:
        return [read() for read in self._readers]

    def move(self, u: list[float]) -> None:
        increment, starts, values = self._written
        if u[self._port] == increment and self._starts is None:
            return
        if self._starts is None:
            self._starts = [
                start if value == last else value + (start - last)
                for value, start, last in zip(self._read(), starts, values, strict=True)
            ]
        increment, starts = u[self._port], self._starts
        for put, start in zip(self._writers, starts, strict=True):
            put(min(max(start + increment, self._low), self._high))
        self._written, self._starts = (increment, starts, self._read()), None


def linear_model(
    aircraft: str,
    condition: TrimCondition | None = None,
    method: Literal["flown", "algebraic"] = "flown",
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    amplitude: Mapping[str, float] | None = None,
    *,
    T: float = 1 / 120,
    substeps: int = 1,
    **options: Unpack[AircraftOptions],
) -> LinearModel:
    """Linear model of an aircraft about a trim, with the commands and outputs of `Aircraft`.

    Parameters
    ----------
    aircraft : str
        name of the JSBSim model
    condition : TrimCondition, optional
        the trim; default 5000 ft and 100 KCAS
    method, inputs, outputs, amplitude
        as in `Aircraft.linear_model`
    T : float
        sample period in s
    substeps : int
        JSBSim steps per sample period
    **options
        ``setup``, ``properties``, ``root``, ``create``, ``allow_network`` or ``allow_files``, as
        of `Aircraft`

    Returns
    -------
    LinearModel

    Raises
    ------
    LinearisationError
        if no linear model exists: no steady trim in flight, an input at the end of its range
        or without response, responses that no linear model fits
    AircraftError, PropertyError, ParameterError, TrimError
        for unknown names, impossible values, or no trim

    Examples
    --------
    >>> model = linear_model("737", TrimCondition(altitude=5000, speed=260, gear=0.0))
    >>> model.states
    ('vt', 'alpha', 'beta', 'p', 'q', 'r', 'phi', 'theta', 'h', 'psi', 'lat', 'lon')
    """
    condition = TrimCondition() if condition is None else condition
    plane = Aircraft(aircraft, condition=condition, T=T, substeps=substeps, **options)
    return plane.linear_model(method, inputs, outputs, amplitude)
