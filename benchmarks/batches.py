"""Batches of flights: `run_batch` on one and two workers, against joblib and Dask used directly.

    python benchmarks/batches.py                    the rows of the table
    python benchmarks/batches.py 100 1000 10000     batches of these sizes, into batches.json

A flight loads and trims a c172p and flies it for 20 s at 120 Hz in turbulence under `PitchHold`.
The peers run the same function: a plain loop, ``joblib.Parallel``, ``Client.map`` on the same
LocalCluster. All are timed in turn, with workers that have imported everything; their start is a
row of its own. Processor time is that of this process and its workers together: it hardly depends
on what else the machine does, while the wall time of two workers needs two quiet cores.
"""

import gc
import json
import logging
import platform
import sys
import tempfile
import time
from datetime import date
from importlib.metadata import version
from pathlib import Path

import joblib
import numpy as np
import psutil
from distributed import Client, LocalCluster
from pathsim import Connection, Simulation
from pathsim.blocks import Scope
from report import HEADER, processor_name, row
from trim_sweep import stop_workers

from pathsim_jsbsim_blocks import Aircraft, PitchHold, fly
from pathsim_jsbsim_blocks.studies import run_batch

RUNS = 24
REPETITIONS = 5
SECONDS = 20.0
WORKERS = 2
MEASURED = Path(__file__).with_name("batches.json")


def flight(Kp, seed):
    plane = Aircraft(
        "c172p",
        altitude=5000,
        speed=90,
        setup={"simulation/randomseed": seed},
        properties={"atmosphere/turb-type": 3, "atmosphere/turbulence/milspec/severity": 3},
    )
    hold = PitchHold(gains={"Kp": Kp, "Ki": 0.063, "Kr": 0.0025, "b": 0.52, "ramp": 3.0})
    scope = Scope()
    sim = Simulation(
        [plane, hold, scope],
        [
            Connection(plane["theta"], hold["theta"], scope),
            Connection(plane["q"], hold["q"]),
            Connection(hold["elevator"], plane["elevator"]),
            Connection(plane["elev_sat"], hold["elev_sat"]),
        ],
        dt=plane.T,
        log=False,
    )
    fly(sim, SECONDS)
    _, (theta,) = scope.read()
    return {"theta_std_deg": float(np.std(theta))}


def cases(count):
    return [{"Kp": 0.032 + 0.032 * i / count, "seed": i} for i in range(count)]


def batch(count, jobs=1, resume=None):
    table = run_batch(flight, cases(count), jobs=jobs, resume=resume, progress=False)
    assert table.completed.all()
    return table.theta_std_deg.tolist()


def batch_on_dask(count):
    with joblib.parallel_config("dask"):
        return batch(count)


def loop(count):
    return [flight(**case)["theta_std_deg"] for case in cases(count)]


def parallel(count):
    work = (joblib.delayed(flight)(**case) for case in cases(count))
    return [r["theta_std_deg"] for r in joblib.Parallel(WORKERS, batch_size=1)(work)]


def dask_map(count, client):
    def one(case):
        return flight(**case)

    return [r["theta_std_deg"] for r in client.gather(client.map(one, cases(count), pure=False))]


def worker_processes():
    """The workers that run; those of loky and Dask have large memory, their helpers small."""
    return [p for p in psutil.Process().children(recursive=True) if own_memory(p) > 30.0]


def own_memory(process):
    """Memory in MB that no other process shares."""
    return process.memory_full_info().uss / 2**20


def processor_time():
    """Seconds of this process and those that it started and that still run."""
    clocks = [p.cpu_times() for p in (psutil.Process(), *psutil.Process().children(recursive=True))]
    return sum(c.user + c.system for c in clocks)


def timed(function, *arguments):
    """Wall and processor time of a call in s, and what it returned."""
    gc.collect()
    wall, processor = time.perf_counter(), processor_time()
    found = function(*arguments)
    return time.perf_counter() - wall, processor_time() - processor, found


