"""Draw the block diagrams of the course.

python docs/block_pictures.py
"""

from pathlib import Path

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt

FOLDER = Path(__file__).resolve().parent / "notebooks" / "figures"
# the same file for the same figure
matplotlib.rcParams["svg.hashsalt"] = "pathsim-jsbsim-blocks"

# readable on white and on black
WIRE, FILL, EDGE, INK = "#718096", "#e3edf8", "#2a78d6", "#16222e"
HEIGHT, RADIUS = 0.66, 0.19  # in
# pt; seven pixels on a telephone
TEXT, NAME = 12.5, 11

# of each picture: blocks as (x, y, text, name), one without a text adds; connections as a path from
# a block or point to another, with a label: (block, x, y) is a place on its edge, -1 left or below
PICTURES = {
    "aircraft": {
        "blocks": {
            "plane": (1.0, 0.0, "Aircraft", "plane"),
            "scope": (4.0, 0.0, "Scope", "scope"),
        },
        "wires": [("plane", "scope", r"$h,\ V,\ \theta,\ \phi,\ \psi$")],
    },
    "aileron_turn": {
        "blocks": {
            "step": (0.7, 0.0, "StepSource", "aileron"),
            "plane": (3.3, 0.0, "JSBSimFDM", "fdm"),
            "scope": (5.8, 0.0, "Scope", "scope"),
        },
        "wires": [
            ("step", "plane", r"$\delta_a$"),
            ("plane", "scope", r"$\phi,\ h,\ \psi$"),
        ],
    },
    "damped_oscillator": {
        "blocks": {
            "sum": (0.6, 0.0, "", "acceleration"),
            "v": (2.2, 0.0, r"$\int$", "velocity"),
            "x": (4.4, 0.0, r"$\int$", "position"),
            "scope": (6.8, 0.0, "Scope", "scope"),
            "d": (2.2, -1.15, r"$-2\,\zeta\,\omega_n$", "damping"),
            "k": (4.4, -2.05, r"$-\omega_n^2$", "stiffness"),
        },
        "wires": [
            ("sum", "v", r"$\ddot x$"),
            ("v", "x", r"$\dot x$"),
            ("x", "scope", r"$x$"),
            ("v", (3.3, 0.0), (3.3, -1.15), ("d", 1, 0)),
            (("d", -1, 0), (0.6, -1.15), ("sum", 0, -1)),
            ("x", (5.5, 0.0), (5.5, -2.05), ("k", 1, 0)),
            (("k", -1, 0), (0.1, -2.05), (0.1, 0.0), "sum"),
        ],
    },
    "step_response": {
        "blocks": {
            "step": (0.6, 0.0, "StepSource", "step"),
            "sum": (2.1, 0.0, "", "error"),
            "gain": (3.5, 0.0, r"$1/\tau$", "rate"),
            "y": (5.4, 0.0, r"$\int$", "lag"),
            "scope": (7.4, 0.0, "Scope", "scope"),
        },
        "wires": [
            ("step", "sum", r"$u$"),
            ("sum", "gain", ""),
            ("gain", "y", r"$\dot y$"),
            ("y", "scope", r"$y$"),
            ("y", (6.3, 0.0), (6.3, -0.95), (2.1, -0.95), ("sum", 0, -1), "-"),
        ],
    },
    "van_der_pol": {
        "blocks": {
            "f": (1.1, 0.0, r"$\mu(1 - x^2)\,v - x$", "acceleration"),
            "v": (3.6, 0.0, r"$\int$", "velocity"),
            "x": (5.8, 0.0, r"$\int$", "position"),
            "scope": (7.9, 0.0, "Scope", "scope"),
        },
        "wires": [
            ("f", "v", r"$\dot v$"),
            ("v", "x", r"$v$"),
            ("x", "scope", r"$x$"),
            ("v", (4.7, 0.0), (4.7, -0.85), (1.65, -0.85), ("f", 0.5, -1)),
            ("x", (6.9, 0.0), (6.9, -1.2), (0.55, -1.2), ("f", -0.5, -1)),
        ],
    },
    "elevator_doublet": {
        "blocks": {
            "doublet": (0.7, 0.0, "DoubletSource", "doublet"),
            "plane": (3.3, 0.0, "Aircraft", "plane"),
            "scope": (5.8, 0.0, "Scope", "scope"),
        },
        "wires": [
            ("doublet", "plane", r"$\Delta\delta_e$"),
            ("plane", "scope", r"$\alpha$"),
        ],
    },
    "pitch_hold": {
        "blocks": {
            "hold": (0.9, 0.0, "PitchHold", "hold"),
            "plane": (3.5, 0.0, "Aircraft", "plane"),
            "scope": (6.0, 0.0, "Scope", "scope"),
        },
        "wires": [
            ("hold", "plane", r"$\Delta\delta_e$"),
            ("plane", "scope", r"$\theta$"),
            ("plane", (4.7, 0.0), (4.7, -0.95), (-0.1, -0.95), (-0.1, 0.0), "hold"),
        ],
        "notes": [(2.3, -0.8, r"$\theta,\ q$")],
    },
    "pitch_loop": {
        "blocks": {
            "ref": (0.2, 0.0, "Constant", "reference"),
            "sum": (2.1, 0.0, "", "error"),
            "gain": (3.5, 0.0, r"$K$", "controller"),
            "plane": (5.6, 0.0, "Aircraft", "plane"),
            "scope": (7.7, 0.0, "Scope", "scope"),
        },
        "wires": [
            ("ref", "sum", r"$3\ \deg$"),
            ("sum", "gain", ""),
            ("gain", "plane", r"$\Delta\delta_e$"),
            ("plane", "scope", r"$\theta$"),
            ("plane", (6.6, 0.0), (6.6, -0.95), (2.1, -0.95), ("sum", 0, -1), "-"),
        ],
    },
    "isa_profile": {
        "blocks": {
            "h": (0.6, 0.0, "Source", "altitude"),
            "air": (3.0, 0.0, "ISAtmosphere", "air"),
            "scope": (5.6, 0.0, "Scope", "scope"),
        },
        "wires": [("h", "air", r"$h$"), ("air", "scope", r"$p,\ \rho,\ T,\ a$")],
    },
    "rudder_kick": {
        "blocks": {
            "a": (0.7, 0.52, "RampSource", "aileron"),
            "r": (0.7, -0.52, "RampSource", "rudder"),
            "plane": (3.4, 0.0, "Aircraft", "plane"),
            "scope": (5.9, 0.0, "Scope", "scope"),
        },
        "wires": [
            ("a", ("plane", -1, 0.55), r"$\Delta\delta_a$"),
            ("r", ("plane", -1, -0.55), r"$\Delta\delta_r$"),
            ("plane", "scope", r"$\beta,\ \phi,\ \psi$"),
        ],
    },
    "scheduled_climb": {
        "blocks": {
            "t": (0.9, 0.48, "LUT1D", "throttle"),
            "e": (0.9, -0.48, "LUT1D", "pitch_trim"),
            "plane": (3.6, 0.0, "JSBSimFDM", "fdm"),
            "scope": (6.1, 0.0, "Scope", "flight"),
        },
        "wires": [
            ("t", ("plane", -1, 0.55), r"$\delta_t(h)$"),
            ("e", ("plane", -1, -0.55), r"$\delta_p(h)$"),
            ("plane", "scope", r"$h,\ V,\ \gamma$"),
            ("plane", (4.6, 0.0), (4.6, -1.3), (-0.1, -1.3), (-0.1, -0.48), "e"),
            ((-0.1, -0.48), (-0.1, 0.48), "t"),
        ],
        "notes": [(2.4, -1.15, r"$h$")],
    },
    "constant_cas_climb": {
        "blocks": {
            "h": (0.5, 0.0, "Source", "altitude"),
            "cas": (2.8, 0.62, "CAStoTAS", "at_cas"),
            "mach": (2.8, -0.62, "MachtoTAS", "at_mach"),
            "min": (5.0, 0.0, "min", "tas"),
            "scope": (7.0, 0.0, "Scope", "speeds"),
        },
        "wires": [
            ("h", (1.6, 0.0), (1.6, 0.62), "cas"),
            ((1.6, 0.0), (1.6, -0.62), "mach"),
            ("cas", ("min", -1, 0.55), ""),
            ("mach", ("min", -1, -0.55), ""),
            ("min", "scope", "TAS"),
        ],
        "notes": [(1.36, 0.12, r"$h$")],
    },
}


