"""Draw the first picture of the README: a diagram, the flight of its aircraft, and its height.

python docs/hero.py
"""

import matplotlib.pyplot as plt
import numpy as np
from block_pictures import draw_on
from generate import save
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from pymap3d import geodetic2ned

from pathsim_jsbsim_blocks import fly
from pathsim_jsbsim_blocks.axes import body_to_ned
from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.tracks.recording import recorded_flights, tracks
from pathsim_jsbsim_blocks.tracks.track import POSITION

FOOT = 0.3048  # m
# axes of the flight: east, north, up; the height is drawn four times as large as the distance
LOW, HIGH = np.array([-11500.0, -1300.0, 0.0]), np.array([2500.0, 800.0, 700.0])
BOX = np.array([14.0, 3.6, 4.6])
SIZE = 0.9  # nose to tail in the units of BOX, so that the attitude can be seen
INSTANTS = (4, 25, 45, 65, 84, 100)  # s

DIAGRAM = {
    "blocks": {
        "loc": (0.9, 1.1, "Localizer", ""),
        "gs": (0.9, 0.0, "Glideslope", ""),
        "lat": (3.2, 1.1, "LocalizerHold", ""),
        "vert": (3.2, 0.0, "GlideslopeHold", ""),
        "vc": (3.2, -1.1, "AirspeedHold", ""),
        "flare": (5.5, 0.0, "FlareHold", ""),
        "plane": (7.8, 0.0, "Aircraft", ""),
    },
    "wires": [
        ("loc", "lat", ""),
        ("gs", "vert", ""),
        ("lat", ("flare", -1, 0.6), ""),
        ("vert", "flare", ""),
        ("vc", ("flare", -1, -0.6), ""),
        ("flare", "plane", ""),
        ("plane", (8.8, 0.0), (8.8, -2.0), (-0.2, -2.0), (-0.2, 0.0), "gs"),
        ((-0.2, 0.0), (-0.2, 1.1), "loc"),
        ((-0.2, -1.1), "vc"),
    ],
    "notes": [(4.3, -1.9, "position, attitude, rates, airspeed, height")],
}

# outline of an aircraft in its body axes: forward, right, down; nose to tail is 1
FUSELAGE = [(0.5, 0, 0), (0.3, 0.06, 0), (-0.5, 0.01, 0), (-0.5, -0.01, 0), (0.3, -0.06, 0)]
WING = [(0.22, 0, -0.03), (0.17, 0.65, -0.06), (0.03, 0.65, -0.06), (0.03, 0, -0.03),
        (0.03, -0.65, -0.06), (0.17, -0.65, -0.06)]  # fmt: skip
TAIL = [(-0.36, 0, 0), (-0.4, 0.22, 0), (-0.5, 0.22, 0), (-0.5, -0.22, 0), (-0.4, -0.22, 0)]
FIN = [(-0.32, 0, 0), (-0.44, 0, -0.24), (-0.5, 0, -0.24), (-0.5, 0, 0)]


def flight():
    """The track of the diagram: time, place north, east and above the runway in ft, attitude."""
    with recorded_flights() as recordings:
        diagram = load_diagram("autoland_c172p")
        fly(diagram.sim, diagram.DURATION, progress=False)
    (flown,) = tracks(recordings)
    names = {label: name for name, label in POSITION.items()}
    track = flown.to_frame().reset_index(names="time").rename(columns=names)
    north, east, down = geodetic2ned(
        track.lat, track.lon, track.h * FOOT, *diagram.AIM, diagram.ELEVATION * FOOT
    )
    return track.assign(north=north / FOOT, east=east / FOOT, up=-down / FOOT)


def to_earth(points, row):
    """Points of the body in ft east, north and up of the runway, by the 3-2-1 angles."""
    axes = np.transpose(points).astype(float)
    north, east, down = body_to_ned(*axes, row.phi, row.theta, row.psi)
    # undistorted on the axes, whose scales differ
    offset = SIZE * np.array([east, north, -down]).T * (HIGH - LOW) / BOX
    return np.array([row.east, row.north, row.up]) + offset


def draw_flight(ax, track):
    ax.plot(track.east, track.north, track.up, color="tab:blue", lw=1.6)
    ax.plot(track.east, track.north, 0.0, color="0.7", lw=1.0)
    runway = [(-300, -60, 0), (2500, -60, 0), (2500, 60, 0), (-300, 60, 0)]
    ax.add_collection3d(Poly3DCollection([runway], facecolor="0.45", edgecolor="0.3"))
    for t in INSTANTS:
        row = track.iloc[(track.time - t).abs().argmin()]
        ax.plot(2 * [row.east], 2 * [row.north], [0.0, row.up], color="0.7", lw=0.7)
        parts = [to_earth(part, row) for part in (FUSELAGE, WING, TAIL, FIN)]
        colour = {"facecolor": "tab:orange", "edgecolor": "#803c00", "linewidth": 0.6}
        ax.add_collection3d(Poly3DCollection(parts, **colour))
    ax.set_box_aspect(BOX, zoom=1.13)
    ax.set(**{f"{x}lim": ends for x, ends in zip("xyz", zip(LOW, HIGH, strict=True), strict=True)})
    ax.view_init(20, -72)
    ax.set_axis_off()


def hero():
    """The diagram on the left, the flight on the right, the height above the runway below."""
    track = flight()
    figure = plt.figure(figsize=(14, 5.0))
    left = figure.add_axes((0.005, 0.06, 0.44, 0.88))
    left.set(xlim=(-0.3, 9.0), ylim=(-2.2, 1.7), aspect="equal")
    left.axis("off")
    draw_on(left, DIAGRAM, points=9.5)
    # a square, to which Matplotlib clips
    draw_flight(figure.add_axes((0.445, -0.11, 0.56, 1.6), projection="3d"), track)
    below = figure.add_axes((0.52, 0.12, 0.46, 0.17))
    below.plot(track.time, track.up, color="tab:blue")
    at = [track.iloc[(track.time - t).abs().argmin()] for t in INSTANTS]
    below.plot([r.time for r in at], [r.up for r in at], "o", color="tab:orange")
    below.set(xlabel="time [s]", ylabel="height [ft]", xlim=(0, track.time.iloc[-1]))
    below.grid(alpha=0.3)
    below.spines[["top", "right"]].set_visible(False)
    return figure


if __name__ == "__main__":
    save(hero(), "hero", width=1600)
