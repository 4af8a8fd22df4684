"""Ninety small PathSim scripts as a stranger may write them, and what an export must make of each.

"equal": it becomes a model that flies as the script does. "refused": PathView cannot hold it.
"either": a model that is right will do, and so will a refusal.
"""

HEAD = """
import numpy as np
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import *
from pathsim.events import *
"""
SRC = """
scope = Scope()
sim = Simulation([src, scope], [Connection(src, scope)], dt=0.05, log=False)
sim.run(0.5)
"""
TWO = """
scope = Scope()
sim = Simulation([src, two, scope], [Connection(src, scope[0]), Connection(two, scope[1])],
                 dt=0.05, log=False)
sim.run(0.5)
"""
AMP = """
src, scope = Source(np.sin), Scope()
sim = Simulation([src, amp, scope], [Connection(src, amp), Connection(amp, scope)], dt=0.05, log=False)
sim.run(0.5)
"""
DECAY = """
x, gain, scope = Integrator(1.0), Amplifier(-2.0), Scope()
sim = Simulation([x, gain, scope], [Connection(x, gain, scope), Connection(gain, x)],
                 dt=0.05, log=False)
"""

SHARED = {
    "list of two functions": (
        """
hits = [0]
def wave(t):
    hits[0] += 1
    return float(hits[0])
src, two = Source(wave), Source(lambda t: 10.0 * hits[0])
"""
        + TWO,
        "equal",
    ),
    "dict of two functions": (
        """
memory = {"last": 0.0}
def keep(t):
    memory["last"] += t
    return memory["last"]
def tell(t):
    return -memory["last"]
src = Source(keep)
two = Source(tell)
"""
        + TWO,
        "equal",
    ),
    "dataclass": (
        """
from dataclasses import dataclass, field
@dataclass
class Plant:
    k: float = 2.0
    log: list = field(default_factory=list)
plant = Plant(k=3.0)
def wave(t):
    plant.log.append(t)
    return plant.k * t
src, two = Source(wave), Source(lambda t: len(plant.log) + 0.0)
"""
        + TWO,
        "equal",
    ),
    "list in two partials": (
        """
from functools import partial
def grow(bag, t):
    bag.append(t)
    return sum(bag)
def size(bag, t):
    return float(len(bag))
bag = []
src, two = Source(partial(grow, bag)), Source(partial(size, bag))
"""
        + TWO,
        "equal",
    ),
    "default argument of two functions": (
        """
def grow(t, bag=[]):
    bag.append(t)
    return sum(bag)
def size(t, bag=grow.__defaults__[0]):
    return float(len(bag))
src, two = Source(grow), Source(size)
"""
        + TWO,
        "equal",
    ),
    "view of an array": (
        """
buffer = np.zeros(3)
tail = buffer[1:]
def write(t):
    buffer[2] = t
    return t
src, two = Source(write), Source(lambda t: tail[1])
"""
        + TWO,
        "equal",
    ),
    "list within a factory": (
        """
def build():
    hits = [0]
    def wave(t):
        hits[0] += 1
        return float(hits[0])
    return Source(wave), Source(lambda t: 10.0 * hits[0])
src, two = build()
"""
        + TWO,
        "equal",
    ),
    "list within a factory, used late": (
        """
def build():
    hits = [0]
    def wave(t):
        hits[0] += 1
        return t
    return Source(wave), Source(lambda t: t if t < 5 else float(hits[0]))
src, two = build()
"""
        + TWO,
        "equal",
    ),
    "view within a factory": (
        """
def build(n):
    store = np.zeros(n)
    view = store[:1]
    def put(t):
        store[0] = t
        return t
    return Source(put), Source(lambda t: view[0])
src, two = build(4)
"""
        + TWO,
        "refused",
    ),
    "view by alias, changed later": (
        """
limits = np.array([1.0, 2.0])
upper = limits[1:]
upper[0] = 9.0
src = Source(lambda t: min(20 * t, limits[1]))
"""
        + SRC,
        "either",
    ),
    "object with two methods": (
        """
class Counter:
    def __init__(self, start):
        self.n = start
    def up(self, t):
        self.n += 1
        return float(self.n)
    def look(self, t):
        return float(self.n)
counter = Counter(5)
src, two = Source(counter.up), Source(counter.look)
"""
        + TWO,
        "equal",
    ),
    "callable object": (
        """
class Ramp:
    slope = 2.0
    def __call__(self, t):
        return self.slope * t
src = Source(Ramp())
"""
        + SRC,
        "equal",
    ),
    "deque": (
        """
from collections import deque
window = deque(maxlen=3)
def mean(t):
    window.append(t)
    return sum(window) / len(window)
src = Source(mean)
"""
        + SRC,
        "equal",
    ),
    "attribute of a function": (
        """
def wave(t):
    wave.calls += 1
    return float(wave.calls)
wave.calls = 0
src = Source(wave)
"""
        + SRC,
        "equal",
    ),
    "attribute of a function, set late by another": (
        """
def wave(t):
    return t if t < 5 else wave.limit
wave.limit = 7.0
def relax(f):
    f.limit = 8.0
    return f
same = relax(wave)
src = Source(wave)
"""
        + SRC,
        "refused",
    ),
    "table of decorated functions": (
        """
WAVES = {}
def register(f):
    WAVES[f.__name__] = f
    return f
@register
def slow(t):
    return 0.5 * t
src = Source(lambda t: WAVES["slow"](t))
"""
        + SRC,
        "either",
    ),
    "cell of a counter": (
        """
def counter():
    n = 0
    def count(t):
        nonlocal n
        n += 1
        return float(n)
    return count
src = Source(counter())
"""
        + SRC,
        "equal",
    ),
    "memory of a cached function": (
        """
from functools import lru_cache
import itertools
ticket = itertools.count()
@lru_cache
def gain(x):
    return float(next(ticket))
first = gain(2.0)
src = Source(lambda t: gain(1.0) if t > 0.2 else 0.0)
"""
        + SRC,
        "refused",
    ),
    "dict subclass attribute by assigned call": (
        """
class Table(dict):
    scale = 1.0
    def tuned(self, k):
        self.scale = k
        return self
table = Table(a=2.0)
same = table.tuned(5.0)
src = Source(lambda t: t if t < 5 else table.scale * table["a"])
"""
        + SRC,
        "refused",
    ),
    "partial's keyword list grown later": (
        """
from functools import partial
def f(t, k=None):
    return sum(k) * t
p = partial(f, k=[1.0])
p.keywords["k"].append(2.0)
src = Source(p)
"""
        + SRC,
        "equal",
    ),
    "list shared with an event, in a factory": (
        """
def build():
    k = np.array([1.0])
    def late(t):
        k[0] = 9.0
    return Amplifier(k), ScheduleList([3.0], func_act=late)
amp, ev = build()
src, scope = Source(np.sin), Scope()
sim = Simulation([src, amp, scope], [Connection(src, amp), Connection(amp, scope)],
   [ev], dt=0.05, log=False)
sim.run(0.5)
""",
        "either",
    ),
}

