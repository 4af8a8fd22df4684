"""A JSBSim aircraft from DAVE-ML models of its aerodynamics, propulsion and inertia."""

from __future__ import annotations

import itertools
import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

from .._core.checks import as_path, did_you_mean, mapping, must_be, nearest, refuse
from .._core.files import write_whole
from ..errors import DaveMLError, FileError
from .mathml import BOOLEAN, LOGIC, OPERATORS, Expression
from .model import DaveModel, Variable
from .tables import Grid

_NAME = re.compile(r"[A-Za-z_][\w.-]*", re.ASCII)

_PROPERTY = re.compile(r"[A-Za-z_][\w.-]*(/[A-Za-z_][\w.-]*(\[\d+\])?)+", re.ASCII)

# JSBSim's properties of inputs by name (in small letters) and unit
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

# outputs by name, and their units
_ROTATIONS = {"Roll": "metrics/bw-ft", "Pitch": "metrics/cbarw-ft", "Yaw": "metrics/bw-ft"}
_COEFFICIENTS = {f"aeroBodyForceCoefficient_{x}": "nd" for x in "XYZ"}
_COEFFICIENTS |= {f"aeroBodyMomentCoefficient_{x}": "nd" for x in _ROTATIONS}
_THRUST = {f"thrustBodyForce_{x}": "lbf" for x in "XYZ"}
_THRUST |= {f"thrustBodyMoment_{x}": "ftlbf" for x in _ROTATIONS}
_SIZES = {"referenceWingArea": "ft2", "referenceWingSpan": "ft", "referenceWingChord": "ft"}
_MASS = {"totalMass": "slug"} | {f"bodyPositionOfCmWrtMrc_{x}": "ft" for x in "XYZ"}
_MASS |= {f"bodyMomentOfInertia_{x}": "slugft2" for x in _ROTATIONS}
_MASS |= {f"bodyProductOfInertia_{x}": "slugft2" for x in ("XY", "ZX", "YZ")}

# lb; by this JSBSim divides weights
_SLUG = 32.174049

_AIRCRAFT = """\
<fdm_config name="{name}" version="2.0" release="BETA">
<fileheader>
<description>Made by write_aircraft of pathsim-jsbsim-blocks from {files}</description>
</fileheader>
<metrics>
<wingarea unit="FT2">{referenceWingArea!r}</wingarea>
<wingspan unit="FT">{referenceWingSpan!r}</wingspan>
<chord unit="FT">{referenceWingChord!r}</chord>
<location name="AERORP" unit="IN"><x>0</x><y>0</y><z>0</z></location>
</metrics>
<mass_balance>
<ixx unit="SLUG*FT2">{bodyMomentOfInertia_Roll!r}</ixx>
<iyy unit="SLUG*FT2">{bodyMomentOfInertia_Pitch!r}</iyy>
<izz unit="SLUG*FT2">{bodyMomentOfInertia_Yaw!r}</izz>
<ixy unit="SLUG*FT2">{bodyProductOfInertia_XY!r}</ixy>
<ixz unit="SLUG*FT2">{bodyProductOfInertia_ZX!r}</ixz>
<iyz unit="SLUG*FT2">{bodyProductOfInertia_YZ!r}</iyz>
<emptywt unit="LBS">{weight!r}</emptywt>
<location name="CG" unit="IN">{centre}</location>
</mass_balance>
<ground_reactions/>
<external_reactions>{thrust}</external_reactions>
<aerodynamics>{aero}</aerodynamics>
</fdm_config>"""


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
        must_be("name", name, "letters, digits, _, . and -, the first a letter or _")
    air, mass, thrust = DaveModel(aero), DaveModel(inertia), ""
    engine = None if propulsion is None else DaveModel(propulsion)
    given = _given(properties, [air, *filter(None, [engine])])
    values = _constants(air, _SIZES) | _constants(mass, _MASS)
    forward, right, down = (values[f"bodyPositionOfCmWrtMrc_{x}"] for x in "XYZ")
    # in inches aft, to the right and up
    centre = f"<x>{-12 * forward!r}</x><y>{12 * right!r}</y><z>{-12 * down!r}</z>"
    if engine is not None:
        part = _Part(name, "propulsion", engine, given)
        thrust = "".join([*part.text, *_forces(part, centre)])
    part = _Part(name, "aero", air, given)
    weight = values["totalMass"] * _SLUG
    text = {"aero": "".join([*part.text, *_axes(part)]), "thrust": thrust, "centre": centre}
    text["files"] = escape(", ".join(Path(x).name for x in (aero, propulsion, inertia) if x))
    root = ET.fromstring(_AIRCRAFT.format(name=name, weight=weight, **text, **values))
    ET.indent(root)
    file = as_path("folder", folder) / "aircraft" / name / f"{name}.xml"
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n")
    except OSError as error:
        raise FileError("write", file, error) from None
    return file


def _given(properties: Any, models: Iterable[DaveModel]) -> dict[str, str]:
    """Properties of inputs, checked: JSBSim ends the process for a malformed name."""
    known, given = (
        {v.id for model in models for v in model.inputs},
        mapping("properties", properties),
    )
    for id, name in given.items():
        if id not in known:
            close = did_you_mean(nearest(id, known))
            refuse("properties", id, f"properties: none of the models has an input {id!r}{close}")
        if not isinstance(name, str) or not _PROPERTY.fullmatch(name):
            reason = f"properties[{id!r}] must be the name of a property, not {name!r}"
            refuse("properties", name, reason)
    return given


