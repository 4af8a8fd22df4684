"""Batches of whole diagrams."""

import functools
import json
import math
import random
import sys

import numpy as np
import pandas as pd
import plain_jsbsim
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Constant

from pathsim_jsbsim_blocks import Aircraft, FlightError, ParameterError, TrimCondition
from pathsim_jsbsim_blocks.studies import batch, run_batch


def quiet(*args, **options):
    return run_batch(*args, **{"jobs": 1, "progress": False, **options})


def pull(elevator, fuel):
    """Pitch angle of a c172p 2 s after its elevator moved."""
    step = Constant(elevator)
    # the search of the plain loop
    condition = TrimCondition(speed=90, fuel=[fuel, fuel], solver="jsbsim")
    aircraft = Aircraft("c172p", condition=condition)
    sim = Simulation(
        [step, aircraft], [Connection(step, aircraft["elevator"])], dt=1 / 120, log=False
    )
    sim.run(2.0)
    return {"pitch_deg": aircraft["theta"].get_outputs()[0], "alpha_trim_deg": aircraft.trim.alpha}


def noise(gain, seed=None):
    return {"draw": gain * random.random(), "numpy": np.random.rand(), "mine": seed}  # noqa: NPY002


def test_a_diagram_is_flown_for_every_case():
    table = quiet(pull, {"elevator": [-0.1, 0.1], "fuel": [40.0, 120.0]})
    given, found = ["elevator", "fuel"], ["pitch_deg", "alpha_trim_deg"]
    assert table.columns.tolist() == [*given, "completed", "reason", *found]
    assert table.completed.all()
    for row in table.itertuples():
        fuel = {f"propulsion/tank[{i}]/contents-lbs": row.fuel for i in (0, 1)}
        fdm = plain_jsbsim.trimmed("c172p", 5000.0, 90.0, setup=fuel)
        elevator = fdm["fcs/elevator-cmd-norm"] + row.elevator
        pitch = plain_jsbsim.fly(
            fdm, ["fcs/elevator-cmd-norm"], [[elevator]] * 240, ["attitude/theta-deg"]
        )[-1, 0]
        # the plain loop's trim differs by rounding
        assert row.pitch_deg == pytest.approx(pitch, abs=1e-6)


def test_seeds_are_recorded_and_reproduce_a_case():
    before = random.getstate()  # the caller's generator is left alone
    table = quiet(noise, {"gain": [1.0, 1.0, 1.0]}, seed=7)
    assert random.getstate() == before
    assert table.seed.nunique() == 3
    assert table.draw.nunique() == 3
    assert table.numpy.nunique() == 3
    assert table.mine.tolist() == table.seed.tolist()
    again = quiet(noise, [{"gain": 1.0, "seed": int(table.seed[1])}])
    assert again.draw[0] == table.draw[1]
    assert again.numpy[0] == table.numpy[1]
    assert quiet(noise, {"gain": [1.0] * 3}, seed=8).seed.tolist() != table.seed.tolist()


def test_a_case_that_fails_says_why_and_the_others_go_on():
    def build(speed):
        if speed == 300:
            raise FlightError("state is nan", aircraft="c172p", time=1.0, name="x", value=math.nan)
        if speed == 500:
            sys.exit("no such model")
        aircraft = Aircraft("c172p", condition=TrimCondition(speed=speed))
        return {"alpha_deg": aircraft.trim.alpha}

    table = quiet(build, {"speed": [90, 20, 300, 500, 100]})
    assert table.completed.tolist() == [True, False, False, False, True]
    assert table.reason[1].startswith("TrimError: aircraft 'c172p' does not trim at")
    assert table.reason[2:4].tolist() == ["FlightError: state is nan", "SystemExit: no such model"]
    assert table.alpha_deg.isna().tolist() == [False, True, True, True, False]


@pytest.mark.parametrize(
    ("result", "message"),
    [
        (3.0, "must return a dict"),
        *(({name: 1.0}, "is a column of the cases") for name in ("gain", "seed", "completed")),
        ({"x": b"a"}, "must be a number, text"),
        ({"\udce9": 1.0}, "can be encoded"),
        ({"x": object()}, "must be a number, text"),
    ],
)
def test_a_result_that_is_no_row_is_the_reason(result, message):
    table = quiet(lambda gain: result, {"gain": [1.0]})
    assert not table.completed[0]
    assert message in table.reason[0]


