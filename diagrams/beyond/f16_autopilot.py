"""An F-16's autopilot from core blocks turns by 15 deg.

Each part of the control laws is a block: altitude and course loops command pitch and bank, and the
gains of a linear-quadratic regulator map the errors of airspeed, angle of attack, attitude and
rates to stick, throttle and pedal. They are the laws of NASA's check cases 13 to 16, which the
package has in DAVE-ML too, in ``f16_control.dml``; here the autopilot is on.

Expected: the same flight as `check_case_13_3`, which has the file as a block, to 1e-9 deg. At 15 s
the commanded course turns by 15 deg; the F-16 is at 30 deg of bank half a second later, 36 deg at
most, and within 0.1 deg of the new heading at 30 s.

Source: NASA/TM-2015-218675, atmospheric check case 13.3, and the F-16 that NASA published with it.
"""

from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Adder, Amplifier, Clip, Constant, Function, Scope, StepSource

from pathsim_jsbsim_blocks import JSBSimFDM, TrimCondition
from pathsim_jsbsim_blocks.check_cases import MODELS

DURATION = 30.0  # s

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
DESIGN = 2.653813535191715  # deg, angle of attack and pitch angle for which the gains were made


def longitudinal_gains(airspeed, alpha, q, theta):  # kt, deg, rad/s, deg
    stick = 0.063009074230494 * airspeed - 0.113230403179271 * alpha
    stick -= 10.113432224566077 * q + 3.154983341632913 * theta
    throttle = -0.997260602961658 * airspeed + 0.025467711176391 * alpha
    throttle -= 1.213308488207827 * q + 0.208744369535208 * theta
    return stick, throttle


def lateral_gains(phi, beta, p, r):  # deg, deg, rad/s, rad/s
    stick = -3.07804394151577 * phi - 0.032365863044163 * beta
    stick -= 4.557858908828332 * p + 0.589443156647647 * r
    pedal = 0.70581745275452 * phi + 0.256362860634868 * beta
    pedal += 1.073666149713151 * p - 0.822114635953878 * r
    return stick, pedal


def deflections(pitch, throttle, roll, pedal):
    aileron = -21.5 * roll
    return -25.0 * pitch, aileron, -30.0 * pedal + 0.008 * aileron, 100.0 * throttle


def within_half_a_turn(angle):
    return (angle + 180.0) % 360.0 - 180.0


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

altitude_command = Constant(10013.0)
altitude_error = Adder("+-")
climb = Amplifier(-0.05)  # deg/ft
pitch_step = Clip(-5.0, 5.0)  # deg
design = Constant(DESIGN)
pitch_error = Adder("+--")

course_command = Constant(45.0)
course_step = StepSource(amplitude=15.0, tau=15.0)
course_error = Adder("++--")
half_turn = Function(within_half_a_turn)
turn = Amplifier(-10.0)
bank_command = Clip(-30.0, 30.0)  # deg
bank_error = Adder("+-")

airspeed_command = Constant(KEAS)
airspeed_error = Adder("+-")
alpha_error = Adder("+-")

longitudinal = Function(longitudinal_gains)
lateral = Function(lateral_gains)
trim_stick = Constant(-ELEVATOR / 25)
trim_throttle = Constant(POWER / 100)
stick = Adder()
throttle = Adder()
stops = Clip([-1.0, 0.0, -1.0, -1.0], [1.0, 1.0, 1.0, 1.0])
mixer = Function(deflections)

angles = Scope(labels=["roll angle [deg]", "pitch angle [deg]", "heading [deg]"])
flight = Scope(labels=["altitude [ft]", "equivalent airspeed [kt]"])
surfaces = Scope(labels=["elevator [deg]", "aileron [deg]", "rudder [deg]", "power [%]"])

