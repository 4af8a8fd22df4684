"""Linear models from flight: small opposite pulses through the aircraft's own sampled map."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from .._core.callers import warn_user
from .._core.checks import did_you_mean, mapping, nearest, positive, refuse
from .._core.pathsim_internals import values
from ..errors import FlightError, LinearisationError
from ..flight.airframe import Airframe
from ..flight.channels import Channel
from ..flight.flyable import Flyable
from .identification import Realisation, realise, respond
from .linearised import Linearised, no_model
from .model import LinearModel
from .servos import hysteresis
from .states import RIGID, acceleration, engine_channels, full_circle, ignorable, port_value

# s; the pulse must move the attitude little and the accelerations enough
_PULSE = 0.025

# s; the phugoid is identified from a fraction of its period, because the data have no noise
_DURATION = 8.0

# s; samples 0.4 s apart alias a short period of 8 rad/s
_LONGEST_PERIOD = 0.25

# samples before the pulse: the first step sets the spools of a turbine to the throttle
_SETTLING = 3

# pulse over full travel; turbine spools accelerate at a constant rate: keep their pulse small
_TURBINE_THROTTLE, _PISTON_THROTTLE = 1e-3, 1e-2

# pulse height of other inputs, by unit
_AMPLITUDES = {"norm": 5e-3, "deg": 0.1, "rad": 1e-3, "ft/s": 0.1, "kt": 0.1}

# fraction of an output's maximum response below which a response has no meaningful shape
_SMALL_RESPONSE = 0.3

# but these primary responses are always judged, however small
_PRIMARY = {
    "fcs/elevator-cmd": ("theta", "q"),
    "fcs/aileron-cmd": ("phi", "p"),
    "fcs/rudder-cmd": ("beta", "r"),
    "fcs/throttle-cmd": ("vt",),
}

# a doublet after the pulse tests the range of the model: s each way, height over the pulse's,
# and for a throttle height over full travel
_WAY, _DOUBLET, _DOUBLET_THROTTLE = 1.0, 2.0, 0.01

# relative to the size of a signal, below which it does not respond
_NO_RESPONSE = 1e-9

# even over odd part of a response, for a warning (more than 10 % after rounding to whole percent)
# and for no linear response at all
_KINKED, _NOT_LINEAR = 0.105, 0.5

# error after a doublet for a warning, in primary responses and in the others: drag is even, so
# the airspeed is never within 5 % after an elevator doublet
_MISSED, _MISSED_ELSEWHERE = 0.05, 0.15

# maximum exponent of the growth of an aircraft that is still near its trim after the pulse
_GROWTH = 3.0

# maximum error of a model that fits
_MAX_FIT_ERROR = 0.3


def flown_model(
    build: Callable[[], Flyable],
    inputs: Sequence[str] | None,
    outputs: Sequence[str] | None,
    amplitude: Mapping[str, float] | None,
) -> LinearModel:
    """Identify a model from flights of blocks from ``build``, each a new aircraft.

    The other parameters, and the errors, are those of `FlightBlock.linear_model`.
    """
    plane = build()
    if plane.T > _LONGEST_PERIOD:
        why = f"samples every {plane.T:g} s alias its short period; identify a block with T "
        why += f"up to {_LONGEST_PERIOD:g} s, or use method='algebraic'"
        raise no_model(plane, "no fit", why)
    subject = Linearised(plane, inputs, outputs)
    if not subject.moved:
        why = "there is no input to move; give the block inputs, or use method='algebraic'"
        raise no_model(plane, "no response", why)
    flights = _Flights(subject, mapping("amplitude", amplitude))
    try:
        responses = _Responses(subject, flights, *flights.fly_all(build))
        system = responses.realised()
        return _named(subject, system, flights, responses.still[0], *responses.judged(system))
    except LinearisationError as error:
        commands = [name for c in subject.inputs if c.name == error.name for name in c.properties]
        servos = hysteresis(plane.airframe.components, commands)
        if not servos:
            raise
        widths = ", ".join(f"{name} {width:g}" for name, width in servos.items())
        why = f"servos of {error.name!r} have hysteresis (width {widths}), larger than the pulses"
        why += "; use method='algebraic'"
        raise no_model(plane, error.reason, why, error.name, servos) from error


class _Responses:
    """Responses to the pulses and doublets: arrays of shape (inputs, samples, signals)."""

    def __init__(
        self,
        subject: Linearised,
        flights: _Flights,
        up: np.ndarray,
        down: np.ndarray,
        still: np.ndarray,
    ):
        self._plane, self._flights, self._signals = subject.plane, flights, flights.channels
        self._ports, self._names = subject.inputs, [c.name for c in subject.inputs]
        self.still = still
        self._odd, self._even = (up - down) / 2, (up + down) / 2 - still
        noise = _NO_RESPONSE * (1.0 + np.abs(still).max(axis=0))
        self._pulsed = self._odd[:, : flights.pulsed]
        size = _rms(self._pulsed)
        for name, height, rms in zip(self._names, flights.heights, size, strict=True):
            if np.all(rms < noise):
                why = f"it does not respond to {name!r} within +-{height:g}; remove it from "
                why += "inputs, or give a larger amplitude"
                raise no_model(self._plane, "no response", why, name)
        # even over odd parts, shape (signals, inputs)
        even = _rms(self._even[:, : flights.pulsed])
        self._kinked = (even / np.maximum(size, noise)).T
        # a signal with the same response up and down has no first-order response
        self._mute = [i for i, ratio in enumerate(self._kinked) if np.all(ratio > _NOT_LINEAR)]
        motion = [i for i, c in enumerate(self._signals) if c in RIGID]
        self._rigid = [i for i in motion if i not in self._mute]
        ratio = np.where((size > noise).T, self._kinked, np.nan)[motion]
        for name, kinks in zip(self._names, ratio.T, strict=True):
            if np.any(kinks > _NOT_LINEAR) and not np.any(kinks <= _NOT_LINEAR):
                why = (
                    f"no response to {name!r} changes sign with it: it is at a limit of its range "
                )
                why += "or the control system has a step at the trim; remove it from inputs, or "
                why += "use method='algebraic'"
                raise no_model(self._plane, "limit", why, name)

    def _indices(self, which: Callable[[Channel], bool]) -> list[int]:
        """Indices of the signals of a kind that are not mute."""
        return [i for i, c in enumerate(self._signals) if i not in self._mute and which(c)]

    def realised(self) -> Realisation:
        """The model identified from the pulses, with the additional latency of throttles."""
        flights = self._flights
        g = self._pulsed / np.reshape(flights.heights, (-1, 1, 1))
        rms = _rms(g).T
        self._kinked[rms < _SMALL_RESPONSE * rms.max(axis=1, keepdims=True)] = np.nan
        self._kinked[self._mute] = np.nan
        g[:, :, self._mute] = 0.0
        integrals = self._indices(ignorable)
        # a heading first, then positions, which depend on it
        integrals.sort(key=lambda i: not self._signals[i].properties[0].startswith("attitude/"))
        system = realise(
            g,
            self._plane.T,
            flights.width,
            rigid=[i for i in self._rigid if i not in integrals],
            engines=self._indices(lambda c: c in flights.engines),
            integrals=integrals,
            abrupt=self._indices(acceleration),
        )
        self._primary = np.array([[_is_primary(p, c) for c in self._signals] for p in self._ports])
        for j, i in np.argwhere(self._primary):
            if i in self._mute:
                signal, name = self._signals[i].name, self._names[j]
                why = f"the response of {signal} to {name} is the same up and down"
                raise no_model(self._plane, "no fit", why, name)
        self._predicted = respond(system, flights.commands.T, self._plane.T)
        for j, port in enumerate(self._ports):
            # a spool takes longer for a larger change: a pulse gives too short a delay
            if _is_throttle(port):
                signals = [k for k in np.flatnonzero(self._primary[j]) if k not in self._mute]
                prediction = self._predicted[j]
                delay = flights.later(self._odd[j][:, signals], prediction[:, signals])
                system.latency[j] += delay
                prediction[delay:] = prediction[: len(prediction) - delay]
        return system

    def judged(self, system: Realisation) -> tuple[np.ndarray, np.ndarray]:
        """Kinks and errors of a model; raises if it does not fit."""
        n, rigid = self._flights.pulsed, self._rigid
        odd, even, prediction = (x[:, n:] for x in (self._odd, self._even, self._predicted))
        size = _rms(odd)
        maximum = size.max(axis=0, initial=0.0)
        small = ((size < _SMALL_RESPONSE * maximum) & ~self._primary) | (size == 0.0)

        def ratio(part: np.ndarray, reference: np.ndarray) -> np.ndarray:
            """Shape (signals, inputs); NaN if a signal hardly responds."""
            return np.where(small, np.nan, part / np.where(small, 1.0, reference)).T

        # after doublets that begin upwards and downwards
        upwards = ratio(_rms(odd + even - prediction), _rms(odd + even))
        downwards = ratio(_rms(odd - even - prediction), _rms(odd - even))
        uneven = ratio(_rms(even), size)
        upwards[self._mute] = downwards[self._mute] = uneven[self._mute] = np.nan
        self._judge_fit(system.error[rigid])
        # not for an unstable aircraft, by now far from its trim
        if np.linalg.eigvals(system.A).real.max(initial=0.0) * _DURATION < _GROWTH:
            error = _rms(odd - prediction)
            self._judge_fit(ratio(error, np.broadcast_to(maximum, size.shape))[rigid])
        kinks, error = np.fmax(self._kinked, uneven), np.fmax(system.error, upwards)
        limit = np.where(self._primary.T, _MISSED, _MISSED_ELSEWHERE)
        excess = np.fmax(kinks / _KINKED, error / limit)
        error = np.fmax(error, downwards)
        self._warn(excess[rigid], kinks[rigid], error[rigid])
        return kinks, error

    def _judge_fit(self, error: np.ndarray) -> None:
        """Raise if the model does not fit the responses."""
        i, j = _worst(error)
        if error.size and not error[i, j] < _MAX_FIT_ERROR:
            signal, name = self._signals[self._rigid[i]].name, self._names[j]
            why = f"the response of {signal} to {name} does not fit (error {error[i, j]:.0%}): the "
            why += "aircraft leaves its trim, or the response is noise"
            raise no_model(self._plane, "no fit", why, name)

    def _warn(self, excess: np.ndarray, kinks: np.ndarray, error: np.ndarray) -> None:
        """Warn of a model for small motions only, for each input with its worst response."""
        airframe = self._plane.airframe
        for j, port in enumerate(self._ports):
            i, _ = _worst(excess[:, [j]])
            if excess.size and excess[i, j] > 1.0:
                signal = self._signals[self._rigid[i]].name
                uneven = kinks[i, j] > _MISSED
                parity = f"its even part is {kinks[i, j]:.0%} of the odd part, " if uneven else ""
                texts = [
                    f"{self._signals[self._rigid[k]].name} {error[k, j]:.0%}"
                    for k in np.flatnonzero(excess[:, j] > 1.0)
                    if k != i
                ]
                too = f", of {', '.join(texts)}" if texts else ""
                warn_user(
                    f"{airframe.aircraft}: the response of {signal} to {port.name} is not linear"
                    f"{_reason(airframe, port)}: {parity}the model's error after a doublet "
                    f"{error[i, j]:.0%}{too}. The linear model is the mean of up and down for "
                    "small motions; see its kinks and fit",
                    once=True,
                )


class _Flights:
    """Flights with a pulse and then a doublet on one input each, and the recorded signals."""

    def __init__(self, subject: Linearised, amplitude: Mapping[str, float]):
        self._subject, T = subject, subject.plane.T
        airframe = subject.plane.airframe
        self.heights = _heights(airframe, subject.inputs, amplitude)
        self.engines = engine_channels(airframe)
        # one signal for each property, because outputs, states and engine states overlap
        self.signals: dict[str, Channel] = {}
        for channel in [*RIGID, *self.engines, *subject.outputs]:
            for name in channel.properties[:1]:
                self.signals.setdefault(airframe.canonical(name), channel)
        self.channels = list(self.signals.values())
        self.width = max(round(_PULSE / T), 1)
        n = round(_DURATION / T / self.width) * self.width
        self._way = max(round(_WAY / T), 1)
        # samples of the response to the pulse
        self.pulsed = n + 1
        # commands over all periods of a flight: a pulse, and a doublet after its response
        self.commands = np.zeros((len(subject.inputs), 2 * n))
        for u, port, height in zip(self.commands, subject.inputs, self.heights, strict=True):
            of_default = _is_throttle(port) and port.name not in amplitude
            doublet = _DOUBLET_THROTTLE if of_default else _DOUBLET * height
            u[: self.width] = height
            u[n:][: self._way] = doublet
            u[n + self._way :][: self._way] = -doublet

    def fly_all(self, build: Callable[[], Flyable]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The signals with each input upwards first, downwards first, and at the trim."""
        pairs = [
            [self._fly(build(), port, sign * u) for sign in (1, -1)]
            for port, u in zip(self._subject.moved, self.commands, strict=True)
        ]
        still = self._fly(self._subject.plane, None, np.zeros_like(self.commands[0]))
        up, down = (np.array(side) for side in zip(*pairs, strict=True))
        return up, down, still

    def later(self, odd: np.ndarray, prediction: np.ndarray) -> int:
        """Periods by which the first half of the doublet acts later than predicted."""
        start, end = self.pulsed, self.pulsed + self._way
        errors = [
            float(((odd[start:end] - prediction[start - k : end - k]) ** 2).sum())
            for k in range(self._way)
        ]
        return int(np.argmin(errors))

    def _fly(self, plane: Flyable, port: int | None, commands: np.ndarray) -> np.ndarray:
        """Signals from the start of the pulse on, shape (samples, signals)."""
        read = plane.airframe.reader_of(self.signals)
        u = values(plane.inputs)
        trimmed = plane.trimmed_inputs()
        u[: len(trimmed)] = trimmed
        y = np.empty((len(commands) + 1, len(self.signals)))
        try:
            for k in range(1, _SETTLING + 1):
                plane.advance(k, u)
            y[0] = read()
            for k, command in enumerate(commands.tolist(), 1):
                if port is not None:
                    u[port] = trimmed[port] + command
                plane.advance(_SETTLING + k, u)
                y[k] = read()
        except FlightError as error:
            why = f"with fixed controls it does not fly for {2 * _DURATION:g} s: {error}"
            raise no_model(plane, "no fit", why) from error
        for i, channel in enumerate(self.channels):
            if circle := full_circle(channel):
                y[:, i] = np.unwrap(y[:, i], period=circle / channel.factor)
        return y


