"""Diagrams as environments of Gymnasium."""

import numpy as np
import pytest
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Block, Constant, Integrator, RandomNumberGenerator, Scope, WhiteNoise
from pathsim.solvers import RKCK54

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

from pathsim_jsbsim_blocks import (  # noqa: E402
    Aircraft,
    FlightError,
    ParameterError,
    PitchHold,
    Sensor,
    TrimCondition,
    TrimError,
)
from pathsim_jsbsim_blocks.gym import make_env  # noqa: E402
from pathsim_jsbsim_blocks.scripts.settings import SettingError  # noqa: E402

TASKS = ("PitchHold-v1", "HeadingInTurbulence-v0", "Approach-v0")
ELEVATOR = {"plane.elevator": (-0.3, 0.3)}
PITCH = ["plane.theta", "plane.q"]
ACTIONS = np.random.default_rng(1).uniform(-0.1, 0.1, (20, 1))


def level(values):
    return -abs(values["plane.theta"])


GIVEN = {"action": ELEVATOR, "observation": PITCH, "reward": level}


def bare(plane=None, **options):
    """A Cessna 172, or another plane, whose elevator is the action."""
    plane = plane or Aircraft("c172p", altitude=5000, speed=90)
    sim = Simulation([plane], [], dt=1 / 120, log=False)
    return make_env(sim, **{**GIVEN, "step": 0.05, **options})


def flown(env, actions=ACTIONS, **reset):
    rows = [env.reset(**reset)[0]]
    for action in actions:
        seen, _, terminated, _, _ = env.step(action)
        rows.append(seen)
        if terminated:
            break
    return np.array(rows)


@pytest.mark.parametrize("task", TASKS)
def test_gymnasium_finds_no_fault_with_the_tasks(task):
    env = gymnasium.make(f"pathsim-jsbsim/{task}")
    check_env(env.unwrapped, skip_render_check=True)


def test_the_picture_and_the_track_of_an_episode(tmp_path):
    env = gymnasium.make("pathsim-jsbsim/PitchHold-v1", render_mode="rgb_array").unwrapped
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.figure()
    flown(env, seed=1)
    picture = env.render()
    assert (picture.dtype, picture.shape[2]) == (np.uint8, 3)
    assert np.ptp(picture) > 100
    track = env.track()
    assert np.allclose(track.time, 0.1 * np.arange(21))
    assert np.array_equal(track.signals["plane.elevator"][1:], ACTIONS[:, 0])
    assert track.h[0] == pytest.approx(5000)


@pytest.mark.parametrize("sink", [lambda: Integrator(0.0), Scope], ids=["with stages", "flat"])
def test_a_step_flies_what_a_run_flies(sink):
    def diagram(*more):
        plane, hold, height = Aircraft("c172p", altitude=5000, speed=90), PitchHold(), sink()
        wires = [
            Connection(plane["theta"], hold["theta"]),
            Connection(plane["q"], hold["q"]),
            Connection(hold["elevator"], plane["elevator"]),
            Connection(plane["hdot"], height),
            *(Connection(block, hold["theta_ref"]) for block in more),
        ]
        blocks = [plane, hold, height, *more]
        return plane, hold, height, Simulation(blocks, wires, dt=1 / 120, log=False)

    command = Constant(0.0)
    plane, _, height, sim = diagram(command)
    ports, stages = [f"plane.{port}" for port in Aircraft.output_port_labels], height.engine
    expected = []
    for (reference,) in 10.0 * ACTIONS:
        command.value = reference
        sim.run(0.1)
        expected.append([*plane.outputs.to_array(), *([height.outputs[0]] if stages else [])])
    plane, hold, integral, sim = diagram()  # noqa: RUF059, names of ports
    env = make_env(
        sim,
        action={"hold.theta_ref": (-10, 10)},
        observation=[*ports, *(["integral.0"] if stages else [])],
        reward=lambda v: v["time"],
    )
    for _ in range(2):
        assert np.array_equal(flown(env, 10.0 * ACTIONS)[1:], expected)
    if not stages:
        # what is recorded is the same too
        assert np.array_equal(integral.read()[0], height.read()[0])
        assert np.array_equal(integral.read()[1], height.read()[1])


