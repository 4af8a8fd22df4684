"""Read a diagram script: values from the live diagram, names and expressions from the source."""

from __future__ import annotations

import ast
import builtins
import inspect
import itertools
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, NoReturn

import numpy as np
from pathsim import Connection, Interface, Subsystem
from pathsim.blocks import Block, Function, StateSpace

from .._core.own import editable
from .._core.pathsim_internals import flies_matrices, own_events, port_names
from .._seeding import draws_from_shared, is_random
from .code import Code, Unwritable
from .diagram import Diagram, Event, Graph, Node, Part, Wire, ends
from .expressions import same
from .first_run import FirstRun, named_arguments
from .settings import fieldless, live_settings
from .toolboxes import Toolbox, core_registry, toolbox_of, unknown_block
from .variables import TAKEN, plain, prefix_inside, unique

_BY_NAME = "PathView knows blocks by class name only"


def read_diagram(script: FirstRun) -> Diagram:
    """Everything in a diagram script; a `DiagramError` names what PathView cannot represent."""
    return _Reader(script).diagram()


class _Reader:
    def __init__(self, script: FirstRun):
        self.script = script
        self.refuse, self._called = script.refuse, script.called
        self.code = Code(script)
        self.registry = core_registry()
        self.parts: dict[int, Part] = {}
        self.types: dict[str, tuple[type[Block], Toolbox | None]] = {}
        self.lost: list[str] = []  # blocks whose state PathView cannot represent

    def diagram(self) -> Diagram:
        sim = self.script.simulation
        if sim.time:
            where = f"the simulation is at t = {sim.time:g} when its first run begins"
            self.refuse(f"{where}; PathView starts at 0", self.script.run_call)
        graph = self._graph(sim.blocks, sim.connections, sim.events, None)
        if self.lost:
            calls = [f"{method}() in line {line}" for method, line in self.script.states]
            cause = f", which {calls[-1]} has set," if calls else ""
            self.refuse(f"PathView has no initial value for {', '.join(self.lost)}: their state "
                        f"when the run begins{cause} cannot be in the model")  # fmt: skip
        todo = [(p, n, v) for p in self.parts.values() for n, v in p.arguments.items()]
        # functions first: a parameter then refers to the same table as a function that uses it
        for part, name, value in sorted(todo, key=lambda item: not callable(item[2])):
            part.target.params[name] = self._expression(part, name, value)
        for part in self.parts.values():
            part.target.params = {n: part.target.params[n] for n in part.arguments}
        live = live_settings(self.script)
        settings = {name: self._setting(*setting) for name, setting in live.items()}
        variables = self._name_parts()
        for part in self.parts.values():
            params = part.target.params.items()
            part.target.params = {n: self.code.filled(e, variables) for n, e in params}
        return Diagram(
            path=self.script.path,
            docstring=ast.get_docstring(self.script.tree) or "",
            graph=graph,
            context=self._context(variables),
            settings={"solver": sim.Solver.__name__, **settings},
            duration=float(live["duration"][0]),
            toolboxes=self._toolboxes(),
            log=bool(sim.log),
            unseeded=[
                part.variable
                for part in self.parts.values()
                if is_random(part.value) and part.arguments.get("seed") is None
            ],
            parts={part.variable: part for part in self.parts.values()},
        )

    def _context(self, variables: Mapping[str, str]) -> str:
        """The model's code; it seeds NumPy's shared generator if the diagram may draw from it."""
        text, seed = self.code.text(variables), None
        parts = self.parts.values()
        every = [text, *(e for part in parts for e in part.target.params.values())]
        if any("random" in e for e in every) or any(draws_from_shared(p.value) for p in parts):
            seed = self.script.generators.seed
        return "\n".join(filter(None, [text, "" if seed is None else f"np.random.seed({seed})"]))

    # structure ----------------------------------------------------------------------------------

    def _graph(
        self,
        blocks: Sequence[Block],
        connections: Sequence[Connection],
        events: Sequence[Any],
        parent: Part | None,
    ) -> Graph:
        index = {id(b): i for i, b in enumerate(blocks)}
        wires = [w for c in connections for w in self._wires(c, index)]
        nodes = [self._block(block, i, wires, parent) for i, block in enumerate(blocks)]
        return Graph(nodes, wires, [self._event(e, parent) for e in events])

    def _wires(self, connection: Connection, index: dict[int, int]) -> Iterator[Wire]:
        for source, out, target, into in ends(connection):
            for block in (source, target):
                if id(block) not in index:
                    reason = f"{self._called(block)} is connected but not in the list of blocks"
                    self._refuse(block, reason)
            if not connection:
                reason = "is switched off when the run begins; PathView cannot represent that"
                self._refuse(source, f"a connection of {self._called(source)} {reason}")
            yield Wire(index[id(source)], out, index[id(target)], into)

    def _block(self, block: Block, i: int, wires: Sequence[Wire], parent: Part | None) -> Node:
        kind = self._kind(block)
        node = Node("", kind.__name__)
        n_in = max((w.input + 1 for w in wires if w.target == i), default=0)
        n_out = max((w.output + 1 for w in wires if w.source == i), default=0)
        part = self._add(Part(node, block, kind, parent=parent))
        node.inputs = _port_names(block, kind, "input", n_in)
        node.outputs = _port_names(block, kind, "output", n_out)
        if kind is Interface:
            return node
        if kind is Subsystem:
            fieldless(self.script, block)
            blocks = [block.interface, *block.blocks]
            node.graph = self._graph(blocks, block.connections, own_events(block), part)
            # the two sides of the interface have the same ports
            interface = node.graph.nodes[0]
            for mine, theirs in (("inputs", "outputs"), ("outputs", "inputs")):
                ports = max(getattr(node, mine), getattr(interface, theirs), key=len)
                setattr(node, mine, ports)
                setattr(interface, theirs, ports)
            return node
        self._construction(part, self._known(block, kind))
        if node.type in _SYNCHRONOUS.split():
            more = max(len(node.inputs), len(node.outputs))
            node.inputs += [f"in {k}" for k in range(len(node.inputs), more)]
            node.outputs += [f"out {k}" for k in range(len(node.outputs), more)]
        return node

    def _kind(self, block: Block) -> type[Block]:
        """The class for PathView: StateSpace if it lacks a linear block's class or state."""
        kind = _built_in(type(block), self.registry["blocks"])
        if kind.__module__ == "pathsim.blocks.math" and kind.__name__ in _EXPRESSIONS:
            return Function
        in_pathview = kind.__name__ in self.registry["blocks"] or kind.__module__[:8] != "pathsim."
        stateless = "initial_value" not in _parameters(kind) and np.any(_states(block)[0])
        return StateSpace if flies_matrices(block) and (stateless or not in_pathview) else kind

    def _known(self, block: Block, kind: type[Block]) -> list[str]:
        """Parameter names of a block's class; refuse a class that PathView does not have."""
        name = kind.__name__
        if kind.__module__.startswith("pathsim."):
            entry = self.registry["blocks"].get(name)
            toolbox, parameters = None, entry and entry["params"]
        else:
            toolbox = toolbox_of(kind)
            parameters = list(kind.info()["parameters"]) if toolbox else None
        if parameters is None:
            hint = ""
            if not kind.__module__.startswith("pathsim."):
                hint = "; its class must be exported by an installed package"
            elif hasattr(block, "func") and re.search(r"\bjsbsim\b", self.script.source):
                hint = "; in a function JSBSim runs ahead of the clock: use Aircraft or JSBSimFDM"
            self._refuse(block, unknown_block(name, self.registry) + hint)
        if self.types.setdefault(name, (kind, toolbox))[0] is not kind:
            reason = f"two blocks of the same class name {name!r} from different packages"
            self._refuse(block, f"{reason}; {_BY_NAME}")
        return parameters

    def _event(self, event: Any, parent: Part | None) -> Event:
        name = type(event).__name__
        entry = self.registry["events"].get(name)
        target = Event("", f"pathsim.events.{name}", {})
        part = self._add(Part(target, event, type(event), parent=parent))
        if entry is None or not type(event).__module__.startswith("pathsim."):
            self._refuse(event, f"PathView does not know the event {name!r}")
        self._construction(part, entry["params"])
        return target

    def _add(self, part: Part) -> Part:
        if id(part.value) in self.parts:
            self._refuse(part.value, f"{self._called(part.value)} is in the diagram twice")
        if not part.value:
            reason = "is switched off when the run begins; PathView cannot represent that"
            self._refuse(part.value, f"{self._called(part.value)} {reason}")
        self.parts[id(part.value)] = part
        return part

    # source -------------------------------------------------------------------------------------

    def _refuse(self, value: Any, reason: str, node: ast.AST | None = None) -> NoReturn:
        """Refuse a part, by default with the line that builds it."""
        built_at = self.script.built_at
        node = node or built_at(value) or built_at(self.script.simulation)
        self.refuse(reason, node)

    def _construction(self, part: Part, names: Sequence[str]) -> None:
        """The values with which a part is to be built, by parameter name."""
        construction, parameters = self.script.construction(part.value), _parameters(part.kind)
        arguments, values = frozenset[str](), dict[str, Any]()
        if construction and construction.arguments is not None and part.kind is type(part.value):
            arguments, values = construction.arguments, construction.values
        for name in arguments:
            if name not in names or name.startswith("_"):
                reason = f"PathView cannot represent parameter {name!r} of {part.kind.__name__}"
                self._refuse(part.value, reason)
        if "initial_value" not in names and not same(*_states(part.value)):
            self.lost.append(f"{self._called(part.value)} ({part.kind.__name__})")
        if part.kind is Function and type(part.value) is not Function:
            part.arguments["func"] = part.value  # written by its expression
            return
        for name in names:
            default = parameters[name].default if name in parameters else ...
            value, initial = values.get(name, (default, default))
            live = editable(getattr(part.value, name, initial))
            if name == "initial_value":
                live = _state(part.value, live)
            if not same(live, editable(initial)):  # changed since the part was built
                value = live
            if name in arguments or not same(value, default):
                part.arguments[name] = value

    def _expression(self, part: Part, name: str, value: Any) -> str:
        """An expression for a parameter, from the script if that gives the value."""
        if part.kind is Function and type(part.value) is not Function:
            text = _EXPRESSIONS[type(part.value).__name__]
            numbers = {n: x for n, x in vars(part.value).items() if f"{{{n}}}" in text}
            return text.format(**{n: self.code.parameter(x, n) for n, x in numbers.items()})
        node = self._node(part, name)
        what = f"parameter {name!r} of {self._called(part.value)}"
        if value is inspect.Parameter.empty:
            self._refuse(part.value, f"{what} cannot be read from the block")
        try:
            source = node is not None and self.code.kept(node, value)
            return source or self.code.parameter(value, name)
        except Unwritable as unwritable:
            where = node if hasattr(node, "lineno") else None
            self._refuse(part.value, f"{what}: {unwritable}", where)

    def _node(self, part: Part, name: str) -> ast.expr | None:
        """The script's expression for a parameter."""
        construction = self.script.construction(part.value)
        if construction is None or construction.arguments is None:
            return None
        return named_arguments(construction.node, list(_parameters(part.kind))).get(name)

    def _setting(self, value: Any, node: ast.expr | None) -> str:
        if value is None:
            return ""
        integral = isinstance(value, float) and value.is_integer()  # `fly` turns 60 into 60.0
        for live in (value, int(value)) if integral else (value,):
            if node is not None and (text := self.code.kept(node, live)):
                return text
        return repr(float(value))

    # names --------------------------------------------------------------------------------------

    def _name_parts(self) -> dict[str, str]:
        """Name every part; return their variables, keyed by their stand-ins in the code."""
        variables = {f"__part_{id(self.script.simulation)}": "sim"}
        code = self.code.names | self.code.inner | {*dir(builtins)}

        def is_of_code(name: str) -> bool:
            variable = prefix + plain(name)
            return variable in code or bool(TAKEN.fullmatch(variable))

        def taken(name: str) -> bool:
            return is_of_code(name) or prefix + plain(name) in variables.values()

        for part in self.parts.values():
            prefix = _prefix(part.parent)
            if isinstance(part.value, Interface):
                part.target.name, part.variable = "Interface", f"{prefix}interface"
            else:
                wish = self._wish(part, prefix)
                if part.kind is Subsystem:  # PathView does not prefix nested ones
                    prefix = ""
                wish += " block" if is_of_code(wish) else ""
                part.target.name = unique(wish, taken, " ")
                part.variable = prefix + plain(part.target.name)
            variables[f"__part_{id(part.value)}"] = part.variable
        for value in self.code.parts.values():
            if f"__part_{id(value)}" not in variables:
                label = self._called(value)
                self.refuse(f"a function refers to {label}, which is not in the simulation")
        return variables

    def _wish(self, part: Part, prefix: str) -> str:
        """The label of a part, such as "pitch rate" for ``pitch_rate``; it may be taken."""
        variables = self.script.names_of(part.value)
        wish = variables[0] if variables else self._original_name(part)
        wish = wish or part.kind.__name__
        for start in (prefix, f"{part.parent.variable}_" if part.parent else ""):
            wish = wish.removeprefix(start) or wish
        label = re.sub("_+", " ", wish).strip()
        return label if plain(label) else part.kind.__name__

    def _original_name(self, part: Part) -> str:
        """The label of a part without a module variable: the target of the call that built it."""
        target = self.script.target(part.value)
        variable = self.script.namespace.get(target)
        return "" if isinstance(variable, (list, tuple, dict)) else target

    def _toolboxes(self) -> list[Toolbox]:
        """The toolboxes in use, ordered so that every class name resolves to the right one."""
        owners = {name: toolbox for name, (_, toolbox) in self.types.items()}
        toolboxes = sorted({t for t in owners.values() if t}, key=lambda t: t.package)
        for order in itertools.permutations(toolboxes):
            winners = {name: t for t in order for name in owners if t.block(name)}
            if all(winners.get(name) == toolbox for name, toolbox in owners.items()):
                return list(order)
        names = " and ".join(t.package for t in toolboxes)
        self.refuse(f"blocks of the same class name in {names} hide each other; {_BY_NAME}")


