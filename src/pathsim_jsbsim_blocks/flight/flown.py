"""Linear models from flight: small opposite pulses through the aircraft's own sampled map."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from mmap import mmap
from typing import TYPE_CHECKING

import numpy as np

from .._core._pathsim import values
from .._core.callers import warn_user
from .._core.checks import did_you_mean, mapping, nearest, positive, refuse
from ..errors import FlightError, LinearisationError
from ..linear.identification import Realisation, realise, respond
from ..linear.model import LinearModel, find
from .airframe import Airframe
from .channels import (
    RIGID,
    Channel,
    acceleration,
    as_shown,
    driven,
    engine_channels,
    full_circle,
    ignorable,
)
from .rehearsal import rehearse

if TYPE_CHECKING:
    from .block import FlightBlock

# s; a pulse of this length moves the attitude little and the accelerations enough
_PULSE = 0.025

# s; the phugoid is identified from a fraction of its period, because the data have no noise
_DURATION = 8.0

# s; samples 0.4 s apart show a short period of 8 rad/s as a slower one
_LONGEST_PERIOD = 0.25

# samples before the pulse: the first step sets the spools of a turbine to the throttle
_SETTLING = 3

# of full travel. A turbine's spools accelerate at a constant rate: only small pulses are linear
_TURBINE_THROTTLE, _PISTON_THROTTLE = 1e-3, 1e-2

# other inputs, by unit
_AMPLITUDES = {"norm": 5e-3, "deg": 0.1, "rad": 1e-3, "ft/s": 0.1, "kt": 0.1}

# responses below this fraction of the largest one of an output have no meaningful shape
_HARDLY = 0.3

# but these are judged however small: what each command is for
_PURPOSES = {
    "fcs/elevator-cmd": ("theta", "q"),
    "fcs/aileron-cmd": ("phi", "p"),
    "fcs/rudder-cmd": ("beta", "r"),
    "fcs/throttle-cmd": ("vt",),
}

# a doublet follows the pulse, to see how far the model holds: s each way, times the pulse's
# height, and of full travel for a throttle
_WAY, _DOUBLET, _DOUBLET_THROTTLE = 1.0, 2.0, 0.01

# relative to the size of a signal: no response at all
_NOTHING = 1e-9

# even over odd part of a response: worth a warning (above 10 %, in the whole percent that it is
# told in), and no linear response at all
_KINKED, _BROKEN = 0.105, 0.5

# error after a doublet that is worth a warning, in what a command is for and in the rest: drag is
# even, so that the airspeed follows no elevator within 5 %
_MISSED, _MISSED_ELSEWHERE = 0.05, 0.15

# growth, as the exponent, with which an aircraft is still near its trim after the pulse
_GROWTH = 3.0

# s of processor time from which on loading and trimming costs more than a copy of the process
_LONG = 0.1

# s of processor time for a flight in such a copy
_LONGEST_FLIGHT = 60

# largest error of a model that is one
_WORST_FIT = 0.3


def flown_model(
    build: Callable[[], FlightBlock],
    inputs: Sequence[str] | None,
    outputs: Sequence[str] | None,
    amplitude: Mapping[str, float] | None,
) -> LinearModel:
    """Identify a model from flights of blocks that ``build`` makes, each a fresh aircraft.

    The other parameters, and the errors, are those of `FlightBlock.linear_model`.
    """
    start = time.process_time()
    block = build()
    slow = time.process_time() - start > _LONG
    if block.T > _LONGEST_PERIOD:
        raise LinearisationError(
            f"no linear model of {block.airframe.aircraft!r}: samples every {block.T:g} s do not "
            f"show its short period; identify a block with T up to {_LONGEST_PERIOD:g} s, or use "
            "method='algebraic'",
            aircraft=block.airframe.aircraft,
            reason="no fit",
        )
    ports, channels = block.channels()
    wanted = find("inputs", [c.name for c in ports], inputs)
    moved = driven(block.airframe, ports, wanted, inputs is not None)
    names = [ports[i].name for i in moved]
    if not moved:
        raise LinearisationError(
            f"no linear model of {block.airframe.aircraft!r}: there is no input to move; give the "
            "block inputs, or use method='algebraic'",
            aircraft=block.airframe.aircraft,
            reason="no response",
        )
    chosen = find("outputs", [c.name for c in channels], outputs)
    heights = _heights(block.airframe, [ports[i] for i in moved], amplitude)
    engines = engine_channels(block.airframe)
    # one signal for each property: outputs, states and engine states share them
    signals: dict[str, Channel] = {}
    for channel in [*RIGID, *engines, *(channels[i] for i in chosen)]:
        for name in channel.properties[:1]:
            signals.setdefault(block.airframe.canonical(name), channel)
    listed = list(signals.values())
    flights = _Flights(build, signals, block.T)
    commands = [
        flights.commands(
            height,
            _DOUBLET_THROTTLE
            if _is_throttle(ports[i]) and ports[i].name not in mapping("amplitude", amplitude)
            else _DOUBLET * height,
        )
        for i, height in zip(moved, heights, strict=True)
    ]
    pairs = [
        [flights.from_trim(block, slow, port, sign * command) for sign in (1, -1)]
        for port, command in zip(moved, commands, strict=True)
    ]
    still = flights.fly(block, None, np.zeros_like(commands[0]))
    odd, even = [], []
    for port, height, (up, down) in zip(moved, heights, pairs, strict=True):
        odd.append((up - down) / 2)
        even.append((up + down) / 2 - still)
        if np.all(_rms(odd[-1][: flights.pulsed]) < _nothing(still)):
            raise LinearisationError(
                f"no linear model of {block.airframe.aircraft!r}: it does not respond to "
                f"{ports[port].name!r} within +-{height:g}; leave that out of the inputs, or "
                f"choose a larger amplitude",
                aircraft=block.airframe.aircraft,
                reason="no response",
                name=ports[port].name,
            )
    pulsed = np.array([y[: flights.pulsed] for y in odd])
    kinked = _ratio([y[: flights.pulsed] for y in even], pulsed, _nothing(still))
    # what answers alike to up and down does not answer in the first order
    mute = [i for i in range(len(listed)) if np.all(kinked[i] > _BROKEN)]
    motion = [i for i, c in enumerate(listed) if c in RIGID]
    rigid = [i for i in motion if i not in mute]
    responds = (_rms(pulsed) > _nothing(still)).T
    _judge_inputs(block.airframe.aircraft, names, np.where(responds, kinked, np.nan)[motion])
    g = pulsed / np.reshape(heights, (-1, 1, 1))
    rms = np.sqrt((g**2).mean(axis=1)).T
    kinked[rms < _HARDLY * rms.max(axis=1, keepdims=True)] = np.nan
    kinked[mute] = np.nan
    g[:, :, mute] = 0.0
    integrals = [i for i, c in enumerate(listed) if ignorable(c) and i not in mute]
    # a heading first, then positions, which depend on it
    integrals.sort(key=lambda i: not listed[i].properties[0].startswith("attitude/"))
    found = realise(
        g,
        block.T,
        flights.width,
        rigid=[i for i in rigid if i not in integrals],
        engines=[i for i, c in enumerate(listed) if c in engines and i not in mute],
        integrals=integrals,
        abrupt=[i for i, c in enumerate(listed) if acceleration(c) and i not in mute],
    )
    meant = np.array([[_is_for(ports[i], c) for c in listed] for i in moved])
    predicted = respond(found, np.array(commands).T, block.T)
    for j, i in enumerate(moved):
        # a spool takes the longer the further it goes: what the pulse shows is no delay at all
        if _is_throttle(ports[i]):
            seen = [k for k in np.flatnonzero(meant[j]) if k not in mute]
            later = flights.later(odd[j][:, seen], predicted[j][:, seen])
            found.latency[j] += later
            predicted[j, later:] = predicted[j, : len(predicted[j]) - later]
    doublets = _Doublets(
        np.array(odd)[:, flights.pulsed :],
        np.array(even)[:, flights.pulsed :],
        predicted[:, flights.pulsed :],
        meant,
    )
    upwards, downwards, uneven = doublets.missed(1), doublets.missed(-1), doublets.uneven()
    upwards[mute] = downwards[mute] = uneven[mute] = np.nan
    shown = [listed[i].name for i in rigid]
    _judge_fit(block.airframe.aircraft, names, shown, found.error[rigid])
    # an unstable aircraft is far from its trim by now
    if np.linalg.eigvals(found.A).real.max(initial=0.0) * _DURATION < _GROWTH:
        _judge_fit(block.airframe.aircraft, names, shown, doublets.missed_of_largest()[rigid])
    kinked, error = np.fmax(kinked, uneven), np.fmax(found.error, upwards)
    limit = np.where(meant.T, _MISSED, _MISSED_ELSEWHERE)
    beyond = np.fmax(kinked / _KINKED, error / limit)
    error = np.fmax(error, downwards)
    reasons = [_reason(block.airframe, ports[i]) for i in moved]
    told = beyond[rigid], kinked[rigid], error[rigid]
    _warn(block.airframe.aircraft, names, reasons, shown, *told)
    return _named(block, found, signals, chosen, moved, still[0], kinked, error)


class _Doublets:
    """Responses to the doublets, and what the model predicts: shape (inputs, samples, signals)."""

    def __init__(self, odd: np.ndarray, even: np.ndarray, predicted: np.ndarray, meant: np.ndarray):
        self._odd, self._even, self._predicted = odd, even, predicted
        size = _rms(odd)
        hardly = (size < _HARDLY * size.max(axis=0, initial=0.0)) & ~meant
        self._hardly = hardly | (size == 0.0)

    def missed(self, sign: int) -> np.ndarray:
        """Error over response, shape (signals, inputs); NaN where a signal hardly responds.

        The response is that to the doublet that begins upwards (1) or downwards (-1), with its even
        part.
        """
        even = sign * self._even
        return self._over(_rms(self._odd + even - self._predicted), _rms(self._odd + even))

    def missed_of_largest(self) -> np.ndarray:
        """Error over the signal's largest response to any input, likewise."""
        largest = np.broadcast_to(_rms(self._odd).max(axis=0, initial=0.0), self._hardly.shape)
        return self._over(_rms(self._odd - self._predicted), largest)

    def uneven(self) -> np.ndarray:
        """Even part over odd part, likewise."""
        return self._over(_rms(self._even), _rms(self._odd))

    def _over(self, part: np.ndarray, whole: np.ndarray) -> np.ndarray:
        return np.where(self._hardly, np.nan, part / np.where(self._hardly, 1.0, whole)).T