def test_a_reward_sees_the_values_of_all_ports():
    seen = []
    env = bare(reward=lambda v: seen.append(dict(v)) or 3)
    env.reset()
    _, reward, *_ = env.step([-0.1])
    assert (reward, type(reward)) == (3.0, float)
    assert seen[0] == env.values
    ports = {*Aircraft.input_port_labels, *Aircraft.output_port_labels}
    assert {*seen[0]} == {"time", *(f"plane.{port}" for port in ports)}
    assert (seen[0]["time"], seen[0]["plane.elevator"]) == (pytest.approx(0.05), -0.1)
    assert seen[0]["plane.h"] == env.simulation.blocks[0].outputs["h"]


def test_the_end_of_an_episode():
    env = bare(duration=0.17, terminated=lambda v: v["plane.theta"] > 1.5)
    env.reset()
    # it lasts at least its duration
    assert [env.step([0.0])[2:4] for _ in range(4)] == [(False, False)] * 3 + [(False, True)]
    env.reset()
    while not (last := env.step([-0.3]))[2]:
        pass
    assert last[0][0] > 1.5
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step([0.0])


@pytest.mark.parametrize(
    ("judge", "answer"),
    [
        *(("reward", x) for x in (None, "3", np.nan, -np.inf, True, [1.0], np.array([1.0, 2.0]))),
        *(("terminated", x) for x in (None, 1, "no", np.array([True, False]), np.nan)),
    ],
)
def test_an_answer_of_a_judge_that_is_none_is_refused(judge, answer):
    env = bare(**{judge: lambda v: answer})
    env.reset()
    with pytest.raises(ParameterError) as error:
        env.step([0.0])
    assert error.value.parameter == judge
    assert error.value.value is answer


@pytest.mark.parametrize("judge", ["reward", "terminated"])
def test_a_judge_that_raises_leaves_the_flight_and_its_time_limit(judge):
    def judged(values):
        calls.append(values["time"])
        if len(calls) in (3, 4, 20):
            raise ZeroDivisionError
        return False if judge == "terminated" else np.float32(0.0)

    calls = []
    env, plain = bare(duration=1.0, **{judge: judged}), bare(duration=1.0)
    env.reset()
    truncated = False
    while not truncated:
        try:
            seen, _, _, truncated, _ = env.step([0.1])
        except ZeroDivisionError:
            assert len(calls) in (3, 4, 20)
    # the twentieth step ends at the limit, but its judge has failed
    assert calls == pytest.approx([0.05 * k for k in range(1, 22)])
    assert np.array_equal(seen, flown(plain, [[0.1]] * 21)[-1])


def test_a_crash_ends_the_episode_and_the_next_is_the_same_as_ever():
    env = bare(Aircraft("c172p", altitude=300, speed=90), step=0.5, crash=-7.0)
    gentle = flown(env)
    env.reset()
    while not (last := env.step([0.3]))[2]:
        assert last[1] != -7.0
    _, reward, terminated, truncated, info = last
    assert (reward, terminated, truncated) == (-7.0, True, False)
    assert "touched the ground" in info["reason"]
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step([0.3])
    with pytest.raises(FlightError, match="reset to fly again"):
        env.simulation.run(1.0)
    assert np.array_equal(flown(env), gentle)


def test_a_second_environment_on_a_simulation_is_refused():
    plane = Aircraft("c172p", altitude=5000, speed=90)
    sim = Simulation([plane], [], dt=1 / 120, log=False)
    env = make_env(sim, step=0.05, **GIVEN)
    before = flown(env)
    for action in (ELEVATOR, {"plane.rudder": (-1, 1)}):
        with pytest.raises(ParameterError) as error:
            make_env(sim, wired="replace", step=0.05, **{**GIVEN, "action": action})
        assert error.value.parameter == "diagram"
    assert np.array_equal(flown(env), before)


def test_dt_is_changed_between_episodes_only():
    env = bare()
    env.reset()
    env.step([0.1])
    env.simulation.dt = 1 / 240
    with pytest.raises(ParameterError, match=r"dt was changed from 0\.0083.* during the episode"):
        env.step([0.1])
    env.simulation.dt = 1 / 120
    env.step([0.1])
    env.simulation.dt = 0.02
    with pytest.raises(ParameterError) as error:
        env.reset()
    assert (error.value.parameter, error.value.value) == ("step", 0.05)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step([0.1])
    env.simulation.dt = 1 / 240
    env.reset()
    env.step([0.0])
    assert env.values["time"] == pytest.approx(0.05)


