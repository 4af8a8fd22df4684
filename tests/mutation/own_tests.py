"""Own tests of each module, quick ones first.

A key is the end of a module's path, or a folder with a slash; the longest that fits counts. A test
file is looked for by its name in all of ``tests/``, so that neither list minds a move. What is no
file is an option of pytest.
"""

OWN_TESTS = {
    "_core/_pathsim": ["test_pathsim_seam.py", "test_sampling.py", "test_instants.py"],
    "_core/sampling": ["test_sampling.py", "test_instants.py", "test_checkpoint.py"],
    "flight/fdm": [
        "test_promises.py",
        "test_limits.py",
        "test_checkpoint.py",
        "test_reset.py",
        "test_bad_input.py",
        "-k",
        "not ten_seconds and not process_alive",
    ],
    "flight/aircraft": ["test_aircraft.py", "test_promises.py"],
    "flight/_trim": ["test_trim.py"],
    "flight/condition": ["test_trim.py", "test_promises.py"],
    "sources": ["test_sources.py", "test_promises.py"],
    "air/atmosphere": ["test_atmosphere.py", "test_atmosphere_blocks.py"],
    "air/atmosphere_blocks": ["test_atmosphere_blocks.py", "test_airspeed.py", "test_promises.py"],
    "air/airspeed": ["test_airspeed.py"],
    "air/airspeed_blocks": ["test_airspeed.py", "test_promises.py"],
    "axes/": ["test_axes.py", "test_promises.py"],
    "control/": ["test_laws.py", "test_gains.py", "test_promises.py"],
    "control/pid": ["test_laws.py", "test_pid.py", "test_promises.py"],
    "control/controller": ["test_gains.py", "test_pid.py", "test_autopilot.py"],
    "pathview/": ["test_names.py", "test_export.py", "test_convert.py"],
    "pathview/check": ["test_unreadable.py", "test_convert.py"],
    "pathview/generate": ["test_convert.py"],
    "pathview/context": ["test_names.py", "test_export.py"],
    "pathview/reader": ["test_positions.py", "test_export.py"],
    "pathview/script": ["test_unreadable.py", "test_export.py"],
    "pathview/layout": ["test_layout.py", "test_positions.py", "test_committed.py"],
    "pathview/names": ["test_names.py", "test_export.py"],
    "pathview/pvm": ["test_positions.py", "test_export.py", "test_convert.py"],
    "pathview/trusted_models": ["test_trusted_place.py", "test_trust.py"],
    "pathview/server": ["test_view.py", "test_hosted_editor.py"],
    "pathview/_view": ["test_view.py", "test_hosted_editor.py"],
}
