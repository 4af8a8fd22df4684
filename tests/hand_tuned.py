"""The gain tables that were tuned by hand, and the files of the others."""

from pathsim_jsbsim_blocks.control.gain_tables import TABLES, table

GAINS = {name: table(name).points[0].gains for name in ("c172p", "737", "global5000")}
# those with a schedule; the landing table is tuned by hand, for one configuration
DESIGNED = sorted(p for p in TABLES.glob("*.json") if p.stem not in {*GAINS, "737-landing"})