def test_a_stop_in_the_diagram_ends_the_episode():
    options = {"settings": {"DECISION_HEIGHT": 1999.0}}
    env = gymnasium.make("pathsim-jsbsim/Approach-v0", **options).unwrapped
    env.reset()
    last = env.step([0.0, 0.2, -0.5])
    while not last[2]:
        last = env.step([0.0, 0.2, -0.5])
    assert 2450 < env.values["aircraft.h"] <= 2499
    assert last[4] == {}


def test_one_seed_decides_all_random_numbers():
    def noisy():
        plane, noise = Aircraft("c172p", altitude=5000, speed=90), WhiteNoise(0.05)
        gyro = Sensor(noise=1.0)
        wires = [Connection(noise, plane["aileron"]), Connection(plane["q"], gyro)]
        sim = Simulation([plane, noise, gyro], wires, dt=1 / 120, log=False)
        given = {"action": ELEVATOR, "observation": ["plane.phi", "gyro.y"], "reward": level}
        return make_env(sim, vary={"plane.speed": (80, 100)}, **given)

    env = noisy()
    first, second = flown(env, seed=5), flown(env)
    assert not np.array_equal(first, second)
    assert first[0, 1] != second[0, 1]
    for again in (env, noisy()):
        assert np.array_equal(flown(again, seed=5), first)
        assert np.array_equal(flown(again), second)


def test_what_varies():
    env = bare(
        vary={"plane.speed": (80, 100), "plane.altitude": (3000, 6000)},
        observation=["plane.vc", "plane.h"],
    )
    seen = np.array([env.reset(seed=k)[0] for k in range(4)])
    assert np.ptp(seen, axis=0).min() > 1.0
    (speed, height), info = env.reset(options={"plane.speed": 85.0})
    assert speed == pytest.approx(85, abs=1e-6)
    assert info["varied"] == {"plane.speed": 85.0, "plane.altitude": pytest.approx(height)}
    with pytest.raises(ParameterError) as error:
        env.reset(options={"plane.sped": 85.0})
    assert (error.value.parameter, error.value.value) == ("options", "plane.sped")
    with pytest.raises(ParameterError, match=r"nothing to vary: make_env\(vary=\.\.\.\)"):
        bare().reset(options={"plane.speed": 95.0})


def test_parameters_of_a_block_that_fit_each_other_only_are_set_together():
    env = bare(
        Aircraft("737", altitude=10_000, speed=340, gear=0),
        observation=["plane.h", "plane.vc"],
        vary={"plane.altitude": (10_000, 37_000), "plane.speed": (250, 340)},
    )
    # at 37,000 ft 340 KCAS are beyond its thrust
    for point in ((10_000, 340), (37_000, 250), (10_000, 340), (37_000, 250)):
        options = dict(zip(("plane.altitude", "plane.speed"), point, strict=True))
        assert env.reset(options=options)[0] == pytest.approx(point)
    with pytest.raises(TrimError):
        env.reset(options={"plane.altitude": 37_000, "plane.speed": 340})


def test_a_plain_attribute_of_a_block_is_varied():
    class Bias(Block):
        def __init__(self, value):
            super().__init__()
            self.value = value

        def update(self, t):
            self.outputs[0] = self.value

    plane, bias = Aircraft("c172p", altitude=5000, speed=90), Bias(0.1)
    sim = Simulation([plane, bias], [Connection(bias, plane["aileron"])], dt=1 / 120, log=False)
    given = {**GIVEN, "observation": ["plane.aileron"]}
    env = make_env(sim, vary={"bias.value": (0.1, 0.2)}, **given)
    assert env.reset(options={"bias.value": 0.15})[0] == 0.15


@pytest.mark.parametrize("step", [0.1, 0.05])
def test_the_pitch_task_flies_what_an_aircraft_sampled_at_120_hz_flies(step):
    env = gymnasium.make("pathsim-jsbsim/PitchHold-v1", step=step).unwrapped
    sampled = bare(step=step)
    assert np.array_equal(flown(env, seed=1)[:, :2], flown(sampled))
    # the command ramps from the pitch angle to the reference
    theta, command = flown(env, 0.0 * ACTIONS, options={"hold.theta_ref": 4.0})[:, [0, 2]].T
    assert command[0] == theta[0]
    assert 0.0 < command[1] - command[0] < 4.0 * step
    assert command[-1] == 4.0


