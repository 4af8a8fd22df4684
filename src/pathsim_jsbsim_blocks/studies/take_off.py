"""A take-off whose engine fails: the diagram, its pilot, and the glide."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pathsim import Connection, Simulation
from pathsim.blocks import Constant

from .._core.running import fly
from .._core.units import KNOT
from ..axes.navigation import Place, bearing_from, distance, place
from ..control.pid import DiscretePID
from ..flight import TrimCondition
from ..flight.aircraft import Aircraft
from ..guidance.autopilot import Autopilot

COURSE = 90.0  # deg, of the take-off
END = (0.0, 0.0)  # deg, the end of the runway, which is the threshold on the way back
_LIFT_OFF = 1000.0  # ft before the end of the runway, at the screen height
_SCREEN = 50.0  # ft
_CLIMB, _GLIDE = 75.0, 68.0  # KCAS
_CROSSWIND = 10.0  # kt from the left

# s from the failure to the first control input
_REACTION = 4.0

# deg; D. F. Rogers, The Possible "Impossible" Turn, J. Aircraft 32 (1995), finds the least loss of
# height at 45 deg
_BANK = 45.0

# deg before the threshold is ahead at which the turn ends
_LEAD = 20.0

# from the airspeed in kt to the pitch angle in deg: a pilot who holds a speed
_PILOT = {"Kp": -0.8, "Ki": -0.08, "Kd": -1.0, "Tf": 0.5, "low": -25.0, "high": 5.0}

_ROW = 0.5  # s between two rows, and between two decisions
_LONGEST = 240.0  # s

_MEASURED = ("theta", "phi", "psi", "p", "q", "r", "h", "hdot", "vc", "beta")


@dataclass
class TakeOff:
    """A Cessna 172 that climbs out at full throttle, its airspeed held with the elevator."""

    sim: Simulation
    plane: Aircraft
    autopilot: Autopilot
    speed: Constant
    mixture: Constant
    roll_mode: Constant

    @classmethod
    def build(cls) -> TakeOff:
        feet = distance(place(0.0, -0.5), place(0.0, 0.5))  # in a degree along the equator
        wind = _CROSSWIND * KNOT
        condition = TrimCondition(
            altitude=_SCREEN,
            speed=_CLIMB,
            throttle=1.0,
            heading=COURSE - math.degrees(math.asin(_CROSSWIND / _CLIMB)),
            latitude=END[0],
            longitude=END[1] - _LIFT_OFF / feet,
            wind_north=-wind,
            # low, so that a glide that misses the runway shows by how much
            setup={"ic/terrain-elevation-ft": -5000.0},
        )
        plane = Aircraft("c172p", condition=condition, input_properties=["fcs/mixture-cmd-norm"])
        autopilot = Autopilot("c172p", theta_ref=plane.trim.theta)
        pilot = DiscretePID(**_PILOT)
        speed, mixture, roll_mode, on = map(Constant, (_CLIMB, 0.0, 0.0, 1.0))
        wires: list[tuple[Any, ...]]
        wires = [(plane[port], autopilot[port]) for port in (*_MEASURED, "elev_sat", "ail_sat")]
        wires += [(autopilot[name], plane[name]) for name in ("elevator", "aileron", "rudder")]
        wires += [(speed, pilot["r"]), (plane["vc"], pilot["y"]), (pilot, autopilot["theta_ref"])]
        wires += [(on, autopilot["pitch_mode"], autopilot["speed_off"])]
        wires += [(roll_mode, autopilot["roll_mode"]), (mixture, plane["fcs/mixture-cmd-norm"])]
        blocks = [plane, autopilot, pilot, speed, mixture, roll_mode, on]
        connections = [Connection(*wire) for wire in wires]
        sim = Simulation(blocks, connections, dt=1 / 120, log=False)
        return cls(sim, plane, autopilot, speed, mixture, roll_mode)

    def until(self, time: float) -> None:
        """Fly on to a time in s."""
        fly(self.sim, time - self.sim.time, progress=False)

    def glide(self, side: float) -> list[dict[str, float]]:
        """Stop the engine, and fly on: a row for each half second.

        ``side`` is -1 for a turn to the left, 1 to the right, 0 for none. Straight ahead it ends at
        the height of the runway, after a turn where the threshold is nearest.
        """
        rows = [self.row()]
        # without fuel, whatever the throttle
        self.mixture.value = -self.plane.fdm["fcs/mixture-cmd-norm"]
        self._fly_on(rows, _REACTION)
        self.speed.value = _GLIDE
        if side:
            self.autopilot.phi_ref = side * _BANK
            self.roll_mode.value = 1.0
        turning = side != 0.0
        while rows[-1]["time_s"] < rows[0]["time_s"] + _LONGEST:
            if turning and side * self._bearing() % 360.0 < _LEAD:
                turning, self.roll_mode.value = False, 0.0
            if side and not turning:
                self.autopilot.psi_ref = (self.heading() + self._bearing()) % 360.0
            self._fly_on(rows, _ROW)
            recedes = rows[-1]["distance_ft"] > rows[-2]["distance_ft"]
            if (recedes and not turning) if side else rows[-1]["height_ft"] <= 0.0:
                break
        return rows

    def heading(self) -> float:
        return float(self.plane.outputs["psi"])

    def _bearing(self) -> float:
        """Angle from the heading to the threshold, deg in [0, 360)."""
        return (bearing_from(self._here(), place(*END)) - self.heading()) % 360.0

    def _here(self) -> Place:
        return place(self.plane.outputs["lat"], self.plane.outputs["lon"])

    def _fly_on(self, rows: list[dict[str, float]], duration: float) -> None:
        for _ in range(round(duration / _ROW)):
            fly(self.sim, _ROW, progress=False)
            rows.append(self.row())

    def row(self) -> dict[str, float]:
        """Time, and place relative to the end of the runway."""
        end, position = place(*END), self._here()
        offset = [b - a for a, b in zip(end.position, position.position, strict=True)]
        north, east = (sum(map(float.__mul__, offset, axis)) for axis in (end.north, end.east))
        return {
            "time_s": round(self.sim.time, 6),
            "north_ft": north,
            "east_ft": east,
            "height_ft": float(self.plane.outputs["h"]),
            "speed_kcas": float(self.plane.outputs["vc"]),
            "distance_ft": distance(end, position),
        }
