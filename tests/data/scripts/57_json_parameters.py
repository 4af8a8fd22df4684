import json
from pathlib import Path
from pathsim import Connection, Simulation
from pathsim.blocks import PID, Adder, LUT1D, Scope, StepSource, TransferFunctionNumDen

P = json.loads(
    '{"pid": {"Kp": 3.0, "Ki": 0.8, "Kd": 0.02}, "plant": {"num": [1.0], "den": [1, 2, 2]}, "dt": 0.01}'
)
folder = Path(__file__).resolve().parent
rows = [
    tuple(map(float, line.split(",")))
    for line in (folder / "profile.csv").read_text().splitlines()[1:]
]
t, y = zip(*rows)
limits = LUT1D(points=t, values=y)
r, e, c = StepSource(1.0, 0.5), Adder("+-"), PID(**P["pid"], f_max=50)
p, sc = (
    TransferFunctionNumDen(P["plant"]["num"], P["plant"]["den"]),
    Scope(labels=["y", "u", "lim"]),
)
sim = Simulation(
    [r, e, c, p, limits, sc],
    [
        Connection(r, e[0]),
        Connection(e, c),
        Connection(c, p, sc[1]),
        Connection(p, e[1], limits, sc[0]),
        Connection(limits, sc[2]),
    ],
    dt=P["dt"],
    log=False,
)
if __name__ == "__main__":
    sim.run(5)
