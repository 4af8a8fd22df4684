"""Every hold is the equation in its manual page: outputs over random wires, without an aircraft.

The equations are written down a second time, here and in ``equations``.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from all_holds import HOLDS
from equations import (
    ATTITUDE,
    HEADING,
    NOTHING,
    PI,
    SPEED,
    G,
    N,
    T,
    aileron_for,
    assert_same,
    attitude,
    clip,
    laws,
    on_a_ramp,
    seen,
    wander,
)
from pathsim import Connection, Simulation
from pathsim.blocks import Constant
from scipy.signal import lfilter

from pathsim_jsbsim_blocks import (
    AirspeedHold,
    DiscretePID,
    HeadingHold,
    PitchHold,
    RollHold,
    YawDamper,
)

# of a lag of 2 s
POLE = math.exp(-T / 2.0)


@pytest.mark.parametrize("target", [None, 1.0])
@pytest.mark.parametrize(
    ("hold", "sign", "y", "rate", "actuator"),
    [(PitchHold, -1.0, "theta", "q", "elevator"), (RollHold, 1.0, "phi", "p", "aileron")],
)
def test_attitude_holds(wires, hold, sign, y, rate, actuator, target):
    limits = (-0.5, 0.4)
    block = hold(gains=ATTITUDE, authority=limits, T=T, **{f"{y}_ref": target})
    u, reference = on_a_ramp(
        attitude(sign, *limits),
        ATTITUDE["ramp"],
        target,
        wires[y],
        wires["off"],
        rate=wires[rate],
        port=wires[f"{y}_ref"],
        sat=wires["ail_sat" if actuator == "aileron" else "elev_sat"],
    )
    assert_same(laws(block, **wires), {actuator: u, f"{y}_cmd": reference}, limits)


def without_gusts(wires):
    """The complementary airspeed, from vectors in body axes."""
    alpha, beta, theta, phi = (np.radians(wires[x]) for x in ("alpha", "beta", "theta", "phi"))
    ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    path = np.array([ca * cb, sb, sa * cb])
    force = np.array([wires["nx"], NOTHING, -wires["nz"]])
    ct = np.cos(theta)
    weight = np.array([-np.sin(theta), np.sin(phi) * ct, np.cos(phi) * ct])
    # 1.68781 ft/s per kt cancels in vc / vt
    along = G * np.sum((force + weight) * path, axis=0) * wires["vc"] / wires["vt"]
    v, found = wires["vc"][0], np.empty(N)
    for k, vc in enumerate(wires["vc"]):
        found[k] = clip(v, vc - 8.0, vc + 4.0)
        v += T * (along[k] + (vc - v) / 10.0)
    return found


@pytest.mark.parametrize("target", [None, 91.0])
@pytest.mark.parametrize("connected", ["", "climb", "climb and motion"])
def test_airspeed_hold(wires, target, connected):
    limits = (-0.15, 0.1)
    block = AirspeedHold(gains=SPEED, authority=limits, T=T, vc_ref=target)
    pi = PI(
        **{name: value for name, value in SPEED.items() if name not in ("Kc", "ramp", "band")},
        low=limits[0],
        high=limits[1],
    )
    # errors of up to 16 kt
    names = "vc", "hdot", "vc_ref", "off", "thr_sat"
    wires = wires | {"vc": 90.0 + 3.0 * (wires["vc"] - 90.0)}
    ports, airspeed, climb = {name: wires[name] for name in names}, wires["vc"], wires["hdot"]
    rng = np.random.default_rng(6)
    if connected:
        ports["hdot_cmd"] = wander(rng, 4.0)
        # the first sample has the measured rate of climb, then a lag of 2 s begins there
        climb = lfilter([0.0, 1.0 - POLE], [1.0, -POLE], ports["hdot_cmd"], zi=[climb[0]])[0]
    if "motion" in connected:
        angles = {"alpha": 4.0, "beta": 0.0, "theta": 5.0, "phi": 0.0}
        ports |= {name: wander(rng, 2.0, mean) for name, mean in angles.items()}
        ports |= {"nx": wander(rng, 0.05), "nz": wander(rng, 0.1, 1.0), "vt": NOTHING + 165.0}
        airspeed = without_gusts(ports)
        differences = airspeed - wires["vc"]
        assert np.max(differences) == pytest.approx(4.0)
        assert np.min(differences) == pytest.approx(-8.0)
    u, reference = on_a_ramp(
        pi,
        SPEED["ramp"],
        target,
        airspeed,
        wires["off"],
        port=wires["vc_ref"],
        sat=wires["thr_sat"],
        feed=SPEED["Kc"] * climb,
        seen=seen,
    )
    ours = laws(block, **ports)
    assert ours["throttle"] == pytest.approx(u, abs=1e-9)
    assert ours["vc_cmd"] == pytest.approx(reference, abs=1e-9)
    assert limits[0] <= np.min(u) < np.max(u) <= limits[1]


@pytest.mark.parametrize(
    ("target", "straight", "vt"),
    [(None, 0.0, 0.0), (355.0, 0.0, 0.0), (None, 1.5, 0.0), (None, 1.5, 160.0)],
)
def test_heading_hold(wires, target, straight, vt):
    bank, limits = 12.0, (-0.9, 0.9)
    wires = wires | {"vt": NOTHING + vt}
    block = HeadingHold(
        gains={"heading": {**HEADING, "bank": straight}, "roll": ATTITUDE},
        psi_ref=target,
        bank_max=bank,
        authority=0.9,
        T=T,
    )
    start = {"k": None}
    banks = []

    def heading(k):
        if start["k"] is None or wires["off"][k - 1]:
            start.update(k=k, found=wires["psi"][k], pi=PI(**HEADING, low=-bank, high=bank))
            start.update(bank=straight, psi=wires["psi"][k], phi=straight)
        elif vt:
            # the part of the bank that turns nothing
            behind = math.remainder(wires["psi"][k] - start["psi"], 360.0) * math.exp(-T)
            start["psi"] = wires["psi"][k] - behind
            start["phi"] += (1 - math.exp(-T)) * (wires["phi"][k] - start["phi"])
            turned = math.degrees(math.atan(vt * math.radians(behind) / 32.174))
            if abs(turned) < 0.5:
                start["bank"] += (1 - math.exp(-T / 10.0)) * (start["phi"] - turned - start["bank"])
        error = math.remainder(
            (start["found"] if target is None else target) + wires["psi_ref"][k] - wires["psi"][k],
            360.0,
        )
        pi = start["pi"]
        if abs(HEADING["Kp"] * error) >= bank:
            pi.integral = 0.0
        banks.append(pi(error, 0.0, feed=start["bank"]))
        return banks[-1]

    u, reference = aileron_for(heading, wires, limits)
    assert_same(laws(block, **wires), {"aileron": u, "phi_cmd": reference}, limits)
    assert 20 < np.count_nonzero(np.abs(banks) == bank) < len(banks) - 20


def rudder(wires, beta, limit, K=0.0, tau=2.0, Kp=0.0, Ki=0.0, Kroll=0.0, Kbank=0.0):
    """The rudder against what the yaw rate is beside its mean, and against the sideslip."""
    fade = math.exp(-T / tau)
    u, last, engaged = np.empty(N), 0.0, False
    for k in range(N):
        r = wires["r"][k]
        bank = math.degrees(math.sin(math.radians(wires["phi"][k])))
        turn = Kroll * wires["p"][k] + Kbank * bank
        if wires["off"][k]:
            last *= fade
        else:
            if not engaged:  # go on from the output: the integral, or what fades, cancels the rest
                mean, held = r - last / K, Kp * beta[k] - turn
            v = K * (r - mean) - Kp * beta[k] + held + turn
            last = clip(v, -limit, limit)
            mean = fade * mean + (1 - fade) * r
            if not Ki:
                held *= fade
            elif not (last != v and np.sign(v) == -np.sign(beta[k])):  # no further into the limit
                held -= Ki * T * beta[k]
        u[k], engaged = last, not wires["off"][k]
    return u


@pytest.mark.parametrize(
    ("gains", "limit"),
    [
        ({}, 0.05),
        ({"Kp": 0.03, "Ki": 0.06}, 0.05),
        ({"Kp": 0.03, "Kroll": -0.01, "Kbank": -0.004}, 0.09),
    ],
    ids=["yaw rate", "sideslip", "turns fed forward"],
)
def test_yaw_damper(wires, gains, limit):
    gains = {"K": 0.02, "tau": 1.5, **gains}
    block = YawDamper(gains=gains, authority=limit, T=T)
    beta = wander(np.random.default_rng(5), 0.8) if "Kp" in gains else NOTHING
    u = rudder(wires, beta, limit, **gains)
    assert_same(laws(block, **wires, beta=beta), {"rudder": u}, (-limit, limit))


def test_a_sideslip_that_measures_0_is_connected():
    # the integral that cancels the bank at engagement keeps its value, and fades without a sensor
    ports = {"phi": NOTHING + 10.0, "p": NOTHING, "r": NOTHING}
    gains = {"K": 0.02, "tau": 1.5, "Ki": 0.05, "Kbank": -0.004}
    held, faded = (
        laws(YawDamper(gains=gains, T=T), **ports, **beta)["rudder"]
        for beta in ({"beta": NOTHING}, {})
    )
    assert not held.any()
    turn = -0.004 * math.degrees(math.sin(math.radians(10.0)))
    assert faded[-1] == pytest.approx(turn * -math.expm1(-T * (N - 1) / 1.5), rel=1e-9)


def test_without_gain_or_sideslip_the_rudder_stays(wires):
    on = {name: x for name, x in wires.items() if name != "off"}
    assert not laws(YawDamper(gains={"K": 0.0}, T=T), **wires)["rudder"].any()
    numbers = {"K": 0.02, "tau": 1.5, "Kroll": -0.01, "Kbank": -0.004}
    plain, integral = (
        laws(YawDamper(gains={**numbers, "Ki": Ki}, T=T), **on) for Ki in (0.0, 0.05)
    )
    assert np.array_equal(plain["rudder"], integral["rudder"])


@pytest.mark.parametrize("hold", [*HOLDS.values(), DiscretePID])
def test_a_wire_beyond_the_last_input_changes_nothing(hold):
    # PathSim makes room for any port number that is wired
    block = hold()
    u = [0.5 + i for i in range(len(block.input_port_labels))]
    expected, state = block.law(u, block.initial_state()), block.initial_state()
    assert block.law([*u, 9.0, 9.0], state) == expected
    _, state = expected
    assert block.law([*u, 9.0], state) == block.law(u, state)


@pytest.mark.filterwarnings("ignore:.*(unconnected inputs|not connected)")
@pytest.mark.parametrize("hold", HOLDS.values())
def test_nan_at_any_port_is_nan_at_every_output(hold):
    # a limit that is NaN limits nothing: with NaN at alpha the aircraft stalled
    for port in hold.input_port_labels:
        block, sick = hold(), Constant(math.nan)
        wire = Connection(sick, block[port])
        Simulation([sick, block], [wire], dt=block.T, log=False).run(3 * block.T)
        assert np.isnan(block.outputs.to_array()).all(), port
