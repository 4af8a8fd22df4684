"""Checkpoints: blocks with a plain state go on bit for bit; an aircraft refuses, by its reason."""

from functools import partial

import numpy as np
import pytest
from all_holds import HOLDS
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Scope, Source

from pathsim_jsbsim_blocks import (
    Actuator,
    Aircraft,
    DiscretePID,
    DrydenTurbulence,
    ParameterError,
    Sensor,
)

pytestmark = pytest.mark.matrix

T = 1 / 120


def test_an_aircraft_refuses_and_leaves_no_file(tmp_path):
    plane = Aircraft("c172p", altitude=5000, speed=90)
    sim = Simulation([plane], dt=plane.T, log=False)
    with pytest.raises(ParameterError, match=r"studies\.branch") as error:
        sim.save_checkpoint(str(tmp_path / "stop"))
    assert (error.value.parameter, error.value.value) == ("checkpoint", "Aircraft_0")
    assert list(tmp_path.iterdir()) == []


PARAMETERS = {
    "PitchHold": {"theta_ref": 3.0},
    "CourseHold": {"waypoints": [(0.1, 0.05), (0.2, 0.0)]},
    "GlideslopeHold": {"threshold": (0.1, 0.0)},
}
BLOCKS = [
    *(partial(hold, "c172p", **PARAMETERS.get(name, {})) for name, hold in HOLDS.items()),
    lambda: DiscretePID(Kp=0.5, Ki=0.3, T=0.03),
    lambda: Sensor(noise=0.1, lag=0.2, seed=3),
    lambda: Actuator(),
    lambda: DrydenTurbulence(seed=5),
]


@pytest.mark.parametrize("make", BLOCKS)
@pytest.mark.parametrize(
    ("parts", "depth"), [(1, 0), (2, 1)], ids=["dt = T", "dt = T/2, stopped between samples"]
)
@pytest.mark.filterwarnings("ignore:.*(measures 0 at|jumps over a sample instant|no landings)")
def test_a_block_with_a_plain_state_goes_on(make, depth, parts, tmp_path):
    dt = T / parts

    def diagram():
        block, scope = make(), Scope()
        off = (block.input_port_labels or {}).get("off")
        sources = [
            Source(lambda t, i=i: 0.0 if i == off else np.sin((i + 1) * t))
            for i in range(len(block.inputs))
        ]
        outer = block
        if depth:
            inside = Interface()
            wires = [Connection(inside[i], block[i]) for i in range(len(sources))]
            wires += [Connection(block[i], inside[i]) for i in range(len(block.outputs))]
            outer = Subsystem([inside, block], wires)
        wires = [Connection(source, outer[i]) for i, source in enumerate(sources)]
        wires += [Connection(outer[i], scope[i]) for i in range(len(block.outputs))]
        return Simulation([outer, scope, *sources], wires, dt=dt, log=False), scope

    whole, scope = diagram()
    whole.run(151 * dt)
    whole.save_checkpoint(str(tmp_path / "stop"))
    whole.run(1.0)
    again, later = diagram()
    again.run(0.3)
    again.load_checkpoint(str(tmp_path / "stop"))
    again.run(1.0)
    y, same = (s.read()[1][:, -100:] for s in (scope, later))
    assert np.ptp(y, axis=1).max() > 0.0
    assert np.array_equal(y, same)


def test_a_hold_of_another_period_is_refused(tmp_path):
    def simulation(T):
        hold = DiscretePID(T=T)
        return Simulation([hold], [], dt=0.1, log=False), hold

    sim, _ = simulation(0.1)
    sim.save_checkpoint(str(tmp_path / "stop"))
    other, hold = simulation(0.2)
    with pytest.raises(ParameterError) as error:
        other.load_checkpoint(str(tmp_path / "stop"))
    assert (error.value.parameter, error.value.value) == ("T", 0.2)
    assert hold.clock.period == 0.2
