"""Draw the figures of the pages on concepts, light and dark.

python docs/figures.py
"""

from pathlib import Path

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
import numpy as np

from pathsim_jsbsim_blocks import plots
from pathsim_jsbsim_blocks.flight.airframe import Airframe
from pathsim_jsbsim_blocks.flight.points import aircraft_points

FOLDER = Path(__file__).resolve().parent / "concepts" / "figures"
# the same file for the same figure
matplotlib.rcParams["svg.hashsalt"] = "pathsim-jsbsim-blocks"

BODY, AIR, EARTH, FORCE = "#2a78d6", "#e07b39", "#3f9b54", "#c0392b"


def outline(angle=0.0, scale=1.0):
    """Side view of a light aircraft, nose to the right, turned nose up by ``angle`` in deg."""
    x = [1.0, 0.93, 0.55, 0.32, -0.05, -0.75, -0.98, -1.0, -0.9, -0.55, 0.2, 0.75, 0.97, 1.0]
    z = [0.02, 0.10, 0.14, 0.30, 0.30, 0.10, 0.40, 0.05, 0.0, -0.05, -0.14, -0.12, -0.05, 0.02]
    return turned(np.array(x) * scale, np.array(z) * scale, angle)


def plan(angle=0.0, scale=1.0):
    """Top view, nose to the right, turned by ``angle`` in deg (nose up in the picture)."""
    half_x = [1.0, 0.9, 0.4, 0.35, 0.1, 0.05, -0.7, -0.78, -0.95, -0.95]
    half_y = [0.0, 0.08, 0.1, 1.2, 1.2, 0.1, 0.05, 0.4, 0.4, 0.0]
    x = np.array(half_x + half_x[::-1]) * scale
    y = np.array(half_y + [-v for v in half_y[::-1]]) * scale
    return turned(x, y, angle)


def front(angle=0.0, scale=1.0):
    """View from behind, right wing to the right, rolled right by ``angle`` in deg."""
    x = [0.0, 0.1, 1.2, 1.2, 0.13, 0.12, 0.0, -0.12, -0.13, -1.2, -1.2, -0.1, 0.0]
    z = [0.55, 0.12, 0.16, 0.10, 0.05, -0.1, -0.16, -0.1, 0.05, 0.10, 0.16, 0.12, 0.55]
    return turned(np.array(x) * scale, np.array(z) * scale, -angle)


def turned(x, y, angle):
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return c * np.asarray(x) - s * np.asarray(y), s * np.asarray(x) + c * np.asarray(y)


def arrow(ax, angle, length, colour, text, start=(0.0, 0.0), dashed=False, **offset):
    """An arrow from ``start`` at ``angle`` (deg, from the right, counter-clockwise), labelled."""
    dx, dy = turned([length], [0.0], angle)
    end = start[0] + dx[0], start[1] + dy[0]
    ax.annotate(
        "",
        xy=end,
        xytext=start,
        arrowprops={
            "arrowstyle": "-|>",
            "color": colour,
            "lw": 1.8,
            "ls": "--" if dashed else "-",
            "shrinkA": 0,
            "shrinkB": 0,
        },
    )
    label = start[0] + 1.09 * dx[0], start[1] + 1.09 * dy[0]
    ax.text(
        label[0] + offset.get("dx", 0),
        label[1] + offset.get("dy", 0),
        text,
        color=colour,
        ha="center",
        va="center",
    )


def arc(ax, begin, end, radius, text, colour):
    """An angle between two directions in deg."""
    angles = np.radians(np.linspace(begin, end, 40))
    ax.plot(radius * np.cos(angles), radius * np.sin(angles), color=colour, lw=1.2)
    middle = np.radians((begin + end) / 2)
    ax.text(
        (radius + 0.11) * np.cos(middle),
        (radius + 0.11) * np.sin(middle),
        text,
        color=colour,
        ha="center",
        va="center",
    )


def canvas(count, width=8.0, height=3.6):
    figure, axes = plt.subplots(
        1, count, figsize=(width, height), layout="constrained", squeeze=False
    )
    for ax in axes[0]:
        ax.set_aspect("equal")
        ax.axis("off")
    return figure, axes[0]


def ink():
    return plt.rcParams["text.color"]


def aircraft(ax, shape):
    ax.fill(*shape, facecolor="#9aa5b1", alpha=0.35, edgecolor=ink(), lw=0.8)