# from altitude and course to a step of the pitch angle and a bank
outer = Interface()
outer.register_port_map({"pitch": 0, "bank": 1}, {"h": 0, "psi": 1, "beta": 2})
guidance = Subsystem(
    [
        outer,
        altitude_command,
        altitude_error,
        climb,
        pitch_step,
        course_command,
        course_step,
        course_error,
        half_turn,
        turn,
        bank_command,
    ],
    [
        Connection(outer["h"], altitude_error[0]),
        Connection(altitude_command, altitude_error[1]),
        Connection(altitude_error, climb),
        Connection(climb, pitch_step),
        Connection(pitch_step, outer["pitch"]),
        Connection(outer["psi", "beta"], course_error[0, 1]),
        Connection(course_command, course_error[2]),
        Connection(course_step, course_error[3]),
        Connection(course_error, half_turn),
        Connection(half_turn, turn),
        Connection(turn, bank_command),
        Connection(bank_command, outer["bank"]),
    ],
)

# from errors and rates to the control surfaces
STATES = ["phi", "theta", "alpha", "beta", "p", "q", "r", "ve"]
SURFACES = ["elevator", "aileron", "rudder", "power"]
inner = Interface()
inner.register_port_map(
    {name: i for i, name in enumerate(SURFACES)},
    {name: i for i, name in enumerate(["pitch", "bank", *STATES])},
)
regulator = Subsystem(
    [
        inner,
        design,
        pitch_error,
        alpha_error,
        bank_error,
        airspeed_command,
        airspeed_error,
        longitudinal,
        lateral,
        trim_stick,
        trim_throttle,
        stick,
        throttle,
        stops,
        mixer,
    ],
    [
        Connection(inner["theta", "pitch"], pitch_error[0, 1]),
        Connection(design, pitch_error[2], alpha_error[1]),
        Connection(inner["alpha"], alpha_error[0]),
        Connection(inner["phi", "bank"], bank_error[0, 1]),
        Connection(inner["ve"], airspeed_error[0]),
        Connection(airspeed_command, airspeed_error[1]),
        Connection(airspeed_error, longitudinal[0]),
        Connection(alpha_error, longitudinal[1]),
        Connection(inner["q"], longitudinal[2]),
        Connection(pitch_error, longitudinal[3]),
        Connection(bank_error, lateral[0]),
        Connection(inner["beta", "p", "r"], lateral[1:4]),
        Connection(longitudinal[0], stick[0]),
        Connection(trim_stick, stick[1]),
        Connection(longitudinal[1], throttle[0]),
        Connection(trim_throttle, throttle[1]),
        Connection(stick, stops[0]),
        Connection(throttle, stops[1]),
        Connection(lateral[0:2], stops[2, 3]),
        Connection(stops[0:4], mixer[0:4]),
        Connection(mixer[0:4], inner[SURFACES]),
    ],
)

sim = Simulation(
    [vehicle, guidance, regulator, angles, flight, surfaces],
    [
        Connection(vehicle["position/h-sl-ft"], guidance["h"], flight[0]),
        Connection(vehicle["attitude/psi-deg"], guidance["psi"], angles[2]),
        Connection(vehicle["aero/beta-deg"], guidance["beta"], regulator["beta"]),
        Connection(guidance["pitch", "bank"], regulator["pitch", "bank"]),
        Connection(vehicle["attitude/phi-deg"], regulator["phi"], angles[0]),
        Connection(vehicle["attitude/theta-deg"], regulator["theta"], angles[1]),
        Connection(vehicle["aero/alpha-deg"], regulator["alpha"]),
        Connection(vehicle["velocities/pi-rad_sec"], regulator["p"]),
        Connection(vehicle["velocities/qi-rad_sec"], regulator["q"]),
        Connection(vehicle["velocities/ri-rad_sec"], regulator["r"]),
        Connection(vehicle["velocities/ve-kts"], regulator["ve"], flight[1]),
        Connection(regulator["elevator"], vehicle["nesc_f16/elevator-deg"], surfaces[0]),
        Connection(regulator["aileron"], vehicle["nesc_f16/aileron-deg"], surfaces[1]),
        Connection(regulator["rudder"], vehicle["nesc_f16/rudder-deg"], surfaces[2]),
        Connection(regulator["power"], vehicle["nesc_f16/power-pct"], surfaces[3]),
    ],
    dt=1 / 200,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(angles, flight, surfaces, title="F-16: a turn by 15 deg")


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    _, (phi, _, psi) = angles.read()
    print(f"bank up to {phi.max():.2f} deg, heading at the end {psi[-1]:.2f} deg")
    show(figure(), "f16_autopilot")
