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
_CDN = re.compile(r"https://cdn\.jsdelivr\.net/npm/katex@[^/\"'`]+/dist")

# PathView installs this toolbox with pip when it first starts in a browser
_PRELOADED = ("pathsim-chem", "pathsim_chem")
_CATEGORIES = {  # folder of this package: category and shape in PathView's block library
    "flight": ("Aircraft", "rect"),
    "sources": ("Sources", "pill"),
    "wind": ("Wind", "rect"),
    "control": ("Autopilot", "rect"),
    "axes": ("Axes", "rect"),
    "air": ("Air data", "rect"),
    "tracks": ("Recording", "rect"),
    "units": ("Units", "rect"),
}

# wires pass behind the names of ports
_STYLE = "<style>.port-label { background: var(--surface); }</style>"

# PathView fits the blocks into the window, not the wires around them: zoom out until these are seen
_WHOLE = """async () => {
        const shown = () => [...document.querySelectorAll(".svelte-flow__edge-path")].map(
            wire => wire.getBoundingClientRect());
        let busy = false, before = "", still = 0;
        const over = new AbortController(), options = {capture: true, signal: over.signal};
        for (const kind of ["pointerdown", "keydown", "wheel"])
            addEventListener(kind, event => { busy ||= event.isTrusted; }, options);
        for (let i = 0; i < 100 && still < 4 && !busy; i++) {
            await pause(250);
            const now = JSON.stringify(shown());
            still = now === before && now !== "[]" ? still + 1 : 0;
            before = now;
        }
        const outside = () => shown().some(wire => wire.left < 0 || wire.right > innerWidth
            || wire.top < 40 || wire.bottom > innerHeight);
        for (let i = 0; i < 4 && !busy && outside(); i++) {
            document.body.dispatchEvent(new KeyboardEvent("keydown", {key: "-", bubbles: true}));
            await pause(400);
        }
        over.abort();
    }"""


def policy(nonce: str = "") -> str:
    """Content-Security-Policy of all answers; ``nonce`` marks a page's own inline scripts."""
    own = f" 'nonce-{nonce}'" if nonce else ""
    return "; ".join(
        [
            "default-src 'none'",
            f"script-src 'self'{own}",
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


def rendered(page: str, required: list[Toolbox]) -> tuple[str, str]:
    """A page of PathView with toolboxes registered, and the nonce of its scripts."""
    nonce = secrets.token_urlsafe(16)
    page = re.sub(r"<script(?=[\s>])", f'<script nonce="{nonce}"', page)
    script = f'<script nonce="{nonce}">{registration(required)}</script>'
    return page.replace("<head>", f"<head>{_STYLE}{script}", 1), nonce


def local_scripts(static: Path) -> dict[str, str]:
    """PathView's scripts that load KaTeX's style sheet and fonts, redirected here, by path."""
    found = {}
    for file in (static / "app").rglob("*.js"):
        text, count = _CDN.subn("/katex", file.read_text(encoding="utf-8"))
        if count:
            found[f"/{file.relative_to(static).as_posix()}"] = text
    return found


def refused(reason: str) -> str:
    """A page that explains why a request was refused."""
    return f"<!doctype html><title>403 Forbidden</title><p>{html.escape(reason)}\n"


def registration(required: list[Toolbox]) -> str:
    """JavaScript that registers toolboxes before PathView starts; the last of a name wins."""
    toolboxes = required if OURS in required else [OURS, *required]
    entries = [{**t.requirement(), "blocks": _selection(t), "events": []} for t in toolboxes]
    name, module = _PRELOADED
    seeded = [name] if importlib.util.find_spec(module) is None else []
    return f"""(() => {{
        const key = "pathview.toolboxes.v1", toolboxes = {_literal(entries)};
        let state = null;
        try {{ state = JSON.parse(localStorage.getItem(key)); }} catch {{}}
        if (state?.version !== 1) state = {{version: 1}};
        const others = (state.toolboxes ?? []).filter(o => !toolboxes.some(t => t.id === o.id));
        state.toolboxes = [...others, ...toolboxes];
        state.seededIds = [...new Set([...(state.seededIds ?? []), ...{_literal(seeded)}])];
        localStorage.setItem(key, JSON.stringify(state));
        // a model that opens before its toolboxes are there is drawn, and wired, at wrong sizes
        const fetched = window.fetch, ready = "button[aria-label='Run']:not([disabled])";
        const pause = ms => new Promise(done => setTimeout(done, ms));
        const whole = {_WHOLE};
        window.fetch = async (url, ...rest) => {{
            if (!String(url).startsWith("/model/")) return fetched(url, ...rest);
            for (let i = 0; i < 600 && !document.querySelector(ready); i++) await pause(100);
            whole();
            return fetched(url, ...rest);
        }};
    }})();"""


def _literal(value: Any) -> str:
    """A value as a JavaScript literal that cannot close the script element."""
    return json.dumps(value).replace("<", "\\u003c")


def _selection(toolbox: Toolbox) -> list[dict[str, Any]]:
    """This package's blocks with their categories; for other toolboxes PathView takes all."""
    out = []
    for name, block in toolbox.blocks().items() if toolbox == OURS else ():
        category, shape = _CATEGORIES[block.__module__.split(".")[1]]
        out.append(
            {"className": name, "enabled": True, "override": {"category": category, "shape": shape}}
        )
    return out