CHANGED = {
    "object changed by an assigned call": (
        """
class Config:
    def __init__(self):
        self.limit = 1.0
    def scaled(self, k):
        self.limit *= k
        return True
config = Config()
ok = config.scaled(4.0)
src = Source(lambda t: min(t, config.limit))
"""
        + SRC,
        "refused",
    ),
    "slots changed by an assigned call": (
        """
class Config:
    __slots__ = ("limit",)
    def __init__(self):
        self.limit = 1.0
    def scaled(self, k):
        self.limit *= k
        return True
config = Config()
ok = config.scaled(4.0)
src = Source(lambda t: min(t, config.limit))
"""
        + SRC,
        "refused",
    ),
    "object changed by a call": (
        """
class Config:
    limit = 1.0
    def relax(self):
        self.limit = 3.0
config = Config()
config.relax()
src = Source(lambda t: min(30 * t, config.limit))
"""
        + SRC,
        "equal",
    ),
    "class changed": (
        """
class Config:
    limit = 1.0
Config.limit = 3.0
src = Source(lambda t: min(30 * t, Config.limit))
"""
        + SRC,
        "equal",
    ),
    "method of an own class replaced": (
        """
class Law:
    def u(self, t):
        return t
law = Law()
Law.u = lambda self, t: 2 * t
src = Source(law.u)
"""
        + SRC,
        "equal",
    ),
    "limit popped": (
        """
limits = {"soft": 5.0}
old = limits.pop("soft")
src = Source(lambda t: min(t, limits.get("soft", 9.0)))
"""
        + SRC,
        "refused",
    ),
    "limit updated": (
        """
limits = {"soft": 5.0}
limits.update(soft=0.2)
src = Source(lambda t: min(t, limits["soft"]))
"""
        + SRC,
        "equal",
    ),
    "limit bound twice": (
        """
LIMIT = 5.0
src = Source(lambda t: min(t, LIMIT))
LIMIT = 0.3
"""
        + SRC,
        "equal",
    ),
    "limit changed by a function in a function": (
        """
limits = [5.0]
def set_it():
    limits[0] = 8.0
def prepare():
    set_it()
prepare()
src = Source(lambda t: min(t, limits[0]))
"""
        + SRC,
        "equal",
    ),
    "global set by a function only": (
        """
def setup():
    global LIMIT
    LIMIT = 0.25
setup()
src = Source(lambda t: min(t, LIMIT))
"""
        + SRC,
        "equal",
    ),
    "limit bound by exec": (
        """
exec("LIMIT = 8.0")
src = Source(lambda t: t if t < 5 else LIMIT)
"""
        + SRC,
        "refused",
    ),
    "limit bound through globals": (
        """
globals()["LIMIT"] = 8.0
src = Source(lambda t: t if t < 5 else LIMIT)
"""
        + SRC,
        "refused",
    ),
    "limit bound beside a block": (
        """
amp, LIMIT = Amplifier(3.0), 8.0
two = Source(lambda t: t if t < 5 else LIMIT)
src = Source(lambda t: t)
"""
        + TWO,
        "refused",
    ),
    "function chosen by a block": (
        """
def limit():
    return 5.0
amp = Amplifier(2.0)
def pick(block):
    return (lambda: 9.0) if block.gain > 1 else (lambda: 7.0)
limit = pick(amp)
src = Source(lambda t: t if t < 5 else limit())
"""
        + SRC,
        "refused",
    ),
    "table filled in a comprehension": (
        """
table = []
_ = [table.append(0.1 * i) for i in range(4)]
src = Source(lambda t: table[int(4 * t)])
"""
        + SRC,
        "refused",
    ),
    "gain of a block changed": (
        """
amp = Amplifier(2.0)
amp.gain += 1.5
"""
        + AMP,
        "equal",
    ),
    "source function replaced": (
        """
src = Source(lambda t: t)
src.func = lambda t: 2 * t
"""
        + SRC,
        "equal",
    ),
    "parameters that __dict__ changes": (
        """
class Config:
    limit = 4.0
config = Config()
vars(config)["limit"] = 6.0
src = Source(lambda t: t if t < 5 else config.limit)
"""
        + SRC,
        "either",
    ),
    "code of a function exchanged": (
        """
def f(t):
    return t
def g(t):
    return t if t < 5 else 9.0
_ = setattr(f, "__code__", g.__code__)
src = Source(f)
"""
        + SRC,
        "either",
    ),
    "spline changed by assigned call": (
        """
from scipy.interpolate import interp1d
f = interp1d([0, 1.0], [0, 2.0], bounds_error=False, fill_value=0.0)
_ = setattr(f, "fill_value", 9.0)
src = Source(lambda t: float(f(t)))
"""
        + SRC,
        "refused",
    ),
    "dataclass replaced": (
        """
from dataclasses import dataclass, replace
@dataclass(frozen=True)
class Cfg:
    k: float = 1.0
cfg = Cfg()
cfg = replace(cfg, k=3.0)
src = Source(lambda t: cfg.k * t)
"""
        + SRC,
        "equal",
    ),
    "singledispatch": (
        """
from functools import singledispatch
@singledispatch
def law(x):
    return 1.0
_ = law.register(float, lambda x: 2.0 * x)
src = Source(lambda t: law(float(t)) if t > 5 else t)
"""
        + SRC,
        "refused",
    ),
    "functions that name another key": (
        """
K = {"soft": 1.0, "hard": 2.0}
laws = [lambda: K["soft"]]
_ = laws.__setitem__(0, lambda: K["hard"])
src = Source(lambda t: t if t < 5 else laws[0]())
"""
        + SRC,
        "refused",
    ),
}

