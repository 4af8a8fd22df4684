"""Every hold is the equation in its manual page: outputs over random wires, without an aircraft.

The equations are written down here a second time, from the manual pages and with the sign of the
actuator in the gains, as one loop over the samples for each kind of hold.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from pathsim_jsbsim_blocks import (
    AirspeedHold,
    AltitudeHold,
    Autopilot,
    DiscretePID,
    FlareHold,
    GlideslopeHold,
    HeadingHold,
    LocalizerHold,
    PitchHold,
    RollHold,
    SpeedOnPitchHold,
    VerticalSpeedHold,
    YawDamper,
)
from pathsim_jsbsim_blocks.control import holds
from pathsim_jsbsim_blocks.control.loops import wrap
from pathsim_jsbsim_blocks.control.protection import share_of_climb

T = 1 / 20
N = 900
OFF = np.zeros(N)
OFF[300:340] = OFF[600:610] = 1.0


def wander(rng, size, mean=0.0):
    """Noise of that size (rms) about its mean, with a correlation time of 1 s."""
    pole = math.exp(-T)
    return mean + size * math.sqrt(1 - pole**2) * lfilter([1.0], [1.0, -pole], rng.normal(size=N))


def clip(x, low, high):
    return min(max(x, low), high)


def laws(block, **wires):
    """Outputs of the block's law by port, over whole signals; what is not wired is 0."""
    state, out = block.initial_state(), []
    for k in range(N):
        u = [float(wires[name][k]) if name in wires else 0.0 for name in block.input_port_labels]
        y, state = block.law(u, state)
        out.append(y)
    return dict(zip(block.output_port_labels, np.array(out).T, strict=True))


class PI:
    """u = Kp (b r - y) + Ki int(r - y) dt - Kd dy/dt - Kr rate + feed, in its limits."""

    def __init__(self, Kp, Ki, low, high, Kd=0.0, Kr=0.0, b=1.0, Tf=0.0):
        self.Kp, self.Ki, self.Kd, self.Kr, self.b = Kp, Ki, Kd, Kr, b
        self.low, self.high = low, high
        self.pole = math.exp(-T / Tf) if Tf else 0.0
        self.back = T * Ki / Kp  # over the integral's own time constant
        self.u, self.integral, self.fading, self.dydt, self.y = 0.0, 0.0, 0.0, 0.0, None

    def hold(self, y):
        self._differentiate(y)
        return self.u

    def _differentiate(self, y):
        if self.y is not None:
            self.dydt = self.pole * self.dydt + (1 - self.pole) * (y - self.y) / T
        self.y = y

    def __call__(self, r, y, rate=0.0, sat=0.0, feed=0.0, engaging=False):
        self._differentiate(y)
        static = self.Kp * (self.b * r - y) + feed
        damping = self.Kd * self.dydt + self.Kr * rate
        if engaging:  # go on from the output, which the integral and a fading part take over
            self.integral, self.fading = self.u - static, damping
        v = static - damping + self.integral + self.fading
        self.u = clip(v, self.low, self.high)
        self.fading *= math.exp(-T / 0.3)
        self.integral += self.Ki * T * (r - y) + self.back * (self.u - v - sat)
        return self.u


def seen(reference, vc):
    """An airspeed whose error beyond 4 kt counts for a fifth."""
    error = abs(vc - reference)
    return vc if error <= 4.0 else reference + math.copysign(0.2 * error + 3.2, vc - reference)


def on_a_ramp(pi, ramp, target, y, rate, port, sat, off, feed, seen=lambda reference, y: y):
    """Actuator and reference of a hold that moves to ``target`` (None: what it finds) + port."""
    u, references = np.empty(N), np.empty(N)
    engaged = False
    for k in range(N):
        if off[k]:
            references[k] = y[k]
            u[k] = pi.hold(y[k])
        else:
            if engaged:
                if callable(target):
                    goal = target(k)
                else:
                    goal = (found if target is None else target) + port[k]  # noqa: F821
                references[k] = references[k - 1] + clip(
                    goal - references[k - 1], -ramp * T, ramp * T
                )
            else:
                references[k] = found = y[k]  # noqa: F841
                if callable(target):
                    target(k)
            value = seen(references[k], y[k])
            u[k] = pi(references[k], value, rate[k], sat[k], feed[k], engaging=not engaged)
        engaged = not off[k]
    return u, references


