"""Make what is generated in the documentation: the gallery, its figures, the tables.

python docs/generate.py
python docs/generate.py PART ...    some of it: pages, modes, accuracy, fleet, diagrams, studies
"""

import argparse
import ast
import contextlib
import inspect
import io
import json
import os
import re
import runpy
import sys
import tempfile
import warnings
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from importlib.metadata import version
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("agg")

from fleet import fleet_table, level_or_glide, table_row
from layers import layers_picture
from pathsim.blocks import Block
from tables import (
    DOCS,
    EVIDENCE,
    markdown,
    measured,
    put,
    read_table,
    requirements_table,
    write_table,
)

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks import Aircraft, BlocksError, LinearisationError, TrimError
from pathsim_jsbsim_blocks.catalogue import (
    diagram_groups,
    diagram_names,
    diagram_notebook,
    find_diagram,
)
from pathsim_jsbsim_blocks.check_cases import CASES, compare, fly_case
from pathsim_jsbsim_blocks.cli.parser import _GROUPS as COMMAND_GROUPS
from pathsim_jsbsim_blocks.cli.parser import command_parser
from pathsim_jsbsim_blocks.flight import aircraft_names
from pathsim_jsbsim_blocks.plots import saving_to
from pathsim_jsbsim_blocks.studies import STUDIES

CHECK_CASES = """\
## NASA's check cases

[How they are compared](check-cases.md), [all distances](evidence/accuracy.md).

[![Distances of the 18 check cases](pictures/evidence_accuracy.png)](evidence/accuracy.md)
"""
PERFORMANCE = """\
## Performance charts

What an aircraft can do, on one page: `pathsim-jsbsim chart NAME --save NAME.pdf`.
[How to read it](performance.md), [the pages of the fleet](evidence/performance.md).

[![Performance charts of a c172p](pictures/performance_climb.png)](performance.md)
"""
GALLERY_INTRODUCTION = """\
# Gallery

Each diagram is a script and a model for PathView. `pathsim-jsbsim run NAME` flies it,
`pathsim-jsbsim view NAME` opens it in the editor.
"""


@contextlib.contextmanager
def drawing(name):
    """A folder to draw in: the figures in it that begin with a name become pictures."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        with contextlib.redirect_stdout(io.StringIO()):
            yield
        for figure in Path().glob(f"{name}*.png"):
            shrink(figure, DOCS / "pictures" / figure.name)
        os.chdir(DOCS)


def picture(name):
    """The figures of a diagram, as its script names them."""
    with drawing(name):
        script = runpy.run_path(str(find_diagram(name)), run_name="__main__")
        if not name.startswith("check_case_"):
            thumbnail(name, script["figure"]())


# of the gallery: the number of the panel that shows a diagram, if not the first one
PANEL = {
    "aileron_turn": 1,
    "elevator_doublet": 1,
    "gust_response": 1,
    "isa_profile": 2,
    "rudder_kick": 1,
    "scheduled_climb": 2,
    "trimmed_flight": 2,
}


def thumbnail(name, figure):
    """One panel of a figure without its axes, for the gallery: made for a width of 300 px."""
    from matplotlib import pyplot as plt

    panel = figure.axes[PANEL.get(name, 0)]
    small, ax = plt.subplots(figsize=(3, 2), layout="constrained")
    for collection in panel.collections:
        for path in collection.get_paths():
            ax.fill(*path.vertices.T, facecolor=collection.get_facecolor()[0])
    for line in panel.lines:
        style = {"color": line.get_color(), "linestyle": line.get_linestyle(), "linewidth": 2.2}
        marks = {"marker": line.get_marker(), "markevery": line.get_markevery()}
        ax.plot(*line.get_data(), **style, **marks)
    ax.set(xlim=panel.get_xlim(), ylim=panel.get_ylim(), aspect=panel.get_aspect())
    ax.tick_params(bottom=False, left=False, labelbottom=False, labelleft=False)
    ax.spines[:].set_color("0.8")
    small.savefig(DOCS / "pictures" / "thumbnails" / f"{name}.png", dpi=200)
    plt.close(small)
    plt.close(figure)


def page_picture(name):
    """The figures that the code of a page shows."""
    text = (DOCS / f"{name}.md").read_text(encoding="utf-8")
    code = "".join(re.findall(r"^```python\n(.*?)^```$", text, re.M | re.S))
    with drawing(name), saving_to(f"{name}.png"):
        exec(compile(code, f"{name}.md", "exec"), {})


def study_pictures():
    """The figure of each study."""
    for name, study in STUDIES.items():
        save(study.figure(study.table(progress=False)), f"study_{name}", dpi=100)


def save(figure, name, dpi=150, width=800):
    """Write a figure as a picture of the pages."""
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=dpi)
    shrink(drawn, DOCS / "pictures" / f"{name}.png", width)


def shrink(source, target, width=800):
    """Write a picture small enough for a README."""
    from PIL import Image

    with Image.open(source) as image:
        height = round(image.height * width / image.width)
        small = image.convert("RGB").resize((width, height), Image.Resampling.LANCZOS)
        # median cut, the default, loses colours of few pixels, such as that of a single mark
        small.quantize(128, Image.Quantize.FASTOCTREE).save(target, optimize=True)


def docstring(name):
    """Summary and text of a diagram's script."""
    text = ast.get_docstring(ast.parse(find_diagram(name).read_text(encoding="utf-8")))
    summary, _, rest = text.partition("\n")
    return summary, rest.strip()