RANDOM = {
    "drawn then changed": (
        """
rng = np.random.default_rng(3)
gains = rng.normal(size=3)
gains[1] = 0.0
amp = Amplifier(gains[0] + gains[1])
"""
        + AMP,
        "equal",
    ),
    "drawn, then doubled": (
        """
np.random.seed(4)
amp = Amplifier(np.random.rand())
amp.gain *= 2
"""
        + AMP,
        "equal",
    ),
    "numpy's seed under another name": (
        """
from numpy.random import seed as s, rand as r
s(4)
amp = Amplifier(r())
"""
        + AMP,
        "equal",
    ),
    "random.seed": (
        """
import random
random.seed(11)
src = Source(lambda t: random.random())
"""
        + SRC,
        "equal",
    ),
    "random under another name": (
        """
import random as dice
dice.seed(11)
src = Source(lambda t: dice.gauss(0, 1))
"""
        + SRC,
        "equal",
    ),
    "RandomState": (
        """
rs = np.random.RandomState(4)
src = Source(lambda t: rs.rand())
"""
        + SRC,
        "equal",
    ),
    "RandomState already drawn from, used late": (
        """
rs = np.random.RandomState(4)
burn = rs.rand()
src = Source(lambda t: t if t < 5 else rs.rand())
"""
        + SRC,
        "refused",
    ),
    "Generator already drawn from, used late": (
        """
rng = np.random.default_rng(4)
burn = rng.normal()
src = Source(lambda t: t if t < 5 else rng.normal())
"""
        + SRC,
        "refused",
    ),
    "generator shared with a block": (
        """
rng = np.random.default_rng(4)
amp = Amplifier(rng.normal())
src = Source(lambda t: rng.normal())
"""
        + TWO.replace("two", "amp"),
        "either",
    ),
    "shuffled list": (
        """
import random
order = [1.0, 2.0, 3.0]
random.Random(5).shuffle(order)
amp = Amplifier(order[0])
"""
        + AMP,
        "equal",
    ),
    "order of a set of texts": (
        """
names = {"roll", "pitch", "yaw", "flap"}
src = Source(lambda t: float(len(list(names)[0])) if t > 0.2 else 0.0)
"""
        + SRC,
        "either",
    ),
    "hash of a text": ("amp = Amplifier(hash('gain') % 10)" + AMP, "equal"),
    "seed alias late": (
        """
s = np.random.seed
s(4)
src = Source(lambda t: t if t < 5 else np.random.rand())
"""
        + SRC,
        "refused",
    ),
    "seed in a function, late": (
        """
def setup():
    np.random.seed(4)
setup()
src = Source(lambda t: t if t < 5 else np.random.rand())
"""
        + SRC,
        "refused",
    ),
    "random seed of other name in function": (
        """
import random as r
def setup(n):
    r.seed(n)
    return n
n = setup(5)
src = Source(lambda t: t if t < 5 else r.random())
"""
        + SRC,
        "refused",
    ),
    "spawned generators": (
        """
a, b = [np.random.default_rng(s) for s in np.random.SeedSequence(7).spawn(2)]
amp = Amplifier(a.normal())
src = Source(lambda t: b.normal())
two = Amplifier(b.normal())
scope = Scope()
sim = Simulation([src, amp, two, scope], [Connection(src, amp, two), Connection(amp, scope[0]), Connection(two, scope[1])], dt=0.05, log=False)
sim.run(0.5)
""",
        "either",
    ),
    "numpy's seed, and nothing else": (
        "np.random.seed(3)\nsrc = Source(lambda t: np.random.normal())" + SRC,
        "equal",
    ),
}

