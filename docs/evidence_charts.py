"""Draw the charts of the evidence pages from the tables (CSV) beside them.

python docs/evidence_charts.py
python docs/evidence_charts.py NAME ...    some of them
"""

import re
import sys

import matplotlib.pyplot as plt
import pandas as pd
from generate import save
from tables import EVIDENCE


def read(name):
    """A table as text, by aircraft."""
    return pd.read_csv(EVIDENCE / f"{name}.csv", dtype=str, keep_default_na=False, index_col=0)


def rows(table, columns):
    """A panel for each column, with a line for each aircraft."""
    height = 1.4 + 0.19 * len(table)
    figure, axes = plt.subplots(1, columns, sharey=True, figsize=(9, height), layout="constrained")
    axes[0].set_yticks(range(len(table)), table.index, fontsize=9)
    axes[0].set_ylim(len(table) - 0.5, -0.5)
    return figure, axes


def steps():
    """Settling times of the designed tables at their design points."""
    table = read("designed-gains-steps")
    figure, axes = rows(table, 5)
    limits = {"pitch": 4.0, "roll": 5.0}
    for ax, loop in zip(axes, ("pitch", "roll", "heading", "altitude", "speed"), strict=True):
        (column,) = (c for c in table.columns if c.startswith(f"{loop}:"))
        seconds = pd.Series([float(cell.split(",")[0]) for cell in table[column]])
        failed = [loop in row for row in table["verdict"]]
        end = max(1.2 * seconds.quantile(0.9), limits.get(loop, 0.0))
        colours = ["tab:red" if f else "tab:blue" for f in failed]
        ax.scatter(seconds.clip(upper=end), range(len(table)), c=colours, s=20)
        for row, value in seconds[seconds > end].items():
            ax.annotate(f"{value:.0f} →", (end, row), (-6, -3), ha="right", fontsize=9,
                        textcoords="offset points")  # fmt: skip
        if loop in limits:
            ax.axvline(limits[loop], color="0.5", linestyle="--")
        ax.set(title=loop, xlabel="settling time [s]", xlim=(0.0, 1.08 * end))
        ax.grid(axis="both", alpha=0.3)
    figure.suptitle("Designed gains: settling times (red: a requirement is missed; dashed: limit)")
    return figure


def modes():
    """Natural frequency and damping ratio of the fleet's oscillations."""
    table = read("fleet-modes")
    figure, axes = plt.subplots(1, 3, figsize=(9, 3.9), layout="constrained")
    named = {"c172p": "tab:orange", "737": "tab:green", "Concorde": "tab:red"}
    for ax, mode in zip(axes, ("short period", "Dutch roll", "phugoid"), strict=True):
        for name in sorted(table.index, key=list(named).__contains__):  # named ones above the rest
            for frequency, damping in re.findall(r"([\d.]+) / (-?[\d.]+)", table[mode][name]):
                ax.plot(
                    float(damping),
                    float(frequency),
                    "o",
                    color=named.get(name, "#a5bfd6"),
                    markersize=7 if name in named else 4,
                    label=name if name in named else None,
                )
        ax.axvline(0.0, color="0.5", linewidth=0.8)
        ax.set(title=mode, xlabel="damping ratio", ylabel="natural frequency [rad/s]")
        ax.set_ylim(bottom=0.0)
        ax.grid(alpha=0.3)
    figure.legend(*axes[1].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.suptitle("The fleet's oscillations in level flight or a glide")
    return figure


def performance():
    """Rate of climb, ceiling and glide ratio of the fleet."""
    table = read("performance")
    figure, axes = rows(table, 3)
    columns = {
        "climb ft/min": "best rate of climb [ft/min]",
        "service ceiling ft": "service ceiling [ft]",
        "glide ratio": "best glide ratio",
    }
    for ax, (column, label) in zip(axes, columns.items(), strict=True):
        values = pd.to_numeric(table[column].str.rstrip("*"), errors="coerce")
        values = values.where(values > 0.0)  # a glider does not climb
        early = table[column].str.endswith("*")
        colours = early.map({True: "white", False: "tab:blue"})
        ax.scatter(values, range(len(table)), s=24, c=colours, edgecolors="tab:blue")
        ax.set_xlabel(label)
        ax.set_xlim(left=0.0)
        ax.xaxis.set_major_locator(plt.MaxNLocator(4))
        ax.grid(alpha=0.3)
    figure.suptitle("Climb at sea level, ceiling and glide of the fleet")
    return figure


def accuracy():
    """Each quantity of NASA's check cases: the larger of its two distances over their limits."""
    table = pd.read_csv(EVIDENCE / "accuracy.csv", dtype={"case": str})
    cases = list(dict.fromkeys(table["case"]))
    kinds = {"altitude": "altitude", "latitude": "position", "longitude": "position"}
    kinds |= {"true airspeed": "airspeed", "heading": "attitude"}
    kinds |= dict.fromkeys(("roll angle", "pitch angle"), "attitude")
    kind = table["quantity"].map(kinds).fillna("rates and velocities")
    figure, ax = plt.subplots(figsize=(9, 4.4), layout="constrained")
    marks = dict(zip(("altitude", "position", "airspeed", "attitude"), "osD^", strict=True))
    for name, mark in {**marks, "rates and velocities": "x"}.items():
        part = table[kind == name]
        # rounding is drawn at the foot of the axis
        ax.semilogy([cases.index(c) for c in part["case"]], part["ratio"].clip(lower=1e-6), mark,
                    label=name, alpha=0.8, markersize=6)  # fmt: skip
    ax.axhline(1.0, color="tab:red", linewidth=1.5)
    ax.annotate("limit", (len(cases) - 0.6, 1.15), color="tab:red", ha="right")
    ax.set_xticks(range(len(cases)), cases)
    ax.set(xlabel="check case", ylabel="distance / limit", ylim=(5e-7, 4.0))
    ax.grid(alpha=0.3)
    figure.legend(loc="outside lower center", ncols=5)
    figure.suptitle(
        "NASA's check cases: each quantity's distance from the simulators, over its limit"
    )
    return figure


CHARTS = {
    "accuracy": accuracy,
    "designed_gains": steps,
    "fleet_modes": modes,
    "fleet_performance": performance,
}


if __name__ == "__main__":
    for name in sys.argv[1:] or CHARTS:
        save(CHARTS[name](), f"evidence_{name}", width=1350)
