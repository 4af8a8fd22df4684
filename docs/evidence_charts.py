"""Draw the charts of the evidence pages from the tables (CSV) beside them.

python docs/evidence_charts.py
"""

import re
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd

DOCS = Path(__file__).resolve().parent
EVIDENCE = DOCS / "evidence"


def read(name):
    """A table as text, by aircraft."""
    return pd.read_csv(EVIDENCE / f"{name}.csv", dtype=str, keep_default_na=False, index_col=0)


def steps():
    """Settling times of the designed tables at their design points."""
    table = read("designed-gains-steps")
    figure, axes = plt.subplots(1, 5, sharey=True, figsize=(11, 6.4), layout="constrained")
    limits = {"pitch": 4.0, "roll": 5.0}
    for ax, loop in zip(axes, ("pitch", "roll", "heading", "altitude", "speed"), strict=True):
        (column,) = (c for c in table.columns if c.startswith(f"{loop}:"))
        seconds = [float(cell.split(",")[0]) for cell in table[column]]
        failed = [loop in row for row in table["verdict"]]
        ax.scatter(seconds, range(len(table)), c=["tab:red" if f else "tab:blue" for f in failed])
        if loop in limits:
            ax.axvline(limits[loop], color="0.5", linestyle="--")
        ax.set(title=loop, xlabel="settling time [s]")
        ax.set_xlim(left=0.0)
        ax.grid(axis="both", alpha=0.3)
    axes[0].set_yticks(range(len(table)), table.index)
    axes[0].invert_yaxis()
    return figure


def modes():
    """Natural frequency and damping ratio of the fleet's oscillations."""
    table = read("fleet-modes")
    figure, axes = plt.subplots(1, 3, figsize=(11, 4), layout="constrained")
    for ax, mode in zip(axes, ("short period", "Dutch roll", "phugoid"), strict=True):
        for name, cell in table[mode].items():
            for frequency, damping in re.findall(r"([\d.]+) / (-?[\d.]+)", cell):
                ax.plot(float(damping), float(frequency), "o", color="tab:blue", markersize=4)
                if name in ("c172p", "Concorde"):
                    ax.annotate(
                        name,
                        (float(damping), float(frequency)),
                        xytext=(5, 2),
                        textcoords="offset points",
                        fontsize=9,
                    )
        ax.axvline(0.0, color="0.5", linewidth=0.8)
        ax.set(title=mode, xlabel="damping ratio", ylabel="natural frequency [rad/s]")
        ax.set_ylim(bottom=0.0)
        ax.grid(alpha=0.3)
    return figure


def performance():
    """Rate of climb, ceiling and glide ratio of the fleet."""
    table = read("performance")
    figure, axes = plt.subplots(1, 3, sharey=True, figsize=(11, 8), layout="constrained")
    columns = ("climb ft/min", "service ceiling ft", "glide ratio")
    for ax, column in zip(axes, columns, strict=True):
        values = pd.to_numeric(table[column].str.rstrip("*"), errors="coerce")
        early = table[column].str.endswith("*")
        ax.scatter(values, range(len(table)), s=20, c=early.map({True: "white", False: "tab:blue"}))
        ax.scatter(values, range(len(table)), s=20, facecolors="none", edgecolors="tab:blue")
        label = {
            "climb ft/min": "best rate of climb at sea level [ft/min]",
            "service ceiling ft": "service ceiling [ft]",
            "glide ratio": "best glide ratio",
        }[column]
        ax.set(xlabel=label)
        ax.set_xlim(left=min(0.0, values.min() * 1.1))
        ax.grid(alpha=0.3)
    axes[0].set_yticks(range(len(table)), table.index, fontsize=8)
    axes[0].invert_yaxis()
    return figure


CHARTS = {"designed_gains": steps, "fleet_modes": modes, "fleet_performance": performance}


def main():
    from generate import shrink

    with tempfile.TemporaryDirectory() as folder:
        for name, draw in CHARTS.items():
            file = Path(folder, f"{name}.png")
            draw().savefig(file, dpi=150)
            shrink(file, DOCS / "pictures" / f"evidence_{name}.png", width=1100)
            plt.close("all")


if __name__ == "__main__":
    plt.switch_backend("agg")
    main()
