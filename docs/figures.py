"""Draw the figures of the pages on concepts, light and dark.

python docs/figures.py
"""

import xml.etree.ElementTree as ET
from pathlib import Path

import jsbsim
import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.patches import FancyBboxPatch

from pathsim_jsbsim_blocks.axes import body_to_ned
from pathsim_jsbsim_blocks.flight.airframe import Airframe

FOLDER = Path(__file__).resolve().parent / "concepts" / "figures"
SAME = {"svg.hashsalt": "pathsim-jsbsim-blocks"}  # the same file for the same figure

# readable on white and on black
BODY, AIR, EARTH, FORCE = "#3484e0", "#e07b39", "#3f9b54", "#e0524a"
STABILITY, INERTIAL, GRID = "#a06cd5", "#8a94a0", "#8a94a0"
WHOLE = {"shrinkA": 0, "shrinkB": 0}  # of an arrow from one point to the other


def outline(angle=0.0, scale=1.0):
    """Side view of a light aircraft, nose to the right, turned nose up by ``angle`` in deg."""
    x = [1.0, 0.93, 0.55, 0.32, -0.05, -0.75, -0.98, -1.0, -0.9, -0.55, 0.2, 0.75, 0.97, 1.0]
    z = [0.02, 0.10, 0.14, 0.30, 0.30, 0.10, 0.40, 0.05, 0.0, -0.05, -0.14, -0.12, -0.05, 0.02]
    return turned(np.array(x) * scale, np.array(z) * scale, angle)


def plan(angle=0.0, scale=1.0, wing=0.05):
    """Top view, nose to the right, turned by ``angle`` in deg (nose up in the picture).

    The trailing edge of the wing is at ``wing``.
    """
    chord = [wing + 0.35, wing + 0.3, wing + 0.05, wing]
    half_x = [1.0, 0.9, *chord, -0.7, -0.78, -0.95, -0.95]
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


def head(ax, begin, end, colour, **style):
    """A line with a head at its end."""
    props = {"arrowstyle": "-|>", "color": colour, **style}
    ax.annotate("", xy=end, xytext=begin, arrowprops=props)


def label(ax, x, y, text, colour, **style):
    """A text in its colour, with its middle at a place."""
    ax.text(x, y, text, **{"color": colour, "ha": "center", "va": "center", **style})


def vector(ax, step, colour, text, start=(0.0, 0.0), dashed=False, dx=0.0, dy=0.0):
    """An arrow by a step from ``start``, labelled beyond its end."""
    (x, y), (u, v) = start, step
    head(ax, start, (x + u, y + v), colour, lw=1.8, ls="--" if dashed else "-", **WHOLE)
    label(ax, x + 1.09 * u + dx, y + 1.09 * v + dy, text, colour)


def arrow(ax, angle, length, *style, **offset):
    """A vector at an angle (deg, from the right, counter-clockwise)."""
    vector(ax, turned(length, 0.0, angle), *style, **offset)


def arc(ax, begin, end, radius, text, colour):
    """An angle between two directions in deg."""
    angles = np.radians(np.linspace(begin, end, 40))
    ax.plot(radius * np.cos(angles), radius * np.sin(angles), color=colour, lw=1.2)
    middle = np.radians((begin + end) / 2)
    far = radius + 0.11
    label(ax, far * np.cos(middle), far * np.sin(middle), text, colour)


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


def aircraft(ax, shape, alpha=0.35):
    ax.fill(*shape, facecolor="#9aa5b1", alpha=alpha, edgecolor=ink(), lw=0.8)


def titled(ax, text, x, y):
    """A title inside the panel: panels of unequal height would have theirs at unequal heights."""
    label(ax, x, y, text, ink(), va="bottom", fontsize=11)


INCH = 2 / 326  # of a Cessna 172, in units of the outline
NOSE, WATERLINE = -37.7, -0.13  # station of the front point; height of waterline 0 in the outline


def station(inches):
    """Abscissa of a fuselage station in the outline, whose nose points right."""
    return 1.0 - (inches - NOSE) * INCH


