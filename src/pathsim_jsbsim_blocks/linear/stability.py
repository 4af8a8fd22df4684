"""Stability margins of one loop of a law and an aircraft, and of many loops in a search."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from .._core.checks import refuse
from .._core.continuous import sampled_equivalent
from .._core.extras import required
from .._core.pathsim_internals import port_names, values
from .._core.sampling import SampledLaw
from ..flight.block import FlightBlock
from .model import LinearModel, find

# a cascaded hold's command to its inner loop, and the measurements of the inner loop
_INNER = {"theta_cmd": ("theta", "q"), "phi_cmd": ("phi", "p")}

_SETTLED = 5.0  # s at the trim, for a hold's references to settle
_SLOWEST = 1e-3  # rad/s, minimum frequency of a law's loop
_PER_DECADE = 360  # frequencies
_RANGE = 1e3  # of frequencies beyond the modes: a crossover may be far from them
_JUMP = 2.0  # rad between two frequencies: more is no crossing but the jump at an undamped pole

_GROWTH = 0.02  # 1/s, modes that grow more slowly, such as a spiral, count as stable

EXTRA_DELAY = 0.05  # s


@dataclass(frozen=True, eq=False)
class Margins:
    """Stability margins of a loop L with negative feedback, and its frequency response.

    They apply only if the closed loop is ``stable``; numbers are returned for an unstable one too,
    such as that of a law with the wrong sign.

    Attributes
    ----------
    loop : str
        the law, the point at which its loop is broken, and the laws closed within it
    gain_margin : float
        change of gain in dB at which the loop becomes unstable, the one nearest to 0: positive for
        an increase, negative for a decrease; infinite without a phase crossover
    phase_crossover : float
        frequency in rad/s at which the phase is an odd multiple of 180 deg: also 0, pi / T of a
        sampled loop, and infinity, if the gain is finite there; NaN without one
    phase_margin : float
        deg, the one nearest to 0: positive for added lag, negative for added lead, as at a
        phugoid's peak; infinite without a crossover
    crossover : float
        frequency in rad/s of gain 1, at which the phase margin applies; NaN without one
    delay_margin : float
        additional delay in s at which the loop becomes unstable; infinite without a crossover
    disk_margin : float
        maximum alpha with ``|S - 1/2| < 1 / alpha``, S = 1 / (1 + L), for simultaneous changes of
        gain and phase (balanced, skew 0)
    Ms : float
        maximum sensitivity ``|S|``
    omega : array, shape (k,)
        rad/s
    response : complex array, shape (k,)
        L at these frequencies
    stable : bool or None
        whether all modes of the closed loop are stable or double in more than 35 s; None for a
        frequency response
    """

    loop: str
    gain_margin: float
    phase_crossover: float
    phase_margin: float
    crossover: float
    delay_margin: float
    disk_margin: float
    Ms: float
    omega: np.ndarray
    response: np.ndarray
    stable: bool | None = None

    @property
    def disk_gain_margin(self) -> float:
        """Change of gain in dB that the disk allows, up and down."""
        alpha = self.disk_margin
        return 20 * math.log10((2 + alpha) / (2 - alpha)) if alpha < 2 else math.inf

    @property
    def disk_phase_margin(self) -> float:
        """Change of phase in deg that the disk allows, lag and lead."""
        return 2 * math.degrees(math.atan(self.disk_margin / 2))

    def __str__(self) -> str:
        gain = f"{self.gain_margin:.1f} dB"
        if math.isfinite(self.gain_margin):
            gain += f" at {self.phase_crossover:.3g} rad/s"
        phase = f"{self.phase_margin:.1f} deg"
        if math.isfinite(self.phase_margin):
            phase += f" at {self.crossover:.3g} rad/s"
        disk = f"{self.disk_gain_margin:.1f} dB, {self.disk_phase_margin:.0f} deg"
        return (
            f"{self.loop}: gain margin {gain}, phase margin {phase}, "
            f"delay margin {self.delay_margin:.3g} s, disk margin {self.disk_margin:.2f} ({disk})"
            f"{'; the closed loop is UNSTABLE' if self.stable is False else ''}"
        )


def margins(plant: Any, law: Any = None, *closed: Any) -> Margins:
    """Stability margins of a loop, with exact sampling, hold and latency.

    The loop of a law is broken at its command. For a hold this is the actuator's command, with
    all its measurements fed back; for a hold with an inner loop (heading, course, altitude, climb)
    it is the command to that loop, ``phi_cmd`` or ``theta_cmd``, with the inner loop closed. Loops
    of other laws are open, unless they are in ``closed``.

    Parameters
    ----------
    plant : Aircraft, JSBSimFDM, LinearModel or python-control system
        the aircraft, from which a flown model is identified (0.5 s), or its model; without a law a
        loop L with negative feedback, such as a ``FrequencyResponseData`` or a transfer function
    law : hold, SampledLaw or python-control system
        signed as connected, u = law y: negative feedback includes the minus. A block is engaged
        at the trim, and each port named like an output is connected (in a diagram, only ports with
        a connection). A python-control system has names of the model's outputs and input as
        labels, and the model's sample period if it is discrete
    *closed : hold, SampledLaw or python-control system
        other laws with closed loops

    Returns
    -------
    Margins

    Raises
    ------
    MissingExtraError
        for a law that is not a block, without python-control (extra ``analysis``)
    ParameterError
        for a law with a measurement that the model lacks, naming the nearest, with more than one
        command, or with another sample period
    LinearisationError, LinearizationError
        if the aircraft or the law has no linear model

    References
    ----------
    Seiler, Packard, Gahinet: "An Introduction to Disk Margins", IEEE Control Systems Magazine
    40(5), 2020.

    Examples
    --------
    >>> from pathsim_jsbsim_blocks import Aircraft, PitchHold
    >>> round(margins(Aircraft("c172p", speed=90), PitchHold("c172p")).crossover, 2)  # rad/s
    7.35
    """
    if law is None:
        return _of_loop(plant)
    model = plant.linear_model() if isinstance(plant, FlightBlock) else plant
    if not isinstance(model, LinearModel):
        why = f"plant must be an aircraft or its LinearModel, not {reprlib.repr(plant)}"
        refuse("plant", plant, why)
    outer = _connected("law", law, model)
    if len(outer.commands) > 1:
        why = f"a loop has one command, but {outer.name} has {', '.join(outer.commands)}"
        refuse("law", law, why)
    inner = [_connected("closed", each, model) for each in closed]
    for block, each in zip(closed, inner, strict=True):
        if outer.required and each.required and set(outer.commands) & set(each.commands):
            why = f"{outer.name} and {each.name} move the same command, {', '.join(each.commands)}"
            refuse("closed", block, f"{why}: the inner loop of a hold is closed without it")
    at = outer.commands[0]
    reference = next((x for x in _INNER if x in outer.references), "")
    attitude_outputs = _INNER.get(reference, ())
    if attitude_outputs and set(attitude_outputs) < set(outer.required):
        outer, attitude = outer.parted(attitude_outputs)
        at, inner = reference, [attitude, *inner]

    end = math.pi / model.dt
    modes = np.concatenate([np.linalg.eigvals(model.A), *(x.modes for x in (outer, *inner))])
    omega = _frequencies(modes, _SLOWEST, end)
    name = f"{outer.name} of {model.aircraft}, broken at {at}"
    if inner:
        name += f", closed: {', '.join(each.name for each in inner)}"

    def L(omega: np.ndarray) -> np.ndarray:
        return _loop(model, outer, inner, omega)[0]

    if not L(omega).any():
        why = f"{outer.name} does not respond at the trim: its command is at a limit, as with a"
        refuse("law", law, f"{why} reference far from the trim, or it measures a ground track")
    return _margins(name, omega, L, end, _stable(model, outer, inner))


def _stable(model: LinearModel, outer: _Connected, inner: Sequence[_Connected]) -> bool:
    """Whether no mode of the closed loop grows, by Nyquist's criterion along Re s = _GROWTH."""
    omega = np.r_[0.0, _frequencies(np.empty(0), _SLOWEST, math.pi / model.dt)] - 1j * _GROWTH
    L, difference = _loop(model, outer, inner, omega)
    angle = np.unwrap(np.angle((1 + L) * difference))
    modes = [np.linalg.eigvals(model.A), *(each.modes for each in (outer, *inner))]
    growing = (np.concatenate(modes).real > _GROWTH).sum()
    return bool(growing == round((angle[-1] - angle[0]) / math.pi))


