"""PathView's pages as this package serves them: no external content, no scripts but our own."""

from __future__ import annotations

import html
import importlib.util
import json
import re
import secrets
from pathlib import Path
from typing import Any

from .toolboxes import OURS, Toolbox

KATEX = Path(__file__).parent / "katex"
_STYLE = Path(__file__).with_name("page.css")
_SCRIPT = Path(__file__).with_name("page.js")
# PathView cuts the names of ports at 8 characters
_CUT = re.compile(r"(?<==)8(?=\)\{return (\w+)\.length>(\w+)\?\1\.slice\(0,\2\):\1\})")
_CDN = re.compile(r"https://cdn\.jsdelivr\.net/npm/katex@[^/\"'`]+/dist")

# PathView installs this toolbox with pip when it first starts in a browser
_PRELOADED = ("pathsim-chem", "pathsim_chem")
_CATEGORIES = {  # folder of this package: category and shape in PathView's block library
    "flight": ("Aircraft", "rect"),
    "daveml": ("Aircraft", "rect"),
    "sources": ("Sources", "pill"),
    "wind": ("Wind", "rect"),
    "control": ("Autopilot", "rect"),
    "guidance": ("Autopilot", "rect"),
    "linear": ("Aircraft", "rect"),
    "axes": ("Axes", "rect"),
    "air": ("Air data", "rect"),
    "tracks": ("Recording", "rect"),
    "units": ("Units", "rect"),
}


def policy(nonce: str = "") -> str:
    """Content-Security-Policy of all answers; ``nonce`` marks a page's own inline scripts."""
    source = f" 'nonce-{nonce}'" if nonce else ""
    return "; ".join(
        [
            "default-src 'none'",
            f"script-src 'self'{source}",
            "worker-src 'self'",
            "connect-src 'self'",
            "font-src 'self' data:",
            "img-src 'self' data: blob:",
            # formulas, plots and blocks are placed by style attributes
            "style-src 'self' 'unsafe-inline'",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'none'",
        ]
    )


def rendered(page: str, toolboxes: list[Toolbox]) -> tuple[str, str]:
    """A page of PathView with toolboxes registered, and the nonce of its scripts."""
    nonce = secrets.token_urlsafe(16)
    page = re.sub(r"<script(?=[\s>])", f'<script nonce="{nonce}"', page)
    script = f'<script nonce="{nonce}">{registration(toolboxes)}</script>'
    style = f"<style>{_STYLE.read_text(encoding='utf-8')}</style>"
    return page.replace("<head>", f"<head>{style}{script}", 1), nonce


def local_scripts(static: Path) -> dict[str, str]:
    """PathView's modified scripts by path: KaTeX is local, names of ports are not cut."""
    scripts = {}
    for file in (static / "app").rglob("*.js"):
        original = file.read_text(encoding="utf-8")
        text = _CUT.sub("99", _CDN.sub("/katex", original))
        if text != original:
            scripts[f"/{file.relative_to(static).as_posix()}"] = text
    return scripts


def refused(reason: str) -> str:
    """A page that explains why a request was refused."""
    return f"<!doctype html><title>403 Forbidden</title><p>{html.escape(reason)}\n"


def registration(required: list[Toolbox]) -> str:
    """JavaScript that registers toolboxes before PathView starts, and guards what it opens."""
    toolboxes = required if OURS in required else [OURS, *required]
    entries = [{**t.requirement(), "blocks": _selection(t), "events": []} for t in toolboxes]
    name, module = _PRELOADED
    seeded = [name] if importlib.util.find_spec(module) is None else []
    return f"""(() => {{
const toolboxes = {_literal(entries)}, seeded = {_literal(seeded)};
{_SCRIPT.read_text(encoding="utf-8")}
}})();"""


def _literal(value: Any) -> str:
    """A value as a JavaScript literal that cannot close the script element."""
    return json.dumps(value).replace("<", "\\u003c")


def _selection(toolbox: Toolbox) -> list[dict[str, Any]]:
    """This package's blocks with their categories; of other toolboxes PathView registers all."""
    out = []
    for name, block in toolbox.blocks().items() if toolbox == OURS else ():
        category, shape = _CATEGORIES[block.__module__.split(".")[1]]
        out.append(
            {"className": name, "enabled": True, "override": {"category": category, "shape": shape}}
        )
    return out
