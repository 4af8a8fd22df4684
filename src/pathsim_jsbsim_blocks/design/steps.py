"""Steps of the references flown on the nonlinear aircraft."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..control.gains import AircraftGains, GainSchedule
from ..flight.aircraft import Aircraft
from ..guidance.autopilot import Autopilot
from .requirements import STEP_REQUIREMENTS, StepRequirement
from .search import StepQuality, step_quality

# flight before the step, s: the start after a trim disturbs turbines
BEFORE = 2.0


@dataclass(frozen=True)
class Step:
    """A step of one reference: port of the `Autopilot`, its mode inputs, output of the aircraft."""

    port: str
    output: str
    required: StepRequirement
    modes: dict[str, float]


STEPS = {
    loop: Step(f"{output}_ref", output, STEP_REQUIREMENTS[loop], modes)
    for loop, output, modes in (
        ("pitch", "theta", {"pitch_mode": 1.0}),
        ("roll", "phi", {"roll_mode": 1.0}),
        ("heading", "psi", {}),
        ("altitude", "h", {}),
        ("speed", "vc", {}),
    )
}


@dataclass(frozen=True)
class Flown:
    """Result of a flown step."""

    quality: StepQuality
    time: np.ndarray  # s from the step on
    outputs: dict[str, np.ndarray]  # outputs of the aircraft
    stop: float  # longest time in s for which a command was at the end of its travel


def fly_step(
    fresh: Callable[[], Aircraft],
    gains: AircraftGains | GainSchedule,
    step: Step,
    size: float | None = None,
    seconds: float | None = None,
) -> Flown:
    """Fly a step in a plain loop of an aircraft and the autopilot.

    ``fresh`` creates a trimmed aircraft; ``size`` and ``seconds`` of flight replace the step's own.
    Raises `FlightError` if the flight ends early.
    """
    size = step.required.size if size is None else size
    plane = fresh()
    T = plane.T
    autopilot = Autopilot(gains=gains, T=T)
    state = autopilot.initial_state()
    ports, names = autopilot.input_port_labels, list(Aircraft.output_port_labels)
    wires = [(ports[name], i) for i, name in enumerate(names) if name in ports]
    u = [0.0] * len(ports)
    for name, value in step.modes.items():
        u[ports[name]] = value
    lead = round(BEFORE / T)
    n = lead + round((step.required.seconds if seconds is None else seconds) / T)
    rows = np.empty((n + 1, len(names)))
    y: Sequence[float] = plane.outputs.to_array().tolist()
    rows[0] = y
    command = [0.0] * len(plane.input_port_labels)
    for k in range(n):
        for port, i in wires:
            u[port] = y[i]
        if k == lead:
            # an increment on the value at engagement
            u[ports[step.port]] = size
        out, state = autopilot.law(u, state)
        command[:4] = out[:4]
        y = rows[k + 1] = plane.advance(k + 1, command)
    column = names.index("psi")
    rows[:, column] = np.unwrap(rows[:, column], period=360.0)
    outputs = dict(zip(names, rows[lead:].T, strict=True))
    time, start = np.arange(n + 1 - lead) * T, rows[0, names.index(step.output)]
    # negative until the reference is reached
    error = np.sign(size) * (outputs[step.output] - start - size)
    quality = step_quality(error, step.required.tolerance, T)
    stops = [outputs[name] != 0.0 for name in ("elev_sat", "ail_sat", "rud_sat", "thr_sat")]
    return Flown(quality, time, outputs, max(_longest(s) for s in stops) * T)


def _longest(flags: np.ndarray) -> int:
    """Length of the longest run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    return int(np.max(edges[1::2] - edges[::2], initial=0))
