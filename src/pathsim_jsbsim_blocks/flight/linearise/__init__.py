"""Linear models of an aircraft at its trim, from JSBSim's accelerations or from flight."""
