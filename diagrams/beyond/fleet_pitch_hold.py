"""One pitch hold, six aircraft: 5 deg up, from a Cessna 172 to a Boeing 747.

Each aircraft is trimmed in level flight: a light aircraft, three airliners, a business jet and a
supersonic trainer. ``PitchHold`` raises the nose of each by 5 deg at 1 s; the throttles stay at
their trim settings. The gain tables have the aircraft's names: three are tuned by hand, three
designed from linear models.

Expected: each is within 0.5 deg after 1.9 s (c172p) to 3.1 s (A320), with an overshoot of at most
3.4 %, and within 0.1 deg at the end.

Source: our own.
"""

from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Scope, StepSource

from pathsim_jsbsim_blocks import Aircraft, PitchHold

DURATION = 15.0  # s
STEP = 5.0  # deg
START = 1.0  # s

c172p = Aircraft(aircraft="c172p", altitude=5000.0, speed=90.0)
b737 = Aircraft(aircraft="737", altitude=10000.0, speed=280.0, gear=0.0)
global5000 = Aircraft(aircraft="global5000", altitude=15000.0, speed=250.0, gear=0.0)
a320 = Aircraft(aircraft="A320", altitude=5000.0, speed=281.0, gear=0.0)
b747 = Aircraft(aircraft="B747", altitude=5000.0, speed=268.0, gear=0.0)
t38 = Aircraft(aircraft="T38", altitude=5000.0, speed=223.0, gear=0.0)
hold_c172p = PitchHold(gains="c172p")
hold_b737 = PitchHold(gains="737")
hold_global5000 = PitchHold(gains="global5000")
hold_a320 = PitchHold(gains="A320")
hold_b747 = PitchHold(gains="B747")
hold_t38 = PitchHold(gains="T38")
step = StepSource(amplitude=STEP, tau=START)
pitch = Scope(
    labels=[
        "c172p [deg]",
        "737 [deg]",
        "global5000 [deg]",
        "A320 [deg]",
        "B747 [deg]",
        "T38 [deg]",
    ]
)
elevator = Scope(
    labels=[
        "elevator of c172p [-]",
        "elevator of 737 [-]",
        "elevator of global5000 [-]",
        "elevator of A320 [-]",
        "elevator of B747 [-]",
        "elevator of T38 [-]",
    ]
)


def loop(plane, hold):
    """A plane with its hold: the commanded step in, pitch angle and elevator out."""
    ports = Interface()
    ports.register_port_map({"theta": 0, "elevator": 1}, {"theta_ref": 0})
    return Subsystem(
        [ports, plane, hold],
        [
            Connection(ports["theta_ref"], hold["theta_ref"]),
            Connection(plane["theta", "q", "elev_sat"], hold["theta", "q", "elev_sat"]),
            Connection(plane["theta"], ports["theta"]),
            Connection(hold["elevator"], plane["elevator"], ports["elevator"]),
        ],
    )


loop_c172p = loop(c172p, hold_c172p)
loop_b737 = loop(b737, hold_b737)
loop_global5000 = loop(global5000, hold_global5000)
loop_a320 = loop(a320, hold_a320)
loop_b747 = loop(b747, hold_b747)
loop_t38 = loop(t38, hold_t38)

sim = Simulation(
    [
        step,
        loop_c172p,
        loop_b737,
        loop_global5000,
        loop_a320,
        loop_b747,
        loop_t38,
        pitch,
        elevator,
    ],
    [
        Connection(
            step,
            loop_c172p,
            loop_b737,
            loop_global5000,
            loop_a320,
            loop_b747,
            loop_t38,
        ),
        Connection(loop_c172p["theta"], pitch[0]),
        Connection(loop_c172p["elevator"], elevator[0]),
        Connection(loop_b737["theta"], pitch[1]),
        Connection(loop_b737["elevator"], elevator[1]),
        Connection(loop_global5000["theta"], pitch[2]),
        Connection(loop_global5000["elevator"], elevator[2]),
        Connection(loop_a320["theta"], pitch[3]),
        Connection(loop_a320["elevator"], elevator[3]),
        Connection(loop_b747["theta"], pitch[4]),
        Connection(loop_b747["elevator"], elevator[4]),
        Connection(loop_t38["theta"], pitch[5]),
        Connection(loop_t38["elevator"], elevator[5]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import subplots

    time, pitches = pitch.read()
    _, elevators = elevator.read()
    drawing, (top, bottom) = subplots(2, 1, sharex=True, layout="constrained", figsize=(9, 7))
    for label, theta, u in zip(pitch.labels, pitches, elevators, strict=True):
        top.plot(time, theta - theta[0], label=label.split()[0])
        bottom.plot(time, u)
    top.axhspan(STEP - 0.5, STEP + 0.5, color="0.9")
    top.set_ylabel("pitch angle above the trim [deg]")
    top.legend(loc="lower right", fontsize="small", ncols=2)
    bottom.set_ylabel("elevator increment [-]")
    bottom.set_xlabel("time [s]")
    for ax in (top, bottom):
        ax.grid(alpha=0.4)
    drawing.suptitle("six aircraft: 5 deg of pitch")
    return drawing


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import settling, show

    sim.run(DURATION)
    time, pitches = pitch.read()
    for label, theta in zip(pitch.labels, pitches, strict=True):
        raised = theta - theta[0]
        print(
            f"{label.split()[0]:>10}: {settling(time, raised, STEP, 0.5, 'deg', after=START)}, "
            f"at most {raised.max():.3f} deg, {raised[-1]:.3f} deg at the end"
        )
    show(figure(), "fleet_pitch_hold")
