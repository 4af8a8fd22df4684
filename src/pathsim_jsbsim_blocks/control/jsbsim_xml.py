"""Sampled laws as JSBSim XML: a ``<system>`` that computes what the block computes, bit for bit.

The law is traced as expressions of `signals`, which become functions of JSBSim. These run at the
start of a frame, before the control system, when JSBSim has moved the aircraft but not yet computed
its airspeed and angles of attack and sideslip: the others are those of the frame before, so that
all are of one instant.
"""

from __future__ import annotations

import inspect
import re
import xml.etree.ElementTree as ET
from collections.abc import Collection, Sequence
from typing import Any

from .._core.aircraft_ports import ALMOST_NORTH, OUTPUTS, SHORT_INPUTS, SHORT_OUTPUTS, SURFACES
from .._core.checks import must_be, one_of, whole
from .gains import GainSchedule
from .signals import (
    Operations,
    Signal,
    flat,
    larger,
    limit,
    nested,
    operations,
    select,
    smaller,
)

ROOT = "ap/pathsim"  # of the properties

_MEASURED = {port: (name, factor) for port, (name, factor) in OUTPUTS.items() if name}
_MEASURED |= {"h_agl": (SHORT_OUTPUTS["h_agl"][0], 1.0), "wow": ("gear/wow", 1.0)}
# what JSBSim computes after its control system
_LATE = re.compile(r"aero/|accelerations/|flight-path/|gear/|velocities/(vc|vt|mach)")
_EXCESS = {"elev_sat": "elevator", "ail_sat": "aileron", "rud_sat": "rudder", "thr_sat": "throttle"}
_UNITS = {"p": "deg_sec", "q": "deg_sec", "r": "deg_sec", "chi": "deg"}
_UNITS |= dict.fromkeys(("across", "to_go", "dist", "gs_dist", "loc_dist"), "ft")
_UNITS |= dict.fromkeys((*SURFACES, "throttle", "brakes", "steering"), "norm")
_WHOLE = 1e-3  # of the frames in a period, for time steps such as 0.0083333 s
_WIDTH = 90  # of lines
_LARGEST = 1e300  # stands for infinity, which JSBSim does not read

_TAGS = {
    **{"add": "sum", "sub": "difference", "mul": "product", "truediv": "quotient", "ne": "nq"},
    **{"select": "ifthen", "smaller": "min", "larger": "max"},
    **{name: name for name in ("pow", "lt", "le", "gt", "ge", "eq", "and", "or", "abs")},
    **{name: name for name in ("acos", "atan", "cos", "exp", "sin", "integer")},
}


def _tag(name: str, *operands: ET.Element) -> ET.Element:
    element = ET.Element(name)
    if name in ("sum", "difference", "product") and operands[0].tag == name:
        # these take any number, from left to right
        operands = (*operands[0], *operands[1:])
    element.extend(operands)
    return element


def _leaf(name: str, text: str) -> ET.Element:
    element = ET.Element(name)
    element.text = text
    return element


def _v(number: str) -> ET.Element:
    value = float({"True": 1.0, "False": 0.0}.get(number, number))
    return _leaf("v", repr(min(max(value, -_LARGEST), _LARGEST)))


def _operation(name: str, operands: Sequence[ET.Element]) -> ET.Element:
    """An operation of `signals`."""
    if name in _TAGS:
        return _tag(_TAGS[name], *operands)
    if name == "neg":
        return _tag("product", _v("-1.0"), *operands)
    if name == "limit":
        x, low, high = operands
        return _tag("min", _tag("max", x, low), high)
    if name == "expm1":
        return _tag("difference", _tag("exp", *operands), _v("1.0"))
    if name == "mod":
        # of a positive divisor; C's has the sign of the dividend
        rest = _tag("fmod", *operands)
        negative = _tag("lt", rest, _v("0.0"))
        return _tag("ifthen", negative, _tag("sum", rest, operands[1]), rest)
    raise NotImplementedError(f"{name} in JSBSim XML")


def _names(state: Any) -> list[str]:
    """Names of the values in a state, from the fields of its named tuples."""
    names = []
    for name, part in zip(getattr(state, "_fields", range(len(state))), state, strict=True):
        names += [f"{name}-{x}" for x in _names(part)] if isinstance(part, tuple) else [str(name)]
    return names


def _lines(element: ET.Element) -> list[str]:
    """An element as indented lines; no text in it needs escaping."""
    attributes = "".join(f' {name}="{value}"' for name, value in element.items())
    start, end = f"<{element.tag}{attributes}>", f"</{element.tag}>"
    inner = [line for child in element for line in _lines(child)]
    text = element.text or ""
    if len(one := " ".join([start, *inner, end]) if inner else f"{start}{text}{end}") <= _WIDTH:
        return [one]
    return [start, *(f"  {line}" for line in inner or text.splitlines()), end]


