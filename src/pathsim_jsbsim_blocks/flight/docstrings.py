"""What the manual pages of the aircraft blocks share.

Parameters that are those of a trim condition or an airframe have their texts from there.
"""

from .._core.docstrings import entries, filler
from .airframe import Airframe
from .trimming.condition import TrimCondition


def _same(documented: type, names: str) -> str:
    return entries(documented, **{name: name for name in names.split()})


fill = filler(
    start="aircraft : str\n    name of the JSBSim model\n"
    + _same(TrimCondition, "altitude speed mach gamma heading"),
    turn=_same(TrimCondition, "bank mode"),
    configuration=_same(TrimCondition, "gear flaps"),
    trim=entries(
        TrimCondition,
        trim_altitude="altitude",
        trim_gamma="gamma",
        trim_heading="heading",
        trim_mode="mode",
    ),
    written="""
    setup : dict, optional
        properties written before initialisation and trim (fuel, payload)
    properties : dict, optional
        properties written after the trim (turbulence)
    """,
    surroundings=_same(Airframe, "create")
    + _same(Airframe, "allow_network allow_files integrators planet gravity flightgear"),
    motion="""
    theta, phi, psi
        pitch, roll and heading angle, deg; `Aircraft` shows a heading in [0, 360)
    p, q, r
        body rates, deg/s
    alpha, beta, gamma
        angle of attack, sideslip angle, flight path angle, deg
    h
        altitude above mean sea level, ft
    hdot
        rate of climb, ft/s
    vc
        calibrated airspeed, kt
    vt
        true airspeed, ft/s
    mach
        Mach number
    nx, nz
        load factors, g; nz is +1 in level flight
    lat, lon
        geodetic latitude and longitude, deg
    """,
    raises="""
    Raises
    ------
    AircraftError, PropertyError, ParameterError, TrimError
        when the block is built: unknown names and values that cannot be, or no trim
    FlightError
        in flight, when an input or the state is not finite, the aircraft has crashed or is under
        the ground, or something else runs or holds it; of `Aircraft` also at a contact with the
        ground beyond ``sink_max`` or ``scrape_max``
    """,
)
