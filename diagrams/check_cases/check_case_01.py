"""NASA's check case 1: a sphere falls without drag.

It tests gravity and translation. The sphere is at rest relative to the rotating Earth, 30,000 ft
above the equator, and falls for 30 s without drag.

Expected: within the band of NASA's simulators in every quantity; 0.0003 ft in altitude from
simulator 05. The sphere has the eastward speed of a larger circle: it drifts 6.4 m to the east.

Source: NASA/TM-2015-218675, atmospheric check case 1.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import JSBSimFDM
from pathsim_jsbsim_blocks.check_cases import MODELS

DURATION = 30.0  # s
OMEGA = 7.292115e-5  # rad/s, rotation of the Earth: ic/ rates are relative to it

vehicle = JSBSimFDM(
    T=1 / 100,
    output_properties=[
        "position/h-sl-ft",
        "position/lat-geod-deg",
        "position/long-gc-deg",
        "velocities/vt-fps",
        "velocities/v-north-fps",
        "velocities/v-east-fps",
        "velocities/v-down-fps",
        "attitude/phi-deg",
        "attitude/theta-deg",
        "attitude/psi-deg",
        "velocities/pi-rad_sec",
        "velocities/qi-rad_sec",
        "velocities/ri-rad_sec",
    ],
    JSBSim_path=MODELS,
    aircraft_model="nesc_sphere",
    trim_airspeed=0.0,
    trim_altitude=30000.0,
    trim_mode="none",
    setup={"nesc/cd": 0.0, "ic/p-rad_sec": -OMEGA},
    integrators="precise",
)
position = Scope(labels=["altitude [ft]", "latitude [deg]", "longitude [deg]"])
velocity = Scope(
    labels=[
        "true airspeed [ft/s]",
        "velocity north [ft/s]",
        "velocity east [ft/s]",
        "velocity down [ft/s]",
    ]
)
attitude = Scope(labels=["roll angle [deg]", "pitch angle [deg]", "heading [deg]"])
rates = Scope(labels=["roll rate [rad/s]", "pitch rate [rad/s]", "yaw rate [rad/s]"])

sim = Simulation(
    [vehicle, position, velocity, attitude, rates],
    [
        Connection(vehicle["position/h-sl-ft"], position[0]),
        Connection(vehicle["position/lat-geod-deg"], position[1]),
        Connection(vehicle["position/long-gc-deg"], position[2]),
        Connection(vehicle["velocities/vt-fps"], velocity[0]),
        Connection(vehicle["velocities/v-north-fps"], velocity[1]),
        Connection(vehicle["velocities/v-east-fps"], velocity[2]),
        Connection(vehicle["velocities/v-down-fps"], velocity[3]),
        Connection(vehicle["attitude/phi-deg"], attitude[0]),
        Connection(vehicle["attitude/theta-deg"], attitude[1]),
        Connection(vehicle["attitude/psi-deg"], attitude[2]),
        Connection(vehicle["velocities/pi-rad_sec"], rates[0]),
        Connection(vehicle["velocities/qi-rad_sec"], rates[1]),
        Connection(vehicle["velocities/ri-rad_sec"], rates[2]),
    ],
    dt=1 / 100,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.check_cases import comparison_figure

    return comparison_figure(1, position, velocity, attitude, rates)


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.check_cases import compare, comparison_table
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    print(comparison_table(1, compare(1, position, velocity, attitude, rates)))
    show(figure(), "check_case_01")