def _rms(x: np.ndarray) -> np.ndarray:
    """Over the samples, the last axis but one."""
    return np.sqrt((x**2).mean(axis=-2))


def _is_throttle(port: Channel) -> bool:
    return any(name.startswith("fcs/throttle-cmd") for name in port.properties)


def _is_primary(port: Channel, signal: Channel) -> bool:
    """Whether the signal is a primary response to the command."""
    return any(
        name.startswith(command) and signal.name in signals
        for name in port.properties
        for command, signals in _PRIMARY.items()
    )


def _reason(airframe: Airframe, port: Channel) -> str:
    """Reason why the response to a throttle is not linear; "" without one."""
    # for a piston engine it may be the thrust (pa28) or the aircraft's motion (Camel)
    if _is_throttle(port) and airframe.of_engines("n2"):
        return " (a turbine's spools accelerate at constant rates)"
    return ""


def _heights(
    airframe: Airframe, ports: Sequence[Channel], amplitude: Mapping[str, float]
) -> list[float]:
    names = [port.name for port in ports]
    for name in amplitude:
        if name not in names:
            close = did_you_mean(nearest(str(name), names))
            refuse("amplitude", name, f"amplitude: there is no input {name!r}{close}")
    piston = airframe.of_engines("map-inhg")
    heights = []
    for port in ports:
        if port.name in amplitude:
            heights.append(positive(f"amplitude[{port.name!r}]", amplitude[port.name]))
        elif _is_throttle(port):
            heights.append(_PISTON_THROTTLE if piston else _TURBINE_THROTTLE)
        elif port.unit in _AMPLITUDES:
            heights.append(_AMPLITUDES[port.unit])
        else:
            why = f"{port.name!r} has no default amplitude: give "
            why += f"amplitude={{{port.name!r}: ...}}, small and in its unit"
            refuse("amplitude", port.name, why)
    return heights