def structural():
    figure, (side, top) = canvas(2, 10.5, 4.0)
    for ax, low, high in ((side, -0.52, 0.62), (top, -1.35, 1.35)):
        for inches in (0, 100, 200):
            x = station(inches)
            ax.plot([x, x], [low, high], color=GRID, lw=0.8, ls="--", zorder=0)
            label(ax, x, low - 0.06, f"FS {inches}", GRID, va="top")

    def level(ax, height, text):
        ax.plot([-1.2, 1.35], [height, height], color=GRID, lw=0.8, ls="--", zorder=0)
        ax.text(-1.25, height, text, color=GRID, ha="right", va="center")

    for inches in (0, 50):
        level(side, WATERLINE + inches * INCH, f"WL {inches}")
    for inches in (-100, 0, 100):
        level(top, -inches * INCH, f"BL {inches}")
    aircraft(side, outline())
    aircraft(top, plan(0, 0.98, wing=0.25))
    origin, cg = (station(0), WATERLINE), (station(42.1), WATERLINE + 37.7 * INCH)
    arrow(side, 180, 0.45, EARTH, "x", origin, dy=-0.1, dx=0.05)
    arrow(side, 90, 0.5, EARTH, "z", origin, dx=0.08)
    arrow(side, 0, 0.62, BODY, r"$x_B$", cg, dx=0.05)
    arrow(side, -90, 0.45, BODY, r"$z_B$", cg, dx=-0.1)
    side.plot(*origin, "o", color=EARTH)
    side.plot(*cg, "o", color=BODY)
    side.text(origin[0] + 0.06, origin[1] - 0.13, "origin", color=EARTH, ha="left")
    side.text(cg[0] - 0.05, cg[1] - 0.14, "CG", color=BODY, ha="right")
    origin, cg = (station(0), 0.0), (station(42.1), 0.0)
    arrow(top, 180, 0.45, EARTH, "x", origin, dy=0.1)
    arrow(top, -90, 0.75, EARTH, "y", origin, dx=0.08, dy=0.05)
    arrow(top, 0, 0.75, BODY, r"$x_B$", cg, dx=0.05)
    arrow(top, -90, 0.55, BODY, r"$y_B$", cg, dx=-0.1, dy=0.03)
    top.plot(*origin, "o", color=EARTH)
    top.plot(*cg, "o", color=BODY)
    for ax, text in ((side, "from the right side"), (top, "from above")):
        ax.set(xlim=(-1.65, 1.45), ylim=(-1.55, 1.65))
        titled(ax, text, 0, 1.4)
    return figure


def wind():
    figure, (side, top) = canvas(2, 10.5, 4.6)
    alpha, beta = 16, 18
    aircraft(side, outline(alpha, 0.9))
    arrow(side, alpha, 1.35, BODY, r"$x_B$", dy=0.04)
    arrow(side, alpha - 90, 0.85, BODY, r"$z_B$")
    arrow(side, 0, 1.35, STABILITY, r"$x_S$")
    arrow(side, -90, 0.85, STABILITY, r"$z_S = z_W$", dx=-0.12)
    arrow(side, 90, 1.0, FORCE, "lift L")
    arc(side, 0, alpha, 1.05, r"$\alpha$", ink())
    arc(side, -90, alpha - 90, 0.55, r"$\alpha$", ink())
    aircraft(top, plan(90, 0.78))
    arrow(top, 90, 1.2, STABILITY, r"$x_S$", dy=0.02)
    arrow(top, 0, 1.05, BODY, r"$y_B = y_S$", dx=0.2)
    arrow(top, 90 - beta, 1.25, AIR, r"$x_W$: airspeed", dx=0.32, dy=0.02)
    arrow(top, -beta, 1.05, AIR, r"$y_W$", dx=0.03)
    arrow(top, 270 - beta, 0.95, FORCE, "drag D", dx=-0.1, dy=-0.04)
    arrow(top, 180 - beta, 0.7, FORCE, "side force\nY < 0", dx=-0.25, dy=0.02)
    arc(top, 90 - beta, 90, 0.95, r"$\beta$", ink())
    arc(top, -beta, 0, 0.8, r"$\beta$", ink())
    for ax, text in ((side, "from the right side"), (top, "from above")):
        ax.set(xlim=(-1.35, 1.75), ylim=(-1.25, 1.65))
        titled(ax, text, 0.2, 1.42)
    return figure


