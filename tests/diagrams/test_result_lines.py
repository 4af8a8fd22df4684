"""Result lines are true, however short the flight is: each number is taken from the CSV again."""

import math
import re

import numpy as np
import pandas as pd
import pytest

from pathsim_jsbsim_blocks.cli import main

NUMBER = r"(-?[\d,]+(?:\.\d+)?(?:e[+-]\d+)?)"


def oscillator(f):
    x, v = f["position x"], f["velocity v"]
    swing = f["t"] <= f["t"][1:][(v[:-1] < 0.0) & (v[1:] >= 0.0)][0]
    # analytic: half a period later, by its damping ratio of 0.25
    return x[swing].min(), -math.exp(-0.25 * math.pi / math.sqrt(1 - 0.25**2)), 0.25, x[-1], 20


def van_der_pol(f):
    x = f["position x"]
    up = f["t"][1:][(x[:-1] < 0.0) & (x[1:] >= 0.0)]
    return np.abs(x[f["t"] > up[-4]]).max(), (up[-1] - up[-4]) / 3


def pitch_hold(f, target):
    theta, h = f["pitch angle"], f["altitude"]
    away = np.flatnonzero(np.abs(theta - target) > 0.05)[-1]
    settled = () if away + 1 == len(theta) else (f["t"][away + 1],)
    end = theta.max(), h[-1] - h[0], f["calibrated airspeed"][-1]
    return theta[-1], f["t"][-1], 0.05, target, *settled, *end


def step_response(f):
    y = f["response y"]
    return y[-1], 1, np.abs(y - f["analytic"]).max()


def elevator_doublet(f):
    alpha = f["angle of attack"]
    # masses and trim are those of the notebook
    trim = 67967, 48235, 790.8, alpha[0], -2.9634, -0.147775, 0.772610
    return *trim, alpha.min(), alpha.max(), alpha[-1], 1


SHORT = ["--duration", "1"]
SWING = "first swing to # (analytic # from x = 1 with zeta = #)\nx = # after # s\n"
NO_SWING = "the first swing is not over by the end\nx = # after # s\n"
FEW = "too few cycles for a period: # in # s\n"
DOUBLET = """weight # lb, empty # lb, CG at x = # in
trimmed: alpha # deg, elevator # deg (# of its travel), throttle #
alpha from # to # deg, # deg after # s
"""
HELD = (
    "pitch angle # deg after # s, {}within # deg of # deg {}, at most # deg; climbed # ft, # KCAS\n"
)
LATE = HELD.format("not ", "by the end")


# something that a result line tells of happens, does not happen yet, or never
@pytest.mark.parametrize(
    ("name", "options", "line", "values"),
    [
        ("damped_oscillator", [], SWING, oscillator),
        ("damped_oscillator", SHORT, NO_SWING, lambda f: (f["position x"][-1], 1)),
        ("damped_oscillator", ["--set", "stiffness.gain=0"], NO_SWING, lambda f: (1, 20)),
        ("elevator_doublet", SHORT, DOUBLET, elevator_doublet),
        (
            "pitch_hold",
            ["--duration", "4"],
            HELD.format("", "from # s on"),
            lambda f: pitch_hold(f, 3),
        ),
        ("pitch_hold", SHORT, LATE, lambda f: pitch_hold(f, 3)),
        ("pitch_hold", [*SHORT, "--set", "hold.theta_ref=20"], LATE, lambda f: pitch_hold(f, 20)),
        (
            "step_response",
            SHORT,
            "y = # after # s; largest difference to the analytic curve #\n",
            step_response,
        ),
        ("van_der_pol", [], "amplitude #, period # s\n", van_der_pol),
        ("van_der_pol", SHORT, FEW, lambda f: (0, 1)),
        (
            "van_der_pol",
            ["--set", "position.initial_value=0", "--set", "velocity.initial_value=0"],
            FEW,
            lambda f: (0, 40),
        ),
    ],
)
def test_result_lines_are_true(name, options, line, values, tmp_path, capsys):
    files = "--save", str(tmp_path / "x.png"), "--csv", str(tmp_path / "x.csv")
    assert main(["run", name, *files, *options]) == 0
    printed = re.sub(".* saved: .*\n", "", capsys.readouterr().out)
    found = re.fullmatch(re.escape(line).replace(r"\#", NUMBER), printed)
    assert found, printed
    signals = pd.read_csv(tmp_path / "x.csv")
    flight = {label.partition(" [")[0]: signal.to_numpy() for label, signal in signals.items()}
    expected = values({"t": flight["time"], **flight})
    for text, value in zip(found.groups(), expected, strict=True):
        mantissa, _, exponent = text.partition("e")
        last_digit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
        assert float(text.replace(",", "")) == pytest.approx(value, abs=0.51 * last_digit), text