def elevator_for(pitch, wires, limits):
    """The elevator of a pitch angle, which is a function of the sample."""
    return on_a_ramp(
        attitude(-1.0, *limits),
        ATTITUDE["ramp"],
        pitch,
        wires["theta"],
        wires["q"],
        NOTHING,
        wires["elev_sat"],
        wires["off"],
        NOTHING,
    )


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


ATTITUDE = {"Kp": 0.11, "Ki": 0.03, "Kr": 0.017, "b": 0.6, "ramp": 4.5}
SPEED = {
    "Kp": 0.03,
    "Ki": 0.001,
    "Kd": -0.007,
    "Tf": 0.4,
    "b": 0.9,
    "ramp": 1.7,
    "Kc": 0.0035,
    "band": 4.0,
}
HEADING = {"Kp": 1.3, "Ki": 0.02}
ALTITUDE = {"Kh": 0.21, "Kp": 0.09, "Ki": 0.15, "hdot_max": 8.0}
NOTHING = np.zeros(N)


def attitude(sign, low, high):
    gains = {name: sign * value for name, value in ATTITUDE.items() if name in ("Kp", "Ki", "Kr")}
    return PI(**gains, b=ATTITUDE["b"], low=low, high=high)


def assert_same(ours, theirs, limits):
    """Rounding; ``limits`` are reached, and most samples are between them."""
    for name, expected in theirs.items():
        assert np.max(np.abs(ours[name] - expected)) < 1e-9, name
    u, (low, high) = next(iter(theirs.values())), limits
    assert low <= np.min(u) < np.max(u) <= high
    assert 5 < np.count_nonzero((u == low) | (u == high)) < N / 2


@pytest.mark.parametrize("target", [None, 1.0])
@pytest.mark.parametrize(
    ("hold", "sign", "y", "rate", "actuator"),
    [(PitchHold, -1.0, "theta", "q", "elevator"), (RollHold, 1.0, "phi", "p", "aileron")],
)
def test_attitude_holds(wires, hold, sign, y, rate, actuator, target):
    limits = (-0.5, 0.4)
    block = hold(gains=ATTITUDE, authority=limits, T=T, **{f"{y}_ref": target})
    sat = wires[f"{actuator[:3]}_sat" if actuator == "aileron" else "elev_sat"]
    u, reference = on_a_ramp(
        attitude(sign, *limits),
        ATTITUDE["ramp"],
        target,
        wires[y],
        wires[rate],
        wires[f"{y}_ref"],
        sat,
        wires["off"],
        NOTHING,
    )
    assert_same(laws(block, **wires), {actuator: u, f"{y}_cmd": reference}, limits)


@pytest.mark.parametrize("target", [None, 91.0])
def test_airspeed_hold(wires, target):
    limits = (-0.15, 0.1)
    block = AirspeedHold(gains=SPEED, authority=limits, T=T, vc_ref=target)
    pi = PI(
        **{name: value for name, value in SPEED.items() if name not in ("Kc", "ramp", "band")},
        low=limits[0],
        high=limits[1],
    )
    # errors of up to 16 kt
    wires = wires | {"vc": 90.0 + 3.0 * (wires["vc"] - 90.0)}
    u, reference = on_a_ramp(
        pi,
        SPEED["ramp"],
        target,
        wires["vc"],
        NOTHING,
        wires["vc_ref"],
        wires["thr_sat"],
        wires["off"],
        SPEED["Kc"] * wires["hdot"],
        seen,
    )
    assert np.abs(wires["vc"] - reference).max() > 8.0
    assert_same(laws(block, **wires), {"throttle": u, "vc_cmd": reference}, limits)


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

    u, reference = on_a_ramp(
        attitude(1.0, *limits),
        ATTITUDE["ramp"],
        heading,
        wires["phi"],
        wires["p"],
        NOTHING,
        wires["ail_sat"],
        wires["off"],
        NOTHING,
    )
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


G = 32.174  # ft/s2


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


