"""Read a diagram script: structure from the live diagram, expressions from the source."""

from __future__ import annotations

import ast
import builtins
import inspect
import itertools
import keyword
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from pathsim import Connection, Interface, Subsystem
from pathsim.blocks import Block

from .._core._pathsim import own_events, port_names, port_number
from .context import PARTS, Context
from .diagram import Diagram, Event, Graph, Node, Wire
from .names import passed, used
from .script import Script, named_arguments
from .settings import setting_expressions, setting_values
from .toolboxes import Toolbox, core_registry, toolbox_of, unknown_block
from .variables import plain, prefix_inside

# methods that build the diagram, or only look at it
_HARMLESS = {"add_block", "add_connection", "add_event", "register_port_map", "plot", "read",
             "save"}
_TAKEN = {"np", "plt", "blocks", "connections", "events", "sim", "json", "gc", "sys", "traceback",
          "base64", *dir(builtins)}
_GENERATED = re.compile(r"blocks|connections|events|sim|conn_\d+")


def read_diagram(script: Script) -> Diagram:
    """Everything that a model file can hold of a diagram script.

    Raises
    ------
    DiagramError
        for what PathView has no place for, with file, line and reason
    """
    return _Reader(script).diagram()


@dataclass
class _Part:
    """A block or an event on its way to a node."""

    target: Node | Event
    value: Any
    arguments: dict[str, ast.expr]
    function: ast.FunctionDef | None = None
    parent: _Part | None = None
    variable: str = ""


