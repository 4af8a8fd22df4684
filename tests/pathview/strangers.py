"""Small PathSim scripts as a stranger may write them, and what an export must make of each.

"equal": it becomes a model that flies as the script does. "refused": it need not, but a model that
is written flies as the script does.
"""

import re

HEAD = """
import numpy as np
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import *
from pathsim.events import *
from pathsim.solvers import *
"""
TAILS = {
    "SRC": """
scope = Scope()
sim = Simulation([src, scope], [Connection(src, scope)], dt=0.05, log=False)
sim.run(0.5)
""",
    "AMP": """
src, scope = Source(np.sin), Scope()
sim = Simulation([src, amp, scope], [Connection(src, amp), Connection(amp, scope)], dt=0.05, log=False)
sim.run(0.5)
""",
}

LOOP = """
i = Integrator(1.0)
a = Amplifier(-1.0)
s = Scope()
sim = Simulation([i, a, s], [Connection(i, a, s), Connection(a, i)], dt=0.01, log=False)
"""

TEXT = r"""
## shared: callable object -> equal +SRC
class Ramp:
    slope = 2.0
    def __call__(self, t):
        return self.slope * t
src = Source(Ramp())
## shared: deque -> equal +SRC
from collections import deque
window = deque(maxlen=3)
def mean(t):
    window.append(t)
    return sum(window) / len(window)
src = Source(mean)
## shared: attribute of a function -> equal +SRC
def wave(t):
    wave.calls += 1
    return float(wave.calls)
wave.calls = 0
src = Source(wave)
## shared: table of decorated functions -> refused +SRC
WAVES = {}
def register(f):
    WAVES[f.__name__] = f
    return f
@register
def slow(t):
    return 0.5 * t
src = Source(lambda t: WAVES["slow"](t))
## shared: cell of a counter -> equal +SRC
def counter():
    n = 0
    def count(t):
        nonlocal n
        n += 1
        return float(n)
    return count
src = Source(counter())
## shared: partial's keyword list grown later -> equal +SRC
from functools import partial
def f(t, k=None):
    return sum(k) * t
p = partial(f, k=[1.0])
p.keywords["k"].append(2.0)
src = Source(p)
## changed: object changed by a call -> equal +SRC
class Config:
    limit = 1.0
    def relax(self):
        self.limit = 3.0
config = Config()
config.relax()
src = Source(lambda t: min(30 * t, config.limit))
## changed: class changed -> equal +SRC
class Config:
    limit = 1.0
Config.limit = 3.0
src = Source(lambda t: min(30 * t, Config.limit))
## changed: limit updated -> equal +SRC
limits = {"soft": 5.0}
limits.update(soft=0.2)
src = Source(lambda t: min(t, limits["soft"]))
## changed: limit bound twice -> equal +SRC
LIMIT = 5.0
src = Source(lambda t: min(t, LIMIT))
LIMIT = 0.3
## changed: limit changed by a function in a function -> equal +SRC
limits = [5.0]
def set_it():
    limits[0] = 8.0
def prepare():
    set_it()
prepare()
src = Source(lambda t: min(t, limits[0]))
## changed: global set by a function only -> equal +SRC
def setup():
    global LIMIT
    LIMIT = 0.25
setup()
src = Source(lambda t: min(t, LIMIT))
## changed: function chosen by a block -> refused +SRC
def limit():
    return 5.0
amp = Amplifier(2.0)
def pick(block):
    return (lambda: 9.0) if block.gain > 1 else (lambda: 7.0)
limit = pick(amp)
src = Source(lambda t: t if t < 5 else limit())
## changed: table filled in a comprehension -> refused +SRC
table = []
_ = [table.append(0.1 * i) for i in range(4)]
src = Source(lambda t: table[int(4 * t)])
## changed: gain of a block changed -> equal +AMP
amp = Amplifier(2.0)
amp.gain += 1.5
## changed: source function replaced -> equal +SRC
src = Source(lambda t: t)
src.func = lambda t: 2 * t
## changed: dataclass replaced -> equal +SRC
from dataclasses import dataclass, replace
@dataclass(frozen=True)
class Cfg:
    k: float = 1.0
cfg = Cfg()
cfg = replace(cfg, k=3.0)
src = Source(lambda t: cfg.k * t)
## random: drawn then changed -> equal +AMP
rng = np.random.default_rng(3)
gains = rng.normal(size=3)
gains[1] = 0.0
amp = Amplifier(gains[0] + gains[1])
## random: drawn, then doubled -> equal +AMP
np.random.seed(4)
amp = Amplifier(np.random.rand())
amp.gain *= 2
## random: numpy's seed under another name -> equal +AMP
from numpy.random import seed as s, rand as r
s(4)
amp = Amplifier(r())
## random: random.seed -> refused +SRC
import random
random.seed(11)
src = Source(lambda t: random.random())
## random: random under another name -> refused +SRC
import random as dice
dice.seed(11)
src = Source(lambda t: dice.gauss(0, 1))
## random: RandomState -> equal +SRC
rs = np.random.RandomState(4)
src = Source(lambda t: rs.rand())
## random: Generator already drawn from, used late -> refused +SRC
rng = np.random.default_rng(4)
burn = rng.normal()
src = Source(lambda t: t if t < 5 else rng.normal())
## random: generator shared with a block -> refused
rng = np.random.default_rng(4)
amp = Amplifier(rng.normal())
src = Source(lambda t: rng.normal())

scope = Scope()
sim = Simulation([src, amp, scope], [Connection(src, scope[0]), Connection(amp, scope[1])],
                 dt=0.05, log=False)
sim.run(0.5)
## random: shuffled list -> equal +AMP
import random
order = [1.0, 2.0, 3.0]
random.Random(5).shuffle(order)
amp = Amplifier(order[0])
## random: numpy's seed, and nothing else -> equal +SRC
np.random.seed(3)
src = Source(lambda t: np.random.normal())
## numpy: float32 -> equal +AMP
amp = Amplifier(np.float32(0.1))
## numpy: float32 in a loop -> equal +AMP
for k in np.array([0.1, 0.3], dtype=np.float32):
    amp = Amplifier(k)
## numpy: float64 in a loop -> equal +AMP
amps = [Amplifier(k) for k in np.linspace(0, 1, 4)]
amp = amps[1]
## numpy: 0-d array -> equal +AMP
amp = Amplifier(np.array(2.0))
## numpy: 0-d array from a function -> equal +AMP
def build(k):
    return Amplifier(np.asarray(k))
amp = build(0.7)
## numpy: masked array -> refused +SRC
table = np.ma.array([1.0, 2.0, 3.0], mask=[False, True, False])
src = Source(lambda t: float(table.sum()) * t)
## numpy: matrix in Fortran order -> equal +AMP
def build():
    A = np.asfortranarray(np.array([[-1.0, 0.2], [0.0, -2.0]]))
    return StateSpace(A, np.ones((2, 1)), np.ones((1, 2)), np.zeros((1, 1)))
amp = build()
## numpy: negative zero, infinity and nan -> equal +SRC
low, high = -0.0, float("inf")
src = Source(lambda t, nan=float("nan"): np.copysign(t, low) if t < high else nan)
## numpy: bool and integer gains -> equal +AMP
amps = {name: Amplifier(k) for name, k in (("a", True), ("b", np.int8(3)))}
amp = amps["b"]
## pathsim: subclass of Simulation -> equal
class Mine(Simulation):
    pass
src, scope = Source(np.sin), Scope()
sim = Mine([src, scope], [Connection(src, scope)], dt=0.05, log=False)
sim.run(0.5)
## pathsim: update replaced on a block -> refused +AMP
amp = Amplifier(2.0)
amp.update = lambda t: None
## pathsim: subclass that only builds -> equal +AMP
class Half(Amplifier):
    def __init__(self):
        super().__init__(0.5)
amp = Half()
## pathsim: subsystem -> equal +AMP
def lag(tau):
    port, x, k = Interface(), Integrator(), Amplifier(1 / tau)
    add = Adder("+-")
    return Subsystem([port, x, k, add], [Connection(port, add[0]), Connection(x, add[1], port),
                                         Connection(add, k), Connection(k, x)])
amp = lag(0.2)
## pathsim: event that counts -> equal
count = [0]
def tick(t):
    count[0] += 1
clock = Schedule(t_start=0, t_period=0.1, func_act=tick)
src, scope = Source(lambda t: float(count[0])), Scope()
sim = Simulation([src, scope], [Connection(src, scope)], [clock], dt=0.05, log=False)
sim.run(0.5)
## pathsim: event that changes a block -> equal
amp = Amplifier(1.0)
def louder(t):
    amp.gain = 5.0
src, scope = Source(np.cos), Scope()
step = ScheduleList([0.2], func_act=louder)
sim = Simulation([src, amp, scope], [Connection(src, amp), Connection(amp, scope)], [step],
                 dt=0.05, log=False)
sim.run(0.5)
## pathsim: event that stops -> equal
x, gain, scope = Integrator(1.0), Amplifier(-2.0), Scope()
sim = Simulation([x, gain, scope], [Connection(x, gain, scope), Connection(gain, x)],
                 [Condition(lambda t: t > 0.32, lambda t: sim.stop())], dt=0.05, log=False)
sim.run(0.5)
## pathsim: several simulations -> equal
sims = []
for k in (1.0, 2.0):
    src, scope = Constant(k), Scope()
    sims.append(Simulation([src, scope], [Connection(src, scope)], dt=0.05, log=False))
for s in sims:
    s.run(0.5)
## pathsim: block that PathView lacks -> refused +SRC
src = Comparator()
## pathsim: subclass of Connection -> refused
class Late(Connection):
    n = 0
    def update(self):
        Late.n += 1
        if Late.n < 100:
            super().update()
src, scope = Source(np.sin), Scope()
sim = Simulation([src, scope], [Late(src, scope)], dt=0.05, log=False)
sim.run(0.5)
## world: generator -> refused +SRC
def steps():
    x = 0.0
    while True:
        yield x
        x += 1.0
g = steps()
src = Source(lambda t: next(g))
## world: globals in a function -> refused +SRC
k = 2.0
src = Source(lambda t: t if t < 5 else globals()['k'])
## world: try and finally -> equal
x, gain, scope = Integrator(1.0), Amplifier(-2.0), Scope()
sim = Simulation([x, gain, scope], [Connection(x, gain, scope), Connection(gain, x)],
                 dt=0.05, log=False)
try:
    gain.gain = -3.0
    sim.run(0.5)
finally:
    gain.gain = 0.0
## world: run_streaming -> equal
x, gain, scope = Integrator(1.0), Amplifier(-2.0), Scope()
sim = Simulation([x, gain, scope], [Connection(x, gain, scope), Connection(gain, x)],
                 dt=0.05, log=False)
for _ in sim.run_streaming(duration=0.5, tickrate=100):
    pass
## world: run_realtime -> equal
x, gain, scope = Integrator(1.0), Amplifier(-2.0), Scope()
sim = Simulation([x, gain, scope], [Connection(x, gain, scope), Connection(gain, x)],
                 dt=0.05, log=False)
for _ in sim.run_realtime(duration=0.2):
    pass
## world: loop of time steps -> equal
x, gain, scope = Integrator(1.0), Amplifier(-2.0), Scope()
sim = Simulation([x, gain, scope], [Connection(x, gain, scope), Connection(gain, x)],
                 dt=0.05, log=False)
while sim.time < 0.5:
    sim.timestep()
## world: fly -> equal
from pathsim_jsbsim_blocks import fly
x, gain, scope = Integrator(1.0), Amplifier(-2.0), Scope()
sim = Simulation([x, gain, scope], [Connection(x, gain, scope), Connection(gain, x)],
                 dt=0.05, log=False)
fly(sim, 0.5)
## world: file from the start -> equal +SRC
import io
buf = io.StringIO("1.0\n2.0\n" * 50)
src = Source(lambda t: float(buf.readline() or 0))
## built: changed in a loop that runs -> equal
LOOP
for g in (-6.0, -7.0):
    a.gain = g
    sim.run(1)
## built: solvers tried in a loop -> equal
LOOP
if __name__ == "__main__":
    for solver in (ESDIRK32, GEAR21):
        sim._set_solver(Solver=solver, tolerance_lte_abs=1e-4)
        sim.run(1)
## built: changed under with, try and if -> equal
LOOP
with np.errstate(all="ignore"):
    a.gain = -2.0
    try:
        sim.dt = 0.02
        if a.gain < 0:
            i.reset()
            sim.run(1)
    finally:
        a.gain = 0.0
## built: added under the main guard -> equal
LOOP
if __name__ == "__main__":
    extra = Amplifier(0.5)
    sim.add_block(extra)
    sim.add_connection(Connection(i, extra))
    sim.add_connection(Connection(extra, s[1]))
    sim.run(1)
## built: changed through a container -> equal
B = {"i": Integrator(1.0), "a": Amplifier(-1.0), "s": Scope()}
B["a"].gain = -6.0
sim = Simulation(list(B.values()), [Connection(B["i"], B["a"], B["s"]), Connection(B["a"], B["i"])],
                 log=False)
sim.run(1)
## built: changed by a function -> equal
def tune(block):
    block.gain *= 4
    return block

i = Integrator(1.0)
a = tune(Amplifier(-1.0))
s = Scope()
sim = Simulation([i, a, s], [Connection(i, a, s), Connection(a, i)], log=False)
sim.run(1)
## built: seeded draws in another order -> equal
np.random.seed(4)
rng = np.random.default_rng(5)
a, b = Amplifier(np.random.rand()), Amplifier(np.random.rand())
c = Source(lambda t, k=rng.normal(): k + t)
d = Amplifier(rng.normal())
s = Scope()
sim = Simulation([d, s, b, c, a], [Connection(c, a), Connection(a, b), Connection(b, d),
                                   Connection(d, s)], log=False)
sim.run(1)
## built: seeded in a function -> equal
def build():
    np.random.seed(1)
    return Constant(np.random.rand()), Scope()

c, s = build()
sim = Simulation([c, s], [Connection(c, s)], log=False)
sim.run(1)
## built: a parameter that changes between blocks -> equal
k = 1.0
a = Source(lambda t: t * k)
b = Amplifier(k)
k = 3.0
s = Scope()
sim = Simulation([a, b, s], [Connection(a, b), Connection(b, s)], log=False)
sim.run(1)
## built: a list that changes after it is used -> equal
x0 = np.array([1.0, 2.0])
b = Integrator(x0)
k = [2.0]
f = Source(lambda t: k[0] * t)
x0[0] = 9.0
s = Scope()
sim = Simulation([b, f, s], [Connection(b[0:2], s[0:2]), Connection(f, s[2])], log=False)
def more():
    k.append(1.0)
    k[0] += 1
more()
sim.run(1)
## built: wires of a subsystem, one by one -> equal
port, x, gain = Interface(), Integrator(1.0), Amplifier(-2.0)
inside = Subsystem([port, x, gain], [Connection(x, gain), Connection(x, port), Connection(gain, x)])
s = Scope()
sim = Simulation([inside, s], [Connection(inside, s)], dt=0.01, log=False)
sim.run(1)
## built: other ways to give arguments -> equal
from functools import partial
a = Amplifier(**{"gain": 3.0})
p = PID(*(2.0, 0.5, 0.1), f_max=50)
c = Source(partial(lambda k, t: k * t, 2.0))
d = Constant(a.gain + 1 if a else 0)
noise = [WhiteNoise(seed=i) for i in (1, 2)]
s = Scope()
sim = Simulation([a, p, c, d, *noise, s], [
    Connection(c, a), Connection(a, p), Connection(p, s), Connection(d, s[1]),
    Connection(noise[1], s[2])], log=False)
sim.run(1)
## built: run by getattr -> equal
LOOP
getattr(sim, "run")(0.5)
## fresh: an enumeration of modes -> equal
from enum import Enum
class Mode(Enum):
    OFF = 0
    HEAT = 1
    COOL = 2
class Controller:
    def __init__(self, low, high):
        self.low, self.high, self.mode = low, high, Mode.OFF
    def decide(self, t):
        T = room.engine.get()
        if T < self.low:
            self.mode = Mode.HEAT
        elif T > self.high:
            self.mode = Mode.COOL
        else:
            self.mode = Mode.OFF
    def power(self, t):
        return {Mode.OFF: 0.0, Mode.HEAT: 2.0, Mode.COOL: -2.0}[self.mode]
ctrl = Controller(19.0, 21.0)
room = Integrator(15.0)
heat = Source(ctrl.power)
loss = Function(lambda T, q: q - 0.1 * (T - 10.0))
s = Scope()
sim = Simulation([room, heat, loss, s], [Connection(room, loss[0], s[0]), Connection(heat, loss[1], s[1]),
    Connection(loss, room)], [Schedule(t_period=0.5, func_act=ctrl.decide)], dt=0.05, log=False)
sim.run(20)
## fresh: a closure that counts -> equal
def make_counter(step):
    n = 0
    def tick(t):
        nonlocal n
        n += step
    def value(t):
        return n * 0.1
    return tick, value
tick, value = make_counter(3)
src, s = Source(value), Scope()
sim = Simulation([src, s], [Connection(src, s)], [Schedule(t_start=0.1, t_period=0.3, func_act=tick)], dt=0.05, log=False)
sim.run(2)
## fresh: a relay with slots -> equal
class Relay:
    __slots__ = ("on", "off", "state")
    def __init__(self, on, off):
        self.on, self.off, self.state = on, off, False
    def __call__(self, x):
        if x < self.on:
            self.state = True
        elif x > self.off:
            self.state = False
        return 1.0 if self.state else -1.0
relay = Function(Relay(-0.2, 0.2))
x, s = Integrator(1.0), Scope()
sim = Simulation([relay, x, s], [Connection(x, relay, s), Connection(relay, x, s[1])], dt=0.01, log=False)
sim.run(3)
## fresh: lambdas in a line -> equal
amps, freqs = [1.0, 0.5, 0.25], [1, 3, 5]
srcs = [Source(lambda t, a=a, f=f: a * np.sin(2 * np.pi * f * t)) for a, f in zip(amps, freqs)]
add, s = Adder(), Scope()
sim = Simulation([*srcs, add, s], [Connection(b, add[i]) for i, b in enumerate(srcs)] + [Connection(add, s)], dt=0.01, log=False)
sim.run(1)
## fresh: a decorator with arguments -> equal
import functools
import math
def clipped(low, high):
    def around(f):
        @functools.wraps(f)
        def inner(*args):
            return min(high, max(low, f(*args)))
        return inner
    return around
@clipped(-0.8, 0.8)
def wave(t):
    return 1.2 * math.sin(3 * t)
@clipped(0.0, math.inf)
def rectified(x):
    return 2 * x
src, rect, s = Source(wave), Function(rectified), Scope()
sim = Simulation([src, rect, s], [Connection(src, rect, s), Connection(rect, s[1])], dt=0.02, log=False)
sim.run(3)
## fresh: named tuples -> equal
from collections import namedtuple
from types import SimpleNamespace
Limits = namedtuple("Limits", "low high")
cfg = SimpleNamespace(rate=0.5, limits=Limits(-1.0, 1.0))
class C:
    K = 4.0
    OFFSET = -0.5
src = Source(lambda t: C.K * t + C.OFFSET)
clip = Function(lambda x: min(max(x * cfg.rate, cfg.limits.low), cfg.limits.high))
s = Scope()
sim = Simulation([src, clip, s], [Connection(src, clip, s), Connection(clip, s[1])], dt=0.02, log=False)
sim.run(1.0)
"""

SCRIPTS = {
    name: (re.sub("^LOOP\n", LOOP, source) + TAILS.get(tail, ""), verdict)
    for name, verdict, tail, source in re.findall(
        r"^## (.+) -> (\w+)(?: \+(\w+))?\n((?:(?!## ).*\n)*)", TEXT, re.M
    )
}
