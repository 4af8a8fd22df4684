"""Any diagram as an environment of Gymnasium: `make_env`, and three registered tasks.

Importing this module registers ``pathsim-jsbsim/PitchHold-v1``,
``pathsim-jsbsim/HeadingInTurbulence-v0`` and ``pathsim-jsbsim/Approach-v0``.
"""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Block

from ._core.callers import frames
from ._core.checks import (
    check_range,
    did_you_mean,
    flag,
    mapping,
    must_be,
    nearest,
    nearest_ports,
    number,
    one_of,
    positive,
    refuse,
)
from ._core.extras import required
from ._core.own import own
from ._core.pathsim_internals import port_names, port_number, port_reader, show, values
from ._core.running import SteppedRun
from ._core.wiring import contents, warn_of_wiring
from ._seeding import draws_from_shared, random_blocks, seed_blocks
from .catalogue import find_diagram
from .control.holds import PitchHold
from .errors import FlightError
from .flight import Aircraft
from .scripts.script import Script
from .tracks.track import POSITION, Track
from .wind.turbulence import DrydenTurbulence

if TYPE_CHECKING:
    import gymnasium
    from matplotlib.figure import Figure
else:
    gymnasium = required("gymnasium", "gym")

__all__ = ["DiagramEnv", "make_env"]

# relative; how far a step may be from a whole number of the diagram's steps
_ROUNDING = 1e-9

_T = TypeVar("_T")
_Port = tuple[Block, Any, int]  # with its register and number
Judge = Callable[[Mapping[str, float]], Any]
Ranges = Mapping[str, tuple[float, float]]


class _Actions(Block):
    """Outputs: the actions. Inputs: the signals they replace."""


class _Signals:
    """Ports with the ranges of their values, and the space of these ranges."""

    def __init__(self, parameter: str, intervals: Any, ports: Mapping[str, _Port], normalise: bool):
        ranges = {n: _range(n, bounds) for n, bounds in mapping(parameter, intervals).items()}
        self.names = [*ranges]
        self.ports = [_lookup(parameter, name, ports) for name in ranges]
        self.read = [port_reader(register, i) for _, register, i in self.ports]
        self.low, self.high = low, high = np.array([*ranges.values()]).T
        if normalise:
            endless = [n for n, bounds in ranges.items() if not np.isfinite(np.subtract(*bounds))]
            if endless:
                refuse("normalise", True, f"normalise needs a finite range of {endless[0]!r}")
            low, high = -np.ones(len(ranges)), np.ones(len(ranges))
        self._normalised = normalise
        self.space = gymnasium.spaces.Box(low, high, dtype=np.float64)

    def within(self, x: np.ndarray) -> np.ndarray:
        """Limited to the space; numpy's clip is three times slower."""
        return np.minimum(np.maximum(x, self.space.low), self.space.high)

    def to_space(self, y: list[float]) -> np.ndarray:
        """Values of the ports as a point of the space."""
        x = np.array(y)
        if self._normalised:
            x = 2.0 * (x - self.low) / (self.high - self.low) - 1.0
        return self.within(x)

    def to_ports(self, x: np.ndarray) -> list[float]:
        """A point of the space as values of the ports."""
        x = self.within(x)
        if self._normalised:
            x = self.low + 0.5 * (x + 1.0) * (self.high - self.low)
        return x.tolist()


class _Values(Mapping[str, float]):
    """Values of all ports of a diagram by ``"BLOCK.PORT"``, and ``"time"`` in s."""

    def __init__(self, sim: Simulation, ports: Mapping[str, _Port]):
        self._read = {name: port_reader(register, i) for name, (_, register, i) in ports.items()}
        self._read["time"] = lambda: float(sim.time)

    def __getitem__(self, name: str) -> float:
        return _lookup("values", name, self._read)()

    def __iter__(self) -> Iterator[str]:
        return iter(self._read)

    def __len__(self) -> int:
        return len(self._read)