class _Reader:
    def __init__(self, script: Script):
        self.script = script
        self.refuse = script.refuse
        self.registry = core_registry()
        self.parts: dict[int, _Part] = {}
        self.types: dict[str, tuple[type[Block], Toolbox | None]] = {}

    def diagram(self) -> Diagram:
        sim = self.script.simulation
        self._check_unchanged()
        graph = self._graph(sim.blocks, sim.connections, sim.events, None)
        settings = setting_expressions(self.script)
        context = Context(self.script, [
            *(e for p in self.parts.values() for e in p.arguments.values()),
            *(p.function for p in self.parts.values() if p.function), *settings.values()])
        self._check_order(context)
        for name in sorted(context.names):
            if _GENERATED.fullmatch(name):
                self.refuse(f"PathView's own code uses the name {name!r}; rename it")
        renamed = self._name_parts(context)
        for name in sorted(context.parts - renamed.keys()):
            self.refuse(f"a function refers to {name!r}, which is not in the simulation")
        renamed = {old: new for old, new in renamed.items() if old != new}
        functions = self._write_parameters(context, renamed)
        imports = self._event_imports(graph)
        values = setting_values(self.script)
        values.update({k: context.expression(e, renamed) for k, e in settings.items()})
        return Diagram(
            path=self.script.path, docstring=ast.get_docstring(self.script.tree) or "",
            graph=graph, context="\n\n".join([*filter(None, [context.text(renamed, imports)]),
                                              *functions]),
            settings=values, toolboxes=self._toolboxes())

    # structure ----------------------------------------------------------------------------------

    def _graph(self, blocks: Sequence[Block], connections: Sequence[Connection],
               events: Sequence[Any], parent: _Part | None) -> Graph:
        index = {id(b): i for i, b in enumerate(blocks)}
        wires = [w for c in connections for w in self._wires(c, index)]
        nodes = [self._block(block, i, wires, parent) for i, block in enumerate(blocks)]
        return Graph(nodes, wires, [self._event(e, parent) for e in events])

    def _wires(self, connection: Connection, index: dict[int, int]) -> Iterator[Wire]:
        source = connection.source
        for target in connection.targets:
            for end in (source, target):
                if id(end.block) not in index:
                    self.refuse(f"{self._called(end.block)} is wired but not in the list of blocks",
                                self._node(end.block))
            for out, into in zip(source.ports, target.ports, strict=True):
                yield Wire(index[id(source.block)], port_number(source.block.outputs, out),
                           index[id(target.block)], port_number(target.block.inputs, into))

    def _block(self, block: Block, i: int, wires: Sequence[Wire], parent: _Part | None) -> Node:
        node = Node("", type(block).__name__, line=getattr(self._node(block), "lineno", None))
        n_in = max((w.input + 1 for w in wires if w.target == i), default=0)
        n_out = max((w.output + 1 for w in wires if w.source == i), default=0)
        part = self._add(_Part(node, block, {}, parent=parent))
        node.inputs = _port_names(block, "input", n_in)
        node.outputs = _port_names(block, "output", n_out)
        if type(block) is Interface:
            return node
        if type(block) is Subsystem:
            self._construction(part, {"blocks", "connections", "events"})
            inside = [block.interface, *block.blocks]
            node.graph = self._graph(inside, block.connections, own_events(block), part)
            # the two sides of the interface have the same ports
            interface = node.graph.nodes[0]
            for mine, theirs in (("inputs", "outputs"), ("outputs", "inputs")):
                ports = max(getattr(node, mine), getattr(interface, theirs), key=len)
                setattr(node, mine, ports)
                setattr(interface, theirs, ports)
            return node
        parameters = self._known(block)
        self._construction(part, set(parameters))
        if node.type in _SYNCHRONOUS:
            more = max(len(node.inputs), len(node.outputs))
            node.inputs += [f"in {k}" for k in range(len(node.inputs), more)]
            node.outputs += [f"out {k}" for k in range(len(node.outputs), more)]
        return node

    def _known(self, block: Block) -> list[str]:
        """Parameter names of a block's class, which PathView must know."""
        kind = type(block)
        name = kind.__name__
        if kind.__module__.startswith("pathsim."):
            entry = self.registry["blocks"].get(name)
            toolbox, parameters = None, entry and entry["params"]
        else:
            toolbox = toolbox_of(kind)
            parameters = list(kind.info()["parameters"]) if toolbox else None
        if parameters is None:
            where = ("" if kind.__module__.startswith("pathsim.") else
                     "; its class must be exported by an installed package")
            self.refuse(unknown_block(name, self.registry) + where, self._node(block))
        if self.types.setdefault(name, (kind, toolbox))[0] is not kind:
            self.refuse(f"two blocks of the same class name {name!r} from different packages; "
                        "PathView knows blocks by class name only", self._node(block))
        return parameters

    def _event(self, event: Any, parent: _Part | None) -> Event:
        name = type(event).__name__
        entry = self.registry["events"].get(name)
        part = self._add(_Part(Event("", f"pathsim.events.{name}", {}), event, {}, parent=parent))
        if entry is None or not type(event).__module__.startswith("pathsim."):
            self.refuse(f"PathView does not know the event {name!r}", self._node(event))
        self._construction(part, set(entry["params"]))
        return part.target  # type: ignore[return-value]

    def _add(self, part: _Part) -> _Part:
        if id(part.value) in self.parts:
            self.refuse(f"{self._called(part.value)} is in the diagram twice",
                        self._node(part.value))
        self.parts[id(part.value)] = part
        return part

    # source -------------------------------------------------------------------------------------

    def _node(self, value: Any) -> ast.AST | None:
        made = self.script.construction(value)
        return made.node if made else None

    def _called(self, value: Any) -> str:
        names = self._variables(value)
        return repr(names[0]) if names else f"this {type(value).__name__}"

    def _variables(self, value: Any) -> list[str]:
        return [n for n, v in self.script.namespace.items() if v is value]

    def _construction(self, part: _Part, known: set[str]) -> None:
        """Arguments of the call that made a part, by parameter name."""
        made = self.script.construction(part.value)
        what = self._called(part.value)
        kind = type(part.value)
        if made is None:
            self.refuse(f"{what} is not built by the script itself")
        if made.around:
            self.refuse(f"{what} is built in {made.around}; PathView wants a statement of its own "
                        "for each block", made.node)
        if not made.direct:
            self.refuse(f"{what} is built by a function; PathView wants a plain call of "
                        f"{kind.__name__}(...)", made.node)
        names = [n for n, p in inspect.signature(kind.__init__).parameters.items()
                 if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)][1:]
        if isinstance(made.node, ast.FunctionDef):
            part.function = made.node
            part.arguments[names[0]] = ast.Name(made.node.name, ast.Load())
        else:
            part.arguments = self._arguments(made.node, names)
        for name in part.arguments:
            if name not in known or name.startswith("_"):
                self.refuse(f"PathView has no place for parameter {name!r} of {kind.__name__}",
                            made.node)
        if kind is Subsystem:  # what it is made of is read from the live one
            part.arguments = {}
        for name, value in part.arguments.items():
            if any(isinstance(n, (ast.NamedExpr, ast.Await, ast.Yield, ast.YieldFrom))
                   for n in ast.walk(value)):
                self.refuse(f"parameter {name!r} of {what} is not a plain expression", value)

    def _arguments(self, call: ast.Call, names: Sequence[str]) -> dict[str, ast.expr]:
        if any(isinstance(a, ast.Starred) for a in call.args) or any(
                k.arg is None for k in call.keywords):
            self.refuse("arguments given as *args or **kwargs; PathView wants them one by one",
                        call)
        if len(call.args) > len(names):
            self.refuse("arguments without a parameter name; PathView wants them named", call)
        return named_arguments(call, names)

    def _check_unchanged(self) -> None:
        parts = {n for n, v in self.script.namespace.items() if isinstance(v, PARTS)}
        for statement in self.script.statements:
            for name, node in self.script.changes(statement):
                if name in parts and not (
                        isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load)
                        and node.attr in _HARMLESS):
                    self.refuse(f"{name!r} is changed after it is built; PathView has no place "
                                "for that", node)
            call = statement.value if isinstance(statement, ast.Expr) else None
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Name):
                for name in sorted(passed(statement) & parts):
                    self.refuse(f"{call.func.id}() may change {name!r} after it is built; PathView "
                                "has no place for that", statement)

    def _check_order(self, context: Context) -> None:
        """PathView gives a parameter one value: it must not change between two blocks."""
        for part in self.parts.values():
            for node in part.arguments.values():
                line = getattr(node, "lineno", 0)
                for name in used(node):
                    after = context.bound_after(name, line)
                    if line and after and context.bound_before(name, line):
                        self.refuse(f"{name!r} changes after {self._called(part.value)} was built "
                                    "with it; PathView builds all blocks at the end", after)

    # names --------------------------------------------------------------------------------------

    def _name_parts(self, context: Context) -> dict[str, str]:
        """Name every part; returns the new names of the script's variables."""
        given: set[str] = set()
        other = _TAKEN | context.names
        renamed = {n: "sim" for n in self._variables(self.script.simulation)}
        for part in self.parts.values():
            prefix = _prefix(part.parent)
            variables = self._variables(part.value)
            if isinstance(part.value, Interface):
                part.target.name, part.variable = "Interface", f"{prefix}interface"
            else:
                wish = variables[0] if variables else type(part.value).__name__
                for start in (prefix, f"{part.parent.variable}_" if part.parent else ""):
                    wish = wish.removeprefix(start) or wish
                for name in _display_names(wish, type(part.value).__name__, other):
                    # PathView does not prefix the variable of a subsystem in a subsystem
                    part.variable = ("" if type(part.value) is Subsystem else prefix) + plain(name)
                    if part.variable not in given and _is_free(part.variable, other):
                        part.target.name = name
                        break
            given.add(part.variable)
            renamed.update({n: part.variable for n in variables})
        return renamed

    def _write_parameters(self, context: Context, renamed: dict[str, str]) -> list[str]:
        functions = []
        for part in self.parts.values():
            if part.function is not None:
                name = f"{part.variable}_function"
                while name in context.names:
                    name += "_"
                functions.append(context.function(part.function, name, renamed))
                part.target.params = dict.fromkeys(part.arguments, name)
            else:
                part.target.params = {k: context.expression(e, renamed)
                                      for k, e in part.arguments.items()}
        return functions

    def _event_imports(self, graph: Graph) -> list[str]:
        """Imports for events in subsystems: PathView imports only those of the top level."""
        top = {e.type for e in graph.events}
        inner = {p.target.type for p in self.parts.values() if isinstance(p.target, Event)} - top
        names = sorted(t.rpartition(".")[2] for t in inner)
        return [f"from pathsim.events import {', '.join(names)}"] if names else []

    def _toolboxes(self) -> list[Toolbox]:
        """The toolboxes in use, in an order in which the right one wins every class name."""
        owners = {name: toolbox for name, (_, toolbox) in self.types.items()}
        toolboxes = sorted({t for t in owners.values() if t}, key=lambda t: t.package)
        for order in itertools.permutations(toolboxes):
            wins: dict[str, Toolbox | None] = dict.fromkeys(owners)
            for toolbox in order:
                wins.update(dict.fromkeys(toolbox.blocks().keys() & owners.keys(), toolbox))
            if wins == owners:
                return list(order)
        self.refuse("blocks of the same class name in "
                    f"{' and '.join(t.package for t in toolboxes)} hide each other; "
                    "PathView knows blocks by class name only")


