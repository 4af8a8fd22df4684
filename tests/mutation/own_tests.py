"""Own tests of each module, quick ones first.

A key is the end of a module's path, or a folder with a slash; the longest that fits counts. A test
file is looked for by its name in all of ``tests/``, so that neither list minds a move.
"""

OWN_TESTS = {
    "flight/aircraft": ["test_aircraft.py", "test_promises.py"],
    "aircraft": ["test_aircraft.py", "test_promises.py"],
    "sources": ["test_sources.py", "test_promises.py"],
    "atmosphere": ["test_atmosphere.py", "test_atmosphere_blocks.py"],
    "atmosphere_blocks": ["test_atmosphere_blocks.py", "test_promises.py"],
    "airspeed": ["test_airspeed.py"],
    "airspeed_blocks": ["test_airspeed.py", "test_promises.py"],
    "calibrated_airspeed_blocks": ["test_airspeed.py", "test_promises.py"],
    "axes/": ["test_axes.py", "test_promises.py"],
    "axes/aircraft": ["test_axes.py"],
    "control/": ["test_laws.py", "test_gains.py", "test_promises.py"],
    "control/pid": ["test_laws.py", "test_pid.py", "test_promises.py"],
    "control/autopilot": ["test_laws.py", "test_gains.py", "test_promises.py",
                          "test_autopilot.py"],
}
