"""Random signals for the ports of holds."""

import numpy as np
import pytest
from equations import N, wander

OFF = np.zeros(N)
OFF[300:340] = OFF[600:610] = 1.0


@pytest.fixture(scope="module", params=[0.0, 1.0], ids=["engaged first", "off first"])
def wires(request):
    """Random signals for every port, large enough for ramps and limits to act now and then."""
    off = OFF.copy()
    off[:5] = request.param
    rng = np.random.default_rng(22)
    return {
        "theta": wander(rng, 1.2, 2.0),
        "phi": wander(rng, 2.0),
        "psi": wander(rng, 8.0, 355.0) % 360.0,
        "vc": wander(rng, 2.0, 90.0),
        "h": wander(rng, 20.0, 5000.0),
        "hdot": wander(rng, 3.0),
        **{rate: wander(rng, 2.0) for rate in "pqr"},
        "theta_ref": wander(rng, 1.2),
        "phi_ref": wander(rng, 2.0),
        "psi_ref": wander(rng, 8.0),
        "h_ref": wander(rng, 15.0),
        "vc_ref": wander(rng, 2.0),
        "off": off,
        "elev_sat": 0.02 * rng.normal(size=N),
        "ail_sat": 0.02 * rng.normal(size=N),
        "thr_sat": 0.02 * rng.normal(size=N),
    }
