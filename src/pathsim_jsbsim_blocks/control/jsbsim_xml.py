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
from collections.abc import Mapping, Sequence
from typing import Any

from .._core.aircraft_ports import ALMOST_NORTH, OUTPUTS, SHORT_INPUTS, SHORT_OUTPUTS, SURFACES
from .._core.checks import refuse, whole
from .gains import GainSchedule
from .signals import Operations, Signal, flat, nested, operations

ROOT = "ap/pathsim"  # of the properties

_MEASURED = {port: found for port, found in OUTPUTS.items() if found[0] is not None}
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
    **{name: name for name in ("acos", "atan", "cos", "exp", "sin")},
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


def _p(name: str) -> ET.Element:
    return _leaf("p", name)


def _v(value: float) -> ET.Element:
    return _leaf("v", repr(min(max(float(value), -_LARGEST), _LARGEST)))


def _limited(x: ET.Element, low: ET.Element, high: ET.Element) -> ET.Element:
    for tag, limit in (("max", low), ("min", high)):
        if limit.text != repr(_LARGEST) and limit.text != repr(-_LARGEST):
            x = _tag(tag, x, limit)
    return x


def _operation(name: str, operands: Sequence[ET.Element]) -> ET.Element:
    """An operation of `signals`."""
    if name in _TAGS:
        return _tag(_TAGS[name], *operands)
    if name == "neg":
        return _tag("product", _v(-1.0), *operands)
    if name == "limit":
        return _limited(*operands)
    if name == "expm1":
        return _tag("difference", _tag("exp", *operands), _v(1.0))
    if name == "mod":
        # of a positive divisor; C's has the sign of the dividend
        rest = _tag("fmod", *operands)
        negative = _tag("lt", rest, _v(0.0))
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
        unit = str(_MEASURED[quantity][0]).rpartition("-")[2]
    return f"{name}-{unit}" if unit and "/" not in unit and not name.endswith(unit) else name