def gallery():
    """A picture and a line for each diagram, by its folder."""
    *groups, cases = diagram_groups().values()
    parts = [GALLERY_INTRODUCTION]
    for title, names in zip(("From the published notebooks", "Beyond them"), groups, strict=True):
        cells = [gallery_cell(name) for name in names]
        cells += [""] * (-len(cells) % 3)
        rows = [cells[i : i + 3] for i in range(0, len(cells), 3)]
        parts.append(f"## {title}\n\n{markdown('| | | |', rows, '---')}\n")
    listed = "".join(f"- [`{n}`]{script_link(n)} {docstring(n)[0]}\n" for n in cases)
    return "\n".join(
        [*parts, f"{CHECK_CASES}\n<!-- check cases -->\n{listed}<!-- end -->\n", PERFORMANCE]
    )


def script_link(name):
    return f"(../diagrams/{find_diagram(name).parent.name}/{name}.py)"


def gallery_cell(name):
    link = script_link(name)
    notebook = diagram_notebook(name)
    source = f" (notebook {notebook})" if notebook else ""
    picture = f"[![{name}](pictures/thumbnails/{name}.png)]{link}"
    return f"{picture} [`{name}`]{link} {docstring(name)[0]}{source}"


def diagram_page(name):
    """The page of a diagram: what it shows, its figures, its model, its script."""
    summary, rest = docstring(name)
    summary = summary.replace("`", "")  # bold text has no code in it
    drawn = {file.stem for file in (DOCS / "pictures").glob(f"{name}*.png")}
    shown = [n for n in (name, f"{name}_track", f"{name}_troposphere") if n in drawn]
    # the diagram, and then what is inside its subsystems
    shown += sorted(n for n in drawn if n.startswith(f"{name}_pathview"))
    pictures = "\n\n".join(f".. image:: ../pictures/{n}.png" for n in shown)
    return f"""\
{name}
{"=" * len(name)}

**{summary}**

{rest}

.. code-block:: sh

   pathsim-jsbsim run {name} --save {name}.png
   pathsim-jsbsim view {name}

{pictures}

.. dropdown:: The script

   .. literalinclude:: ../../diagrams/{find_diagram(name).parent.name}/{name}.py
      :language: python
"""


def drawn_in_pathview():
    """The diagrams with a picture of their model: one of each kind of check case."""
    kinds = ("check_case_01", "check_case_13_3")
    return [n for n in diagram_names() if not n.startswith("check_case_") or n in kinds]


# of the table of blocks: folders or files of the package
SUBJECTS = {
    "Aircraft": ("flight", "linear", "daveml"),
    "Test inputs": ("sources",),
    "Air data and units": ("air", "units"),
    "Wind": ("wind",),
    "Control": ("control",),
    "Guidance and landing": ("guidance",),
    "Axes": ("axes",),
    "Recording": ("tracks",),
}