def _worst(x: np.ndarray) -> tuple[int, int]:
    """Row and column of the maximum, where NaN ranks last."""
    if not x.size:
        return 0, 0
    i, j = np.unravel_index(np.argmax(np.nan_to_num(x, nan=-1.0)), x.shape)
    return int(i), int(j)


def _named(
    subject: Linearised,
    system: Realisation,
    flights: _Flights,
    start: np.ndarray,
    kinks: np.ndarray,
    error: np.ndarray,
) -> LinearModel:
    hidden = [j for j, i in enumerate(system.signals) if i < 0]
    states = [
        Channel(f"x{hidden.index(j) + 1}", ()) if i < 0 else flights.channels[i]
        for j, i in enumerate(system.signals)
    ]
    x_units = np.array([state.factor for state in states])
    p, m = len(subject.outputs), len(subject.inputs)
    C, D = np.zeros((p, len(states))), np.zeros((p, m))
    fit, kink = np.full((p, m), np.nan), np.full((p, m), np.nan)
    properties = list(flights.signals)
    for row, channel in enumerate(subject.outputs):
        if channel.properties:
            i = properties.index(subject.plane.airframe.canonical(channel.properties[0]))
            C[row] = channel.factor * system.C[i] / x_units
            D[row] = channel.factor * system.D[i]
            fit[row], kink[row] = error[i], kinks[i]
    starts = zip(states, system.signals, strict=True)
    x0 = [port_value(state, start[i]) if i >= 0 else 0.0 for state, i in starts]
    A, B = x_units[:, None] * system.A / x_units, x_units[:, None] * system.B
    return subject.model(
        "flown",
        states,
        **{"A": A, "B": B, "C": C, "D": D, "x0": np.array(x0)},
        latency=np.array(system.latency),
        kinks=kink,
        fit=fit,
    )
