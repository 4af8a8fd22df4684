"""Trim maps and batches: functions that return tables, use all cores, and scale out to clusters.

Needs the extra ``studies``: ``pip install "pathsim-jsbsim-blocks[studies]"``.
"""

from .batch import run_batch
from .failure import engine_failure, engine_failure_chart
from .figures import (
    alpha_elevator_chart,
    climb_chart,
    envelope_map,
    performance_chart,
    thrust_chart,
)
from .futures import branch
from .performance import performance_table
from .published import (
    STUDIES,
    Study,
    aoa_vs_cas,
    aoa_vs_cas_loading,
    climb_schedule,
    thrust_vectoring,
    trim_envelope,
)
from .report import AircraftReport, aircraft_report
from .sweep import trim_sweep

__all__ = [
    "STUDIES",
    "AircraftReport",
    "Study",
    "aircraft_report",
    "alpha_elevator_chart",
    "aoa_vs_cas",
    "aoa_vs_cas_loading",
    "branch",
    "climb_chart",
    "climb_schedule",
    "engine_failure",
    "engine_failure_chart",
    "envelope_map",
    "performance_chart",
    "performance_table",
    "run_batch",
    "thrust_chart",
    "thrust_vectoring",
    "trim_envelope",
    "trim_sweep",
]