def _axes(part: _Part) -> Iterator[str]:
    for name, v in _outputs(part.model, _COEFFICIENTS).items():
        axis = name.rpartition("_")[2]
        factors = ["aero/qbar-psf", "metrics/Sw-sqft", *filter(None, [_ROTATIONS.get(axis)])]
        product = "".join(f"<p>{factor}</p>" for factor in factors)
        yield f'<axis name="{axis.upper()}"><function><product>{product}{part.leaves[v.id]}'
        yield "</product></function></axis>"


def _forces(part: _Part, centre: str) -> Iterator[str]:
    for name, v in _outputs(part.model, _THRUST).items():
        kind, unit = ("moment", "LBSFT") if v.units == "ftlbf" else ("force", "LBS")
        axis = {"Roll": "X", "Pitch": "Y", "Yaw": "Z"}.get(name.rpartition("_")[2], name[-1])
        direction = "".join(f"<{x.lower()}>{int(x == axis)}</{x.lower()}>" for x in "XYZ")
        yield f'<{kind} name="thrust-{kind}-{axis.lower()}" frame="BODY" unit="{unit}">'
        yield f"<function><sum>{part.leaves[v.id]}<value>0.0</value></sum></function>"
        yield f'<location unit="IN">{centre}</location><direction>{direction}</direction></{kind}>'


class _Part:
    """A model as functions of JSBSim: their XML, and what stands for each variable in others."""

    def __init__(self, aircraft: str, part: str, model: DaveModel, given: Mapping[str, str]):
        self.model = model
        self.leaves: dict[str, str] = {}
        self.text: list[str] = []
        for v in model.variables.values():
            if not _NAME.fullmatch(v.id):
                raise v.element.error("JSBSim has no properties of this name", v.id)
            content = self._content(v)
            if v.kind == "input":
                own = f"{aircraft}/{v.id}"
                name = given.get(v.id) or _INPUTS.get((v.name.lower(), v.units)) or own
                content = f"<p>{name}</p>"
                if name == own:
                    self.text.append(f'<property value="{v.initial or 0.0!r}">{own}</property>')
            if v.low > -math.inf:
                content = f"<max>{content}<value>{v.low!r}</value></max>"
            if v.high < math.inf:
                content = f"<min>{content}<value>{v.high!r}</value></min>"
            if not content.startswith(("<p>", "<value>")):
                function = f"{aircraft}/{part}/{v.id}"
                self.text.append(f'<function name="{function}">{content}</function>')
                content = f"<p>{function}</p>"
            self.leaves[v.id] = content

    def _content(self, v: Variable) -> str:
        try:
            return self._table(v) if v.kind == "table" else _xml(v.expression, self.leaves)
        except ValueError as error:
            raise v.element.error(f"{error}", v.id) from None

    def _table(self, v: Variable) -> str:
        table = v.table
        if not isinstance(table, Grid) or not all(axis.plain for axis in table.axes):
            raise ValueError("JSBSim's tables are gridded, linear and held at their ends")
        used = [i for i, axis in enumerate(table.axes) if len(axis.points) > 1]
        points = [table.axes[i].points for i in used]
        leaves = [self.leaves[v.arguments[i]] for i in used]
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


def _xml(expression: Expression, leaves: Mapping[str, str]) -> str:
    """An expression as a function of JSBSim."""
    kind, *arguments = expression
    if kind == "number":
        return f"<value>{arguments[0]!r}</value>"
    if kind == "variable":
        return leaves[arguments[0]]
    if kind == "piecewise":
        *parts, last = arguments
        if len(parts) % 2:
            raise ValueError("JSBSim's functions need an otherwise")
        xml = _xml(last, leaves)
        for value, when in zip(parts[-2::-2], parts[::-2], strict=True):
            xml = f"<ifthen>{_condition(when, leaves)}{_xml(value, leaves)}{xml}</ifthen>"
        return xml
    tag = OPERATORS[kind][3]
    if not tag:
        raise ValueError(f"JSBSim's functions lack {kind}")
    inner = _condition if kind in LOGIC else _xml
    return f"<{tag}>{''.join(inner(x, leaves) for x in arguments)}</{tag}>"


def _condition(expression: Expression, leaves: Mapping[str, str]) -> str:
    """An expression that is 0 or 1, as JSBSim demands of conditions."""
    if expression[0] not in BOOLEAN:
        expression = ("neq", expression, ("number", 0.0))
    return _xml(expression, leaves)


def _outputs(model: DaveModel, units: Mapping[str, str]) -> dict[str, Variable]:
    """The outputs by their standard names, in the units that JSBSim expects."""
    found = {v.name: v for v in model.variables.values() if v.name in units}
    for name, v in found.items():
        if v.units != units[name]:
            raise v.element.error(f"{name} is in {v.units!r}, not {units[name]}", v.id)
    return found


def _constants(model: DaveModel, units: Mapping[str, str]) -> dict[str, float]:
    """Outputs that are constants, or depend on inputs that have an initial value."""
    found = _outputs(model, units)
    evaluates = all(v.initial is not None for v in model.inputs)
    for name in units:
        if name not in found or not (evaluates or found[name].kind == "constant"):
            raise DaveMLError(f"needs {name}, as a constant", path=model.path)
    values = model.evaluate() if evaluates else {v.id: v.initial for v in found.values()}
    return {name: float(values[v.id]) for name, v in found.items()}  # type: ignore[arg-type]
