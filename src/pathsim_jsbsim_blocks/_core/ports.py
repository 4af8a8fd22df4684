"""Names of ports: in their order, and as PathView writes them."""

from __future__ import annotations

# labels of the ports whose names PathView would cut, at 8 characters
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
    """What PathView writes at a port: its name, or a shorter label."""
    return _LABELS.get(port, port)


def numbered(names: str) -> dict[str, int]:
    """Port labels from names with spaces between them, in their order."""
    return {name: i for i, name in enumerate(names.split())}