class _System:
    """The ``<system>`` of a block.

    Parameters
    ----------
    block : DescribedLaw
        the block
    name : str
        the node of its properties under ``ap/pathsim``
    engines : int
        how many throttles there are
    """

    def __init__(self, block: Any, name: str, engines: int):
        self.block, self.base, self.engines = block, f"{ROOT}/{name}", engines
        self.inputs, self.outputs = list(block.input_port_labels), list(block.output_port_labels)
        self.declared: list[ET.Element] = []
        self.functions: list[ET.Element] = []
        self.about: list[str] = []
        # what each input, value of the state and gain is
        self.leaves: dict[str, ET.Element] = {}

    def property(self, name: str, value: float = 0.0, about: str = "") -> str:
        """Declare a property; ``about`` documents it in the header."""
        path = f"{self.base}/{name}"
        self.declared.append(_leaf("property", path))
        self.declared[-1].set("value", repr(float(value)))
        if about:
            self.about.append(f"  {path}\n      {about}")
        return path

    def put(self, path: str, expression: ET.Element) -> None:
        """Compute a property in every frame, after those before it."""
        function = ET.Element("function", copyto=path)
        function.append(expression)
        self.functions.append(function)

    def text(self) -> str:
        self.switches()
        held = self.take_inputs()
        commands = self.capture()
        self.start()
        self.gains = self.schedule()
        shown = self.fly()
        for port, captured in commands.items():
            self.command(port, captured, shown[port])
        for path, measured in held.items():
            self.put(path, measured)
        after = _tag("sum", _p(self.frame), _v(1.0))
        more = _tag("and", _p(self.active), _tag("lt", after, _p(self.frames)))
        self.put(self.frame, _tag("ifthen", more, after, _v(0.0)))

        system = ET.Element("system", name=f"{type(self.block).__name__} at {self.base}")
        system.extend([*self.declared, *self.functions])
        schedule, kind = getattr(self.block, "_schedule", None), type(self.block).__name__
        law = f"{kind} with gains for {schedule.aircraft}" if schedule else repr(self.block)
        header = _HEADER.format(
            law=law.replace("--", "- -"),
            T=self.block.clock.period,
            base=self.base,
            about="\n".join(self.about),
        )
        body = "\n".join(_lines(system))
        return f'<?xml version="1.0" encoding="utf-8"?>\n<!--\n{header}-->\n{body}\n'

    def switches(self) -> None:
        """Count JSBSim's frames in a sample period, while the law is not active."""
        self.engaged = self.property("engaged", about="1 engages, 0 leaves the commands alone")
        self.active = self.property(
            "active", about="1 while engaged, unless JSBSim's time step does not divide T"
        )
        self.frames, self.frame, self.sampling = map(self.property, ("frames", "frame", "sampling"))
        step, period = _p("simulation/dt"), self.block.clock.period
        ratio = _tag("quotient", _v(period), step)
        nearest = _tag("integer", _tag("sum", ratio, _v(0.5)))
        off = _tag("abs", _tag("difference", ratio, nearest))
        # the step is 0 while JSBSim initialises and trims
        fits = _tag("and", _tag("gt", step, _v(0.0)), _tag("lt", off, _v(_WHOLE)))
        counted = _tag("ifthen", fits, nearest, _v(0.0))
        self.put(self.frames, _tag("ifthen", _p(self.active), _p(self.frames), counted))

    def start(self) -> None:
        """Decide whether the law is active, and whether it samples in this frame."""
        runs = _tag("gt", _p("simulation/dt"), _v(0.0))
        wanted = _tag("nq", _p(self.engaged), _v(0.0))
        self.put(self.active, _tag("and", wanted, runs, _tag("gt", _p(self.frames), _v(0.0))))
        first = _tag("lt", _p(self.frame), _v(0.5))
        self.put(self.sampling, _tag("and", _p(self.active), first))

    def kept(self, path: str, expression: ET.Element, start: float) -> None:
        """Compute a property at each sample; it is ``start`` while the law is not active."""
        otherwise = _tag("ifthen", _p(self.active), _p(path), _v(start))
        self.put(path, _tag("ifthen", _p(self.sampling), expression, otherwise))

    def take_inputs(self) -> dict[str, ET.Element]:
        """Find the inputs; returns what of them is to be held for the next frame."""
        held, documented = {}, _documented(self.block, "Inputs")
        for i, port in enumerate(self.inputs):
            if port not in _MEASURED:
                name = _property_of(port)
                name = f"given-{name}" if port in self.outputs else name
                about = "" if port in _EXCESS else documented.get(port, "")
                value = _p(self.property(name, about=about))
            else:
                name, factor = str(_MEASURED[port][0]), _MEASURED[port][1]
                value = _p(name) if factor == 1.0 else _tag("product", _p(name), _v(factor))
                if port == "psi":
                    north = _tag("gt", value, _v(ALMOST_NORTH))
                    value = _tag("ifthen", north, _v(0.0), value)
                if not _LATE.match(name):
                    path = self.property(_property_of(port))
                    held[path], value = value, _p(path)
            self.leaves[f"u{i}"] = value
        return held

    def capture(self) -> dict[str, dict[str, str]]:
        """Keep the commands from before the engagement; by output, and by command property."""
        throttles = tuple(f"fcs/throttle-cmd-norm[{i}]" for i in range(self.engines))
        known = {**SHORT_INPUTS, **{port: (name,) for port, name in SURFACES.items()}}
        known["throttle"] = throttles
        found: dict[str, dict[str, str]] = {}
        for port in self.outputs:
            for i, name in enumerate(known.get(port, ())):
                before = self.property(f"captured-{port}-{i}-norm")
                found.setdefault(port, {})[name] = before
                self.put(before, _tag("ifthen", _p(self.active), _p(before), _p(name)))
        return found

    def command(self, port: str, captured: Mapping[str, str], increment: str) -> None:
        """Move the commands of an output, within their range."""
        excess = []
        for name, before in captured.items():
            low, high = _v(-1.0 if port in (*SURFACES, "steering") else 0.0), _v(1.0)
            if port == "elevator":
                # JSBSim limits the sum of command and pitch trim
                trim = _p("fcs/pitch-trim-cmd-norm")
                low = _tag("max", low, _tag("difference", low, trim))
                high = _tag("min", high, _tag("difference", high, trim))
            demanded = _tag("sum", _p(before), _p(increment))
            moved = _limited(demanded, low, high)
            self.put(name, _tag("ifthen", _p(self.active), moved, _p(name)))
            excess.append(_tag("difference", demanded, _p(name)))
        for i, sat in enumerate(self.inputs):
            if _EXCESS.get(sat) == port:
                over = excess[0] if len(excess) == 1 else _mean_of_running(excess)
                path = str(self.leaves[f"u{i}"].text)
                self.put(path, _tag("ifthen", _p(self.active), over, _v(0.0)))

    def fly(self) -> dict[str, str]:
        """The law; returns the properties of the outputs."""
        documented = _documented(self.block, "Outputs")
        shown = {
            port: self.property(_property_of(port), about=documented.get(port, ""))
            for port in self.outputs
        }
        start, names = flat(self.block.START), _names(self.block.START)
        outputs, after = self.reduced(start)
        found = operations([*outputs, *after.values()])
        results = found.results[len(outputs) :]
        # the first of equal values by its result
        keep = dict(zip(found.results, shown.values(), strict=False))
        for i, result in zip(after, results, strict=True):
            if start[i] or result not in keep:
                keep[f"x{i}"] = self.property(f"state/{names[i]}")
            self.leaves[f"x{i}"] = _p(keep.get(f"x{i}", keep.get(result, "")))
        expressions = self.expressions(found)
        paths = [*shown.values(), *(str(self.leaves[f"x{i}"].text) for i in after)]
        starts = dict.fromkeys(paths, 0.0)
        starts |= {str(self.leaves[f"x{i}"].text): float(start[i]) for i in after}
        self.go_on(dict(zip(paths, expressions, strict=True)), starts)
        return shown

    def traced(self, x: Sequence[Any]) -> tuple[list[Any], tuple[Any, ...]]:
        """Outputs and next state, flat, from inputs, gains and the state given."""
        block, n = self.block, len(self.inputs)
        u = [Signal(f"u{i}") for i in range(n)]
        wired, block.inputs.wired = block.inputs.wired, set(range(n))
        try:
            form = block.form([1.0] * n)
            state = nested(iter(x), block.START)
            outputs, state = block.describe([*u, *self.gains], state, form)
        finally:
            block.inputs.wired = wired
        return outputs, flat(state)

    def reduced(self, start: Sequence[float]) -> tuple[list[Any], dict[int, Any]]:
        """Outputs and next state by its indices, without what is constant, equal or not used."""
        # all are constant or equal until a sample tells them apart
        x: list[Any] = list(start)
        while True:
            outputs, state = self.traced(x)
            groups: dict[Any, int] = {}
            after = list(x)
            for i, result in enumerate(operations(state).results):
                leaf = x[i].operation if isinstance(x[i], Signal) else repr(float(x[i]))
                if result not in (repr(start[i]), repr(float(start[i]))) or leaf[0] == "x":
                    after[i] = Signal(f"x{groups.setdefault((leaf, result), i)}")
            if [getattr(s, "operation", s) for s in after] == [
                getattr(s, "operation", s) for s in x
            ]:
                break
            x = after
        used: dict[int, Any] = {}
        while True:
            steps = operations([*outputs, *used.values()]).steps.values()
            read = {int(leaf[1:]) for leaf, *operands in steps if leaf[0] == "x" and not operands}
            if read == used.keys():
                return outputs, used
            used = {i: state[i] for i in sorted(read)}

    def expressions(self, found: Operations) -> list[ET.Element]:
        """The results; operations that are used several times become properties."""
        uses, texts = found.uses(twice=("mod",)), dict(self.leaves)

        def operand(name: str) -> ET.Element:
            numbers = {"True": 1.0, "False": 0.0}
            return texts[name] if name in texts else _v(float(numbers.get(name, name)))

        for result, (operation, *operands) in found.steps.items():
            if not operands:
                texts[result] = self.leaves[operation]
                continue
            expression = _operation(operation, [operand(x) for x in operands])
            if uses[result] > 1:
                path = self.property(f"law/{result}")
                self.put(path, expression)
                expression = _p(path)
            texts[result] = expression
        return [operand(x) for x in found.results]

    def go_on(self, values: dict[str, ET.Element], start: Mapping[str, float]) -> None:
        """Move the state to the next sample, each value after those that follow from it."""
        read = {path: {p.text for p in x.iter("p")} - {path} for path, x in values.items()}
        while values:
            free = [path for path in values if not any(path in read[x] for x in values)]
            if not free:
                path = next(iter(values))
                after = self.property(f"{path.removeprefix(self.base)[1:]}-next")
                self.put(after, values[path])
                values[path], read[path] = _p(after), set()
            for path in free:
                self.kept(path, values.pop(path), start[path])

    def schedule(self) -> list[Any]:
        """The gains of a schedule, as tables over airspeed and altitude or as numbers."""
        schedule: GainSchedule | None = getattr(self.block, "_schedule", None)
        if schedule is None:
            return []
        altitudes, speeds, numbers = schedule.grid
        nominal = schedule.points[schedule.nominal]
        keys = []
        for port, unit, there in (("vc", "kts", nominal.speed), ("h", "ft", nominal.altitude)):
            keys.append(self.property(f"gains/{port}-{unit}", there))
            if port in self.inputs:
                vc, here = (self.leaves[f"u{self.inputs.index(x)}"] for x in ("vc", port))
                # without an airspeed
                on_ground = _tag("eq", vc, _v(0.0))
                self.put(keys[-1], _tag("ifthen", on_ground, _v(there), here))
        row: list[Any] = []
        for loop, first, end in schedule.columns:
            for gain, k in zip(vars(getattr(nominal.gains, loop)), range(first, end), strict=True):
                row.append(float(numbers[0, 0, k]))
                if k in schedule.varying:
                    row[-1] = Signal(f"g{k}")
                    path = self.property(f"gains/{loop}-{gain}")
                    self.leaves[f"g{k}"] = _p(path)
                    self.put(path, _table(keys, altitudes, speeds, numbers[:, :, k].tolist()))
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