def euler():
    """The three rotations in their order, each from the axes of the one before, and all in one."""
    names = ("above", "side", "behind", "together")
    figure, axes = plt.subplot_mosaic(
        [names[:3], ["together"] * 3],
        figsize=(9.5, 8.2),
        layout="constrained",
        height_ratios=(1, 1.35),
    )
    psi, theta, phi = 35, 20, 25
    above, side, behind, together = (axes[name] for name in names)
    aircraft(above, plan(90 - psi, 0.72))
    arrow(above, 90, 1.2, EARTH, "north")
    arrow(above, 0, 1.15, EARTH, "east", dx=0.12)
    arrow(above, 90 - psi, 1.2, BODY, r"$x_1$")
    arrow(above, -psi, 1.15, BODY, r"$y_1$")
    arc(above, 90 - psi, 90, 0.9, r"$\psi$", ink())
    arc(above, -psi, 0, 0.9, r"$\psi$", ink())
    aircraft(side, outline(theta, 0.9))
    arrow(side, 0, 1.25, EARTH, r"$x_1$", dx=0.03)
    arrow(side, -90, 1.05, EARTH, "down", dx=-0.22)
    arrow(side, theta, 1.25, BODY, r"$x_B$", dx=0.03)
    arrow(side, theta - 90, 1.05, BODY, r"$z_2$")
    arc(side, 0, theta, 1.0, r"$\theta$", ink())
    arc(side, -90, theta - 90, 0.75, r"$\theta$", ink())
    aircraft(behind, front(phi, 0.9))
    arrow(behind, 0, 1.25, EARTH, r"$y_1$", dx=0.03)
    arrow(behind, -90, 1.05, EARTH, r"$z_2$", dx=0.02)
    arrow(behind, -phi, 1.25, BODY, r"$y_B$", dx=0.03)
    arrow(behind, -90 - phi, 1.05, BODY, r"$z_B$", dx=-0.03)
    arc(behind, -phi, 0, 1.0, r"$\phi$", ink())
    arc(behind, -90 - phi, -90, 0.75, r"$\phi$", ink())
    titles = {
        "above": "1. heading $\\psi$ about down\nfrom above",
        "side": "2. pitch $\\theta$ about $y_1$\nfrom the right",
        "behind": "3. roll $\\phi$ about $x_B$\nfrom behind",
    }
    for name, text in titles.items():
        axes[name].set(xlim=(-1.4, 1.6), ylim=(-1.35, 1.95))
        titled(axes[name], text, 0.1, 1.5)
    in_one_view(together, phi, theta, psi)
    for ax in axes.values():
        ax.set_aspect("equal")
        ax.axis("off")
    return figure


# of the aircraft in one view: x forward, y right, z down
PARTS = {
    "fin": [(-0.72, 0, -0.08), (-0.9, 0, -0.42), (-1.03, 0, -0.42), (-0.98, 0, 0)],
    "tailplane": [
        (-0.72, 0.42, 0),
        (-0.9, 0.42, 0),
        (-0.98, 0, 0),
        (-0.9, -0.42, 0),
        (-0.72, -0.42, 0),
    ],
    "wing": [
        (0.28, 1.25, -0.1),
        (0.02, 1.25, -0.1),
        (-0.06, 0, -0.1),
        (0.02, -1.25, -0.1),
        (0.28, -1.25, -0.1),
        (0.36, 0, -0.1),
    ],
    "fuselage": [
        (1, 0, 0),
        (0.8, 0, -0.12),
        (0.3, 0, -0.2),
        (-0.1, 0, -0.2),
        (-0.98, 0, -0.06),
        (-0.98, 0, 0.02),
        (0, 0, 0.16),
        (0.8, 0, 0.13),
    ],
}


