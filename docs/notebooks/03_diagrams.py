# %% [markdown]
# # 3. Block diagrams
#
# Three diagrams without an aircraft: how blocks and connections make a differential equation. Each comes as a script
# and as a model for PathView.
#
# ## A damped oscillator

# %%
from pathsim_jsbsim_blocks.catalogue import load_diagram

oscillator = load_diagram("damped_oscillator")
oscillator.sim.run(oscillator.DURATION)
oscillator.figure()

# %% [markdown]
# The blocks are two integrators in a row, and an adder that sums what acts on the first:

# %%
for connection in oscillator.sim.connections:
    targets = ", ".join(type(target.block).__name__ for target in connection.targets)
    print(type(connection.source.block).__name__, "->", targets)

# %% [markdown]
# ## A step response

# %%
step = load_diagram("step_response")
step.sim.run(step.DURATION)
step.figure()

# %% [markdown]
# ## Van der Pol's oscillator

# %%
oscillation = load_diagram("van_der_pol")
oscillation.sim.run(oscillation.DURATION)
oscillation.figure()

# %% [markdown]
# ## The same in PathView
#
# `pathsim-jsbsim view van_der_pol` opens the diagram in the editor. A model becomes a script again, by the editor's own
# button or here:

# %%
import tempfile
from pathlib import Path

from pathsim_jsbsim_blocks.catalogue import diagram_folder
from pathsim_jsbsim_blocks.pathview import convert_model

with tempfile.TemporaryDirectory() as folder:
    script = convert_model(diagram_folder() / "van_der_pol.pvm", Path(folder, "van_der_pol.py"))
    lines = script.read_text(encoding="utf-8").splitlines()
start = next(i for i, line in enumerate(lines) if "Integrator(" in line)
print("\n".join(lines[start : start + 6]))

# %% [markdown]
# [A diagram drawn in PathView](../drawing.md) goes the whole way with the mouse. Next:
# [an elevator doublet](04_elevator_doublet.ipynb).