def _mean_of_running(values: Sequence[ET.Element]) -> ET.Element:
    """The mean over the engines that run, or over all if none does."""
    runs = [_p(f"propulsion/engine[{i}]/set-running") for i in range(len(values))]
    each = [_tag("product", *pair) for pair in zip(runs, values, strict=True)]
    running = _tag("sum", *runs)
    return _tag(
        "ifthen",
        _tag("gt", running, _v(0.0)),
        _tag("quotient", _tag("sum", *each), running),
        _tag("quotient", _tag("sum", *values), _v(len(values))),
    )


_HEADER = """\
{law}
of pathsim-jsbsim-blocks, sampled every {T!r} s.

Include this file in the aircraft's, <system file="NAME"/>, from the aircraft's folder or its folder
Systems. JSBSim's time step must divide the sample period. With

  {base}/engaged = 1

it adds increments to the commands as they are then. Names of properties end in their units.

{about}
"""


def system(block: Any, name: str | None = None, engines: int = 1) -> str:
    """The ``<system>`` of a block, as `DescribedLaw.to_jsbsim_xml` gives it."""
    kind = type(block).__name__
    if name is None:
        name = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", kind).lower()
    if not isinstance(name, str) or not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name):
        refuse(
            "name",
            name,
            f"name must be made of small letters, digits and single dashes, not {name!r}",
        )
    engines = whole("engines", engines, low=1)
    return _System(block, name, engines).text()
