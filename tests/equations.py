"""The equations of the loops, written down from the manual pages, and signals to compare them over.

The sign of the actuator is in the gains; a hold is one loop over the samples.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.signal import lfilter

T = 1 / 20
N = 900
NOTHING = np.zeros(N)
G = 32.174  # ft/s2
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


def wander(rng, size, mean=0.0):
    """Noise of that size (rms) about its mean, with a correlation time of 1 s."""
    pole = math.exp(-T)
    return mean + size * math.sqrt(1 - pole**2) * lfilter([1.0], [1.0, -pole], rng.normal(size=N))


def clip(x, low, high):
    return min(max(x, low), high)


def degrees(angle):
    """In [-180, 180)."""
    return (angle + 180.0) % 360.0 - 180.0


def smoothed(pole, x):
    """A low-pass that starts at its first value."""
    return lfilter([1.0 - pole], [1.0, -pole], x, zi=[pole * x[0]])[0]


def laws(block, **wires):
    """Outputs of the block's law by port, over whole signals; what is not wired is 0."""
    block.inputs.wired.update(wires)
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


def attitude(sign, low, high):
    gains = {name: sign * value for name, value in ATTITUDE.items() if name in ("Kp", "Ki", "Kr")}
    return PI(**gains, b=ATTITUDE["b"], low=low, high=high)


def on_a_ramp(
    pi,
    ramp,
    target,
    y,
    off,
    rate=NOTHING,
    port=NOTHING,
    sat=NOTHING,
    feed=NOTHING,
    seen=lambda reference, y: y,
):
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
    pi, sat = attitude(-1.0, *limits), wires["elev_sat"]
    return on_a_ramp(
        pi, ATTITUDE["ramp"], pitch, wires["theta"], wires["off"], rate=wires["q"], sat=sat
    )


def aileron_for(bank, wires, limits):
    """The aileron of a roll angle, which is a function of the sample."""
    pi, sat = attitude(1.0, *limits), wires["ail_sat"]
    return on_a_ramp(
        pi, ATTITUDE["ramp"], bank, wires["phi"], wires["off"], rate=wires["p"], sat=sat
    )


def assert_same(ours, theirs, limits):
    """Rounding; ``limits`` are reached, and most samples are between them."""
    for name, expected in theirs.items():
        assert np.max(np.abs(ours[name] - expected)) < 1e-9, name
    u, (low, high) = next(iter(theirs.values())), limits
    assert low <= np.min(u) < np.max(u) <= high
    assert 5 < np.count_nonzero((u == low) | (u == high)) < N / 2