class _Flights:
    """Flights with a pulse on one input each and a doublet after it, and what is recorded."""

    def __init__(self, build: Callable[[], FlightBlock], signals: Mapping[str, Channel], T: float):
        self._build, self._signals = build, signals
        self.width = max(round(_PULSE / T), 1)
        self._n = round(_DURATION / T / self.width) * self.width
        self._way = max(round(_WAY / T), 1)
        # samples of the response to the pulse
        self.pulsed = self._n + 1

    def commands(self, height: float, doublet: float) -> np.ndarray:
        """A pulse, and a doublet after its response, over all periods of a flight."""
        u = np.zeros(2 * self._n)
        u[: self.width] = height
        u[self._n :][: self._way] = doublet
        u[self._n + self._way :][: self._way] = -doublet
        return u

    def later(self, odd: np.ndarray, predicted: np.ndarray) -> int:
        """Periods by which the doublet's first way acts later than a model has it."""
        start, end = self.pulsed, self.pulsed + self._way
        errors = [
            float(((odd[start:end] - predicted[start - k : end - k]) ** 2).sum())
            for k in range(self._way)
        ]
        return int(np.argmin(errors))

    def from_trim(
        self, plane: FlightBlock, copied: bool, port: int, commands: np.ndarray
    ) -> np.ndarray:
        """The signals of `fly`, from a copy of the plane or another one: this one stays there."""
        if copied:
            # the last byte tells that the flight has ended well
            shared = mmap(-1, 8 * (len(commands) + 1) * len(self._signals) + 1)

            def fly() -> None:
                shared[:] = self.fly(plane, port, commands).tobytes() + b"y"

            rehearse(fly, _LONGEST_FLIGHT)
            if shared[-1:] == b"y":
                return np.frombuffer(shared[:-1]).reshape(len(commands) + 1, -1)
        return self.fly(self._build(), port, commands)

    def fly(self, plane: FlightBlock, port: int | None, commands: np.ndarray) -> np.ndarray:
        """Signals from the start of the pulse on, shape (samples, signals)."""
        readers = [plane.airframe.reader(name) for name in self._signals]
        u = values(plane.inputs)
        trimmed = plane.trimmed_inputs()
        u[: len(trimmed)] = trimmed
        y = np.empty((len(commands) + 1, len(readers)))
        try:
            for k in range(1, _SETTLING + 1):
                plane.advance(k, u)
            y[0] = [read() for read in readers]
            for k, command in enumerate(commands.tolist(), 1):
                if port is not None:
                    u[port] = trimmed[port] + command
                plane.advance(_SETTLING + k, u)
                y[k] = [read() for read in readers]
        except FlightError as error:
            raise LinearisationError(
                f"no linear model of {plane.airframe.aircraft!r}: left to itself it does not "
                f"stay in the air for {2 * _DURATION:g} s: {error}",
                aircraft=plane.airframe.aircraft,
                reason="no fit",
            ) from error
        for i, channel in enumerate(self._signals.values()):
            if circle := full_circle(channel):
                y[:, i] = np.unwrap(y[:, i], period=circle / channel.factor)
        return y


