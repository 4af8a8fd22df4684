"""Copies of blocks, by ``copy.copy``, ``copy.deepcopy`` and by pickling: they go on as the block does."""

import copy
import inspect
import pickle

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Block, Scope, Source

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks import (
    Actuator,
    Autopilot,
    DoubletSource,
    DrydenTurbulence,
    ISAtmosphere,
    OneMinusCosineGust,
    PitchHold,
    RampSource,
    Sensor,
)

T = 1 / 64  # s; sums of it are exact

BLOCKS = {
    name: block
    for name in package.__all__
    if inspect.isclass(block := getattr(package, name)) and issubclass(block, Block)
}
AIRCRAFT = ["Aircraft", "JSBSimFDM"]

BY = pytest.mark.parametrize(
    "by",
    [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))],
    ids=["copy", "deepcopy", "pickle"],
)


@pytest.mark.parametrize("name", [name for name in BLOCKS if name not in AIRCRAFT])
def test_a_copy_has_the_parameters_and_ports_and_its_own_values(name):
    block = BLOCKS[name](**{"method": "algebraic"} if name == "LinearAircraft" else {})
    other = pickle.loads(pickle.dumps(copy.copy(copy.deepcopy(block))))
    assert repr(other) == repr(block)
    for side in ("inputs", "outputs"):
        ours, theirs = getattr(block, side), getattr(other, side)
        assert theirs._mapping == ours._mapping
        assert theirs.to_array().tolist() == ours.to_array().tolist()
        theirs[0] = 17.0
        assert ours[0] != 17.0


def flown(block, duration, start=0.0):
    """The block's outputs, with waves at all its inputs, in a diagram of its own."""
    names, outputs = list(block.input_port_labels or ()), len(block.outputs)
    waves = [Source(lambda t, i=i: 100.0 + 50.0 * np.sin((1 + i) * t)) for i, _ in enumerate(names)]
    scope = Scope()
    wires = [Connection(wave, block[name]) for wave, name in zip(waves, names, strict=True)]
    wires += [Connection(block[i], scope[i]) for i in range(outputs)]
    sim = Simulation([block, *waves, scope], wires, dt=T, log=False)
    sim.time = start
    sim.run(duration)
    return np.array(scope.read()[1]), sim


@BY
@pytest.mark.parametrize(
    "make",
    [
        lambda: PitchHold("c172p", theta_ref=3.0, T=T),
        lambda: Autopilot("737", h_ref=120.0, T=T, reference="absolute"),
        lambda: Sensor(bias=0.5, noise=0.2, lag=0.3, seed=7, T=T),
        lambda: Actuator(frequency=8.0, max_rate=20.0, high=130.0, T=T),
        lambda: DrydenTurbulence(seed=3, T=T),
        lambda: DoubletSource(start=0.5, width=1.0),
        lambda: RampSource(start=0.5, rise_time=2.0),
        lambda: OneMinusCosineGust(airspeed=300.0, start=0.5),
        lambda: ISAtmosphere(),
    ],
    ids=lambda make: type(make()).__name__,
)
def test_a_copy_made_in_flight_goes_on_as_the_block_does(make, by):
    whole, _ = flown(make(), 2.0)
    block = make()
    _, sim = flown(block, 1.0)
    other = by(block)
    after, _ = flown(other, 1.0, start=1.0)
    assert after[:, 1:].tolist() == whole[:, 65:].tolist()
    assert np.abs(whole[:, 65:] - whole[:, 64:65]).max() > 1e-6
    # and the block itself is not moved by it
    assert block.outputs.to_array().tolist() == whole[:, 64].tolist()
    sim.run(1.0)
    assert block.outputs.to_array().tolist() == whole[:, 128].tolist()


@BY
def test_a_copy_has_parameters_of_its_own(by):
    block = PitchHold("c172p", theta_ref=3.0, T=T)
    other = by(block)
    other.set(theta_ref=-2.0, gains="737")
    assert (block.theta_ref, block._checked.theta_ref) == (3.0, 3.0)
    fresh = PitchHold("737", theta_ref=-2.0, T=T)
    assert flown(other, 1.0)[0].tolist() == flown(fresh, 1.0)[0].tolist()
