"""Fly with the outer engine failed, for docs/evidence/autopilots-engines.csv.

    python docs/failed_engines.py [AIRCRAFT ...]

The outer engine of each aircraft with several fails, in a climb at full throttle and in cruise,
with the tanks at a fifth and full.
"""

import sys
from dataclasses import replace

import pandas as pd
from gain_tables import flight_of, flown_by, fuel, seen_by, table_of
from tables import write_table

from pathsim_jsbsim_blocks import Aircraft, Autopilot
from pathsim_jsbsim_blocks.control.gain_tables import read_gains
from pathsim_jsbsim_blocks.errors import BlocksError
from pathsim_jsbsim_blocks.flight import Airframe, aircraft_names

T = 1 / 60
# s before the engine fails, and after it; the last of them; ft of climb
FAILS, AFTER, LAST, CLIMBS = 20.0, 100.0, 20.0, 20_000.0
# of the tanks
FUEL = {"light": 0.2, "heavy": 1.0}


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
    """Signals from the failure of an engine on, and the table's lowest airspeed at the end."""
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
    psi = seen["psi"]

    def asked(k, seen):
        if k * T >= FAILS:
            stop_engine(plane)
        return references

    for command, seen in flown_by(pilot(name), plane, round((FAILS + AFTER) / T), asked):
        row = {signal: seen[signal] for signal in ("beta", "h", "vc")}
        off = (seen["psi"] - psi + 180.0) % 360.0 - 180.0
        rows.append({**row, "off": off, "rudder": command[2]})
    y = pd.DataFrame(rows[round(FAILS / T) :])
    return y, schedule.at(seen["h"], seen["vc"]).envelope.vc_min


def main(names):
    """The table of failed engines."""
    rows = []
    for name in names or aircraft_names():
        if not table_of(name).exists():
            continue
        if Airframe(name, create=flight_of(name).create).engines < 2:
            continue
        for climbs, phase in ((True, "climb"), (False, "cruise")):
            row = {"": f"{name}, {phase}"}
            for load, share in FUEL.items():
                sideslip = f"{load}: sideslip at the end, largest [deg]"
                try:
                    y, slowest = engine_out(name, share, climbs)
                except BlocksError as error:
                    row[sideslip] = f"{error}"[:60]
                    continue
                last = y[-round(LAST / T) :].mean()
                row |= {
                    sideslip: f"{abs(last.beta):.1f}, {y.beta.abs().max():.1f}",
                    f"{load}: rudder": f"{last.rudder:+.2f}",
                    f"{load}: heading [deg]": f"{y.off.abs().max():.1f}",
                    f"{load}: lowest airspeed (limit) [kt]": f"{y.vc.min():.0f} ({slowest:.0f})",
                    f"{load}: height [ft]": f"{y.h.iloc[-1] - y.h.iloc[0]:+.0f}",
                }
            print(*row.values(), sep=" | ", flush=True)
            rows.append(row)
    if not names:
        write_table("autopilots-engines", rows)


if __name__ == "__main__":
    main(sys.argv[1:])