def _documented(block: Any, section: str) -> dict[str, str]:
    """What a block's docstring says of its ports."""
    _, _, text = (inspect.getdoc(type(block)) or "").partition(f"\n{section}\n---")
    entries = re.findall(r"^(\w[\w, ]*)\n((?: +.*\n)+)", text.partition("\n\n")[0] + "\n", re.M)
    return {
        port: re.sub(r"``|\*\*|-(?=-)", "", " ".join(about.split()))
        for ports, about in entries
        for port in ports.split(", ")
    }


def _property_of(port: str) -> str:
    """A port's name with dashes and its unit."""
    name = port.replace("_", "-")
    quantity = re.sub("_(ref|cmd)$", "", port)
    unit = _UNITS.get(quantity, "")
    if quantity in _MEASURED and not unit:
        unit = _MEASURED[quantity][0].rpartition("-")[2]
    return f"{name}-{unit}" if unit and "/" not in unit and not name.endswith(unit) else name


class _System:
    """The ``<system>`` of a block, with the parameters of `system`."""

    def __init__(self, block: Any, name: str, engines: int, unwired: Collection[str]):
        self.block, self.base, self.engines = block, f"{ROOT}/{name}", engines
        self.unwired = unwired
        self.inputs, self.outputs = list(block.input_port_labels), list(block.output_port_labels)
        self.declared: list[ET.Element] = []
        self.functions: list[ET.Element] = []
        self.about: list[str] = []
        self.engaged = self.property("engaged", about="1 engages, 0 leaves the commands alone")
        why = "1 while engaged, unless JSBSim's time step does not divide T"
        self.active = self.property("active", about=why)
        self.frames, self.frame, self.sampling = map(self.property, ("frames", "frame", "sampling"))

    def property(self, name: str, value: float = 0.0, about: str = "") -> Any:
        """Declare a property; ``about`` documents it in the header."""
        path = f"{self.base}/{name}"
        self.declared.append(_leaf("property", path))
        self.declared[-1].set("value", repr(float(value)))
        if about:
            self.about.append(f"  {path}\n      {about}")
        return Signal(path)

    def put(self, to: Signal, value: Any) -> None:
        """Compute a property in every frame, after those before it."""
        self.write(to.operation, *self.rendered(operations([value])))

    def write(self, path: str, expression: ET.Element) -> None:
        function = ET.Element("function", copyto=path)
        function.append(expression)
        self.functions.append(function)

    def rendered(self, found: Operations) -> list[ET.Element]:
        """The results; operations that are used several times become properties."""
        uses = found.uses(twice=("mod",))
        texts: dict[str, ET.Element] = {}

        def operand(name: str) -> ET.Element:
            return texts[name] if name in texts else _v(name)

        for result, (operation, *operands) in found.steps.items():
            if not operands:
                texts[result] = _leaf("p", operation)
                continue
            texts[result] = _operation(operation, [operand(x) for x in operands])
            if uses[result] > 1:
                path = self.property(f"law/t{len(self.functions)}").operation
                self.write(path, texts[result])
                texts[result] = _leaf("p", path)
        return [operand(x) for x in found.results]

    def text(self) -> str:
        # the step is 0 while JSBSim initialises and trims
        step: Any = Signal("simulation/dt")
        active = self.active
        ratio = self.block.clock.period / step
        nearest: Any = Signal("integer", ratio + 0.5)
        fits = (step > 0.0) & (abs(ratio - nearest) < _WHOLE)
        self.put(self.frames, select(active, self.frames, select(fits, nearest, 0.0)))
        u, held = self.measured()
        commands = self.capture()
        self.put(active, (self.engaged != 0.0) & (step > 0.0) & (self.frames > 0.0))
        self.put(self.sampling, active & (self.frame < 0.5))
        shown = self.fly([*u, *self.schedule(u)])
        for port, captured in commands.items():
            self.command(port, captured, shown[port], u)
        for path, value in held:
            self.put(path, value)
        after = self.frame + 1.0
        self.put(self.frame, select(active & (after < self.frames), after, 0.0))

        kind, schedule = type(self.block).__name__, getattr(self.block, "_schedule", None)
        law = f"{kind} with gains for {schedule.aircraft}" if schedule else repr(self.block)
        system = ET.Element("system", name=self.base)
        system.extend([*self.declared, *self.functions])
        header = _HEADER.format(
            law=law.replace("--", "- -"),
            T=self.block.clock.period,
            base=self.base,
            about="\n".join(self.about),
        )
        body = "\n".join(_lines(system))
        return f'<?xml version="1.0" encoding="utf-8"?>\n<!--\n{header}-->\n{body}\n'

    def measured(self) -> tuple[list[Any], list[tuple[Any, Any]]]:
        """The inputs, and what of them is to be held for the next frame."""
        u, held, documented = [], [], _documented(self.block, "Inputs")
        absolute = getattr(self.block, "reference", None) == "absolute"
        flies = self.block.of_aircraft
        for port in self.inputs:
            name = _property_of(port) if flies else port
            if not flies or port not in _MEASURED or port in self.unwired:
                name = f"given-{name}" if port in self.outputs else name
                about = "" if port in _EXCESS else documented.get(port, "")
                begins = absolute and port not in self.unwired
                start = getattr(self.block.checked, port, None) if begins else None
                u.append(self.property(name, start or 0.0, about))
                continue
            path, factor = _MEASURED[port]
            value: Any = Signal(path)
            value *= factor
            if port == "psi":
                value = select(value > ALMOST_NORTH, 0.0, value)
            if _LATE.match(path):
                u.append(value)
            else:
                u.append(self.property(name))
                held.append((u[-1], value))
        return u, held

    def capture(self) -> dict[str, list[tuple[Any, Any]]]:
        """By output the commands that it moves, and what they were before the engagement."""
        known = {**SHORT_INPUTS, **{port: (name,) for port, name in SURFACES.items()}}
        known["throttle"] = tuple(f"fcs/throttle-cmd-norm[{i}]" for i in range(self.engines))
        found: dict[str, list[tuple[Any, Any]]] = {}
        for port in self.outputs:
            for i, name in enumerate(known.get(port, ())):
                command, before = Signal(name), self.property(f"captured-{port}-{i}-norm")
                self.put(before, select(self.active, before, command))
                found.setdefault(port, []).append((command, before))
        return found

    def command(
        self, port: str, captured: Sequence[tuple[Any, Any]], increment: Any, u: Any
    ) -> None:
        """Move the commands of an output, within their range."""
        low: Any = -1.0 if port in (*SURFACES, "steering") else 0.0
        high: Any = 1.0
        if port == "elevator":
            # JSBSim limits the sum of command and pitch trim
            trim: Any = Signal("fcs/pitch-trim-cmd-norm")
            low, high = larger(low, low - trim), smaller(high, high - trim)
        for command, before in captured:
            moved = limit(before + increment, low, high)
            self.put(command, select(self.active, moved, command))
        excess = [before + increment - command for command, before in captured]
        sats = [i for i, x in enumerate(self.inputs) if _EXCESS.get(x) == port]
        for sat in (u[i] for i in sats if self.inputs[i] not in self.unwired):
            over, *others = excess
            if others:  # the mean over the engines that run, or over all if none does
                runs: list[Any] = [
                    Signal(f"propulsion/engine[{i}]/set-running") for i in range(len(excess))
                ]
                mean = sum(x * r for x, r in zip(excess, runs, strict=True)) / sum(runs)
                over = select(sum(runs) > 0.0, mean, sum(excess) / float(len(excess)))
            self.put(sat, select(self.active, over, 0.0))

    def fly(self, u: Sequence[Any]) -> dict[str, Signal]:
        """The law; returns the properties of the outputs."""
        documented = _documented(self.block, "Outputs")
        shown = {
            port: self.property(_property_of(port), about=documented.get(port, ""))
            for port in self.outputs
        }
        names = [f"state/{name}" for name in _names(self.block.START)]
        paths = [f"{self.base}/{name}" for name in names]
        outputs, state = self.reduced(u, paths)
        after = {self.property(names[i]).operation: value for i, value in state.items()}
        values = self.rendered(operations([*outputs, *after.values()]))
        for output, value in zip(shown.values(), values, strict=False):
            self.keep(output.operation, value, 0.0)
        start = dict(zip(paths, flat(self.block.START), strict=True))
        left = dict(zip(after, values[len(shown) :], strict=True))
        read = {path: {p.text for p in x.iter("p")} - {path} for path, x in left.items()}
        while left:
            # each value after those that follow from it
            free = [path for path in left if not any(path in read[x] for x in left)]
            if not free:
                path = next(iter(left))
                self.write(f"{path}-next", left[path])
                self.property(f"{path.removeprefix(self.base)[1:]}-next")
                left[path], read[path] = _leaf("p", f"{path}-next"), set()
            for path in free:
                self.keep(path, left.pop(path), start[path])
        return shown

    def keep(self, path: str, expression: ET.Element, start: float) -> None:
        """Compute a property at each sample; it is ``start`` while the law is not active."""
        active, sampling = (_leaf("p", x.operation) for x in (self.active, self.sampling))
        otherwise = _tag("ifthen", active, _leaf("p", path), _v(repr(start)))
        self.write(path, _tag("ifthen", sampling, expression, otherwise))

    def reduced(self, u: Sequence[Any], paths: Sequence[str]) -> tuple[list[Any], dict[int, Any]]:
        """Outputs, and next state by its indices without what is constant, equal or not used."""
        start = flat(self.block.START)
        # all are constant or equal until a sample tells them apart
        x: list[Any] = list(start)
        same: list[Any] = []
        while same != (same := [getattr(value, "operation", value) for value in x]):
            outputs, state = self.traced([*u], x)
            groups: dict[Any, int] = {}
            for i, result in enumerate(operations(state).results):
                if same[i] in paths or result not in (repr(start[i]), repr(float(start[i]))):
                    x[i] = Signal(paths[groups.setdefault((same[i], result), i)])
        used: dict[int, Any] = {}
        while True:
            steps = operations([*outputs, *used.values()]).steps.values()
            read = {paths.index(step[0]) for step in steps if step[0] in paths}
            if read == used.keys():
                return outputs, used
            used = {i: state[i] for i in sorted(read)}

    def traced(self, u: list[Any], x: Sequence[Any]) -> tuple[list[Any], tuple[Any, ...]]:
        """Outputs and next state, flat."""
        block = self.block
        there = [float(port not in self.unwired) for port in self.inputs]
        wired, block.inputs.wired = block.inputs.wired, {i for i, x in enumerate(there) if x}
        try:
            state = nested(iter(x), block.START)
            outputs, state = block.describe(u, state, block.form(there))
        finally:
            block.inputs.wired = wired
        return outputs, flat(state)

    def schedule(self, u: Sequence[Signal]) -> list[Any]:
        """The gains of a schedule, as tables over airspeed and altitude or as numbers."""
        schedule: GainSchedule | None = getattr(self.block, "_schedule", None)
        if schedule is None:
            return []
        altitudes, speeds, numbers = schedule.grid
        nominal = schedule.points[schedule.nominal]
        keys = []
        for port, unit, there in (("vc", "kts", nominal.speed), ("h", "ft", nominal.altitude)):
            key = self.property(f"gains/{port}-{unit}", there)
            keys.append(key.operation)
            if port in self.inputs:
                vc, here = (u[self.inputs.index(x)] for x in ("vc", port))
                self.put(key, select(vc == 0.0, there, here))  # without an airspeed
        row: list[Any] = []
        for loop, first, end in schedule.columns:
            for gain, k in zip(vars(getattr(nominal.gains, loop)), range(first, end), strict=True):
                row.append(float(numbers[0, 0, k]))
                if k in schedule.varying:
                    row[-1] = self.property(f"gains/{loop}-{gain}")
                    table = _table(keys, altitudes, speeds, numbers[:, :, k].tolist())
                    self.write(row[-1].operation, table)
        return row


