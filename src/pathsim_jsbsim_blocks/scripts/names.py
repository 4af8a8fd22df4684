"""Which names a piece of Python source uses and binds, by Python's scoping rules."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)
_COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)


def references(node: ast.AST, local: frozenset[str] = frozenset()) -> Iterator[ast.Name]:
    """The ``Name`` nodes in ``node`` that refer to the module's scope, not to an inner one."""
    if isinstance(node, ast.Name):
        if node.id not in local:
            yield node
    elif isinstance(node, _FUNCTIONS):
        every, args = arguments(node), node.args
        body = node.body if isinstance(node.body, list) else [node.body]
        outer = [*args.defaults, *args.kw_defaults, *(a.annotation for a in every)]
        if not isinstance(node, ast.Lambda):
            outer += [*node.decorator_list, node.returns]
        yield from _all(filter(None, outer), local)
        yield from _all(body, local | {a.arg for a in every} | bound(body))
    elif isinstance(node, ast.ClassDef):
        yield from _all([*node.bases, *node.keywords, *node.decorator_list], local)
        yield from _all(node.body, local | bound(node.body))
    elif isinstance(node, _COMPREHENSIONS):
        # the first iterable belongs to the scope around the comprehension
        yield from references(node.generators[0].iter, local)
        inner = local | bound(g.target for g in node.generators)
        for field in ast.iter_child_nodes(node):
            if field is node.generators[0]:
                yield from _all(node.generators[0].ifs, inner)
            else:
                yield from references(field, inner)
    else:
        yield from _all(ast.iter_child_nodes(node), local)


def _all(nodes: Iterable[ast.AST], local: frozenset[str]) -> Iterator[ast.Name]:
    for node in nodes:
        yield from references(node, local)


def used(node: ast.AST) -> set[str]:
    """Names of the module that ``node`` reads, now or when a function in it is called."""
    # x += 1 and del x also need an x, although the syntax tree does not mark it as a Load
    targets = {id(n.target) for n in ast.walk(node) if isinstance(n, ast.AugAssign)}
    return {n.id for n in references(node) if not isinstance(n.ctx, ast.Store) or id(n) in targets}


def bound(nodes: Iterable[ast.AST]) -> frozenset[str]:
    """Names that ``nodes`` bind in their own scope."""
    names: set[str] = set()
    outer: set[str] = set()
    todo = list(nodes)
    while todo:
        node = todo.pop()
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            names.add(node.name)
        elif isinstance(node, (ast.Lambda, *_COMPREHENSIONS)):
            pass
        elif isinstance(node, (ast.Global, ast.Nonlocal)):
            outer.update(node.names)
        else:
            if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
                names.add(node.id)
            elif isinstance(node, ast.alias):
                names.add((node.asname or node.name).partition(".")[0])
            elif isinstance(node, (ast.ExceptHandler, ast.MatchAs, ast.MatchStar)) and node.name:
                names.add(node.name)
            todo.extend(ast.iter_child_nodes(node))
    return frozenset(names - outer)


def arguments(function: ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda) -> list[ast.arg]:
    """All arguments of a function's definition, those with a position first."""
    a = function.args
    return [*a.posonlyargs, *a.args, *a.kwonlyargs, *filter(None, (a.vararg, a.kwarg))]


def own(nodes: Iterable[ast.AST]) -> list[ast.AST]:
    """Nodes and what is in them, in their order, without the bodies of functions and classes."""
    every: list[ast.AST] = []
    todo = [*nodes][::-1]
    while todo:
        node = todo.pop()
        every.append(node)
        if not isinstance(node, (*_FUNCTIONS, ast.ClassDef)):
            todo += [*ast.iter_child_nodes(node)][::-1]
    return every


def assignments(node: ast.AST) -> Iterator[tuple[ast.Name, ast.expr]]:
    """Variables and expressions of an assignment, those of ``a, b = 1, 2`` one by one."""
    if isinstance(node, ast.Assign):
        for target in node.targets:
            yield from _matched(target, node.value)
    elif isinstance(node, (ast.AnnAssign, ast.NamedExpr)) and node.value is not None:
        yield from _matched(node.target, node.value)


def _matched(target: ast.expr, value: ast.expr) -> Iterator[tuple[ast.Name, ast.expr]]:
    lists = (ast.Tuple, ast.List)
    if isinstance(target, ast.Name):
        yield target, value
    elif isinstance(target, lists) and isinstance(value, lists):
        same_length = len(target.elts) == len(value.elts)
        for inner, part in zip(target.elts, value.elts, strict=True) if same_length else ():
            yield from _matched(inner, part)
