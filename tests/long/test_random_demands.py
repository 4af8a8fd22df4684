"""Random demands on the autopilot, with every table of the fleet.

Weight, centre of gravity, flaps, altitude and airspeed are drawn anew for each case; half of them
fly in moderate turbulence, and one engine of a fifth of those with several fails. References lead
beyond every limit, and modes change.
"""

import contextlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from how_many import bounded

from pathsim_jsbsim_blocks import Aircraft
from pathsim_jsbsim_blocks.control.airspeeds import fastest_airspeed
from pathsim_jsbsim_blocks.control.gain_tables import read_gains
from pathsim_jsbsim_blocks.errors import BlocksError, FlightError
from pathsim_jsbsim_blocks.flight import aircraft_names, empty_weight_cg

pytestmark = pytest.mark.long

# too fast before throttle was taken above the highest airspeed
TOO_FAST = (169, 234, 262, 385, 394, 534, 561, 672, 840)
T, SECONDS, CHANGES = 1 / 60, 100.0, 6
# of the tanks; of the chord, the empty weight's; ft above the table's lowest point; of the airspeed
# of its nominal point
FUEL, CG, HEIGHT, SPEED = (0.1, 1.0), (-0.03, 0.03), (0.0, 4000.0), (0.9, 1.15)
# deg; ft beyond the present altitude; deg of bank; of the airspeed; ft/s; of full travel
PITCH, CLIMB, BANK = (-25.0, 30.0), (-8000.0, 8000.0), (-75.0, 75.0)
VC, RATE, LEVER = (0.3, 2.0), (-80.0, 80.0), (-1.0, 1.0)
# deg beyond alpha_max, in turbulence of the mean over 2 s; kt beyond the highest airspeed, s
ALPHA, MEAN, FAST, LONG = 1.0, 2.0, 5.0, 10.0


@pytest.fixture
def docs(monkeypatch):
    """The modules that fly the evidence of the gain tables."""
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "docs")
    import failed_engines
    import gain_tables

    return gain_tables, failed_engines


def started(gain_tables, name, rng, seed):
    """An aircraft in a random condition, or None if it trims in none of five; and turbulence."""
    flight, schedule = gain_tables.flight_of(name), read_gains(gain_tables.table_of(name))
    nominal = schedule.points[schedule.nominal]
    turbulent = bool(rng.random() < 0.5)
    rough = gain_tables.turbulence(4.0, 50.0, seed) if turbulent else {}
    plane = Aircraft(name, condition=flight.condition, create=flight.create)
    tanks, chord = gain_tables.fuel(plane, 1.0), 12.0 * plane.fdm["metrics/cbarw-ft"]
    cg = empty_weight_cg(name)[0] + np.random.default_rng([seed, 1]).uniform(*CG) * chord
    options = {"create": flight.create, "properties": rough, "output_properties": ["h_agl"]}
    for _ in range(5):
        share = rng.uniform(*FUEL)
        condition = replace(
            flight.condition,
            altitude=schedule.points[0].altitude + 1500.0 + rng.uniform(*HEIGHT),
            speed=nominal.speed * rng.uniform(*SPEED),
            empty_cg_x=cg,
            fuel={tank: share * full for tank, full in tanks.items()},
            flaps=0.3 if rng.random() < 0.2 else None,
        )
        with contextlib.suppress(BlocksError):  # no trim
            return Aircraft(name, condition=condition, T=T, substeps=2, **options), turbulent
    return None, turbulent


def demanded(rng, seen):
    """References and modes, whether or not the aircraft can follow them."""
    return {
        "pitch_mode": float(rng.random() < 0.3),
        "roll_mode": float(rng.random() < 0.5),
        "v_mode": float(rng.integers(3)),
        "theta_ref": rng.uniform(*PITCH),
        "phi_ref": rng.uniform(*BANK),
        "psi_ref": rng.uniform(0.0, 360.0),
        "h_ref": seen["h"] + rng.uniform(*CLIMB),
        "vc_ref": seen["vc"] * rng.uniform(*VC),
        "hdot_ref": rng.uniform(*RATE),
        "thr_ref": rng.uniform(*LEVER),
    }


def flown(gain_tables, failed_engines, case):
    """Limits that are not kept in a case, "" for none."""
    rng = np.random.default_rng(case)
    names = [name for name in aircraft_names() if gain_tables.table_of(name).exists()]
    name = names[case % len(names)]
    plane, turbulent = started(gain_tables, name, rng, case)
    if plane is None:
        return ""
    table = read_gains(gain_tables.table_of(name))
    fails = rng.uniform(0.0, SECONDS) if plane.airframe.engines > 1 and rng.random() < 0.2 else 1e9
    references, rows = {}, []

    def asked(k, seen):
        nonlocal references
        if k % round(SECONDS / CHANGES / T) == 0:
            references = demanded(rng, seen)
        if k * T > fails:
            failed_engines.stop_engine(plane)
        return references

    try:
        flight = gain_tables.flown_by(failed_engines.pilot(name), plane, round(SECONDS / T), asked)
        for k, (_, seen) in enumerate(flight):
            if k % 6 == 0:
                limits = table.at(seen["h"], seen["vc"]).envelope
            fastest = fastest_airspeed(limits.vmo, limits.mmo, seen["h"])
            rows.append((seen["alpha"] - limits.alpha_max, seen["vc"] - fastest - FAST))
    except FlightError as error:
        return f"{name} ends: {error}"
    alpha, fast = np.array(rows).T
    if turbulent:
        window = round(MEAN / T)
        alpha = np.convolve(alpha, np.full(window, 1.0 / window), "valid")
    long = np.convolve(fast > 0.0, np.ones(round(LONG / T)), "valid")
    missed = f"{name}: alpha {alpha.max():+.1f} deg " if alpha.max() > ALPHA else ""
    return missed + (f"{name}: overspeed" if long.max() > LONG / T - 0.5 else "")


# airspeeds down to 0.3 of the present one
@pytest.mark.filterwarnings("ignore:Autopilot.* far below")
def test_random_demands(docs):
    cases = dict.fromkeys([*range(bounded(20, 1000)), *TOO_FAST])
    missed = {case: flown(*docs, case) for case in cases}
    # seven of the first thousand are not kept
    assert sum(map(bool, missed.values())) <= 0.02 * len(missed), missed
