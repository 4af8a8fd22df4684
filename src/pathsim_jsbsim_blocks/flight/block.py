"""`FlightBlock`: what all aircraft blocks share."""

from __future__ import annotations

import inspect
import math
import time
from array import array
from collections.abc import Mapping, Sequence
from threading import get_ident
from typing import Any

import jsbsim
import numpy as np
from pathsim.utils.portreference import PortReference

from .._core._pathsim import port_names, show, values
from .._core.checks import flag, number, positive, whole
from .._core.docs import filler
from .._core.ports import NamedPorts
from .._core.sampling import SHORTEST_PERIOD, SampledPlant
from ..errors import CopyError, FlightError, ParameterError, PropertyError
from ._trim import TrimState, trim
from .airframe import Airframe
from .condition import TrimCondition
from .console import capture_console, log

# s; with longer steps than these JSBSim's integration is unstable
_LONGEST_STEP = 0.1

# any NaN or inf in the state shows up here within one step
_WATCHED = ("velocities/vt-fps", "position/h-agl-ft", "accelerations/Nz")

# g; beyond any flyable load factor; ground springs of a crashed model give hundreds
_CRASH = 50.0

# ft above the terrain; JSBSim lets a centre of gravity sink below this
_UNDERGROUND = -1.0

# what the manual pages of the aircraft blocks share
fill = filler(
    configuration="""
    gear : float, optional
        0 (up) to 1 (down); default is the model's own setting
    flaps : float, optional
        0 (up) to 1 (fully down); default is the model's own setting
    """,
    written="""
    setup : dict, optional
        properties written before initialisation and trim (fuel, payload)
    properties : dict, optional
        properties written after the trim (turbulence)
    """,
    surroundings="""
    create : dict, optional
        properties that the model expects from its environment (FlightGear), with their values
    record_inputs : bool
        keep the inputs flown (8 bytes per input and sample), which checkpoints need
    allow_network : bool
        let the model open the sockets that its XML asks for
    allow_files : bool
        let the model write the files that its XML asks for
    """,
    raises="""
    Raises
    ------
    AircraftError, PropertyError, ParameterError, TrimError
        when the block is built: unknown names and values that cannot be, or no trim
    FlightError
        in flight, when an input or the state is not finite, the aircraft has crashed or is under
        the ground, or something else runs or holds it
    """,
)