NUMPY = {
    "float32": ("amp = Amplifier(np.float32(0.1))" + AMP, "equal"),
    "float32 in a loop": (
        """
for k in np.array([0.1, 0.3], dtype=np.float32):
    amp = Amplifier(k)
"""
        + AMP,
        "equal",
    ),
    "float64 in a loop": (
        """
amps = [Amplifier(k) for k in np.linspace(0, 1, 4)]
amp = amps[1]
"""
        + AMP,
        "equal",
    ),
    "0-d array": ("amp = Amplifier(np.array(2.0))" + AMP, "equal"),
    "0-d array from a function": (
        """
def build(k):
    return Amplifier(np.asarray(k))
amp = build(0.7)
"""
        + AMP,
        "equal",
    ),
    "masked array": (
        """
table = np.ma.array([1.0, 2.0, 3.0], mask=[False, True, False])
src = Source(lambda t: float(table.sum()) * t)
"""
        + SRC,
        "equal",
    ),
    "masked array, mask changed by a call": (
        """
table = np.ma.array([1.0, 2.0, 3.0], mask=[False, True, False])
was = table.mask.copy(); soft = table.soften_mask()
last = table.__setitem__(0, np.ma.masked)
src = Source(lambda t: t if t < 5 else float(table.sum()))
"""
        + SRC,
        "refused",
    ),
    "structured array": (
        """
rows = np.array([(1.0, 2), (3.0, 4)], dtype=[("x", float), ("n", int)])
amp = Amplifier(rows["x"][1])
"""
        + AMP,
        "equal",
    ),
    "structured array in a factory": (
        """
def build():
    row = np.array([(1.0, 2)], dtype=[("x", float), ("n", int)])
    return Source(lambda t: row["x"][0] * t)
src = build()
"""
        + SRC,
        "refused",
    ),
    "matrix in Fortran order": (
        """
def build():
    A = np.asfortranarray(np.array([[-1.0, 0.2], [0.0, -2.0]]))
    return StateSpace(A, np.ones((2, 1)), np.ones((1, 2)), np.zeros((1, 1)))
amp = build()
"""
        + AMP,
        "equal",
    ),
    "negative zero, infinity and nan": (
        """
low, high = -0.0, float("inf")
src = Source(lambda t, nan=float("nan"): np.copysign(t, low) if t < high else nan)
"""
        + SRC,
        "equal",
    ),
    "bool and integer gains": (
        """
amps = {name: Amplifier(k) for name, k in (("a", True), ("b", np.int8(3)))}
amp = amps["b"]
"""
        + AMP,
        "equal",
    ),
    "ndarray subclass attribute by assigned call": (
        """
class V(np.ndarray):
    pass
v = np.zeros(3).view(V)
v.k = 1.0
_ = setattr(v, "k", 7.0)
src = Source(lambda t: t if t < 5 else v.k)
"""
        + SRC,
        "refused",
    ),
    "float subclass counts": (
        """
class F(float):
    def up(self):
        self.n = getattr(self, "n", 0) + 1
        return self.n
f = F(2.0)
first = f.up()
src = Source(lambda t: t if t < 5 else float(f.up()))
"""
        + SRC,
        "refused",
    ),
    "object array of functions": (
        """
laws = np.array([np.sin, lambda t: 3 * t], dtype=object)
laws[0] = np.cos
src = Source(lambda t: laws[0](t) + laws[1](t))
"""
        + SRC,
        "equal",
    ),
}