def _rms(x: np.ndarray) -> np.ndarray:
    """Over the samples, the last axis but one."""
    return np.sqrt((x**2).mean(axis=-2))


def _nothing(still: np.ndarray) -> np.ndarray:
    """Size of a response of each signal that is none."""
    return _NOTHING * (1.0 + np.abs(still).max(axis=0))


def _ratio(even: Sequence[np.ndarray], odd: np.ndarray, least: np.ndarray) -> np.ndarray:
    """Even over odd parts, shape (signals, inputs)."""
    return (_rms(np.array(even)) / np.maximum(_rms(odd), least)).T


def _is_throttle(port: Channel) -> bool:
    return any(name.startswith("fcs/throttle-cmd") for name in port.properties)


def _is_for(port: Channel, signal: Channel) -> bool:
    """Whether moving the signal is what the command is for."""
    return any(
        name.startswith(command) and signal.name in signals
        for name in port.properties
        for command, signals in _PURPOSES.items()
    )


def _reason(airframe: Airframe, port: Channel) -> str:
    """Why the response to a turbine's throttle is not linear; "" where the reason is not known.

    With a piston engine it may be the thrust (pa28) or the aircraft's motion (Camel).
    """
    spools = any(airframe.has(f"propulsion/engine[{i}]/n2") for i in range(airframe.engines))
    if _is_throttle(port) and spools:
        return " (a turbine's spools accelerate at constant rates)"
    return ""