def test_a_case_edited_by_build_is_its_row_in_the_table():
    def build(widths):
        widths.append(0.0)
        return {"n": len(widths)}

    widths = [[1.0], [2.0, 3.0]]
    table = run_batch(build, {"widths": [*widths, *widths]}, jobs=1, progress=False)
    assert table.widths.tolist() == [[1.0], [2.0, 3.0], [1.0], [2.0, 3.0]]
    assert table.n.tolist() == [2, 3, 2, 3]


def test_a_batch_resumes_from_its_file(tmp_path):
    path = tmp_path / "batch.jsonl"
    table = quiet(noise, {"gain": [1.0, 2.0]}, resume=path)
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:2]))
    pd.testing.assert_frame_equal(
        quiet(noise, {"gain": [1.0, 2.0]}, resume=path), table, check_exact=True
    )
    with pytest.raises(ParameterError) as error:
        quiet(noise, {"gain": [1.0, 3.0]}, resume=path)
    assert error.value.parameter == "resume"


def test_seeds_beyond_32_bits_draw_differently():
    seeds = [0, 2**32, 2**40, 2**63, 2**64, 2**64 + 2**32, 2**200]
    table = quiet(noise, [{"gain": 1.0, "seed": seed} for seed in seeds])
    assert table.draw.nunique() == table["numpy"].nunique() == len(seeds)


@pytest.mark.parametrize(
    "values",
    [
        lambda: (x for x in (1, 2, 3)),
        lambda: {1: "a", 2: "b", 3: "c"}.keys(),
        lambda: map(int, "123"),
        lambda: np.arange(1, 4),
    ],
)
def test_an_axis_is_any_iterable(values, capsys):
    table = run_batch(shown, {"x": values(), "z": (z for z in "ab")}, jobs=1)
    assert table.y.tolist() == [1, 1, 2, 2, 3, 3]
    assert "3 x 2 = 6 cases" in capsys.readouterr().err


def shown(x, z=None):
    return {"y": x}


@pytest.mark.parametrize("text", ["\udce9", ["a", "\ud800"], {"a": "\udfff"}])
def test_a_text_that_cannot_be_encoded_costs_its_own_case(text, tmp_path):
    def build(x):
        if x == 3:
            raise ValueError("no file a\udce9")
        return {"y": text if x == 2 else "é"}

    table = quiet(build, {"x": [1, 2, 3]})
    assert table.completed.tolist() == [True, False, False]
    assert table.y[0] == "é"
    assert "can be encoded" in table.reason[1]
    assert table.reason[2] == "ValueError: no file a\\udce9"
    table.to_parquet(tmp_path / "table.parquet")


HELD = Aircraft("c172p")


def level(diagram):
    """The last pitch angle of diagram pitch_hold, and where it ends."""
    time, data = diagram.pitch.read()
    return {"pitch_deg": data[0, -1], "time_s": time[-1], "reference": diagram.hold.theta_ref}


ONE = {"gain": [1.0]}
REFERENCE = {"hold.theta_ref": [1.0]}


@pytest.mark.parametrize(
    ("build", "cases", "options", "message"),
    [
        (noise, {}, {}, "cases is empty"),
        (noise, {"gan": [1.0]}, {}, "case 0 has 'gan', which build does not take; did you mean 'g"),
        (noise, [{"gain": 1.0}, {}], {}, "case 1 does not fit build: missing .*'gain'"),
        (noise, {"gain": [math.nan]}, {}, "must be finite"),
        (noise, {"gain": b"ab"}, {}, "gain must be a number"),
        (noise, {"gain": [[bytearray(b"a")]]}, {}, r"gain\[0\] must be a number"),
        (noise, {"gain": np.array([b"a"])}, {}, "gain must be a number"),
        (noise, {"gain": ["\udce9"]}, {}, "gain must be a text that can be encoded"),
        (noise, {"gain": [1.0], "completed": [True]}, {}, "a column 'completed'"),
        (noise, pd.DataFrame({"gain": [1.0], "reason": ["a"]}), {}, "a column 'reason'"),
        (noise, {"gain": [1.0], "seed": [-1]}, {}, "seed must be at least 0"),
        (noise, ONE, {"measure": level}, "is only for a script"),
        (noise, ONE, {"duration": 1.0}, "is only for a script"),
        ("noise", ONE, {}, "no diagram or script 'noise'"),
        (3, ONE, {}, "build must be a function"),
        (dict, ONE, {}, "must be a function with known parameters"),
        (lambda gain: HELD.outputs, ONE, {}, "build cannot be sent to other processes"),
        ("pitch_hold", {"hold.theta_rf": [1]}, {"measure": level}, "did you mean 'theta_ref'"),
        ("pitch_hold", {"hld.theta_ref": [1]}, {"measure": level}, "'hld'; did you mean 'hold'"),
        ("pitch_hold", REFERENCE, {}, "measure must be a function"),
        ("pitch_hold", REFERENCE, {"measure": level, "duration": 0.0}, "duration must be greater"),
    ],
)
def test_bad_input_is_refused_before_the_work_begins(monkeypatch, build, cases, options, message):
    monkeypatch.setattr(batch, "run_parts", None)
    with pytest.raises(ParameterError, match=message):
        quiet(build, cases, **options)


