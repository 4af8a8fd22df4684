"""NASA's check case 16: an F-16 circles where the equator meets the date line.

It tests navigation and axes where latitude and longitude change sign. The F-16 starts 3 nautical
miles to the east of 0 N, 180 E, heading north, and its autopilot follows a circle around it.

Expected: within 0.01 ft in altitude of simulator 05, 2e-6 deg, and 0.04 deg of bank.

Source: NASA/TM-2015-218675, atmospheric check case 16, and the F-16 that NASA published with it.
"""

from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Constant, Scope

from pathsim_jsbsim_blocks import DaveML, JSBSimFDM, TrimCondition
from pathsim_jsbsim_blocks.check_cases import MODELS

DURATION = 180.0  # s

# level flight over the ellipsoid, in still air: the angle of attack, elevator and power at which
# udot, wdot and qdot are 0, and the rates at which the vertical turns
ALPHA = 2.665371398301661  # deg
ELEVATOR = -3.246947388511962  # deg, trailing edge down
POWER = 13.819634389165477  # percent
RATES = [
    0.0,
    -2.710400408366082e-05,
    0.0,
]  # rad/s, relative to the Earth
KEAS = 287.0001866662163  # kt

vehicle = JSBSimFDM(
    T=1 / 200,
    input_properties=[
        "nesc_f16/elevator-deg",
        "nesc_f16/aileron-deg",
        "nesc_f16/rudder-deg",
        "nesc_f16/power-pct",
    ],
    output_properties=[
        "position/h-sl-ft",
        "position/lat-geod-deg",
        "position/long-gc-deg",
        "velocities/vt-fps",
        "attitude/phi-deg",
        "attitude/theta-deg",
        "attitude/psi-deg",
        "aero/alpha-deg",
        "aero/beta-deg",
        "velocities/pi-rad_sec",
        "velocities/qi-rad_sec",
        "velocities/ri-rad_sec",
        "velocities/ve-kts",
    ],
    JSBSim_path=MODELS,
    aircraft_model="nesc_f16",
    condition=TrimCondition(
        mode="none",
        altitude=10000.0,
        heading=0.0,
        latitude=0.0,
        longitude=-179.95,
        setup={
            "ic/vn-fps": 563.643,
            "ic/ve-fps": 0.0,
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
laws = DaveML("f16_control.dml")
autopilot_on = Constant(1.0)
trim_throttle = Constant(POWER / 100)
trim_stick = Constant(-ELEVATOR / 25)
circle = DaveML("f16_circle.dml")
around_pole = Constant(0.0)
altitude_command = Constant(10000.0)
airspeed_command = Constant(KEAS)
position = Scope(labels=["altitude [ft]", "latitude [deg]", "longitude [deg]"])
speed = Scope(labels=["true airspeed [ft/s]"])
attitude = Scope(labels=["roll angle [deg]", "pitch angle [deg]", "heading [deg]"])
surfaces = Scope(labels=["elevator [deg]", "aileron [deg]", "rudder [deg]", "power [%]"])

# the commands to the autopilot, and the trim from which it starts
COMMANDS = ["on", "throttle", "stick", "altitude", "airspeed"]
signals = Interface()
signals.register_port_map({name: i for i, name in enumerate(COMMANDS)}, {})
commands = Subsystem(
    [signals, autopilot_on, trim_throttle, trim_stick, altitude_command, airspeed_command],
    [
        Connection(autopilot_on, signals["on"]),
        Connection(trim_throttle, signals["throttle"]),
        Connection(trim_stick, signals["stick"]),
        Connection(altitude_command, signals["altitude"]),
        Connection(airspeed_command, signals["airspeed"]),
    ],
)

sim = Simulation(
    [
        vehicle,
        commands,
        laws,
        circle,
        around_pole,
        position,
        speed,
        attitude,
        surfaces,
    ],
    [
        Connection(vehicle["position/h-sl-ft"], laws["altitudeMsl"], position[0]),
        Connection(vehicle["position/lat-geod-deg"], position[1], circle["geLatitude"]),
        Connection(vehicle["position/long-gc-deg"], position[2], circle["geLongitude"]),
        Connection(vehicle["velocities/vt-fps"], speed[0]),
        Connection(vehicle["attitude/phi-deg"], laws["eulerAngle_Roll"], attitude[0]),
        Connection(vehicle["attitude/theta-deg"], laws["eulerAngle_Pitch"], attitude[1]),
        Connection(vehicle["attitude/psi-deg"], laws["eulerAngle_Yaw"], attitude[2]),
        Connection(vehicle["aero/alpha-deg"], laws["angleOfAttack"]),
        Connection(vehicle["aero/beta-deg"], laws["angleOfSideslip"]),
        Connection(vehicle["velocities/pi-rad_sec"], laws["bodyAngularRate_Roll"]),
        Connection(vehicle["velocities/qi-rad_sec"], laws["bodyAngularRate_Pitch"]),
        Connection(vehicle["velocities/ri-rad_sec"], laws["bodyAngularRate_Yaw"]),
        Connection(vehicle["velocities/ve-kts"], laws["equivalentAirspeed"]),
        Connection(around_pole, circle["circleThePole"]),
        Connection(circle["lateralOffset"], laws["lateralOffset"]),
        Connection(circle["courseCommand"], laws["courseCommand"]),
        Connection(commands["on"], laws["autopilotOn"]),
        Connection(commands["throttle"], laws["trimThrottle"]),
        Connection(commands["stick"], laws["trimStick"]),
        Connection(commands["altitude"], laws["altitudeCommand"]),
        Connection(commands["airspeed"], laws["airspeedCommand"]),
        Connection(laws["elevatorDeflection"], vehicle["nesc_f16/elevator-deg"], surfaces[0]),
        Connection(laws["aileronDeflection"], vehicle["nesc_f16/aileron-deg"], surfaces[1]),
        Connection(laws["rudderDeflection"], vehicle["nesc_f16/rudder-deg"], surfaces[2]),
        Connection(laws["powerLeverAngle"], vehicle["nesc_f16/power-pct"], surfaces[3]),
    ],
    dt=1 / 200,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.check_cases import comparison_figure

    return comparison_figure(16, position, speed, attitude)


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.check_cases import compare, comparison_table
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    print(comparison_table(16, compare(16, position, speed, attitude)))
    show(figure(), "check_case_16")