def commands_tables():
    """Each command of the package with its options, by the groups of its help."""
    parser = command_parser()
    (actions,) = (a for a in parser._actions if a.dest == argparse.SUPPRESS and a.choices)
    parts = []
    for group, names in COMMAND_GROUPS.items():
        rows = []
        for name in names:
            command = actions.choices[name]
            rows.append((f"**{name}**", command.description.rstrip(".")))
            for option in command._actions:
                if option.dest != "help" and option.help != argparse.SUPPRESS:
                    rows.append(option_row(option))
        title = f"{group[0].upper()}{group[1:]}"
        parts.append(f"### {title}\n\n{markdown('| command | |', rows, '---')}")
    return "\n\n".join(parts)


def option_row(option):
    """An option or argument of a command, as a row."""
    flag = max(option.option_strings, key=len, default="")
    words = [option.metavar] if isinstance(option.metavar, str) else option.metavar or ()
    if not words and option.nargs != 0 and not option.choices:
        words = [option.dest.upper()]
    text = (option.help or "").replace("|", "\\|").replace("\n", " ") % vars(option)
    if option.choices and not flag:
        words = [option.metavar or option.dest.upper()]
    return f"`{' '.join([flag, *map(str, words)]).strip()}`", text


def blocks_tables():
    """A line for each block, by subject: its docstring's first, and the file that has the rest."""
    subjects = {part: subject for subject, parts in SUBJECTS.items() for part in parts}
    rows = {subject: [] for subject in SUBJECTS}
    for name in sorted(package.__all__):
        block = getattr(package, name)
        if isinstance(block, type) and issubclass(block, Block):
            file = Path(inspect.getfile(block)).relative_to(DOCS.parent).as_posix()
            summary = inspect.getdoc(block).partition("\n")[0].replace("``", "`")
            subject = subjects[block.__module__.split(".")[1]]
            rows[subject].append((f"[`{name}`](../../{file})", summary))
    tables = (f"## {s}\n\n{markdown('| block | |', rows[s], '---')}\n" for s in SUBJECTS)
    return "\n".join(tables)


def fleet_page():
    """How every aircraft that jsbsim brings does in level flight or a glide: the table in words."""
    verdicts = {row["aircraft"]: row["verdict"] for row in read_table("fleet")}
    trims = sum(verdict.startswith("trims") for verdict in verdicts.values())
    glides = sum(verdict.startswith("glides") for verdict in verdicts.values())
    departs = sum("not steady" in verdict for verdict in verdicts.values())
    reasons = {}
    for name, verdict in verdicts.items():
        if not verdict.startswith(("trims", "glides")):
            reasons.setdefault(verdict.removeprefix("no trim: "), []).append(name)
    rows = ((why, ", ".join(names)) for why, names in reasons.items())
    table = markdown("| no flight | aircraft |", rows, "---")
    modes = (EVIDENCE / "fleet.md").read_text(encoding="utf-8").partition("\n## Modes\n")
    return (
        f"# The fleet\n\n{measured('fleet', 'fleet-modes')}\n\n"
        f"The {len(verdicts)} aircraft that jsbsim {version('jsbsim')} brings; "
        f"{trims} of them trim in level flight,\n{glides} in a glide with the throttle closed; "
        f"{departs} of these leave their path by more than 20 ft.\n"
        "[All of them](fleet.csv).\n\n"
        "Each is trimmed where `level_flight` of `pathsim_jsbsim_blocks.flight` finds it a "
        "condition (gear up where it\nretracts, fuel frozen), and flown for 30 s with its "
        "controls fixed; the "
        "drift is its height above the path then. A glide\nends in denser air, so it drifts too. "
        "The verdict names engines that run out of fuel in a flight of 60 s, fuel not frozen.\n\n"
        f"{table}\n" + "".join(modes[1:])
    )


# what the tables of the check cases put together
GROUPS = {
    "altitude": ("ft", ["altitude"]),
    "latitude, longitude": ("deg", ["latitude", "longitude"]),
    "true airspeed": ("kt", ["true airspeed"]),
    "attitude": ("deg", ["roll angle", "pitch angle", "heading"]),
    "rates": ("deg/s", ["roll rate", "pitch rate", "yaw rate"]),
}


