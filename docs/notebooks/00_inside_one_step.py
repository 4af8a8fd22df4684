# %% [markdown]
# # 0. Inside one step
#
# *Aim:* to say what a flight dynamics model computes in one step, and what a block diagram adds. *Assumed:* Newton's laws,
# Euler angles, NumPy. *Time:* 30 minutes.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# [JSBSim](https://github.com/JSBSim-Team/jsbsim) is a flight dynamics model in C++, with six degrees of freedom. It contains no aircraft: all
# data, from lift tables to landing gear, are read from XML files. FlightGear and many research simulators use it.
#
# [PathSim](https://github.com/pathsim/pathsim) simulates block diagrams. To a script that calls JSBSim in a loop it adds your own
# controllers, sensors and continuous dynamics, each at its own rate, and scopes and an editor.
#
# ## The equations of motion
#
# JSBSim sums the forces $F$ and moments $M$ in body axes. With the mass $m$, the inertia $I$, the velocity $v$ and the rates
# $\omega$:
#
# $$\dot v = \frac{F}{m} + g - \omega \times v$$
#
# $$\dot\omega = I^{-1}\left(M - \omega \times I\omega\right)$$
#
# $$\dot\phi = p + \tan\theta\,(q\sin\phi + r\cos\phi)$$
#
# $$\dot\theta = q\cos\phi - r\sin\phi, \qquad \dot\psi = (q\sin\phi + r\cos\phi)/\cos\theta$$
#
# A Cessna 172, trimmed by JSBSim alone:

# %%
import jsbsim
import numpy as np


def trimmed():
    jsbsim.FGJSBBase().debug_lvl = 0  # no messages
    fdm = jsbsim.FGFDMExec(None)
    fdm.load_model("c172p")
    fdm["ic/h-sl-ft"], fdm["ic/vc-kts"] = 5000.0, 90.0
    fdm["propulsion/set-running"] = -1
    fdm.run_ic()
    fdm.do_trim(1)
    return fdm


fdm = trimmed()


def read(*names):
    return np.array([fdm[name] for name in names])


# %% [markdown]
# The forces along the body's x axis, in lbf. In trim they balance:

# %%
for part in ("aero", "prop", "weight"):
    print(f"{part:<7}{fdm[f'forces/fbx-{part}-lbs']:9.2f}")
total = fdm["forces/fbx-total-lbs"] + fdm["forces/fbx-weight-lbs"]
print(f"sum    {total:9.2f}")

# %% [markdown]
# **Predict.** The nose is 1.3 deg above the horizon, and the aircraft weighs 1880 lbf. How large is the component of its weight along x, and what
# is its sign? The next cell has the answer.

# %%
theta = np.radians(fdm["attitude/theta-deg"])
print(f"{-fdm['inertia/weight-lbs'] * np.sin(theta):.2f} lbf")

# %% [markdown]
# ## One second, twice
#
# The elevator command moves by -0.05, and JSBSim flies for one second. Beside it NumPy integrates the equations
# above by Euler's method, with the forces and moments that JSBSim computes.

# %%
ixy, ixz, iyz = -read(
    *(f"inertia/i{a}-slugs_ft2" for a in ("xy", "xz", "yz"))
)
ixx, iyy, izz = read(
    *(f"inertia/i{a}-slugs_ft2" for a in ("xx", "yy", "zz"))
)
inertia = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
mass, dt = fdm["inertia/mass-slugs"], fdm.get_delta_t()


def state():
    """Velocity in ft/s, rates in rad/s, Euler angles in rad."""
    v = read(*(f"velocities/{x}-fps" for x in "uvw"))
    w = read(*(f"velocities/{x}-rad_sec" for x in "pqr"))
    angles = read(*(f"attitude/{x}-rad" for x in ("phi", "theta", "psi")))
    return v, w, angles