def in_one_view(ax, phi, theta, psi):
    """The aircraft, NED and body axes and the three angles, seen from the south-east and above."""
    look, down = np.radians(-32), np.radians(30)  # heading of the line of sight, and its slope
    screen = np.array(
        [
            [-np.sin(look), np.cos(look), 0.0],
            [np.cos(look) * np.sin(down), np.sin(look) * np.sin(down), -np.cos(down)],
        ]
    )
    body = np.array(body_to_ned(*np.eye(3), phi, theta, psi))
    heading = np.array(body_to_ned(*np.eye(3), 0, 0, psi))
    for part in PARTS.values():
        aircraft(ax, screen @ body @ np.transpose(part), alpha=0.4)

    def direction(axis, length, colour, text, **style):
        vector(ax, length * (screen @ axis), colour, text, **style)

    north, east, down_axis = np.eye(3)
    direction(north, 1.6, EARTH, "north")
    direction(east, 1.6, EARTH, "east")
    direction(down_axis, 1.1, EARTH, "down")
    direction(heading[:, 0], 1.75, INERTIAL, r"$x_1$", dashed=True, dx=0.05)
    direction(heading[:, 1], 1.6, INERTIAL, r"$y_1$", dashed=True, dx=0.12, dy=0.1)
    direction(body[:, 0], 1.75, BODY, r"$x_B$")
    direction(body[:, 1], 1.6, BODY, r"$y_B$")
    direction(body[:, 2], 1.1, BODY, r"$z_B$")

    def angle(begin, end, radius, text, dx=0.0):
        """An arc from one unit vector to another."""
        share = np.linspace(0.0, 1.0, 40)
        between = np.arccos(begin @ end)
        points = np.outer(begin, np.sin((1 - share) * between)) + np.outer(
            end, np.sin(share * between)
        )
        x, y = screen @ (radius * points / np.sin(between))
        ax.plot(x, y, color=FORCE, lw=1.6)
        label(ax, 1.1 * x[20] + dx, 1.1 * y[20], text, FORCE, fontsize=12)

    angle(north, heading[:, 0], 1.35, r"$\psi$")
    angle(heading[:, 0], body[:, 0], 1.5, r"$\theta$")
    angle(heading[:, 1], body[:, 1], 1.3, r"$\phi$", dx=-0.16)
    ax.set(xlim=(-1.6, 2.1), ylim=(-1.35, 1.25))
    titled(ax, "in one view; dashed: the axes after the heading", 0.25, 1.15)


def globe(x, y, z, turn=25.0, tilt=22.0):
    """Orthographic projection: abscissa, ordinate, and the distance towards the viewer."""
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    ahead, right = c * x + s * y, -s * x + c * y
    ct, st = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))
    return right, ct * z - st * ahead, ct * ahead + st * z


def curve(ax, x, y, z, **style):
    """A curve on the Earth; what is behind it is dotted."""
    u, v, front = globe(x, y, z)
    for visible, look in ((front >= 0, {}), (front < 0, {"ls": ":", "alpha": 0.5})):
        ax.plot(np.where(visible, u, np.nan), np.where(visible, v, np.nan), **{**style, **look})


def local(lat, lon):
    """Unit vectors up, north and east at a latitude and longitude in rad, in ECEF."""
    up = np.array([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)])
    north = np.array([-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)])
    return up, north, np.array([-np.sin(lon), np.cos(lon), 0.0 * lon])


