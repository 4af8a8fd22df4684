from pathsim import Connection, Simulation
from pathsim.blocks import Amplifier, Constant, Integrator, Scope
from pathsim.events import Condition

B = {"rate": Constant(1.0), "level": Integrator(0.0), "gain": Amplifier(3.0), "scope": Scope()}
state = {"phase": "fill", "times": []}


def full(t):
    return B["level"].engine.state > 1.0 and state["phase"] == "fill"


def drain(t):
    state["phase"] = "drain"
    state["times"].append(t)
    B["rate"].value = -0.5


sim = Simulation(
    list(B.values()),
    [
        Connection(B["rate"], B["level"]),
        Connection(B["level"], B["gain"], B["scope"][0]),
        Connection(B["gain"], B["scope"][1]),
    ],
    [Condition(full, drain)],
    dt=0.01,
    log=False,
)
sim.run(2)
