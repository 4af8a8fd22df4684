"""NASA's check case 13.1: an F-16's autopilot climbs by 100 ft.

It tests control laws together with the aircraft. The F-16 of case 11 flies on its stability
augmentation and autopilot; at 5 s the commanded altitude rises by 100 ft.

Expected: within 0.33 ft in altitude of simulator 05, and 0.003 kt in airspeed. Level flight is
held 0.31 ft above the command: the published laws are made for a pitch angle 0.015 deg above that
of the trim. The simulator has no such offset.

Source: NASA/TM-2015-218675, atmospheric check case 13.1, and the F-16 that NASA published with it.
"""

from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Adder, Constant, Scope, StepSource

from pathsim_jsbsim_blocks import DaveML, JSBSimFDM, TrimCondition
from pathsim_jsbsim_blocks.check_cases import MODELS

DURATION = 20.0  # s

# level flight over the ellipsoid, in still air: the angle of attack, elevator and power at which
# udot, wdot and qdot are 0, and the rates at which the vertical turns
ALPHA = 2.6389076926144264  # deg
ELEVATOR = -3.232741194162996  # deg, trailing edge down
POWER = 13.873860063261105  # percent
RATES = [
    5.794250606300034e-07,
    -2.7048375306696378e-05,
    -1.3863146715424909e-05,
]  # rad/s, relative to the Earth
KEAS = 287.9813957627089  # kt

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
        altitude=10013.0,
        heading=45.0,
        latitude=36.01916667,
        longitude=-75.67444444,
        setup={
            "ic/vn-fps": 400.0,
            "ic/ve-fps": 400.0,
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
altitude_command = Constant(10013.0)
altitude_step = StepSource(amplitude=100.0, tau=5.0)
new_altitude = Adder()
airspeed_command = Constant(KEAS)
course_command = Constant(45.0)
offset = Constant(0.0)
position = Scope(labels=["altitude [ft]", "latitude [deg]", "longitude [deg]"])
speed = Scope(labels=["true airspeed [ft/s]"])
attitude = Scope(labels=["roll angle [deg]", "pitch angle [deg]", "heading [deg]"])
surfaces = Scope(labels=["elevator [deg]", "aileron [deg]", "rudder [deg]", "power [%]"])

# the commands to the autopilot, and the trim from which it starts
COMMANDS = ["on", "throttle", "stick", "altitude", "airspeed", "course", "offset"]
signals = Interface()
signals.register_port_map({name: i for i, name in enumerate(COMMANDS)}, {})
commands = Subsystem(
    [
        signals,
        autopilot_on,
        trim_throttle,
        trim_stick,
        altitude_command,
        altitude_step,
        new_altitude,
        airspeed_command,
        course_command,
        offset,
    ],
    [
        Connection(autopilot_on, signals["on"]),
        Connection(trim_throttle, signals["throttle"]),
        Connection(trim_stick, signals["stick"]),
        Connection(altitude_command, new_altitude[0]),
        Connection(altitude_step, new_altitude[1]),
        Connection(new_altitude, signals["altitude"]),
        Connection(airspeed_command, signals["airspeed"]),
        Connection(course_command, signals["course"]),
        Connection(offset, signals["offset"]),
    ],
)

sim = Simulation(
    [
        vehicle,
        commands,
        laws,
        position,
        speed,
        attitude,
        surfaces,
    ],
    [
        Connection(vehicle["position/h-sl-ft"], laws["altitudeMsl"], position[0]),
        Connection(vehicle["position/lat-geod-deg"], position[1]),
        Connection(vehicle["position/long-gc-deg"], position[2]),
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
        Connection(commands["on"], laws["autopilotOn"]),
        Connection(commands["throttle"], laws["trimThrottle"]),
        Connection(commands["stick"], laws["trimStick"]),
        Connection(commands["altitude"], laws["altitudeCommand"]),
        Connection(commands["airspeed"], laws["airspeedCommand"]),
        Connection(commands["course"], laws["courseCommand"]),
        Connection(commands["offset"], laws["lateralOffset"]),
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

    return comparison_figure(13.1, position, speed, attitude)


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.check_cases import compare, comparison_table
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    print(comparison_table(13.1, compare(13.1, position, speed, attitude)))
    show(figure(), "check_case_13_1")
