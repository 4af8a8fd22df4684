"""`FlightBlock`: base of all aircraft blocks."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from math import inf, isfinite, nan
from typing import TYPE_CHECKING, Any, Literal, NoReturn

import jsbsim
import numpy as np
from pathsim.exceptions import LinearizationError
from pathsim.utils.portreference import PortReference
from pathsim.utils.register import Register

from .._core.aircraft_ports import property_of
from .._core.callers import warn_user
from .._core.checks import number, refuse
from .._core.clock import SHORTEST_PERIOD
from .._core.continuous import Matrices
from .._core.parameters import Parametric
from .._core.pathsim_internals import NamedRegister, port_names, values
from .._core.sampling import SampledPlant
from .._core.wiring import name_of
from ..errors import (
    BlocksError,
    CopyError,
    FlightError,
    ParameterError,
)
from . import from_trim
from .airframe import Airframe
from .channels import Channel
from .console import capture_console, console
from .contact import GroundContact
from .flightgear import next_address
from .property_ports import check_ports, listed
from .script import StartFile
from .trimming import TrimState, trim
from .trimming.condition import TrimCondition, check_condition
from .trimming.initial import start_from_file
from .trimming.trimmer import Trimmer

if TYPE_CHECKING:
    from ..linear.model import LinearModel

# s; with longer steps than these JSBSim's integration is unstable
_LONGEST_STEP = 0.1

# any NaN or inf in the state shows up here within one step
_WATCHED = tuple(map(property_of, ("vt", "h_agl", "nz")))

# s between checks for engines without fuel
_FUEL_CHECK = 1.0

# g; beyond any flyable load factor; ground springs of a crashed model give hundreds
_CRASH = 50.0

# ft above the terrain; JSBSim does not stop a centre of gravity from sinking below this
_UNDERGROUND = -1.0

# parameters of the airframe
_OF_AIRFRAME = set(inspect.signature(Airframe).parameters) - {
    "aircraft",
    "dt",
    "empty_cg_x",
    "start",
}

# parameters that are fields of a trim condition; a block's own setup is written after the field's
_OF_CONDITION = {f.name for f in fields(TrimCondition)} - {"setup"}

Write = Callable[[list[float]], None]
Read = Callable[[], list[float]]


class FlightBlock(Parametric, SampledPlant):
    """Base of the aircraft blocks: life, time, inputs and outputs of one JSBSim aircraft."""

    input_port_labels: Any
    output_port_labels: Any
    # the parameters, which each block declares in its own order
    substeps: int
    condition: TrimCondition | None
    setup: Mapping[str, float] | None
    properties: Mapping[str, float] | None
    root: str | None
    create: Mapping[str, float] | str | None
    flightgear: str | None
    input_properties: Sequence[str] | None
    output_properties: Sequence[str] | None
    # limits of a touch with the ground, ft/s and ft
    sink_max: float = inf
    scrape_max: float = inf

    # parameters that are fields of a condition under another name
    _trim_names: Mapping[str, str] = {}
    # the solver of a condition that is given by parameters
    _solver: str | None = None
    # names that stand for properties, at inputs and at outputs
    _short: tuple[Mapping[str, tuple[str, ...]], Mapping[str, tuple[str, ...]]] = ({}, {})

    airframe: Airframe
    trim: TrimState
    # whether it only looks at a flight, without files and sockets
    _sealed = False
    # key of the last flight, and its aircraft
    _before: tuple[str, Airframe] | None = None
    # key of the linearised flight, and its model
    _linear: tuple[str, LinearModel] | None = None
    # the error that has ended the flight
    _ending: FlightError | None = None
    # whether the user was warned that a parameter acts at the next reset
    _warned_of_reset = False

    @classmethod
    def _trimmed_like(cls, last_flight: tuple[str, Airframe] | None, **parameters: Any) -> Any:
        """A sealed block that takes over the trim of an earlier flight with the same parameters."""
        block = cls.__new__(cls)
        block._before, block._sealed = last_flight, True
        cls.__init__(block, **parameters)
        return block

    def _begin(self) -> None:
        SampledPlant.__init__(self, self.T)
        if self.flightgear is None:
            self.flightgear = next_address()
        self.input_properties = listed("input_properties", self.input_properties)
        self.output_properties = listed("output_properties", self.output_properties)
        self.inputs = NamedRegister.of(self.input_port_labels or (), self.input_properties)
        self.outputs = NamedRegister.of(self.output_port_labels or (), self.output_properties)
        self.input_port_labels = dict(port_names(self.inputs))
        self.output_port_labels = dict(port_names(self.outputs))

    def build(self) -> None:
        if not self._built:
            self.take_off(self._load())
            return
        self._check_properties()
        if self._flight_key() != self._flying:
            # try the parameters for the next reset on another aircraft; this one keeps flying
            from_trim.twin(self)

    def _change(self, values: dict[str, Any]) -> None:
        super()._change(values)
        if not self._warned_of_reset and self._flight_key() != self._flying:
            self._warned_of_reset = True
            changes = ", ".join(f"{name_of(self)}.{n} = {x!r}" for n, x in values.items())
            how = "sim.reset(), sim.run(..., reset=True), or Run in PathView"
            warn_user(f"{changes} acts at the next reset: {how}")

    def _further(self, ports: Register) -> list[str]:
        """Names of the inputs or outputs after the fixed ones."""
        kind: Any = type(self)
        labels = kind.input_port_labels if ports is self.inputs else kind.output_port_labels
        return list(port_names(ports))[len(labels or ()) :]

    def _check_properties(self, taken: Mapping[str, str] = {}) -> None:
        """Refuse properties that cannot be ports; ``taken`` are those that fixed ports write."""
        for parameter, names, ports, short, occupied in (
            ("input_properties", self.input_properties, self.inputs, self._short[0], taken),
            ("output_properties", self.output_properties, self.outputs, self._short[1], {}),
        ):
            check_ports(parameter, names, self._further(ports), self.airframe, short, occupied)

    def _model(self) -> str:
        """Name of the model, from the block's parameters."""
        raise NotImplementedError

    def _condition(self) -> TrimCondition:
        """The condition from the block's parameters: single ones or ``condition``, not both."""
        defaults = {f.name: f.default for f in fields(self)}
        names = {name: self._trim_names.get(name, name) for name in defaults}
        trim_fields = {name: field for name, field in names.items() if field in _OF_CONDITION}
        if self.condition is None:
            values_of_fields = {field: getattr(self, name) for name, field in trim_fields.items()}
            return TrimCondition(**{"solver": self._solver, **values_of_fields})
        check_condition(self.condition)
        for name in trim_fields:
            value = getattr(self, name)
            if np.any(value != defaults[name]):  # an array is refused here too
                why = f"both condition and {name}={value!r} are given: put {name} into the "
                refuse(name, value, f"{why}condition")
        return self.condition

    def _start_file(self) -> StartFile | None:
        """The script or reset file from which the aircraft starts, if any."""
        return None

    def channels(self) -> tuple[list[Channel], list[Channel]]:
        """Inputs and outputs as properties."""
        raise NotImplementedError

    def trimmed_inputs(self) -> list[float]:
        """Values at the trim of the inputs in `channels`, the block's first."""
        raise NotImplementedError

    def trim_here(self, **changes: Any) -> TrimState:
        """Trim the present flight on another aircraft; this one is not affected.

        Altitude, airspeed, path angle through the air, heading, wind, place, gear, flaps, fuel,
        payload and running engines are those of this moment, all else is as in the block's
        condition; modes "ground", "none" and "pull-up" become "full". The state's commands minus
        those of the block's ``trim`` are the inputs that an `Aircraft` would need; the state's
        condition starts another block here.

        Parameters
        ----------
        **changes
            fields of `TrimCondition` that differ: ``gamma=0``, ``mode="turn"`` (the bank is then
            that of this moment), ``solver="newton"``

        Raises
        ------
        TrimError
            if no trim is found
        ParameterError
            for an unknown field
        """
        return from_trim.trim_here(self, changes)

    def linear_model(
        self,
        method: Literal["flown", "algebraic"] = "flown",
        inputs: Sequence[str] | None = None,
        outputs: Sequence[str] | None = None,
        amplitude: Mapping[str, float] | None = None,
    ) -> LinearModel:
        """Linear model of the aircraft about its trim, with the block's ports.

        It is identified on separate aircraft, so the current flight is undisturbed. The model is
        always linearised about the trim, also during a run.

        Parameters
        ----------
        method : str
            "flown": identified from small opposite pulses on each input, 8 s each, so that the
            control system, actuators and engines are included; a doublet on each input, another
            8 s, shows how well the model holds. "algebraic": central differences of JSBSim's
            accelerations, the rigid aircraft with its engines in steady state, in about 20 ms;
            with propeller governors, and for turboprops, in 0.2 to 0.4 s of frozen flight
        inputs, outputs : list of str, optional
            names of ports; default all that the aircraft has: one without engines has no throttle.
            The wind of an `Aircraft` and its ``input_properties`` are not among the inputs
        amplitude : dict, optional
            height of the pulse on an input, by its name, in its unit; default 0.005 for
            surfaces, 0.001 for the throttle of a turbine and 0.01 for that of a piston engine. The
            doublet has twice this height, that of a throttle 0.01 by default

        Warns
        -----
        RuntimeWarning
            for each input whose response to a doublet, upwards first, is not linear: its even
            part is above 10 % of the odd part, or the model's error above 5 % in the command's
            primary responses (theta and q for the elevator, phi and p for the aileron, beta and r
            for the rudder, vt for the throttle) or above 15 % in the others

        Raises
        ------
        LinearisationError
            without a steady trim in flight (modes "none", "ground" and "pull-up"), for an input
            at the end of its range or without response, and if no linear model fits; flown, for
            a ``T`` above 0.25 s, too coarse for the short period; algebraic, for an engine
            that does not settle
        ParameterError
            for an unknown method or port, naming the nearest
        """
        from ..linear import jsbsim  # beyond the core: imported when it is asked for

        return jsbsim.model_about_trim(self, method, inputs, outputs, amplitude)

    def response(self, input: str, increments: Sequence[float], output: str) -> np.ndarray:
        """An output over increments on an input, the other inputs as trimmed.

        It is flown from the trim by a separate aircraft; the current flight is undisturbed.

        Parameters
        ----------
        input, output : str
            names of ports
        increments : list of float
            added to the trimmed input over each period, in its unit

        Returns
        -------
        array, shape (n + 1,)
            the output at the sample instants, the trim first, in its unit

        Raises
        ------
        ParameterError
            for an unknown port, naming the nearest
        FlightError
            if the aircraft cannot be flown on
        """
        from ..linear import jsbsim  # beyond the core

        return jsbsim.response(self, input, increments, output)

    def to_statespace(self, t: float) -> Matrices:
        """A, B, C, D of the flown model about the trim, at any time of the flight.

        The delay of sampling, latency and half a period of hold, becomes a first-order lag on each
        input. The model is kept until a parameter changes. Inputs that it leaves out, such as the
        wind of an `Aircraft`, have no effect in it.

        Raises
        ------
        LinearizationError
            PathSim's: if no linear model exists
        """
        try:
            flight = self._flight_key()
            if self._linear is None or self._linear[0] != flight:
                self._linear = flight, self.linear_model()
        except BlocksError as error:
            raise LinearizationError(str(error)) from error
        model = self._linear[1]
        A, B, C, D = model.with_lags(model.delay)
        padding = ((0, 0), (0, len(port_names(self.inputs)) - B.shape[1]))
        return A, np.pad(B, padding), C, np.pad(D, padding)

    def _connect(self) -> tuple[Write, Read]:
        """Functions that write the inputs to a fresh, trimmed airframe and read its outputs."""
        raise NotImplementedError

    def _load(self) -> list[float]:
        """Load, initialise and trim an aircraft; return its outputs at the start of the flight."""
        self._substeps = self._checked.substeps
        dt = self._checked.T / self._substeps
        number("T / substeps", dt, low=SHORTEST_PERIOD, high=_LONGEST_STEP)
        start, condition = self._start_file(), self._condition()
        self._flying = self._flight_key()
        self._ending = None
        self._warned_of_reset = False
        last_flight, self._before = self._before, None
        options = {name: getattr(self, name) for name in _OF_AIRFRAME}
        if self._sealed:
            options |= {"allow_network": False, "allow_files": False}
        self.airframe = Airframe(
            self._model() if start is None else start.aircraft,
            self._checked.T,
            empty_cg_x=condition.empty_cg_x,
            start=start,
            **options,
        )
        if start is not None:
            self.trim = start_from_file(self.airframe, self.setup)
        elif last_flight and last_flight[0] == self._flying:
            # the same flight again: skip the checks that it has passed
            like = Trimmer.of(last_flight[1])
            self.trim, _ = Trimmer.of(self.airframe).trim(condition, self.setup, like=like)
        else:
            self.trim = trim(self.airframe, condition, self.setup)
        write, read = self._connect()
        self.airframe.write(self.properties, "properties")
        self._before = self._flying, self.airframe
        speed, height, nz = (self.airframe.reader(name) for name in _WATCHED)
        self._n_inputs = len(port_names(self.inputs))
        self._n_outputs = len(port_names(self.outputs))
        self._step, self._time_zero = self.airframe.dt, self.airframe.sim_time()
        # what `advance` uses, in one look-up
        limits = (getattr(self._checked, name, inf) for name in ("sink_max", "scrape_max"))
        numbers = self._substeps, self._time_zero, dt * self._substeps, 0.5 * dt
        contact = GroundContact(self.airframe, numbers[2], *limits)
        touch = lambda: contact.broken(self.clock.begun[1])  # noqa: E731
        readers = speed, height, nz, contact.reach, contact.look, touch
        self._bound = self.airframe.run, self.airframe.sim_time, write, read, *readers, numbers
        self._starved = self.airframe.starved()
        self._fuel_at = _FUEL_CHECK / (dt * self._substeps) if self.airframe.engines else inf
        y = read()
        self._check(y, 0.0)
        return y

    def take_off(self, y: list[float]) -> None:
        """Show the start of a flight, with these outputs."""
        self.start_from(y)
        self.airframe.start_outputs()
        for observe in from_trim.at_take_off:
            observe(self)

    @property
    def model_name(self) -> str:
        return self.airframe.aircraft

    @property
    def fdm(self) -> jsbsim.FGFDMExec:
        """The live ``jsbsim.FGFDMExec``, for inspection only; `reset` may replace it."""
        return self.airframe.fdm

    def __repr__(self) -> str:
        if not hasattr(self, "trim"):
            return f"{type(self).__name__}(not built)"
        if self.airframe.start is not None:
            return f"{type(self).__name__}({self.airframe.aircraft!r}, {self.airframe.start})"
        condition = self.trim.condition
        speed = (
            f"{condition.speed:g} KCAS" if condition.mach is None else f"Mach {condition.mach:g}"
        )
        place = f"{condition.altitude:g} ft"
        on_ground = condition.mode == "ground"
        place = f"on the ground at {place}" if on_ground else f"{place}, {speed}"
        return f"{type(self).__name__}({self.airframe.aircraft!r}, {place})"

    def __getitem__(self, key: Any) -> PortReference:
        reference = super().__getitem__(key)
        for port in reference.ports:
            if isinstance(port, int) and port >= max(self._n_inputs, self._n_outputs):
                message = f"{type(self).__name__} has {self._n_inputs} inputs and "
                message += f"{self._n_outputs} outputs, no port {port}"
                refuse("port", port, message)
        return reference

    def __reduce_ex__(self, protocol: Any) -> Any:
        # copy.copy and copy.deepcopy call this too
        name, aircraft = type(self).__name__, self.airframe.aircraft
        why = f"{name} {aircraft!r} cannot be copied or pickled: JSBSim's state stays in its "
        why += f"process. Build another {name} with the same parameters; studies.branch runs "
        why += "several futures of this flight"
        raise CopyError(why, block=name, aircraft=aircraft)

    def reset(self) -> None:
        """Repeat the flight with a freshly loaded aircraft.

        Changed parameters take effect. If the model can no longer be loaded or trimmed,
        because its files have changed, this raises and the aircraft continues its flight.
        """
        attributes = dict(self.__dict__)
        try:
            y = self._load()
        except BaseException:
            self.__dict__.update(attributes)
            raise
        super().reset()
        self.take_off(y)

    def latch(self, t: float) -> list[float]:
        if self._ending:
            self._stay_ended()
        u = values(self.inputs)
        if len(u) > self._n_inputs:
            why = f"input port {len(u) - 1} of {type(self).__name__} is connected, but the number "
            refuse("inputs", len(u), f"{why}of inputs is {self._n_inputs}")
        if not isfinite(sum(u)):
            for port, value in zip(port_names(self.inputs), u, strict=False):
                if not isfinite(value):
                    self._fail(f"input {port!r}", port, value, t)
        return u

    def advance(self, index: int, u: list[float]) -> list[float]:
        # inlined, because a call or an attribute look-up costs as much as reading an output
        run, sim_time, write, read, speed, height, nz, reach, look, touch, numbers = self._bound
        substeps, time_zero, period, half_step = numbers
        if self._ending:
            self._stay_ended()
        if not console.installed:
            # JSBSim has a console per thread, and a diagram may continue in another thread
            capture_console()
        # an interrupt may have come before the inputs were written, or between the steps
        clock = self.clock
        begun, contact = clock.begun
        done = self._steps_since(index - 1) if begun == index else 0
        try:
            if not done:
                contact = look(contact) if height() < reach else None
                clock.begun = index, contact
                write(u)
            for _ in range(substeps - done):
                run()
        except (jsbsim.BaseError, ParameterError) as error:
            self._fail_step(index, error)
        if not -half_step <= sim_time() - time_zero - index * period <= half_step:
            self._fail_time(index)
        y = read()
        agl = height()
        if contact and (failure := touch()):
            self._fail(*failure, self._time(index))
        if not (isfinite(sum(y) + speed()) and agl >= _UNDERGROUND and -_CRASH < nz() < _CRASH):
            self._check(y, self._time(index))
        if index >= self._fuel_at:
            self._check_fuel(index)
        return y

    def _time(self, index: int) -> float:
        return self.clock.start + index * self.clock.period

    def _check_fuel(self, index: int) -> None:
        """Warn about engines that have stopped for lack of fuel since the last check."""
        earlier, self._starved = self._starved, self.airframe.starved()
        self._fuel_at = index + _FUEL_CHECK / self.clock.period
        engines = [str(i) for i in self._starved if i not in earlier]
        if engines:
            warn_user(
                f"{self.airframe.aircraft}: engine{'s' * (len(engines) > 1)} {', '.join(engines)} "
                f"stopped for lack of fuel by t = {self._time(index):.4g} s: the tanks that feed "
                "them are empty"
            )

    def _steps_since(self, index: int) -> int:
        """JSBSim's own count of its steps since an instant."""
        time = self.airframe.sim_time() - self._time_zero
        return round(time / self._step) - index * self._substeps

    def _end(self, why: str, name: str, value: float, t: float) -> NoReturn:
        aircraft = self.airframe.aircraft
        message = f"aircraft {aircraft!r}{why}"
        error = FlightError(message, aircraft=aircraft, time=t, name=name, value=value)
        self._ending = error.reworded(f"{message}. This flight has ended: reset to fly again")
        raise error from None

    def _stay_ended(self) -> NoReturn:
        # a copy: raising the stored one would add to its traceback at every step
        raise self._ending.reworded(str(self._ending))  # type: ignore[union-attr]

    def _fail(self, what: str, name: str, value: float, t: float) -> None:
        """End a flight because of an impossible value; in a script, of one that is not finite.

        JSBSim flies its scripts through the ground.
        """
        script = self.airframe.script_run
        if script is not None and isfinite(value):
            script.warn(
                "limit", f"{self.airframe.aircraft}: {what} is {value:.6g} at t = {t:.9g} s"
            )
            return
        self._end(f": {what} is {value:.6g} at t = {t:.9g} s", name, value, t)

    def _fail_step(self, index: int, error: Exception) -> NoReturn:
        """End a flight because of a refused input, or of an exception in JSBSim."""
        t, name = self._time(index - 1), getattr(error, "parameter", "")
        why = f" at t = {t:.9g} s: {' '.join(str(error).split())}"
        self._end(why, name, getattr(error, "value", nan), t)

    def _fail_time(self, index: int) -> NoReturn:
        time = self.airframe.sim_time() - self._time_zero
        why = f": its clock shows {time:.9g} s after {index} periods of {self.clock.period:.9g} s: "
        why += "other code runs or holds it"
        self._end(why, "simulation/sim-time-sec", time, self._time(index))

    def _check(self, y: list[float], t: float) -> None:
        """End the flight at ``t`` if it cannot continue."""
        monitors = {name: self.airframe.fdm[name] for name in _WATCHED}
        for name, value in [*zip(port_names(self.outputs), y, strict=False), *monitors.items()]:
            if not isfinite(value):
                self._fail(f"state {name!r}", name, value, t)
        _, height, nz = _WATCHED
        if not -_CRASH < monitors[nz] < _CRASH:
            self._fail(f"crashed, load factor {nz!r}", nz, monitors[nz], t)
        if monitors[height] < _UNDERGROUND:
            what = f"under the ground, height of the centre of gravity {height!r}"
            self._fail(what, height, monitors[height], t)

    def _flight_key(self) -> str:
        """Text of all parameters, equal if a flight can be repeated."""
        # as a text, because arrays do not compare to one value
        return repr([getattr(self, f.name) for f in fields(self)])

    def to_checkpoint(self, prefix: str, recordings: bool = False) -> tuple[dict, dict]:
        """Refused: JSBSim cannot save its state."""
        why = f"the flight of {self.airframe.aircraft!r} cannot be saved in a checkpoint: JSBSim "
        why += "cannot save its state. studies.branch runs several futures from this instant"
        refuse("checkpoint", prefix, why)