def earth():
    """ECI and ECEF, the tangent plane of a place, and the local vertical frame of an aircraft."""
    figure, (ax,) = canvas(1, 7.6, 6.6)

    def ray(start, direction, colour, text, **style):
        vector(ax, globe(*direction)[:2], colour, text, globe(*start)[:2], **style)

    turn = np.linspace(0, 2 * np.pi, 241)
    ax.fill(np.cos(turn), np.sin(turn), facecolor="#9aa5b1", alpha=0.12)
    ax.plot(np.cos(turn), np.sin(turn), color=GRID, lw=1.0)
    for lat in range(-60, 90, 30):
        circle = local(np.radians(lat) * np.ones_like(turn), turn)[0]
        curve(ax, *circle, color=GRID, lw=1.0 if lat == 0 else 0.4)
    zero = np.zeros(3)
    sidereal = -30  # deg: the Earth has turned by this from x_I, eastwards
    for angle, colour, names, dashed in (
        (0, BODY, (r"$x_E$", r"$y_E$"), False),
        (sidereal, INERTIAL, (r"$x_I$", r"$y_I$"), True),
    ):
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        ray(zero, (1.6 * c, 1.6 * s, 0), colour, names[0], dashed=dashed, dy=-0.03)
        ray(zero, (-1.45 * s, 1.45 * c, 0), colour, names[1], dashed=dashed, dx=0.06)
    ray(zero, (0, 0, 1.5), BODY, r"$z_E = z_I$", dx=0.2)
    spin = np.radians(np.linspace(-60, 200, 60))
    u, v, _ = globe(0.2 * np.cos(spin), 0.2 * np.sin(spin), 1.28 * np.ones_like(spin))
    ax.plot(u, v, color=FORCE, lw=1.6)
    head(ax, (u[-4], v[-4]), (u[-1], v[-1]), FORCE)
    label(ax, -0.24, 1.25, r"$\omega_E$", FORCE, ha="right", fontsize=12)
    turned_by = np.radians(np.linspace(sidereal, 0, 40))
    x, y, z = local(0 * turned_by, turned_by)[0]
    curve(ax, 1.15 * x, 1.15 * y, z, color=INERTIAL, lw=1.4)
    u, v, _ = globe(1.3 * np.cos(turned_by[20]), 1.3 * np.sin(turned_by[20]), 0)
    label(ax, u, v - 0.02, r"$\omega_E t$", INERTIAL)
    lat, lon = np.radians(42), np.radians(50)
    up, north, east = local(lat, lon)
    for line in (up, [np.cos(lon), np.sin(lon), 0]):
        u, v, _ = globe(*(np.outer(line, [0, 1])))
        ax.plot(u, v, color=AIR, lw=1.2, ls="--")
    t = np.linspace(0, 1, 40)
    curve(ax, *local(0 * t, lon * t)[0], color=AIR, lw=2.4)
    curve(ax, *local(lat * t, lon)[0], color=AIR, lw=2.4)
    for x, y, z, text in (
        (1.1 * np.cos(lon / 2), 1.1 * np.sin(lon / 2), -0.07, "longitude"),
        (*local(lat / 2, lon)[0], "latitude"),
    ):
        u, v, _ = globe(x, y, z)
        right = text == "latitude"
        label(ax, u + 0.05 * right, v, text, AIR, ha="left" if right else "center")
    corners = [up + 0.36 * (i * north + j * east) for i, j in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
    u, v, _ = np.transpose([globe(*corner) for corner in corners])
    ax.fill(u, v, facecolor=EARTH, alpha=0.25, edgecolor=EARTH)
    label(ax, u[0] + 0.05, v[0] + 0.1, "tangent plane,\nfixed to a place", EARTH, ha="left")
    ax.plot(*globe(*up)[:2], "o", color=EARTH)
    up, north, east = local(np.radians(52), np.radians(-22))
    place = 1.12 * up
    ray(place, 0.42 * north, STABILITY, "N", dy=0.03)
    ray(place, 0.42 * east, STABILITY, "E", dx=0.05)
    ray(place, -0.35 * up, STABILITY, "D", dy=-0.02)
    u, v, _ = globe(*place)
    ax.plot(u, v, "o", color=STABILITY)
    text = "local vertical frame,\nmoves with the aircraft"
    label(ax, u - 0.12, v + 0.1, text, STABILITY, ha="right", va="bottom")
    ax.set(xlim=(-1.75, 1.75), ylim=(-1.2, 1.6))
    return figure


def climb():
    """Forces in a climb with body and wind axes, from the right; the side force from above."""
    figure, (ax, top) = canvas(2, 10.5, 5.2)
    gamma, alpha, beta = 14, 12, 18
    theta = gamma + alpha
    aircraft(ax, outline(theta, 0.85))
    ax.plot([-1.1, 1.9], [0, 0], color=GRID, lw=0.8, ls=":")
    ax.text(1.9, -0.09, "horizon", color=GRID, ha="right", va="center")
    arrow(ax, gamma, 1.8, AIR, r"$x_W$: V", dx=0.08)
    arrow(ax, gamma - 90, 0.8, AIR, r"$z_W$", dx=0.02)
    arrow(ax, theta, 1.5, BODY, r"$x_B$", dy=0.03)
    arrow(ax, theta - 90, 0.8, BODY, r"$z_B$", dx=0.05)
    arrow(ax, gamma + 90, 1.25, FORCE, "lift L")
    arrow(ax, gamma + 180, 1.3, FORCE, "drag D", dx=-0.03, dy=-0.08)
    arrow(ax, theta, 0.95, FORCE, "thrust T", dx=-0.3, dy=0.13)
    arrow(ax, -90, 1.3, FORCE, "weight W")
    arc(ax, 0, gamma, 1.55, r"$\gamma$", ink())
    arc(ax, gamma, theta, 1.25, r"$\alpha$", ink())
    aircraft(top, plan(90, 0.78))
    arrow(top, 90, 1.25, BODY, r"$x_B$")
    arrow(top, 0, 1.1, BODY, r"$y_B$", dx=0.04)
    arrow(top, 90 - beta, 1.25, AIR, r"$x_W$: V", dx=0.16)
    arrow(top, -beta, 1.1, AIR, r"$y_W$", dx=0.04)
    arrow(top, 270 - beta, 0.95, FORCE, "drag D", dx=-0.1, dy=-0.04)
    arrow(top, 180 - beta, 0.7, FORCE, "side force\nY < 0", dx=-0.45, dy=0.28)
    arc(top, 90 - beta, 90, 0.95, r"$\beta$", ink())
    ax.set(xlim=(-1.5, 2.1), ylim=(-1.55, 1.75))
    top.set(xlim=(-1.5, 1.6), ylim=(-1.55, 1.75))
    titled(ax, "from the right side", 0.2, 1.55)
    titled(top, "from above, in a sideslip", 0.05, 1.55)
    return figure


def flow():
    """From a model in XML to a figure and a track: the parts, and what passes between them."""
    figure, (ax,) = canvas(1, 9.5, 4.8)
    colours = {"file": STABILITY, "block": BODY, "result": EARTH}

    def box(x, y, title, text, kind, width=1.7, height=0.86):
        corner = (x - width / 2, y - height / 2)
        frame = FancyBboxPatch(corner, width, height, "round,pad=0.02,rounding_size=0.08")
        frame.set(facecolor=(*to_rgb(colours[kind]), 0.14), edgecolor=colours[kind], linewidth=1.4)
        ax.add_patch(frame)
        label(ax, x, y + 0.2, title, ink(), weight="bold")
        label(ax, x, y - 0.14, text, ink(), fontsize=9)

    def wire(*points, text="", at=(0, 0)):
        x, y = np.transpose(points)
        ax.plot(x[:-1], y[:-1], color=GRID, lw=1.6)
        head(ax, *points[-2:], GRID, lw=1.6, **WHOLE)
        label(ax, *at, text, ink(), fontsize=9)

    diagram = FancyBboxPatch((2.15, -1.72), 4.9, 3.6, "round,pad=0.02,rounding_size=0.1")
    diagram.set(facecolor="none", edgecolor=INERTIAL, linewidth=1.2, linestyle="--")
    ax.add_patch(diagram)
    ax.text(2.3, 1.68, "the diagram: a Simulation of PathSim", color=ink(), va="center")
    ax.plot([2.4, 6.8], [1.05, 1.05], color=AIR, lw=1.4)
    for x in np.linspace(2.4, 6.8, 23):
        tick = 0.16 if round((x - 2.4) / 0.2) % 4 == 0 else 0.08
        ax.plot([x, x], [1.05, 1.05 + tick], color=AIR, lw=1.4)
    ax.text(2.4, 1.35, r"PathSim's clock: $t_k = k\,T$", color=AIR, va="center", fontsize=9)
    for x in (3.5, 5.9):
        wire((x, 1.02), (x, 0.5))
    box(0.85, 1.1, "XML", "aircraft, engines,\nsystems", "file")
    box(0.85, -0.1, "Trim", "state and controls\nof the condition", "block")
    box(3.5, 0.02, "Aircraft", "sampled block: JSBSim\nadvances by $T$", "block", 2.0)
    box(5.9, 0.02, "PitchHold", "sampled block:\na control law", "block", 1.8)
    box(5.9, -1.2, "Scope", "records each step", "block", 1.8, 0.7)
    box(8.5, -1.2, "Figures", "time histories, tables", "result", 1.9, 0.7)
    box(8.5, -2.2, "Track", "KML, Tacview, HTML,\nFlightGear", "result", 1.9)
    box(8.5, 1.25, "PathView", "the same diagram\nin an editor", "result", 1.9)
    wire((0.85, 0.65), (0.85, 0.35))
    wire((1.72, -0.1), (2.48, -0.1))
    wire((4.52, 0.02), (4.98, 0.02), text=r"$\theta, q$", at=(4.75, 0.17))
    back = (6.4, 0.47), (6.4, 0.78), (3.0, 0.78), (3.0, 0.47)
    wire(*back, text="elevator increment", at=(4.7, 0.66))
    wire((3.9, -0.43), (3.9, -1.2), (4.98, -1.2), text="any signals", at=(4.4, -1.06))
    wire((6.82, -1.2), (7.53, -1.2))
    wire((3.1, -0.43), (3.1, -2.2), (7.53, -2.2), text="position, attitude", at=(5.0, -2.08))
    wire((7.09, 1.25), (7.53, 1.25))
    wire((7.53, 1.4), (7.09, 1.4))
    ax.set(xlim=(-0.1, 9.6), ylim=(-2.7, 2.0))
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
    dx, dz = turned(length, 0.0, angle)
    ax.plot([hinge[0], hinge[0] + dx], [hinge[1], hinge[1] + dz], color=FORCE, lw=4)
    where = hinge[0], hinge[1] + (0.38 if 0 < angle < 180 else -0.38)
    label(ax, *where, text, FORCE)


def moment(ax, centre, radius, begin, end):
    """A curved arrow about a centre, between two angles in deg."""
    angles = np.radians(np.linspace(begin, end, 40))
    x, y = centre[0] + radius * np.cos(angles), centre[1] + radius * np.sin(angles)
    ax.plot(x, y, color=BODY, lw=1.8)
    head(ax, (x[-3], y[-3]), (x[-1], y[-1]), BODY, lw=1.8)


def banked():
    figure, (ax, chart) = plt.subplots(
        1, 2, figsize=(9.5, 4.2), layout="constrained", width_ratios=(1.15, 1)
    )
    ax.set_aspect("equal")
    ax.axis("off")
    phi, lift = 35, 1.45
    weight = lift * np.cos(np.radians(phi))
    aircraft(ax, front(phi, 0.9))
    ax.plot([-1.4, 1.4], [0, 0], color=GRID, lw=0.8, ls=":")
    arrow(ax, 90 - phi, lift, FORCE, "lift L = n W", dx=0.3)
    arrow(ax, 90, weight, FORCE, r"$L\,\cos\phi_W$", dashed=True, dx=-0.3)
    aside = lift * np.sin(np.radians(phi))
    arrow(ax, 0, aside, FORCE, r"$L\,\sin\phi_W$", dashed=True, dx=0.16, dy=0.12)
    arrow(ax, -90, weight, FORCE, "weight W")
    arc(ax, 90 - phi, 90, 0.75, r"$\phi_W$", ink())
    # the tail of an arrow: the velocity leads away from the viewer
    ax.plot(0, 0, "o", color=AIR, mfc="none", ms=11, mew=1.6)
    ax.plot(0, 0, "x", color=AIR, ms=7, mew=1.6)
    ax.text(-0.16, -0.3, r"$V,\ x_W$", color=AIR, ha="right")
    ax.set(xlim=(-1.6, 1.7), ylim=(-1.45, 1.45))
    titled(ax, "along the velocity, in a turn to the right", 0, 1.4)
    angles = np.linspace(0, 70, 200)
    chart.plot(angles, 1 / np.cos(np.radians(angles)), color=BODY, lw=1.8)
    for angle in (30, 45, 60):
        n = 1 / np.cos(np.radians(angle))
        chart.plot(angle, n, "o", color=BODY)
        chart.text(angle - 2, n + 0.06, f"{n:.2f} g", color=ink(), ha="right")
    chart.set(
        xlabel=r"bank $\phi_W$ [deg]", ylabel="load factor n = L/W [g]", xlim=(0, 70), ylim=(1, 3)
    )
    chart.grid(alpha=0.4)
    return figure


# of the aircraft, in its XML
POINTS = {
    "aerodynamic reference point": "metrics/location[@name='AERORP']",
    "eye point": "metrics/location[@name='EYEPOINT']",
    "visual reference point": "metrics/location[@name='VRP']",
    "wheels": "ground_reactions/contact[@type='BOGEY']/location",
    "other contact points": "ground_reactions/contact[@type='STRUCTURE']/location",
    "tanks": "propulsion/tank/location",
    "point masses": "mass_balance/pointmass/location",
}
SEATS = ("pilot", "co-pilot", "left passenger", "right passenger", "baggage")
NEAR = {
    "centre of gravity": "CG",
    "empty-weight CG": "empty-weight CG",
    "visual reference point": "visual reference point",
}


def points():
    """The points of a Cessna 172, named, with the chord of its wing; around the CG, enlarged."""
    airframe = Airframe("c172p")
    airframe.run_ic()
    model = ET.parse(f"{jsbsim.get_default_root_dir()}/aircraft/c172p/c172p.xml")

    def in_model(path):  # in, structural axes
        return [tuple(float(at.findtext(i)) for i in "xyz") for at in model.iterfind(path)]

    found = {
        "empty-weight CG": in_model("mass_balance/location[@name='CG']"),
        "centre of gravity": [tuple(airframe.fdm[f"inertia/cg-{axis}-in"] for axis in "xyz")],
        **{kind: in_model(path) for kind, path in POINTS.items()},
    }
    chord = 12 * airframe.fdm["metrics/cbarw-ft"]
    figure, axes = plt.subplot_mosaic(
        [["side", "near"], ["top", "cabin"]],
        figsize=(9.5, 8.3),
        layout="constrained",
        height_ratios=(1, 4),  # the left panels have one scale: their width limits them
        width_ratios=(1, 1.75),
    )
    side, near, top, cabin = (axes[name] for name in ("side", "near", "top", "cabin"))
    (x0, _, z0), half = found["aerodynamic reference point"][0], found["other contact points"][3][1]
    wing = np.array([x0 - chord / 4, x0 + 3 * chord / 4])
    side.plot(wing, [z0, z0], color=GRID, lw=4, solid_capstyle="butt")
    side.text(wing[1] + 4, z0, "wing chord", color=GRID, va="center")
    for ax in (top, cabin):
        ax.fill(wing[[0, 1, 1, 0]], [-half, -half, half, half], facecolor="#9aa5b1", alpha=0.25)
    top.plot(wing, [0, 0], color=GRID, lw=4, solid_capstyle="butt")
    top.text(wing[1] + 4, 8, "root chord", color=GRID)
    colours = dict(zip(found, plt.rcParams["axes.prop_cycle"].by_key()["color"], strict=False))
    for (kind, places), marker in zip(found.items(), "oXs^vDP*p", strict=False):
        x, y, z = np.transpose(places)
        for ax, ordinate in ((side, z), (near, z), (top, y), (cabin, y)):
            ax.plot(x, ordinate, marker, color=colours[kind], markersize=7, label=kind)

    def name(ax, text, x, y, below=False):
        offset, side = (-9, "top") if below else (8, "bottom")
        place = {"textcoords": "offset points", "ha": "center", "va": side}
        ax.annotate(text, (x, y), (0, offset), fontsize=9, **place)

    for seat, (x, y, _) in zip(SEATS, found["point masses"], strict=True):
        name(cabin, seat, x, y, y < 0)
    name(side, "aerodynamic reference point", x0, z0)
    name(cabin, "aerodynamic reference point", x0, 0.0, below=True)
    for kind, text in NEAR.items():
        name(near, text, found[kind][0][0], found[kind][0][2])
    near.set(xlim=(40.2, 43.8), ylim=(35.8, 39.6), title="around the CG, from the left")
    near.set(xlabel="x [in]", ylabel="z [in]")
    cabin.set(xlim=(20, 112), ylim=(-34, 34), title="the cabin, from above")
    cabin.set(xlabel="x [in]", ylabel="y [in]", anchor="N")
    side.set(ylabel="z, up [in]", title="from the left side", xlim=(-50, 200), ylim=(-30, 95))
    top.set(ylabel="y, right [in]", xlabel="x, aft [in]", title="from above")
    top.set(xlim=(-50, 200), ylim=(-230, 230))
    for ax in (side, top, cabin):
        ax.set_aspect("equal")
    for ax in axes.values():
        ax.grid(alpha=0.4)
    handles, labels = top.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize="small")
    return figure


def main():
    for draw in (structural, wind, euler, earth, climb, banked, controls, points, flow):
        for style, suffix in (("default", ""), ("dark_background", "-dark")):
            with plt.style.context((style, SAME)):
                figure = draw()
                file = FOLDER / f"{draw.__name__}{suffix}.svg"
                figure.savefig(file, transparent=True, metadata={"Date": None})
                plt.close(figure)


if __name__ == "__main__":
    main()