class DiagramEnv(gymnasium.Env):
    """A diagram as an environment, made by `make_env`.

    Attributes
    ----------
    simulation : pathsim.Simulation
        the diagram
    values : mapping
        current values of its ports, as passed to ``reward``
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}
    simulation: Simulation
    values: Mapping[str, float]
    action_space: gymnasium.spaces.Box
    observation_space: gymnasium.spaces.Box

    def __init__(self, build: Callable[[Mapping[str, Any]], Any], given: Mapping[str, Any]):
        self._build = build
        options = self._options = given
        self._vary = {n: _range(n, r) for n, r in mapping("vary", options["vary"]).items()}
        for name, (low, high) in self._vary.items():
            number(name, high - low)
        # a variable of a script takes effect only when the script is built again
        self._anew = any("." not in name for name in self._vary)
        self._crash = number("crash", options["crash"])
        self._reward = options["reward"]
        self._terminated = options["terminated"] or (lambda _: False)
        for name, judge in (("reward", self._reward), ("terminated", self._terminated)):
            if not callable(judge):
                must_be(name, judge, "a function of the values")
        self.render_mode = options["render_mode"]
        if self.render_mode is not None:
            one_of("render_mode", self.render_mode, ("rgb_array",))
        one_of("wired", options["wired"], ("refuse", "replace"))
        flag("normalise", options["normalise"])
        steps = positive("duration", options["duration"]) / positive("step", options["step"])
        self._longest = math.ceil(steps * (1 - _ROUNDING))
        self._pieces: SteppedRun | None = None
        self._rows: list[list[float]] = []
        self._find({})
        self.action_space, self.observation_space = self._actions.space, self._observed.space

    def _find(self, settings: Mapping[str, Any]) -> None:
        """Build the diagram, find its ports and connect the actions."""
        options, (sim, blocks) = self._options, self._build(settings)
        self.simulation = sim
        if sim.engine.is_adaptive:
            refuse("diagram", sim, "an environment needs a solver with a fixed step")
        if drawers := [type(b).__name__ for b in contents(sim)[0] if draws_from_shared(b)]:
            why = "draws from NumPy's global generator, which cannot be seeded: use WhiteNoise"
            refuse("diagram", sim, f"{drawers[0]} {why}")
        if any(isinstance(block, _Actions) for block in sim.blocks):
            refuse("diagram", sim, "this simulation is an environment already: build another one")
        self._count_steps()
        ports, observation = _ports(blocks, "inputs", "outputs"), options["observation"]
        self.values = _Values(sim, ports)
        if isinstance(observation, (list, tuple)):
            observation = dict.fromkeys(observation, (-np.inf, np.inf))
        normalise = options["normalise"]
        self._observed = _Signals("observation", observation, ports, normalise)
        self._actions = _Signals("action", options["action"], _ports(blocks, "inputs"), normalise)
        parameters = {
            f"{name}.{parameter}": (block, parameter)
            for name, block in blocks.items()
            for parameter in block.info()["parameters"]
        }
        self._places = {n: _lookup("vary", n, parameters) for n in self._vary if "." in n}
        # last, so that an error leaves the user's simulation unchanged
        self._wire()
        self._aircraft = next((b for b in sim.blocks if isinstance(b, Aircraft)), None)
        outputs = getattr(self._aircraft, "outputs", self._source.outputs)
        at = port_names(outputs)
        self._place = [port_reader(outputs, at[name]) for name in POSITION if name in at]
        self._random = random_blocks(sim)
        warn_of_wiring(sim)

    def _count_steps(self) -> None:
        step, dt = self._options["step"], self.simulation.dt
        self._dt, self._count = dt, round(step / dt)
        if not self._count or abs(step / dt - self._count) > _ROUNDING * self._count:
            refuse("step", step, f"step must be a multiple of dt = {dt:.9g} s, not {step:.9g} s")

    def _wire(self) -> None:
        """Connect the actions to the diagram, replacing the connections to their ports."""
        sim, ends = self.simulation, [(block, i) for block, _, i in self._actions.ports]
        obsolete = []
        for name, end in zip(self._actions.names, ends, strict=True):
            if end[0] not in sim.blocks:
                refuse("action", name, f"{name!r} is inside a subsystem")
            if ends.count(end) > 1:
                refuse("action", name, f"two actions have the port {name!r}")
            wires = [w for w in sim.connections if any(e == end for _, e in _ends(w))]
            if wires and self._options["wired"] == "refuse":
                why = f"{name!r} is connected already; wired='replace' replaces the connection"
                refuse("wired", "refuse", why)
            obsolete += [wire for wire in wires if wire not in obsolete]
        # two blocks: with one, the replaced signals would seem to feed the actions (a loop)
        self._source, spare = _Actions(), _Actions()
        sim.add_block(self._source)
        sim.add_block(spare)
        for wire in obsolete:
            sim.remove_connection(wire)
            for source, end in _ends(wire):
                target = spare[ends.index(end)] if end in ends else end[0][end[1]]
                sim.add_connection(Connection(wire.source.block[source], target))
        for i, (block, k) in enumerate(ends):
            sim.add_connection(Connection(self._source[i], block[k]))

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode; ``options`` are values of varied parameters instead of random ones.

        ``info["varied"]`` has the values. The ``seed`` determines all later random numbers.

        Raises
        ------
        ParameterError
            for an option that is not varied
        TrimError
            if the aircraft does not trim
        """
        self._pieces = None
        super().reset(seed=seed)
        if options and not self._vary:
            refuse("options", options, "this environment has nothing to vary: make_env(vary=...)")
        choices = {
            one_of("options", n, self._vary): v for n, v in mapping("options", options).items()
        }
        settings = {n: self.np_random.uniform(*r) for n, r in self._vary.items()} | choices
        draw = int(self.np_random.integers(2**31))
        if self._anew:
            self._find(settings)
        else:
            self._count_steps()
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", ".*acts at the next reset", RuntimeWarning)
                self._set(settings)
        pieces, self._rows = SteppedRun(self.simulation), []
        seed_blocks(self._random, draw)
        pieces.show()
        self._pieces = pieces
        return self._observe(), {"varied": settings}

    def _set(self, settings: Mapping[str, Any]) -> None:
        """Set parameters of blocks, those of one block together: they may fit each other only."""
        changes: dict[Any, dict[str, Any]] = {}
        for name, value in settings.items():
            block, parameter = self._places[name]
            changes.setdefault(block, {})[parameter] = value
        for block, parameters in changes.items():
            if hasattr(block, "set"):
                block.set(**parameters)
            else:  # plain attributes
                vars(block).update(parameters)

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Fly one step; an action beyond its range is limited to it.

        A `FlightError` terminates the episode; ``info["reason"]`` has its text.

        Raises
        ------
        ParameterError
            for an action that has the wrong shape or is not finite, a reward that is not a finite
            number, a ``terminated`` that is not True or False, and if the diagram's ``dt`` was
            changed during the episode
        """
        if self._pieces is None:
            raise gymnasium.error.ResetNeeded("the episode has ended, or none has begun: reset()")
        if self.simulation.dt != self._dt:
            why = f"dt was changed from {self._dt:.9g} s during the episode: call reset() first"
            refuse("dt", self.simulation.dt, why)
        try:
            u = np.asarray(action, dtype=float)
        except (TypeError, ValueError):
            u = np.array(np.nan)
        if u.shape != self.action_space.shape or not np.isfinite(u).all():
            must_be("action", action, f"a list of {len(self._actions.names)} finite numbers")
        show(self._source.outputs, self._actions.to_ports(u))
        info, terminated = {}, True
        try:
            terminated = not self._pieces.run(self._count)
        except FlightError as error:
            info["reason"] = str(error)
        # before the judges, which may raise: the step counts; the first row is the start
        observation, truncated = self._observe(), len(self._rows) > self._longest
        if terminated:
            self._pieces = None
        reward = self._crash if info else number("reward", self._reward(self.values))
        if not terminated and flag("terminated", self._terminated(self.values)):
            self._pieces, terminated = None, True
        return observation, reward, terminated, truncated, info

    def _observe(self) -> np.ndarray:
        """The observation; it is recorded with the action and the first aircraft's position."""
        y = [read() for read in self._observed.read]
        row = [self.values["time"], *y, *values(self._source.outputs)[: len(self._actions.names)]]
        self._rows.append(row + [read() for read in self._place])
        return self._observed.to_space(y)

    def _recorded(self) -> tuple[np.ndarray, dict[str, np.ndarray], list[np.ndarray]]:
        """Times of the episode, observations and actions, and the aircraft's position."""
        if not self._rows:
            raise gymnasium.error.ResetNeeded("no episode has begun: reset()")
        time, *columns = np.array(self._rows).T
        names = [*self._observed.names, *self._actions.names]
        return time, dict(zip(names, columns, strict=False)), columns[len(names) :]

    def figure(self) -> Figure:
        """The episode so far: observations and actions over time."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        time, signals, _ = self._recorded()
        drawing = Figure(figsize=(8.0, 1.5 + 0.9 * len(signals)), layout="constrained")
        FigureCanvasAgg(drawing)
        axes = drawing.subplots(len(signals), 1, sharex=True, squeeze=False)[:, 0]
        for i, (ax, (name, column)) in enumerate(zip(axes, signals.items(), strict=True)):
            # the action of a row is held over the step that ends there
            style = ("C0", "default") if i < len(self._observed.names) else ("C1", "steps-pre")
            ax.plot(time, column, style[0], drawstyle=style[1])
            ax.set_ylabel(name.replace(".", "\n"), fontsize="small", rotation=0, ha="right")
            ax.grid(alpha=0.4)
        axes[-1].set_xlabel("time [s]")
        return drawing

    def render(self) -> np.ndarray | None:  # type: ignore[override]
        """The picture of `figure` as an array of RGB values."""
        if self.render_mode is None:
            return None
        canvas: Any = self.figure().canvas
        canvas.draw()
        return np.array(canvas.buffer_rgba())[..., :3]

    def track(self) -> Track:
        """The episode's flight, one row for each step, for `save_tracks`.

        Raises
        ------
        ParameterError
            for a diagram without an `Aircraft`
        """
        time, signals, place = self._recorded()
        if self._aircraft is None:
            refuse("diagram", self.simulation, "no track: the diagram has no Aircraft")
        model = self._aircraft.airframe.aircraft
        at: dict[str, Any] = dict(zip(POSITION, place, strict=True))
        return Track(model, model, time, **at, signals=signals)


def make_env(
    diagram: str | Path | Simulation,
    *,
    action: Ranges,
    observation: Sequence[str] | Ranges,
    reward: Judge,
    terminated: Judge | None = None,
    step: float = 0.1,
    duration: float = 20.0,
    vary: Ranges | None = None,
    settings: Mapping[str, Any] | None = None,
    wired: str = "refuse",
    normalise: bool = False,
    crash: float = 0.0,
    render_mode: str | None = None,
) -> DiagramEnv:
    """Make a Gymnasium environment from a diagram.

    Ports are ``"BLOCK.PORT"``: BLOCK is a variable of the script, or of the caller for a
    simulation, PORT the name of an output, or else of an input, or the number of a port without a
    name.

    Parameters
    ----------
    diagram : str, Path or Simulation
        name in the catalogue, path of a script that builds ``sim``, or a simulation, to which the
        actions are connected; its solver has a fixed step
    action : dict
        input ports with the range of their values, held over each step; at an `Aircraft` they are
        increments on the trimmed commands
    observation : list or dict
        ports, or ports with their ranges, to which the observations are limited
    reward : callable
        called after each step with the values of all ports by name, ``values["aircraft.theta"]``,
        and ``values["time"]`` in s; returns a finite number
    terminated : callable, optional
        called likewise: True ends the episode, as does a ``sim.stop()`` in the diagram or a
        `FlightError`
    step : float
        simulated time of a step in s, a multiple of the diagram's ``dt``
    duration : float
        time after which an episode is truncated, s
    vary : dict
        ranges from which each episode draws: ``"BLOCK.PARAMETER"``, set on the block before the
        reset, or ``"NAME"``, a variable of the script, which is then built again
    settings : dict, optional
        values with which the script is built, as for `load_diagram`
    wired : str
        "refuse" an action's port that is connected already, or "replace" the connection
    normalise : bool
        observations and actions between -1 and 1 over their ranges
    crash : float
        reward of a step that ends in a `FlightError`
    render_mode : str, optional
        "rgb_array"

    Raises
    ------
    ParameterError
        for a port, parameter or variable that does not exist, naming the nearest, a connected
        port, an adaptive solver, a ``step`` that is not a multiple of ``dt``, and a simulation
        that is an environment already
    """
    # copies: resets read them again
    options = {n: own(v) for n, v in locals().items() if n not in ("diagram", "settings")}
    if not action or not observation:
        refuse("action", action, "an environment needs at least one action and one observation")
    constants = mapping("settings", settings)
    if isinstance(diagram, Simulation):
        if constants or any("." not in name for name in mapping("vary", vary)):
            refuse("settings", settings, "settings and variables need a script, not a simulation")
        names = (_named(diagram, {**f.f_globals, **f.f_locals}) for f in frames())
        pair = diagram, next(filter(None, names), {})
        return DiagramEnv(lambda variation: pair, options)
    script = find_diagram(str(diagram))
    if any("." not in name for name in mapping("vary", vary)):
        # raises for variables that the script does not have
        Script(script, {**constants, **dict.fromkeys(mapping("vary", vary))})

    def build(variation: Mapping[str, Any]) -> tuple[Simulation, dict[str, Block]]:
        module = Script(script, {**constants, **variation}).load()
        sim = getattr(module, "sim", None)
        if not isinstance(sim, Simulation):
            refuse("diagram", str(script), f"{script.name} builds no Simulation named sim")
        return sim, _named(sim, vars(module))

    return DiagramEnv(build, options)


def _named(sim: Simulation, names: Mapping[str, Any]) -> dict[str, Block]:
    ids = {id(block) for block in contents(sim)[0]}
    return {name: value for name, value in names.items() if id(value) in ids}


def _ports(blocks: Mapping[str, Block], *sides: str) -> dict[str, _Port]:
    """Ports by ``"BLOCK.PORT"``; if both sides have a name, the last side wins."""
    ports_by_name: dict[str, _Port] = {}
    for name, block in blocks.items():
        for side in sides:
            register = getattr(block, side)
            ports = port_names(register) or {str(i): i for i in range(max(len(register), 1))}
            ports_by_name |= {f"{name}.{port}": (block, register, i) for port, i in ports.items()}
    return ports_by_name


def _lookup(parameter: str, name: Any, entries: Mapping[str, _T]) -> _T:
    if name in entries:
        return entries[name]
    block = str(name).partition(".")[0]
    ports = {x.partition(".")[2]: x for x in entries if x.startswith(f"{block}.")}
    close = [ports[x] for x in nearest_ports(str(name).partition(".")[2], ports)]
    why = did_you_mean(close or nearest(name, entries)) or f"; available: {', '.join(entries)}"
    if not entries:
        why = ": no variable of the script, or of the caller of make_env, is one of its blocks"
    refuse(parameter, name, f"no {name!r} in the diagram{why}")


def _ends(wire: Connection) -> list[tuple[Any, tuple[Block, int]]]:
    """Source ports of a connection, each with the target's block and input."""
    return [
        (source, (target.block, port_number(target.block.inputs, port)))
        for target in wire.targets
        for source, port in zip(wire.source.ports, target.ports, strict=True)
    ]


