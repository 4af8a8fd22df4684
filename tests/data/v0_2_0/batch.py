# written for version 0.2.0
from pathsim_jsbsim_blocks.studies import run_batch


def last_pitch(diagram):
    return {"theta": diagram.pitch.read()[1][0][-1]}


table = run_batch(
    "pitch_hold", {"hold.theta_ref": [2.0, 4.0]}, measure=last_pitch, jobs=1, progress=False
)
print(*table["theta"])