# those of spheres and bricks, and those of the F-16
FALLS = [case for case in CASES if case <= 10]
F16 = [case for case in CASES if case > 10]


def check_cases(cases=FALLS, integrators="precise"):
    """The deviations of check cases, by quantity."""
    return {
        case: {d.quantity: d for d in compare(case, *fly_case(case, integrators=integrators))}
        for case in cases
    }


def worst(deviations, quantities):
    """Largest difference from simulator 05, with two digits; 0 for rounding."""
    largest = max(deviations[q].from_05 for q in quantities)
    return f"{largest:.2g}" if largest > 1e-12 else "0"


def cases_table(found):
    """One row for each check case: differences from simulator 05, and how much passes."""
    # the F-16's cases compare no rates
    groups = {n: g for n, g in GROUPS.items() if all(g[1][0] in ds for ds in found.values())}
    head = " | ".join(f"{name} [{unit}]" for name, (unit, _) in groups.items())
    rows = []
    for case, deviations in found.items():
        cells = [worst(deviations, quantities) for _, quantities in groups.values()]
        inside = sum(d.passes for d in deviations.values())
        rows.append((f"{case}", CASES[case], *cells, f"{inside} of {len(deviations)}"))
    return markdown(f"| | check case | {head} | pass |", rows, "---")


def ratios(found):
    """Distances and limits of each quantity of each case, and the larger ratio of the two."""
    for case, deviations in found.items():
        for d in deviations.values():
            row = {"case": f"{case:g}", "quantity": d.quantity, "unit": d.unit}
            for name in ("worst", "band", "from_05", "limit_05", "ratio"):
                number = getattr(d, name)
                row[name] = "" if number is None else f"{number:.3g}"
            yield row


def default_table():
    """The cases that do not pass with JSBSim's own integrators."""
    found = check_cases(integrators="default").items()
    return cases_table({n: ds for n, ds in found if not all(d.passes for d in ds.values())})


def doublet(hz, integrators):
    """Angle of attack and pitch angle of a c172p in an elevator doublet, at 30 Hz."""
    plane = Aircraft("c172p", altitude=5000, speed=90, T=1 / hz, integrators=integrators)
    u, ports = np.zeros((12 * hz, 4)), plane.output_port_labels
    u[hz : 2 * hz, 0], u[2 * hz : 3 * hz, 0] = 0.1, -0.1
    return flown(plane, u)[:: hz // 30, [ports["alpha"], ports["theta"]]]


def doublet_table():
    """Errors of both presets in a doublet, against 1920 Hz."""
    exact, rows = doublet(1920, "precise"), []
    for hz in (30, 60, 120, 480):
        default, precise = (
            np.abs(doublet(hz, preset) - exact).max(axis=0) for preset in ("default", "precise")
        )
        cells = [default[0], precise[0], default[1], precise[1]]
        rows.append((f"{hz} Hz", *(f"{x:.3f} deg" for x in cells)))
    head = "| rate | alpha, default | alpha, precise | theta, default | theta, precise |"
    return markdown(head, rows, "---")


def accuracy():
    """The tables of the check cases and of the integrators."""
    precise, f16 = check_cases(), check_cases(F16)
    write_table("accuracy", list(ratios({**precise, **f16})))
    page = EVIDENCE / "accuracy.md"
    put(page, "commit", measured("accuracy"))
    put(page, "check cases", cases_table(precise))
    put(page, "F-16", cases_table(f16))
    put(page, "check cases by default", default_table())
    put(page, "doublet", doublet_table())


CORES = (2, 64, 1000)


def scale_table():
    """What batches cost: `benchmarks/batches.json`, and what follows from it."""
    measured = json.loads((DOCS.parent / "benchmarks" / "batches.json").read_text(encoding="utf-8"))
    largest = measured["batches"][-1]
    of_one_core = largest["processor_s"] / largest["runs"]
    busy = largest["processor_s"] < 0.8 * largest["wall_s"] * measured["workers"]
    kB = 1e3 * largest["journal_MB"] / largest["runs"]
    rows = []
    for batch in measured["batches"]:
        cells = {cores: "" for cores in CORES} | {measured["workers"]: duration(batch["wall_s"])}
        rows.append((f"{batch['runs']:,}", *cells.values(), f"{batch['journal_MB']:.2g} MB"))
    for runs in (10**5, 10**7):
        times = [duration(measured["start_s"] + runs * of_one_core / cores) for cores in CORES]
        cells = f"{runs:,}", *times, f"{runs * kB / 1e3:,.0f} MB"
        rows.append([f"*{cell}*" for cell in cells])
    head = f"| flights | {' | '.join(f'{cores} cores' for cores in CORES)} | journal |"
    return (
        f"Measured on {measured['date']} with {measured['workers']} workers (joblib "
        f"{measured['joblib']}) on {measured['processor']},\nPython {measured['python']}, jsbsim "
        f"{measured['jsbsim']}, PathSim {measured['pathsim']}: {1 / of_one_core:.1f} flights per "
        f"second and core. A worker takes {measured['start_s']:.1f} s\nto start, and "
        f"{measured['worker_MB']} MB of memory.\n\n"
        f"{markdown(head, rows, first='--:')}\n\n"
        "Rows in italics are not measured: they follow from the processor time of the largest "
        "batch, with as many\nflights on each core."
        + " The machine was busy with other work: the measured times are too long."
        * busy
    )


def duration(seconds):
    for unit, size in (("days", 86400), ("h", 3600), ("min", 60)):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.{1 if seconds < 10 * size else 0}f} {unit}"
    return f"{seconds:.0f} s"


