# written for version 0.2.0
from pathsim_jsbsim_blocks.gym import make_env

env = make_env(
    "pitch_hold",
    action={"aircraft.elevator": (-0.3, 0.3)},
    observation=["aircraft.theta", "aircraft.q", "hold.theta_cmd"],
    reward=lambda v: -abs(v["aircraft.theta"] - v["hold.theta_cmd"]),
    step=0.1,
    duration=20,
    wired="replace",
)
env.reset(seed=1)
for _ in range(20):
    seen, reward, *_ = env.step([-0.02])
print(*seen, reward)
