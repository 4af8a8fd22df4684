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

# the flight, and properties that the script's events write
OUTPUTS = {outputs}

# a property among input_properties is left to the diagram
fdm = JSBSimFDM({parameters}
    output_properties=list(OUTPUTS),
)
DURATION = fdm.duration  # s, the script's own

scope = Scope(labels=list(OUTPUTS.values()))

sim = Simulation(
    [fdm, scope],
    [Connection(fdm[name], scope[i]) for i, name in enumerate(OUTPUTS)],
    dt=fdm.T,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(scope, title={title})


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    show(figure(), {stem})
'''


def diagram_of_script(script: str | Path, root: str | None = None) -> tuple[Path, str]:
    """The path of a JSBSim script, and the text of a diagram that flies it.

    ``script`` is a path or a name below the JSBSim root.
    """
    file = script_file(script, root)
    airframe = Airframe(file.aircraft, file.dt, root=root, start=file)
    names = [n for n in file.writes if airframe.has(n) and "r" in airframe.access(n)]
    names = [n for n in map(airframe.canonical, names) if not n.startswith("simulation/")]
    writes = {name: f"{name} [{unit_of(name) or '-'}]" for name in names if name not in _STATES}
    parameters = {"script": file.name(root)}
    if root is not None:
        parameters["JSBSim_path"] = str(Path(root).absolute())
    return file.path, _TEXT.format(
        name=file.path.name,
        aircraft=file.aircraft,
        outputs=_dict({**_STATES, **writes}),
        parameters="".join(f"\n    {name}={_text(x)}," for name, x in parameters.items()),
        title=_text(f"{file.aircraft}: {file.path.name}"),
        stem=_text(file.path.stem),
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
