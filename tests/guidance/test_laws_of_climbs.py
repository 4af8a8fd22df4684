"""The altitude hold and the autopilot are the equations in their manual pages, and the holds'."""

from __future__ import annotations

import math

import numpy as np
import pytest
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
    assert_same,
    clip,
    elevator_for,
    laws,
    wander,
)

from pathsim_jsbsim_blocks import (
    AirspeedHold,
    AltitudeHold,
    Autopilot,
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


@pytest.mark.parametrize("inner", ["altitude", "pitch"])
def test_the_autopilot_is_the_holds(wires, inner):
    shifts = {"pitch_off": 0, "roll_off": 60, "speed_off": 130, "yaw_off": 190}
    offs = {name: np.roll(wires["off"], shift) for name, shift in shifts.items()}
    pitching = inner == "pitch"
    steady = wires | {"vc": 95.0 + 0.02 * wires["vc"], "vc_ref": NOTHING}  # no climb given up
    steady["vt"] = NOTHING + 170.0
    climbs = {"h_ref": 5020.0, "hdot_max": 9.0, "theta_min": -3.0, "theta_max": 5.0}
    turns = {"psi_ref": 10.0, "bank_max": 13.0}
    pilot = Autopilot(
        GAINS,
        theta_ref=1.0,
        phi_ref=2.0,
        vc_ref=96.0,
        elevator_authority=0.4,
        aileron_authority=(-0.3, 0.35),
        rudder_authority=0.05,
        throttle_authority=(-0.15, 0.1),
        T=T,
        **climbs,
        **turns,
    )
    modes = {"pitch_mode": NOTHING + pitching, "roll_mode": NOTHING + pitching}
    one = laws(pilot, **steady, **offs, **modes)

    pitch, roll = {"authority": 0.4, "T": T}, {"authority": (-0.3, 0.35), "T": T}
    if pitching:
        holds = {
            "pitch_off": PitchHold(GAINS["pitch"], theta_ref=1.0, **pitch),
            "roll_off": RollHold(GAINS["roll"], phi_ref=2.0, **roll),
        }
    else:
        vertical, lateral = (
            {name: GAINS[name] for name in names}
            for names in (("altitude", "pitch"), ("heading", "roll"))
        )
        holds = {
            "pitch_off": AltitudeHold(vertical, **climbs, **pitch),
            "roll_off": HeadingHold(lateral, **turns, **roll),
        }
    holds["speed_off"] = AirspeedHold(GAINS["speed"], vc_ref=96.0, T=T, authority=(-0.15, 0.1))
    holds["yaw_off"] = YawDamper(GAINS["yaw"], authority=0.05, T=T)
    several = {"hdot_cmd": NOTHING, "captured": NOTHING}
    for off, hold in holds.items():
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


@pytest.mark.parametrize(
    ("vc", "demanded", "share"),
    [
        (90.0, 90.0, 1.0),
        (81.0, 90.0, 1.0),
        (76.5, 90.0, 0.5),
        (72.0, 90.0, 0.0),
        (63.0, 90.0, -1.0),
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
