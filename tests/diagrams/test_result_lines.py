"""Result lines are true, however short the flight is: each number is taken from the CSV again.

A line that matches none of its diagram's templates fails, so that no claim goes unchecked.
"""

import csv
import math
import re

import numpy as np
import pytest

from pathsim_jsbsim_blocks.cli import main

NUMBER = r"(-?[\d,]+(?:\.\d+)?(?:e[+-]\d+)?)"
SETTLING = r"(?:not )?within \S+ \S+ of \S+ \S+ (?:by the end|from \S+ s on|\S+ s after t = \S+ s)"


class Flight:
    """The signals of one run, by label or by number, without the samples that a scope left out."""

    def __init__(self, path):
        with path.open(newline="") as file:
            self.labels, *rows = csv.reader(file)
        self.columns = [[float(x or "nan") for x in column] for column in zip(*rows, strict=True)]
        self.time = np.array(self.columns[0])
        self.end = self.time[-1]

    def __getitem__(self, label):
        label = label if isinstance(label, int) else self._index(label)
        values = np.array(self.columns[label])
        return values[~np.isnan(values)]

    def _index(self, label):
        (found,) = [i for i, name in enumerate(self.labels) if name.partition(" [")[0] == label]
        return found

    def at(self, label, time):
        return self[label][np.abs(self.time - time).argmin()]

    def span(self, label, start=-1.0):
        values = self[label][self.time > start]
        return values.min(), values.max()

    def until(self, most):
        return min(most, self.end / 2)


def digits(text):
    """Half a unit of the last digit of a printed number."""
    mantissa, _, exponent = text.partition("e")
    return 0.51 * 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def check_settling(claim, time, y):
    """A settling time holds from there on, and not for a sample before it."""
    tolerance, target = (float(x) for x in re.findall(r"within (\S+) \S+ of (\S+) ", claim)[0])
    if claim.startswith("not"):
        assert abs(y[-1] - target) > tolerance, claim
        return
    first = sum(
        float(x) for x in re.findall(r"(?:from|t =) (\S+) s|(\S+) s after", claim) for x in x if x
    )
    inside = [abs(value - target) <= tolerance for value in y]
    assert all(i for i, t in zip(inside, time, strict=True) if t > first + 0.051), claim
    before = [i for i, t in zip(inside, time, strict=True) if t < first - 0.051]
    assert not before or not before[-1], claim


def crossings(time, y):
    """Times of the samples after an upward crossing of 0."""
    return [t for a, b, t in zip(y, y[1:], time[1:], strict=False) if a < 0.0 <= b]


def oscillator(f):
    back = crossings(f.time, f["velocity v"])
    swing = f["position x"][f.time <= back[0]].min() if back else math.nan
    return swing, -math.exp(-0.25 * math.pi / math.sqrt(1 - 0.25**2)), 0.25


def van_der_pol(f):
    up = crossings(f.time, f["position x"])
    late = np.abs(f["position x"][f.time > up[-4]]) if len(up) > 3 else [math.nan]
    return max(late), (up[-1] - up[-4]) / 3 if len(up) > 3 else math.nan


def left(f):
    start = f.until(4.0)
    late = [np.abs(f[f"yaw rate, {x}"][f.time > start]).max() for x in ("bare", "damped")]
    return start, *late


# template of a line, with # for a number and @ for a settling time -> its numbers (what settles:
# the signal and the target) as the recorded signals give them; None: no signal is claimed
SIGNALS = {
    "damped_oscillator": {
        "first swing to # (analytic # from x = 1 with zeta = #)": oscillator,
        "the first swing is not over by the end": lambda f: (
            [0.0] * (not math.isnan(oscillator(f)[0]))
        ),
        "x = # after # s": lambda f: (f["position x"][-1], f.end),
    },
    "elevator_doublet": {
        # of the notebook
        "weight # lb, empty # lb, CG at x = # in": lambda f: (67967, 48235, 790.8),
        "trimmed: alpha # deg, elevator # deg (# of its travel), throttle #": lambda f: (
            f["angle of attack"][0],
            -2.9634,
            -0.147775,
            0.772610,
        ),
        "alpha from # to # deg, # deg after # s": lambda f: (
            *f.span("angle of attack"),
            f["angle of attack"][-1],
            f.end,
        ),
    },
    "pitch_hold": {
        "pitch angle # deg after # s, @, at most # deg; climbed # ft, # KCAS": lambda f: (
            f["pitch angle"][-1],
            f.end,
            f["pitch angle"],
            max(f["pitch angle"]),
            f["altitude"][-1] - f["altitude"][0],
            f["calibrated airspeed"][-1],
        )
    },
    "step_response": {
        "y = # after # s; largest difference to the analytic curve #": lambda f: (
            f.at("response y", 2.0),
            min(2.0, f.end),
            max(abs(f["response y"] - f["analytic"])),
        )
    },
    "van_der_pol": {
        "amplitude #, period # s": van_der_pol,
        "too few cycles for a period: # in # s": lambda f: (
            n if (n := len(crossings(f.time, f["position x"]))) < 4 else math.nan,
            f.end,
        ),
    },
}


def pattern(template):
    plain = template if ".*" in template or "+" in template else re.escape(template)
    plain = plain.replace(r"\#", "#").replace(r"\ ", " ")
    return re.sub(" {3,}", " +", plain).replace("#", NUMBER).replace("@", f"({SETTLING})")


def check_line(flight, template, groups, expected):
    assert len(groups) == len(expected), template
    for text, value in zip(groups, expected, strict=True):
        if "within" in text:
            check_settling(text, flight.time, value)
        else:
            number = text.replace(",", "")
            assert float(number) == pytest.approx(value, abs=digits(number)), (template, text)


def result_lines(tmp_path, capsys, name, *options):
    files = "--save", str(tmp_path / "x.png"), "--csv", str(tmp_path / "x.csv")
    assert main(["run", name, *files, *options]) == 0
    out = capsys.readouterr()
    assert "Traceback" not in out.err
    lines = [x.rstrip() for x in out.out.splitlines() if " saved: " not in x]
    return lines, Flight(tmp_path / "x.csv")


def check(tmp_path, capsys, name, *options):
    lines, flight = result_lines(tmp_path, capsys, name, *options)
    assert lines
    for line in lines:
        for template, numbers in SIGNALS[name].items():
            if found := re.fullmatch(pattern(template), line.strip()):
                check_line(flight, template, found.groups(), numbers(flight))
                break
        else:
            pytest.fail(f"unchecked: {line}")


@pytest.mark.parametrize("name", SIGNALS)
def test_result_lines_of_a_second_are_true(tmp_path, capsys, name):
    check(tmp_path, capsys, name, "--duration", "1")


# something that a result line tells of does not happen, or at another time
OTHERWISE = {
    "pitch_hold": ["hold.theta_ref=20"],
    "van_der_pol": ["position.initial_value=0", "velocity.initial_value=0"],
    "damped_oscillator": ["stiffness.gain=0"],
}


@pytest.mark.parametrize("name", OTHERWISE)
def test_what_does_not_happen_is_not_claimed(tmp_path, capsys, name):
    options = [x for setting in OTHERWISE[name] for x in ("--set", setting)]
    check(tmp_path, capsys, name, "--duration", "8", *options)
