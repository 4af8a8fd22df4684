"""Dutch roll of a 737 with the gain of its yaw damper at 0, 1 and 2.

Three 737s at 5000 ft and 260 KCAS, gear up, get the same rudder pulse, 0.1 from 1 s to 1.5 s. The
model's own damper deflects the rudder in proportion to the yaw rate: 0.0175 of travel for 1 deg/s.
An external gain cancels this damper in one aircraft and doubles it in another.

Expected: the damping ratio is 0.16 without a damper, 0.37 as the model is built, 0.58 with twice
the gain, and the natural frequency stays at 2.0 rad/s. The linear model of the diagram
(``sim.to_statespace``) has the same three pairs of poles.

Source: our own, on the 737 of JSBSim.
"""

from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Adder, Amplifier, Scope, StepSource

from pathsim_jsbsim_blocks import Aircraft

DURATION = 15.0  # s

pulse = StepSource(amplitude=[0.1, 0.0], tau=[1.0, 1.5])
without = Aircraft(aircraft="737", altitude=5000.0, speed=260.0, gear=0.0)
built_in = Aircraft(aircraft="737", altitude=5000.0, speed=260.0, gear=0.0)
doubled = Aircraft(aircraft="737", altitude=5000.0, speed=260.0, gear=0.0)
less = Amplifier(gain=-0.01745)
more = Amplifier(gain=0.01745)
rudder_less = Adder("++")
rudder_more = Adder("++")
slip = Scope(
    labels=[
        "sideslip angle, gain 0 [deg]",
        "sideslip angle, gain 1 [deg]",
        "sideslip angle, gain 2 [deg]",
    ]
)
yaw = Scope(
    labels=["yaw rate, gain 0 [deg/s]", "yaw rate, gain 1 [deg/s]", "yaw rate, gain 2 [deg/s]"]
)
roll = Scope(
    labels=["roll angle, gain 0 [deg]", "roll angle, gain 1 [deg]", "roll angle, gain 2 [deg]"]
)


def with_feedback(plane, gain, rudder):
    """A plane whose yaw rate moves the rudder beside the pulse."""
    ports = Interface()
    ports.register_port_map({"beta": 0, "r": 1, "phi": 2}, {"pulse": 0})
    return Subsystem(
        [ports, plane, gain, rudder],
        [
            Connection(ports["pulse"], rudder[0]),
            Connection(plane["r"], gain),
            Connection(gain, rudder[1]),
            Connection(rudder, plane["rudder"]),
            Connection(plane["beta", "r", "phi"], ports["beta", "r", "phi"]),
        ],
    )


gain_0 = with_feedback(without, less, rudder_less)
gain_2 = with_feedback(doubled, more, rudder_more)

sim = Simulation(
    [pulse, gain_0, built_in, gain_2, slip, yaw, roll],
    [
        Connection(pulse, gain_0["pulse"], built_in["rudder"], gain_2["pulse"]),
        Connection(gain_0["beta"], slip[0]),
        Connection(gain_0["r"], yaw[0]),
        Connection(gain_0["phi"], roll[0]),
        Connection(built_in["beta"], slip[1]),
        Connection(built_in["r"], yaw[1]),
        Connection(built_in["phi"], roll[1]),
        Connection(gain_2["beta"], slip[2]),
        Connection(gain_2["r"], yaw[2]),
        Connection(gain_2["phi"], roll[2]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(
        slip, yaw, roll, title="737: rudder pulse, gain of the yaw damper at 0, 1 and 2"
    )


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    for gain in (0, 1, 2):
        time, beta = signal(slip, f"sideslip angle, gain {gain}")
        start = min(5.0, time[-1] / 2)
        late = time > start
        print(
            f"gain {gain}: sideslip up to {abs(beta).max():.2f} deg, after {start:.4g} s "
            f"{abs(beta[late] - beta[-1]).max():.3f} deg from its last value at most"
        )
    show(figure(), "dutch_roll")
