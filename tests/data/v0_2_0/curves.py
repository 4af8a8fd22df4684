# written for version 0.2.0
from pathsim_jsbsim_blocks.plots import exact_curves, subplots

with exact_curves():
    figure, axes = subplots(2)
