"""Fly with the outer engine failed, for docs/evidence/autopilots-engines.csv.

    python docs/failed_engines.py [AIRCRAFT ...]

The outer engine of each aircraft with several fails, in a climb at full throttle and in cruise,
with the tanks at a fifth and full.
"""

import sys
from dataclasses import replace

import numpy as np
from gain_tables import flight_of, flown_by, fuel, seen_by, table_of
from tables import write_table

from pathsim_jsbsim_blocks import Aircraft, Autopilot
from pathsim_jsbsim_blocks.control.gain_tables import read_gains
from pathsim_jsbsim_blocks.errors import BlocksError
from pathsim_jsbsim_blocks.flight import Airframe, aircraft_names

T = 1 / 60
# s before the engine fails, and after it; the last of them; ft of climb
FAILS, AFTER, LAST, CLIMBS = 20.0, 100.0, 20.0, 20_000.0
ENGINES = """\
| | light: sideslip at the end, largest [deg] | rudder | heading [deg] \
| lowest airspeed (limit) [kt] | height [ft] \
| heavy: sideslip | rudder | heading | airspeed | height |
|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"""


def pilot(name):
    """An autopilot with the gains of an aircraft, its references wired and absolute."""
    autopilot = Autopilot(str(table_of(name)), reference="absolute", T=T)
    for port in (port for port in Autopilot.input_port_labels if port.endswith("_ref")):
        autopilot[port].get_inputs()  # as a connection does
    return autopilot


def stop_engine(plane):
    """Stop the outer engine: a piston engine goes on running until its mixture is cut."""
    plane.airframe.fdm["propulsion/engine[0]/set-running"] = 0.0
    plane.airframe.fdm["fcs/mixture-cmd-norm[0]"] = 0.0


def engine_out(name, share, climbs):
    """Fly with a failed engine: signals from the failure on, or an error; and the lowest airspeed.

    Columns: sideslip, rudder, its excess, heading error, height gained, airspeed, throttle.
    """
    flight, schedule = flight_of(name), read_gains(table_of(name))
    nominal = schedule.points[schedule.nominal]
    tanks = fuel(Aircraft(name, condition=flight.condition, create=flight.create), 1.0)
    condition = replace(
        flight.condition,
        altitude=nominal.altitude,
        speed=nominal.speed,
        fuel={tank: share * full for tank, full in tanks.items()},
    )
    plane = Aircraft(name, condition=condition, create=flight.create, T=T, substeps=2)
    seen, rows = seen_by(plane), []
    references = {f"{port}_ref": seen[port] for port in ("h", "psi", "vc")}
    if climbs:
        references |= {"v_mode": 2.0, "thr_ref": 1.0, "h_ref": seen["h"] + CLIMBS}
    psi, h = seen["psi"], seen["h"]

    def asked(k, seen):
        if k * T >= FAILS:
            stop_engine(plane)
        return references

    for command, seen in flown_by(pilot(name), plane, round((FAILS + AFTER) / T), asked):
        off = (seen["psi"] - psi + 180.0) % 360.0 - 180.0
        moved = seen["beta"], command[2], seen["rud_sat"], off, seen["h"] - h, seen["vc"]
        rows.append((*moved, command[3]))
    return np.array(rows[round(FAILS / T) :]), schedule.at(seen["h"], seen["vc"]).envelope.vc_min


def main(names):
    """The table of failed engines."""
    lines = [ENGINES]
    for name in names or aircraft_names():
        if not table_of(name).exists():
            continue
        if Airframe(name, create=flight_of(name).create).engines < 2:
            continue
        for climbs, phase in ((True, "climb"), (False, "cruise")):
            cells = [f"| {name}, {phase}"]
            for share in (0.2, 1.0):
                try:
                    y, slowest = engine_out(name, share, climbs)
                except BlocksError as error:
                    cells.append(f"{error}"[:60] + " | | | | ")
                    continue
                last = y[-round(LAST / T) :].mean(axis=0)
                cells.append(
                    f"{abs(last[0]):.1f}, {np.abs(y[:, 0]).max():.1f} | {last[1]:+.2f} "
                    f"| {np.abs(y[:, 3]).max():.1f} | {y[:, 5].min():.0f} ({slowest:.0f}) "
                    f"| {y[-1, 4] - y[0, 4]:+.0f}"
                )
            lines.append(" | ".join(cells) + " |")
            print(lines[-1], flush=True)
    if not names:
        write_table("autopilots-engines", "\n".join(lines) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
