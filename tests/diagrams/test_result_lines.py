"""Result lines are true, however short the flight is: each number is taken from the CSV again.

A line that matches none of its diagram's templates fails, so that no claim goes unchecked.
"""

import csv
import math
import re
from pathlib import Path

import numpy as np
import pytest

from pathsim_jsbsim_blocks import check_cases
from pathsim_jsbsim_blocks.catalogue import diagram_names
from pathsim_jsbsim_blocks.cli import main

README = ("damped_oscillator", "step_response", "van_der_pol", "elevator_doublet", "pitch_hold")
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


def settled(label, target):
    return lambda f: (f[label], target)


def oscillator(f):
    back = crossings(f.time, f["velocity v"])
    swing = f["position x"][f.time <= back[0]].min() if back else math.nan
    return swing, -math.exp(-0.25 * math.pi / math.sqrt(1 - 0.25**2)), 0.25


def van_der_pol(f):
    up = crossings(f.time, f["position x"])
    late = np.abs(f["position x"][f.time > up[-4]]) if len(up) > 3 else [math.nan]
    return max(late), (up[-1] - up[-4]) / 3 if len(up) > 3 else math.nan


def touchdown(f):
    wheels = f["wheels on the ground"]
    i = next((i for i, value in enumerate(wheels) if value), None)
    if i is None:
        return [math.nan] * 8
    signals = "right of the centre line", "calibrated airspeed", "pitch angle", "bank", "heading"
    across, vc, theta, phi, psi = (f[name][i] for name in signals)
    past = 8000.0 - f["distance to the antenna"][i]
    return f.time[i], past, across, -f["rate of climb"][i - 1], vc, theta, phi, psi


def landed(f):
    return (
        8000.0 - f["distance to the antenna"][-1],
        f["right of the centre line"][-1],
        f["calibrated airspeed"][-1],
    )


LANDING = {
    "touchdown after # s, # ft past the aiming point and # ft right of the centre line, sinking at "
    "# ft/s, at # KCAS; pitch # deg, bank # deg, heading # deg": touchdown,
    "no touchdown by the end": lambda f: [] if not f["wheels on the ground"].any() else [0],
    "at the end # ft past the aiming point and # ft right, at # KCAS": landed,
}


def decision(f):
    of_path = f["cross-track error"][-1], f["above the glide path"][-1]
    flight = (f[name][-1] for name in ("calibrated airspeed", "heading", "course over the ground"))
    return f.end, f["distance to the threshold"][-1], *of_path, *flight


def final(f):
    near = f["distance to the threshold"] < 5 * 6076.12
    apart = f["cross-track error"], f["above the glide path"]
    return [5, *(np.abs(x[near]).max() if near.any() else math.nan for x in apart)]


def mission(f):
    start = f.end - 20.0
    signals = "altitude", "heading", "calibrated airspeed"
    commands = (
        10000.0 + 1500.0 * (f.end >= 20.0) - 500.0 * (f.end >= 180.0),
        90.0 + 60.0 * (f.end >= 60.0),
        280.0 + 15.0 * (f.end >= 130.0),
    )
    first = next(t for t in f.time if t > start)
    pairs = zip(signals, commands, strict=True)
    return [first, *(x for name, command in pairs for x in (*f.span(name, start), command))]


def sideslip(gain):
    def numbers(f):
        beta = f[f"sideslip angle, gain {gain}"]
        start = f.until(5.0)
        return gain, np.abs(beta).max(), start, np.abs(beta - beta[-1])[f.time > start].max()

    return numbers


def ride(label, first, nz):
    def numbers(f):
        start = f.until(5.0)
        n = f[nz][f.time > start]
        return min(f[first]), max(f[first]), start, n.std(), n.min(), n.max()

    return {
        f"{label}: altitude from # to # ft, nz after # s # g rms, from # to #": numbers,
    }


def raised(column):
    return lambda f: (f[column] - f[column][0], 5.0)


def fleet(name):
    def numbers(f):
        y = f[name] - f[name][0]
        return y.max(), y[-1]

    return numbers


def peak(label, sign=1):
    return lambda f: (sign * max(sign * f[label]), f.time[(sign * f[label]).argmax()])


def headwind(f):
    return -min(f["tailwind"]), f.time[f["tailwind"].argmin()]


def f_factor(f):
    lost = np.gradient(f["tailwind"], f.time) / 32.174 + f["downdraft"] / f["true airspeed"]
    return lost.max(), f.time[lost.argmax()]