def structural():
    figure, (ax,) = canvas(1, 7.0, 3.4)
    aircraft(ax, outline(scale=1.4))
    # the nose points right: structural x runs aft, to the left
    origin = 1.75, -0.28
    arrow(ax, 180, 0.75, EARTH, "x aft", origin, dy=0.13)
    arrow(ax, 90, 0.75, EARTH, "z up", origin)
    ax.plot(*origin, "o", color=EARTH)
    ax.text(origin[0] + 0.08, origin[1] - 0.14, "structural origin", color=EARTH, ha="center")
    arrow(ax, 0, 0.85, BODY, "x forward", dx=0.24, dy=0.02)
    arrow(ax, -90, 0.6, BODY, "z down")
    ax.plot(0, 0, "o", color=BODY)
    ax.text(-0.16, 0.1, "CG", color=BODY, ha="center")
    ax.text(0.35, -0.75, "y points right in both: towards you", color=ink(), ha="left")
    ax.set(xlim=(-1.6, 2.2), ylim=(-0.95, 0.8))
    return figure


def wind():
    figure, (side, top) = canvas(2, 9.0, 3.8)
    alpha = 16
    aircraft(side, outline(alpha))
    arrow(side, alpha, 1.4, BODY, r"$x_B$")
    arrow(side, alpha - 90, 0.8, BODY, r"$z_B$")
    arrow(side, 0, 1.4, AIR, r"$x_S$")
    arrow(side, -90, 0.8, AIR, r"$z_S$")
    arc(side, 0, alpha, 1.1, r"$\alpha$", ink())
    side.set(xlim=(-1.2, 1.7), ylim=(-1.05, 0.85), title="from the right side")
    beta = 18
    aircraft(top, plan(90, 0.8))
    arrow(top, 90, 1.2, BODY, r"$x_S$")
    arrow(top, 0, 1.05, BODY, r"$y_B = y_S$", dx=0.18)
    arrow(top, 90 - beta, 1.3, AIR, r"$x_W$: airspeed", dx=0.25)
    arrow(top, -beta, 1.05, AIR, r"$y_W$")
    arc(top, 90 - beta, 90, 1.0, r"$\beta$", ink())
    top.set(xlim=(-1.1, 1.6), ylim=(-0.95, 1.6), title="from above")
    return figure


def euler():
    figure, (above, side, behind) = canvas(3, 9.5, 3.5)
    psi, theta, phi = 35, 14, 25
    aircraft(above, plan(90 - psi, 0.75))
    arrow(above, 90, 1.2, EARTH, "north")
    arrow(above, 0, 1.1, EARTH, "east", dx=0.1)
    arrow(above, 90 - psi, 1.2, BODY, r"$x_B$")
    arc(above, 90 - psi, 90, 0.95, r"$\psi$", ink())
    above.set(title="heading, from above", xlim=(-1.2, 1.45), ylim=(-1.2, 1.45))
    aircraft(side, outline(theta))
    arrow(side, 0, 1.35, EARTH, "horizon", dy=-0.13)
    arrow(side, theta, 1.35, BODY, r"$x_B$")
    arc(side, 0, theta, 1.1, r"$\theta$", ink())
    side.set(title="pitch, from the right", xlim=(-1.2, 1.7), ylim=(-1.3, 1.35))
    aircraft(behind, front(phi))
    arrow(behind, 0, 1.35, EARTH, "horizon", dy=0.13)
    arrow(behind, -phi, 1.35, BODY, r"$y_B$")
    arc(behind, -phi, 0, 1.1, r"$\phi$", ink())
    behind.set(title="roll, from behind", xlim=(-1.4, 1.7), ylim=(-1.3, 1.35))
    return figure


def earth():
    figure = plt.figure(figsize=(6.4, 5.4), layout="constrained")
    ax = figure.add_subplot(projection="3d", computed_zorder=False)
    ax.set_axis_off()
    ax.view_init(22, 35)
    ax.set_box_aspect((1, 1, 1), zoom=1.15)
    turn = np.linspace(0, 2 * np.pi, 120)
    for lat in range(-60, 90, 30):
        r, z = np.cos(np.radians(lat)), np.sin(np.radians(lat))
        ax.plot(r * np.cos(turn), r * np.sin(turn), z, color="#9aa5b1", lw=0.6)
    for lon in range(0, 180, 30):
        c, s = np.cos(np.radians(lon)), np.sin(np.radians(lon))
        ax.plot(c * np.cos(turn), s * np.cos(turn), np.sin(turn), color="#9aa5b1", lw=0.6)

    def ray(start, direction, colour, text):
        ax.quiver(*start, *direction, color=colour, lw=1.8, arrow_length_ratio=0.12)
        ax.text(*(np.add(start, 1.12 * np.asarray(direction))), text, color=colour, ha="center")

    ray((0, 0, 0), (1.5, 0, 0), BODY, "x: 0 N 0 E")
    ray((0, 0, 0), (0, 1.5, 0), BODY, "y: 0 N 90 E")
    ray((0, 0, 0), (0, 0, 1.28), BODY, "z: north pole")
    lat, lon = np.radians(35), np.radians(50)
    up = np.array([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)])
    north = np.array([-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)])
    east = np.array([-np.sin(lon), np.cos(lon), 0.0])
    ax.scatter(*up, color=EARTH, s=25)
    ray(up, 0.5 * north, EARTH, "north")
    ray(up, 0.5 * east, EARTH, "east")
    ray(up, -0.45 * up, EARTH, "down")
    ax.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-1, 1))
    return figure


