"""Read a diagram script: structure from the live diagram, expressions from the source.

A parameter keeps its expression if the model's code can evaluate it. Otherwise, or if the result
differs from the diagram's value (``ByValue``), that value is written.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import itertools
import keyword
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, NoReturn

from pathsim import Connection, Interface, Subsystem
from pathsim.blocks import Block

from .._core.pathsim_internals import own_events, port_names
from ..scripts.first_run import FirstRun, named_arguments
from ..scripts.names import used
from .code import Code
from .diagram import Diagram, Event, Graph, Node, Part, Wire, ends
from .literals import Unwritable, definition, literal, memories, top_level
from .settings import setting_expressions, setting_values
from .toolboxes import Toolbox, core_registry, toolbox_of, unknown_block
from .variables import plain, prefix_inside

# variables of PathView's own script
_OWN = "np plt blocks connections events sim json gc sys traceback base64"
_TAKEN = {*_OWN.split(), *dir(builtins)}
_BY_NAME = "PathView knows blocks by class name only"
_GENERATED = re.compile(r"blocks|connections|events|sim|conn_\d+")


# parameters to write with their values: the ``id`` of a part, or None for a setting, and the name
ByValue = set[tuple[int | None, str]]


def read_diagram(script: FirstRun, by_value: ByValue, without: Collection[int] = ()) -> Diagram:
    """Everything in a diagram script; a `DiagramError` names what PathView cannot represent."""
    return _Reader(script, by_value, without).diagram()


class _Reader:
    def __init__(self, script: FirstRun, by_value: ByValue, without: Collection[int]):
        self.script = script
        self.refuse, self._called = script.refuse, script.called
        self.by_value = by_value
        self.code = Code(script, without)
        self.stand_ins: dict[str, Any] = {}
        self.values: dict[int, str] = {}  # of functions' variables: what can change, by id
        self.memories: dict[int, Any] = {}
        self.literals: list[tuple[Part, str, Any]] = []  # parameters written with their values
        self.registry = core_registry()
        self.parts: dict[int, Part] = {}
        self.types: dict[str, tuple[type[Block], Toolbox | None]] = {}

    def diagram(self) -> Diagram:
        sim = self.script.simulation
        if sim.time:
            where = f"the simulation is at t = {sim.time:g} when its first run begins"
            self.refuse(f"{where}; PathView starts at 0", self.script.run_call)
        graph = self._graph(sim.blocks, sim.connections, sim.events, None)
        for part in self.parts.values():
            self._settle(part)
        for part, name, value in self.literals:  # a function may change them
            held = [n for n in self.script.names_of(value) if n in self.code.names]
            if held or id(value) in self.values:
                known = held[0] if held else self.values[id(value)]
                part.arguments[name] = ast.Name(known, ast.Load())
        settings = self._settings()
        code = self.code
        for name in sorted(code.names):
            if _GENERATED.fullmatch(name):
                self.refuse(f"PathView's own code uses the name {name!r}; rename it")
        renamed = self._name_parts(code)
        for name in sorted(code.parts - renamed.keys()):
            self.refuse(f"a function refers to {name!r}, which is not in the simulation")
        renamed = {old: new for old, new in renamed.items() if old != new}
        for part in self.parts.values():
            part.target.params = {k: code.expression(e, renamed) for k, e in part.arguments.items()}
        imports = self._event_imports(graph)
        values = setting_values(self.script)
        values.update({k: code.expression(e, renamed) for k, e in settings.items()})
        return Diagram(
            path=self.script.path,
            docstring=ast.get_docstring(self.script.tree) or "",
            graph=graph,
            context=code.text(renamed, imports),
            settings=values,
            toolboxes=self._toolboxes(),
            log=bool(sim.log),
            code_values=code.values(),
            places=self.code.places,
            parts={part.variable: part for part in self.parts.values()},
        )

    def _settings(self) -> dict[str, ast.expr]:
        found = {}
        for name, node in setting_expressions(self.script).items():
            local = self.script.local_names(node)
            if (None, name) not in self.by_value and self._stands_alone(node, local):
                found[name] = node
                self.code.need(node)
        return found

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
        kind = type(connection)
        if kind is not Connection:
            reason = f"a connection is a {kind.__name__}; PathView has PathSim's Connection only"
            self._refuse(connection.source.block, reason)
        for source, out, target, into in ends(connection):
            for block in (source, target):
                if id(block) not in index:
                    reason = f"{self._called(block)} is wired but not in the list of blocks"
                    self._refuse(block, reason)
            yield Wire(index[id(source)], out, index[id(target)], into)

    def _block(self, block: Block, i: int, wires: Sequence[Wire], parent: Part | None) -> Node:
        kind = _built_in(type(block))
        node = Node("", kind.__name__)
        n_in = max((w.input + 1 for w in wires if w.target == i), default=0)
        n_out = max((w.output + 1 for w in wires if w.source == i), default=0)
        part = self._add(Part(node, block, kind, parent=parent))
        node.inputs = _port_names(block, kind, "input", n_in)
        node.outputs = _port_names(block, kind, "output", n_out)
        if kind is Interface:
            return node
        if kind is Subsystem:
            self._construction(part, ["blocks", "connections", "events"])
            part.known, part.arguments = (), {}  # they are read from the live subsystem
            inside = [block.interface, *block.blocks]
            node.graph = self._graph(inside, block.connections, own_events(block), part)
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

    def _known(self, block: Block, kind: type[Block]) -> list[str]:
        """Parameter names of a block's class, which PathView must know."""
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
                hint = "; JSBSim runs ahead of the clock in a function: use Aircraft or JSBSimFDM"
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
        self.parts[id(part.value)] = part
        return part

    # source -------------------------------------------------------------------------------------

    def _refuse(self, value: Any, reason: str, node: ast.AST | None = None) -> NoReturn:
        """Refuse a part, by default with the line that builds it."""
        built_at = self.script.built_at
        node = node or built_at(value) or built_at(self.script.simulation)
        self.refuse(reason, node)

    def _construction(self, part: Part, known: Sequence[str]) -> None:
        """The arguments of a part, by parameter name, as the source gives them."""
        part.known = known
        made, parameters = self.script.construction(part.value), _parameters(part.kind)
        arguments = None
        if made and made.given is not None and part.kind is type(part.value):
            arguments = _plain_arguments(made.node, parameters)
        if made is None or made.given is None or arguments is None:
            for name in known:
                default = parameters[name].default if name in parameters else ...
                if not _is_default(getattr(part.value, name, default), default):
                    self.by_value.add((id(part.value), name))
            return
        for name, node in arguments.items():
            if name not in known or name.startswith("_"):
                reason = f"PathView cannot represent parameter {name!r} of {part.kind.__name__}"
                self._refuse(part.value, reason)
            now = getattr(part.value, name, None)
            if self._is_own(now) and made.given.get(name, now) is not now:
                self.by_value.add((id(part.value), name))  # replaced
            else:
                part.arguments[name] = node

    def _is_own(self, value: Any) -> bool:
        """Whether a value is a function of the script."""
        return inspect.isfunction(value) and value.__code__.co_filename == str(self.script.path)

    def _definition(self, function: Any) -> Any:
        return definition(function, self.script.tree) if self._is_own(function) else None

    def _settle(self, part: Part) -> None:
        """Give every parameter an expression that the model's code can evaluate."""
        for name in part.known:
            if (id(part.value), name) in self.by_value:
                part.arguments[name] = self._written(part, name)
        made = self.script.construction(part.value)
        local = self.script.local_names(made.node) if made else set[str]()
        for name, node in part.arguments.items():
            if not self._stands_alone(node, local):
                part.arguments[name] = node = self._written(part, name)
            self.code.need(node)

    @staticmethod
    def _stands_alone(node: ast.expr, local: set[str]) -> bool:
        """Whether an expression of the source may mean the same at the top level."""
        active = (ast.NamedExpr, ast.Await, ast.Yield, ast.YieldFrom)
        return not used(node) & local and not any(isinstance(n, active) for n in ast.walk(node))

    def _written(self, part: Part, name: str) -> ast.expr:
        """An expression for the value of a parameter."""
        node, made = part.arguments.get(name), self.script.construction(part.value)
        value = getattr(part.value, name, ((made and made.given) or {}).get(name, ...))
        what = f"parameter {name!r} of {self._called(part.value)}"
        where = node if hasattr(node, "lineno") else None
        if value is ...:
            self._refuse(part.value, f"{what} cannot be read from the block", where)
        try:
            if not inspect.isfunction(value):
                if any(memories(value)):
                    self.literals.append((part, name, value))
                return _without_places(ast.parse(literal(value), mode="eval").body)
            source = node if isinstance(node, ast.Lambda) else self._definition(value)
            function = _without_places(top_level(value, source, self._stand_in, self._value))
        except Unwritable as unwritable:
            reason = f"{what}: {unwritable}; write it at the top level, under a name"
            self._refuse(part.value, reason, where)
        if isinstance(function, ast.Lambda):
            return function
        function.name = self._free(function.name, "_function")
        function.decorator_list, function.returns = [], None
        return self._made(function.name, function)

    def _free(self, name: str, more: str = "_") -> str:
        while name in self.script.namespace or name in self.code.made:
            name += more
        return name

    def _made(self, name: str, statement: ast.stmt) -> ast.Name:
        self.code.made[name] = statement
        self.code.need(statement)
        return ast.Name(name, ast.Load())

    def _value(self, variable: str, value: Any) -> ast.expr:
        """An expression for the value of a function's variable.

        What can change gets a name, because another function may have it too.
        """
        if value is None or isinstance(value, (bool, int, float, complex, str, tuple)):
            return ast.parse(literal(value), mode="eval").body
        held = [n for n, v in self.script.namespace.items() if v is value]
        if held:
            return ast.Name(held[0], ast.Load())
        if id(value) not in self.values:
            for memory in memories(value):
                if self.memories.setdefault(memory, value) is not value:
                    raise Unwritable(
                        f"{variable!r} shares memory with a variable of another function"
                    )
            name = self.values[id(value)] = self._free(variable)
            self._made(name, _without_places(ast.parse(f"{name} = {literal(value)}").body[0]))
        return ast.Name(self.values[id(value)], ast.Load())

    def _stand_in(self, value: Any) -> str | None:
        """A name for a part to which a function refers, until the parts are named."""
        if value is self.script.simulation or id(value) in self.parts:
            self.stand_ins[f"__part_{id(value)}"] = value
            return f"__part_{id(value)}"
        return None

    # names --------------------------------------------------------------------------------------

    def _name_parts(self, code: Code) -> dict[str, str]:
        """Name every part; returns the new names of the script's variables."""
        given: set[str] = set()
        other = _TAKEN | code.names | self._locals(code)
        renamed = {n: "sim" for n in self.script.names_of(self.script.simulation)}
        for part in self.parts.values():
            prefix = _prefix(part.parent)
            variables = self.script.names_of(part.value)
            if isinstance(part.value, Interface):
                part.target.name, part.variable = "Interface", f"{prefix}interface"
            else:
                wish = variables[0] if variables else self._original_name(part)
                wish = wish or part.kind.__name__
                for start in (prefix, f"{part.parent.variable}_" if part.parent else ""):
                    wish = wish.removeprefix(start) or wish
                for name in _display_names(wish, part.kind.__name__, other):
                    # PathView does not prefix the variable of a subsystem in a subsystem
                    part.variable = ("" if part.kind is Subsystem else prefix) + plain(name)
                    if part.variable not in given and _is_free(part.variable, other):
                        part.target.name = name
                        break
            given.add(part.variable)
            renamed.update({n: part.variable for n in variables})
        for name, value in self.stand_ins.items():
            whole = value is self.script.simulation
            renamed[name] = "sim" if whole else self.parts[id(value)].variable
        return renamed

    def _locals(self, code: Code) -> set[str]:
        """Variables of the functions that refer to parts; they would shadow a part of that name."""
        expressions = (e for p in self.parts.values() for e in p.arguments.values())
        parts = code.parts | self.stand_ins.keys()
        functions = [
            node
            for top in (*code.nodes(), *expressions)
            for node in ast.walk(top)
            if isinstance(node, (ast.FunctionDef, ast.Lambda)) and used(node) & parts
        ]
        inside = [n for function in functions for n in ast.walk(function)]
        stored = {n.id for n in inside if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        return stored | {n.arg for n in inside if isinstance(n, ast.arg)}

    def _original_name(self, part: Part) -> str:
        """A name for a part that no variable of the module holds: its key or its original name."""
        for value in self.script.namespace.values():
            if isinstance(value, dict):
                for key, item in value.items():
                    if item is part.value and isinstance(key, str):
                        return key
        target = self.script.target(part.value)
        held = self.script.namespace.get(target)
        return "" if isinstance(held, (list, tuple, dict)) else target

    def _event_imports(self, graph: Graph) -> list[str]:
        """Imports for events in subsystems: PathView imports only those of the top level."""
        top = {e.type for e in graph.events}
        inner = {p.target.type for p in self.parts.values() if isinstance(p.target, Event)} - top
        names = sorted(t.rpartition(".")[2] for t in inner)
        return [f"from pathsim.events import {', '.join(names)}"] if names else []

    def _toolboxes(self) -> list[Toolbox]:
        """The toolboxes in use, ordered so that every class name resolves to the right one."""
        owners = {name: toolbox for name, (_, toolbox) in self.types.items()}
        toolboxes = sorted({t for t in owners.values() if t}, key=lambda t: t.package)
        for order in itertools.permutations(toolboxes):
            found = {name: toolbox for toolbox in order for name in toolbox.blocks()}
            if all(found.get(name) == toolbox for name, toolbox in owners.items()):
                return list(order)
        names = " and ".join(t.package for t in toolboxes)
        self.refuse(f"blocks of the same class name in {names} hide each other; {_BY_NAME}")


# Blocks of which PathView keeps as many outputs as inputs
_SYNCHRONOUS = (
    "Integrator Differentiator Delay Amplifier Sin Cos Tan Tanh Abs Sqrt Exp Log Log10 Mod Clip "
    "Pow Polynomial Rescale Alias LogicNot SampleHold FirstOrderHold DiscreteIntegrator "
    "DiscreteDerivative"
)


def _port_names(block: Block, kind: type[Block], side: str, wired: int) -> list[str]:
    """Names of a block's ports: its labels, names derived from its parameters, or ``in 0``."""
    register = block.inputs if side == "input" else block.outputs
    labels = kind.info()[f"{side}_port_labels"]
    n = wired
    if kind not in (Interface, Subsystem):
        n = max(len(register if labels is None else labels), wired)
    # PathView shows eight characters, so keep the last part of a path
    names = {
        i: name.rpartition("/")[2] or name
        for ports in (port_names(register), labels or {})
        for name, i in ports.items()
    }
    names.update(enumerate(getattr(block, "drawn_ports", {}).get(side, ())))
    if side == "input":
        drawn = getattr(block, "labels", None) or getattr(block, "operations", None) or ()
        if kind.__name__ in ("Scope", "Spectrum", "Adder", "Divider"):
            n = max(n, len(drawn))
            names.update(enumerate(map(str, drawn)))
    n = max([n, *(i + 1 for i in names)])
    return [names.get(i, f"{side[:-3]} {i}") for i in range(n)]


def _built_in(kind: type[Block]) -> type[Block]:
    """The class that PathView may know: the base of a class that only adds ``__init__``."""
    while not kind.__module__.startswith("pathsim.") and len(kind.__bases__) == 1:
        base = kind.__bases__[0]
        own = vars(kind).keys() - {"__init__", *vars(type("", (), {}))}
        if (
            not issubclass(base, Block)
            or base is Block
            or any(hasattr(base, n) for n in own)
            or own & _parameters(base).keys()
            or toolbox_of(kind)
        ):
            break
        kind = base
    return kind


def _parameters(kind: type) -> Mapping[str, inspect.Parameter]:
    return inspect.signature(kind).parameters


def _plain_arguments(
    call: ast.expr, parameters: Mapping[str, inspect.Parameter]
) -> dict[str, ast.expr] | None:
    """The arguments of a call in which each corresponds to one parameter; None of others."""
    if not isinstance(call, ast.Call):
        return None
    names = [
        n for n, p in parameters.items() if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)
    ]
    starred = [a for a in call.args if isinstance(a, ast.Starred)]
    if starred or len(call.args) > len(names) or any(k.arg is None for k in call.keywords):
        return None
    return named_arguments(call, names)


def _is_default(value: Any, default: Any) -> bool:
    if value is default:
        return True
    try:
        return type(value) is type(default) and bool(value == default)
    except ValueError:  # arrays
        return False


def _prefix(parent: Part | None) -> str:
    """What PathView puts before the variables of the blocks of a part."""
    if parent is None:
        return ""
    return prefix_inside(parent.target.name, _prefix(parent.parent))


def _is_free(variable: str, other: Collection[str]) -> bool:
    return not (keyword.iskeyword(variable) or variable in other or _GENERATED.fullmatch(variable))


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


def _without_places(node: Any) -> Any:
    """A node that is not in the script's source."""
    for inner in ast.walk(node):
        for name in ("lineno", "end_lineno", "col_offset", "end_col_offset"):
            inner.__dict__.pop(name, None)
    return node
