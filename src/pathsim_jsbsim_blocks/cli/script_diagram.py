"""A JSBSim script as the text of a diagram that flies it: the beginning of one's own."""

from __future__ import annotations

import contextlib
import json
import logging
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from ..flight.airframe import Airframe
from ..flight.channels import unit_of
from ..flight.console import log
from ..flight.script import script_file

_STATES = {
    "position/h-sl-ft": "altitude [ft]",
    "velocities/vc-kts": "airspeed [kt]",
    "aero/alpha-deg": "angle of attack [deg]",
    "aero/beta-deg": "sideslip angle [deg]",
    "attitude/theta-deg": "pitch angle [deg]",
    "attitude/phi-deg": "roll angle [deg]",
    "attitude/psi-deg": "heading [deg]",
}

_TEXT = '''"""The JSBSim script {name}, which flies the aircraft {aircraft}."""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import JSBSimFDM

STATES = {states}
# written by the script's events; a property among input_properties is left to the diagram
COMMANDS = {commands}

fdm = JSBSimFDM({parameters}
    output_properties=[*STATES, *COMMANDS],
)
DURATION = fdm.duration  # s, the script's own

states = Scope(labels=list(STATES.values()))
commands = Scope(labels=list(COMMANDS.values()))

sim = Simulation(
    [fdm, states, commands],
    [
        *(Connection(fdm[name], states[i]) for i, name in enumerate(STATES)),
        *(Connection(fdm[name], commands[i]) for i, name in enumerate(COMMANDS)),
    ],
    dt=fdm.T,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(states, title={title})


def figure_commands():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(commands, title={title_of_commands})


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    show(figure(), {stem})
    show(figure_commands(), {stem_of_commands})
'''


def diagram_of_script(script: str | Path, root: str | None = None) -> tuple[Path, str]:
    """The path of a JSBSim script, and the text of a diagram that flies it.

    ``script`` is a path or a name below the JSBSim root.
    """
    file = script_file(script, root)
    airframe = Airframe(file.aircraft, file.dt, root=root, start=file)
    names = [n for n in file.writes if airframe.has(n) and "r" in airframe.access(n)]
    names = [n for n in map(airframe.canonical, names) if not n.startswith("simulation/")]
    units = {name: unit_of(name) or "-" for name in names if name not in _STATES}
    commands = {name: f"{name} [{unit}]" for name, unit in units.items()}
    parameters = {"script": file.name(root)}
    if root is not None:
        parameters["JSBSim_path"] = str(Path(root).absolute())
    title, stem = f"{file.aircraft}: {file.path.name}", file.path.stem
    return file.path, _TEXT.format(
        name=file.path.name,
        aircraft=file.aircraft,
        states=_dict(_STATES),
        commands=_dict(commands or {"simulation/sim-time-sec": "time of the script [s]"}),
        parameters="".join(f"\n    {name}={_text(x)}," for name, x in parameters.items()),
        title=_text(title),
        title_of_commands=_text(f"{title}, written by its events"),
        stem=_text(stem),
        stem_of_commands=_text(f"{stem}_commands"),
    )


def _dict(values: Mapping[str, str]) -> str:
    return "{\n" + "".join(f"    {_text(n)}: {_text(v)},\n" for n, v in values.items()) + "}"


def _text(value: str) -> str:
    """A text in Python, in double quotes."""
    return json.dumps(value, ensure_ascii=False)


@contextlib.contextmanager
def printed_notices() -> Iterator[None]:
    """Context in which the notices of scripts are printed as they come."""
    handler, level = logging.StreamHandler(sys.stdout), log.level
    handler.addFilter(lambda record: " executed at time: " in record.getMessage())
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)