def test_a_diagram_by_name_is_flown_with_other_parameters():
    cases = {"hold.theta_ref": [2.0, 4.0], "aircraft.speed": [90.0, 30.0], "DURATION": [4.0]}
    table = quiet("pitch_hold", cases, measure=level)
    assert table.columns.tolist()[:6] == [*cases, "completed", "reason", "pitch_deg"]
    assert table.completed.tolist() == [True, False, True, False]
    assert table.reason[1].startswith("TrimError")
    flown = table[table.completed]
    assert flown.pitch_deg.to_numpy() == pytest.approx([2.0, 4.0], abs=0.05)
    assert flown.reference.tolist() == [2.0, 4.0]
    assert flown.time_s.to_numpy() == pytest.approx([4.0, 4.0])


@pytest.mark.long
def test_in_other_processes_too():
    table = quiet("pitch_hold", {"hold.theta_ref": [2, 4]}, measure=level, duration=3.0, jobs=2)
    assert table.reference.tolist() == [2, 4]
    assert table.time_s.to_numpy() == pytest.approx([3.0, 3.0])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("X = 1.0; print(X)", "builds no Simulation named sim"),
        ("{build}; print(X)", "has no DURATION: give duration"),
        ("{build}; DURATION = X; sim.run(1.0)", "runs when it is imported"),
    ],
)
def test_a_script_that_cannot_be_flown_is_refused(text, said, tmp_path):
    build = "from pathsim import Simulation; X = 1.0; sim = Simulation([], [], log=False)"
    (tmp_path / "own.py").write_text(text.format(build=build))
    with pytest.raises(ParameterError, match=said):
        quiet(str(tmp_path / "own.py"), {"X": [1.0]}, measure=level)


def doubled(m, sign=1.0):
    return {"y": sign * m.Y}


def test_a_batch_of_a_script_is_resumed_for_the_same_script_only(tmp_path):
    script = tmp_path / "own.py"
    text = (
        "from pathsim import Simulation\nX = 1.0\nDURATION = 0.1\n"
        "sim = Simulation([], [], dt=0.1, log=False)\nY = 2 * X\n"
    )
    script.write_text(text)
    options = {"measure": doubled, "resume": tmp_path / "kept"}
    assert quiet(script, {"X": [1.0, 2.0]}, **options).y.tolist() == [2.0, 4.0]
    script.write_text(text.replace("2 * X", "3 * X"))
    with pytest.raises(ParameterError, match=rf"study: {tmp_path.name}/own.py is changed;"):
        quiet(script, {"X": [1.0, 2.0]}, **options)
    script.write_text(text)
    other = functools.partial(doubled, sign=-1.0)
    with pytest.raises(ParameterError) as error:
        quiet(script, {"X": [1.0, 2.0]}, **options | {"measure": other}, duration=0.2)
    assert error.value.parameter == "resume"
    assert quiet(script, {"X": [1.0, 2.0]}, **options).y.tolist() == [2.0, 4.0]


def halved(fuel, name, load):
    return {"half": [load[0] / 2, None]}


def test_lists_stay_lists_in_parquet_and_are_json_in_csv(tmp_path):
    cases = [{"fuel": [1.0, 2.5], "name": ["a"], "load": {0: 1.0}}] * 2
    table = quiet(halved, cases, resume=tmp_path / "kept")
    pd.testing.assert_frame_equal(quiet(halved, cases, resume=tmp_path / "kept"), table)
    table.to_csv(tmp_path / "table.csv")
    table.to_parquet(tmp_path / "table.parquet")
    text, kept = pd.read_csv(tmp_path / "table.csv"), pd.read_parquet(tmp_path / "table.parquet")
    expected = {"fuel": [1.0, 2.5], "name": ["a"], "load": {"0": 1.0}, "half": [0.5, None]}
    for name, value in expected.items():
        assert json.loads(text[name][1]) == value
        assert table[name][1] == value
    assert list(kept["fuel"][1]) == [1.0, 2.5]
    assert list(kept["name"][1]) == ["a"]
    assert kept["load"][1] == {"0": 1.0}