def size(text):
    """Half the width and height of a block in inches."""
    if not text:
        return RADIUS, RADIUS
    return (2.2 if "x^2" in text else 1.1 if "$" in text else 1.5) / 2, HEIGHT / 2


def place(blocks, point, side):
    """Where a connection meets a block: in the middle of a side, or at a given place."""
    if isinstance(point, str):
        point = (point, side, 0.0)
    if len(point) == 2:
        return point
    x, y, text, _ = blocks[point[0]]
    half = size(text)
    return x + half[0] * point[1], y + half[1] * point[2]


def wire(ax, blocks, path):
    """An orthogonal line with an arrow at its end; its label stands over its first part."""
    *path, last = path
    text = last if isinstance(last, str) and last not in blocks else ""
    path = path if text or last == "" else [*path, last]
    points = [place(blocks, path[0], 1), *path[1:-1], place(blocks, path[-1], -1)]
    if len(points) == 2 and points[0][1] != points[1][1]:
        middle = (points[0][0] + points[1][0]) / 2
        points[1:1] = [(middle, points[0][1]), (middle, points[1][1])]
    ax.plot(*zip(*points, strict=True), color=WIRE, lw=1.5, solid_joinstyle="round", zorder=1)
    ax.annotate(
        "",
        xy=points[-1],
        xytext=points[-2],
        arrowprops={"arrowstyle": "-|>", "color": WIRE, "lw": 1.5, "shrinkA": 0, "shrinkB": 0},
    )
    if len(path) > 2 and isinstance(path[0], str):
        ax.plot(*points[1], "o", color=WIRE, ms=4)  # a branch
    if text == "-":
        x, y = points[-1]
        ax.text(x + 0.12, y - 0.12, "$-$", color=WIRE, ha="left", va="center", fontsize=TEXT)
    else:
        (x0, y0), (x1, _) = points[:2]
        ax.text((x0 + x1) / 2, y0 + 0.07, text, color=WIRE, ha="center", va="bottom", fontsize=TEXT)


