"""Make the charts of the fleet, and the page docs/evidence/performance.md from them.

    python docs/performance_charts.py FOLDER [AIRCRAFT ...]

writes the table of each of these aircraft (default: all that trim) that is not yet there as CSV
into FOLDER, a PDF page of it into docs/evidence/performance, and its row of the evidence page; the
other rows stay. One core works; two in two folders take half the time. The page has the hours.
"""

import re
import statistics
import sys
import textwrap
import time
from pathlib import Path

import matplotlib
import pandas as pd

matplotlib.use("agg")

from matplotlib import pyplot as plt
from tables import DOCS, EVIDENCE, commit, measured, read_table, write_table

from pathsim_jsbsim_blocks.studies import performance_chart, performance_table
from pathsim_jsbsim_blocks.studies.figures import is_fault

# column: quantity and number format; the first altitude and the model's own weight count
COLUMNS = {
    "stall KCAS": ("stall speed", ".0f"),
    "highest KTAS": ("highest level speed", ".0f"),
    "climb ft/min": ("best rate of climb", ".0f"),
    "Vy KCAS": ("Vy", ".0f"),
    "service ceiling ft": ("service ceiling", ".0f"),
    "glide ratio": ("best glide ratio", ".1f"),
    "nmi/lb": ("best specific range", ".3f"),
    "turn g": ("sustained load factor", ".1f"),
    "gust g at VC": ("gust load factor at VC", ".1f"),
    "take-off ft": ("take-off distance", ".0f"),
    "landing ft": ("landing distance", ".0f"),
}

REASON = re.compile(r"\(([^)]*)\)")  # of a missing value

# the pictures of docs/performance.md, with the panels of each
FIGURES = {
    "speeds": ("stall", "V-n", "speeds", "turn"),
    "climb": ("climb", "ceiling", "glide", "field"),
    "level": ("power", "range"),
}

HEAD = """\
# The fleet's performance

{measured}

The charts of {count} of the {all} aircraft that trim, with default settings of
`pathsim-jsbsim chart` ([definitions](../performance.md)): values at sea level and the model's own
weight, flaps up.

![Climb, ceiling and glide ratio of the fleet](../pictures/evidence_fleet_performance.png)

Open circles are values whose search ended early. [All numbers](performance.csv): stall, highest
level speed, climb, ceiling, glide, range, the steepest sustained turn of six airspeeds, gusts,
take-off and landing; how many values of an aircraft were flown, the median and the largest of the
differences, and the processor time, which two cores share: `chart` takes half of it. Then come the
values that are missing, with their reasons; a star marks one whose search ended early for such a
reason. The last but one column counts the values that `chart` lists as
[faults](../performance.md#limits-of-a-chart).

{flown} values were flown. The median difference of an aircraft is at most {median:.2g} %, the
largest difference {largest:.0f} % ({farthest}). Two models have two steady glides at one
airspeed, of which a trim finds one and a flight the other: the engines of the c310 idle at 759 or
952 rpm at 96 KCAS, and the tables of the SGS end at an angle of attack of -1 deg (57 KCAS).
<!-- from tests/studies/test_performance.py -->

`python docs/performance_charts.py FOLDER` makes all pages and the table, in {hours:.1f} hours of
processor time. The charts of each aircraft on one page (PDF):

"""


def fleet():
    """Aircraft that trim, as the table of the fleet has it."""
    steady = ("trims", "glides")
    return [r["aircraft"] for r in read_table("fleet") if r["verdict"].startswith(steady)]


def make(name, folder):
    """The table of an aircraft, computed if it is not there, and its page, if it has values."""
    file, page = folder / f"{name}.csv", EVIDENCE / "performance" / f"{name}.pdf"
    if not file.exists():
        start = time.process_time()
        table = performance_table(name, jobs=1, progress=False)
        table = table.assign(seconds=time.process_time() - start, commit=commit())
        table.to_csv(file, index=False)
        page.unlink(missing_ok=True)
    table = pd.read_csv(file)
    table.attrs["aircraft"] = name
    if not page.exists() and any(pd.notna(value(table, q)[0]) for q, _ in COLUMNS.values()):
        figure = performance_chart(table.drop(columns=["seconds", "commit"]))
        # without a date the file depends on the table alone
        figure.savefig(page, metadata={"CreationDate": None})
        plt.close(figure)
    return table


