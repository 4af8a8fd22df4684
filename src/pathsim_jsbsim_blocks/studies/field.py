"""Take-off and landing distances, flown with the holds of a gain table."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Function, Scope
from pathsim.events import Condition

from ..control.gain_tables import tables
from ..control.holds import PitchHold, RollHold
from ..errors import BlocksError
from ..flight import TrimCondition, TrimState, trim
from ..flight.aircraft import Aircraft
from ..guidance.flare import FlareHold
from .flight_tests import LARGE, Plane, reason_of

_ROTATION, _CLIMB, _APPROACH = 1.05, 1.2, 1.3  # of the stall speed: CS 25.107, 25.107(b), 23.73
_PATH = -3.0  # deg
_SCREEN = 50.0  # ft: CS 23.59, 23.75, 25.125
_LARGE_SCREEN = 35.0  # ft: CS 25.113
_STEEPEST, _USUAL = 15.0, 10.0  # deg, maximum pitch, and pitch if no climb trims
_LONGEST = 120.0  # s
_STOPPED = 3.0  # ft/s, a ground speed that idle thrust may sustain against the brakes

_SPEED = "velocities/vg-fps"
_READ = ("vc", "h_agl", "gear/wow", _SPEED)


def field(plane: Plane) -> None:
    """Take-off with half flaps, landing with full flaps, at the plane's altitude."""
    base = plane.base
    for name, flaps, fly in (("take-off", 0.5, _take_off), ("landing", 1.0, _landing)):
        plane.base = replace(base, flaps=flaps, gear=None if base.gear is None else 1.0)
        measured: tuple[float | None, float | None, float] = None, None, np.nan
        plane.reason = "no gain table"
        if plane.airframe.aircraft in tables():
            try:
                measured = fly(plane)
            except BlocksError as error:
                plane.reason = reason_of(error)
        distance, roll, speed = measured
        plane.put(f"{name} distance", distance, speed)
        plane.put(f"{name} ground roll", roll, speed)
    plane.base = base


def _take_off(plane: Plane) -> tuple[float, float, float]:
    """Distance to the screen, ground roll and airspeed at lift-off."""
    slow = plane.slowest()
    climb = plane.climb(_CLIMB * slow.speed)
    theta = min(climb.theta, _STEEPEST) if climb else _USUAL
    screen = _LARGE_SCREEN if plane.weight > LARGE else _SCREEN
    on_wheels = _on_wheels(plane)
    clear = on_wheels.altitude - plane.base.altitude + screen
    aircraft, gains = _aircraft(plane, on_wheels.condition), plane.airframe.aircraft
    pitch, roll = PitchHold(gains=gains, theta_ref=theta), RollHold(gains=gains, phi_ref=0.0)
    pilot = Function(lambda speed: (1.0, float(speed < _ROTATION * slow.speed)))
    wires = [Connection(aircraft[n], pitch[n]) for n in ("theta", "q", "elev_sat")]
    wires += [Connection(aircraft[n], roll[n]) for n in ("phi", "p", "ail_sat")]
    wires += [Connection(aircraft["vc"], pilot), Connection(pilot[0], aircraft["throttle"])]
    wires += [Connection(pilot[1], pitch["off"], roll["off"])]
    wires += [Connection(pitch["elevator"], aircraft["elevator"])]
    wires += [Connection(roll["aileron"], aircraft["aileron"])]
    way, speed, height, gear, _ = _flown(
        plane, [aircraft, pitch, roll, pilot], wires, lambda: aircraft.outputs["h_agl"] > clear
    )
    if height[-1] < clear or not gear.any():
        raise BlocksError(f"not at {screen:g} ft within {_LONGEST:g} s")
    off = int(np.flatnonzero(gear)[-1])
    return float(way[-1]), float(way[off]), float(speed[off])


def _landing(plane: Plane) -> tuple[float, float, float]:
    """Distance from the screen to a stop, ground roll and airspeed at touchdown."""
    path = plane.trim(_APPROACH * plane.slowest().speed, gamma=_PATH)
    if not path:
        raise BlocksError(plane.reason)
    on_wheels = _on_wheels(plane).altitude
    start = replace(_above_ground(plane), speed=path.speed, gamma=_PATH)
    aircraft = _aircraft(plane, replace(start, altitude=on_wheels + _SCREEN))
    flare = FlareHold(
        gains=plane.airframe.aircraft, gear_height=on_wheels - plane.base.altitude, sink=4.0
    )
    read = ("h_agl", "hdot", "theta", "q", "psi", "phi", "p", "r", "vc")
    wires = [Connection(aircraft[n], flare[n]) for n in read]
    wires += [Connection(aircraft["gear/wow"], flare["wow"], aircraft["brakes"])]
    zero, idle = Constant(0.0), Constant(-1.0)
    wires += [Connection(zero, flare["loc_ft"], flare["loc_dist"])]
    wires += [Connection(idle, flare["throttle"])]
    done = ("elevator", "aileron", "rudder", "throttle", "steering")
    wires += [Connection(flare[n], aircraft[n]) for n in done]
    way, speed, _, gear, ground = _flown(
        plane, [aircraft, flare, zero, idle], wires, lambda: aircraft.outputs[_SPEED] < _STOPPED
    )
    down = int(np.flatnonzero(gear)[0]) if gear.any() else -1
    if down < 0 or ground[-1] > _STOPPED:
        raise BlocksError(f"not at rest within {_LONGEST:g} s")
    return float(way[-1]), float(way[-1] - way[down]), float(speed[down])


def _on_wheels(plane: Plane) -> TrimState:
    """The plane at rest on ground at its altitude."""
    return trim(plane.flyer(), replace(_above_ground(plane), mode="ground"), hint=False)


def _above_ground(plane: Plane) -> TrimCondition:
    """The plane's condition, with the ground at its altitude."""
    setup = {**plane.base.setup, "ic/terrain-elevation-ft": plane.base.altitude}
    return replace(plane.base, setup=setup)


def _aircraft(plane: Plane, condition: TrimCondition) -> Aircraft:
    return Aircraft(
        plane.airframe.aircraft,
        condition=condition,
        root=plane.airframe.root,
        create=plane.create,
        input_properties=["brakes", "steering"],
        output_properties=["h_agl", "gear/wow", _SPEED],
    )


def _flown(plane: Plane, blocks: list[Any], wires: list[Any], ends: Any) -> tuple[np.ndarray, ...]:
    """Distance in ft, airspeed, height of the CG, weight on wheels, ground speed: arrays."""
    aircraft, scope = blocks[0], Scope()
    wires += [Connection(aircraft[n], scope[i]) for i, n in enumerate(_READ)]
    done = Condition(lambda t: ends(), func_act=lambda t: sim.stop())
    sim = Simulation([*blocks, scope], wires, [done], dt=aircraft.T, log=False)
    sim.run(_LONGEST)
    _, (speed, height, gear, ground) = scope.read()
    return np.cumsum(ground) * aircraft.T, speed, height, gear, ground