def _heights(
    airframe: Airframe, ports: Sequence[Channel], amplitude: Mapping[str, float] | None
) -> list[float]:
    """Height of the pulse on each input."""
    given = mapping("amplitude", amplitude)
    names = [port.name for port in ports]
    for name in given:
        if name not in names:
            refuse(
                "amplitude",
                name,
                f"amplitude: there is no input {name!r}" + did_you_mean(nearest(str(name), names)),
            )
    piston = any(airframe.has(f"propulsion/engine[{i}]/map-inhg") for i in range(airframe.engines))
    heights = []
    for port in ports:
        if port.name in given:
            heights.append(positive(f"amplitude[{port.name!r}]", given[port.name]))
        elif _is_throttle(port):
            heights.append(_PISTON_THROTTLE if piston else _TURBINE_THROTTLE)
        elif port.unit in _AMPLITUDES:
            heights.append(_AMPLITUDES[port.unit])
        else:
            refuse(
                "amplitude",
                port.name,
                f"how far to move {port.name!r} cannot be told from its name: give "
                f"amplitude={{{port.name!r}: ...}}, in its unit and small",
            )
    return heights


def _judge_inputs(aircraft: str, inputs: Sequence[str], kinks: np.ndarray) -> None:
    """Refuse inputs to which nothing that responds does so up and down alike."""
    for name, kink in zip(inputs, kinks.T, strict=True):
        if np.any(kink > _BROKEN) and not np.any(kink <= _BROKEN):
            raise LinearisationError(
                f"no linear model of {aircraft!r}: up and down are not opposite in any response to "
                f"{name!r}: it is at the end of its range, or the control system has a step there; "
                "leave that out of the inputs",
                aircraft=aircraft,
                reason="limit",
                name=name,
            )


