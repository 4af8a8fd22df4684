"""The gain tables that were tuned by hand, and the files of the others."""

from pathsim_jsbsim_blocks.control.gain_tables import TABLES, table

GAINS = {name: table(name).points[0].gains for name in ("c172p", "737", "global5000")}
DESIGNED = sorted(path for path in TABLES.glob("*.json") if path.stem not in GAINS)