@pytest.mark.parametrize("hold", [VerticalSpeedHold, SpeedOnPitchHold])
def test_climbs(wires, hold):
    limits, theta, target = (-0.7, 0.7), (-2.0, 5.0), 5040.0
    wires = wires | {"h": 4920.0 + 0.2 * np.arange(N), "vc": wires["vc"] - 1.0}
    speed = {"speed": SPEED} if hold is SpeedOnPitchHold else {}
    block = hold(
        gains={"altitude": ALTITUDE, "pitch": ATTITUDE, **speed},
        h_ref=target - wires["h_ref"][0],
        theta_min=theta[0],
        theta_max=theta[1],
        authority=0.7,
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
        if hold is VerticalSpeedHold:
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
    assert_same(laws(block, **wires), expected, limits)
    assert 50 < np.count_nonzero(captured) < N - 200


def degrees(angle):
    """In [-180, 180)."""
    return (angle + 180.0) % 360.0 - 180.0


def smoothed(pole, x):
    """A low-pass that starts at its first value."""
    return lfilter([1.0 - pole], [1.0, -pole], x, zi=[pole * x[0]])[0]


@pytest.mark.parametrize("lookahead", [None, 9.0])
def test_localizer_hold(wires, lookahead):
    # closes on the course from 1500 ft to the right of it, and turns onto it after 24 s
    course, bank, limits = 12.0, 12.0, (-1.2, 1.2)
    rng, t = np.random.default_rng(8), T * np.arange(N)
    turns = np.maximum(t - 24.3, 0.0)
    ft = wander(rng, 1.0, 1095.0 - 45.0 * (t - turns) + 405.0 * np.exp(-turns / 9.0))
    dist = wander(rng, 1.0, 30_000.0 - 150.0 * t)
    across, along = np.diff(ft, prepend=0.0) / T, -np.diff(dist, prepend=0.0) / T
    pole = math.exp(-T / 2.0)
    speed = np.maximum(np.r_[0.0, smoothed(pole, along[1:])], 30.0)
    drift = course + np.degrees(np.arctan(across / np.maximum(along, 30.0))) - wires["psi"]
    drift[0] = 0.0
    drift[1:] = smoothed(pole, np.unwrap(drift[1:], period=360.0))
    chi, now, captured, demanded = wires["psi"] + drift, {}, np.zeros(N), np.zeros(N)

    def localizer(k):
        if not now or wires["off"][k - 1]:
            now.update(found=wires["psi"][k], captured=False)
            now["pi"] = PI(**HEADING, low=-bank, high=bank)
        tau = lookahead or max(3.5 * speed[k] / (G * HEADING["Kp"]), 1.0)
        closing = clip(math.degrees(math.atan(ft[k] / (tau * speed[k]))), -30.0, 30.0)
        ahead = degrees(chi[k] - course)
        met = ahead <= -closing if ft[k] > 0.0 else ahead >= -closing
        now["captured"] |= k > 0 and (met or abs(closing) < 5.0)
        demanded[k] = course - closing if now["captured"] else now["found"]
        captured[k] = now["captured"]
        error = degrees(demanded[k] - (chi[k] if now["captured"] else wires["psi"][k]))
        if abs(HEADING["Kp"] * error) >= bank:
            now["pi"].integral = 0.0
        return now["pi"](error, 0.0)

    block = LocalizerHold(
        gains={"heading": HEADING, "roll": ATTITUDE},
        course=course,
        lookahead=lookahead,
        intercept=30.0,
        bank_max=bank,
        authority=1.2,
        T=T,
    )
    u, reference = on_a_ramp(
        attitude(1.0, *limits),
        ATTITUDE["ramp"],
        localizer,
        wires["phi"],
        wires["p"],
        NOTHING,
        wires["ail_sat"],
        wires["off"],
        NOTHING,
    )
    ours = laws(block, **wires, loc_ft=ft, loc_dist=dist)
    assert_same(ours, {"aileron": u, "phi_cmd": reference, "captured": captured}, limits)
    on = wires["off"] == 0.0
    assert ours["chi_cmd"][on] == pytest.approx(demanded[on] % 360.0, abs=1e-9)
    assert 100 < np.count_nonzero(captured) < N - 100


@pytest.mark.parametrize(("from_above", "hdot_max"), [(False, None), (True, 3.0)])
def test_glideslope_hold(wires, from_above, hdot_max):
    limits, theta, slope = (-1.2, 1.2), (-3.0, 6.0), math.tan(math.radians(3.0))
    # crosses the path from below, or comes from above it
    rng, t = np.random.default_rng(9), T * np.arange(N)
    dist = wander(rng, 3.0, 20_000.0 - 150.0 * t)
    start, rate = (260.0, -12.0) if from_above else (-90.0, 6.0)
    above = wander(rng, 10.0, start + rate * t)
    seen = np.degrees(np.arctan(slope + above / dist)) - 3.0
    # the descent, and swings that move the elevator from stop to stop
    wires = wires | {"hdot": wires["hdot"] - 8.0 * (t > 5.0) + 6.0 * np.sin(t)}
    closing = -np.diff(dist, prepend=0.0) / T
    closing[0] = 0.0
    speed = np.r_[0.0, smoothed(math.exp(-T / 2.0), np.abs(closing[1:]))]
    most = ALTITUDE["hdot_max"] if hdot_max is None else hdot_max
    now, demanded, captured = {}, np.zeros(N), np.zeros(N)

    def path(k):
        engaging = not now or wires["off"][k - 1]
        if engaging:
            now.update(found=wires["h"][k], captured=False)
            now["pi"] = PI(ALTITUDE["Kp"], ALTITUDE["Ki"], *theta)
            now["pi"].u = wires["theta"][k]
        sink, back = slope * speed[k], -ALTITUDE["Kh"] * above[k]
        level = clip(ALTITUDE["Kh"] * (now["found"] - wires["h"][k]), -most, most)
        seen_from_below = from_above or seen[k] <= 0.35
        now["captured"] |= closing[k] > 0.0 and back - sink <= level and seen_from_below
        captured[k] = now["captured"]
        descent = clip(back, -most, max(most, sink)) - sink
        demanded[k] = descent if now["captured"] else level
        return now["pi"](demanded[k], wires["hdot"][k], engaging=engaging)

    block = GlideslopeHold(
        gains={"altitude": ALTITUDE, "pitch": ATTITUDE},
        hdot_max=hdot_max,
        theta_min=theta[0],
        theta_max=theta[1],
        authority=1.2,
        T=T,
        from_above=from_above,
    )
    block.inputs.wired = {"gs_dist"}
    u, reference = elevator_for(path, wires, limits)
    ours = laws(block, **wires, gs_deg=seen, gs_ft=above, gs_dist=dist)
    expected = {"elevator": u, "theta_cmd": reference, "hdot_cmd": demanded, "captured": captured}
    assert_same(ours, expected, limits)
    assert np.array_equal(ours["gs_ft"], above)
    assert np.array_equal(ours["gs_deg"], seen)
    assert 100 < np.count_nonzero(captured) < N - 20


FLARE = {
    "course": 358.0,
    "gear_height": 5.0,
    "sink": 2.0,
    "tau": 2.5,
    "bank_max": 3.0,
    "align": 0.06,
    "climb": 9.0,
    "decide": 60.0,
    "across_max": 25.0,
    "theta_max": 7.0,
}


class Flare:
    """The law of a `FlareHold` from its manual page, sample by sample."""

    def __init__(self, limits):
        self.limits, self.phase, self.last, self.slow = limits, 0, None, {}

    def smooth(self, name, tau, x):
        """A low-pass that starts at 0."""
        self.slow[name] = self.slow.get(name, 0.0)
        self.slow[name] -= math.expm1(-T / tau) * (x - self.slow[name])
        return self.slow[name]

    def __call__(self, now):
        c, before, last = FLARE, self.phase, self.last
        height, v = now["h_agl"] - c["gear_height"], max(now["vc"] * 1852.0 / 0.3048 / 3600.0, 30.0)
        steepest = min(-height / c["tau"], 0.0) - c["sink"]
        self.beam(now, last)
        self.begin(now, height, steepest)
        gained = 0.0 if last is None else v - last["v"]
        acceleration = self.smooth("acceleration", 2.0, gained / T)
        sinks = v * math.radians(now["theta"] - now["alpha"]) - now["hdot"] if now["alpha"] else 0.0
        if last is None:
            self.slow["gust"] = sinks
        gust = self.smooth("gust", 0.2, sinks)
        if self.phase < 2:
            self.kept = v
        # on the ground, in a go-around until the airspeed of the touchdown
        self.rolls = self.phase == 2 or (self.phase == 3 and now["wow"] and v < self.kept)
        if before == 0:
            self.pitch, self.roll = attitude(-1.0, *self.limits), attitude(1.0, *self.limits)
            self.pitch.b, self.pitch.u, self.roll.u = 1.0, now["elevator"], now["aileron"]
            self.lowest = self.reference = now["theta"]
            self.bank, self.rudder, self.throttle = now["phi"], now["rudder"], now["throttle"]
            self.psi, self.kept = now["psi"], v
        elif self.phase != 3:  # an angle of attack for the same lift
            self.integral -= math.degrees(2.0 / 4.0) * gained / v
        if before == 0 or self.phase != before:
            self.integral = now["theta"] - math.degrees(now["hdot"] + gust) / v
            self.demanded, self.theta = now["hdot"], now["theta"]
            if self.phase == 3:
                self.lowest = now["theta"]
        lift = 0.0
        if last is not None:
            lift = self.smooth("lift", 0.2, (now["hdot"] - last["hdot"]) / T)
        self.climb(now, height, steepest, v, acceleration, gust, lift)
        out = self.commands(now, height, v, engaging=before == 0)
        self.last = now | {"v": v}
        return out

    def beam(self, now, last):
        self.aside = self.along = 0.0
        if last is not None:
            across = (now["loc_ft"] - last["loc_ft"]) / T
            along = (last["loc_dist"] - now["loc_dist"]) / T
            self.slow.setdefault("aside", across)
            self.slow.setdefault("along", along)
            self.aside = self.smooth("aside", 0.5, across)
            self.along = self.smooth("along", 0.5, along)

    def begin(self, now, height, steepest):
        c, before = FLARE, self.phase
        low = now["hdot"] <= steepest or height <= c["sink"] * c["tau"]
        if before == 0 and low:
            self.phase = 1
        self.least = min(self.least, height) if before == 1 else height
        if self.phase == 1 and now["wow"]:
            self.phase = 2
        elif self.phase == 2 and not now["wow"] and height > 1.0:
            self.phase = 1
        astray = height < c["decide"] and abs(now["loc_ft"]) > c["across_max"]
        if now["go_around"] or (self.phase < 2 and (astray or height > self.least + 10.0)):
            self.phase = 3
        if now["off"]:
            self.phase = 0

    def climb(self, now, height, steepest, v, acceleration, gust, lift):
        c, goes = FLARE, self.phase == 3
        spare = now["hdot"] + v / G * (acceleration + 0.1 * (v - self.kept))
        slower = max(c["climb"], spare - v / G * 0.1 * 0.1 * self.kept)
        target = clip(now["hdot"], steepest, 0.5 * (steepest - c["sink"]))
        if goes:
            target = clip(spare, 0.3 * c["climb"], slower)
        step = clip(target - self.demanded, -8.0 * T, 8.0 * T)
        self.demanded += step
        error, lag = self.demanded - now["hdot"], v / (4.0 * G)
        omega = min(1.0, 0.3 * ATTITUDE["Kp"] / ATTITUDE["Kr"])
        ahead = self.demanded + gust + lag * (omega * error + 0.22 * (step / T - lift))
        if not goes and now["hdot"] < steepest:
            ahead -= lag * now["hdot"] / c["tau"]
        asked = self.integral + math.degrees(ahead / v)
        highest = 15.0 if goes and height > 30.0 else c["theta_max"]
        lowest = -10.0 if goes and height > 100.0 else min(self.lowest, c["theta_max"])
        # no further where the elevator is at its stop; a positive one is nose down
        if self.pitch.u <= self.limits[0]:
            highest = min(highest, self.reference)
        elif self.pitch.u >= self.limits[1]:
            lowest = max(lowest, self.reference)
        wanted = clip(asked, lowest, highest)
        self.integral += omega * T * (math.degrees(error / v) + wanted - asked)
        if self.rolls:
            lowered = self.theta - (2.0 * T if now["wow"] else 0.0)
            wanted, self.demanded = max(lowered, min(self.theta, 0.0)), now["hdot"]
        self.theta = wanted

    def commands(self, now, height, v, engaging):
        c, rolls, goes = FLARE, self.rolls, self.phase == 3
        bank = 0.0
        if self.phase == 1:
            pull = 0.4 * (0.4 * now["loc_ft"] + 1.4 * self.aside)
            bank = clip(-math.degrees(pull / G), -c["bank_max"], c["bank_max"])
        elif goes:
            bank = clip(degrees(self.psi - now["psi"]), -c["bank_max"], c["bank_max"])
        if not engaging:
            self.reference += clip(self.theta - self.reference, -15.0 * T, 15.0 * T)
            most = ATTITUDE["ramp"] * T
            self.bank += clip(bank - self.bank, -most, most)
        elevator = self.pitch(self.reference, now["theta"], now["q"], engaging=engaging)
        aileron = self.roll(self.bank, now["phi"], now["p"], engaging=engaging)

        aim = c["course"]
        if rolls:
            aim -= clip(math.degrees(0.25 * now["loc_ft"] / v), -5.0, 5.0)
        flies = goes and not rolls
        if rolls or height < 3.0 * max(-now["hdot"], c["sink"]):
            self.psi += clip(degrees(aim - self.psi), -3.0 * T, 3.0 * T)
        error = 0.0 if flies else c["align"] * (degrees(now["psi"] - self.psi) + 0.5 * now["r"])
        moved = clip(now["rudder"] + error, self.rudder - T, self.rudder + T)
        self.rudder = clip(moved, -1.0, 1.0)
        self.throttle = 1.0 if goes else max(self.throttle - 0.2 * T, -1.0)
        brakes = self.phase == 2 and now["wow"] and self.theta <= 0.0
        most = clip(abs(self.along) / 20.0, 0.1, 1.0)
        self.brakes = min(self.brakes + 0.25 * T, most) if brakes else 0.0
        own = [elevator, aileron, self.rudder, self.throttle, self.brakes]
        own.append(clip(-error, -1.0, 1.0) if rolls else 0.0)
        passed = [now[x] for x in ("elevator", "aileron", "rudder", "throttle")]
        shown = own if self.phase else [*passed, 0.0, 0.0]
        return [*shown, float(self.phase), self.reference, self.bank, self.demanded]

    brakes = 0.0


@pytest.mark.parametrize("astray", [False, True])
@pytest.mark.parametrize("alpha", [0.0, 3.0])
def test_flare_hold(wires, alpha, astray):
    # 8 s of approach, flare, roll-out from 25 s with a bounce, go-around from 35 s
    limits, rng, t = (-0.25, 0.25), np.random.default_rng(10), T * np.arange(N)

    def along(*values, noise=0.0):
        return wander(rng, noise, np.interp(t, [0.0, 15.0, 25.0, 35.0, 45.0], values))

    wires = {name: wires[name] for name in ("theta", "q", "phi", "p", "r", "psi")} | {
        "h_agl": along(95.0, 35.0, 5.0, 5.0, 90.0, noise=0.3),
        "hdot": along(-6.0, -6.0, -2.0, 0.0, 8.0, noise=1.0),
        "vc": along(90.0, 80.0, 75.0, 50.0, 70.0, noise=1.0),
        "loc_ft": along(3.0, 8.0, -5.0, 5.0, 9.0, noise=1.0),
        "loc_dist": 9000.0 - np.cumsum(T * np.interp(t, [0.0, 25.0, 33.0], [130.0, 130.0, 6.0])),
        "alpha": along(alpha, alpha, alpha, alpha, alpha, noise=alpha / 4),
        **{name: wander(rng, 0.05) for name in ("elevator", "aileron", "rudder", "throttle")},
        "wow": ((t > 25.0) & (t < 38.0) & ~((t > 27.0) & (t < 28.0))).astype(float),
        "go_around": (t > 35.0).astype(float),
        "off": (t > 43.0).astype(float),
    }
    wires["h_agl"] += 3.0 * ((t > 27.0) & (t < 28.0))
    if astray:
        wires["loc_ft"] = wires["loc_ft"] + 30.0 * (t > 12.0)
    gains = {"altitude": ALTITUDE, "pitch": ATTITUDE, "roll": ATTITUDE}
    block, flare = FlareHold(gains, authority=limits[1], T=T, **FLARE), Flare(limits)
    rows = [flare({name: float(x[k]) for name, x in wires.items()}) for k in range(N)]
    expected = dict(zip(block.output_port_labels, np.array(rows).T, strict=True))
    assert_same(laws(block, **wires), expected, limits)
    assert set(expected["phase"]) == ({0.0, 3.0} if astray else {0.0, 1.0, 2.0, 3.0})
    if not astray:
        assert 0.2 < expected["brakes"].max() <= 1.0


def test_yaw_damper(wires):
    K, tau, limit = 0.02, 1.5, 0.05
    block = YawDamper(gains={"K": K, "tau": tau}, authority=limit, T=T)
    u, last, engaged = np.empty(N), 0.0, False
    for k in range(N):
        r = wires["r"][k]
        if wires["off"][k]:
            last *= math.exp(-T / tau)
        else:
            if not engaged:
                mean = r - last / K
            last = clip(K * (r - mean), -limit, limit)
            mean = math.exp(-T / tau) * mean + (1 - math.exp(-T / tau)) * r
        u[k], engaged = last, not wires["off"][k]
    assert_same(laws(block, **wires), {"rudder": u}, (-limit, limit))
    assert not laws(YawDamper(gains={"K": 0.0, "tau": tau}, T=T), **wires)["rudder"].any()


def test_turn_coordination(wires):
    K, tau, Kp, Ki, limit = 0.02, 1.5, 0.03, 0.06, 0.05
    block = YawDamper(gains={"K": K, "tau": tau, "Kp": Kp, "Ki": Ki}, authority=limit, T=T)
    beta = wander(np.random.default_rng(5), 0.8)
    u, last, engaged = np.empty(N), 0.0, False
    for k in range(N):
        r = wires["r"][k]
        if wires["off"][k]:
            last *= math.exp(-T / tau)
        else:
            if not engaged:  # go on from the output: the integral cancels the sideslip found
                mean, integral = r - last / K, Kp * beta[k]
            v = K * (r - mean) - Kp * beta[k] + integral
            last = clip(v, -limit, limit)
            mean = math.exp(-T / tau) * mean + (1 - math.exp(-T / tau)) * r
            if not (last != v and np.sign(v) == -np.sign(beta[k])):  # no further into the limit
                integral -= Ki * T * beta[k]
        u[k], engaged = last, not wires["off"][k]
    assert_same(laws(block, **wires, beta=beta), {"rudder": u}, (-limit, limit))


def test_without_sideslip_the_rudder_has_no_integral(wires):
    on = {name: x for name, x in wires.items() if name != "off"}
    numbers = {"K": 0.02, "tau": 1.5, "Kroll": -0.01, "Kbank": -0.004}
    plain, integral = (
        laws(YawDamper(gains={**numbers, "Ki": Ki}, T=T), **on) for Ki in (0.0, 0.05)
    )
    assert np.array_equal(plain["rudder"], integral["rudder"])


def test_turns_are_fed_forward(wires):
    K, tau, Kp, Kroll, Kbank, limit = 0.02, 1.5, 0.03, -0.01, -0.004, 0.09
    numbers = {"K": K, "tau": tau, "Kp": Kp, "Kroll": Kroll, "Kbank": Kbank}
    block = YawDamper(gains=numbers, authority=limit, T=T)
    beta, p, phi = wander(np.random.default_rng(6), 0.8), wires["p"], wires["phi"]
    u, last, engaged = np.empty(N), 0.0, False
    for k in range(N):
        r = wires["r"][k]
        turn = Kroll * p[k] + Kbank * 180.0 / math.pi * math.sin(phi[k] * math.pi / 180.0)
        if wires["off"][k]:
            last *= math.exp(-T / tau)
        else:
            if not engaged:  # go on from the output; what was held of it fades
                mean, held = r - last / K, Kp * beta[k] - turn
            last = clip(K * (r - mean) - Kp * beta[k] + held + turn, -limit, limit)
            mean = math.exp(-T / tau) * mean + (1 - math.exp(-T / tau)) * r
            held *= math.exp(-T / tau)
        u[k], engaged = last, not wires["off"][k]
    assert_same(laws(block, **wires, beta=beta), {"rudder": u}, (-limit, limit))


GAINS = {
    "pitch": ATTITUDE,
    "roll": {**ATTITUDE, "Kr": 0.01},
    "heading": HEADING,
    "altitude": ALTITUDE,
    "speed": SPEED,
    "yaw": {"K": 0.02},
}


@pytest.mark.parametrize("inner", ["altitude", "pitch", "climb", "speed"])
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
    v_mode = {"climb": 1.0, "speed": 2.0}.get(inner, 0.0)
    modes = {"pitch_mode": NOTHING + pitching, "roll_mode": NOTHING + pitching}
    modes["v_mode"] = NOTHING + v_mode
    # below 5020 ft while it climbs, until the middle
    steady["h"] = np.where((np.arange(N) < N // 2) & (v_mode > 0.0), 4700.0, steady["h"])
    steady["vt"] = NOTHING + 170.0
    one = laws(
        Autopilot(
            GAINS,
            theta_ref=1.0,
            h_ref=5020.0,
            phi_ref=2.0,
            psi_ref=10.0,
            vc_ref=96.0,
            hdot_ref=5.0,
            bank_max=13.0,
            hdot_max=None if v_mode else 9.0,
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
    climb = {
        "gains": {name: GAINS[name] for name in ("altitude", "pitch")},
        "h_ref": 5020.0,
        "theta_min": -3.0,
        "theta_max": 5.0,
        **pitch,
    }
    longitudinal = {
        "pitch": lambda: PitchHold(GAINS["pitch"], theta_ref=1.0, **pitch),
        "altitude": lambda: AltitudeHold(hdot_max=9.0, **climb),
        "climb": lambda: VerticalSpeedHold(hdot_ref=5.0, **climb),
        "speed": lambda: SpeedOnPitchHold(
            vc_ref=96.0, **(climb | {"gains": climb["gains"] | {"speed": SPEED}})
        ),
    }
    holds = [
        ("pitch_off", longitudinal[inner]()),
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
        several |= laws(hold, **(steady | {"off": offs[off]}))
    assert set(one) == set(several)
    if v_mode:
        assert 100 < np.count_nonzero(one["captured"]) < N - 100
    if inner == "speed":  # the throttle is given until the capture
        del several["throttle"], several["vc_cmd"]
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
    quiet = wires | {"off": NOTHING, "vc": NOTHING + 90.0, "vc_ref": NOTHING}
    y = laws(Autopilot(GAINS, T=T), **quiet, pitch_mode=mode, roll_mode=mode)
    for name in ("theta_cmd", "phi_cmd"):
        assert np.max(np.abs(np.diff(y[name]))) == pytest.approx(ATTITUDE["ramp"] * T)
    for k in range(200, N, 200):  # the altitude's loop begins with the pitch reference as it is
        assert y["theta_cmd"][k] == pytest.approx(y["theta_cmd"][k - 1], abs=1e-12)
    assert not y["hdot_cmd"][mode != 0].any()
    # the altitude found when its mode came back, and the port's way since
    back = 200
    error = (quiet["h"][back] + quiet["h_ref"] - quiet["h"])[back:300]
    assert y["hdot_cmd"][back:300] == pytest.approx(
        np.clip(ALTITUDE["Kh"] * error, -8.0, 8.0), abs=1e-9
    )


@pytest.mark.parametrize(
    "hold", [*(getattr(holds, name) for name in holds.__all__), Autopilot, DiscretePID]
)
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


@pytest.mark.parametrize(
    ("angle", "same"),
    [
        (0.0, 0.0),
        (180.0, -180.0),
        (-180.0, -180.0),
        (179.0, 179.0),
        (181.0, -179.0),
        (-181.0, 179.0),
        (725.0, 5.0),
        (-725.0, -5.0),
    ],
)
def test_wrap(angle, same):
    assert wrap(angle) == same
