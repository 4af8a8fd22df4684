"""Mistakes in the wiring are named, and nothing else is."""

import json
import warnings

import pytest
from all_holds import HOLDS
from how_many import first
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Adder, Amplifier, Constant, Scope

from pathsim_jsbsim_blocks import (
    Actuator,
    Aircraft,
    AltitudeHold,
    Autopilot,
    DiscretePID,
    DrydenTurbulence,
    FlightRecorder,
    ISAtmosphere,
    JSBSimFDM,
    LinearAircraft,
    Microburst,
    PitchHold,
    RollHold,
    WindShear,
    YawDamper,
    fly,
)
from pathsim_jsbsim_blocks._core.wiring import warn_of_wiring
from pathsim_jsbsim_blocks.catalogue import diagram_names, load_diagram
from pathsim_jsbsim_blocks.control.gain_tables import TABLES, table

# what a hold needs from the aircraft
MEASURED = {"theta": "theta", "q": "q", "elev_sat": "elev_sat"}


def said(sim, run=None):
    """The warnings of a run."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        (run or (lambda: fly(sim, 0.05)))()
    assert all(w.category is RuntimeWarning for w in caught)
    return [str(w.message) for w in caught]


@pytest.mark.parametrize(
    "run",
    [
        lambda sim: sim.run(0.05),
        lambda sim: fly(sim, 0.05),
        lambda sim: sim.timestep(sim.dt),
        lambda sim: [*sim.run_streaming(0.05)],
    ],
    ids=["run", "fly", "timestep", "streaming"],
)
def test_every_way_to_run_warns_of_a_lost_command_and_of_default_gains(run):
    plane = Aircraft("737", altitude=10_000, speed=280, gear=0)
    lost, other = PitchHold(), RollHold()
    wires = [Connection(plane["theta", "q"], lost["theta", "q"])]
    wires += [Connection(plane["phi", "p"], other["phi", "p"])]
    wires += [Connection(other["aileron"], plane["aileron"])]
    sim = Simulation([plane, lost, other], wires, dt=1 / 120, log=False)
    assert said(sim, lambda: run(sim)) == [
        "lost['elevator'] is not connected: the command has no effect",
        "other has the gains of c172p, but flies plane, which is 737",
    ]
    assert said(sim, lambda: run(sim)) == []
    assert said(sim, lambda: fly(sim, 0.05, reset=True)) == []


@pytest.mark.parametrize("run", [Simulation.run, fly])
def test_warnings_are_at_the_line_that_runs(run):
    low, high, hold, air = Constant(5e3), Constant(9e4), AltitudeHold(), ISAtmosphere()
    stranger = Constant(1.0)
    wires = [Connection(low, hold["h"]), Connection(high, hold["h_ref"], air["altitude"])]
    wires += [Connection(stranger, hold["theta"])]
    sim = Simulation([low, high, hold, air], wires, dt=1 / 50, log=False)
    with pytest.warns(RuntimeWarning) as caught:
        run(sim, 0.1)
    texts = "stranger is", "jumps over a sample", "measures 0 at", "an increment", "extrapolated"
    for text in texts:
        assert [w.filename for w in caught if text in str(w.message)] == [__file__]


def test_a_wired_block_that_is_not_in_the_simulation():
    source, amplifier, scope = Constant(1.0), Amplifier(2.0), Scope()
    sim = Simulation(
        [amplifier], [Connection(source, amplifier), Connection(amplifier, scope)], log=False
    )
    assert said(sim) == [
        "source is connected (source['out'] to amplifier[0]), but not among the blocks of the "
        "simulation: it has no effect",
        "scope is connected (amplifier[0] to scope[0]), but not among the blocks of the "
        "simulation: it has no effect",
    ]
    assert said(sim) == []


def test_two_wires_into_one_port_by_name_and_by_number():
    plane, kick, other = Aircraft(), Constant(0.01), Constant(0.02)
    wires = [Connection(kick, plane["elevator"]), Connection(other, plane[0])]

    def simulation():
        return Simulation([plane, kick, other], wires, dt=1 / 120, log=False)

    assert said(simulation()) == [
        "two connections lead to plane['elevator'], from kick['out'] and other['out']: use an Adder. "
        "One of them has no effect"
    ]
    # what is switched off leaves its place
    wires[1].off()
    assert said(simulation()) == []
    wires[1].on()
    other.off()
    assert said(simulation()) == []


def test_a_place_without_a_wire():
    plane, recorder = Aircraft(), FlightRecorder(signals=["calibrated airspeed [kt]"])
    shear, burst = WindShear(), Microburst()
    wires = [
        Connection(plane["lat"], recorder[0], burst["lat"]),
        Connection(plane["h", "theta", "phi", "psi"], recorder["h", "theta", "phi", "psi"]),
        Connection(plane["lon"], burst["lon"]),
        Connection(shear["north"], plane["wind_north"]),
        Connection(burst["east"], plane["wind_east"]),
    ]
    sim = Simulation([plane, recorder, shear, burst], wires, dt=1 / 120, log=False)
    assert said(sim) == [
        "recorder['lon'] is not connected and reads 0",
        "shear['h'] is not connected and reads 0",
        "burst['h'] is not connected and reads 0",
    ]
    assert said(sim) == []


def test_an_input_of_the_fdm_that_leaves_its_trim_without_a_wire():
    throttle, elevator, rudder = (f"fcs/{x}-cmd-norm" for x in ("throttle", "elevator", "rudder"))
    fdm = JSBSimFDM(
        aircraft_model="c172p",
        trim_airspeed=90,
        trim_altitude=5000,
        input_properties=[throttle, elevator, rudder],
    )
    kick = Constant(0.01)
    sim = Simulation([fdm, kick], [Connection(kick, fdm[rudder])], dt=1 / 120, log=False)
    # the elevator command is 0 at the trim
    assert said(sim) == [f"fdm['{throttle}'] is not connected and reads 0"]
    other = JSBSimFDM(
        aircraft_model="c172p", trim_airspeed=90, trim_altitude=5000, input_properties=[throttle]
    )
    sim = Simulation([other], [], dt=1 / 120, log=False)
    other.inputs[0] = 0.7  # as a program of its own may do
    assert said(sim) == []


def test_a_wire_from_inside_a_subsystem_to_its_outside():
    # PathSim transmits nothing; a landing flew on holds that it should have switched off
    inside, first, second = Interface(), Amplifier(1.0), Amplifier(2.0)
    box = Subsystem(
        [inside, first, second],
        [Connection(inside, first, second), Connection(first, inside)],
    )
    outside, beyond, scope = Constant(1.0), Amplifier(1.0), Scope()
    blocks = [outside, box, beyond, scope]
    wires = [Connection(outside, box), Connection(box, scope), Connection(beyond, scope[1])]
    assert said(Simulation(blocks, wires, log=False)) == []
    wires.append(Connection(second, beyond))
    sim = Simulation(blocks, wires, log=False)
    assert said(sim) == [
        "second is connected (second[0] to beyond[0]) outside its subsystem, not by a port of it: "
        "it has no effect"
    ]
    sim.run(0.1)
    assert scope.read()[1][:, -1].tolist() == [1.0, 0.0]


def test_a_wire_added_later_is_seen_at_the_next_run():
    stranger, one, scope = Constant(1.0), Constant(2.0), Scope()
    for flies_before in (True, False):
        sim = Simulation([one, scope], [Connection(one, scope)], log=False)
        if flies_before:
            assert said(sim) == []
        sim.add_connection(Connection(stranger, scope[1]))
        # `load_diagram` looks before the run
        assert said(sim, lambda sim=sim: warn_of_wiring(sim)) == []
        assert len(said(sim)) == 1


def autopilot(*switches):
    """Messages on an autopilot that drives nothing, with loops switched off."""
    plane, pilot, one = Aircraft(), Autopilot(), Constant(1.0)
    names = ["theta", "phi", "psi", "p", "q", "r", "h", "hdot", "vc"]
    wires = [Connection(plane[n], pilot[n]) for n in names]
    wires += [Connection(one, pilot[s]) for s in switches]
    return said(Simulation([plane, pilot, one], wires, dt=1 / 120, log=False))


def test_a_loop_that_is_switched_off_needs_no_wire():
    nowhere = "pilot[{!r}] is not connected: the command has no effect"
    assert autopilot() == [nowhere.format(n) for n in ("elevator", "aileron", "throttle")]
    assert autopilot("speed_off", "pitch_off") == [nowhere.format("aileron")]


def test_other_controllers_and_holds_that_drive_anything_are_left_alone():
    plane, damper, gain, pid = Aircraft(), YawDamper(), Amplifier(1.0), DiscretePID()
    wires = [Connection(plane["r"], damper["r"]), Connection(plane["theta"], pid["y"])]
    wires += [Connection(damper["rudder"], gain)]
    sim = Simulation([plane, damper, gain, pid], wires, dt=1 / 120, log=False)
    assert said(sim) == []


def test_every_hold_names_the_commands_that_it_gives():
    for name, block in HOLDS.items():
        surfaces = {"elevator", "aileron", "rudder", "throttle"}
        if name == "Autopilot":  # an aircraft may have its own yaw damper
            surfaces.remove("rudder")
        assert {*block.commands} == surfaces & {*block.output_port_labels}
        # the commands of a landing cannot be switched off one by one
        switches = {""} if name == "FlareHold" else {*block.input_port_labels}
        assert {*block.commands.values()} <= switches


@pytest.mark.parametrize("name", first(diagram_names()))
def test_no_diagram_of_the_catalogue_has_a_mistake(name):
    diagram = load_diagram(name)
    assert said(diagram.sim, lambda: fly(diagram.sim, 2 * diagram.sim.dt)) == []


def test_a_wind_that_blows_nowhere():
    plane, air, burst = Aircraft(), DrydenTurbulence(), Microburst()
    wires = [Connection(plane[port], air[port]) for port in ("h", "vt", "psi")]
    wires += [Connection(plane[port], burst[port]) for port in ("lat", "lon", "h")]
    wires += [Connection(burst["north"], plane["wind_north"])]
    sim = Simulation([plane, air, burst], wires, dt=1 / 120, log=False)
    assert said(sim) == ["air is not connected: the wind has no effect"]


@pytest.mark.parametrize("run", [Simulation.run, fly])
def test_a_look_at_the_wiring_marks_no_input_as_connected(run):
    source, hold, scope = Constant(1.0), PitchHold(), Scope()
    wires = [Connection(source, hold["q"]), Connection(hold["elevator"], scope)]
    sim = Simulation([source, hold, scope], wires, dt=1 / 50, log=False)
    measured, jumps = said(sim, lambda: run(sim, 0.05))
    assert measured == "PitchHold measures 0 at unconnected inputs: theta"
    assert "jumps over a sample instant" in jumps


def elevator(plane, hold, through=()):
    """Wires of a pitch hold, whose command goes through other blocks."""
    chain = [hold["elevator"], *through]
    ends = [*through, plane["elevator"]]
    command = [Connection(a, b) for a, b in zip(chain, ends, strict=True)]
    return [*command, *(Connection(plane[a], hold[b]) for a, b in MEASURED.items())]


def others(name, plane):
    return [f"hold has the gains of {name}, but flies plane, which is {plane}"]


OWN = table("c172p").points[0].gains


@pytest.mark.parametrize(
    ("gains", "said_of"),
    [
        ("c172p", []),
        ("737", others("737", "c172p")),
        (table("737"), others("737", "c172p")),
        ({"altitude": "737", "pitch": OWN.pitch}, others("737", "c172p")),
        ({"altitude": "c172p", "pitch": "737"}, []),  # in part those of this one
        ({"altitude": OWN.altitude, "pitch": OWN.pitch}, []),
        (OWN, []),
    ],
)
def test_gains_of_another_aircraft(gains, said_of):
    plane, hold = Aircraft("c172p", altitude=5000, speed=90), AltitudeHold(gains=gains)
    names = {"h": "h", "hdot": "hdot", **MEASURED}
    wires = [Connection(plane[a], hold[b]) for a, b in names.items()]
    wires += [Connection(hold["elevator"], plane["elevator"])]
    sim = Simulation([plane, hold], wires, dt=1 / 120, log=False)
    assert said(sim) == said_of
    assert said(sim) == []


def test_gains_of_a_file_are_for_the_aircraft_that_it_names(tmp_path):
    file = tmp_path / "mine.json"
    for name, expected in (("c172p", []), ("c310", others("c310", "c172p"))):
        document = json.loads((TABLES / "c172p.json").read_text())
        file.write_text(json.dumps({**document, "aircraft": name}))
        plane, hold = Aircraft("c172p", altitude=5000, speed=90), PitchHold(gains=str(file))
        file.unlink()  # what it said is known
        assert (
            said(Simulation([plane, hold], elevator(plane, hold), dt=1 / 120, log=False))
            == expected
        )


def test_gains_of_another_aircraft_through_other_blocks():
    for kind in (LinearAircraft, Aircraft):
        plane, hold = kind("c172p", altitude=5000, speed=90), PitchHold(gains="737")
        through = [Adder(), Actuator(), Amplifier(1.0)]
        wires = elevator(plane, hold, through)
        sim = Simulation([plane, hold, *through], wires, dt=1 / 120, log=False)
        assert said(sim) == others("737", "c172p")
    stick = "fcs/elevator-cmd-norm"
    plane = JSBSimFDM(
        input_properties=[stick],
        output_properties=["attitude/theta-deg", "velocities/q-rad_sec"],
        aircraft_model="c172p",
        trim_airspeed=90,
        trim_altitude=5000,
    )
    hold, limit = PitchHold(gains="737"), Amplifier(0.0)
    wires = [
        Connection(hold["elevator"], limit),
        Connection(limit, plane[stick]),
        Connection(plane[0, 1], hold["theta", "q"]),
    ]
    assert said(Simulation([plane, hold, limit], wires, dt=1 / 120, log=False)) == others(
        "737", "c172p"
    )


def test_a_hold_whose_reference_another_aircraft_follows_does_not_fly_it():
    leader = Aircraft("c172p", altitude=5000, speed=90)
    follower = Aircraft("737", altitude=5000, speed=250, gear=1.0)
    hold, servo, pid = PitchHold(gains="c172p"), Actuator(), DiscretePID()
    wires = [*elevator(leader, hold, [servo])[:-1], Connection(servo["sat"], hold["elev_sat"])]
    wires += [Connection(hold["theta_cmd"], pid["r"]), Connection(follower["theta"], pid["y"])]
    wires += [Connection(pid, follower["elevator"])]
    sim = Simulation([leader, follower, hold, servo, pid], wires, dt=1 / 120, log=False)
    assert said(sim) == []


def test_gains_in_a_subsystem():
    inside, hold = Interface(), PitchHold(gains="c172p")
    box = Subsystem(
        [inside, hold],
        [
            Connection(inside[0, 1], hold["theta", "q"]),
            Connection(hold["elevator"], inside[0]),
            Connection(hold["theta_cmd"], inside[1]),
        ],
    )
    plane = Aircraft("737", altitude=5000, speed=250, gear=1.0)
    wires = [Connection(plane["theta", "q"], box[0, 1]), Connection(box[0], plane["elevator"])]
    sim = Simulation([plane, box], wires, dt=1 / 120, log=False)
    assert said(sim) == others("c172p", "737")


@pytest.mark.parametrize("crossed", [False, True])
def test_two_aircraft_in_a_subsystem_are_flown_by_different_ports(crossed):
    light = Aircraft("c172p", altitude=5000, speed=90)
    heavy = Aircraft("737", altitude=5000, speed=250, gear=1.0)
    inside, outside = Interface(), Interface()
    wires = [
        Connection(inside[0], light["elevator"]),
        Connection(inside[1], heavy["elevator"]),
        Connection(light["theta", "q"], inside[0, 1]),
        Connection(heavy["theta", "q"], inside[2, 3]),
    ]
    box = Subsystem([inside, light, heavy], wires)
    wires = [Connection(outside[0, 1], box[0, 1]), Connection(box[:4], outside[:4])]
    pair = Subsystem([outside, box], wires)
    one, two = PitchHold(gains="c172p"), PitchHold(gains="737")
    wires = [Connection(pair[0, 1], one["theta", "q"]), Connection(pair[2, 3], two["theta", "q"])]
    wires += [Connection(one["elevator"], pair[int(crossed)])]
    wires += [Connection(two["elevator"], pair[int(not crossed)])]
    expected = [
        "one has the gains of c172p, but flies heavy, which is 737",
        "two has the gains of 737, but flies light, which is c172p",
    ]
    diagram = Simulation([pair, one, two], wires, dt=1 / 120, log=False)
    assert said(diagram) == (expected if crossed else [])


def test_load_diagram_tells_of_gains_of_another_aircraft():
    with pytest.warns(RuntimeWarning, match="gains of 737"):
        load_diagram("pitch_hold", {"hold.gains": "737"})
