"""The figures of the trim studies. Each takes a table and returns a matplotlib Figure."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.checks import did_you_mean, name_list, nearest, one_of, refuse
from ..plots import subplots

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARKERS = "osD^vPX*"

# reason for which a point does not trim: its marker in a map
_REASONS = {"alpha limit": "x", "thrust": "|", "elevator": "_", "no convergence": "+"}


def _chart(study: str, columns: str) -> Callable[[Callable[..., Any]], Callable[..., Figure]]:
    """A decorator for functions that draw a table and its trimmed rows, return figure, headline.

    The table must have the ``columns``, separated by blanks, of ``study``.
    """

    def complete(draw: Callable[..., Any]) -> Callable[..., Figure]:
        def chart(table: pd.DataFrame, title: str = "") -> Figure:
            figure, headline = draw(table, _trimmed(table, draw.__name__, study, columns.split()))
            figure.suptitle(title or _named(table, headline))
            return figure

        chart.__name__ = chart.__qualname__ = draw.__name__
        chart.__doc__ = draw.__doc__
        return chart

    return complete


def _named(table: pd.DataFrame, headline: str) -> str:
    """The headline, preceded by the aircraft if the table has its name."""
    aircraft = table.attrs.get("aircraft")
    return f"{aircraft}: {headline}" if aircraft else headline[0].upper() + headline[1:]


def _trimmed(table: Any, chart: str, study: str, columns: Sequence[str]) -> pd.DataFrame:
    """The rows that trimmed, after checking that the table has all columns of the chart."""
    names = [str(name) for name in getattr(table, "columns", ())]
    if not names:
        refuse("table", table, f"{chart} draws a table (DataFrame) of {study}, not {table!r:.60}")
    for name in ("trimmed", *columns):
        if name not in names:
            why = f"{chart} draws a table of {study}; this one has no column {name!r}"
            refuse("table", names, why + did_you_mean(nearest(name, names)))
    rows = table[table.trimmed.astype(bool)]
    if rows.empty:
        refuse("table", names, f"{chart} cannot draw this table: none of its points trims")
    return rows


@_chart(
    "aoa_vs_cas, aoa_vs_cas_loading or a trim_sweep over speed",
    "requested_altitude_ft speed_kcas alpha_deg elevator_rad weight_lb cg_x_in",
)
def alpha_elevator_chart(table: pd.DataFrame, trimmed: pd.DataFrame) -> tuple[Figure, str]:
    """Angle of attack and elevator deflection in trim against airspeed, in two panels.

    One line for each altitude and, if the table has them, weight case and CG shift (of the
    empty-weight CG, in inches). The legend gives weight and CG of the first point of each line.

    Parameters
    ----------
    table : DataFrame
        of aoa_vs_cas, aoa_vs_cas_loading or a trim_sweep over speed
    title : str
        headline

    Raises
    ------
    ParameterError
        if the table lacks a column, or no point of it trims
    """
    lines = list(_lines(trimmed))
    figure, axes = subplots(
        2, 1, sharex=True, figsize=(8, 6 + 0.2 * len(lines)), layout="constrained"
    )
    for label, style, rows in lines:
        curves = (rows.alpha_deg, np.degrees(rows.elevator_rad))
        for ax, y in zip(axes, curves, strict=True):
            ax.plot(rows.speed_kcas, y, label=label, markersize=4, linewidth=1.2, **style)
    axes[0].set(ylabel="angle of attack [deg]")
    axes[1].set(ylabel="elevator deflection [deg]", xlabel="calibrated airspeed [kt]")
    for ax in axes:
        ax.grid(alpha=0.4)
    marks = axes[0].get_legend_handles_labels()
    figure.legend(*marks, loc="outside lower center", fontsize="small")
    return figure, "trim: angle of attack, and elevator (trailing edge down positive)"


def _lines(table: pd.DataFrame) -> Iterator[tuple[str, dict[str, Any], pd.DataFrame]]:
    """Label, style and rows of each line: colour by weight, marker by CG, dashes by altitude."""
    keys = ["weight_case", "cg_shift_percent", "requested_altitude_ft"]
    keys = [key for key in keys if key in table]
    values = [list(table[key].unique()) for key in keys]
    for group, rows in table.groupby(keys, sort=False):
        at = dict(zip(keys, group, strict=True))
        index = {key: order.index(at[key]) for key, order in zip(keys, values, strict=True)}
        parts = [
            f"{at['weight_case']}" if "weight_case" in at else "",
            _cg_travel(rows) if "cg_shift_percent" in at else "",
            f"{at['requested_altitude_ft']:.0f} ft",
            f"{rows.weight_lb.iloc[0]:.0f} lb",
            f"CG {rows.cg_x_in.iloc[0]:.1f} in",
        ]
        style = {
            "color": f"C{index.get('weight_case', 0)}",
            "marker": _MARKERS[index.get("cg_shift_percent", 0) % len(_MARKERS)],
            "linestyle": ("-", "--", "-.", ":")[index["requested_altitude_ft"] % 4],
        }
        yield ", ".join(filter(None, parts)), style, rows


def _cg_travel(rows: pd.DataFrame) -> str:
    """Shift of the empty-weight CG, in inches because a percentage would be read as % MAC."""
    first = rows.iloc[0]
    shift = first.cg_shift_percent
    inches = first.requested_empty_cg_x_in * shift / (100 + shift)
    return f"empty CG {abs(inches):.1f} in {'aft' if shift > 0 else 'forward'}"


@_chart(
    "trim_envelope or a trim_sweep over speed and gamma",
    "reason thrust_lb throttle_norm alpha_deg requested_speed_kcas requested_gamma_deg",
)
def envelope_map(table: pd.DataFrame, trimmed: pd.DataFrame) -> tuple[Figure, str]:
    """Throttle, thrust and angle of attack over airspeed and flight path angle, in three panels.

    The marker of a point without trim tells the reason, so that the map shows its limits.

    Parameters
    ----------
    table : DataFrame
        of trim_envelope or a trim_sweep over speed and gamma
    title : str
        headline

    Raises
    ------
    ParameterError
        if the table lacks a column, or no point of it trims
    """
    from matplotlib.ticker import MaxNLocator

    figure, axes = subplots(3, 1, sharex=True, figsize=(8, 10.5), layout="constrained")
    for ax, values, label in (
        (axes[0], trimmed.throttle_norm, "throttle command [-]"),
        (axes[1], trimmed.thrust_lb / 1000, "thrust [1000 lbf]"),
        (axes[2], trimmed.alpha_deg, "angle of attack [deg]"),
    ):
        points = ax.scatter(
            trimmed.requested_speed_kcas, trimmed.requested_gamma_deg, c=values, marker="s", s=50
        )
        figure.colorbar(points, ax=ax, label=label)
        for reason, rows in table[~table.trimmed].groupby("reason"):
            style: dict[str, Any] = {
                "marker": _REASONS.get(str(reason), "."),
                "label": f"no trim: {reason}",
            }
            style |= {"s": 26, "color": "0.35", "linewidths": 1.0}
            ax.scatter(rows.requested_speed_kcas, rows.requested_gamma_deg, **style)
        ax.set_ylabel("flight path angle [deg]")
        ax.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes[-1].set_xlabel("calibrated airspeed [kt]")
    if not table.trimmed.all():
        marks = axes[0].get_legend_handles_labels()
        figure.legend(*marks, loc="outside lower center", ncols=3, fontsize="small")
    return figure, f"trim envelope, {len(trimmed)} of {len(table)} points trim"


@_chart("thrust_vectoring", "case thrust_angle_deg thrust_lb alpha_deg")
def thrust_chart(table: pd.DataFrame, trimmed: pd.DataFrame) -> tuple[Figure, str]:
    """Thrust and angle of attack against the thrust angle, with the minimum marked.

    One panel for each case. The curve is flat at the minimum and has kinks from the trim's
    tolerance, so the angle is accurate to about half a degree.

    Parameters
    ----------
    table : DataFrame
        of thrust_vectoring
    title : str
        headline

    Raises
    ------
    ParameterError
        if the table lacks a column, or no point of it trims
    """
    cases = list(trimmed.groupby("case", sort=False))
    figure, axes = subplots(
        len(cases), 1, squeeze=False, figsize=(8, 3.6 * len(cases)), layout="constrained"
    )
    for ax, (case, rows) in zip(axes[:, 0], cases, strict=True):
        best = rows.loc[rows.thrust_lb.idxmin()]
        ax.plot(rows.thrust_angle_deg, rows.thrust_lb, color="C0")
        least = f"minimum: {best.thrust_lb:.0f} lbf at about {best.thrust_angle_deg:.0f} deg"
        ax.plot(best.thrust_angle_deg, best.thrust_lb, "o", color="C3", label=least)
        ax.set_title(
            f"{case}: {best.requested_altitude_ft:.0f} ft, {best.speed_kcas:.0f} KCAS, "
            f"Mach {best.mach:.2f}, flight path angle {best.gamma_deg:.0f} deg",
            fontsize="medium",
        )
        ax.set(xlabel="thrust angle, up positive [deg]")
        ax.set_ylabel("thrust [lbf]", color="C0")
        ax.ticklabel_format(useOffset=False)
        ax.grid(alpha=0.4)
        ax.legend(loc="upper center")
        alpha = ax.twinx()
        alpha.plot(rows.thrust_angle_deg, rows.alpha_deg, "--", color="C2")
        alpha.set_ylabel("angle of attack [deg]", color="C2")
    return figure, "thrust in trim against the angle of the engines"


@_chart(
    "climb_schedule or a trim_sweep over altitude",
    "requested_altitude_ft requested_speed_kcas requested_gamma_deg throttle_norm pitch_trim_norm",
)
def climb_chart(table: pd.DataFrame, trimmed: pd.DataFrame) -> tuple[Figure, str]:
    """Throttle and pitch trim of a steady climb against altitude, in two panels.

    Parameters
    ----------
    table : DataFrame
        of climb_schedule or a trim_sweep over altitude
    title : str
        headline

    Raises
    ------
    ParameterError
        if the table lacks a column, or no point of it trims
    """
    from matplotlib.ticker import MaxNLocator

    figure, axes = subplots(1, 2, figsize=(8, 3.8), layout="constrained")
    for ax, name in zip(axes, ("throttle", "pitch trim"), strict=True):
        values = trimmed[f"{name.replace(' ', '_')}_norm"]
        ax.plot(trimmed.requested_altitude_ft, values, "o-", markersize=4)
        ax.xaxis.set_major_locator(MaxNLocator(5))
        ax.set(xlabel="altitude [ft]", ylabel=f"{name} command [-]")
        ax.grid(alpha=0.4)
    first = table.iloc[0]
    climb = f"{first.requested_speed_kcas:g} KCAS, {first.requested_gamma_deg:g} deg"
    return figure, f"steady climb at {climb}"


def performance_chart(table: pd.DataFrame, title: str = "", charts: Sequence[str] = ()) -> Figure:
    """Performance charts of an aircraft on one page; a panel without values gives the reason.

    A value that breaks an invariant of physics is drawn hollow.

    Parameters
    ----------
    table : DataFrame
        of `performance_table`
    title : str
        headline
    charts : sequence of str
        the panels, by default all: `stall`, `V-n`, `power`, `climb`, `speeds`, `ceiling`,
        `glide`, `range`, `turn`, `field`

    Raises
    ------
    ParameterError
        if the table is not one of `performance_table`, or for an unknown panel
    """
    from .performance import COLUMNS

    if [*getattr(table, "columns", ())] != [*COLUMNS]:
        refuse("table", table, "performance_chart draws a table (DataFrame) of performance_table")
    rows = table.dropna(subset=["value"])
    pull = "power" if (rows.quantity == "power required").any() else "thrust"
    speeds = ("stall speed, throttle closed", "lowest level speed", "highest level speed")
    panels = {
        "stall": ("stall", _stall_speeds, ("stall speed",)),
        "V-n": ("V-n", _load_factors, ()),
        "power": ("level", _over_speed, (f"{pull} available", f"{pull} required")),
        "climb": ("climb", _over_speed, ("rate of climb",)),
        "speeds": ("level", _over_altitude, speeds),
        "ceiling": ("climb", _over_altitude, ("best rate of climb",)),
        "glide": ("glide", _over_speed, ("sink rate",)),
        "range": ("range", _over_speed, ("specific range",)),
        "turn": ("turn", _over_speed, ("instantaneous load factor", "sustained load factor")),
        "field": ("field", _distances, ("landing distance", "take-off distance")),
    }
    names = name_list("charts", charts) or panels
    charts = [one_of("charts", chart, panels) for chart in names]
    lines = math.ceil(len(charts) / 2)
    figure, axes = subplots(
        lines, 2, squeeze=False, figsize=(10, 0.8 + 4 * lines), layout="constrained"
    )
    for ax, panel in itertools.zip_longest(axes.flat, charts):
        if panel is None:
            ax.set_axis_off()
            continue
        chart, draw, quantities = panels[panel]
        draw(ax, table[table.chart == "V-n"] if chart == "V-n" else rows, quantities)
        if panel == "glide":
            ax.invert_yaxis()
        if ax.has_data():
            ax.grid(alpha=0.4)
            ax.locator_params("x", nbins=6)
            if ax.get_legend_handles_labels()[0]:  # below the panel, clear of the curves
                ax.legend(
                    loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, fontsize="small"
                )
            continue
        ax.set_axis_off()
        failures = table[table.quantity.str.startswith("all of ")]
        why = table[(table.chart == chart) & table.value.isna()]
        reasons = map(str, (failures if why.empty else why).reason.unique())
        text = f"no {chart} chart:\n{', '.join(reasons) or 'not in the table'}"
        ax.text(0.5, 0.5, text, ha="center", wrap=True, transform=ax.transAxes)
    notes, flown = [_holes(table), _faults(table)], table.difference_percent.abs().dropna()
    if len(flown):
        notes.append(f"{len(flown)} values flown, half of them within {flown.median():.2g} %")
    text = "\n".join(note for note in notes if note)
    figure.supxlabel(text, fontsize="small", wrap=True)
    figure.suptitle(title or _named(table, "performance"))
    return figure


def _holes(table: pd.DataFrame) -> str:
    """Text with the airspeeds at which curves have gaps, and the reasons."""
    rows = table[table.value.isna() & table.speed_kcas.notna()]
    parts = []
    for (quantity, reason), points in rows.groupby(["quantity", "reason"], sort=False):
        speeds = ", ".join(f"{speed:.0f}" for speed in points.speed_kcas)
        parts.append(f"{quantity} at {speeds} KCAS ({reason})")
    return "left out: " + "; ".join(parts) if parts else ""


def is_fault(table: pd.DataFrame) -> Any:
    """Which values break an invariant; tables read from a file have NaN for an empty text."""
    return table.fault.astype(object).fillna("") != ""


def _faults(table: pd.DataFrame) -> str:
    """Text with the invariants that values break; they are drawn hollow."""
    rows = table[is_fault(table)]
    parts = [
        f"{fault} ({', '.join(points.quantity.unique())})"
        for fault, points in rows.groupby("fault", sort=False)
    ]
    return "hollow: " + "; ".join(parts) if parts else ""


def _line(ax: Axes, rows: pd.DataFrame, x: str, y: str, style: str, **options: Any) -> None:
    """Values of a table, with hollow marks for those that break an invariant."""
    (curve,) = ax.plot(rows[x], rows[y], style, **options)
    _hollow(ax, rows, x, y, curve.get_color())


def _hollow(ax: Axes, rows: pd.DataFrame, x: str, y: str, color: Any) -> None:
    hollow = rows[is_fault(rows)]
    if len(hollow):
        ax.plot(hollow[x], hollow[y], "o", color=color, markerfacecolor=ax.get_facecolor())


def _over_speed(ax: Axes, table: pd.DataFrame, quantities: Sequence[str]) -> None:
    """Quantities against airspeed, one line for each altitude and weight."""
    for quantity, style in zip(quantities, "-:", strict=False):
        rows = table[table.quantity == quantity]
        for i, ((height, weight), line) in enumerate(rows.groupby(["altitude_ft", "weight_lb"])):
            label = f"{height:.0f} ft, {weight:.0f} lb" if style == "-" else None
            _line(ax, line, "speed_kcas", "value", f".{style}", color=f"C{i}", label=label)
        for unit in rows.unit[:1]:
            ax.set_ylabel(",\ndotted: ".join(quantities) + f" [{unit}]")
    ax.set_xlabel("calibrated airspeed [kt]")


def _stall_speeds(ax: Axes, table: pd.DataFrame, quantities: Sequence[str]) -> None:
    rows = table[table.quantity.isin(quantities)].sort_values("weight_lb")
    for flaps, line in rows.groupby("flaps_norm"):
        _line(ax, line, "weight_lb", "value", "o-", label=f"flaps {flaps:g}")
    ax.set(xlabel="weight [lb]", ylabel="stall speed, throttle closed [KCAS]")


def _over_altitude(ax: Axes, table: pd.DataFrame, quantities: Sequence[str]) -> None:
    """Quantities and ceilings against altitude."""
    for i, quantity in enumerate(quantities):
        rows = table[table.quantity == quantity]
        for weight, line in rows.groupby("weight_lb"):
            name = f"{quantity}, {weight:.0f} lb"
            _line(ax, line, "value", "altitude_ft", "o-", color=f"C{i}", label=name)
        for unit in rows.unit[:1]:
            name = quantity if len(quantities) == 1 else "true airspeed"
            ax.set_xlabel(f"{name} [{'kt' if unit == 'KTAS' else unit}]")
    for ceiling, style in (("absolute ceiling", "-"), ("service ceiling", ":")):
        for height in table[table.quantity == ceiling].value if ax.lines else ():
            ax.axhline(height, color="0.4", linestyle=style, label=f"{ceiling} {height:.0f} ft")
    ax.set_ylabel("altitude [ft]")


def _distances(ax: Axes, table: pd.DataFrame, quantities: Sequence[str]) -> None:
    """Distances to and from the screen height, as bars."""
    for row in table[table.quantity.isin(quantities)].itertuples():
        name = f"{row.quantity.removesuffix(' distance')}\n{row.altitude_ft:.0f} ft"
        ax.bar_label(ax.barh(f"{name}, {row.weight_lb:.0f} lb", row.value), fmt="%.0f ft")
    ax.set_xlabel("distance over the screen height [ft]")
    ax.margins(x=0.2)


def _load_factors(ax: Axes, rows: pd.DataFrame, quantities: Sequence[str]) -> None:
    """Manoeuvre and gust lines of a V-n diagram, closed if its corners have values."""
    limit = rows[rows.quantity == "speed at the lift limit"]
    speeds = {name: rows[rows.quantity == name].value.dropna() for name in ("VC", "VD")}
    ends = [speed.iloc[0] for speed in speeds.values() if len(speed)]
    corners = {}  # load factor: highest speed, KEAS
    for line in (limit[limit.load_factor > 0.0], limit[limit.load_factor < 0.0]):
        line = line.sort_values("load_factor", key=abs)
        largest, line = line.load_factor[-1:], line.dropna(subset=["value"])
        if not len(line):
            continue
        # at a constant lift coefficient the airspeed grows with the root of the load factor
        root = np.sqrt([0.0, *line.load_factor.abs()])
        fine = np.linspace(0.0, root[-1], 50)
        speed, n = np.interp(fine, root, [0.0, *line.value]), fine**2
        sign = np.sign(line.load_factor.iloc[0])
        # CS 23.337: the negative limit holds up to VC
        end = max([*(ends if sign > 0.0 else ends[:1]), speed[-1]])
        at_limit = largest.isin(line.load_factor).all()
        if at_limit or sign < 0.0:
            corners[sign * n[-1]] = end
        if at_limit:
            speed, n = np.append(speed, end), np.append(n, n[-1])
            if sign > 0.0:
                speeds["VA"] = line.value[-1:]
        label = "lift limit, limit load factor" if sign > 0.0 else None
        ax.plot(speed, sign * n, "C0", label=label)
        _hollow(ax, line, "value", "load_factor", "C0")
    if len(ends) == 2 and len(corners) == 2:
        (high, fast), (low, slow) = sorted(corners.items(), reverse=True)
        style = "C0" if low == limit.load_factor.min() else "C0:"  # dotted where no trim is known
        ax.plot([fast, fast, slow], [high, 0.0, low], style)
    for name, speed in speeds.items():
        if len(speed) and ax.lines:
            span: dict[str, Any] = {
                "transform": ax.get_xaxis_transform(),
                "color": "0.6",
                "linewidth": 0.8,
            }
            ax.vlines(speed.iloc[0], 0.0, 1.0, **span)
            ax.annotate(name, (speed.iloc[0], 0.02), xycoords=("data", "axes fraction"))
    for i, name in enumerate(("VC", "VD"), 1):
        gust = rows[rows.quantity == f"gust load factor at {name}"].value.dropna()
        if len(gust):
            jump, speed = gust.iloc[0] - 1.0, speeds[name].iloc[0]
            tips = [speed, 0.0, speed], [1.0 + jump, 1.0, 1.0 - jump]
            ax.plot(*tips, f"C{i}--", label=f"gust at {name}")
    ax.set(xlabel="equivalent airspeed [kt]", ylabel="load factor [g]")
