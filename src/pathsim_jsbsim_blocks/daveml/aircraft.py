"""A JSBSim aircraft from DAVE-ML models of its aerodynamics, propulsion and inertia."""

from __future__ import annotations

import itertools
import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from .._core.checks import as_path, mapping, refuse
from .._core.files import write_whole
from ..errors import DaveMLError, FileError
from .mathml import BOOLEAN, LOGIC, OPERATORS, Expression
from .model import DaveModel, Variable
from .tables import Grid

_NAME = re.compile(r"[A-Za-z_][\w.-]*", re.ASCII)

# inputs by name (in small letters) and unit
_INPUTS = {
    ("trueairspeed", "ft_s"): "velocities/vt-fps",
    ("angleofattack", "deg"): "aero/alpha-deg",
    ("angleofattack", "rad"): "aero/alpha-rad",
    ("angleofsideslip", "deg"): "aero/beta-deg",
    ("angleofsideslip", "rad"): "aero/beta-rad",
    ("bodyangularrate_roll", "rad_s"): "velocities/p-aero-rad_sec",
    ("bodyangularrate_pitch", "rad_s"): "velocities/q-aero-rad_sec",
    ("bodyangularrate_yaw", "rad_s"): "velocities/r-aero-rad_sec",
    ("mach", "nd"): "velocities/mach",
    ("altitudemsl", "ft"): "position/h-sl-ft",
}

_ROTATIONS = ("Roll", "Pitch", "Yaw")
_LENGTHS = {"Roll": "metrics/bw-ft", "Pitch": "metrics/cbarw-ft", "Yaw": "metrics/bw-ft"}
_COEFFICIENTS = {
    **{f"aeroBodyForceCoefficient_{axis}": "nd" for axis in "XYZ"},
    **{f"aeroBodyMomentCoefficient_{axis}": "nd" for axis in _ROTATIONS},
}
_THRUST = {
    **{f"thrustBodyForce_{axis}": "lbf" for axis in "XYZ"},
    **{f"thrustBodyMoment_{axis}": "ftlbf" for axis in _ROTATIONS},
}
_METRICS = {
    "referenceWingArea": ("ft2", "wingarea"),
    "referenceWingSpan": ("ft", "wingspan"),
    "referenceWingChord": ("ft", "chord"),
}
_INERTIA = {
    "bodyMomentOfInertia_Roll": ("slugft2", "ixx"),
    "bodyMomentOfInertia_Pitch": ("slugft2", "iyy"),
    "bodyMomentOfInertia_Yaw": ("slugft2", "izz"),
    "bodyProductOfInertia_XY": ("slugft2", "ixy"),
    "bodyProductOfInertia_ZX": ("slugft2", "ixz"),
    "bodyProductOfInertia_YZ": ("slugft2", "iyz"),
}
_CENTRE = {f"bodyPositionOfCmWrtMrc_{axis}": "ft" for axis in "XYZ"}

# lb; by this JSBSim divides weights
_SLUG = 32.174049


def write_aircraft(
    name: str,
    *,
    aero: Any,
    inertia: Any,
    propulsion: Any = None,
    folder: Any,
    properties: Mapping[str, str] | None = None,
) -> Path:
    """Write a JSBSim aircraft from DAVE-ML models.

    Variables are recognised by the names of the standard, in feet, slugs, pounds and seconds.
    Aerodynamic coefficients act at the reference centre, thrust at the centre of mass. Each
    variable is a property ``NAME/aero/varID`` or ``NAME/propulsion/varID``. Inputs that JSBSim does
    not have, such as deflections and power, are properties ``NAME/varID`` that can be written.

    Parameters
    ----------
    name : str
        of the aircraft
    aero, inertia, propulsion : str or Path
        DAVE-ML files; the inertia is evaluated once, at the initial values of its inputs
    folder : str or Path
        JSBSim root directory, made if it is not there: ``root`` of `Aircraft`, ``JSBSim_path`` of
        `JSBSimFDM`. An aircraft of this name is replaced
    properties : dict, optional
        JSBSim's properties of inputs that have other names, by varID

    Returns
    -------
    Path
        the file, ``FOLDER/aircraft/NAME/NAME.xml``

    Raises
    ------
    FileError
        if a file cannot be read or written
    DaveMLError
        for a file that is malformed, lacks an output or has it in another unit, and for what
        JSBSim has no functions for, naming the variable
    ParameterError
        for a name that JSBSim would not accept
    """
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        refuse("name", name, f"name must be letters, digits, _, . and -, not {name!r}")
    given = mapping("properties", properties)
    air, mass = DaveModel(aero), DaveModel(inertia)
    parts = ["<external_reactions/>"]
    if propulsion is not None:
        part = _Part(name, "propulsion", DaveModel(propulsion), given)
        parts = ["<external_reactions>", *part.text, *_forces(part, mass), "</external_reactions>"]
    part = _Part(name, "aero", air, given)
    xml = "".join(
        [
            f'<fdm_config name="{name}" version="2.0" release="BETA"><fileheader><description>',
            "Made from DAVE-ML by write_aircraft of pathsim-jsbsim-blocks",
            "</description></fileheader>",
            *_metrics(air),
            *_mass(mass),
            "<ground_reactions/>",
            *parts,
            "<aerodynamics>",
            *part.text,
            *_axes(part),
            "</aerodynamics></fdm_config>",
        ]
    )
    root = ET.fromstring(xml)
    ET.indent(root)
    file = as_path("folder", folder) / "aircraft" / name / f"{name}.xml"
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n")
    except OSError as error:
        raise FileError("write", file, error) from None
    return file