def _table(
    keys: Sequence[str], altitudes: Sequence[float], speeds: Sequence[float], rows: Any
) -> ET.Element:
    table = ET.Element("table")
    for lookup, key in zip(("row", "column"), keys, strict=True):
        variable = _leaf("independentVar", key)
        variable.set("lookup", lookup)
        table.append(variable)
    lines = [altitudes, *([v, *row] for v, row in zip(speeds, rows, strict=True))]
    table.append(_leaf("tableData", "\n".join(" ".join(map(repr, line)) for line in lines)))
    return table


_HEADER = """\
{law}
of pathsim-jsbsim-blocks, sampled every {T!r} s.

Include this file in the aircraft's, <system file="NAME"/>, from the aircraft's folder or its folder
Systems. JSBSim's time step must divide the sample period. The law runs with

  {base}/engaged = 1

and its increments are added to the commands as they are then. Names of properties end in their
units.

{about}
"""


def system(block: Any, name: str | None, engines: int, unwired: Sequence[str]) -> str:
    """The ``<system>`` of a block, as `DescribedLaw.to_jsbsim_xml` gives it."""
    kind = type(block).__name__
    if name is None:
        name = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", kind).lower()
    if not isinstance(name, str) or not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name):
        must_be("name", name, "made of small letters, digits and single dashes")
    engines = whole("engines", engines, low=1)
    if not isinstance(unwired, (list, tuple)):
        must_be("unwired", unwired, "a list of input ports")
    for port in unwired:
        one_of("unwired", port, tuple(block.input_port_labels))
    return _System(block, name, engines, unwired).text()