def climb():
    figure, (ax,) = canvas(1, 6.5, 5.0)
    gamma, alpha = 18, 6
    aircraft(ax, outline(gamma + alpha))
    ax.plot([-1.1, 1.9], [0, 0], color="#9aa5b1", lw=0.8, ls=":")
    arrow(ax, gamma, 1.75, AIR, "V")
    arrow(ax, gamma + 90, 1.25, FORCE, "lift L")
    arrow(ax, gamma + 180, 0.7, FORCE, "drag D", dx=-0.08)
    arrow(ax, gamma, 1.15, FORCE, "thrust T", dx=0.0, dy=-0.2)
    arrow(ax, -90, 1.3, FORCE, "weight W")
    arc(ax, 0, gamma, 1.5, r"$\gamma$", ink())
    ax.set(xlim=(-1.25, 2.0), ylim=(-1.55, 1.45))
    return figure


def controls():
    """Elevator, ailerons and rudder where their commands are positive, and what the nose does."""
    figure, (side, behind, above) = canvas(3, 9.5, 3.4)
    aircraft(side, outline())
    surface(side, (-0.78, 0.1), 0.3, 205, "trailing edge down")
    moment(side, (0.75, 0.0), 0.42, 55, -55)
    aircraft(behind, front())
    surface(behind, (0.95, 0.13), 0.2, 90, "right one up")
    surface(behind, (-0.95, 0.13), 0.2, 270, "left one down")
    moment(behind, (0.0, 0.1), 0.5, 130, 50)
    aircraft(above, plan(90, 0.8))
    surface(above, (0.0, -0.72), 0.3, 240, "trailing edge left")
    moment(above, (0.0, 0.45), 0.42, 55, 125)
    for ax, does, seen in (
        (side, "elevator: nose down", "from the right"),
        (behind, "aileron: right wing down", "from behind"),
        (above, "rudder: nose left", "from above"),
    ):
        ax.set_title(f"positive {does}\n({seen})", fontsize="medium")
        ax.set(xlim=(-1.35, 1.35), ylim=(-1.2, 1.2))
    return figure


def surface(ax, hinge, length, angle, text):
    """A control surface from its hinge, deflected to an angle (deg, from the right)."""
    dx, dz = turned([length], [0.0], angle)
    ax.plot([hinge[0], hinge[0] + dx[0]], [hinge[1], hinge[1] + dz[0]], color=FORCE, lw=4)
    where = hinge[0], hinge[1] + (0.38 if 0 < angle < 180 else -0.38)
    ax.text(*where, text, color=FORCE, ha="center", va="center")


def moment(ax, centre, radius, begin, end):
    """A curved arrow about a centre, between two angles in deg."""
    angles = np.radians(np.linspace(begin, end, 40))
    x, y = centre[0] + radius * np.cos(angles), centre[1] + radius * np.sin(angles)
    ax.plot(x, y, color=BODY, lw=1.8)
    arrow_head = {"arrowstyle": "-|>", "color": BODY, "lw": 1.8}
    ax.annotate("", xy=(x[-1], y[-1]), xytext=(x[-3], y[-3]), arrowprops=arrow_head)


def points():
    airframe = Airframe("c172p")
    airframe.run_ic()
    return plots.aircraft_points(aircraft_points(airframe), "c172p: named points")


def main():
    FOLDER.mkdir(exist_ok=True)
    for draw in (structural, wind, euler, earth, climb, controls, points):
        for style, suffix in (("default", ""), ("dark_background", "-dark")):
            with plt.style.context(style):
                figure = draw()
                figure.savefig(
                    FOLDER / f"{draw.__name__}{suffix}.svg",
                    transparent=True,
                    metadata={"Date": None},
                )
                plt.close(figure)


if __name__ == "__main__":
    main()
