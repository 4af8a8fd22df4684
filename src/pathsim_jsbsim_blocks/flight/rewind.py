"""`Rewind`: a loaded model put back to where loading left it, in a fraction of loading's time.

JSBSim's own reset stops the engines and keeps what was written, the initial conditions and the
random numbers; these are put back here. That this was all is not assumed but checked: the next
flight must start with the same value of every property as the first one. Models with a state that
JSBSim does not reset, such as the Concorde's fuel transfer, fail this check, and so do most after
NaN: they are loaded anew.
"""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Mapping
from math import isfinite

import jsbsim

from .airframe import Airframe
from .console import capture_console
from .trimming.initial import properties
from .trimming.state import TrimState, read_state
from .trimming.trimmer import Trimmer
from .writable import why_not

# bit of the mode of JSBSim's reset
_WITHOUT_RUN_IC = 2

_SEED = "simulation/randomseed"

# JSBSim acts when they are written
_ACTIONS = ("propulsion/set-running", "simulation/terminate", _SEED)

# NaN shows up here within one step, after which searches can end the process
_SPEED = "velocities/vt-fps"

# those of the pass before, from which no flight follows
_REPORTS = re.compile(r"/(fuel-flow-rate-\w+|tsfc)$")

# JSBSim uses these at every step where they exist; once written, they exist until it loads anew
_OVERRIDES = [f"atmosphere/override/{name}" for name in ("temperature", "pressure", "density")]

# initial conditions from which all others follow, and what they are in flight
_VELOCITIES = {
    **{f"ic/{axis}-fps": f"velocities/{axis}-fps" for axis in "uvw"},
    **{f"ic/{axis}-rad_sec": f"velocities/{axis}-rad_sec" for axis in "pqr"},
}
_ANGLES = {
    "ic/phi-rad": "attitude/phi-rad",
    "ic/theta-rad": "attitude/theta-rad",
    "ic/psi-true-rad": "attitude/psi-rad",
}
# takes away the wind that rounding leaves: beside such a velocity it is nothing
_FAST = {"ic/u-fps": 0.0, "ic/v-fps": 0.0, "ic/w-fps": 1e9, "ic/vw-mag-fps": 0.0}
_PLACE = [
    f"ic/{name}" for name in ("lat-geod-rad", "long-gc-rad", "terrain-elevation-ft", "h-sl-ft")
]
_COMMAND = re.compile(r"fcs/[\w-]+-cmd-norm(\[\d+\])?")

# how far a restored state may be from the trim, ft/s2 and rad/s2: as far as JSBSim's own search
_TOLERANCES = {
    **dict.fromkeys(("udot", "vdot", "wdot"), 0.01),
    **dict.fromkeys(("pdot", "qdot", "rdot"), 0.001),
}

# passes after which nothing is left of what the airframe was before; in the first ones JSBSim
# searches for the speed of propellers, each time nearer
_PASSES, _SPINS = 6, 2


class Rewind:
    """What an airframe was after loading, not yet initialised, and at the start of its flight."""

    def __init__(self, airframe: Airframe):
        self._airframe, self._version = airframe, airframe.version()
        self._overridden = list(filter(airframe.has, _OVERRIDES))
        # the state that `restore` puts back, where it does
        self.trimmed: TrimState | None = None
        nodes = airframe.nodes()
        read = [n for n in nodes if nodes[n].get_attribute(jsbsim.Attribute.READ)]
        self._state = [nodes[name] for name in read if not _REPORTS.search(name)]
        kept = [n for n in read if not n.startswith("ic/") and n not in _ACTIONS]
        nodes = {name: nodes[name] for name in kept if not why_not(name, airframe.has)}
        written = [x for x in nodes.values() if x.get_attribute(jsbsim.Attribute.WRITE)]
        self._loaded = [(node, node.get_double_value()) for node in written]
        self._seed = airframe.fdm[_SEED]
        # JSBSim derives each from the others, so that these come in an order
        still = dict.fromkeys(("ic/w-fps", *_VELOCITIES, "ic/alpha-rad", "ic/beta-rad"), 0.0)
        self._initial = [
            *dict.fromkeys(_ANGLES, 0.0).items(),
            *_FAST.items(),
            *still.items(),
            *((name, airframe.fdm[name]) for name in _PLACE),
        ]
        self._started: bytes | None = None

    def started(self) -> None:
        """The airframe is as each flight is to start."""
        self._started = self._values()

    def rewind(self) -> bool:
        """Put the airframe back to where loading left it; False where that is not possible."""
        airframe, fdm = self._airframe, self._airframe.fdm
        if not isfinite(fdm[_SPEED]) or airframe.version() != self._version:
            return False
        if [*filter(airframe.has, _OVERRIDES)] != self._overridden:
            return False
        capture_console()
        fdm.reset_to_initial_conditions(_WITHOUT_RUN_IC)
        for name, value in self._initial:
            fdm[name] = value
        fdm[_SEED] = self._seed
        for node, value in self._loaded:
            if node.get_double_value() != value:
                node.set_double_value(value)
        airframe.forget()
        Trimmer.of(airframe).forget()
        return True

    def proven(self) -> bool:
        """Whether all properties are those with which the first flight started."""
        return self._values() == self._started

    def restores(self, trimmed: TrimState, setup: Mapping[str, float] | None) -> bool:
        """Whether `restore` puts a trim back each time alike; tried on the trimmed airframe."""
        if trimmed.condition.mode == "none":
            return False
        fdm, stopped = self._airframe.fdm, self._airframe.stopped
        controls = [node for node in self._airframe.nodes() if _COMMAND.fullmatch(node)]
        state = {"ic/h-sl-ft": "position/h-sl-ft", **_ANGLES, **_VELOCITIES}
        self._kept = [(name, fdm[now]) for name, now in state.items()]
        self._commands = {name: fdm[name] for name in controls}, stopped
        self.trimmed = trimmed
        values = []
        for _ in range(2):
            if not self.rewind():
                break
            self.restore(setup)
            values.append(self._values())
        now = read_state(self._airframe, trimmed.condition)
        if len({*values}) == 1 and all(
            abs(getattr(now, name) - getattr(trimmed, name)) <= tolerance
            for name, tolerance in _TOLERANCES.items()
        ):
            return True
        self.trimmed = None
        return False

    def restore(self, setup: Mapping[str, float] | None) -> None:
        """Put the trimmed state back on an airframe that was rewound."""
        assert self.trimmed is not None
        airframe, fdm, condition = self._airframe, self._airframe.fdm, self.trimmed.condition
        airframe.write(properties(airframe, condition, setup), "setup")
        commands, airframe.stopped = self._commands
        airframe.start_engines()
        for name, value in commands.items():
            fdm[name] = value
        if wind := math.hypot(condition.wind_north, condition.wind_east):
            direction = math.atan2(condition.wind_east, condition.wind_north)
            fdm["ic/vw-mag-fps"], fdm["ic/vw-dir-deg"] = wind, math.degrees(direction)
        for name, value in self._kept:
            fdm[name] = value
        propellers = airframe.of_engines("propeller-rpm")
        with airframe.engines_stopped():
            # actuators then take their final position at once, and no fuel is burnt
            fdm.set_trim_status(True)
            try:
                for i in range(_PASSES):
                    airframe.run_ic()
                    if propellers and i < _SPINS:
                        fdm.get_propulsion().get_steady_state()
            finally:
                fdm.set_trim_status(False)

    def _values(self) -> bytes:
        return array("d", map(jsbsim.FGPropertyNode.get_double_value, self._state)).tobytes()
