"""Wind axes to body axes and back, checked in flight against JSBSim's own forces.

A Cessna 172 at 5000 ft and 90 KCAS. An elevator doublet moves the angle of attack, a rudder doublet
the sideslip angle. Drag, side force and lift are transformed with alpha and beta to body axes and
back; six differences compare both with JSBSim's own values.

Expected: alpha from -2.0 to 4.4 deg, beta from -9.0 to 5.5 deg and lift from 540 to 3230 lbf; all
six differences stay below 1e-11 lbf, the level of rounding.

Source: JSBSim Reference Manual, Concepts, Frames of Reference.
"""

from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Adder, Scope

from pathsim_jsbsim_blocks import BodyToWind, DoubletSource, JSBSimFDM, WindToBody

DURATION = 15.0  # s

elevator = DoubletSource(amplitude=0.2, start=1.0, width=1.0, polarity=-1)
rudder = DoubletSource(amplitude=0.3, start=5.0, width=1.5)
fdm = JSBSimFDM(
    T=1 / 120,
    input_properties=["fcs/elevator-cmd-norm", "fcs/rudder-cmd-norm"],
    output_properties=[
        "aero/alpha-deg",
        "aero/beta-deg",
        "forces/fwx-aero-lbs",
        "forces/fwy-aero-lbs",
        "forces/fwz-aero-lbs",
        "forces/fbx-aero-lbs",
        "forces/fby-aero-lbs",
        "forces/fbz-aero-lbs",
    ],
    aircraft_model="c172p",
    trim_airspeed=90,
    trim_altitude=5000,
)
to_body = WindToBody()
to_wind = BodyToWind()
x_error = Adder("+-")
y_error = Adder("+-")
z_error = Adder("+-")
drag_error = Adder("+-")
side_error = Adder("+-")
lift_error = Adder("+-")
angles = Scope(labels=["angle of attack [deg]", "sideslip angle [deg]"])
wind = Scope(labels=["drag [lbf]", "side force [lbf]", "lift [lbf]"])
body = Scope(labels=["x, forward [lbf]", "y, right [lbf]", "z, down [lbf]"])
errors = Scope(
    labels=["x [lbf]", "y [lbf]", "z [lbf]", "drag [lbf]", "side force [lbf]", "lift [lbf]"]
)

WIND = ["drag", "side", "lift"]
BODY = ["x", "y", "z"]
ports = Interface()
ports.register_port_map(
    {name: i for i, name in enumerate([*BODY, "dx", "dy", "dz", "ddrag", "dside", "dlift"])},
    {name: i for i, name in enumerate(["alpha", "beta", *WIND, *BODY])},
)
there_and_back = Subsystem(
    [
        ports,
        to_body,
        to_wind,
        x_error,
        y_error,
        z_error,
        drag_error,
        side_error,
        lift_error,
    ],
    [
        Connection(ports["alpha", "beta"], to_body["alpha", "beta"], to_wind["alpha", "beta"]),
        Connection(ports[WIND], to_body[WIND]),
        Connection(to_body[BODY], to_wind[BODY], ports[BODY]),
        Connection(to_body["x"], x_error[0]),
        Connection(to_body["y"], y_error[0]),
        Connection(to_body["z"], z_error[0]),
        Connection(ports["x"], x_error[1]),
        Connection(ports["y"], y_error[1]),
        Connection(ports["z"], z_error[1]),
        Connection(to_wind["drag"], drag_error[0]),
        Connection(to_wind["side"], side_error[0]),
        Connection(to_wind["lift"], lift_error[0]),
        Connection(ports["drag"], drag_error[1]),
        Connection(ports["side"], side_error[1]),
        Connection(ports["lift"], lift_error[1]),
        Connection(x_error, ports["dx"]),
        Connection(y_error, ports["dy"]),
        Connection(z_error, ports["dz"]),
        Connection(drag_error, ports["ddrag"]),
        Connection(side_error, ports["dside"]),
        Connection(lift_error, ports["dlift"]),
    ],
)

sim = Simulation(
    [elevator, rudder, fdm, there_and_back, angles, wind, body, errors],
    [
        Connection(elevator, fdm["fcs/elevator-cmd-norm"]),
        Connection(rudder, fdm["fcs/rudder-cmd-norm"]),
        Connection(fdm[0:8], there_and_back[0:8]),
        Connection(fdm[0:2], angles[0:2]),
        Connection(fdm[2:5], wind[0:3]),
        Connection(there_and_back[BODY], body[0:3]),
        Connection(there_and_back[3:9], errors[0:6]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    drawing = time_histories(
        angles, wind, body, title="c172p: aerodynamic force in wind and body axes"
    )
    for panel, place in zip(drawing.axes[1:3], ("upper right", "lower right"), strict=True):
        panel.legend(ncols=3, loc=place, fontsize="small")
    return drawing


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    _, alpha = signal(angles, "angle of attack")
    _, beta = signal(angles, "sideslip angle")
    _, lift = signal(wind, "lift")
    _, differences = errors.read()
    print(
        f"alpha from {alpha.min():.2f} to {alpha.max():.2f} deg, "
        f"beta from {beta.min():.2f} to {beta.max():.2f} deg, "
        f"lift from {lift.min():.0f} to {lift.max():.0f} lbf"
    )
    print(
        f"largest difference from JSBSim's forces, there and back: {abs(differences).max():.1e} lbf"
    )
    show(figure(), "wind_to_body")
