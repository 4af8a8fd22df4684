# written for version 0.2.0
from pathsim_jsbsim_blocks.gym import make_env

env = make_env(
    "pitch_hold",
    action={"hold.theta_ref": (-5.0, 5.0)},
    observation=["aircraft.theta"],
    reward=lambda v: -abs(v["aircraft.theta"]),
    restart="restored",
    wired="replace",
)
env.reset(seed=1)
