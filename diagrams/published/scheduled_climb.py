"""Climb by schedule: throttle and pitch trim follow the altitude through lookup tables.

An A-4 climbs from a trim at 1000 ft, 300 KCAS and 5 deg. The tables hold the commands of that trim
at each 1000 ft (the study ``climb_schedule``); only the altitude is fed back. The run stops at
20,000 ft.

Expected: 20,000 ft after 406.3 s, at 295.7 KCAS and 4.6 deg: the tables come from steady-climb
trims and do not include the thrust that accelerates the aircraft at constant calibrated airspeed.

Source: notebook 10 of the published JSBSim/PathSim notebooks; its flight with the first trim held
is the diagram ``fixed_trim_climb``. Alpha is limited to -4 to 12 deg, as published.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import LUT1D, Scope
from pathsim.events import Condition

from pathsim_jsbsim_blocks import JSBSimFDM

DURATION = 450.0  # s, more than it takes

ALTITUDE = [1000, 2000, 3000, 4000, 5000, 6000, 7000, 8000, 9000, 10000, 11000, 12000, 13000,
            14000, 15000, 16000, 17000, 18000, 19000, 20000]  # ft
THROTTLE = [0.69076794325, 0.698955743865, 0.707422310369, 0.716184647075, 0.725261276549,
            0.734672432655, 0.744440268238, 0.754589097206, 0.765145674927, 0.776139524273,
            0.784889983499, 0.794096238841, 0.803790372599, 0.814007238768, 0.82478470302,
            0.835603804133, 0.845880311453, 0.856598238222, 0.867792864624, 0.879503582485]
PITCH_TRIM = [-0.0781438043203, -0.0786281641573, -0.0791320128655, -0.079656316511,
              -0.0802020938372, -0.080770424867, -0.0813624540512, -0.0819793946884,
              -0.0826225336866, -0.0832932366987, -0.0839929527203, -0.0847232304745,
              -0.0854856919101, -0.0862820851106, -0.087114262025, -0.0879841938903,
              -0.088893981509, -0.089845859524, -0.0908422162987, -0.0918855996495]

fdm = JSBSimFDM(
    T=1 / 120,
    input_properties=["fcs/throttle-cmd-norm", "fcs/pitch-trim-cmd-norm"],
    output_properties=["position/h-sl-ft", "velocities/vc-kts", "flight-path/gamma-deg"],
    aircraft_model="A4",
    trim_airspeed=300.0,
    trim_altitude=1000.0,
    trim_gamma=5.0,
    gear=1.0,
    setup={
        "aero/alpha-min-rad": -0.06981317007977318,
        "aero/alpha-max-rad": 0.20943951023931953,
    },
)
throttle = LUT1D(points=ALTITUDE, values=THROTTLE)
pitch_trim = LUT1D(points=ALTITUDE, values=PITCH_TRIM)
flight = Scope(sampling_period=1.0, labels=["altitude [ft]", "calibrated airspeed [kt]",
                                            "flight path angle [deg]"])
power = Scope(sampling_period=1.0, labels=["throttle command [-]"])
pitch = Scope(sampling_period=1.0, labels=["pitch trim command [-]"])
top = Condition(
    func_evt=lambda t: fdm.outputs["position/h-sl-ft"] >= 20000.0,
    func_act=lambda t: sim.stop(),
)

sim = Simulation(
    [fdm, throttle, pitch_trim, flight, power, pitch],
    [
        Connection(fdm["position/h-sl-ft"], throttle, pitch_trim, flight[0]),
        Connection(fdm["velocities/vc-kts"], flight[1]),
        Connection(fdm["flight-path/gamma-deg"], flight[2]),
        Connection(throttle, fdm["fcs/throttle-cmd-norm"], power),
        Connection(pitch_trim, fdm["fcs/pitch-trim-cmd-norm"], pitch),
    ],
    [top],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(
        flight,
        power,
        pitch,
        title="A-4: climb by the trims of 300 KCAS and 5 deg",
        references={"calibrated airspeed": 300.0, "flight path angle": 5.0},
    )


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    print(f"{fdm.outputs['position/h-sl-ft']:.1f} ft after {sim.time:.1f} s, "
          f"at {fdm.outputs['velocities/vc-kts']:.1f} KCAS, "
          f"flight path angle {fdm.outputs['flight-path/gamma-deg']:.2f} deg")
    show(figure(), "scheduled_climb")