# blocks for which PathView keeps the numbers of inputs and outputs equal
_SYNCHRONOUS = (
    "Integrator Differentiator Delay Amplifier Sin Cos Tan Tanh Abs Sqrt Exp Log Log10 Mod Clip "
    "Pow Polynomial Rescale Alias LogicNot SampleHold FirstOrderHold DiscreteIntegrator "
    "DiscreteDerivative"
)


def _port_names(block: Block, kind: type[Block], side: str, wires: int) -> list[str]:
    """Names of a block's ports: its labels, names derived from its parameters, or ``in 0``."""
    register = block.inputs if side == "input" else block.outputs
    labels = kind.info()[f"{side}_port_labels"]
    n = wires
    if kind not in (Interface, Subsystem):
        n = max(len(register if labels is None else labels), wires)
    # PathView shows eight characters: the last part of a path is the most telling
    names = {
        i: name.rpartition("/")[2] or name
        for ports in (port_names(register), labels or {})
        for name, i in ports.items()
    }
    names.update(enumerate(getattr(block, "drawn_ports", {}).get(side, ())))
    if side == "input":
        symbols = getattr(block, "labels", None) or getattr(block, "operations", None) or ()
        if kind.__name__ in ("Scope", "Spectrum", "Adder", "Divider"):
            n = max(n, len(symbols))
            names.update(enumerate(map(str, symbols)))
    n = max([n, *(i + 1 for i in names)])
    return [names.get(i, f"{side[:-3]} {i}") for i in range(n)]