def damping(f):
    ratios = []
    for name in ("bare", "damped"):
        y = f[f"sideslip angle, {name}"][f.time > 1.5]
        turns = [b for a, b, c in zip(y, y[1:], y[2:], strict=False) if (b - a) * (c - b) < 0]
        if len(turns) < 3:
            return math.nan, math.nan
        decrement = math.log(abs((turns[0] - turns[1]) / (turns[1] - turns[2]))) / math.pi
        ratios.append(decrement / math.hypot(1.0, decrement))
    return ratios


def left(f):
    start = f.until(4.0)
    late = [np.abs(f[f"yaw rate, {x}"][f.time > start]).max() for x in ("bare", "damped")]
    return start, *late


def air(f):
    """The line of the sample nearest to each altitude, in order."""
    near = {int(np.abs(f["altitude"] - 1000 * km).argmin()) for km in (0, 11, 20, 50, 80)}
    for i in sorted(near):
        temperature = f["temperature"][i] - 273.15
        yield (
            f["altitude"][i] / 1000,
            f["pressure"][i],
            f["density"][i],
            temperature,
            f["speed of sound"][i],
        )


def stall(name):
    def numbers(f):
        vc, h = f[f"airspeed, {name}"], f[f"altitude, {name}"]
        return vc.min(), vc[-1], max(f[f"angle of attack, {name}"]), h.min(), h.max()

    return numbers