def _metrics(air: DaveModel) -> Iterable[str]:
    sizes = _constants(air, {name: unit for name, (unit, _) in _METRICS.items()})
    yield "<metrics>"
    for name, (unit, tag) in _METRICS.items():
        yield f'<{tag} unit="{unit.upper()}">{sizes[name]!r}</{tag}>'
    for point in ("AERORP", "EYEPOINT", "VRP"):
        yield f'<location name="{point}" unit="IN"><x>0</x><y>0</y><z>0</z></location>'
    yield "</metrics>"


def _mass(mass: DaveModel) -> Iterable[str]:
    units = {name: unit for name, (unit, _) in _INERTIA.items()}
    values = _constants(mass, {**units, "totalMass": "slug"})
    yield "<mass_balance>"
    for name, (_, tag) in _INERTIA.items():
        yield f'<{tag} unit="SLUG*FT2">{values[name]!r}</{tag}>'
    yield f'<emptywt unit="LBS">{values["totalMass"] * _SLUG!r}</emptywt>'
    yield f'<location name="CG" unit="IN">{_centre(mass)}</location></mass_balance>'


def _centre(mass: DaveModel) -> str:
    """The centre of mass from the reference centre, x aft and z up."""
    forward, right, down = _constants(mass, _CENTRE).values()
    return f"<x>{-12 * forward!r}</x><y>{12 * right!r}</y><z>{-12 * down!r}</z>"


def _axes(part: _Part) -> Iterable[str]:
    for name, v in _outputs(part.model, _COEFFICIENTS).items():
        axis = name.rpartition("_")[2]
        factors = ["aero/qbar-psf", "metrics/Sw-sqft", *filter(None, [_LENGTHS.get(axis)])]
        product = "".join(f"<p>{factor}</p>" for factor in factors)
        yield f'<axis name="{axis.upper()}"><function><product>{product}{part.leaf(v)}</product>'
        yield "</function></axis>"


def _forces(part: _Part, mass: DaveModel) -> Iterable[str]:
    for name, v in _outputs(part.model, _THRUST).items():
        if v.kind == "constant" and not v.initial:
            continue
        axis = name.rpartition("_")[2]
        kind, unit = ("moment", "LBSFT") if axis in _ROTATIONS else ("force", "LBS")
        along = axis if kind == "force" else "XYZ"[_ROTATIONS.index(axis)]
        direction = "".join(f"<{x}>{int(x.upper() == along)}</{x}>" for x in "xyz")
        yield f'<{kind} name="thrust-{axis.lower()}" frame="BODY" unit="{unit}">'
        yield f"<function><sum>{part.leaf(v)}<value>0.0</value></sum></function>"
        yield f'<location unit="IN">{_centre(mass)}</location>'
        yield f"<direction>{direction}</direction></{kind}>"


