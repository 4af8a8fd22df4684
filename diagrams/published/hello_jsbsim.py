"""Hello, JSBSim: a Cessna 172 trimmed at 3000 ft and 80 KCAS, heading 45 deg, flown for 1 s.

The controls stay at their trim settings: the inputs of the aircraft block are increments on the
trimmed commands, and they are unconnected. Expected: throttle 62.157 %, pitch trim 5.2799 %, alpha
2.53 deg, and after 1 s still 3000 ft.

Source: notebook 1 of the published JSBSim/PathSim notebooks, its "hello world"; the numbers are
those of a plain JSBSim loop.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft

DURATION = 1.0  # s

aircraft = Aircraft(aircraft="c172p", altitude=3000.0, speed=80.0, heading=45.0, solver="jsbsim")
scope = Scope(
    labels=[
        "altitude [ft]",
        "pitch angle [deg]",
        "roll angle [deg]",
        "true airspeed [ft/s]",
        "heading [deg]",
    ]
)

sim = Simulation(
    [aircraft, scope],
    [
        Connection(aircraft["h"], scope[0]),
        Connection(aircraft["theta"], scope[1]),
        Connection(aircraft["phi"], scope[2]),
        Connection(aircraft["vt"], scope[3]),
        Connection(aircraft["psi"], scope[4]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(scope, title="c172p, trimmed: 1 s of level flight")


if __name__ == "__main__":
    from importlib.metadata import version

    from pathsim_jsbsim_blocks.plots import show

    print(f"JSBSim {version('jsbsim')}, PathSim {version('pathsim')}, {aircraft.T:.6f} s a step")
    print(f"throttle    {100 * aircraft.trim.throttle[0]:8.3f} %")
    print(f"pitch trim  {100 * aircraft.trim.pitch_trim:8.4f} %")
    print(f"alpha       {aircraft.trim.alpha:8.2f} deg")
    print(f"roll angle  {aircraft.outputs['phi']:8.2f} deg")
    print(f"airspeed    {aircraft.outputs['vt'] * 3600 * 0.3048 / 1852:8.2f} KTAS")
    sim.run(DURATION)
    print(
        f"after {sim.time:.3g} s: altitude {aircraft.outputs['h']:.4f} ft, "
        f"pitch {aircraft.outputs['theta']:.4f} deg, heading {aircraft.outputs['psi']:.4f} deg"
    )
    show(figure(), "hello_jsbsim")