# blocks without memory that PathView lacks, as the function of a Function block
_EXPRESSIONS = {
    "Matrix": "lambda *u: tuple(np.dot({A}, u))",
    "Norm": "lambda *u: np.linalg.norm(u)",
    "PowProd": "lambda *u: np.prod(np.power(u, {exponents}))",
    "Atan": "lambda *u: tuple(np.arctan(u))",
    "Sinh": "lambda *u: tuple(np.sinh(u))",
    "Cosh": "lambda *u: tuple(np.cosh(u))",
}


def _built_in(kind: type[Block], core: Collection[str]) -> type[Block]:
    """A class, or its base if it only adds ``__init__``: PathView may have the base.

    ``core`` names PathView's classes of PathSim.
    """
    while len(kind.__bases__) == 1:
        of_pathsim = kind.__module__.startswith("pathsim.")
        if of_pathsim and (kind.__name__ in core or kind.__bases__[0].__name__ not in core):
            break  # PathView's own, or not an old name of one such as Step
        base = kind.__bases__[0]
        additions = vars(kind).keys() - {"__init__", *vars(type("", (), {}))}
        if (
            not issubclass(base, Block)
            or base is Block
            or any(hasattr(base, n) for n in additions)
            or additions & _parameters(base).keys()
            or (not of_pathsim and toolbox_of(kind))
        ):
            break
        kind = base
    return kind


def _parameters(kind: type) -> Mapping[str, inspect.Parameter]:
    return inspect.signature(kind).parameters


def _states(block: Any) -> tuple[Any, Any]:
    """The state of a block, and its engine's initial value; None without an engine."""
    engine = getattr(block, "engine", None)
    return engine and np.ravel(engine.state).copy(), engine and np.ravel(engine.initial_value) * 1.0


def _state(block: Any, initial: Any) -> Any:
    """The state of a block if it differs from ``initial``, e.g. after `steadystate`."""
    state, _ = _states(block)
    if state is None or same(state, np.ravel(np.asarray(initial, float))):
        return initial
    return state.item() if np.ndim(initial) == 0 and state.size == 1 else state


def _prefix(parent: Part | None) -> str:
    """PathView's prefix for the variables of the blocks in a subsystem."""
    if parent is None:
        return ""
    return prefix_inside(parent.target.name, _prefix(parent.parent))