# Blocks of which PathView keeps as many outputs as inputs
_SYNCHRONOUS = {
    "Integrator", "Differentiator", "Delay", "Amplifier", "Sin", "Cos", "Tan", "Tanh", "Abs",
    "Sqrt", "Exp", "Log", "Log10", "Mod", "Clip", "Pow", "Polynomial", "Rescale", "Alias",
    "LogicNot", "SampleHold", "FirstOrderHold", "DiscreteIntegrator", "DiscreteDerivative",
}


def _port_names(block: Block, side: str, wired: int) -> list[str]:
    """Names of a block's ports: its labels, what it draws them from, or ``in 0``."""
    register = block.inputs if side == "input" else block.outputs
    labels = getattr(type(block), f"{side}_port_labels")
    if type(block) in (Interface, Subsystem):
        n = wired
    elif labels is not None:
        n = max(len(labels), wired)
    else:
        n = max(len(register), wired)
    # PathView shows eight characters: of a path, the last part says more than the first
    names = {i: name.rpartition("/")[2] or name
             for name, i in (port_names(register) or labels or {}).items()}
    if side == "input":
        drawn = getattr(block, "labels", None) or getattr(block, "operations", None) or ()
        if type(block).__name__ in ("Scope", "Spectrum", "Adder", "Divider"):
            n = max(n, len(drawn))
            names.update(enumerate(map(str, drawn)))
    n = max([n, *(i + 1 for i in names)])
    return [names.get(i, f"{side[:-3]} {i}") for i in range(n)]


def _prefix(parent: _Part | None) -> str:
    """What PathView puts before the variables of the blocks of a part."""
    if parent is None:
        return ""
    return prefix_inside(parent.target.name, _prefix(parent.parent))


def _is_free(variable: str, other: Collection[str]) -> bool:
    return not (keyword.iskeyword(variable) or variable in other
                or _GENERATED.fullmatch(variable))


def _display_names(variable: str, kind: str, other: Collection[str]) -> Iterator[str]:
    """Names for a block, the best first; ``pitch_rate`` is shown as "pitch rate"."""
    name = re.sub("_+", " ", variable).strip()
    if not plain(name):
        name = kind
    yield name
    if not _is_free(plain(name), other):
        name += " block"
        yield name
    yield from (f"{name} {i}" for i in itertools.count(2))