# what neither an even part nor the engine explains
REASONS = {
    "Camel": "Its roll damping falls by a tenth from 0 to 0.6 deg/s. Its pitch rate follows the "
    "elevator within four samples, in the model at once. Its airspeed responds to the throttle 50 "
    "times less than to the elevator"
}


def modes_table():
    """Write the natural modes of every aircraft that trims in level flight."""
    rows = []
    for name in aircraft_names():
        # a process for each: none must die
        with ProcessPoolExecutor(1) as pool:
            rows.append(pool.submit(modes_of, name).result())
    write_table("fleet-modes", rows)
    put(EVIDENCE / "fleet.md", "counts", modes_counts())


def modes_counts():
    """Which aircraft have no linear model, and which commands of the others are not linear."""
    notes = {row["aircraft"]: row["note"] for row in read_table("fleet-modes")}
    untrimmed = [name for name, note in notes.items() if note.startswith("no trim")]
    models = [row["aircraft"] for row in read_table("fleet-modes") if row["doublet error"]]
    without = [name for name in notes if name not in {*untrimmed, *models}]
    rows = [
        ("no level flight or glide", f"{len(untrimmed)}"),
        ("no linear model", ", ".join(without)),
    ]
    for inputs in (("elevator",), ("aileron", "rudder"), ("throttle",)):
        refused = re.compile(rf"to ({'|'.join(inputs)}) is not linear")
        names = [name for name in models if refused.search(notes[name])]
        rows.append((f"{' or '.join(inputs)} not linear", ", ".join(names)))
    return markdown("| | aircraft |", rows, "---")


# of linear-models.md: two aircraft without spools for comparison with the turbines
THROTTLES = ("c172p", "737", "global5000", "f16", "A4", "B747", "787-8", "MD11", "F4N", "Concorde")


def throttle_table():
    """Errors of the airspeed after doublets of the throttle that begin upwards and downwards."""
    rows = {row["aircraft"]: row for row in read_table("fleet-modes")}
    errors = [
        [f"{direction}wards first"]
        + [rows[name][f"vt, {direction} first"].rstrip("%") for name in THROTTLES]
        for direction in ("up", "down")
    ]
    return markdown(f"| | {' | '.join(THROTTLES)} |", errors)


def searches():
    """The row of trim.md: how many of the fleet each search trims."""
    rows = read_table("fleet")
    level = [row for row in rows if row["verdict"].startswith("trims")]
    jsbsim = sum(row["by JSBSim"] == "trims" for row in level)
    glides = sum(row["verdict"].startswith("glides") for row in rows)
    return (
        f"| [the {len(rows)} bundled models](evidence/fleet.md) | {jsbsim} in level flight; "
        f"glides are refused | {len(level)} in level flight, {glides} in a glide |"
    )