def _range(name: str, bounds: Any) -> tuple[float, float]:
    if not isinstance(bounds, (tuple, list)) or len(bounds) != 2:
        refuse(name, bounds, f"{name} needs a range (low, high), not {bounds!r}")
    return check_range(*bounds)


def _pitch_hold(step: float = 0.1, **options: Any) -> DiagramEnv:
    """Track the pitch angle that a `PitchHold` commands, with the elevator of a Cessna 172."""
    # nothing in it acts between two actions, so that a sample is as long as a step
    substeps = max(round(step * 120), 1)
    plane = Aircraft("c172p", altitude=5000.0, speed=90.0, T=step, substeps=substeps)
    hold = PitchHold("c172p", T=step)
    wires = [Connection(plane[port], hold[port]) for port in ("theta", "q", "elev_sat")]
    wires.append(Connection(hold["elevator"], plane["elevator"]))
    sim = Simulation([plane, hold], wires, dt=step, log=False)
    angles = ("plane.theta", "plane.q", "hold.theta_cmd")
    usual: dict[str, Any] = {
        "action": {"plane.elevator": (-0.3, 0.3)},
        "observation": dict.fromkeys(angles, (-30, 30)),
        "reward": lambda v: -abs(v["plane.theta"] - v["hold.theta_cmd"]),
        "vary": {"hold.theta_ref": (0.0, 4.0)},
        "wired": "replace",
        "crash": -1000.0,
    }
    return make_env(sim, **{**usual, **options, "step": step})


