"""Response of a linear aircraft with closed loops to turbulence."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid
from scipy.special import ndtr

from ..control.airspeeds import ComplementaryAirspeed
from ..linear.model import LinearModel
from ..wind import dryden_field
from . import requirements as req
from .plant import OMEGA, Law, Plant

AIR = ("along", "up")


def in_turbulence(plant: Plant, model: LinearModel, altitude: float) -> Plant:
    """The plant with moderate turbulence at an altitude in ft: white noise at two further inputs.

    The aircraft's states are relative to the air. If the air accelerates, they change by the
    opposite, and the aircraft rises with the air:

    .. math::
        \\dot V = \\ldots - \\dot u, \\quad \\dot\\alpha = \\ldots + \\dot w / V, \\quad
        \\dot h = \\ldots + w

    with u along the flight path and w up. Both are noise through a first-order lag, of L / V and
    L / 2V, with the rms and the lengths of `dryden_field`, as in JSBSim's MIL-spec turbulence.

    A further output, "airspeed", is that of `ComplementaryAirspeed`, without limits: it has the
    motion of the air only behind a lag.

    If the model lacks one of these states, or has states that appear in no output, the effect of
    the air is unknown and the plant is returned unchanged.
    """
    T, states = plant.T, list(model.states)
    if "x1" in states or not {"vt", "alpha", "h"} <= set(states):
        return plant
    per_speed = plant.row("vc")[states.index("vt")]
    plant = _with_airspeed(plant, per_speed)
    n = len(plant.A)
    vt = float(model.x0[states.index("vt")])
    field = dryden_field(altitude)
    rate = np.array([vt / field.L_u, 2.0 * vt / field.L_w])
    size = np.array([field.sigma_u, field.sigma_w]) * np.sqrt(2.0 * rate)
    fade = np.exp(-rate * T)
    enters = (1.0 - fade) / rate * size
    # effect of increments of u and w on the states, and of w itself
    moves, rise = np.zeros((n, 2)), np.zeros((n, 2))
    moves[states.index("vt"), 0] = -1.0
    moves[states.index("alpha"), 1] = math.degrees(1.0 / vt)
    rise[states.index("h"), 1] = T
    rise[n - 1, 0] = T / ComplementaryAirspeed.TIME
    m = plant.B.shape[1]
    A = np.block([[plant.A, moves * (fade - 1.0) + rise], [np.zeros((2, n)), np.diag(fade)]])
    B = np.block([[plant.B, moves * enters], [np.zeros((2, m)), np.diag(enters)]])
    C = np.hstack([plant.C, np.zeros((len(plant.C), 2))])
    C[plant.outputs.index("hdot"), n + 1] = 1.0
    C[plant.outputs.index("airspeed"), n] = per_speed
    return Plant(A, B, C, [*plant.inputs, *AIR], plant.outputs, T)


def _with_airspeed(plant: Plant, per_speed: float) -> Plant:
    """The plant with the output "airspeed" in air at rest, and a state for u behind its lag."""
    A = np.pad(plant.A, (0, 1))
    A[-1, -1] = 1.0 - plant.T / ComplementaryAirspeed.TIME
    B, row = np.pad(plant.B, ((0, 1), (0, 0))), np.append(plant.row("vc"), -per_speed)
    C = np.vstack([np.pad(plant.C, ((0, 0), (0, 1))), row])
    return Plant(A, B, C, plant.inputs, [*plant.outputs, "airspeed"], plant.T)


def rms(omega: np.ndarray, *responses: np.ndarray) -> np.ndarray:
    """Root mean square of signals from their responses to white noises, over the last axis."""
    power = sum(np.abs(response) ** 2 for response in responses)
    return np.sqrt(trapezoid(power, omega, axis=-1) / np.pi)


Responses = dict[str, np.ndarray]


def within(y: Responses, g: Responses, law: Law, T: float, names: Iterable[str]) -> Responses:
    """Some of the responses ``y``, with a law closed around the input with responses ``g``."""
    u = law.of(y, T) / (1.0 + law.of(g, T))
    return {name: y[name] - g[name] * u for name in names if name in y}


def moved(
    plant: Plant, law: Law, input_: str, *outputs: str, inner: tuple[str, Law] | None = None
) -> tuple[np.ndarray, Responses]:
    """Loops L of laws at an input; rms of it and of outputs, 0 if the plant lacks the output.

    ``inner`` are another input and the laws around it.
    """
    g = plant.response(OMEGA, input_)
    air = [plant.response(OMEGA, name) for name in AIR if name in plant.inputs]
    if inner:
        h, law_inside = plant.response(OMEGA, inner[0]), inner[1]
        g, *air = (within(y, h, law_inside, plant.T, {*law.gains, *outputs}) for y in (g, *air))
    L = law.of(g, plant.T)
    moves = [-law.of(gust, plant.T) / (1.0 + L) for gust in air]
    signals = {input_: moves}
    for name in outputs:
        present = name in plant.outputs
        signals[name] = [y[name] + g[name] * u for y, u in zip(air, moves, strict=True) if present]
    # gives the rms its shape if there is no turbulence
    zero = np.zeros_like(L)
    return L, {name: rms(OMEGA, zero, *responses) for name, responses in signals.items()}


# peak over rms of the altitude error in a flight of some minutes
_PEAK = 3.3

# cost of an excess of 100 % of the target, s of settling time
_ALTITUDE_COST, _PITCH_COST, _STOP_COST = 30.0, 800.0, 40.0

# maximum excesses that are counted: far beyond the target, a small improvement is no benefit
_PITCH_LOST, _STOP_LOST = 0.5, 4.0


@dataclass(frozen=True)
class Rough:
    """Motion of some loops in turbulence, arrays of shape (loops,)."""

    altitude: np.ndarray  # rms in ft
    pitch: np.ndarray  # rms in deg
    stop: np.ndarray  # fraction of the time with the throttle at a stop

    def cost(self) -> np.ndarray:
        """Cost of each loop, in s of settling time."""
        h = np.maximum(self.altitude * _PEAK / req.ALTITUDE_IN_TURBULENCE - 1.0, 0.0)
        theta = np.clip(
            self.pitch / (req.PITCH_AIM * req.PITCH_IN_TURBULENCE) - 1.0, 0.0, _PITCH_LOST
        )
        stop = np.clip(self.stop / (req.STOP_AIM * req.STOP_IN_TURBULENCE) - 1.0, 0.0, _STOP_LOST)
        return _ALTITUDE_COST * h + _PITCH_COST * theta + _STOP_COST * stop

    def violations(self, i: int) -> tuple[str, ...]:
        """Texts of the requirements that one of the loops does not meet."""
        altitude, pitch, stop = self.altitude[i], self.pitch[i], self.stop[i]
        violations = {
            f"{altitude:.0f} ft rms": altitude * _PEAK > req.ALTITUDE_IN_TURBULENCE,
            f"{pitch:.1f} deg rms": pitch > req.PITCH_IN_TURBULENCE,
            f"{stop:.0%} at the throttle's stop": stop > req.STOP_IN_TURBULENCE,
        }
        return tuple(f"turbulence {text}" for text, over in violations.items() if over)


def at_a_stop(throttle: np.ndarray, room: tuple[float, float]) -> np.ndarray:
    """Fraction of the time at a stop, from the throttle's rms and its limits ``room``."""
    throttle = np.maximum(throttle, 1e-9)
    return ndtr(room[0] / throttle) + ndtr(-room[1] / throttle)
