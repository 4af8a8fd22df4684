"""NASA's check case 12: an F-16 in supersonic flight, controls fixed.

It tests the same as case 11 at 30,013 ft and Mach 2.01. The aerodynamic tables are those of low
speed: the case compares simulators, not aircraft.

Expected: within 0.003 ft in altitude and 5e-6 deg of simulator 05.

Source: NASA/TM-2015-218675, atmospheric check case 12, and the F-16 that NASA published with it.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import JSBSimFDM, TrimCondition
from pathsim_jsbsim_blocks.check_cases import MODELS

DURATION = 180.0  # s

# level flight over the ellipsoid, in still air: the angle of attack, elevator and power at which
# udot, wdot and qdot are 0, and the rates at which the vertical turns
ALPHA = -0.741578296083522  # deg
ELEVATOR = -1.5278623251588221  # deg, trailing edge down
POWER = 91.06616021496224  # percent
RATES = [
    -8.441372068922922e-07,
    -9.553908289522695e-05,
    -4.9002381526452036e-05,
]  # rad/s, relative to the Earth

vehicle = JSBSimFDM(
    T=1 / 200,
    output_properties=[
        "position/h-sl-ft",
        "position/lat-geod-deg",
        "position/long-gc-deg",
        "velocities/vt-fps",
        "attitude/phi-deg",
        "attitude/theta-deg",
        "attitude/psi-deg",
    ],
    JSBSim_path=MODELS,
    aircraft_model="nesc_f16",
    condition=TrimCondition(
        mode="none",
        altitude=30013.0,
        heading=45.0,
        latitude=36.01916667,
        longitude=-75.67444444,
        setup={
            "ic/vn-fps": 1414.2135593,
            "ic/ve-fps": 1414.2135593,
            "ic/theta-deg": ALPHA,
            "ic/p-rad_sec": RATES[0],
            "ic/q-rad_sec": RATES[1],
            "ic/r-rad_sec": RATES[2],
            "nesc_f16/elevator-deg": ELEVATOR,
            "nesc_f16/power-pct": POWER,
        },
    ),
    integrators="precise",
)
position = Scope(labels=["altitude [ft]", "latitude [deg]", "longitude [deg]"])
speed = Scope(labels=["true airspeed [ft/s]"])
attitude = Scope(labels=["roll angle [deg]", "pitch angle [deg]", "heading [deg]"])

sim = Simulation(
    [vehicle, position, speed, attitude],
    [
        Connection(vehicle["position/h-sl-ft"], position[0]),
        Connection(vehicle["position/lat-geod-deg"], position[1]),
        Connection(vehicle["position/long-gc-deg"], position[2]),
        Connection(vehicle["velocities/vt-fps"], speed[0]),
        Connection(vehicle["attitude/phi-deg"], attitude[0]),
        Connection(vehicle["attitude/theta-deg"], attitude[1]),
        Connection(vehicle["attitude/psi-deg"], attitude[2]),
    ],
    dt=1 / 200,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.check_cases import comparison_figure

    return comparison_figure(12, position, speed, attitude)


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.check_cases import compare, comparison_table
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    print(comparison_table(12, compare(12, position, speed, attitude)))
    show(figure(), "check_case_12")
