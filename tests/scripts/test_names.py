"""Which names source uses and binds: Python's scoping rules, case by case."""

import ast

import pytest

from pathsim_jsbsim_blocks.scripts.names import bound, used


def statement(text):
    return ast.parse(text).body[0]


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("a + b.c[d](e=f)", "abdf"),
        ("lambda x, y=z, *v, w=u, **k: x + y + v + w + k + g", "zug"),
        ("def f(x: t = d) -> r:\n    y = x\n    return y + g", "tdrg"),
        ("def f():\n    global y\n    y = y + 1", "y"),
        ("def f():\n    import m as y\n    for z in y: pass\n    return y + z", ""),
        ("def f():\n    def h(): return q\n    return h", "q"),
        ("def f():\n    try: pass\n    except E as e: return e", "E"),
        ("def f(x):\n    return lambda: x + g", "g"),
        ("@d\ndef f(): pass", "d"),
        ("class C(B):\n    x = a\n    y = x", "Ba"),
        ("[x + a for x in b if x > c]", "abc"),
        ("[x for x in x]", "x"),
        ("{k: v for k, v in d.items()}", "d"),
        ("sum(x * y for x in a for y in x)", ["sum", "a"]),
        ("f'{a:{w}} {b!r}'", "awb"),
        ("x = a", "a"),
        ("a += b", "ab"),
        ("a[i] += b", "aib"),
        ("def f():\n    global y\n    y += 1", "y"),
        ("def f():\n    global y\n    del y", "y"),
        ("def f():\n    global y\n    y = 1", ""),
        ("def f(y):\n    y += g", "g"),
    ],
)
def test_used(text, names):
    assert used(statement(text)) == set(names)


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("a = b = c", "ab"),
        ("a, (b, *c) = d", "abc"),
        ("a: int = 1", "a"),
        ("a += 1", "a"),
        ("import x.y, z as w", "xw"),
        ("from m import a as b", "b"),
        ("def f(x): y = 1", "f"),
        ("class C:\n    x = 1", "C"),
        ("for i in x:\n    y = i", "iy"),
        ("with o as f: g = 1", "fg"),
        ("[x for x in y]", ""),
        ("a = lambda x: x", "a"),
        ("(n := 1)", "n"),
        ("del a", "a"),
        ("try: a = 1\nexcept E as e: b = 2", "aeb"),
        ("match x:\n    case [a, *b]: pass\n    case C() as c: pass", "abc"),
    ],
)
def test_bound(text, names):
    assert bound([statement(text)]) == set(names)