def modes_of(name):
    """The row of one aircraft: its modes, or the error that says why it has none."""
    try:
        return modes_row(name, level_or_glide(name))
    except BlocksError as error:
        reason = error.reason if isinstance(error, TrimError) else "it does not load"
        return {"aircraft": name, "note": f"no trim: {reason}"}


def modes_row(name, flight):
    glides = flight.condition.mode == "glide"
    inputs = ["elevator", "aileron", "rudder"] if glides else None
    plane = partial(Aircraft, name, condition=flight.condition, create=flight.create)
    try:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            model = plane().linear_model(inputs=inputs)
    except LinearisationError as error:
        return {"aircraft": name, "note": str(error).partition(": ")[2].replace("|", "/")}
    row = dict.fromkeys(("aircraft", "short period", "phugoid", "Dutch roll", "roll", "spiral"), "")
    row["aircraft"] = name
    for m in model.modes():
        if m.name in row:
            text = f"{m.frequency:.3g} / {m.damping:.2f}" if m.oscillatory else f"{m.pole.real:.3g}"
            row[m.name] += f", {text}" if row[m.name] else text
    errors, downwards = (doublet_errors(plane, model, size) for size in (0.01, -0.01))
    in_vt = [e.pop("vt", None) for e in (errors, downwards)]
    where = max(errors, key=errors.get)
    remark = "; ".join(
        str(w.message).partition(": ")[2].partition(". ")[0]
        for w in said
        if "not linear" in str(w.message)
    )
    if name in REASONS:
        remark += f". {REASONS[name]}"
    row["doublet error"] = f"{errors[where]:.1%} ({where})"
    for direction, error in zip(("up", "down"), in_vt, strict=True):
        row[f"vt, {direction} first"] = "" if error is None else f"{error:.1%}"
    return row | {"note": remark}


def doublet_errors(plane, model, size):
    """The relative rms errors of what each command is for, after a doublet."""
    still, errors = flown(plane(), np.zeros((1200, 4))), {}
    purposes = (("theta", "q"), ("phi", "p"), ("beta", "r"), ("vt",))
    for port, outputs in enumerate(purposes[: len(model.inputs)]):
        u = np.zeros((1200, 4))
        u[3:123, port], u[123:243, port] = size, -size
        response = flown(plane(), u) - still
        predicted = model.simulate(u[:, : len(model.inputs)]) - model.y0
        for output in outputs:
            i = model.outputs.index(output)
            missed = ((response - predicted)[:, i] ** 2).mean()
            errors[output] = (missed / (response[:, i] ** 2).mean()) ** 0.5
    return errors


def flown(plane, u):
    """The outputs at the trim, and after each row of commands in still air."""
    y = [plane.outputs.to_array()]
    wind = [0.0] * 3
    return np.array(y + [plane.advance(k, row + wind) for k, row in enumerate(u.tolist(), 1)])


def write_pages():
    """Quick to write: the gallery, the table of blocks, and what stands in tables elsewhere."""
    put(DOCS / "monte-carlo.md", "batches", scale_table())
    put(DOCS / "linear-models.md", "throttles", throttle_table())
    put(EVIDENCE / "designed-gains.md", "requirements", requirements_table())
    (DOCS / "pictures" / "layers.svg").write_text(layers_picture(), encoding="utf-8")
    (DOCS / "gallery.md").write_text(gallery(), encoding="utf-8")
    put(DOCS / "reference" / "blocks.md", "blocks", blocks_tables())
    put(DOCS / "command-line.md", "commands", commands_tables())


def fleet():
    write_table("fleet", [table_row(row) for row in fleet_table()])
    (EVIDENCE / "fleet.md").write_text(fleet_page(), encoding="utf-8")


def diagram_pictures():
    for name in diagram_names():
        picture(name)


def other_pictures():
    for name in ("landing", "linear-models", "studies", "tutorial"):
        page_picture(name)
    study_pictures()


PARTS = {
    "pages": write_pages,
    "modes": modes_table,
    "accuracy": accuracy,
    "fleet": fleet,
    "diagrams": diagram_pictures,
    "studies": other_pictures,
}


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "agg")
    for part in sys.argv[1:] or PARTS:
        PARTS[part]()