class FlightBlock(NamedPorts, SampledPlant):
    """What the aircraft blocks share: life, time, inputs and outputs of one JSBSim aircraft."""

    # trim keywords of the block, which a condition replaces, and the condition's names of them
    _trim_keywords: Mapping[str, str]

    def __init__(
        self,
        T: float,
        substeps: int,
        *,
        condition: TrimCondition | None,
        setup: Mapping[str, float] | None,
        properties: Mapping[str, float] | None,
        root: str | None,
        create: Mapping[str, float] | None,
        record_inputs: bool,
        allow_network: bool,
        allow_files: bool,
    ):
        self.substeps = substeps
        self.condition = condition
        self.setup = setup
        self.properties = properties
        self.root = root
        self.create = create
        self.record_inputs = flag("record_inputs", record_inputs)
        self.allow_network = allow_network
        self.allow_files = allow_files
        super().__init__(T)
        self.airframe: Airframe
        self.trim: TrimState

    def _model(self) -> str:
        """Name of the model that the block's parameters ask for."""
        raise NotImplementedError

    def _condition(self) -> TrimCondition:
        """The condition that the block's parameters ask for.

        Raises
        ------
        ParameterError
            for a condition next to flat trim keywords that are not at their defaults
        """
        given = {name: getattr(self, name) for name in self._trim_keywords}
        if self.condition is None:
            return TrimCondition(**{self._trim_keywords[n]: v for n, v in given.items()})
        if not isinstance(self.condition, TrimCondition):
            raise ParameterError(
                f"condition must be a TrimCondition, not {self.condition!r}",
                parameter="condition",
                value=self.condition,
            )
        # a user's subclass may have other parameters
        block = next(c for c in type(self).__mro__ if "_trim_keywords" in vars(c))
        parameters = inspect.signature(block).parameters
        for name, value in given.items():
            if np.any(value != parameters[name].default):  # an array is refused here too
                raise ParameterError(
                    f"both condition and {name}={value!r} are given: put {name} into the condition",
                    parameter=name,
                    value=value,
                )
        return self.condition

    def _connect(self) -> None:
        """Find the properties behind the ports in a fresh, trimmed airframe."""
        raise NotImplementedError

    def _write(self, u: list[float]) -> None:
        """Write the inputs of one sample period to the aircraft."""
        raise NotImplementedError

    def _read(self) -> list[float]:
        """Read the outputs."""
        raise NotImplementedError

    def take_off(self) -> None:
        """Load, initialise and trim a fresh aircraft and show its state."""
        self._substeps = whole("substeps", self.substeps, low=1)
        dt = number(
            "T / substeps",
            positive("T", self.T) / self._substeps,
            low=SHORTEST_PERIOD,
            high=_LONGEST_STEP,
        )
        condition = self._condition()
        self.airframe = Airframe(
            self._model(),
            dt,
            root=self.root,
            empty_cg_x=condition.empty_cg_x,
            create=self.create,
            allow_network=self.allow_network,
            allow_files=self.allow_files,
        )
        self.trim = trim(self.airframe, condition, self.setup)
        self._speed, self._height, self._nz = (self.airframe.reader(name) for name in _WATCHED)
        self._connect()
        self.airframe.write(self.properties, "properties")
        self._thread = get_ident()
        self._n_inputs = len(port_names(self.inputs))
        self._n_outputs = len(port_names(self.outputs))
        self._step, self._period = dt, dt * self._substeps
        self._time_zero = self.airframe.fdm.get_sim_time()
        # index of the instant to which the aircraft is or was on its way
        self._begun = 0
        self._flown = array("d")
        self._flying = self._flight()
        self.start_from(self._observe(0.0))

    @property
    def fdm(self) -> jsbsim.FGFDMExec:
        """The live ``jsbsim.FGFDMExec``, for inspection only; `reset` replaces it."""
        return self.airframe.fdm

    def __getitem__(self, key: Any) -> PortReference:
        reference = super().__getitem__(key)
        for port in reference.ports:
            if isinstance(port, int) and port >= max(self._n_inputs, self._n_outputs):
                raise PropertyError(
                    f"{type(self).__name__} has {self._n_inputs} inputs and {self._n_outputs} "
                    f"outputs, no port {port}",
                    aircraft=self.airframe.aircraft,
                    name=str(port),
                )
        return reference

    def _no_port(self, message: str, port: str, close: Sequence[str]) -> PropertyError:
        return PropertyError(message, aircraft=self.airframe.aircraft, name=port, nearest=close)

    def __reduce_ex__(self, protocol: Any) -> Any:
        # copy.copy and copy.deepcopy ask here too
        name, aircraft = type(self).__name__, self.airframe.aircraft
        raise CopyError(
            f"{name} {aircraft!r} cannot be copied or pickled: JSBSim's state stays in its "
            f"process. Build another {name} with the same parameters; to go on from here, save the "
            "diagram with save_checkpoint and load it there",
            block=name,
            aircraft=aircraft,
        )

    def reset(self) -> None:
        """Fly the same flight again: a fresh aircraft, loaded and trimmed as at first."""
        super().reset()
        self.take_off()

    def latch(self) -> list[float]:
        u = values(self.inputs)
        if len(u) > self._n_inputs:
            raise ParameterError(
                f"input port {len(u) - 1} of {type(self).__name__} is wired, but the block has "
                f"{self._n_inputs} inputs",
                parameter="inputs",
                value=len(u),
            )
        if not math.isfinite(sum(u)):
            for port, value in zip(port_names(self.inputs), u, strict=False):
                if not math.isfinite(value):
                    self._fail(
                        f"input {port!r}",
                        port,
                        value,
                        self.clock.start + self.samples * self.clock.period,
                    )
        return u

    def advance(self, index: int, u: list[float]) -> list[float]:
        if (thread := get_ident()) != self._thread:
            # a diagram may go on in another thread, where JSBSim's console is another one
            self._thread = thread
            capture_console()
        # an interrupt may have come before the inputs were written, or between the steps
        done = self._steps_since(index - 1) if self._begun == index else 0
        if not done:
            self._begun = index
            self._write(u)
        run = self.airframe.fdm.run
        for _ in range(self._substeps - done):
            run()
        clock = self.clock
        t = clock.start + index * clock.period
        time = self.airframe.fdm.get_sim_time() - self._time_zero
        if abs(time - index * self._period) > 0.5 * self._step:
            raise FlightError(
                f"aircraft {self.airframe.aircraft!r}: its clock shows {time:.9g} s after "
                f"{index} periods of {clock.period:.9g} s: something else runs or holds it. "
                "Fly on after a reset",
                aircraft=self.airframe.aircraft,
                time=t,
                name="simulation/sim-time-sec",
                value=time,
            )
        y = self._observe(t)
        if self.record_inputs is True:
            before = (index - 1) * self._n_inputs
            if len(self._flown) >= before:
                self._flown[before:] = array("d", u)
        return y

    def _steps_since(self, index: int) -> int:
        """JSBSim's own count of its steps since an instant."""
        time = self.airframe.fdm.get_sim_time() - self._time_zero
        return round(time / self._step) - index * self._substeps

    def _observe(self, t: float) -> list[float]:
        """The outputs; at ``t`` the flight ends if the aircraft cannot be flown on."""
        y = self._read()
        height, nz = self._height(), self._nz()
        if not (
            math.isfinite(sum(y) + self._speed())
            and height >= _UNDERGROUND
            and -_CRASH < nz < _CRASH
        ):
            for name, value in [
                *zip(port_names(self.outputs), y, strict=False),
                *((name, self.airframe.fdm[name]) for name in _WATCHED),
            ]:
                if not math.isfinite(value):
                    self._fail(f"state {name!r}", name, value, t)
            if -_CRASH < nz < _CRASH:
                self._fail(
                    f"under the ground, height of the centre of gravity {_WATCHED[1]!r}",
                    _WATCHED[1],
                    height,
                    t,
                )
            self._fail(f"crashed, load factor {_WATCHED[2]!r}", _WATCHED[2], nz, t)
        return y

    def _fail(self, what: str, name: str, value: float, t: float) -> None:
        raise FlightError(
            f"aircraft {self.airframe.aircraft!r}: {what} is {value} at t = {t:.9g} s",
            aircraft=self.airframe.aircraft,
            time=t,
            name=name,
            value=value,
        )

    def _flight(self) -> str:
        """What the parameters ask for: the same for a flight to be flown again."""
        return (
            f"{self._model()} at {self._condition()}, T={positive('T', self.T)!r}, "
            f"substeps={self.substeps}, setup={self.setup}, properties={self.properties}, "
            f"create={self.create}, root={self.root}, "
            f"inputs={list(port_names(self.inputs))}, outputs={list(port_names(self.outputs))}"
        )

    def to_checkpoint(self, prefix: str, recordings: bool = False) -> tuple[dict, dict]:
        """Save the flight as the inputs flown: JSBSim's state itself cannot be saved.

        Raises
        ------
        ParameterError
            if the aircraft has flown and ``record_inputs`` is or was off
        """
        flown = max(self._results)
        if len(self._flown) != flown * self._n_inputs:
            raise ParameterError(
                f"the flight of {self.airframe.aircraft!r} cannot be saved: not all of its inputs "
                f"were recorded. Build the block with record_inputs=True",
                parameter="record_inputs",
                value=self.record_inputs,
            )
        json_data, npz_data = super().to_checkpoint(prefix, recordings)
        latched, u = self._latched
        json_data.update(flight=self._flying, samples=flown, latched=latched)
        npz_data[f"{prefix}/flown"] = np.array(self._flown)
        npz_data[f"{prefix}/latched"] = np.array(u)
        return json_data, npz_data

    def load_checkpoint(self, prefix: str, json_data: dict, npz: Any) -> None:
        """Fly a saved flight again on a fresh aircraft, with the inputs recorded.

        Raises
        ------
        ParameterError
            if the checkpoint is of another flight, or flying it again ends elsewhere
        """
        flight = json_data.get("flight")
        if flight != self._flight():
            raise ParameterError(
                f"the checkpoint is of another flight: {flight}; this block flies {self._flight()}",
                parameter="checkpoint",
                value=flight,
            )
        super().load_checkpoint(prefix, json_data, npz)
        start = time.perf_counter()
        saved = self.outputs.to_array()
        self.take_off()
        samples, kept = json_data["samples"], json_data["index"] - 1
        rows = npz[f"{prefix}/flown"].reshape(samples, self._n_inputs).tolist()
        self._results = results = {0: self._results[kept]}
        for index, row in enumerate(rows, 1):
            results[index] = self.advance(index, row)
            if index <= kept:
                del results[index - 1]
        self._flown = array("d", npz[f"{prefix}/flown"].tolist())
        self._latched = json_data["latched"], npz[f"{prefix}/latched"].tolist()
        if not any(np.array_equal(y, saved) for y in results.values()):
            raise ParameterError(
                "the recorded inputs lead to another state than the one saved: is it the same "
                "version of jsbsim?",
                parameter="checkpoint",
                value=flight,
            )
        show(self.outputs, saved)
        log.info("flew %d recorded samples again in %.2f s", samples, time.perf_counter() - start)
