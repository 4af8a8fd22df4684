"""Linear models from flight: small opposite pulses through the aircraft's own sampled map."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .._core._pathsim import values
from .._core.checks import did_you_mean, mapping, nearest, positive
from ..errors import FlightError, LinearisationError, ParameterError
from ..linear.identification import Realisation, realise
from ..linear.model import LinearModel, find
from .airframe import Airframe
from .channels import (
    RIGID,
    Channel,
    acceleration,
    engine_channels,
    full_circle,
    ignorable,
)

if TYPE_CHECKING:
    from .block import FlightBlock

# s; a pulse of this length moves the attitude little and the accelerations enough
_PULSE = 0.025

# s; the phugoid is identified from a fraction of its period, because the data have no noise
_DURATION = 8.0

# samples before the pulse: the first step sets the spools of a turbine to the throttle
_SETTLING = 3

# of full travel. A turbine's spools accelerate at a constant rate: only small pulses are linear
_TURBINE_THROTTLE, _PISTON_THROTTLE = 1e-3, 1e-2

# other inputs, by unit
_AMPLITUDES = {"norm": 5e-3, "deg": 0.1, "rad": 1e-3, "ft/s": 0.1, "kt": 0.1}

# responses below this fraction of the largest one of an output have no meaningful shape
_HARDLY = 0.3

# relative to the size of a signal: no response at all
_NOTHING = 1e-9

# even over odd part of a response: worth a warning, and no linear response at all
_KINKED, _BROKEN = 0.1, 0.5

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
    block = build()
    ports, channels = block.channels()
    moved = find("inputs", [c.name for c in ports], inputs)
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
    still = flights.fly(None, 0.0)
    nothing = _NOTHING * (1.0 + np.abs(still).max(axis=0))
    responses, kinks = [], []
    for port, height in zip(moved, heights, strict=True):
        up, down = flights.fly(port, height), flights.fly(port, -height)
        odd, even = _rms(up - down), _rms(up + down - 2 * still)
        if np.all(odd < nothing):
            raise LinearisationError(
                f"no linear model of {block.airframe.aircraft!r}: it does not respond to "
                f"{ports[port].name!r} within +-{height:g}; leave that out of the inputs, or "
                f"choose a larger amplitude",
                aircraft=block.airframe.aircraft,
                reason="no response",
                name=ports[port].name,
            )
        responses.append((up - down) / (2 * height))
        kinks.append(even / np.maximum(odd, nothing))
    g, kinked = np.array(responses), np.array(kinks).T
    # what answers alike to up and down does not answer in the first order
    mute = [i for i in range(len(listed)) if np.all(kinked[i] > _BROKEN)]
    rigid = [i for i, c in enumerate(listed) if c in RIGID and i not in mute]
    _judge_inputs(block.airframe.aircraft, [ports[i].name for i in moved], kinked[rigid])
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
    model = _named(block, found, signals, chosen, moved, still[0], kinked)
    _judge(model, [listed[i].name for i in rigid], kinked[rigid], found.error[rigid])
    return model


class _Flights:
    """Flights with a pulse on one input each, and what is recorded of them."""

    def __init__(self, build: Callable[[], FlightBlock], signals: Mapping[str, Channel], T: float):
        self._build = build
        self._signals = signals
        self.width = max(round(_PULSE / T), 1)
        self._n = round(_DURATION / T / self.width) * self.width

    def fly(self, port: int | None, height: float) -> np.ndarray:
        """Signals from the start of the pulse on, shape (samples, signals)."""
        plane = self._build()
        readers = [plane.airframe.reader(name) for name in self._signals]
        u = values(plane.inputs)
        trimmed = plane.trimmed_inputs()
        u[: len(trimmed)] = trimmed
        pulsed = list(u)
        if port is not None:
            pulsed[port] += height
        y = np.empty((self._n + 1, len(readers)))
        try:
            for k in range(1, _SETTLING + 1):
                plane.advance(k, u)
            y[0] = [read() for read in readers]
            for k in range(1, self._n + 1):
                plane.advance(_SETTLING + k, pulsed if k <= self.width else u)
                y[k] = [read() for read in readers]
        except FlightError as error:
            raise LinearisationError(
                f"no linear model of {plane.airframe.aircraft!r}: left to itself it does not "
                f"stay in the air for {_DURATION:g} s: {error}",
                aircraft=plane.airframe.aircraft,
                reason="no fit",
            ) from error
        for i, channel in enumerate(self._signals.values()):
            if circle := full_circle(channel):
                y[:, i] = np.unwrap(y[:, i], period=circle / channel.factor)
        return y


def _rms(x: np.ndarray) -> np.ndarray:
    return np.sqrt((x**2).mean(axis=0))


def _heights(
    airframe: Airframe, ports: Sequence[Channel], amplitude: Mapping[str, float] | None
) -> list[float]:
    """Height of the pulse on each input."""
    given = mapping("amplitude", amplitude)
    names = [port.name for port in ports]
    for name in given:
        if name not in names:
            raise ParameterError(
                f"amplitude: there is no input {name!r}" + did_you_mean(nearest(str(name), names)),
                parameter="amplitude",
                value=name,
            )
    piston = any(airframe.has(f"propulsion/engine[{i}]/map-inhg") for i in range(airframe.engines))
    heights = []
    for port in ports:
        if port.name in given:
            heights.append(positive(f"amplitude[{port.name!r}]", given[port.name]))
        elif any(name.startswith("fcs/throttle-cmd") for name in port.properties):
            heights.append(_PISTON_THROTTLE if piston else _TURBINE_THROTTLE)
        elif port.unit in _AMPLITUDES:
            heights.append(_AMPLITUDES[port.unit])
        else:
            raise ParameterError(
                f"how far to move {port.name!r} cannot be told from its name: give "
                f"amplitude={{{port.name!r}: ...}}, in its unit and small",
                parameter="amplitude",
                value=port.name,
            )
    return heights


def _judge_inputs(aircraft: str, inputs: Sequence[str], kinks: np.ndarray) -> None:
    """Refuse inputs to which nothing responds up and down alike."""
    for name, kink in zip(inputs, kinks.T, strict=True):
        if np.all(kink > _BROKEN):
            raise LinearisationError(
                f"no linear model of {aircraft!r}: up and down are not opposite in any response to "
                f"{name!r}: it is at the end of its range, or the control system has a step there",
                aircraft=aircraft,
                reason="limit",
                name=name,
            )


def _judge(
    model: LinearModel, signals: Sequence[str], kinks: np.ndarray, error: np.ndarray
) -> None:
    """Refuse a model that is none, and warn of one that holds for small motions only."""
    i, j = divmod(int(np.argmax(error)), len(model.inputs))
    if not error[i, j] < _WORST_FIT:
        raise LinearisationError(
            f"no linear model of {model.aircraft!r}: none fits the response of {signals[i]} to "
            f"{model.inputs[j]} (error {error[i, j]:.0%}): it does not stay near its trim, or its "
            "response is noise",
            aircraft=model.aircraft,
            reason="no fit",
            name=model.inputs[j],
        )
    i, j = divmod(int(np.nanargmax(kinks)), len(model.inputs))
    if kinks[i, j] > _KINKED:
        warnings.warn(
            f"{model.aircraft}: the response of {signals[i]} to {model.inputs[j]} is not linear: "
            f"its even part is {kinks[i, j]:.0%} of the odd part. The linear model is the mean of "
            "both sides; see its kinks",
            RuntimeWarning,
            stacklevel=4,
        )


def _named(
    block: FlightBlock,
    found: Realisation,
    signals: Mapping[str, Channel],
    chosen: list[int],
    moved: list[int],
    start: np.ndarray,
    kinks: np.ndarray,
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
            fit[row], kink[row] = found.error[i], kinks[i]
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
                s.factor * start[i] if i >= 0 else 0.0
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
