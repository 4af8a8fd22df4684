"""Wind axes to body axes and back, checked in flight against JSBSim's own forces.

A Cessna 172 at 5000 ft and 90 KCAS. An elevator doublet moves the angle of attack, a rudder doublet
the sideslip angle. Drag, side force and lift are turned with alpha and beta to the body axes, and
the result is turned back; six differences compare both with JSBSim's own values.

Expected: alpha from -2.0 to 4.4 deg, beta from -9.0 to 5.5 deg and lift from 540 to 3230 lbf; all
six differences stay below 1e-11 lbf: only rounding is left.

Source: JSBSim Reference Manual, Concepts, Frames of Reference.
"""

from pathsim import Connection, Simulation
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

sim = Simulation(
    [
        elevator,
        rudder,
        fdm,
        to_body,
        to_wind,
        x_error,
        y_error,
        z_error,
        drag_error,
        side_error,
        lift_error,
        angles,
        wind,
        body,
        errors,
    ],
    [
        Connection(elevator, fdm["fcs/elevator-cmd-norm"]),
        Connection(rudder, fdm["fcs/rudder-cmd-norm"]),
        Connection(fdm["aero/alpha-deg"], to_body["alpha"], to_wind["alpha"], angles[0]),
        Connection(fdm["aero/beta-deg"], to_body["beta"], to_wind["beta"], angles[1]),
        Connection(fdm["forces/fwx-aero-lbs"], to_body["drag"], drag_error[1], wind[0]),
        Connection(fdm["forces/fwy-aero-lbs"], to_body["side"], side_error[1], wind[1]),
        Connection(fdm["forces/fwz-aero-lbs"], to_body["lift"], lift_error[1], wind[2]),
        Connection(to_body["x"], to_wind["x"], x_error[0], body[0]),
        Connection(to_body["y"], to_wind["y"], y_error[0], body[1]),
        Connection(to_body["z"], to_wind["z"], z_error[0], body[2]),
        Connection(fdm["forces/fbx-aero-lbs"], x_error[1]),
        Connection(fdm["forces/fby-aero-lbs"], y_error[1]),
        Connection(fdm["forces/fbz-aero-lbs"], z_error[1]),
        Connection(to_wind["drag"], drag_error[0]),
        Connection(to_wind["side"], side_error[0]),
        Connection(to_wind["lift"], lift_error[0]),
        Connection(x_error, errors[0]),
        Connection(y_error, errors[1]),
        Connection(z_error, errors[2]),
        Connection(drag_error, errors[3]),
        Connection(side_error, errors[4]),
        Connection(lift_error, errors[5]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    drawing = time_histories(
        angles, wind, body, errors, title="c172p: aerodynamic force in wind and body axes"
    )
    for panel, place in zip(drawing.axes[1:3], ("upper right", "lower right"), strict=True):
        panel.legend(ncols=3, loc=place, fontsize="small")
    noise = drawing.axes[-1]
    for curve in noise.lines:
        curve.set_ydata(abs(curve.get_ydata()))
        curve.set(linestyle="none", marker=".", markersize=2)
    noise.set(yscale="log", ylim=(1e-17, 1e-9), ylabel="|difference| [lbf]")
    noise.axhline(1e-11, color="k", linestyle=":", label="bound")
    noise.legend(ncols=7, loc="upper right", fontsize="small", markerscale=4)
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
