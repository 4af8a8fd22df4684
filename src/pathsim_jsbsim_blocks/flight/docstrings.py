"""What the manual pages of the aircraft blocks share."""

from .._core.docstrings import filler

fill = filler(
    start="""
    aircraft : str
        name of the JSBSim model
    altitude : float
        ft above mean sea level
    speed : float
        KCAS; not used if ``mach`` is given
    mach : float, optional
        Mach number instead of ``speed``
    gamma : float
        flight path angle in deg
    heading : float
        true heading in deg
    """,
    configuration="""
    gear : float, optional
        0 (up) to 1 (down); default is the model's own setting
    flaps : float, optional
        0 (up) to 1 (fully down); default is the model's own setting
    """,
    written="""
    setup : dict, optional
        properties written before initialisation and trim (fuel, payload)
    properties : dict, optional
        properties written after the trim (turbulence)
    """,
    surroundings="""
    create : dict, optional
        properties that the model expects from its environment (FlightGear), with their values
    record_inputs : bool
        keep the inputs flown (8 bytes per input and sample), which checkpoints need
    allow_network : bool
        let the model open the sockets that its XML asks for, and send and listen there
    allow_files : bool
        let the model write the files that its XML asks for
    integrators : str or dict
        "default" (JSBSim's own: Euler for rotation), "precise" (a third of the error in flight at
        the same T; less stable on the ground below 120 Hz), or methods by state:
        ``{"rate_rotational": "adams-bashforth 3"}``. States: ``rate_rotational``,
        ``rate_translational``, ``position_rotational``, ``position_translational``. Methods:
        "none" (the state stays), "euler", "trapezoidal", "adams-bashforth 2" to
        "adams-bashforth 5"; for ``position_rotational`` also "buss 1", "buss 2",
        "local linearization"
    planet : str or dict, optional
        "WGS-84", "round" (a sphere of the same area, rotating), "round, fixed" (not rotating), or
        what differs from WGS-84: ``semimajor_axis``, ``semiminor_axis`` (ft), ``rotation_rate``
        (rad/s), ``GM`` (ft3/s2), ``J2``; default is the model's own, or WGS-84
    gravity : str, optional
        "J2" (of the ellipsoid) or "point mass"; default is JSBSim's, J2
    flightgear : str, optional
        ``"HOST:PORT"`` where FlightGear listens, such as "127.0.0.1:5550": JSBSim sends its native
        FDM packets there by UDP, 60 in a second of the flight. Nothing waits for them
    """,
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
