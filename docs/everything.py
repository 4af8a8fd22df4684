"""Make every generated figure, table, notebook and picture of the documentation again.

    python docs/everything.py            all, in a day of two cores
    python docs/everything.py --quick    all but the flights of the evidence, in about an hour
    python docs/everything.py --list     the steps, and the time that each took
    python docs/everything.py NAME ...   some of them

Needs Chromium. Ends with the first step that fails. The times are kept in `docs/everything.json`.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

DOCS = Path(__file__).resolve().parent
TIMES = DOCS / "everything.json"

# name: command after `python`; FOLDER is a temporary one
QUICK = {
    "models": "docs/add_diagram.py --models",
    "concepts": "docs/figures.py",
    "pages": "docs/generate.py pages",
    "modes": "docs/generate.py modes",
    "accuracy": "docs/generate.py accuracy",
    "fleet": "docs/generate.py fleet",
    "diagrams": "docs/generate.py diagrams",
    "studies": "docs/generate.py studies",
    "first picture": "docs/hero.py",
    "evidence charts": "docs/evidence_charts.py",
    "pathview": "docs/screenshots.py",
    "drawing": "-m pytest -q tests/browser/test_drawing.py --screenshots docs/pictures",
    "notebooks": "docs/notebooks.py",
    "learning": "docs/learned_pitch_hold.py",
}
FLIGHTS = {
    "performance": "docs/performance_charts.py FOLDER",
    "steps": "docs/gain_tables.py --fly",
    "cruise": "docs/gain_tables.py --cruise",
    "airspeeds": "docs/gain_tables.py --airspeed",
    "turbulence": "docs/gain_tables.py --rough",
    "near the ground": "docs/gain_tables.py --slow",
    "random cases": "docs/monte_carlo.py",
    "landings": "docs/landings.py",
    "approaches in a crosswind": "docs/landings.py crosswind",
    "failed engines": "docs/failed_engines.py",
}
STEPS = {name: command.split() for name, command in (QUICK | FLIGHTS).items()}


def make(name):
    """Run one step from the root of the repository, and keep its time."""
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        command = [folder if word == "FOLDER" else word for word in STEPS[name]]
        subprocess.run([sys.executable, *command], cwd=DOCS.parent, check=True)
    minutes = round((time.monotonic() - start) / 60, 1)
    TIMES.write_text(json.dumps(times() | {name: minutes}, indent=2) + "\n", encoding="utf-8")
    print(f"{name}: {minutes} min", flush=True)


def times():
    return json.loads(TIMES.read_text(encoding="utf-8")) if TIMES.exists() else {}


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(STEPS))
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    if unknown := {*options.names} - {*STEPS}:
        parser.error(f"no step {', '.join(unknown)}; the steps are {', '.join(STEPS)}")
    for name in options.names or (QUICK if options.quick else STEPS):
        if options.list:
            print(f"{name}: {times().get(name, '?')} min: python {' '.join(STEPS[name])}")
        else:
            make(name)


if __name__ == "__main__":
    main()