def _heading(**options: Any) -> DiagramEnv:
    """Turn a Cessna 172 from 170 to 190 deg at 5000 ft, in moderate turbulence."""
    plane = Aircraft("c172p", altitude=5000.0, speed=90.0, heading=170.0)
    air = DrydenTurbulence(severity="moderate", span=35.8)
    wires = [Connection(plane[port], air[port]) for port in ("h", "vt", "psi")]
    wires += [Connection(air[axis], plane[f"wind_{axis}"]) for axis in ("north", "east", "down")]
    sim = Simulation([plane, air], wires, dt=1 / 120, log=False)
    angles = [f"plane.{port}" for port in ("theta", "phi", "p", "q", "r", "beta")]
    ranges = {"plane.psi": (0, 360), "plane.h": (0, 10_000), "plane.vc": (0, 200)}
    usual: dict[str, Any] = {
        "action": {"plane.aileron": (-0.5, 0.5), "plane.elevator": (-0.3, 0.3)},
        "observation": {**dict.fromkeys(angles, (-90, 90)), **ranges},
        "reward": lambda v: -abs(v["plane.psi"] - 190) / 10 - abs(v["plane.h"] - 5000) / 100,
        "step": 0.2,
        "duration": 60.0,
        "crash": -1000.0,
    }
    return make_env(sim, **{**usual, **options})