def _judge_fit(
    aircraft: str, inputs: Sequence[str], signals: Sequence[str], error: np.ndarray
) -> None:
    """Refuse a model that is none."""
    i, j = _worst(error)
    if error.size and not error[i, j] < _WORST_FIT:
        raise LinearisationError(
            f"no linear model of {aircraft!r}: none fits the response of {signals[i]} to "
            f"{inputs[j]} (error {error[i, j]:.0%}): it does not stay near its trim, or its "
            "response is noise",
            aircraft=aircraft,
            reason="no fit",
            name=inputs[j],
        )


def _warn(
    aircraft: str,
    inputs: Sequence[str],
    reasons: Sequence[str],
    signals: Sequence[str],
    beyond: np.ndarray,
    kinks: np.ndarray,
    error: np.ndarray,
) -> None:
    """Warn of a model that holds for small motions only: of the worst response to each input."""
    for j, name in enumerate(inputs):
        i, _ = _worst(beyond[:, [j]])
        if beyond.size and beyond[i, j] > 1.0:
            uneven = kinks[i, j] > _MISSED
            said = f"its even part is {kinks[i, j]:.0%} of the odd part, " if uneven else ""
            warn_user(
                f"{aircraft}: the response of {signals[i]} to {name} is not linear{reasons[j]}: "
                f"{said}the model's error after a doublet {error[i, j]:.0%}. The linear model is "
                "the mean of both sides for small motions; see its kinks and fit",
                once=True,
            )


def _worst(x: np.ndarray) -> tuple[int, int]:
    """Row and column of the largest, NaN being least."""
    if not x.size:
        return 0, 0
    i, j = np.unravel_index(np.argmax(np.nan_to_num(x, nan=-1.0)), x.shape)
    return int(i), int(j)


def _named(
    block: FlightBlock,
    found: Realisation,
    signals: Mapping[str, Channel],
    chosen: list[int],
    moved: list[int],
    start: np.ndarray,
    kinks: np.ndarray,
    error: np.ndarray,
) -> LinearModel:
    """The model in the units of states and ports, with their names."""
    ports, channels = block.channels()
    inputs, shown = [ports[i] for i in moved], [channels[i] for i in chosen]
    listed, properties = list(signals.values()), list(signals)
    hidden = [j for j, i in enumerate(found.signals) if i < 0]
    states = [
        Channel(f"x{hidden.index(j) + 1}", ()) if i < 0 else listed[i]
        for j, i in enumerate(found.signals)
    ]
    x_units = np.array([state.factor for state in states])
    p, m = len(shown), len(inputs)
    C, D = np.zeros((p, len(states))), np.zeros((p, m))
    fit, kink = np.full((p, m), np.nan), np.full((p, m), np.nan)
    for row, channel in enumerate(shown):
        if channel.properties:
            i = properties.index(block.airframe.canonical(channel.properties[0]))
            C[row] = channel.factor * found.C[i] / x_units
            D[row] = channel.factor * found.D[i]
            fit[row], kink[row] = error[i], kinks[i]
    return LinearModel(
        aircraft=block.airframe.aircraft,
        condition=str(block.trim.condition),
        method="flown",
        A=x_units[:, None] * found.A / x_units,
        B=x_units[:, None] * found.B,
        C=C,
        D=D,
        states=tuple(c.name for c in states),
        inputs=tuple(c.name for c in inputs),
        outputs=tuple(c.name for c in shown),
        units={c.name: c.unit for c in [*states, *inputs, *shown]},
        x0=np.array(
            [
                as_shown(s, start[i]) if i >= 0 else 0.0
                for s, i in zip(states, found.signals, strict=True)
            ]
        ),
        u0=np.array(block.trimmed_inputs())[moved],
        y0=np.array(values(block.outputs))[chosen],
        dt=block.T,
        latency=np.array(found.latency),
        kinks=kink,
        fit=fit,
    )
