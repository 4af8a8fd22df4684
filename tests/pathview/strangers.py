"""Small PathSim scripts as a stranger may write them, and what an export must make of each.

"equal": it becomes a model that flies as the script does. "refused": it need not, but a model that
is written flies as the script does.
"""

import re

from scripts_of_tests import LOOP

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


TEXT = r"""
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
## shared: partial's keyword list grown later -> equal +SRC
from functools import partial
def f(t, k=None):
    return sum(k) * t
p = partial(f, k=[1.0])
p.keywords["k"].append(2.0)
src = Source(p)
## changed: class changed -> equal +SRC
class Config:
    limit = 1.0
Config.limit = 3.0
src = Source(lambda t: min(30 * t, Config.limit))
## changed: global set by a function only -> equal +SRC
def setup():
    global LIMIT
    LIMIT = 0.25
setup()
src = Source(lambda t: min(t, LIMIT))
## changed: global that an event deletes and sets -> equal
n = 0.0
def count(t):
    global n
    before = n
    del n
    n = before + 1.0
src, scope = Source(lambda t: n * t), Scope()
tick = Schedule(t_period=0.1, func_act=count)
sim = Simulation([src, scope], [Connection(src, scope)], [tick], dt=0.05, log=False)
sim.run(0.5)
## changed: function chosen by a block -> refused +SRC
def limit():
    return 5.0
amp = Amplifier(2.0)
def pick(block):
    return (lambda: 9.0) if block.gain > 1 else (lambda: 7.0)
limit = pick(amp)
src = Source(lambda t: t if t < 5 else limit())
## changed: source function replaced -> equal +SRC
src = Source(lambda t: t)
src.func = lambda t: 2 * t
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
## numpy: 0-d array from a function -> equal +AMP
def build(k):
    return Amplifier(np.asarray(k))
amp = build(0.7)
## numpy: masked array -> refused +SRC
table = np.ma.array([1.0, 2.0, 3.0], mask=[False, True, False])
src = Source(lambda t: float(table.sum()) * t)
## numpy: negative zero, infinity and nan -> equal +SRC
low, high = -0.0, float("inf")
src = Source(lambda t, nan=float("nan"): np.copysign(t, low) if t < high else nan)
## pathsim: subclass of Simulation -> equal
class Mine(Simulation):
    pass
src, scope = Source(np.sin), Scope()
sim = Mine([src, scope], [Connection(src, scope)], dt=0.05, log=False)
sim.run(0.5)
## pathsim: update replaced on a block -> refused +AMP
amp = Amplifier(2.0)
amp.update = lambda t: None
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
## world: try and finally -> equal
LOOP
try:
    a.gain = -3.0
    sim.run(0.5)
finally:
    a.gain = 0.0
## world: run_streaming -> equal
LOOP
for _ in sim.run_streaming(duration=0.5, tickrate=100):
    pass
## world: loop of time steps -> equal
LOOP
while sim.time < 0.5:
    sim.timestep()
## world: file from the start -> equal +SRC
import io
buf = io.StringIO("1.0\n2.0\n" * 50)
src = Source(lambda t: float(buf.readline() or 0))
## built: changed in a loop that runs -> equal
LOOP
for g in (-6.0, -7.0):
    a.gain = g
    sim.run(1)
## built: added under the main guard -> equal
LOOP
if __name__ == "__main__":
    extra = Amplifier(0.5)
    sim.add_block(extra)
    sim.add_connection(Connection(i, extra))
    sim.add_connection(Connection(extra, s[1]))
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
## built: run by getattr -> equal
LOOP
getattr(sim, "run")(0.5)
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
"""

SCRIPTS = {
    name: (re.sub("^LOOP\n", LOOP, source) + TAILS.get(tail, ""), verdict)
    for name, verdict, tail, source in re.findall(
        r"^## (.+) -> (\w+)(?: \+(\w+))?\n((?:(?!## ).*\n)*)", TEXT, re.M
    )
}
