"""Learn a pitch hold by an evolution strategy and draw it beside ``PitchHold``.

    python docs/learned_pitch_hold.py [GENERATIONS]

Two processes learn; 20 generations take a minute on two cores. It writes
``docs/pictures/learned_pitch_hold.png`` and prints what `docs/reinforcement-learning.md` says.
"""

import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from pathsim_jsbsim_blocks import fly
from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.design.requirements import STEP_REQUIREMENTS
from pathsim_jsbsim_blocks.design.search import step_quality
from pathsim_jsbsim_blocks.gym import make_env

GENERATIONS = 20
# flights of a generation, and the best of them, from which the next one is drawn
FLIGHTS, BEST = 16, 4
PICTURE = Path(__file__).parent / "pictures" / "learned_pitch_hold.png"
STEP, DURATION = 0.05, 10.0  # s
# error of the pitch angle, its integral and the pitch rate, in deg and s, to the elevator
SCALE = np.array([0.05, 0.05, 0.02])


def environment():
    return make_env(
        "pitch_hold",
        action={"aircraft.elevator": (-0.5, 0.5)},
        observation=["aircraft.theta", "aircraft.q", "hold.theta_cmd"],
        reward=lambda v: -abs(v["aircraft.theta"] - v["hold.theta_cmd"]),
        step=STEP,
        duration=DURATION,
        vary={"hold.theta_ref": (-2.0, 6.0)},
        wired="replace",
        crash=-1000.0,
    )


def policy(weights):
    """A law with an integral, from observation to action, for one episode."""
    integral = 0.0

    def act(seen):
        nonlocal integral
        theta, q, command = seen
        integral += STEP * (command - theta)
        return [-float((weights * SCALE) @ [command - theta, integral, -q])]

    return act


def episode(env, weights, reference):
    """Time, pitch angle and command of an episode, and the sum of its rewards."""
    seen, _ = env.reset(options={"hold.theta_ref": reference})
    act, rows, total, over = policy(weights), [[0.0, seen[0], seen[2]]], 0.0, False
    while not over:
        seen, reward, terminated, truncated, _ = env.step(act(seen))
        total += reward
        over = terminated or truncated
        rows.append([env.values["time"], seen[0], seen[2]])
    return np.array(rows).T, total


def worth(weights):
    """What a law earns, up and down."""
    global _env
    _env = globals().get("_env") or environment()
    return sum(episode(_env, weights, reference)[1] for reference in (6.0, -2.0))


def learn(generations, jobs=2, seed=1):
    """The weights, and the best reward of each generation."""
    rng, mean, spread, history = np.random.default_rng(seed), np.zeros(3), np.ones(3), []
    with ProcessPoolExecutor(jobs) as pool:
        for _ in range(generations):
            drawn = mean + spread * rng.standard_normal((FLIGHTS, len(mean)))
            earned = np.array(list(pool.map(worth, drawn, chunksize=FLIGHTS // jobs)))
            best = drawn[np.argsort(earned)[-BEST:]]
            # the spread follows the best ones, which lie further out while the mean still moves
            spread = 0.5 * spread + 0.5 * np.sqrt(((best - mean) ** 2).mean(axis=0))
            mean = best.mean(axis=0)
            history.append(earned.max())
    return mean, history


def held(reference):
    """The same flight with the diagram's own hold."""
    diagram = load_diagram("pitch_hold", {"hold.theta_ref": reference})
    fly(diagram.sim, DURATION, progress=False)
    time, (theta, command, _) = diagram.pitch.read()
    return np.array([time, theta, command])


def main(generations=GENERATIONS):
    start = time.perf_counter()
    weights, history = learn(int(generations))
    print(f"{len(history)} generations in {time.perf_counter() - start:.0f} s: {weights * SCALE}")
    wanted = STEP_REQUIREMENTS["pitch"]
    reference = load_diagram("pitch_hold").aircraft.trim.theta + wanted.size
    learned, usual = episode(environment(), weights, reference)[0], held(reference)
    drawing, (above, below) = plt.subplots(2, 1, layout="constrained", figsize=(9, 7))
    for name, (t, theta, _), color in (("learned", learned, "C1"), ("PitchHold", usual, "C0")):
        settling, overshoot, _ = step_quality(theta - reference, wanted.tolerance, t[1])
        final = np.abs(theta - reference)[t >= 0.9 * DURATION].max()
        print(
            f"{name}: within {wanted.tolerance:g} deg after {settling:.2f} s, overshoot "
            f"{overshoot:.3f} deg, error at the end {final:.3f} deg"
        )
        label = f"{name}: settled after {settling:.1f} s, overshoot {overshoot:.2f} deg"
        above.plot(t, theta, color, label=label)
    above.plot(usual[0], usual[2], "k:", linewidth=1.0, label="command of PitchHold")
    above.axhspan(reference - wanted.tolerance, reference + wanted.tolerance, color="0.92")
    above.set(xlabel="time [s]", ylabel="pitch angle [deg]", xlim=(0.0, DURATION))
    below.plot(1 + np.arange(len(history)), -np.array(history) * STEP / 2, "C1.-")
    below.set(xlabel="generation", ylabel="error of the best law [deg s]", ylim=(0.0, None))
    below.xaxis.set_major_locator(plt.MaxNLocator(integer=True))
    above.legend(loc="lower right", fontsize="small")
    for ax in (above, below):
        ax.grid(alpha=0.4)
    drawing.suptitle("c172p, 5000 ft, 90 KCAS: a step of the pitch angle")
    drawing.savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    main(*sys.argv[1:])