def test_a_variable_of_a_script_is_varied_by_building_it_again(tmp_path):
    script = tmp_path / "flight.py"
    script.write_text(
        "from pathsim import Simulation\n"
        "from pathsim_jsbsim_blocks import Aircraft\n"
        "SPEED = 90.0\n"
        "plane = Aircraft('c172p', altitude=5000.0, speed=SPEED + 1.0)\n"
        "sim = Simulation([plane], [], dt=1 / 120, log=False)\n"
    )
    given = {"action": ELEVATOR, "observation": ["plane.vc"], "reward": level}
    env = make_env(script, vary={"SPEED": (80, 95)}, **given)
    for seed in range(3):
        seen, info = env.reset(seed=seed)
        assert seen[0] == pytest.approx(info["varied"]["SPEED"] + 1.0, abs=1e-6)
    env.step([0.0])
    with pytest.raises(SettingError) as error:
        make_env(script, vary={"SPED": (80, 95)}, **given)
    assert error.value.parameter == "SPED"
    assert "'SPEED'" in str(error.value)


def test_a_wire_into_an_action_is_refused_or_replaced():
    given = {
        "action": {"aircraft.elevator": (-0.3, 0.3)},
        "observation": ["aircraft.theta", "hold.elevator"],
        "reward": lambda v: 0.0,
    }
    with pytest.raises(
        ParameterError, match=r"'aircraft\.elevator' is connected already.*'replace'"
    ):
        make_env("pitch_hold", **given)
    seen = flown(make_env("pitch_hold", wired="replace", **given), 0.0 * ACTIONS)
    # trimmed controls, whatever the hold commands
    free = Aircraft("c172p", condition=TrimCondition(altitude=5000, speed=90, solver="jsbsim"))
    Simulation([free], [], dt=1 / 120, log=False).run(2.0)
    assert seen[-1, 0] == free.outputs["theta"]
    assert abs(seen[-1, 1]) > 0.01


def test_ranges_and_normalised_values():
    ranges = {"plane.theta": (1.0, 1.5), "plane.q": (-30, 30)}
    env, plain = bare(observation=ranges, normalise=True), bare()
    assert env.observation_space == gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float64)
    assert env.action_space == gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float64)
    rows, expected = flown(env, ACTIONS / 0.3), flown(plain)
    assert np.allclose(rows[:, 1] * 30, expected[:, 1], atol=1e-9)
    assert np.allclose(rows[:, 0], ((expected[:, 0] - 1.0) / 0.25 - 1.0).clip(-1, 1), atol=1e-9)
    assert rows[:, 0].max() == 1.0
    # an action beyond its range is limited to it
    assert np.array_equal(flown(plain, [[5.0]] * 5), flown(plain, [[0.3]] * 5))


def test_worker_processes_fly_what_this_one_flies():
    envs = gymnasium.make_vec("pathsim-jsbsim/PitchHold-v1", 2, vectorization_mode="async")
    try:
        seen, _ = envs.reset(seed=[3, 4])
        rows = [seen] + [envs.step(np.repeat([a], 2, axis=0))[0] for a in ACTIONS[:5]]
    finally:
        envs.close()
    for i, seed in enumerate((3, 4)):
        alone = gymnasium.make("pathsim-jsbsim/PitchHold-v1")
        assert np.array_equal(flown(alone, ACTIONS[:5], seed=seed), np.array(rows)[:, i])


