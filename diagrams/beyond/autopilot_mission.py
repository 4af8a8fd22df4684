"""A mission on autopilot, in turbulence: climb, turn, accelerate, level off.

A Boeing 737 at 10,000 ft and 280 KCAS, gear up, in moderate turbulence: JSBSim's MIL-spec model
with severity 4 (3 is light, 6 severe), about 9 ft/s rms. One ``Autopilot`` block flies it; its
references change through step sources: 1500 ft up at 20 s, 60 deg to the right at 60 s, 15 kt
faster at 130 s, 500 ft down at 180 s.

Expected: the aircraft follows every reference through the gusts: altitude within 45 ft, heading
within 2.2 deg and airspeed within 15.1 kt once captured; the elevator and the ailerons stay off
their stops, and the throttle is at a stop for 0.2 % of the time. The airspeed loop follows the
aircraft's own motion (ports ``nx``, ``nz``, ``vt``), not the gusts.

Source: our own.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope, StepSource

from pathsim_jsbsim_blocks import Aircraft, Autopilot

DURATION = 270.0  # s

aircraft = Aircraft(
    aircraft="737",
    altitude=10000.0,
    speed=280.0,
    heading=90.0,
    gear=0.0,
    properties={
        "atmosphere/randomseed": 7.0,
        "atmosphere/turb-type": 3.0,
        "atmosphere/turbulence/milspec/severity": 4.0,
    },
)
autopilot = Autopilot(gains="737")
climb = StepSource(amplitude=[1500.0, 1000.0], tau=[20.0, 180.0])
turn = StepSource(amplitude=60.0, tau=60.0)
accelerate = StepSource(amplitude=15.0, tau=130.0)
flight = Scope(labels=["altitude [ft]", "heading [deg]", "calibrated airspeed [kt]"])
attitude = Scope(labels=["pitch angle [deg]", "roll angle [deg]"])
elevator = Scope(labels=["elevator increment [-]"])
aileron = Scope(labels=["aileron increment [-]"])
throttle = Scope(labels=["throttle increment [-]"])

sim = Simulation(
    [aircraft, autopilot, climb, turn, accelerate, flight, attitude, elevator, aileron, throttle],
    [
        Connection(aircraft["theta"], autopilot["theta"], attitude[0]),
        Connection(aircraft["phi"], autopilot["phi"], attitude[1]),
        Connection(aircraft["psi"], autopilot["psi"], flight[1]),
        Connection(aircraft["p"], autopilot["p"]),
        Connection(aircraft["q"], autopilot["q"]),
        Connection(aircraft["r"], autopilot["r"]),
        Connection(aircraft["h"], autopilot["h"], flight[0]),
        Connection(aircraft["hdot"], autopilot["hdot"]),
        Connection(aircraft["vc"], autopilot["vc"], flight[2]),
        Connection(aircraft["elev_sat"], autopilot["elev_sat"]),
        Connection(aircraft["ail_sat"], autopilot["ail_sat"]),
        Connection(aircraft["thr_sat"], autopilot["thr_sat"]),
        Connection(aircraft["alpha"], autopilot["alpha"]),
        Connection(aircraft["vt"], autopilot["vt"]),
        Connection(aircraft["nx"], autopilot["nx"]),
        Connection(aircraft["nz"], autopilot["nz"]),
        Connection(climb, autopilot["h_ref"]),
        Connection(turn, autopilot["psi_ref"]),
        Connection(accelerate, autopilot["vc_ref"]),
        Connection(autopilot["elevator"], aircraft["elevator"], elevator),
        Connection(autopilot["aileron"], aircraft["aileron"], aileron),
        Connection(autopilot["rudder"], aircraft["rudder"]),
        Connection(autopilot["throttle"], aircraft["throttle"], throttle),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(
        flight,
        attitude,
        throttle,
        title="737: a mission in moderate turbulence",
        references={
            "altitude": lambda time: 10000.0 + 1500.0 * (time >= 20.0) - 500.0 * (time >= 180.0),
            "heading": lambda time: 90.0 + 60.0 * (time >= 60.0),
            "calibrated airspeed": lambda time: 280.0 + 15.0 * (time >= 130.0),
        },
    )


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    time, h = signal(flight, "altitude")
    _, psi = signal(flight, "heading")
    _, airspeed = signal(flight, "calibrated airspeed")
    last = time > time[-1] - 20.0
    print(
        f"from {time[last][0]:.0f} s on, with the commands of the end in brackets: altitude "
        f"{h[last].min():.0f} to {h[last].max():.0f} ft ({h[0] + climb.outputs[0]:.0f}), heading "
        f"{psi[last].min():.1f} to {psi[last].max():.1f} deg ({psi[0] + turn.outputs[0]:.0f}), "
        f"airspeed {airspeed[last].min():.1f} to {airspeed[last].max():.1f} KCAS "
        f"({airspeed[0] + accelerate.outputs[0]:.0f})"
    )
    show(figure(), "autopilot_mission")
