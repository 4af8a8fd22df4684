"""Attributes of a block that is built: an unknown one is refused, naming the nearest."""

import inspect
import warnings

import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Block

import pathsim_jsbsim_blocks
from pathsim_jsbsim_blocks import Aircraft, Autopilot, DoubletSource, PitchHold, fly
from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.errors import KeywordError

pytestmark = pytest.mark.matrix

BLOCKS = [
    block
    for name in pathsim_jsbsim_blocks.__all__
    if inspect.isclass(block := getattr(pathsim_jsbsim_blocks, name)) and issubclass(block, Block)
]


@pytest.mark.filterwarnings("ignore:.*is not linear")
@pytest.mark.parametrize("kind", BLOCKS, ids=lambda kind: kind.__name__)
def test_every_block_refuses_unknown_names_and_takes_those_of_pathsim(kind):
    block = kind()
    for name in ("nothing_like_it", *(f"{name}_" for name in kind.info()["parameters"])):
        with pytest.raises(KeywordError, match=name):
            setattr(block, name, 1.0)
        assert not hasattr(block, name)
    block._own = 1.0
    # all that PathSim gives a block
    for name in vars(Block()):
        setattr(block, name, getattr(block, name))


@pytest.mark.parametrize(
    ("kind", "name", "said"),
    [
        (PitchHold, "thetaref", "PitchHold has no parameter 'thetaref'; did you mean 'theta_ref'?"),
        (Aircraft, "spede", "Aircraft has no parameter 'spede'; did you mean 'speed'"),
        (Autopilot, "href", "'h_ref'"),
        (DoubletSource, "amplitud", "did you mean 'amplitude'"),
        (Aircraft, "elevator", "'elevator' is an input port, which a Connection leads into"),
    ],
)
def test_the_nearest_is_named(kind, name, said):
    block = kind()
    with pytest.raises(KeywordError) as caught:
        setattr(block, name, 5.0)
    assert said in str(caught.value)
    assert (caught.value.parameter, caught.value.value) == (name, 5.0)


def test_subclasses_of_users_have_their_own():
    class Mine(PitchHold):
        def __init__(self, goal=3.0):
            super().__init__("c172p", theta_ref=goal)
            self.goal = goal

    class Bare(PitchHold):
        pass

    for hold in (Mine(), Bare()):
        hold.anything = 5
        assert hold.anything == 5


def flying(plane):
    source = DoubletSource(amplitude=0.02, start=0.1, width=0.1)
    return Simulation([plane, source], [Connection(source, plane["elevator"])], dt=plane.T, log=0)


def test_a_new_speed_says_once_that_it_acts_at_the_next_reset():
    plane = Aircraft("c172p", altitude=5000, speed=90)
    sim = flying(plane)
    fly(sim, 0.1)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        plane.speed = 110
        plane.set(speed=105, altitude=4000)
        plane.heading = 30
    assert [str(w.message) for w in caught] == [
        "plane.speed = 110 acts at the next reset: sim.reset() or sim.run(..., reset=True)"
    ]
    assert caught[0].filename == __file__
    fly(sim, 0.1)
    assert plane.outputs["vc"] == pytest.approx(90, abs=0.5)
    sim.reset()
    assert plane.outputs["vc"] == pytest.approx(105, abs=0.5)
    assert plane.outputs["h"] == pytest.approx(4000, abs=0.5)


def test_nothing_is_said_where_the_flight_has_the_value_or_a_script_is_set():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plane = Aircraft("c172p", altitude=5000, speed=90)
        plane.speed = 90
        plane.record_inputs = True  # acts at once
        sim = flying(plane)
        fly(sim, 0.1)
        sim.reset()
        diagram = load_diagram("pitch_hold", {"aircraft.speed": 95.0})
        fly(diagram.sim, 0.1)
    assert diagram.aircraft.outputs["vc"] == pytest.approx(95, abs=0.5)
