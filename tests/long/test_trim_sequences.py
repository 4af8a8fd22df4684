"""Random sequences of trims on one airframe: each ends in a finite state or a typed error.

Each batch runs in its own process, because JSBSim's faults end the process. Each call is written to
a file before it is made, so that a batch that dies names its last calls.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from how_many import bounded

TESTS = Path(__file__).parents[1]
SEEDS = range(bounded(1, 20))
SEQUENCES = 50  # of each seed, with up to 6 trims each

BATCH = """
import json, math, random, sys, time
from fleet_conditions import FLYING, NOT_FLYING
from pathsim_jsbsim_blocks import (
    AircraftError, ParameterError, PropertyError, TrimCondition, TrimError
)
from pathsim_jsbsim_blocks.flight import Airframe, has_retractable_gear
from pathsim_jsbsim_blocks.flight import trim
from pathsim_jsbsim_blocks.flight.trimming.state import not_finite

seed, sequences, modes, log, report = sys.argv[1:]
rng = random.Random(int(seed))
create = {name: dict.fromkeys(found[3], 0.0) for name, found in FLYING.items()}
create["dr1"] = create["fokker50"] = create["Pterosaur"] = create["fokker100"]
speeds = {name: found[1] for name, found in FLYING.items()}
names = sorted(set(FLYING) | set(NOT_FLYING) - {"blank"})

def condition(name):
    mode = rng.choice(modes.split(","))
    speed = speeds.get(name, 100.0)
    said = {"mode": mode, "heading": rng.choice([0.0, rng.uniform(0.0, 360.0)]),
            "altitude": rng.choice([0.0, rng.uniform(-1500.0, 60.0), rng.uniform(0.0, 15000.0),
                                    rng.uniform(0.0, 15000.0), 10.0 ** rng.uniform(3.0, 5.44)])}
    if rng.random() < 0.1:
        said["mach"] = 10.0 ** rng.uniform(-2.0, 1.47)
    else:
        said["speed"] = min(2000.0, rng.choice([rng.uniform(0.3, 2.0), rng.uniform(0.7, 1.4),
                                                10.0 ** rng.uniform(-2.0, 1.5)]) * speed)
    if mode != "ground":
        said["gamma"] = rng.choice([0.0, rng.uniform(-10.0, 10.0), rng.uniform(-90.0, 90.0)])
    if mode == "turn":
        said["bank"] = rng.uniform(-80.0, 80.0)
    if mode == "pull-up":
        said["load_factor"] = rng.uniform(-2.0, 5.0)
    if mode == "glide" or (mode not in ("ground", "none") and rng.random() < 0.5):
        said["solver"] = "newton"
        if mode in ("full", "glide") and rng.random() < 0.3:
            said["beta"] = rng.uniform(-30.0, 30.0)
        if mode != "glide" and rng.random() < 0.3:
            said |= {"throttle": rng.random(), "free": rng.choice(["gamma", "speed"])}
    if rng.random() < 0.1 and said.get("solver", "newton") == "newton":
        said["engines_off"] = rng.choice(["all", [0]])
    if rng.random() < 0.2:
        said["flaps"] = rng.random()
    if rng.random() < 0.3:
        said["fuel"] = {0: rng.uniform(0.0, 100.0)}
    if rng.random() < 0.2:
        said["payload"] = {0: rng.uniform(0.0, 300.0)}
    if rng.random() < 0.3:
        said |= {"wind_north": rng.uniform(-100.0, 100.0), "wind_east": rng.uniform(-100.0, 100.0)}
    if rng.random() < 0.3:
        said["gear"] = rng.choice([0.0, 1.0, rng.random()])
    if rng.random() < 0.2:
        said |= {"alpha_min": rng.uniform(-20.0, 0.0), "alpha_max": rng.uniform(0.1, 40.0)}
    return said

counts = {"trims": 0, "found": 0, "by Newton": 0, "TrimError": 0, "AircraftError": 0,
          "refused": 0, "slowest": 0.0}
with open(log, "w", buffering=1) as log:
    for sequence in range(int(sequences)):
        name = rng.choice(names)
        try:
            airframe = Airframe(name, create=create.get(name))
        except AircraftError:
            continue
        for _ in range(rng.randint(1, 6)):
            said = condition(name)
            steps = rng.choice([0, 0, 1, 200])
            print(json.dumps([sequence, name, said, steps]), file=log)
            start = time.process_time()
            counts["trims"] += 1
            try:
                state = trim(airframe, TrimCondition(**said))
                assert not_finite(state) == [], (name, said)
                if "solver" in said:  # what `trim` promises, in ft/s2 and rad/s2
                    counts["by Newton"] += 1
                    # what JSBSim itself says, in the state in which the search has left it; in a
                    # turn or pull-up in wind the velocity over the ground turns
                    limits = {"uvw": 1e-4, "pqr": 1e-5}
                    if said["mode"] == "longitudinal":
                        limits = {"uw": 1e-4, "q": 1e-5}
                    turns = said["mode"] in ("turn", "pull-up") and "wind_north" in said
                    for axis, most in ((a, x) for axes, x in limits.items() for a in axes):
                        unit = "ft_sec2" if axis in "uvw" else "rad_sec2"
                        now = airframe.fdm[f"accelerations/{axis}dot-{unit}"]
                        assert abs(getattr(state, f"{axis}dot")) <= most, (name, said)
                        assert turns or abs(now) <= most, (name, said)
                counts["found"] += 1
            except (PropertyError, ParameterError):
                # this aircraft has no such tank, point mass or engine
                counts["refused"] += 1
                steps = 0
            except (TrimError, AircraftError) as error:
                counts[type(error).__name__] += 1
                if isinstance(error, AircraftError):  # a model that misses a property cannot fly
                    steps = 0
            counts["slowest"] = max(counts["slowest"], time.process_time() - start)
            print(time.process_time() - start, file=log)
            for _ in range(steps):
                airframe.fdm.run()
json.dump(counts, open(report, "w"))
"""


def batch(folder, seed, sequences, modes):
    log, report = folder / "log.txt", folder / "report.json"
    path = os.pathsep.join([str(TESTS), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-c", BATCH, str(seed), str(sequences), modes, str(log), str(report)],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, (
        done.returncode,
        done.stderr[-2000:],
        log.read_text().splitlines()[-12:],
    )
    return json.loads(report.read_text())


@pytest.mark.long
@pytest.mark.parametrize(
    "modes", ["full,longitudinal,ground,pull-up,turn,glide,none", "ground,none"]
)
@pytest.mark.parametrize("seed", SEEDS)
def test_no_sequence_of_trims_ends_the_process(tmp_path, seed, modes):
    counts = batch(tmp_path, seed, SEQUENCES, modes)
    print(f"seed {seed}, {modes}: {counts}")
    assert counts["trims"] > SEQUENCES
    assert counts["found"] > 0
    assert counts["by Newton"] > 0 or "glide" not in modes
