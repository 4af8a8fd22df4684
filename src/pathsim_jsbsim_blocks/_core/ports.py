"""Numbers of ports by their names, and their labels in PathView."""

from __future__ import annotations

# labels of ports with names longer than 8 characters, which PathView would cut
_LABELS = {
    "wind_north": "wind_N",
    "wind_east": "wind_E",
    "wind_down": "wind_D",
    "theta_ref": "θ_ref",
    "theta_cmd": "θ_cmd",
    "pitch_mode": "pitch_md",
    "roll_mode": "roll_md",
    "pitch_off": "pit_off",
    "speed_off": "spd_off",
    "go_around": "goaround",
    "temp_deviation": "temp_dev",
    "temperature": "temp",
    "speed_of_sound": "sound",
    "viscosity": "visc",
}


def label(port: str) -> str:
    """PathView's label of a port: its name, or a shorter label."""
    return _LABELS.get(port, port)


def numbered(names: str) -> dict[str, int]:
    """Port labels from names separated by spaces, in order."""
    return {name: i for i, name in enumerate(names.split())}
