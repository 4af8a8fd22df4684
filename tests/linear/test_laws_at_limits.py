"""`to_statespace` of a law that is at a limit: the model is true there, and says so."""

import warnings

import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope

from pathsim_jsbsim_blocks import (
    Actuator,
    Aircraft,
    AirspeedHold,
    AltitudeHold,
    Autopilot,
    HeadingHold,
    PitchHold,
    RollHold,
    YawDamper,
)


def limits(block, t=0.0):
    """What `to_statespace` warns of, in its own words."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        block.to_statespace(t)
    texts = [str(w.message) for w in caught if "is at a limit" in str(w.message)]
    assert len(texts) == len(caught) <= 1
    return texts[0].split("linear model ")[1].split(" has no")[0] if texts else ""


def seen(*blocks):
    """Scopes, and the connections to them of the commands of blocks."""
    commands = {block: [*names] for block in blocks if (names := getattr(block, "commands", ()))}
    scopes = [Scope() for _ in commands]
    rows = zip(scopes, commands.items(), strict=True)
    return scopes, [Connection(block[names], s[: len(names)]) for s, (block, names) in rows]


def run(block, duration=2.0, **values):
    """A block with constant inputs, after a time."""
    sources = [Constant(x) for x in values.values()]
    wires = [Connection(s, block[n]) for s, n in zip(sources, values, strict=True)]
    scopes, more = seen(block)
    Simulation([block, *sources, *scopes], [*wires, *more], dt=1 / 120, log=False).run(duration)
    return block


LEVEL = {"h": 5000.0, "hdot": 0.0, "theta": 1.3, "q": 0.0}


@pytest.mark.parametrize(
    ("block", "duration", "inputs", "lost"),
    [
        (PitchHold(theta_ref=3.0), 0.1, {"theta": 1.3, "q": 0.0}, "theta_ref"),
        (PitchHold(theta_ref=1.3), 0.1, {"theta": 1.3, "q": 0.0}, ""),
        (PitchHold(), 0.1, {"theta": 1.3, "q": 0.0}, ""),
        (PitchHold(authority=0.01), 2.0, {"theta": 1.3, "q": 5.0}, "elevator"),
        (PitchHold(), 0.1, {"theta": 1.3, "q": 0.0, "theta_ref": -4.0}, "theta_ref"),
        (RollHold(phi_ref=20.0), 0.1, {"phi": 0.0, "p": 0.0}, "phi_ref"),
        (HeadingHold(psi_ref=120.0), 5.0, {"psi": 90.0, "phi": 25.0, "p": 0.0}, "psi_ref"),
        (HeadingHold(psi_ref=91.0), 5.0, {"psi": 90.0, "phi": 1.0, "p": 0.0}, ""),
        (AltitudeHold(h_ref=9000.0), 0.2, LEVEL, "h_ref"),
        (AltitudeHold(h_ref=5001.0), 5.0, LEVEL, ""),
        (AirspeedHold(vc_ref=150.0), 0.1, {"vc": 90.0, "hdot": 0.0}, "vc_ref"),
        (AirspeedHold(vc_ref=94.0, authority=0.02), 9.0, {"vc": 90.0, "hdot": 0.0}, "throttle"),
        (YawDamper(), 0.5, {"r": 0.1}, ""),
        (Actuator(), 2.0, {"u": 1.5}, "y"),
        (Actuator(max_rate=0.1), 2.0, {"u": 0.9}, "y"),
        (Actuator(max_rate=0.1), 2.0, {"u": 0.1}, ""),
    ],
)
def test_a_law_on_its_ramp_or_at_its_stop_is_told(block, duration, inputs, lost):
    run(block, duration, **inputs)
    assert limits(block) == lost
    assert limits(block) == lost  # looking changes nothing


HOLDS = (PitchHold, RollHold, AltitudeHold, HeadingHold, AirspeedHold, YawDamper, Autopilot)


@pytest.mark.filterwarnings("ignore:.*measures 0:RuntimeWarning")
@pytest.mark.parametrize("aircraft", ["c172p", "737"])
def test_holds_at_the_trim_of_their_aircraft_are_at_no_limit(aircraft):
    flight = {"c172p": (5000, 90, None), "737": (10_000, 280, 0.0)}[aircraft]
    plane = Aircraft(aircraft, **dict(zip(("altitude", "speed", "gear"), flight, strict=True)))
    holds = [kind(gains=aircraft) for kind in HOLDS]
    wires = [
        Connection(plane[port], hold[port])
        for hold in holds
        for port in plane.output_port_labels
        if port in hold.input_port_labels
    ]
    scopes, more = seen(*holds)
    sim = Simulation([plane, *holds, *scopes], [*wires, *more], dt=1 / 120, log=False)
    assert [limits(hold) for hold in holds] == len(holds) * [""]
    sim.run(1.0)
    assert [limits(hold) for hold in holds] == len(holds) * [""]


def test_looking_at_a_law_uses_up_no_warning():
    hold = run(AltitudeHold(), 0.2, **LEVEL)
    assert limits(hold) == ""
    port = hold.input_port_labels["h_ref"]
    u = hold.inputs.to_array().tolist()
    u[port:] = [5500.0, *u[port + 1 :]]
    with pytest.warns(RuntimeWarning, match="is an increment"):
        hold.law(u, hold.clock.latest[2])
