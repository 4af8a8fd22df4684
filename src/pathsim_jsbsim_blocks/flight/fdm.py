"""`JSBSimFDM`: a JSBSim aircraft with any property as a port."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .._core._pathsim import NamedRegister, port_names
from .block import FlightBlock, Read, Write, fill
from .channels import Channel, unit_of
from .property_ports import check_ports, listed
from .trimming.condition import TrimCondition

_ROUNDING = 1e-9  # of a search that ends at 0


@fill
class JSBSimFDM(FlightBlock):
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
        JSBSim root directory; default is the one shipped with jsbsim
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
        "full", "longitudinal", "ground" (at rest on the gear, at any speed), "pull-up",
        "turn" or "none"
    %(configuration)s
    condition : TrimCondition, optional
        replaces the trim parameters above where they are not sufficient
    %(written)s
    substeps : int
        JSBSim steps per sample period
    %(surroundings)s

    Inputs
    ------
    as ``input_properties``
        the property names are the port names, in the property's unit

    Outputs
    -------
    as ``output_properties``
        the property names are the port names, in the property's unit

    %(raises)s

    Examples
    --------
    >>> fdm = JSBSimFDM(input_properties=["fcs/elevator-cmd-norm"],
    ...                 output_properties=["attitude/theta-deg"], aircraft_model="c172p",
    ...                 trim_airspeed=90, trim_altitude=5000)
    >>> round(float(fdm.outputs["attitude/theta-deg"]), 2)
    1.29
    """

    input_port_labels = None
    output_port_labels = None

    # pathsim-flight's names
    _trim_keywords = {
        "trim_airspeed": "speed",
        "trim_altitude": "altitude",
        "trim_gamma": "gamma",
        "trim_heading": "heading",
        "trim_mode": "mode",
        "gear": "gear",
        "flaps": "flaps",
    }

    def __init__(
        self,
        T: float = 1 / 120,
        input_properties: Sequence[str] | None = None,
        output_properties: Sequence[str] | None = None,
        JSBSim_path: str | None = None,
        aircraft_model: str = "737",
        trim_airspeed: float = 200,
        trim_altitude: float = 1000,
        trim_gamma: float = 0,
        trim_heading: float = 0.0,
        trim_mode: str = "full",
        gear: float | None = None,
        flaps: float | None = None,
        condition: TrimCondition | None = None,
        setup: Mapping[str, float] | None = None,
        properties: Mapping[str, float] | None = None,
        substeps: int = 1,
        create: Mapping[str, float] | None = None,
        record_inputs: bool = False,
        allow_network: bool = False,
        allow_files: bool = False,
        integrators: str | Mapping[str, str] = "default",
        planet: str | Mapping[str, float] | None = None,
        gravity: str | None = None,
        flightgear: str | None = None,
    ) -> None:
        super().__init__(
            T,
            substeps,
            condition=condition,
            setup=setup,
            properties=properties,
            root=JSBSim_path,
            create=create,
            record_inputs=record_inputs,
            allow_network=allow_network,
            allow_files=allow_files,
            integrators=integrators,
            planet=planet,
            gravity=gravity,
            flightgear=flightgear,
        )
        self.input_properties = listed("input_properties", input_properties)
        self.output_properties = listed("output_properties", output_properties)
        self.aircraft_model = aircraft_model
        self.trim_airspeed = trim_airspeed
        self.trim_altitude = trim_altitude
        self.trim_gamma = trim_gamma
        self.trim_heading = trim_heading
        self.trim_mode = trim_mode
        self.gear = gear
        self.flaps = flaps
        self.inputs = NamedRegister.of(self.input_properties)
        self.outputs = NamedRegister.of(self.output_properties)
        self.take_off()

    def _model(self) -> str:
        return self.aircraft_model

    @property
    def JSBSim_path(self) -> str | None:
        """pathsim-flight's name of ``root``."""
        return self.root

    @JSBSim_path.setter
    def JSBSim_path(self, path: str | None) -> None:
        self.root = path

    def channels(self) -> tuple[list[Channel], list[Channel]]:
        inputs, outputs = (
            [Channel(name, (name,), 1.0, unit_of(name)) for name in port_names(register)]
            for register in (self.inputs, self.outputs)
        )
        return inputs, outputs

    def trimmed_inputs(self) -> list[float]:
        return self._trimmed

    @property
    def places(self) -> list[str]:
        """Inputs that must be connected: the 0 of an open port is not their trimmed value."""
        ports = zip(port_names(self.inputs), self._trimmed, self.inputs.to_array(), strict=False)
        return [name for name, trimmed, now in ports if abs(trimmed) > _ROUNDING and not now]

    def _connect(self) -> tuple[Write, Read]:
        for parameter, ports in (
            ("input_properties", self.inputs),
            ("output_properties", self.outputs),
        ):
            check_ports(parameter, getattr(self, parameter), [*port_names(ports)], self.airframe)
        self._trimmed = [
            self.airframe.fdm[name] if "r" in self.airframe.access(name) else 0.0
            for name in port_names(self.inputs)
        ]
        return (
            self.airframe.writer_of(port_names(self.inputs)),
            self.airframe.reader_of(port_names(self.outputs)),
        )
