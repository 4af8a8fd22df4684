"""A DAVE-ML model: read from its file, evaluated, and verified against its own check data."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from typing import Any, NamedTuple

from .._core.checks import did_you_mean, must_be, nearest, number, refuse
from ..errors import DaveMLError
from .elements import Element, read_elements
from .mathml import NAMES, Expression, python_of, read_expression, variables_of
from .tables import Table, read_tables

# relative tolerance of internal values in check data, for which files state none
_ROUNDING = 1e-6

_INPUTS = ("isInput", "isControl", "isDisturbance")


@dataclass(frozen=True)
class Variable:
    """A variable of a DAVE-ML model: ``id`` within the file, ``name`` outside it.

    ``kind`` is "input", "constant", "calculation" or "table"; ``initial`` is the value of a
    constant, and the default of an input. The value is limited to ``low`` and ``high``.
    """

    id: str
    name: str
    units: str
    sign: str
    kind: str
    is_output: bool
    initial: float | None
    low: float
    high: float
    element: Element
    expression: Expression  # of a calculation
    table: Table | None
    arguments: tuple[str, ...]  # of the table

    @property
    def reads(self) -> set[str]:
        return {*self.arguments} or variables_of(self.expression)


class Check(NamedTuple):
    """One value of a check shot: the file's expected value, and the model's."""

    shot: str
    variable: str
    expected: float
    value: float
    tolerance: float

    @property
    def passes(self) -> bool:
        return abs(self.value - self.expected) <= self.tolerance


class DaveModel:
    """A model in DAVE-ML (ANSI/AIAA S-119), read from a file.

    Its values are limited to their ``minValue`` and ``maxValue``. Statistical elements
    (``uncertainty``) are not read.

    Parameters
    ----------
    file : str or Path
        the file; the name alone of a model that comes with the package, such as "f16_aero.dml"

    Attributes
    ----------
    path : Path
        the file
    variables : dict of Variable
        all variables by varID, each after those that it reads
    inputs, outputs : list of Variable
        in the file's order. Inputs are marked ``isInput``, or have no value, calculation or table;
        outputs are marked ``isOutput``

    Raises
    ------
    FileError
        if the file cannot be read
    DaveMLError
        if it is malformed, naming line and variable
    """

    def __init__(self, file: Any):
        root = read_elements(file)
        self.path = root.path
        if root.tag != "DAVEfunc":
            raise root.error(f"not DAVE-ML: the root is {root.tag!r}, not 'DAVEfunc'")
        tables = ("breakpointDef", "griddedTableDef", "ungriddedTableDef")
        root.only("fileHeader", "variableDef", *tables, "function", "checkData")
        variables = _variables(root, read_tables(root))
        self.variables = {name: variables[name] for name in _order(variables)}
        self.inputs = [v for v in variables.values() if v.kind == "input"]
        self.outputs = [v for v in variables.values() if v.is_output]
        self._shots = [*_shots(root, self)]
        self._function = self._compiled()
        numbers = {name: i for i, name in enumerate(self.variables)}
        self._shown = [numbers[v.id] for v in self.outputs]

    def __reduce__(self) -> tuple[type, tuple[Any]]:
        # the compiled function cannot be pickled
        return type(self), (self.path,)

    def __call__(self, values: Sequence[float]) -> list[float]:
        """The outputs for the inputs, in the order of ``outputs`` and ``inputs``.

        Raises
        ------
        ParameterError
            for a wrong number of values
        DaveMLError
            if a variable has no value for these inputs, as after a division by zero
        """
        if len(values) != len(self.inputs):
            must_be("values", values, f"{len(self.inputs)} numbers, one for each input")
        results = self._evaluated(values)
        return [results[i] for i in self._shown]

    def evaluate(self, inputs: Mapping[str, float] = {}) -> dict[str, float]:
        """All variables by varID.

        Parameters
        ----------
        inputs : mapping
            values of inputs, by varID or name; the others have the initial values of the file

        Raises
        ------
        ParameterError
            for a name that is not an input, and an input without a value
        DaveMLError
            if a variable has no value for these inputs
        """
        ids = {key: v.id for v in self.inputs for key in (v.name, v.id)}
        by_id: dict[str, Any] = {v.id: v.initial for v in self.inputs}
        for name, value in inputs.items():
            if name not in ids:
                close = did_you_mean(nearest(name, ids))
                refuse(name, value, f"{self.path.name} has no input {name!r}{close}")
            by_id[ids[name]] = value
        if missing := [name for name, x in by_id.items() if x is None]:
            why = f"{self.path.name}: missing input {', '.join(map(repr, missing))}"
            refuse(f"{self.path.name}: the input {missing[0]!r}", None, why)
        values = [number(f"{self.path.name}: the input {n!r}", x) for n, x in by_id.items()]
        return dict(zip(self.variables, map(float, self._evaluated(values)), strict=True))

    def verify(self) -> list[Check]:
        """Compare the file's check shots with the model.

        An internal value, for which files state no tolerance, may differ by 1e-6 of its size.

        Raises
        ------
        ParameterError, DaveMLError
            if a shot omits an input, or a variable has no value in it
        """
        checks = []
        for shot, inputs, answers in self._shots:
            results = self.evaluate(inputs)
            checks += [Check(shot, name, x, results[name], tol) for name, x, tol in answers]
        return checks

    def _evaluated(self, values: Sequence[float]) -> list[float]:
        try:
            results = self._function(*values)
        except (ArithmeticError, ValueError) as error:
            place: Any = error.__traceback__
            while place.tb_frame.f_code is not self._function.__code__:
                place = place.tb_next
            v = [*self.variables.values()][place.tb_lineno - 2]
            raise v.element.error(f"no value: {error}", v.id) from None
        if not math.isfinite(sum(results)):
            for v, x in zip(self.variables.values(), results, strict=True):
                if not math.isfinite(x):
                    raise v.element.error(f"no value: it is {x}", v.id)
        return results

    def _compiled(self) -> Any:
        """A function from the inputs to all variables, with one line for each."""
        local = {name: f"v{i}" for i, name in enumerate(self.variables)}
        names = {**NAMES}
        lines = [f"def function({', '.join(local[v.id] for v in self.inputs)}):"]
        lines += [f" {local[v.id]} = {_code(v, local, names)}" for v in self.variables.values()]
        lines.append(f" return [{', '.join(local.values())}]")
        try:
            exec(compile("\n".join(lines), "<DAVE-ML>", "exec"), names)
        except (RecursionError, MemoryError):
            raise DaveMLError("its calculations are nested too deeply", path=self.path) from None
        return names["function"]


def _code(v: Variable, local: Mapping[str, str], names: dict[str, Any]) -> str:
    """The Python of a variable; its table is added to ``names``."""
    if v.kind == "table":
        names[f"table_{local[v.id]}"] = v.table
        code = f"table_{local[v.id]}({', '.join(local[x] for x in v.arguments)})"
    elif v.kind == "input":
        code = local[v.id]
    else:
        code = python_of(v.expression, local.__getitem__)
    free = v.low == -math.inf and v.high == math.inf
    return code if free else f"limited({code}, {v.low!r}, {v.high!r})"


def _variables(root: Element, tables: dict[str, tuple]) -> dict[str, Variable]:
    variables: dict[str, Variable] = {}
    for element in root.all("variableDef"):
        name, initial = element.get("varID"), element.number("initialValue", None)
        if name in variables:
            raise element.error(f"is defined in line {variables[name].element.line} already", name)
        marks = ("isOutput", "isState", "isStateDeriv", "isStdAIAA", *_INPUTS)
        element.only("description", "provenance", "provenanceRef", "calculation",
                     "uncertainty", *marks)  # fmt: skip
        function, table, arguments = tables.pop(name, (None, None, ()))
        calculations = [*element.all("calculation")]
        if len(calculations) + (table is not None) + element.has(*_INPUTS) > 1:
            raise element.error("has more than one of input, calculation and table", name)
        kind, expression = "constant", ("number", initial)
        if table is not None:
            kind = "table"
        elif calculations:
            content = calculations[0].one("math").children
            if len(content) != 1:
                raise element.error(f"its calculation has {len(content)} expressions", name)
            kind, expression = "calculation", read_expression(content[0])
        elif element.has(*_INPUTS) or initial is None:
            kind = "input"
        low = element.number("minValue", -math.inf)
        high = element.number("maxValue", math.inf)
        if low > high:
            raise element.error(f"minValue {low:g} is above maxValue {high:g}", name)
        units, sign = (element.attributes.get(x, "") for x in ("units", "sign"))
        variables[name] = Variable(
            name, element.get("name"), units, sign, kind, element.has("isOutput"), initial,
            low, high, element, expression, table, arguments,
        )  # fmt: skip
    for name, (function, *_) in tables.items():
        raise function.error(f"no variable {name!r}", name=name, of=variables)
    return variables


def _order(variables: Mapping[str, Variable]) -> Iterable[str]:
    """The variables, each after those that it reads."""
    reads = {v.id: v.reads for v in variables.values()}
    for v in variables.values():
        for name in reads[v.id]:
            if name not in variables:
                raise v.element.error(f"reads {name!r}, which is undefined", v.id, name, variables)
    try:
        return [*TopologicalSorter(reads).static_order()]
    except CycleError as error:
        loop = error.args[1]
        needs = " -> ".join(reversed(loop))
        raise variables[loop[0]].element.error(f"depends on itself: {needs}", loop[0]) from None


def _shots(root: Element, model: DaveModel) -> Iterator[tuple[str, dict[str, float], list]]:
    """Name, inputs, and expected values with tolerances of each check shot."""
    outputs = {v.name: v.id for v in [*model.variables.values(), *model.outputs]}
    inputs = outputs | {v.name: v.id for v in model.inputs}
    ids = dict(zip(model.variables, model.variables, strict=True))

    def read(signal: Element, names: Mapping[str, str]) -> tuple[str, float]:
        label, value = signal.one("signalName", "signalID", "varID"), signal.one("signalValue")
        name, names = label.text.strip(), names if label.tag == "signalName" else ids
        if name not in names:
            raise label.error(f"no variable {name!r}", name=name, of=names)
        return names[name], value.parse(value.text)

    for shot in (shot for data in root.all("checkData") for shot in data.all("staticShot")):
        settings = dict(read(x, inputs) for x in shot.one("checkInputs").all("signal"))
        results = []
        parts = shot.all("internalValues", "checkOutputs")
        for signal in (signal for part in parts for signal in part.all("signal")):
            name, value = read(signal, outputs)
            tolerances = [abs(x.parse(x.text)) for x in signal.all("tol")]
            results.append((name, value, max(tolerances, default=_ROUNDING * abs(value))))
        yield shot.attributes.get("name", f"line {shot.line}"), settings, results