# template of a line, with # for a number and @ for a settling time -> its numbers (what settles:
# the signal and the target) as the recorded signals give them; None: no signal is claimed
SIGNALS = {
    "aileron_turn": {
        "roll angle # deg after # s, # deg after # s; altitude lost # ft": lambda f: (
            f.at("roll angle", 5.0),
            min(5.0, f.end),
            f["roll angle"][-1],
            f.end,
            f["altitude"][0] - f["altitude"][-1],
        )
    },
    "airspeed_hold": {
        "calibrated airspeed @; altitude # to # ft": lambda f: (
            f["calibrated airspeed"],
            *f.span("altitude"),
        )
    },
    "altitude_hold": {
        "altitude @, at most # ft; airspeed # to # KCAS": lambda f: (
            f["altitude"],
            max(f["altitude"]),
            *f.span("calibrated airspeed"),
        )
    },
    "approach_737": {
        "passed the line by # ft": lambda f: [max(-min(f["cross-track error"]), 0.0)],
        "from # nmi on within # ft of it and # ft of the path": final,
        "at the decision height after # s, # ft before the threshold: # ft beside the line, # ft "
        "above the glide path, # KCAS, heading # deg, course # deg": lambda f: (
            decision(f) if f["altitude"][-1] <= 700.0 else [math.nan] * 7
        ),
        "above the decision height after # s, # ft before the threshold: # ft beside the line, "
        "# ft above the glide path, # KCAS, heading # deg, course # deg": lambda f: (
            decision(f) if f["altitude"][-1] > 700.0 else [math.nan] * 7
        ),
    },
    "autoland_737": LANDING,
    "autoland_c172p": LANDING,
    "autopilot_mission": {
        "from # s on, with the commands of the end in brackets: altitude # to # ft (#), heading "
        "# to # deg (#), airspeed # to # KCAS (#)": mission
    },
    "constant_cas_climb": {
        # the crossover altitude is computed: that of the notebooks' table
        "crossover altitude # ft; # KTAS, Mach # at # ft; # KTAS, Mach # at # ft": lambda f: (
            32310,
            *(f[x][np.abs(f["altitude"] - 1e4).argmin()] for x in ("TAS", "Mach number")),
            f["altitude"][np.abs(f["altitude"] - 1e4).argmin()],
            *(f[x][-1] for x in ("TAS", "Mach number", "altitude")),
        ),
        r"altitude [ft]  CAS [kt]  TAS [kt]  TAS/CAS": None,
        r"#    #    #    #": None,
    },
    "damped_oscillator": {
        "first swing to # (analytic # from x = 1 with zeta = #)": oscillator,
        "the first swing is not over by the end": lambda f: (
            [0.0] * (not math.isnan(oscillator(f)[0]))
        ),
        "x = # after # s": lambda f: (f["position x"][-1], f.end),
    },
    "doublet_linear_nonlinear": {
        "angle of attack from # to # deg; the linear model is at most # deg from it": lambda f: (
            *f.span("angle of attack, nonlinear"),
            max(abs(f["difference in angle of attack"])),
        )
    },
    "dutch_roll": {
        f"gain {gain}: sideslip up to # deg, after # s # deg from its last value at most": (
            lambda f, gain=gain: sideslip(gain)(f)[1:]
        )
        for gain in (0, 1, 2)
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
    "f16_autopilot": {
        "bank up to # deg, heading at the end # deg": lambda f: (
            max(f["roll angle"]),
            f["heading"][-1],
        )
    },
    "fixed_trim_climb": {
        "# ft after # s, at # KCAS, flight path angle # deg": lambda f: (
            f["altitude"][-1],
            f.end,
            f["calibrated airspeed"][-1],
            f["flight path angle"][-1],
        )
    },
    "fleet_pitch_hold": {
        f"{name}: @, at most # deg, # deg at the end": (
            lambda f, name=name: (raised(name)(f)[0], *fleet(name)(f))
        )
        for name in ("c172p", "737", "global5000", "A320", "B747", "T38")
    },
    "gust_response": {
        # gusts by the table of CS 25.341 at 10,000 ft
        f"{gradient} ft, # ft/s: nz from # to # in # s": (
            lambda f, i=i, peak=peak: (peak, min(f[6 + i]), max(f[6 + i]), f.end)
        )
        for i, (gradient, peak) in enumerate(
            {30: 37.1, 90: 44.5, 150: 48.5, 200: 50.9, 350: 55.9}.items()
        )
    },
    "heading_hold": {
        "heading # deg, @, at most # deg; altitude # to # ft": lambda f: (
            f["heading"][-1],
            f["heading"],
            max(f["heading"]),
            *f.span("altitude"),
        )
    },
    "hello_jsbsim": {
        "JSBSim .*, PathSim .*, # s a step": lambda f: [1 / 120],
        # of the notebook
        "throttle +# %": lambda f: [62.157],
        "pitch trim +# %": lambda f: [5.2799],
        "alpha +# deg": lambda f: [2.53],
        "roll angle +# deg": lambda f: [f["roll angle"][0]],
        "airspeed +# KTAS": lambda f: [f["true airspeed"][0] * 0.3048 * 3600 / 1852],
        "after # s: altitude # ft, pitch # deg, heading # deg": lambda f: (
            f.end,
            *(f[name][-1] for name in ("altitude", "pitch angle", "heading")),
        ),
    },
    "isa_profile": {"# km: +# Pa +# kg/m3 +# degC +# m/s": air},
    "microburst_approach": {
        "headwind up to # ft/s, at # s": headwind,
        "downdraft up to # ft/s, at # s": peak("downdraft"),
        "tailwind up to # ft/s, at # s": peak("tailwind"),
        "F-factor up to #, at # s": f_factor,
        r"airspeed # to # KCAS, throttle up to \+#; # ft below the approach in still air, # ft above "
        "the ground": lambda f: (
            *f.span("calibrated airspeed"),
            max(f["throttle increment"]),
            f["altitude in still air"][-1] - f["altitude"][-1],
            f["altitude"][-1],
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
    "pitch_hold_primitives": {
        "pitch angle # deg after # s, @, at most # deg": lambda f: (
            f["pitch angle"][-1],
            f.end,
            f["pitch angle"],
            max(f["pitch angle"]),
        )
    },
    "rudder_kick": {
        "sideslip angle at most # deg, at # s; # deg after # s": lambda f: (
            *peak("sideslip angle")(f),
            f["sideslip angle"][-1],
            f.end,
        ),
        "roll angle # deg, heading # deg": lambda f: (f["roll angle"][-1], f["heading"][-1]),
    },
    "stall_protection": {
        f"{name}: # kt at the least, # kt at the end; alpha at most # deg; altitude # to # ft": (
            stall(name)
        )
        for name in ("alpha wired", "alpha not wired")
    },
    "step_response": {
        "y = # after # s; largest difference to the analytic curve #": lambda f: (
            f.at("response y", 2.0),
            min(2.0, f.end),
            max(abs(f["response y"] - f["analytic"])),
        )
    },
    "trimmed_flight": {
        "altitude # to # ft, airspeed # to # KCAS, heading # deg after # s": lambda f: (
            *f.span("altitude"),
            *f.span("calibrated airspeed"),
            f["heading"][-1],
            f.end,
        )
    },
    "turbulence_rides": {
        **ride("controls fixed", 1, 3),
        **ride("autopilot", 2, 4),
        "vertical velocity of the air: # ft/s rms": lambda f: [
            math.sqrt(np.mean(f["downward velocity"] ** 2))
        ],
    },
    "van_der_pol": {
        "amplitude #, period # s": van_der_pol,
        "too few cycles for a period: # in # s": lambda f: (
            n if (n := len(crossings(f.time, f["position x"]))) < 4 else math.nan,
            f.end,
        ),
    },
    "wind_to_body": {
        "alpha from # to # deg, beta from # to # deg, lift from # to # lbf": lambda f: (
            *f.span("angle of attack"),
            *f.span("sideslip angle"),
            *f.span(5),
        ),
        "largest difference from JSBSim's forces, there and back: # lbf": lambda f: [
            max(max(abs(f[i])) for i in range(9, 15))
        ],
    },
    "yaw_damper": {
        "yaw rate after # s: at most # deg/s bare, # deg/s damped": left,
        "damping ratio of the Dutch roll # and #": damping,
        "no Dutch roll to measure by the end": lambda f: [0.0] * (not math.isnan(damping(f)[0])),
    },
}
SIGNALS["scheduled_climb"] = SIGNALS["fixed_trim_climb"]


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


def check_reference(name, lines, flight):
    """The headline of a check case tells how far it went, and its first row is the altitude's."""
    until, end = map(float, re.findall(r", until (\S+) s of (\S+) s$", lines[0])[0])
    number = name.removeprefix("check_case_")
    path = Path(check_cases.__file__).parent / "data" / f"nesc_{number}.csv"
    with path.open(newline="") as file:
        rows = [(float(r["time_s"]), float(r["altitude_ft"])) for r in csv.DictReader(file)]
    assert end == rows[-1][0]
    assert until == max(t for t, _ in rows if t <= flight.end + 1e-6)
    worst = max(abs(flight.at("altitude", t) - h) for t, h in rows if t <= until)
    text = re.match(r"  altitude +ft +(\S+)", lines[3])[1]
    assert float(text) == pytest.approx(worst, rel=0.06, abs=1e-8)  # two digits
    assert all(line.endswith("pass") for line in lines[3:])


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
    if name.startswith("check_case"):
        check_reference(name, lines, flight)
        return
    series = {}
    for line in lines:
        for template, numbers in SIGNALS[name].items():
            if found := re.fullmatch(pattern(template), line.strip()):
                if numbers is air:
                    series.setdefault(template, []).append(found.groups())
                elif numbers is not None:
                    check_line(flight, template, found.groups(), numbers(flight))
                break
        else:
            pytest.fail(f"unchecked: {line}")
    for template, rows in series.items():
        for groups, expected in zip(rows, air(flight), strict=True):
            check_line(flight, template, groups, expected)


@pytest.mark.parametrize("name", README)
def test_result_lines_of_a_second_are_true(tmp_path, capsys, name):
    check(tmp_path, capsys, name, "--duration", "1")


@pytest.mark.long
@pytest.mark.parametrize("duration", ["0.05", "1", "6"])
@pytest.mark.parametrize("name", diagram_names())
def test_all_result_lines_are_true(tmp_path, capsys, name, duration):
    if name.endswith("_climb") and duration == "0.05":
        pytest.skip("its scopes record each second")
    check(tmp_path, capsys, name, "--duration", duration)


# something that a result line tells of does not happen, or at another time
OTHERWISE = {
    "pitch_hold": ["hold.theta_ref=20"],
    "airspeed_hold": ["faster.tau=30", "aircraft.speed=100", "faster.amplitude=0"],
    "altitude_hold": ["higher.amplitude=0"],
    "heading_hold": ["heading_hold.psi_ref=30"],
    "van_der_pol": ["position.initial_value=0", "velocity.initial_value=0"],
    "yaw_damper": ["pulse.amplitude=[0, 0]"],
    "fleet_pitch_hold": ["step.amplitude=10"],
    "damped_oscillator": ["stiffness.gain=0"],
    "autoland_c172p": ["go_around.value=1"],
    "aileron_turn": ["fdm.trim_altitude=4000"],
}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n in README else pytest.mark.long) for n in OTHERWISE]
)
def test_what_does_not_happen_is_not_claimed(tmp_path, capsys, name):
    options = [x for setting in OTHERWISE[name] for x in ("--set", setting)]
    check(tmp_path, capsys, name, "--duration", "8", *options)
