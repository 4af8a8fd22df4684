"""Draw the layers of the package from the import contracts in pyproject.toml.

python docs/generate.py pages
"""

import html
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WIDTH, ROW, GAP = 760, 34, 12  # px
CORE, BEYOND = "#cfe3f7", "#f2f2f2"


def layers_picture():
    """An SVG with a row for each layer, the core in another colour; imports point down."""
    import tomllib

    pyproject = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = {c["name"]: c for c in pyproject["tool"]["importlinter"]["contracts"]}
    border = contracts["the core imports nothing beyond"]
    core = {module.rpartition(".")[2] for module in border["source_modules"]}
    layers = [row.split(" | ") for row in contracts["imports point down"]["layers"]]
    parts = []
    for i, names in enumerate(layers):
        width = (WIDTH - GAP * (len(names) - 1)) / len(names)
        for k, name in enumerate(names):
            x, y = k * (width + GAP), i * (ROW + GAP)
            colour = CORE if name in core else BEYOND
            parts.append(
                f'<rect x="{x + 1:.1f}" y="{y + 1}" width="{width - 2:.1f}" height="{ROW}" rx="4" '
                f'fill="{colour}" stroke="#667"/>'
                f'<text x="{x + width / 2:.1f}" y="{y + 23}">{html.escape(name)}</text>\n'
            )
    height = len(layers) * (ROW + GAP)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" '
        f'width="{WIDTH}" height="{height}" font-family="sans-serif" font-size="15" '
        f'text-anchor="middle" fill="#111">\n{"".join(parts)}</svg>\n'
    )
