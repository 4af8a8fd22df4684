"""NASA's atmospheric check cases 1 to 16: vehicles, reference data and comparison."""

from pathlib import Path

from .comparison import CASES, compare, comparison_figure, comparison_table, fly_case

# a JSBSim root directory with the vehicles: `root` of Aircraft, `JSBSim_path` of JSBSimFDM
MODELS = str(Path(__file__).resolve().parent / "models")

__all__ = [
    "CASES",
    "MODELS",
    "compare",
    "comparison_figure",
    "comparison_table",
    "fly_case",
]
