"""Aileron turn: a fixed aileron command sets a roll rate, not a roll angle.

A Cessna 172 at 5000 ft and 90 KCAS, heading 90 deg. The aileron command is **set** to -0.15 (left)
for 5 s and then to 0, with the FDM block, which writes any property unchanged.

Expected: the roll angle reaches -57 deg in 5 s. With the aileron back at 0 it does not stay there:
it eases to -43 deg at 15 s and grows again to -60 deg at 28 s. In 30 s the aircraft turns left
through 286 deg and loses 808 ft.

Source: notebook 2 of the published JSBSim/PathSim notebooks, where this is titled a 10-degree turn.
It is not one, because no controller holds the bank; the diagram ``heading_hold`` has one.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope, StepSource

from pathsim_jsbsim_blocks import JSBSimFDM

DURATION = 30.0  # s

aileron = StepSource(amplitude=[-0.15, 0.0], tau=[0.0, 5.0])
fdm = JSBSimFDM(
    input_properties=["fcs/aileron-cmd-norm"],
    output_properties=[
        "attitude/phi-deg",
        "position/h-sl-ft",
        "attitude/psi-deg",
        "aero/alpha-deg",
        "aero/beta-deg",
        "position/lat-geod-deg",
        "position/long-gc-deg",
    ],
    aircraft_model="c172p",
    trim_airspeed=90.0,
    trim_altitude=5000.0,
    trim_heading=90.0,
)
scope = Scope(labels=["aileron command [-]", "roll angle [deg]", "altitude [ft]", "heading [deg]"])
flow = Scope(labels=["angle of attack [deg]", "sideslip angle [deg]"])
track = Scope(labels=["latitude [deg]", "longitude [deg]"])

sim = Simulation(
    [aileron, fdm, scope, flow, track],
    [
        Connection(aileron, fdm["fcs/aileron-cmd-norm"], scope[0]),
        Connection(fdm["attitude/phi-deg"], scope[1]),
        Connection(fdm["position/h-sl-ft"], scope[2]),
        Connection(fdm["attitude/psi-deg"], scope[3]),
        Connection(fdm["aero/alpha-deg"], flow[0]),
        Connection(fdm["aero/beta-deg"], flow[1]),
        Connection(fdm["position/lat-geod-deg"], track[0]),
        Connection(fdm["position/long-gc-deg"], track[1]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(scope, flow, title="c172p: aileron -0.15 for 5 s, not a 10-degree turn")


def figure_track():
    from pathsim_jsbsim_blocks.plots import ground_track

    time, (latitude, longitude) = track.read()
    return ground_track(time, latitude, longitude, title="c172p: aileron turn, ground track")


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    time, phi = signal(scope, "roll angle")
    _, altitude = signal(scope, "altitude")
    i = abs(time - 5.0).argmin()
    print(
        f"roll angle {phi[i]:.1f} deg after {time[i]:.4g} s, {phi[-1]:.1f} deg after "
        f"{sim.time:.4g} s; altitude lost {altitude[0] - altitude[-1]:.0f} ft"
    )
    show(figure(), "aileron_turn")
    show(figure_track(), "aileron_turn_track")
