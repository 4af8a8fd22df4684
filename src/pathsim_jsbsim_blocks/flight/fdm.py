"""`JSBSimFDM`: a JSBSim aircraft with any property as a port."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._core.checks import flag, integer, optional, positive, refuse
from .._core.parameters import parameter
from .._core.pathsim_internals import port_names
from .block import FlightBlock, Read, Write
from .channels import Channel, unit_of
from .flightgear import address
from .model_files import aircraft_names
from .script import StartFile, reset_file, script_file
from .trimming.condition import Mode, TrimCondition

_ROUNDING = 1e-9  # of a search that ends at 0

# pathsim-flight's; with a script they count as not set
_DEFAULT_T = 1 / 120  # s
_DEFAULT_MODEL = "737"


@dataclass(eq=False, repr=False)
class JSBSimFDM(FlightBlock):
    """JSBSim aircraft with any of its properties as ports.

    The aircraft is trimmed when the block is built: at ``condition``, or by JSBSim's own search at
    the trim parameters. At t = 0 the outputs are the trimmed state; at t_k = k T they are the state
    at exactly t_k; inputs are read at t_k and held over [t_k, t_k+1). Input values replace the
    property's value (absolute): an unconnected input writes 0. Parameters that are set later are
    checked immediately and act at the next reset, as in `Aircraft`.

    The first eight parameters of the signature are those of pathsim-flight's ``JSBSimWrapper``,
    which this block replaces: that one runs a step ahead of the clock and does not reset.

    Parameters
    ----------
    T : float
        sample period in s; the aircraft advances once per T, in ``substeps`` equal JSBSim steps
    input_properties : list of str
        properties written from the input ports, in this order
    output_properties : list of str
        properties shown at the output ports, in this order
    aircraft_model : str
        name of the model
    trim_airspeed : float
        calibrated airspeed to trim at, kt
    trim_altitude : float
        altitude above mean sea level in ft, geometric, up to 278,386, near the end of the standard
        atmosphere (1e9 in mode "none")
    trim_gamma : float
        flight path angle in deg, positive in a climb
    trim_heading : float
        true heading in deg
    trim_mode : str
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
    condition : TrimCondition, optional
        replaces the trim parameters above if they are not sufficient
    setup : dict, optional
        properties written before initialisation and trim (fuel, payload); one that has another
        value then is refused, but for commands that the trim solves for
    properties : dict, optional
        properties written after the trim (turbulence)

    Other Parameters
    ----------------
    JSBSim_path : str, optional
        JSBSim root directory; default is the one shipped with jsbsim
    substeps : int
        JSBSim steps per sample period
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
    script : str, optional
        a JSBSim script (``<runscript>``), a path or a name below the JSBSim root
        ("scripts/c1723.xml"), flown bit for bit as JSBSim flies it. It gives the model, ``T`` (its
        ``dt`` times ``substeps``), the start and the events; `duration` is the time to its end.
        Events do not write to properties that are inputs of the block. ``setup`` is written before
        the start, ``properties`` after it
    initialize : str, optional
        a JSBSim reset file (``<initialize>``), a path or the name of one beside the model
        ("reset00"): the flight starts in exactly this state, trimmed if the file asks for a trim

    Inputs
    ------
    as ``input_properties``
        the property names are the port names, in the property's unit

    Outputs
    -------
    as ``output_properties``
        the property names are the port names, in the property's unit

    Raises
    ------
    AircraftError, PropertyError, ParameterError, TrimError
        when the block is built: unknown names, impossible values, or no trim
    FlightError
        in flight, if an input or the state is not finite, the aircraft has crashed or is under the
        ground, or other code runs or holds it; with `Aircraft` also at ground contact beyond
        ``sink_max`` or ``scrape_max``. With a script only if a value is not finite or an event
        fails: JSBSim flies scripts through the ground

    Examples
    --------
    >>> fdm = JSBSimFDM(input_properties=["fcs/elevator-cmd-norm"],
    ...                 output_properties=["attitude/theta-deg"], aircraft_model="c172p",
    ...                 trim_airspeed=90, trim_altitude=5000)
    >>> round(float(fdm.outputs["attitude/theta-deg"]), 2)
    1.29
    """

    T: float = parameter(_DEFAULT_T, positive)
    input_properties: Sequence[str] | None = None
    output_properties: Sequence[str] | None = None
    JSBSim_path: str | None = None
    aircraft_model: str = _DEFAULT_MODEL
    trim_airspeed: float = 200
    trim_altitude: float = 1000
    trim_gamma: float = 0
    trim_heading: float = 0.0
    trim_mode: Mode = "full"
    gear: float | None = None
    flaps: float | None = None
    condition: TrimCondition | None = None
    setup: Mapping[str, float] | None = None
    properties: Mapping[str, float] | None = None
    substeps: int = parameter(1, integer, low=1)
    create: Mapping[str, float] | str | None = None
    allow_network: bool = parameter(False, flag)
    allow_files: bool = parameter(False, flag)
    integrators: str | Mapping[str, str] = "default"
    planet: str | Mapping[str, float] | None = None
    gravity: str | None = None
    flightgear: str | None = parameter(None, optional, of=address)
    script: str | None = None
    initialize: str | None = None

    input_port_labels = None
    output_port_labels = None

    # pathsim-flight's names
    _trim_names = {
        "trim_airspeed": "speed",
        "trim_altitude": "altitude",
        "trim_gamma": "gamma",
        "trim_heading": "heading",
        "trim_mode": "mode",
    }

    # as pathsim-flight's block trims
    _solver = "jsbsim"

    def _begin(self) -> None:
        # `Aircraft` takes the aircraft first
        if isinstance(self.T, str) and self.T in aircraft_names(self.root):
            refuse("T", self.T, f"the first parameter is T, in s: aircraft_model={self.T!r}?")
        if self.script is not None and positive("T", self.T) == _DEFAULT_T:
            self.T = self._period(self.script, self.substeps)
        super()._begin()

    def _change(self, values: dict[str, Any]) -> None:
        script = values.get("script", self.script)
        if script is not None and {"script", "substeps"} & {*values} and "T" not in values:
            T = self._period(script, values.get("substeps", self.substeps))
            values = {**values, "T": T}
        super()._change(values)

    def _period(self, script: str, substeps: int) -> float:
        """The sample period with a script, s."""
        return script_file(script, self.root).dt * integer("substeps", substeps, low=1)

    def _start_file(self) -> StartFile | None:
        if self.script is None and self.initialize is None:
            return None
        self._refuse_other_starts()
        if self.script is None:
            dt = self._checked.T / self._checked.substeps
            return reset_file(self.initialize, self.aircraft_model, dt, self.root)
        file = script_file(self.script, self.root, port_names(self.inputs))
        T = file.dt * self._checked.substeps
        if not math.isclose(self._checked.T, T, rel_tol=1e-9):
            why = f"T={self.T!r}, but {file} has the step {file.dt!r} s: leave T out, or set {T!r}"
            refuse("T", self.T, why)
        if self.aircraft_model not in (_DEFAULT_MODEL, file.aircraft):
            why = f"aircraft_model={self.aircraft_model!r}, but {file} flies {file.aircraft!r}: "
            refuse("aircraft_model", self.aircraft_model, f"{why}leave aircraft_model out")
        return file

    def _refuse_other_starts(self) -> None:
        """Refuse parameters that start the flight in another way than a file does."""
        file = "initialize" if self.script is None else "script"
        parameters = ["condition", "planet", "gear", "flaps", *self._trim_names]
        for name in [*parameters, "initialize"] if file == "script" else parameters:
            value = getattr(self, name)
            if np.any(value != self.__dataclass_fields__[name].default):
                why = f"{name}={value!r} cannot be combined with {file}, which gives the start of "
                refuse(name, value, f"{why}the flight; setup writes properties before it")

    @property
    def duration(self) -> float | None:
        """Time from the start of the script to its last sample, s; None without a script."""
        file = self.airframe.start
        if file is None or not file.is_script:
            return None
        return file.steps // self._substeps * self._checked.T

    def _model(self) -> str:
        return self.aircraft_model

    @property
    def root(self) -> str | None:  # type: ignore[override]
        return self.JSBSim_path

    def channels(self) -> tuple[list[Channel], list[Channel]]:
        inputs, outputs = (
            [Channel(name, (name,), 1.0, unit_of(name)) for name in port_names(register)]
            for register in (self.inputs, self.outputs)
        )
        return inputs, outputs

    def trimmed_inputs(self) -> list[float]:
        return self._trimmed

    @property
    def _places(self) -> list[str]:
        """Inputs that must be connected: the 0 of an open port is not their trimmed value."""
        ports = zip(port_names(self.inputs), self._trimmed, self.inputs.to_array(), strict=False)
        return [name for name, trimmed, value in ports if abs(trimmed) > _ROUNDING and not value]

    def _connect(self) -> tuple[Write, Read]:
        self._check_properties()
        if self.airframe.start is not None:
            self.airframe.start.check(self.airframe, self._checked.allow_files)
        self._trimmed = [
            self.airframe.fdm[name] if "r" in self.airframe.access(name) else 0.0
            for name in port_names(self.inputs)
        ]
        return (
            self.airframe.writer_of(port_names(self.inputs)),
            self.airframe.reader_of(port_names(self.outputs)),
        )