def draw(picture):
    blocks = picture["blocks"]
    xs = [x + s * size(t)[0] for x, _, t, _ in blocks.values() for s in (-1, 1)]
    ys = [y + s * HEIGHT / 2 for _, y, _, _ in blocks.values() for s in (-1, 1)]
    turns = [p for w in picture["wires"] for p in w if isinstance(p, tuple) and len(p) == 2]
    xs, ys = xs + [p[0] for p in turns], ys + [p[1] for p in turns]
    left, right, low, high = min(xs) - 0.1, max(xs) + 0.1, min(ys) - 0.3, max(ys) + 0.1
    figure = plt.figure(figsize=(right - left, high - low))
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set(xlim=(left, right), ylim=(low, high))
    ax.axis("off")
    draw_on(ax, picture)
    return figure


def draw_on(ax, picture, points=TEXT):
    """Draw the blocks and connections of a picture in the units of its places."""
    blocks = picture["blocks"]
    for path in picture["wires"]:
        wire(ax, blocks, path)
    middle = {"color": INK, "ha": "center", "va": "center", "zorder": 4}
    for x, y, text, name in blocks.values():
        w, h = size(text)
        if text:
            shape = plt.Rectangle((x - w, y - h), 2 * w, 2 * h)
            ax.text(x, y, text, fontsize=points, **middle)
            place, va = y - (h + 0.05), "top"
        else:  # wires meet an adder from below
            shape = plt.Circle((x, y), w)
            ax.text(x, y, "+", fontsize=TEXT, **middle)
            place, va = y + h + 0.05, "bottom"
        shape.set(fc=FILL, ec=EDGE, lw=1.4, zorder=3)
        ax.add_patch(shape)
        ax.text(x, place, name, color=WIRE, ha="center", va=va, fontsize=NAME)
    for x, y, text in picture.get("notes", ()):
        ax.text(x, y, text, color=WIRE, ha="center", va="bottom", fontsize=TEXT)


def main():
    for name, picture in PICTURES.items():
        figure = draw(picture)
        figure.savefig(FOLDER / f"{name}.svg", transparent=True, metadata={"Date": None})
        plt.close(figure)


if __name__ == "__main__":
    main()