class _Part:
    """A model as functions of JSBSim: the properties it declares, and the XML of its variables."""

    def __init__(self, aircraft: str, part: str, model: DaveModel, given: Mapping[str, str]):
        self.model = model
        self.text: list[str] = []
        self._leaves: dict[str, str] = {}
        functions: list[str] = []
        for v in model.variables.values():
            own = f"{aircraft}/{part}/{v.id}"
            if not _NAME.fullmatch(v.id):
                raise v.element.error("JSBSim has no properties of this name", v.id)
            limited = (v.low, v.high) != (-math.inf, math.inf)
            if v.kind == "constant":
                self._leaves[v.id] = f"<value>{self.model.constants[v.id]!r}</value>"
                continue
            if v.kind == "input":
                standard = _INPUTS.get((v.name.lower(), v.units))
                name = given.get(v.id) or standard or f"{aircraft}/{v.id}"
                content = f"<p>{name}</p>"
                if name not in _INPUTS.values() and v.id not in given:
                    self.text.append(f'<property value="{v.initial or 0.0!r}">{name}</property>')
            else:
                content = self._content(v)
            if v.kind == "input" and not limited:
                self._leaves[v.id] = content
                continue
            if limited:
                content = _limited(content, v.low, v.high)
            functions.append(f'<function name="{own}">{content}</function>')
            self._leaves[v.id] = f"<p>{own}</p>"
        self.text += functions

    def leaf(self, v: Variable) -> str:
        return self._leaves[v.id]

    def _content(self, v: Variable) -> str:
        try:
            return self._table(v) if v.kind == "table" else _xml(v.expression, self._leaves.get)
        except ValueError as error:
            raise v.element.error(f"{error}", v.id) from None

    def _table(self, v: Variable) -> str:
        table = v.table
        if not isinstance(table, Grid) or not all(axis.plain for axis in table.axes):
            raise ValueError("JSBSim's tables are gridded, linear and held at their ends")
        used = [i for i, axis in enumerate(table.axes) if len(axis.points) > 1]
        points = [table.axes[i].points for i in used]
        leaves = [self._leaves[v.arguments[i]] for i in used]
        if not used:
            return f"<value>{table.values[0]!r}</value>"
        if len(used) > 3 or any(not leaf.startswith("<p>") for leaf in leaves):
            raise ValueError("JSBSim's tables have up to three variables, and no constants")
        # from the slowest to the fastest
        lookups = (("row",), ("row", "column"), ("table", "row", "column"))[len(used) - 1]
        text = [
            f'<independentVar lookup="{lookup}">{leaf[3:-4]}</independentVar>'
            for lookup, leaf in zip(lookups, leaves, strict=True)
        ]
        columns = points[-1] if len(used) > 1 else []
        values = iter(table.values)
        for place in points[0] if len(used) == 3 else [None]:
            text.append("<tableData>" if place is None else f'<tableData breakPoint="{place!r}">')
            text += [_row(columns)] if columns else []
            for x in points[-2] if columns else points[0]:
                text.append(_row([x, *itertools.islice(values, len(columns) or 1)]))
            text.append("</tableData>")
        return "\n".join(["<table>", *text, "</table>"])


def _row(numbers: Iterable[float]) -> str:
    return " ".join(map(repr, numbers))


def _limited(content: str, low: float, high: float) -> str:
    if low > -math.inf:
        content = f"<max>{content}<value>{low!r}</value></max>"
    return f"<min>{content}<value>{high!r}</value></min>" if high < math.inf else content


def _xml(expression: Expression, leaf: Callable[[str], Any]) -> str:
    """An expression as a function of JSBSim."""
    kind, *arguments = expression
    if kind == "number":
        return f"<value>{arguments[0]!r}</value>"
    if kind == "variable":
        return leaf(arguments[0])
    if kind == "piecewise":
        *parts, last = arguments
        if len(parts) % 2:
            raise ValueError("JSBSim's functions need an otherwise")
        xml = _xml(last, leaf)
        for value, when in zip(parts[-2::-2], parts[::-2], strict=True):
            xml = f"<ifthen>{_condition(when, leaf)}{_xml(value, leaf)}{xml}</ifthen>"
        return xml
    tag = OPERATORS[kind][3]
    if not tag:
        raise ValueError(f"JSBSim's functions lack {kind}")
    inner = _condition if kind in LOGIC else _xml
    return f"<{tag}>{''.join(inner(x, leaf) for x in arguments)}</{tag}>"


def _condition(expression: Expression, leaf: Callable[[str], Any]) -> str:
    """An expression that is 0 or 1, as JSBSim demands of conditions."""
    if expression[0] not in BOOLEAN:
        expression = ("neq", expression, ("number", 0.0))
    return _xml(expression, leaf)


def _outputs(model: DaveModel, units: Mapping[str, str]) -> dict[str, Variable]:
    """The outputs by their standard names, in the units that JSBSim expects."""
    found = {v.name: v for v in model.variables.values() if v.name in units}
    for name, v in found.items():
        if v.units not in units[name].split():
            raise v.element.error(f"{name} is in {v.units!r}, not {units[name]}", v.id)
    return found


def _constants(model: DaveModel, units: Mapping[str, str]) -> dict[str, float]:
    """Outputs that do not depend on inputs, or only on those that have an initial value."""
    found = _outputs(model, units)
    values = model.constants
    if all(v.initial is not None for v in model.inputs):
        values = model.evaluate()
    for name in units:
        if name not in found or found[name].id not in values:
            raise DaveMLError(f"needs {name}, as a constant", path=model.path)
    return {name: values[found[name].id] for name in units}