def _loop(
    model: LinearModel, outer: _Connected, inner: Sequence[_Connected], omega: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """L of a law around the aircraft with the inner loops closed, and their return difference."""
    laws = [outer, *inner]
    inputs = list(dict.fromkeys(x for each in laws for x in each.commands))
    outputs = list(dict.fromkeys(x for each in laws for x in each.measured))
    aircraft = model.select(inputs, outputs).frequency_response(omega)

    def widened(law: _Connected) -> np.ndarray:
        wide = np.zeros((len(omega), len(inputs), len(outputs)), dtype=complex)
        rows, columns = find("", inputs, law.commands), find("", outputs, law.measured)
        wide[np.ix_(range(len(omega)), rows, columns)] = law.response(omega)
        return wide

    feedback = sum((widened(each) for each in inner), np.zeros((1, len(inputs), len(outputs))))
    command = aircraft[:, :, [inputs.index(outer.commands[0])]]
    difference = np.eye(len(outputs)) - aircraft @ feedback
    outputs_per_command = np.linalg.solve(difference, command)
    L = -(widened(outer) @ outputs_per_command)[:, inputs.index(outer.commands[0]), 0]
    return L, np.linalg.det(difference)


class _Connected(NamedTuple):
    """A law on the outputs and inputs of a model."""

    name: str
    measured: Sequence[str]  # outputs of the model
    commands: Sequence[str]  # inputs of the model
    required: Sequence[str]  # measurements that the law requires
    references: Sequence[str]  # other outputs of the law
    response: Any  # frequency response at omega, shape (k, commands, measured)
    modes: np.ndarray  # its poles s, 1/s

    def parted(self, feedback: Sequence[str]) -> tuple[_Connected, _Connected]:
        """The law without the ``feedback`` of some outputs, and that feedback as a law."""
        direct = [i for i, x in enumerate(self.measured) if x not in feedback]
        columns = [self.measured.index(x) for x in feedback]
        return (
            self._replace(
                measured=[self.measured[i] for i in direct],
                response=lambda omega: self.response(omega)[:, :, direct],
            ),
            self._replace(
                name=" and ".join(feedback),
                measured=feedback,
                modes=self.modes[:0],
                response=lambda omega: self.response(omega)[:, :, columns],
            ),
        )


def _connected(parameter: str, law: Any, model: LinearModel) -> _Connected:
    if isinstance(law, SampledLaw):
        return _block(parameter, law, model)
    control = required("control", "analysis", name="python-control")
    if not isinstance(law, (control.StateSpace, control.TransferFunction)):
        why = f"{parameter} must be a hold, a sampled law or a python-control system, not"
        refuse(parameter, law, f"{why} {reprlib.repr(law)}")
    measured, commands = law.input_labels, law.output_labels
    if law.issiso() and len(model.inputs) == len(model.outputs) == 1:
        measured, commands = model.outputs, model.inputs
    find(parameter, model.outputs, measured)
    find(parameter, model.inputs, commands)
    is_discrete = law.isdtime(strict=True)
    if is_discrete and law.dt is not True:
        _same_period(parameter, law, law.dt, model)

    def response(omega: np.ndarray) -> np.ndarray:
        at = 1j * omega
        return np.moveaxis(law(np.exp(at * model.dt) if is_discrete else at, squeeze=False), -1, 0)

    modes = _modes(law.poles(), model.dt if is_discrete else None)
    return _Connected(law.name, measured, commands, (), (), response, modes)


def _modes(poles: np.ndarray, T: float | None) -> np.ndarray:
    """Poles s in 1/s; with a period T those of poles z = exp(s T)."""
    with np.errstate(divide="ignore"):
        return np.log(np.abs(poles)) / T + 1j * np.angle(poles) / T if T else poles


def _block(parameter: str, law: SampledLaw, model: LinearModel) -> _Connected:
    _same_period(parameter, law, law.clock.period, model)
    ports, outputs = port_names(law.inputs), port_names(law.outputs)
    wires = law.inputs.wired or set(ports)
    find(parameter, model.outputs, law.measured)
    measured = [x for x in ports if x in wires and x in model.outputs]
    commands = [x for x in law.commands or outputs if x in outputs]
    find(parameter, model.inputs, commands)
    if not measured:
        why = f"no port of {type(law).__name__} has the name of an output of the model"
        refuse(parameter, law, f"{why}: {', '.join(ports)}; give a python-control system")
    u, state = [0.0] * len(values(law.inputs)), law.initial_state()
    for x in measured:
        u[ports[x]] = float(model.y0[model.outputs.index(x)])
    for _ in range(round(_SETTLED / model.dt)):
        _, state = law.law(u, state)
    A, B, C, D = sampled_equivalent(law.law, u, state, type(law).__name__)
    rows, columns = [outputs[x] for x in commands], [ports[x] for x in measured]
    B, C, D = B[:, columns], C[rows], D[np.ix_(rows, columns)]

    def response(omega: np.ndarray) -> np.ndarray:
        z = np.exp(1j * omega * model.dt)[:, None, None]
        return C @ np.linalg.solve(z * np.eye(len(A)) - A, B) + D

    references = [x for x in outputs if x not in commands]
    modes = _modes(np.linalg.eigvals(A), model.dt)
    name = type(law).__name__
    return _Connected(name, measured, commands, law.measured, references, response, modes)


def _same_period(parameter: str, law: Any, T: float, model: LinearModel) -> None:
    if not math.isclose(T, model.dt, rel_tol=1e-9):
        why = f"the law is sampled every {T:.6g} s, the aircraft every {model.dt:.6g} s"
        refuse(parameter, law, f"{why}: give both the same period")


def _of_loop(loop: Any) -> Margins:
    """Margins of a loop of python-control: of a system at its own modes, not at a grid alone."""
    control = required("control", "analysis", name="python-control")
    system = isinstance(loop, (control.StateSpace, control.TransferFunction))
    if not (system or isinstance(loop, control.FrequencyResponseData)) or not loop.issiso():
        why = "without a law, plant must be a python-control loop with one input and one output"
        refuse("plant", loop, f"{why}, not {reprlib.repr(loop)}")
    if not system:
        order = np.argsort(loop.omega)
        omega, measured = np.asarray(loop.omega)[order], loop.frdata[0, 0, order]
        between = control.FrequencyResponseData(measured, omega, smooth=True)
        return _margins(loop.name, omega, lambda omega: between(1j * omega), None, None)
    T = loop.dt if loop.isdtime(strict=True) else None
    poles = _modes(control.feedback(loop).poles(), T)
    modes = np.concatenate([poles, _modes(loop.poles(), T), _modes(loop.zeros(), T)])
    rates = np.abs(modes[np.isfinite(modes) & (modes != 0)])
    high = math.pi / T if T else _RANGE * rates.max(initial=1.0)
    omega = _frequencies(modes, min(rates.min(initial=1.0), high) / _RANGE, high)

    def L(omega: np.ndarray) -> np.ndarray:
        return loop(np.exp(1j * omega * T) if T else 1j * omega, warn_infinite=False)

    stable = bool((poles.real <= _GROWTH).all())
    return _margins(loop.name, omega, L, high if T else math.inf, stable)


def _frequencies(modes: np.ndarray, low: float, high: float) -> np.ndarray:
    """Frequencies from ``low`` to ``high``, close together at modes of little damping."""
    count = math.ceil(_PER_DECADE * math.log10(high / low))
    modes = modes[np.abs(modes.real) < 0.05 * modes.imag]
    # the phase turns within the damping of a mode
    width = np.maximum(np.abs(modes.real), 1e-9 * modes.imag)
    dense = modes.imag[:, None] + width[:, None] * np.sinh(np.linspace(-12, 12, 241))
    dense = dense[(dense > low) & (dense < high)]
    even = np.geomspace(low, high * (1 - 1e-9), count)  # a pole may be at pi/T
    return np.unique([*even, *dense])


@np.errstate(divide="ignore", invalid="ignore")  # L is 0 at a zero, S infinite at an undamped mode
def _margins(
    name: str,
    omega: np.ndarray,
    L: Callable[[np.ndarray], np.ndarray],
    end: float | None,  # rad/s: pi / T, or infinite; None if L is known at omega only
    stable: bool | None,
) -> Margins:
    """Margins of a response, each at its own frequency."""
    response = L(omega)
    at_phase = _crossings(L, omega, response, lambda L: np.angle(-L))
    gains = -1 / L(at_phase).real
    if end is not None:
        far = omega[-1] * 1e3 if math.isinf(end) else end * (1 - 2e-9)
        for at, omega_1 in ((0.0, omega[0] * 1e-3), (end, far)):
            omega_2 = (omega_1 + at) / 2 if at < math.inf else 2 * omega_1
            value, limit = L(np.array([omega_1, omega_2]))
            # real and finite at 0, pi / T or infinity: the gain at which a pole is there
            if limit.real < 0 and abs(limit - value) < 1e-2 * abs(limit) > 1e2 * abs(limit.imag):
                at_phase, gains = np.append(at_phase, at), np.append(gains, -1 / limit.real)
    gains = 20 * np.log10(gains)
    at_gain = _crossings(L, omega, response, lambda L: np.log(np.abs(L)))
    angles = np.degrees(np.angle(L(at_gain)))
    phases = np.mod(angles, 360.0) - 180.0
    delays = np.radians(np.mod(phases, 360.0)) / at_gain
    gain, phase = (np.argmin(np.abs(x)) if len(x) else None for x in (gains, phases))
    S = 1 / (1 + response)
    return Margins(
        name,
        math.inf if gain is None else float(gains[gain]),
        math.nan if gain is None else float(at_phase[gain]),
        math.inf if phase is None else float(phases[phase]),
        math.nan if phase is None else float(at_gain[phase]),
        float(delays.min(initial=math.inf)),
        float(1 / np.abs(S - 0.5).max()),
        float(np.abs(S).max()),
        omega,
        response,
        stable,
    )


def _crossings(
    L: Callable[[np.ndarray], np.ndarray],
    omega: np.ndarray,
    response: np.ndarray,
    measure: Callable[[np.ndarray], np.ndarray],
) -> np.ndarray:
    """Frequencies at which a measure of L is 0, each between two of ``omega``."""
    values = measure(response)
    # the phase jumps at an undamped pole, and where it passes 180 deg
    between = (np.diff(np.sign(values)) != 0) & (np.abs(np.diff(values)) < _JUMP)
    return np.array(
        [
            brentq(lambda w: measure(L(np.array([w])))[0], *omega[i : i + 2], xtol=1e-12 * omega[i])
            for i in np.flatnonzero(between)
        ]
    )


@dataclass(frozen=True)
class LoopMargins:
    """Margins of many loops, arrays of shape (loops,), for a search over thousands."""

    crossover: np.ndarray  # highest frequency at which the gain is 1, rad/s; 0 without one
    gain: np.ndarray  # minimum of up and down, dB; infinite without a phase crossover
    phase: np.ndarray  # minimum, deg; infinite without a crossover
    Ms: np.ndarray  # maximum sensitivity |1 / (1 + L)|
    Ms_delayed: np.ndarray  # the same with EXTRA_DELAY added


def loop_margins(omega: np.ndarray, L: np.ndarray) -> LoopMargins:
    """Margins of the loops ``L``, shape (loops, frequencies), with negative feedback."""
    size = np.abs(L)
    phase = np.unwrap(np.angle(L), axis=1)
    log = np.log(np.maximum(size, 1e-300))
    # crossovers, interpolated in the logarithms of gain and frequency
    crosses = (log[:, :-1] > 0.0) != (log[:, 1:] > 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        fraction = np.where(crosses, log[:, :-1] / (log[:, :-1] - log[:, 1:]), 0.0)
    angle = phase[:, :-1] + fraction * np.diff(phase, axis=1)
    distance = np.degrees(np.abs(np.mod(angle, 2 * np.pi) - np.pi))
    pm = np.where(crosses, distance, np.inf).min(axis=1)
    frequency = np.exp(np.log(omega[:-1]) + fraction * np.diff(np.log(omega)))
    crossover = np.where(crosses, frequency, 0.0).max(axis=1)
    # phase crossovers, at odd multiples of 180 deg
    turns = np.floor((phase + np.pi) / (2 * np.pi))
    crosses = turns[:, :-1] != turns[:, 1:]
    edge = (np.maximum(turns[:, :-1], turns[:, 1:]) * 2 - 1) * np.pi
    with np.errstate(divide="ignore", invalid="ignore"):
        fraction = np.where(crosses, (edge - phase[:, :-1]) / np.diff(phase, axis=1), 0.0)
    level = log[:, :-1] + fraction * np.diff(log, axis=1)
    gm = np.where(crosses, np.abs(level), np.inf).min(axis=1) * 20 / np.log(10)
    L_late = L * np.exp(-1j * omega * EXTRA_DELAY)
    return LoopMargins(
        crossover, gm, pm, 1 / np.abs(1 + L).min(axis=1), 1 / np.abs(1 + L_late).min(axis=1)
    )
