"""Localizer, glide slope and flare are the equations in their manual pages: see ``test_laws``."""

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
    G,
    N,
    T,
    aileron_for,
    assert_same,
    attitude,
    clip,
    degrees,
    elevator_for,
    laws,
    smoothed,
    wander,
)

from pathsim_jsbsim_blocks import (
    FlareHold,
    GlideslopeHold,
    LocalizerHold,
)


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
    u, reference = aileron_for(localizer, wires, limits)
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


@pytest.mark.parametrize(("sink_max", "most"), [(None, 1.2), (9.0, 9.0 / 7.86)])
@pytest.mark.parametrize("received", [True, False])
def test_near_the_ground_the_sink_rate_is_limited(received, sink_max, most):
    # 18 ft above a path of 3 deg, at 150 ft/s: the path sinks at 7.86 ft/s
    dist = 7000.0 - 150.0 * T * np.arange(N)
    slope = math.tan(math.radians(3.0))
    earth = 0.0 if received else dist**2 / (2 * 20.9e6)
    wires = {"h": 518.0 + dist * slope + earth, "alpha": NOTHING, "gs_ft": NOTHING + 18.0}
    wires |= {"gs_deg": NOTHING + 0.1, "gs_dist": dist, "lat": -dist / 362_750.0}
    block = GlideslopeHold(
        gains={"altitude": ALTITUDE, "pitch": ATTITUDE},
        elevation=500.0,
        crossing_height=0.0,
        T=T,
        **({"sink_max": sink_max} if sink_max else {}),
    )
    if received:
        block.inputs.wired = {"gs_dist"}
    ours = laws(block, **wires)
    assert ours["captured"][-1] == 1.0
    rate, path = ours["hdot_cmd"][200:], 150.0 * slope
    height = dist[200:] * slope + 18.0
    back = ALTITUDE["Kh"] * 18.0
    assert back > 0.2 * path
    # within a foot of 300 ft the Earth's curvature decides
    high, low = height > 301.0, height < 299.0
    assert rate[high] == pytest.approx(-path - back, abs=0.1)
    assert rate[low] == pytest.approx(-most * path, abs=0.05)
    assert high.any()
    assert low.any()


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

        aim, align, speed = c["course"], c["align"], max(self.along, 30.0)
        if rolls:
            aim -= clip(math.degrees(0.25 * now["loc_ft"] / speed), -5.0, 5.0)
            align *= self.kept / v
        flies = goes and not rolls
        if rolls or height < 3.0 * max(-now["hdot"], c["sink"]):
            self.psi += clip(degrees(aim - self.psi), -3.0 * T, 3.0 * T)
        error = 0.0 if flies else align * (degrees(now["psi"] - self.psi) + 0.5 * now["r"])
        if rolls:
            over_ground = c["course"] + math.degrees(math.atan(self.aside / speed))
            self.turn += 0.3 * align * degrees(over_ground - aim) * T
            self.turn = clip(self.turn, -1.0, 1.0)
        else:
            self.turn = 0.0
        steers = error + (self.turn if rolls else now["rudder"])
        self.rudder = clip(clip(steers, self.rudder - T, self.rudder + T), -1.0, 1.0)
        self.throttle = 1.0 if goes else max(self.throttle - 0.2 * T, -1.0)
        brakes = self.phase == 2 and now["wow"] and self.theta <= 0.0
        most = clip(self.along / 20.0, 0.0, 1.0)
        self.brakes = min(self.brakes + 0.25 * T, most) if brakes else 0.0
        own = [elevator, aileron, self.rudder, self.throttle, self.brakes]
        own.append(clip(-steers, -1.0, 1.0) if rolls else 0.0)
        passed = [now[x] for x in ("elevator", "aileron", "rudder", "throttle")]
        shown = own if self.phase else [*passed, 0.0, 0.0]
        return [*shown, float(self.phase), self.reference, self.bank, self.demanded]

    brakes = turn = 0.0


@pytest.mark.parametrize("astray", [False, True])
@pytest.mark.parametrize(("alpha", "aside"), [(0.0, -14.0), (3.0, 14.0)])
def test_flare_hold(wires, alpha, aside, astray):
    # 8 s of approach, flare, roll-out from 25 s with a bounce, go-around from 35 s
    limits, rng, t = (-0.25, 0.25), np.random.default_rng(10), T * np.arange(N)

    def along(*values, noise=0.0):
        return wander(rng, noise, np.interp(t, [0.0, 15.0, 25.0, 35.0, 45.0], values))

    wires = {name: wires[name] for name in ("theta", "q", "phi", "p", "r", "psi")} | {
        "h_agl": along(95.0, 35.0, 5.0, 5.0, 90.0, noise=0.3),
        "hdot": along(-6.0, -6.0, -2.0, 0.0, 8.0, noise=1.0),
        "vc": along(90.0, 80.0, 75.0, 50.0, 70.0, noise=1.0),
        # at the end of the roll-out beyond the limits of the steering
        "loc_ft": along(3.0, 8.0, 0.5 * aside, aside, 9.0, noise=1.0),
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
    ports = {name: signal for name, signal in wires.items() if name != "alpha" or alpha}
    assert_same(laws(block, **ports), expected, limits)
    assert set(expected["phase"]) == ({0.0, 3.0} if astray else {0.0, 1.0, 2.0, 3.0})
    if not astray:
        assert 0.2 < expected["brakes"].max() <= 1.0
