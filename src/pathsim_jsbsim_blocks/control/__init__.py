"""Controllers: the sampled PI-D law, one block per hold, and the autopilot."""