def value(table, quantity):
    """The first value of a quantity at the model's own weight, and why there is none."""
    rows = table[table.quantity == quantity]
    if quantity == "stall speed":
        own = table.weight_lb[table.chart == "turn"].iloc[:1]
        rows = rows[rows.weight_lb.isin(own) & (rows.flaps_norm == 0.0)]
    if quantity == "sustained load factor" and rows.value.notna().any():
        return rows.value.max(), ""
    if rows.empty:
        failed = table.reason[table.quantity.str.startswith("all of ")]
        return float("nan"), failed.iloc[0] if len(failed) else "no trim there"
    return rows.value.iloc[0], rows.reason.iloc[0]


def table_row(name, table):
    """The row of an aircraft, as texts."""
    row, missing = {"aircraft": name}, []
    for column, (quantity, form) in COLUMNS.items():
        number, reason = value(table, quantity)
        early = quantity.endswith("ceiling") and not pd.isna(reason)
        row[column] = "" if pd.isna(number) else f"{number:{form}}{'*' * early}"
        if pd.isna(number) or early:
            missing.append(f"{quantity} ({reason})")
    differences = table.difference_percent.dropna().abs()
    return row | {
        "flown": f"{len(differences)}",
        "median": f"{differences.median():.2f} %" if len(differences) else "",
        "largest": f"{differences.max():.1f} %" if len(differences) else "",
        "time s": f"{table.seconds.iloc[0]:.0f}",
        "missing": ", ".join(missing),
        "faults": f"{is_fault(table).sum()}",
        "commit": table.commit.iloc[0],
    }


def write(tables):
    """Put the rows of these aircraft into the table; the other rows stay."""
    rows = {row["aircraft"]: row for row in read_table("performance")}
    rows |= {name: table_row(name, table) for name, table in tables.items()}
    write_table("performance", [rows[name] for name in fleet() if name in rows])


def page():
    """The page of the evidence: the table in words, and links."""
    made = pd.read_csv(EVIDENCE / "performance.csv")
    blank = made[made[[*COLUMNS]].isna().all(axis=1)].set_index("aircraft").missing
    made = made[~made.aircraft.isin(blank.index)]
    largest = pd.to_numeric(made["largest"].str.rstrip(" %"))
    head = HEAD.format(
        measured=measured("performance"),
        count=len(made),
        all=len(fleet()),
        flown=made.flown.sum(),
        median=pd.to_numeric(made["median"].str.rstrip(" %")).max(),
        largest=largest.max(),
        farthest=made.aircraft[largest.idxmax()],
        hours=pd.to_numeric(made["time s"]).sum() / 3600.0,
    )
    links = ", ".join(f"[{name}](performance/{name}.pdf)" for name in made.aircraft)
    later = [name for name in fleet() if name not in {*made.aircraft, *blank.index}]
    rest = f"\nNot made yet: {', '.join(later)}.\n" if later else ""
    causes = [f"{name} ({statistics.mode(REASON.findall(why))})" for name, why in blank.items()]
    rest += f"\nNo value: {', '.join(causes)}.\n"
    listed = textwrap.fill(links, 125, break_long_words=False, break_on_hyphens=False)
    return f"{head}{listed}.\n{rest}"


def main():
    folder, *names = sys.argv[1:]
    folder = Path(folder)
    folder.mkdir(exist_ok=True)
    for name in names or fleet():
        print(f"{name}: {make(name, folder).seconds.iloc[0]:.0f} s", flush=True)
    tables = {name: make(name, folder) for name in fleet() if (folder / f"{name}.csv").exists()}
    write(tables)
    (EVIDENCE / "performance.md").write_text(page(), encoding="utf-8")
    if "c172p" in tables:
        table = tables["c172p"].drop(columns=["seconds", "commit"])
        for name, charts in FIGURES.items():
            figure = performance_chart(table, charts=charts)
            figure.savefig(DOCS / "pictures" / f"performance_{name}.png", dpi=100)


if __name__ == "__main__":
    main()
