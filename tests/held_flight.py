"""Flights that holds keep: altitude by the elevator, airspeed by the throttle, bank by the aileron."""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope, Source

from pathsim_jsbsim_blocks import Aircraft, AirspeedHold, AltitudeHold, FlightError, RollHold, fly


def held(condition, plane, duration, vc_ref, phi_ref=lambda t: 0.0):
    """Time in s, and vc in kt, h in ft, phi in deg and thr_sat of a flight; None where it ends.

    ``vc_ref`` is absolute. The holds have the gains of the aircraft of a study's ``plane``.
    """
    name = plane.airframe.aircraft
    aircraft = Aircraft(name, condition=condition, create=plane.create)
    level, throttle = AltitudeHold(gains=name), AirspeedHold(gains=name, reference="absolute")
    wings, scope = RollHold(gains=name, phi_ref=0.0), Scope()
    knots, banks = Source(vc_ref), Source(phi_ref)
    # no alpha: protection would not let it slow down so far
    read = {
        level: ("h", "hdot", "theta", "q", "elev_sat", "vc"),
        throttle: ("vc", "hdot", "thr_sat"),
        wings: ("phi", "p", "ail_sat"),
    }
    wires = [Connection(aircraft[n], hold[n]) for hold, names in read.items() for n in names]
    wires += [
        Connection(knots, throttle["vc_ref"]),
        Connection(banks, wings["phi_ref"]),
        Connection(level["elevator"], aircraft["elevator"]),
        Connection(throttle["throttle"], aircraft["throttle"]),
        Connection(wings["aileron"], aircraft["aileron"]),
        *(Connection(aircraft[n], scope[i]) for i, n in enumerate(("vc", "h", "phi", "thr_sat"))),
    ]
    blocks = [aircraft, level, throttle, wings, knots, banks, scope]
    try:
        fly(Simulation(blocks, wires, dt=aircraft.T, log=False), duration, progress=False)
    except FlightError:
        return None
    return scope.read()