def warm(function, count, *arguments):
    """The same for a batch whose workers have started."""
    function(WORKERS, *arguments)
    return timed(function, count, *arguments)


def start_of_workers():
    """Wall and processor time in s that a batch takes longer if its workers must start first."""
    stop_workers()
    cold, again = timed(batch, WORKERS, WORKERS), timed(batch, WORKERS, WORKERS)
    return cold[0] - again[0], cold[1] - again[1]


def dask_client():
    return Client(
        LocalCluster(
            n_workers=WORKERS,
            threads_per_worker=1,
            dashboard_address=None,
            silence_logs=logging.ERROR,  # that a worker took some seconds to end
        )
    )


def start_of_dask():
    """The wall time with a LocalCluster."""
    start = time.perf_counter()
    with dask_client() as client, client.cluster:
        batch_on_dask(WORKERS)
        cold = time.perf_counter() - start
        return cold - timed(batch_on_dask, WORKERS)[0]


def rows():
    starts = [(start_of_workers()[0], start_of_dask()) for _ in range(REPETITIONS)]
    times = []
    for _ in range(REPETITIONS):
        times.append(
            {
                "loop": warm(loop, RUNS),
                "one": warm(batch, RUNS),
                # each has its own workers: joblib ends those of the other
                "joblib": warm(parallel, RUNS),
                "two": warm(batch, RUNS, WORKERS),
            }
        )
    memory = max(own_memory(p) for p in worker_processes())
    stop_workers()
    with dask_client() as client, client.cluster:
        for way in times:
            way["dask"] = warm(batch_on_dask, RUNS)
            way["map"] = warm(dask_map, RUNS, client)
    assert len({tuple(found) for way in times for _, _, found in way.values()}) == 1

    def wall(name):
        return [t[name][0] / RUNS for t in times]

    def processor(name):
        return [t[name][1] / RUNS for t in times]

    flights = f"{SECONDS:.0f} s flight of a batch"
    row(f"{flights}, one worker", "plain loop", wall("one"), wall("loop"), "ms", 1.05)
    row(f"{flights}, two workers", "one worker", wall("two"), wall("one"), "ms", 1 / 1.9)
    row("the same, processor time", "one worker", processor("two"), processor("one"), "ms", 1.1)
    row(
        f"{flights}, two workers",
        "joblib.Parallel",
        wall("two"),
        wall("joblib"),
        "ms",
        1.05,
        "joblib",
    )
    row(f"{flights}, Dask", "Client.map", wall("dask"), wall("map"), "ms", 1.05, "dask")
    row("start of two workers", "LocalCluster", *zip(*starts, strict=True), "s", package="dask")
    print(f"{'':<46} {memory:.0f} MB of its own for a worker")


def measure(sizes):
    """Time batches of each size, their finished cases kept in a journal, and write the results."""
    _, start = start_of_workers()
    batches = []
    for size in sizes:
        with tempfile.TemporaryDirectory() as folder:
            journal = Path(folder, "batch.jsonl")
            wall, processor, _ = timed(batch, size, WORKERS, journal)
            batches.append(
                {
                    "runs": size,
                    "wall_s": round(wall, 2),
                    "processor_s": round(processor, 2),
                    "journal_MB": round(journal.stat().st_size / 1e6, 3),
                    "parent_MB": round(own_memory(psutil.Process())),
                }
            )
        print(batches[-1], flush=True)
    results = {
        "date": date.today().isoformat(),
        "processor": processor_name(),
        "python": platform.python_version(),
        **{name: version(name) for name in ("jsbsim", "pathsim", "joblib")},
        "workers": WORKERS,
        "start_s": round(start / WORKERS, 2),  # processor time of one
        "worker_MB": round(max(own_memory(p) for p in worker_processes())),
        "batches": batches,
    }
    MEASURED.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        measure([int(size) for size in sys.argv[1:]])
    else:
        print(HEADER)
        rows()