def _off_the_approach(v: Mapping[str, float]) -> float:
    off_course, off_path = abs(v["course.across"]) / 1000, abs(v["glide.gs_ft"]) / 100
    return -(off_course + off_path + abs(v["aircraft.vc"] - 150) / 20)


# fly a 737 along localizer and glide path to the decision height, at 150 KCAS
_approach = functools.partial(
    make_env,
    "approach_737",
    action={f"aircraft.{port}": (-0.5, 0.5) for port in ("aileron", "elevator", "throttle")},
    observation={
        **{f"aircraft.{port}": (-90, 90) for port in ("theta", "phi", "p", "q", "r")},
        **{"aircraft.vc": (0, 400), "course.chi": (0, 360), "course.across": (-50_000, 50_000)},
        **{"glide.gs_ft": (-10_000, 10_000), "glide.dist": (-20_000, 200_000)},
    },
    reward=_off_the_approach,
    step=0.5,
    duration=330.0,
    wired="replace",
    crash=-10_000.0,
)


for _id, _task in (
    ("PitchHold-v1", "_pitch_hold"),
    ("HeadingInTurbulence-v0", "_heading"),
    ("Approach-v0", "_approach"),
):
    gymnasium.register(f"pathsim-jsbsim/{_id}", f"{__name__}:{_task}")
