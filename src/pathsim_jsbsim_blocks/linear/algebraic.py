"""Linear models from JSBSim's accelerations about the trim: central differences, no flight."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from .._core.aircraft_ports import property_of
from .._core.checks import mapping, refuse
from .._core.units import FOOT
from ..flight.airframe import Airframe
from ..flight.channels import Channel
from ..flight.flyable import Flyable
from ..flight.settling import Settling
from .linearised import Linearised, no_model
from .model import LinearModel
from .states import RIGID, full_circle, ignorable, port_value

# JSBSim's states in the order in which they are written (height and angles move the velocities):
# initial condition, present value, rate, perturbation in the property's unit
_STATES = (
    ("ic/h-sl-ft", property_of("h"), property_of("hdot"), 5.0),
    ("ic/psi-true-rad", "attitude/psi-rad", "velocities/psidot-rad_sec", 1e-4),
    ("ic/theta-rad", "attitude/theta-rad", "velocities/thetadot-rad_sec", 1e-4),
    ("ic/phi-rad", "attitude/phi-rad", "velocities/phidot-rad_sec", 1e-4),
    ("ic/u-fps", "velocities/u-fps", "accelerations/udot-ft_sec2", 0.1),
    ("ic/v-fps", "velocities/v-fps", "accelerations/vdot-ft_sec2", 0.1),
    ("ic/w-fps", "velocities/w-fps", "accelerations/wdot-ft_sec2", 0.1),
    ("ic/p-rad_sec", property_of("p"), "accelerations/pdot-rad_sec2", 1e-4),
    ("ic/q-rad_sec", property_of("q"), "accelerations/qdot-rad_sec2", 1e-4),
    ("ic/r-rad_sec", property_of("r"), "accelerations/rdot-rad_sec2", 1e-4),
)

# perturbation of an input, in its unit
_COMMAND = 1e-3

# period of quantities that are not angles
_NO_CIRCLE = 1e99

# runs without integration until accelerations that depend on others (alphadot) have settled
_RUNS = 6

# JSBSim's order of computation: a command acts on the rates one period late
_LATENCY = 1


# ground speed along each coordinate of the position
_POSITIONS = {
    property_of("lat"): "velocities/v-north-fps",
    property_of("lon"): "velocities/v-east-fps",
}


def algebraic_model(
    build: Callable[[], Flyable],
    inputs: Sequence[str] | None,
    outputs: Sequence[str] | None,
    amplitude: Mapping[str, float] | None,
) -> LinearModel:
    """Differentiate the block of ``build``; parameters as in `FlightBlock.linear_model`."""
    if mapping("amplitude", amplitude):
        refuse("amplitude", amplitude, "amplitude is for pulses: use it with method='flown'")
    plane = build()
    airframe, subject = plane.airframe, Linearised(plane, inputs, outputs)
    channels = subject.outputs
    x0 = [port_value(c, airframe.fdm[c.properties[0]]) for c in RIGID]
    places = [c for c in channels if c.properties and c.properties[0] in _POSITIONS]
    for c in channels:
        if ignorable(c) and c not in places and not c.properties[0].startswith("attitude/"):
            why = f"outputs: {c.name!r} has no state in the algebraic method; use method='flown'"
            refuse("outputs", c.name, why)
    x0 += [airframe.fdm[c.properties[0]] for c in places]

    rates = [rate for _, _, rate, _ in _STATES]
    rates += [_POSITIONS[c.properties[0]] for c in places]
    read = [(airframe.reader(name), Channel(name, (name,))) for name in rates]
    read += [
        (airframe.reader(c.properties[0]) if c.properties else lambda: 0.0, c)
        for c in (*RIGID, *channels)
    ]
    with airframe.engines_stopped():
        by_state, by_input, even = _differences(plane, subject.inputs, read)
    n, k = len(_STATES), len(rates)
    # from JSBSim's states to those of the model
    change = by_state[k : k + n]
    back = np.linalg.inv(change)
    A, B = change @ by_state[:n] @ back, change @ by_input[:n]
    C, D = by_state[k + n :] @ back, by_input[k + n :]
    if places:
        turn = np.array([[_deg_per_ft(airframe, c.properties[0])] for c in places])
        more = turn * (by_state[n:k] @ back), turn * by_input[n:k]
        A, B, C, D = _with_places((A, B, C, D), more, [channels.index(c) for c in places])
    odd, uneven = (np.sqrt((x[:n] ** 2).sum(axis=0)) for x in (by_input, even))
    kinks = np.where(odd > 0.0, uneven / np.where(odd > 0.0, odd, 1.0), np.nan)
    return subject.model(
        "algebraic",
        (*RIGID, *places),
        **{"A": A, "B": B, "C": C, "D": D, "x0": np.array(x0)},
        latency=np.full(len(odd), _LATENCY),
        kinks=np.broadcast_to(kinks, D.shape),
        fit=np.full(D.shape, np.nan),
    )


def _with_places(
    matrices: Sequence[np.ndarray], rates: Sequence[np.ndarray], rows: Sequence[int]
) -> Sequence[np.ndarray]:
    """The matrices with positions, which are also outputs, as additional states."""
    A, B, C, D = matrices
    n, m = len(A), len(rows)
    A = np.block([[A, np.zeros((n, m))], [rates[0], np.zeros((m, m))]])
    B = np.vstack([B, rates[1]])
    C = np.hstack([C, np.zeros((len(C), m))])
    for j, row in enumerate(rows):
        C[row], D[row], C[row, n + j] = 0.0, 0.0, 1.0
    return A, B, C, D


def _deg_per_ft(airframe: Airframe, position: str) -> float:
    """Change of latitude or longitude with the distance over ground, deg/ft."""
    from pymap3d.rcurve import meridian, transverse

    latitude = airframe.fdm[property_of("lat")]
    height = airframe.fdm[property_of("h")] * FOOT
    if position == property_of("lat"):
        return math.degrees(FOOT / (meridian(latitude) + height))
    return math.degrees(FOOT / ((transverse(latitude) + height) * math.cos(math.radians(latitude))))


def _settle(plane: Flyable, settling: Settling) -> None:
    """Let engines, and then accelerations that depend on others (alphadot), settle."""
    airframe, fdm = plane.airframe, plane.airframe.fdm
    in_time = bool(airframe.of_engines("itt-c"))  # turboprops have power only if time advances
    if in_time:
        airframe.start_turbines()
    if not settling.required:
        fdm.get_propulsion().get_steady_state()
    elif not settling.settle():
        raise no_model(plane, "engine", "its propellers do not settle; use method='flown'")
    if not in_time:
        fdm.suspend_integration()
    for _ in range(_RUNS):
        airframe.run_no_time() if in_time else fdm.run()
    if not in_time:
        fdm.resume_integration()


def _differences(
    plane: Flyable,
    ports: Sequence[Channel],
    readings: Sequence[tuple[Callable[[], float], Channel]],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Central differences by the states and by the inputs, and the even parts of the latter."""
    airframe = plane.airframe
    fdm, write = airframe.fdm, airframe.writer
    settling = Settling(airframe)
    states = [(write(initial), fdm[present], step) for initial, present, _, step in _STATES]
    inputs = [[(write(name), fdm[name]) for name in c.properties] for c in ports]
    factors = np.array([channel.factor for _, channel in readings])
    # a heading of 0 deg is next to one of 360
    circles = np.array([full_circle(channel) or _NO_CIRCLE for _, channel in readings])

    def at(state: int = -1, port: int = -1, by: float = 0.0) -> np.ndarray:
        for j, (put, value, _) in enumerate(states):
            put(value + by * (j == state))
        for j, commands in enumerate(inputs):
            for put, value in commands:
                put(value + by * (j == port))
        fdm.set_trim_status(True)
        fdm.run_ic()
        _settle(plane, settling)
        fdm.set_trim_status(False)
        return factors * [read() for read, _ in readings]

    still = at()

    def both(step: float, **which: int) -> tuple[np.ndarray, np.ndarray]:
        """The central difference over a step, and its even part."""
        up, down = (at(by=by, **which) - still for by in (step, -step))
        up, down = (x - circles * np.round(x / circles) for x in (up, down))
        return (up - down) / (2 * step), (up + down) / (2 * step)

    by_state = [both(step, state=j)[0] for j, (_, _, step) in enumerate(states)]
    by_input = [both(_COMMAND, port=j) for j in range(len(inputs))]
    odd, even = np.reshape(by_input, (len(inputs), 2, len(readings))).transpose(1, 2, 0)
    return np.array(by_state).T, odd, even
