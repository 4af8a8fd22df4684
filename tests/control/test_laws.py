"""Every hold is the equation in its manual page: outputs over random wires, without an aircraft.

The equations are written down a second time, here and in ``equations``.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from all_holds import HOLDS
from equations import (
    ALTITUDE,
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
    elevator_for,
    laws,
    on_a_ramp,
    seen,
    wander,
)
from scipy.signal import lfilter

from pathsim_jsbsim_blocks import (
    AirspeedHold,
    AltitudeHold,
    Autopilot,
    DiscretePID,
    HeadingHold,
    PitchHold,
    RollHold,
    YawDamper,
)
from pathsim_jsbsim_blocks.guidance.protection import share_of_climb

GAINS = {
    "pitch": ATTITUDE,
    "roll": {**ATTITUDE, "Kr": 0.01},
    "heading": HEADING,
    "altitude": ALTITUDE,
    "speed": SPEED,
    "yaw": {"K": 0.02},
}

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


@pytest.mark.parametrize(
    ("target", "hdot_max", "theta_max", "of_table"),
    [(None, None, None, 6.0), (5010.0, 12.0, 6.0, 20.0)],
)
def test_altitude_hold(wires, target, hdot_max, theta_max, of_table):
    limits, theta = (-0.3, 0.3), (-4.0, 6.0)
    block = AltitudeHold(
        gains={"altitude": {**ALTITUDE, "theta_max": of_table}, "pitch": ATTITUDE},
        h_ref=target,
        hdot_max=hdot_max,
        theta_min=theta[0],
        theta_max=theta_max,
        authority=0.3,
        T=T,
    )
    climb = ALTITUDE["hdot_max"] if hdot_max is None else hdot_max
    now, demanded = {}, np.zeros(N)

    def altitude(k):
        engaging = not now or wires["off"][k - 1]
        if engaging:
            now.update(found=wires["h"][k], pi=PI(ALTITUDE["Kp"], ALTITUDE["Ki"], *theta))
            now["pi"].u = wires["theta"][k]
        error = (now["found"] if target is None else target) + wires["h_ref"][k] - wires["h"][k]
        demanded[k] = clip(ALTITUDE["Kh"] * error, -climb, climb)
        return now["pi"](demanded[k], wires["hdot"][k], engaging=engaging)

    u, reference = elevator_for(altitude, wires, limits)
    assert_same(
        laws(block, **wires), {"elevator": u, "theta_cmd": reference, "hdot_cmd": demanded}, limits
    )
    assert set(np.abs(demanded)) >= {0.0, climb}


def capturing(Kh, hdot_max, target, h, hdot):
    """Captures an altitude: the rate of climb, which is asked for until then."""
    far, near = 0.1 * G, 0.1 * G / Kh**2

    def rate(error):
        away = abs(error)
        slow = Kh * away if away < near else math.sqrt(2.0 * far * away - far * near)
        return math.copysign(slow, error)

    state = {"captured": False}

    def demanded(k, asked, engaging):
        if engaging:
            state.update(captured=False)
        error = target - h[k]
        state["captured"] |= error * asked > 0.0 and abs(rate(error)) <= abs(asked)
        if not state["captured"]:
            return asked
        level = clip(Kh * error, -hdot_max, hdot_max)
        still = clip(rate(error), -abs(hdot[k]), abs(hdot[k]))
        return max(level, still, key=abs)

    return demanded, state


@pytest.mark.parametrize("by", ["rate", "speed"])
def test_climbs_of_the_autopilot(wires, by):
    limits, theta, target = (-0.7, 0.7), (-2.0, 5.0), 5040.0
    wires = wires | {"h": 4920.0 + 0.2 * np.arange(N), "vc": wires["vc"] - 1.0}
    block = Autopilot(
        GAINS,
        h_ref=target - wires["h_ref"][0],
        theta_min=theta[0],
        theta_max=theta[1],
        elevator_authority=0.7,
        T=T,
    )
    wires["h_ref"] = NOTHING + wires["h_ref"][0]
    wires["hdot_ref"] = np.abs(wander(np.random.default_rng(3), 3.0, 2.0))
    fly, state = capturing(ALTITUDE["Kh"], ALTITUDE["hdot_max"], target, wires["h"], wires["hdot"])
    now, demanded, captured = {}, np.zeros(N), np.zeros(N)
    knot = 6076.1154856 / 3600 * (1.0 - 6.8756e-6 * wires["h"]) ** -2.128

    def by_speed(k, engaging):
        """V/g (2 zeta omega e + omega^2 int e dt), with the reference on its ramp."""
        gain = 0.15 * wires["vc"][k] * knot[k] ** 2 / G
        angles = np.radians(theta) * wires["vc"][k] * knot[k]
        if engaging:
            now.update(found=wires["vc"][k], ref=wires["vc"][k])
            now["speed"] = PI(1.8 * gain, 0.15 * gain, -angles[1], -angles[0])
            now["speed"].u = -wires["hdot"][k]
        else:
            step = SPEED["ramp"] * T
            goal = now["found"] + wires["vc_ref"][k]
            now["ref"] += clip(goal - now["ref"], -step, step)
        pi = now["speed"]
        pi.Kp, pi.Ki, pi.low, pi.high = 1.8 * gain, 0.15 * gain, -angles[1], -angles[0]
        return -pi(now["ref"], wires["vc"][k], engaging=engaging)

    def climb(k):
        engaging = not now or wires["off"][k - 1]
        if engaging:
            now.update(rate=wires["hdot"][k], pi=PI(ALTITUDE["Kp"], ALTITUDE["Ki"], *theta))
            now["pi"].u = wires["theta"][k]
        if by == "rate":
            asked = now["rate"] + wires["hdot_ref"][k]
        elif state["captured"] and not engaging:
            asked = 0.0
        else:
            asked = by_speed(k, engaging)
        demanded[k] = fly(k, asked, engaging)
        captured[k] = state["captured"]
        return now["pi"](demanded[k], wires["hdot"][k], engaging=engaging)

    u, reference = elevator_for(climb, wires, limits)
    expected = {"elevator": u, "theta_cmd": reference, "hdot_cmd": demanded, "captured": captured}
    wires |= {"pitch_off": wires["off"], "speed_off": wires["off"]}
    wires["v_mode"] = NOTHING + {"rate": 1.0, "speed": 2.0}[by]
    assert_same(laws(block, **wires), expected, limits)
    assert 50 < np.count_nonzero(captured) < N - 200


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


def test_without_gain_or_sideslip_the_rudder_stays(wires):
    on = {name: x for name, x in wires.items() if name != "off"}
    assert not laws(YawDamper(gains={"K": 0.0}, T=T), **wires)["rudder"].any()
    numbers = {"K": 0.02, "tau": 1.5, "Kroll": -0.01, "Kbank": -0.004}
    plain, integral = (
        laws(YawDamper(gains={**numbers, "Ki": Ki}, T=T), **on) for Ki in (0.0, 0.05)
    )
    assert np.array_equal(plain["rudder"], integral["rudder"])


@pytest.mark.parametrize("inner", ["altitude", "pitch"])
def test_the_autopilot_is_the_holds(wires, inner):
    offs = {
        name: np.roll(wires["off"], shift)
        for name, shift in (
            ("pitch_off", 0),
            ("roll_off", 60),
            ("speed_off", 130),
            ("yaw_off", 190),
        )
    }
    numbers = {
        "elevator_authority": 0.4,
        "aileron_authority": (-0.3, 0.35),
        "rudder_authority": 0.05,
        "throttle_authority": (-0.15, 0.1),
    }
    steady = wires | {"vc": 95.0 + 0.02 * wires["vc"], "vc_ref": NOTHING}  # no climb given up
    pitching = inner == "pitch"
    modes = {"pitch_mode": NOTHING + pitching, "roll_mode": NOTHING + pitching}
    steady["vt"] = NOTHING + 170.0
    one = laws(
        Autopilot(
            GAINS,
            theta_ref=1.0,
            h_ref=5020.0,
            phi_ref=2.0,
            psi_ref=10.0,
            vc_ref=96.0,
            bank_max=13.0,
            hdot_max=9.0,
            theta_min=-3.0,
            theta_max=5.0,
            T=T,
            **numbers,
        ),
        **steady,
        **offs,
        **modes,
    )
    pitch = {"authority": numbers["elevator_authority"], "T": T}
    roll = {"authority": numbers["aileron_authority"], "T": T}
    holds = [
        (
            "pitch_off",
            PitchHold(GAINS["pitch"], theta_ref=1.0, **pitch)
            if pitching
            else AltitudeHold(
                {name: GAINS[name] for name in ("altitude", "pitch")},
                h_ref=5020.0,
                hdot_max=9.0,
                theta_min=-3.0,
                theta_max=5.0,
                **pitch,
            ),
        ),
        (
            "roll_off",
            RollHold(GAINS["roll"], phi_ref=2.0, **roll)
            if pitching
            else HeadingHold(
                {name: GAINS[name] for name in ("heading", "roll")},
                psi_ref=10.0,
                bank_max=13.0,
                **roll,
            ),
        ),
        (
            "speed_off",
            AirspeedHold(GAINS["speed"], vc_ref=96.0, T=T, authority=numbers["throttle_authority"]),
        ),
        ("yaw_off", YawDamper(GAINS["yaw"], authority=numbers["rudder_authority"], T=T)),
    ]
    several = {"hdot_cmd": NOTHING, "captured": NOTHING}
    for off, hold in holds:
        several |= laws(hold, **(steady | {"hdot_cmd": several["hdot_cmd"], "off": offs[off]}))
    assert set(one) == set(several)
    for name, signal in several.items():
        assert np.array_equal(one[name], signal), name


@pytest.mark.parametrize("hold", [AltitudeHold, Autopilot])
def test_in_steady_flight_nothing_moves_from_the_first_sample_on(hold):
    # with the protection, which must begin with nothing cut off
    steady = {"theta": 2.0, "h": 5000.0, "vc": 90.0, "alpha": 2.0, "psi": 30.0}
    y = laws(hold("c172p", T=T), **{name: NOTHING + value for name, value in steady.items()})
    assert not y["elevator"].any()
    assert not y["hdot_cmd"].any()
    assert set(y["theta_cmd"]) == {2.0}


def test_a_mode_goes_on_from_the_reference_of_the_other(wires):
    mode = (np.arange(N) // 100 % 2).astype(float)
    quiet = wires | {"off": NOTHING, "vc": NOTHING + 90.0, "vc_ref": NOTHING, "psi_ref": NOTHING}
    quiet["psi"] = np.where(np.arange(N) < 150, 30.0, 60.0)
    y = laws(Autopilot(GAINS, T=T), **quiet, pitch_mode=mode, roll_mode=mode)
    for name in ("theta_cmd", "phi_cmd"):
        assert np.max(np.abs(np.diff(y[name]))) == pytest.approx(ATTITUDE["ramp"] * T)
    for k in range(200, N, 200):  # the altitude's loop begins with the pitch reference as it is
        assert y["theta_cmd"][k] == pytest.approx(y["theta_cmd"][k - 1], abs=1e-12)
    assert not y["hdot_cmd"][mode != 0].any()
    # the heading found when its mode came back
    assert y["phi_cmd"][299] == pytest.approx(0.0, abs=1e-9)
    # the altitude found when its mode came back, and the port's way since
    back = 200
    error = (quiet["h"][back] + quiet["h_ref"] - quiet["h"])[back:300]
    assert y["hdot_cmd"][back:300] == pytest.approx(
        np.clip(ALTITUDE["Kh"] * error, -8.0, 8.0), abs=1e-9
    )


@pytest.mark.parametrize("hold", [*HOLDS.values(), DiscretePID])
def test_a_wire_beyond_the_last_input_changes_nothing(hold):
    # PathSim makes room for any port number that is wired
    block = hold()
    u = [0.5 + i for i in range(len(block.input_port_labels))]
    expected, state = block.law(u, block.initial_state()), block.initial_state()
    assert block.law([*u, 9.0, 9.0], state) == expected
    _, state = expected
    assert block.law([*u, 9.0], state) == block.law(u, state)


@pytest.mark.parametrize(
    ("vc", "demanded", "share"),
    [
        (90.0, 90.0, 1.0),
        (200.0, 90.0, 1.0),
        (81.0, 90.0, 1.0),
        (76.5, 90.0, 0.5),
        (72.0, 90.0, 0.0),
        (67.5, 90.0, -0.5),
        (63.0, 90.0, -1.0),
        (10.0, 90.0, -1.0),
        (0.0, 0.0, 1.0),
        (10.0, -5.0, 1.0),
        (0.25, 0.5, -1.0),
    ],
)
def test_share_of_the_climb_that_the_airspeed_allows(vc, demanded, share):
    assert share_of_climb(vc, demanded) == pytest.approx(share, abs=1e-12)


def test_the_autopilot_gives_up_a_climb_for_its_airspeed():
    # held at 90 kt, flown at 76.5: half of the rate of climb demanded, descents in full
    n = 200
    for port, hdot in ((1000.0, 4.0), (-1000.0, -8.0)):
        y = laws(
            Autopilot(GAINS, vc_ref=90.0, T=T),
            h=NOTHING + 5000.0,
            theta=NOTHING,
            vc=np.where(np.arange(N) < n, 90.0, 76.5),
            h_ref=NOTHING + port,
        )
        assert y["hdot_cmd"][n - 1] == pytest.approx(np.sign(port) * 8.0)
        assert y["hdot_cmd"][-1] == pytest.approx(hdot)
