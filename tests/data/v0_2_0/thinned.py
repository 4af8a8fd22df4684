# written for version 0.2.0
import numpy as np

from pathsim_jsbsim_blocks.tracks import Track

n = np.linspace(0.0, 1.0, 100)
track = Track("a", "c172p", time=n, lat=n, lon=n, h=1000 * n, theta=n, phi=n, psi=n)
print(len(track.thinned(10).time))