PATHSIM = {
    "subclass of Simulation": (
        """
class Mine(Simulation):
    pass
src, scope = Source(np.sin), Scope()
sim = Mine([src, scope], [Connection(src, scope)], dt=0.05, log=False)
sim.run(0.5)
""",
        "refused",
    ),
    "update replaced on a block": (
        """
amp = Amplifier(2.0)
amp.update = lambda t: None
"""
        + AMP,
        "refused",
    ),
    "stop replaced on the simulation": (
        """
x, scope = Integrator(1.0), Scope()
sim = Simulation([x, scope], [Connection(x, scope)],
                 [Condition(lambda t: t > 5, lambda t: sim.stop())], dt=0.05, log=False)
sim.stop = lambda: None
sim.run(0.5)
""",
        "refused",
    ),
    "class of a block changed": (
        """
class Louder(Amplifier):
    def update(self, t):
        self.outputs.update_from_array(9 * self.inputs.to_array())
amp = Amplifier(2.0)
amp.__class__ = Louder
"""
        + AMP,
        "refused",
    ),
    "subclass that only builds": (
        """
class Half(Amplifier):
    def __init__(self):
        super().__init__(0.5)
amp = Half()
"""
        + AMP,
        "equal",
    ),
    "PathSim patched": (
        """
import pathsim.blocks
pathsim.blocks.Amplifier.update = lambda self, t: None
amp = Amplifier(2.0)
"""
        + AMP,
        "refused",
    ),
    "numpy patched": ("np.sin = np.cos\nsrc = Source(lambda t: np.sin(t))" + SRC, "refused"),
    "math patched": (
        "import math\nmath.pi = 3\nsrc = Source(lambda t: t if t < 5 else math.pi)" + SRC,
        "refused",
    ),
    "scipy patched": (
        """
import scipy.special
scipy.special.expit = lambda x: 0.0
src = Source(lambda t: t if t < 5 else scipy.special.expit(t))
"""
        + SRC,
        "refused",
    ),
    "builtins patched": (
        """
import builtins
builtins.abs = lambda x: 42.0
src = Source(lambda t: t if t < 5 else abs(t))
"""
        + SRC,
        "refused",
    ),
    "default of PathSim changed": (
        """
amp = Amplifier()
Amplifier.__init__.__defaults__ = (4.0,)
amp = Amplifier()
"""
        + AMP,
        "either",
    ),
    "subsystem": (
        """
def lag(tau):
    port, x, k = Interface(), Integrator(), Amplifier(1 / tau)
    add = Adder("+-")
    return Subsystem([port, x, k, add], [Connection(port, add[0]), Connection(x, add[1], port),
                                         Connection(add, k), Connection(k, x)])
amp = lag(0.2)
"""
        + AMP,
        "equal",
    ),
    "event that counts": (
        """
count = [0]
def tick(t):
    count[0] += 1
clock = Schedule(t_start=0, t_period=0.1, func_act=tick)
src, scope = Source(lambda t: float(count[0])), Scope()
sim = Simulation([src, scope], [Connection(src, scope)], [clock], dt=0.05, log=False)
sim.run(0.5)
""",
        "equal",
    ),
    "event that changes a block": (
        """
amp = Amplifier(1.0)
def louder(t):
    amp.gain = 5.0
src, scope = Source(np.cos), Scope()
step = ScheduleList([0.2], func_act=louder)
sim = Simulation([src, amp, scope], [Connection(src, amp), Connection(amp, scope)], [step],
                 dt=0.05, log=False)
sim.run(0.5)
""",
        "equal",
    ),
    "event that stops": (
        DECAY.replace("dt=0.05", "[Condition(lambda t: t > 0.32, lambda t: sim.stop())], dt=0.05")
        + "sim.run(0.5)",
        "equal",
    ),
    "several simulations": (
        """
sims = []
for k in (1.0, 2.0):
    src, scope = Constant(k), Scope()
    sims.append(Simulation([src, scope], [Connection(src, scope)], dt=0.05, log=False))
for s in sims:
    s.run(0.5)
""",
        "equal",
    ),
    "block that PathView lacks": ("src = Comparator()" + SRC, "refused"),
    "state set before the run": (DECAY + "x.engine.set(5.0)\nsim.run(0.5)", "refused"),
    "operator of a block replaced, late": (
        """
amp = Amplifier(2.0)
from pathsim.optim.operator import Operator
amp.op_alg = Operator(func=lambda x: 2.0 * x if abs(x) < 3 else 0 * x, jac=lambda x: np.array([[2.0]]))
"""
        + AMP,
        "refused",
    ),
    "delay filled": (
        """
amp = Delay(0.8)
amp._buffer.add(-0.2, 3.0)
"""
        + AMP,
        "refused",
    ),
    "event detect replaced": (
        """
x, scope = Integrator(1.0), Scope()
c = Condition(lambda t: t > 5, lambda t: None)
c.detect = lambda t: (False, False, 1.0)
sim = Simulation([x, scope], [Connection(x, scope)], [c], dt=0.05, log=False)
sim.run(0.5)
""",
        "refused",
    ),
    "engine step replaced": (
        DECAY
        + """
sim.engine.step = lambda *a, **k: (True, 0.0, 1.0)
sim.run(0.5)
""",
        "refused",
    ),
    "subclass of Connection": (
        """
class Late(Connection):
    n = 0
    def update(self):
        Late.n += 1
        if Late.n < 100:
            super().update()
src, scope = Source(np.sin), Scope()
sim = Simulation([src, scope], [Late(src, scope)], dt=0.05, log=False)
sim.run(0.5)
""",
        "refused",
    ),
}