@pytest.mark.parametrize(
    ("options", "parameter"),
    [
        ({"action": {"plane.theta": (-1, 1)}}, "action"),
        ({"action": {"plane.elevator": (1, -1)}}, "low"),
        ({"action": {"plane.elevator": 1.0}}, "plane.elevator"),
        ({"action": {}}, "action"),
        ({"action": {"plane.0": (-1, 1)}}, "action"),
        ({"vary": {"SPEED": (80, 90)}}, "settings"),  # of a script only
        ({"settings": {"SPEED": 3}}, "settings"),
        ({"vary": {"plane.speed": (0, np.inf)}}, "plane.speed"),
        ({"observation": "plane.theta"}, "observation"),
        ({"normalise": "no"}, "normalise"),
        ({"normalise": True}, "normalise"),  # of a value without a range
        ({"step": 0.013}, "step"),
        ({"duration": -1.0}, "duration"),
        ({"reward": 3.0}, "reward"),
        ({"wired": "yes"}, "wired"),
        ({"render_mode": "human"}, "render_mode"),
    ],
)
def test_bad_options_are_refused(options, parameter):
    with pytest.raises(ParameterError) as error:
        bare(**options)
    assert error.value.parameter == parameter


@pytest.mark.parametrize(
    ("parameter", "value", "name", "nearest"),
    [
        ("action", {"plane.elevatr": (-1, 1)}, "plane.elevatr", "plane.elevator"),
        ("observation", ["plane.pitch"], "plane.pitch", "plane.theta"),
        ("vary", {"plane.sped": (80, 90)}, "plane.sped", "plane.speed"),
    ],
)
def test_a_port_or_parameter_that_is_not_there_is_refused_naming_the_nearest(
    parameter, value, name, nearest
):
    with pytest.raises(ParameterError, match=f"did you mean '{nearest}'") as error:
        bare(**{parameter: value})
    assert (error.value.parameter, error.value.value) == (parameter, name)


@pytest.mark.parametrize("action", [[0.0, 0.0], [], [np.nan], 0.0, "up", None])
def test_bad_actions_are_refused(action):
    env = bare()
    env.reset()
    with pytest.raises(ParameterError) as error:
        env.step(action)
    assert error.value.parameter == "action"
    env.step([0.0])


def test_diagrams_that_cannot_be_environments():
    plane, dice = Aircraft("c172p", altitude=5000, speed=90), RandomNumberGenerator()
    for block in (dice, Subsystem([Interface(), dice], [])):
        random = Simulation([plane, block], [], dt=1 / 120, log=False)
        with pytest.raises(ParameterError) as error:
            make_env(random, **GIVEN)
        assert error.value.parameter == "diagram"
    adaptive = Simulation([plane], [], dt=1 / 120, Solver=RKCK54, log=False)
    with pytest.raises(ParameterError) as error:
        make_env(adaptive, **GIVEN)
    assert error.value.parameter == "diagram"
    with pytest.raises(ParameterError) as error:
        make_env("pitch_hld", **GIVEN)
    assert (error.value.parameter, error.value.value) == ("name", "pitch_hld")
    assert "'pitch_hold'" in str(error.value)
    del plane
    with pytest.raises(ParameterError, match="or of the caller of make_env"):
        make_env(Simulation([Aircraft()], [], dt=1 / 120, log=False), **GIVEN)


def test_a_refused_environment_leaves_the_simulation_as_it_was():
    plane, still, hold = Aircraft("c172p", altitude=5000, speed=90), Constant(0.0), PitchHold()
    alias = plane  # noqa: F841  # another name of the same block
    wires = [
        Connection(still, plane["rudder"], hold["theta"]),
        Connection(plane["q"], hold["q"]),
        Connection(hold["elevator"], plane["aileron"]),
    ]
    sim = Simulation([plane, still, hold], wires, dt=1 / 120, log=False)
    given = {"observation": PITCH, "reward": level}
    for options in (
        {"action": {**ELEVATOR, "plane.rudder": (-1, 1)}},
        {"action": ELEVATOR, "step": 0.013},
        {"action": ELEVATOR, "normalise": True},
        {"action": {"plane.rudder": (-1, 1), "alias.rudder": (-1, 1)}, "wired": "replace"},
    ):
        with pytest.raises(ParameterError):
            make_env(sim, **options, **given)
        assert [*sim.connections] == wires
        assert len(sim.blocks) == 3
    flown(make_env(sim, action={"plane.rudder": (-1, 1)}, wired="replace", **given))
    assert hold.inputs["theta"] == 0.0


def test_a_reset_that_fails_ends_the_episode():
    env = bare(vary={"plane.speed": (80, 100)})
    first = flown(env, seed=1)
    with pytest.raises(TrimError):
        env.reset(options={"plane.speed": 5.0})
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step([0.0])
    assert np.array_equal(flown(env, seed=1), first)
