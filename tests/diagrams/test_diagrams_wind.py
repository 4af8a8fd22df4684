"""The diagrams of wind in flight, against plain JSBSim loops in the wind that they recorded."""

import math

import numpy as np
import pytest
from plain_jsbsim import fly
from test_diagrams_flight import flown

from pathsim_jsbsim_blocks import DrydenTurbulence, TrimCondition
from pathsim_jsbsim_blocks.flight import Airframe, trim

GUSTS = [f"atmosphere/gust-{axis}-fps" for axis in ("north", "east", "down")]


def test_gust_response():
    module = flown("gust_response")
    time, down = module.gusts.read()
    _, nz = module.load_factors.read()
    # 14 CFR 25.341: 56 to 44 ft/s EAS at 15,000 ft; density ratio 0.7385 at 10,000 ft
    for gradient, w in zip((30.0, 90.0, 150.0, 200.0, 350.0), down, strict=True):
        peak = (56.0 - 12.0 * 10 / 15) * (gradient / 350.0) ** (1 / 6) / math.sqrt(0.73848)
        s = np.clip(module.airspeed * (time - 1.0), 0.0, 2 * gradient)
        assert -w == pytest.approx(peak / 2 * (1 - np.cos(np.pi * s / gradient)), abs=1e-2)
    assert module.plane_30.trim.tas == pytest.approx(module.airspeed, abs=0.1)
    airframe = Airframe("737")
    trim(airframe, TrimCondition(altitude=10000.0, speed=280.0, gear=0.0))
    fdm = airframe.fdm
    loop = fly(fdm, GUSTS[2:], down[4][:-1, None], ["accelerations/Nz"])[:, 0]
    # the trim starts with the gear up here and is retracted there: the same to rounding
    assert nz[4] == pytest.approx(loop, abs=1e-6)
    # what the docstring says
    assert nz.max(axis=1) == pytest.approx([1.82, 1.96, 1.99, 1.99, 1.94], abs=0.006)
    assert nz.min() == pytest.approx(0.19, abs=0.005)
    assert 1 < nz.max(axis=1).argmax() < 4


def test_turbulence_rides_starts_as_a_plain_loop():
    module = flown("turbulence_rides", 4.0)
    _, nz = module.load_factor.read()
    twin = DrydenTurbulence(severity="moderate", span=35.8, seed=4)
    airframe = Airframe("c172p")
    trim(airframe, TrimCondition(altitude=5000.0, speed=90.0))
    fdm = airframe.fdm
    state, loop = twin.initial_state(), [fdm["accelerations/Nz"]]
    for _ in range(nz.shape[1] - 1):
        here = [fdm[p] for p in ("position/h-sl-ft", "velocities/vt-fps", "attitude/psi-deg")]
        wind, state = twin.law(here, state)
        loop.append(fly(fdm, GUSTS, [wind[:3]], ["accelerations/Nz"])[1, 0])
    assert nz[0] == pytest.approx(loop, abs=1e-9)


@pytest.mark.long
def test_turbulence_rides():
    module = flown("turbulence_rides")
    time, h = module.altitude.read()
    _, nz = module.load_factor.read()
    assert (h[0].min(), h[0].max()) == pytest.approx((4730.0, 5783.0), abs=1.0)
    assert np.abs(h[1] - 5000.0).max() < 48.0
    settled = nz[:, time > 5.0]
    assert settled.std(axis=1) == pytest.approx([0.196, 0.181], abs=0.001)
    # the altitude is paid for from 0.1 to 0.5 Hz, the short period is damped
    frequency, (held, flown_) = module.spectra()
    low, middle, high = (
        (frequency >= a) & (frequency <= b) for a, b in ((0.1, 0.5), (0.75, 1.25), (2.0, 10.0))
    )
    assert flown_[low].mean() > 3 * held[low].mean()
    assert flown_[middle].mean() < held[middle].mean() / 2
    assert flown_[high].sum() == pytest.approx(held[high].sum(), rel=0.15)


@pytest.mark.long
def test_microburst_approach():
    module = flown("microburst_approach")
    time, (h, vc, throttle) = module.flight.read()
    _, (tailwind, downdraft, _) = module.wind.read()
    _, (h_still,) = module.still.read()
    for values, extreme, at, value in (
        (tailwind, np.argmin, 36.4, -8.8),
        (downdraft, np.argmax, 45.6, 17.2),
        (tailwind, np.argmax, 63.8, 26.5),
        (module.f_factor(), np.argmax, 49.6, 0.128),
    ):
        k = extreme(values)
        assert time[k] == pytest.approx(at, abs=0.5)
        assert values[k] == pytest.approx(value, rel=0.01)
    assert (vc.min(), vc.max()) == pytest.approx((141.8, 152.9), abs=0.1)
    assert throttle.max() == pytest.approx(0.11, abs=0.006)
    assert h_still[-1] - h[-1] == pytest.approx(469.0, abs=0.6)
    assert h.min() == h[-1] == pytest.approx(80.0, abs=1.0)
