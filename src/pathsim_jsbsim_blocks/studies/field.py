"""Take-off and landing distances, flown with the pitch and roll holds of a gain table."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Function, Scope
from pathsim.events import Condition

from ..control.gain_tables import tables
from ..control.holds import PitchHold, RollHold
from ..errors import BlocksError
from ..flight import TrimCondition, trim
from ..flight.aircraft import Aircraft
from .flight_tests import LARGE, Plane, slowest

_ROTATION, _CLIMB, _APPROACH = 1.05, 1.2, 1.3  # of the stall speed: CS 25.107, 25.107(b), 23.73
_PATH = -3.0  # deg
_FLARE, _NOSE_UP = 2.5, 4.0  # s above the ground at the sink rate of the path; deg of pitch
_SCREEN = 50.0  # ft: CS 23.59, 23.75, 25.125
_LARGE_SCREEN = 35.0  # ft: CS 25.113
_STEEPEST, _USUAL = 15.0, 10.0  # deg of pitch; where no climb trims
_LONGEST = 120.0  # s
_STOPPED = 3.0  # ft/s, what an idling engine may keep up against the brakes

_READ = _HEIGHT, _GEAR, _SPEED = "position/h-agl-ft", "forces/fbz-gear-lbs", "velocities/vg-fps"


def field(plane: Plane) -> None:
    """Take-off with half flaps, landing with full flaps, at the plane's altitude."""
    if plane.airframe.aircraft not in tables():
        plane.reason = "no gain table"
        plane.put("field", "take-off distance", None)
        plane.put("field", "landing distance", None)
        return
    base = plane.base
    for name, flaps, fly in (("take-off", 0.5, _take_off), ("landing", 1.0, _landing)):
        plane.base = replace(base, flaps=flaps, gear=None if base.gear is None else 1.0)
        try:
            found = fly(plane)
        except BlocksError as error:
            found, plane.reason = None, getattr(error, "reason", str(error))
        distance, roll, speed = found or (None, None, np.nan)
        plane.put("field", f"{name} distance", distance, speed_kcas=speed)
        plane.put("field", f"{name} ground roll", roll, speed_kcas=speed)
    plane.base = base


def _take_off(plane: Plane) -> tuple[float, float, float] | None:
    """Distance to the screen, ground roll and airspeed at lift-off."""
    slow = slowest(plane)
    if not slow:
        return None
    climb = plane.climb(_CLIMB * slow.speed)
    screen = _LARGE_SCREEN if plane.weight > LARGE else _SCREEN
    rotation = _ROTATION * slow.speed
    on_ground = replace(_above_ground(plane), mode="ground")
    on_wheels = trim(plane.flyer(), on_ground, hint=False).altitude - plane.base.altitude
    track = _flown(
        plane,
        on_ground,
        min(climb.theta, _STEEPEST) if climb else _USUAL,
        lambda speed, height, gear, ground: (float(speed < rotation), 0.0, 1.0, 0.0),
        lambda speed, height, gear, ground: height > screen + on_wheels,
    )
    way, speed, height, gear, _ = track
    if height[-1] < screen + on_wheels or not gear.any():
        plane.reason = f"not at {screen:g} ft within {_LONGEST:g} s"
        return None
    off = int(np.flatnonzero(gear)[-1])
    return float(way[-1]), float(way[off]), float(speed[off])


def _landing(plane: Plane) -> tuple[float, float, float] | None:
    """Distance from the screen to a stop, ground roll and airspeed at touchdown."""
    slow = slowest(plane)
    if not slow:
        return None
    path = plane.trim(_APPROACH * slow.speed, gamma=_PATH)
    if not path:
        return None
    on_wheels = trim(plane.flyer(), replace(_above_ground(plane), mode="ground"), hint=False)
    start = replace(_above_ground(plane), speed=path.speed, gamma=_PATH, solver="newton")
    start = replace(start, altitude=on_wheels.altitude + _SCREEN)
    flare = _FLARE * -np.sin(np.radians(_PATH)) * path.tas

    def commands(speed: float, height: float, gear: float, ground: float) -> tuple[float, ...]:
        wheels = height - on_wheels.altitude + plane.base.altitude
        up = _NOSE_UP * min(max(1.0 - wheels / flare, 0.0), 1.0)
        return (1.0, 0.0, -1.0, 1.0) if gear else (0.0, up, -1.0, 0.0)

    track = _flown(plane, start, None, commands, lambda v, h, gear, ground: ground < _STOPPED)
    way, speed, _, gear, ground = track
    down = int(np.flatnonzero(gear)[0]) if gear.any() else -1
    if down < 0 or ground[-1] > _STOPPED:
        plane.reason = f"not at rest within {_LONGEST:g} s"
        return None
    return float(way[-1]), float(way[-1] - way[down]), float(speed[down])


def _above_ground(plane: Plane) -> TrimCondition:
    """The condition of a plane above ground at its altitude."""
    setup = {**plane.base.setup, "ic/terrain-elevation-ft": plane.base.altitude}
    return replace(plane.base, solver=None, setup=setup)


def _flown(
    plane: Plane, condition: TrimCondition, theta: float | None, commands: Any, ends: Any
) -> tuple[np.ndarray, ...]:
    """Way over the ground in ft, airspeed, height of the CG, force on the gear, ground speed.

    ``commands`` returns whether the holds are off, increments of pitch angle and throttle, and the
    brakes, from airspeed, height, force on the gear and ground speed.
    """
    aircraft = Aircraft(
        plane.airframe.aircraft,
        condition=condition,
        root=plane.airframe.root,
        create=plane.create,
        input_properties=["brakes"],
        output_properties=_READ,
    )
    gains = plane.airframe.aircraft
    pitch, roll = PitchHold(gains=gains, theta_ref=theta), RollHold(gains=gains, phi_ref=0.0)
    pilot, scope = Function(commands), Scope()
    wires = [Connection(aircraft[n], pilot[i], scope[i]) for i, n in enumerate(("vc", *_READ))]
    wires += [
        Connection(aircraft["theta"], pitch["theta"]),
        Connection(aircraft["q"], pitch["q"]),
        Connection(aircraft["elev_sat"], pitch["elev_sat"]),
        Connection(aircraft["phi"], roll["phi"]),
        Connection(aircraft["p"], roll["p"]),
        Connection(aircraft["ail_sat"], roll["ail_sat"]),
        Connection(pilot[0], pitch["off"], roll["off"]),
        Connection(pilot[1], pitch["theta_ref"]),
        Connection(pilot[2], aircraft["throttle"]),
        Connection(pilot[3], aircraft["brakes"]),
        Connection(pitch["elevator"], aircraft["elevator"]),
        Connection(roll["aileron"], aircraft["aileron"]),
    ]
    read = lambda: [float(aircraft.outputs[n]) for n in ("vc", *_READ)]  # noqa: E731
    done = Condition(func_evt=lambda t: ends(*read()), func_act=lambda t: sim.stop())
    sim = Simulation([aircraft, pitch, roll, pilot, scope], wires, [done], dt=aircraft.T, log=False)
    sim.run(_LONGEST)
    _, (speed, height, gear, ground) = scope.read()
    return np.cumsum(ground) * aircraft.T, speed, height, gear, ground