WORLD = {
    "time": (
        "import time\nstart = time.time()\nsrc = Source(lambda t: start - start + t)" + SRC,
        "equal",
    ),
    "seconds of a counter": (
        "import time\nsrc = Source(lambda t: time.perf_counter())" + SRC,
        "refused",
    ),
    "date as a parameter": (
        "from datetime import date\namp = Amplifier(date.today().day / 31)" + AMP,
        "equal",
    ),
    "environment": (
        "import os\nos.environ['GAIN'] = '3'\namp = Amplifier(float(os.environ['GAIN']))" + AMP,
        "equal",
    ),
    "environment in a function": (
        """
import os
os.environ.update(GAIN="3")
src = Source(lambda t: t * float(os.environ.get("GAIN", 1)))
"""
        + SRC,
        "equal",
    ),
    "generator": (
        """
def steps():
    x = 0.0
    while True:
        yield x
        x += 1.0
g = steps()
src = Source(lambda t: next(g))
"""
        + SRC,
        "equal",
    ),
    "generator already read, used late": (
        """
g = (float(i) for i in range(1000))
first = next(g)
src = Source(lambda t: t if t < 5 else next(g))
"""
        + SRC,
        "refused",
    ),
    "counter already read, used late": (
        """
import itertools
tickets = itertools.count()
first = next(tickets)
src = Source(lambda t: t if t < 5 else float(next(tickets)))
"""
        + SRC,
        "refused",
    ),
    "file already read, used late": (
        """
f = open(__import__("numpy").__file__)
first = f.readline()
src = Source(lambda t: t if t < 5 else float(len(f.read())))
"""
        + SRC,
        "refused",
    ),
    "globals in a function": (
        "k = 2.0\nsrc = Source(lambda t: t if t < 5 else globals()['k'])" + SRC,
        "refused",
    ),
    "main program in a function": (
        """
import sys
k = 2.0
src = Source(lambda t: sys.modules["__main__"].k)
"""
        + SRC,
        "refused",
    ),
    "name of the main program": (
        "src = Source(lambda t: t if __name__ == '__main__' else -t)" + SRC,
        "refused",
    ),
    "docstring with a line of blanks": (
        '''
def wave(t):
    """A wave.

    \n        indented
    \n    """
    return 2 * t
src = Source(wave)
'''
        + SRC,
        "equal",
    ),
    "try and finally": (
        DECAY + "try:\n    gain.gain = -3.0\n    sim.run(0.5)\nfinally:\n    gain.gain = 0.0\n",
        "equal",
    ),
    "run_streaming": (
        DECAY + "for _ in sim.run_streaming(duration=0.5, tickrate=100):\n    pass\n",
        "equal",
    ),
    "run_realtime": (DECAY + "for _ in sim.run_realtime(duration=0.2):\n    pass\n", "equal"),
    "loop of time steps": (DECAY + "while sim.time < 0.5:\n    sim.timestep()\n", "equal"),
    "fly": ("from pathsim_jsbsim_blocks import fly" + DECAY + "fly(sim, 0.5)\n", "equal"),
    "csv reader read": (
        """
import csv, io
rows = csv.reader(io.StringIO("1\\n2\\n3\\n"))
header = next(rows)
src = Source(lambda t: t if t < 5 else float(next(rows)[0]))
"""
        + SRC,
        "refused",
    ),
    "StringIO rewritten": (
        """
import io
buf = io.StringIO("1.0")
_ = buf.write("9.0"); _ = buf.seek(0)
src = Source(lambda t: t if t < 5 else float(buf.getvalue()))
"""
        + SRC,
        "refused",
    ),
    "file from the start": (
        """
import io
buf = io.StringIO("1.0\\n2.0\\n" * 50)
src = Source(lambda t: float(buf.readline() or 0))
"""
        + SRC,
        "equal",
    ),
}

SCRIPTS = {
    f"{subject}: {name}": case
    for subject, cases in (
        ("shared", SHARED),
        ("changed", CHANGED),
        ("random", RANDOM),
        ("numpy", NUMPY),
        ("pathsim", PATHSIM),
        ("world", WORLD),
    )
    for name, case in cases.items()
}