def derivatives(v, w, angles):
    phi, theta, _ = angles
    p, q, r = w
    force = read(*(f"forces/fb{x}-total-lbs" for x in "xyz"))
    moment = read(*(f"moments/{x}-total-lbsft" for x in "lmn"))
    down = [
        -np.sin(theta),
        np.sin(phi) * np.cos(theta),
        np.cos(phi) * np.cos(theta),
    ]
    g = fdm["accelerations/gravity-ft_sec2"] * np.array(down)
    turn = q * np.sin(phi) + r * np.cos(phi)
    pitch = q * np.cos(phi) - r * np.sin(phi)
    return (
        force / mass + g - np.cross(w, v),
        np.linalg.solve(inertia, moment - np.cross(w, inertia @ w)),
        np.array([p + np.tan(theta) * turn, pitch, turn / np.cos(theta)]),
    )


mine = state()
fdm["fcs/elevator-cmd-norm"] -= 0.05
for _ in range(120):
    fdm.run()
    rates = derivatives(*mine)
    mine = tuple(x + dt * rate for x, rate in zip(mine, rates))

_, (_, q, _), (_, theta, _) = state()
print(
    f"JSBSim: pitch rate {np.degrees(q):.3f} deg/s, pitch angle {np.degrees(theta):.3f} deg"
)
print(
    f"NumPy:  pitch rate {np.degrees(mine[1][1]):.3f} deg/s, pitch angle {np.degrees(mine[2][1]):.3f} deg"
)
assert abs(np.degrees(mine[2][1] - theta)) < 0.05

# %% [markdown]
# The small difference is JSBSim's integration: its formulas, its round and rotating Earth, and the order in which it updates its parts.
#
# **Exercise.** How large is the lift coefficient in trim? Use the weight, the wing area `metrics/Sw-sqft` and the dynamic pressure
# `aero/qbar-psf` of a new aircraft `trimmed()`.

# %%
fresh = trimmed()
answer = fresh["inertia/weight-lbs"] / (
    fresh["metrics/Sw-sqft"] * fresh["aero/qbar-psf"]
)
assert abs(answer - 0.39) < 0.02, "lift equals weight: W = q S C_L"
print(f"{answer:.3f}")

# %% [markdown]
# ## A wrapper of ten lines, and its fault
#
# PathSim's `Wrapper` calls a function once per sample period. That makes JSBSim a block in a few lines:

# %%
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope, Wrapper

fdm, steps = trimmed(), 0
trim = fdm["fcs/elevator-cmd-norm"]


def advance(increment):
    global steps
    steps += 1
    fdm["fcs/elevator-cmd-norm"] = trim + float(np.ravel(increment)[0])
    fdm.run()
    return fdm["attitude/theta-deg"]


naive, command, scope = Wrapper(advance, T=1 / 120), Constant(0.0), Scope()
sim = Simulation(
    [command, naive, scope],
    [Connection(command, naive), Connection(naive, scope)],
    dt=1 / 120,
    log=False,
)

# %% [markdown]
# **Predict.** In 40 s at 120 Hz there are 4,800 periods. How many steps does JSBSim fly?

# %%
sim.run(40)
print(
    f"{steps} steps; JSBSim is at {fdm.get_sim_time():.4f} s, the diagram at {sim.time:.4f} s"
)
assert steps == 4801

# %% [markdown]
# The wrapper flies its first step at t = 0, so the aircraft is always one step ahead of the diagram: what a scope records at t is the
# state at t + T, and a controller acts on a measurement from the future. `Aircraft` shows its trimmed state at t = 0, reads its
# inputs at $t_k$, holds them over the period, and shows the state at $t_{k+1}$ when the diagram reaches that time:

# %%
from pathsim_jsbsim_blocks import Aircraft

plane, scope = Aircraft("c172p", altitude=5000.0, speed=90.0), Scope()
sim = Simulation(
    [plane, scope],
    [Connection(plane["theta"], scope)],
    dt=1 / 120,
    log=False,
)
before = plane.fdm.get_sim_time()
sim.run(40)
print(f"{round((plane.fdm.get_sim_time() - before) * 120)} steps")
assert round((plane.fdm.get_sim_time() - before) * 120) == 4800

# %% [markdown]
# In short: a step sums forces and moments, and integrates them. A block must do so exactly once per period, after its inputs are
# read. [Chapter 1](01_hello.ipynb) flies JSBSim and the block side by side.
