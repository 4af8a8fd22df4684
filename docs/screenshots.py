"""Take the screenshots: every diagram as PathView shows it, and a flight report. Needs Chromium.

python docs/screenshots.py [NAME ...]
"""

import shutil
import sys
import tempfile
import threading
from pathlib import Path

from generate import DOCS, drawn_in_pathview, shrink
from playwright.sync_api import sync_playwright

from pathsim_jsbsim_blocks import cli
from pathsim_jsbsim_blocks.catalogue import find_diagram
from pathsim_jsbsim_blocks.pathview import pvm
from pathsim_jsbsim_blocks.pathview.server import Server

LEFT, TOP, MARGIN = 60, 40, 40  # px: PathView's side bar and top bar, room round the diagram
SMALLEST = 1100, 700  # px
WIDEST = 2400  # px
TALLEST = 1.6  # height by width of a picture; what is below is left out
ZOOM = 1.6  # at which port labels are easy to read; less where the diagram would get too wide

REPORT = "autopilot_mission"  # the diagram whose flight report is shown

# PathView's own "fit" considers blocks only, so wires around them would be cut off
BOUNDS = """() => {
    const view = new DOMMatrix(getComputedStyle(document.querySelector(
        '.svelte-flow__viewport')).transform)
    const pane = document.querySelector('.svelte-flow').getBoundingClientRect()
    const drawn = [...document.querySelectorAll(
        '.svelte-flow__node, .svelte-flow__node *, .svelte-flow__edge-path')]
        .map(e => e.getBoundingClientRect()).filter(r => r.width + r.height > 0)
    const x = drawn.flatMap(r => [r.left, r.right]).map(v => (v - pane.left - view.e) / view.a)
    const y = drawn.flatMap(r => [r.top, r.bottom]).map(v => (v - pane.top - view.f) / view.d)
    return [Math.min(...x), Math.min(...y), Math.max(...x), Math.max(...y)]
}"""
MOVE = """([x, y, zoom]) => {
    const pane = document.querySelector('.svelte-flow').getBoundingClientRect()
    document.querySelector('.svelte-flow__viewport').style.transform =
        `translate(${x - pane.left}px, ${y - pane.top}px) scale(${zoom})`
}"""


def take(page, target):
    """A picture of the whole diagram, as large as it takes to read it."""
    left, top, right, bottom = page.evaluate(BOUNDS)
    width, height = right - left, bottom - top
    zoom = min(ZOOM, (WIDEST - LEFT - 2 * MARGIN) / width)
    size = [
        max(least, round(zoom * extent + bar + 2 * MARGIN))
        for least, extent, bar in zip(SMALLEST, (width, height), (LEFT, TOP), strict=True)
    ]
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.wait_for_timeout(500)
    page.evaluate(
        MOVE,
        [
            (size[0] + LEFT - zoom * width) / 2 - zoom * left,
            (size[1] + TOP - zoom * height) / 2 - zoom * top,
            zoom,
        ],
    )
    page.wait_for_timeout(300)
    with tempfile.TemporaryDirectory() as folder:
        shot = Path(folder) / "shot.png"
        height = min(size[1], round(TALLEST * size[0]))
        page.screenshot(path=shot, clip={"x": 0, "y": 0, "width": size[0], "height": height})
        shrink(shot, target, width=size[0])


def take_report(browser):
    """A flight report, halfway into the flight's turn."""
    with tempfile.TemporaryDirectory() as folder:
        file, shot = Path(folder) / "flight.html", Path(folder) / "shot.png"
        cli.main(["run", REPORT, "--track", str(file), "--save", str(shot)])
        page = browser.new_page(viewport={"width": 1280, "height": 632})
        page.set_default_timeout(180_000)  # plotly is large, a busy machine slow
        page.goto(file.as_uri())
        page.wait_for_selector("body[data-ready]", timeout=180_000)
        page.evaluate(
            "t => { const s = document.getElementById('time'); s.value = t; s.oninput() }", 80
        )
        page.wait_for_timeout(2000)
        page.screenshot(path=shot)
        page.close()
        shrink(shot, DOCS / "pictures" / "flight_report.png", width=1280)


def main(names):
    models = {f"{n}.pvm": pvm.read(find_diagram(n).with_suffix(".pvm")) for n in names}
    with Server(models, 0) as server, sync_playwright() as playwright:
        threading.Thread(target=server.run, daemon=True).start()
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        context = browser.new_context(viewport={"width": 1600, "height": 1000})
        for name in names:
            page = context.new_page()
            page.goto(server.url(f"{name}.pvm"))
            page.wait_for_selector("button[aria-label='Run']:not([disabled])", timeout=180_000)
            page.wait_for_selector(".svelte-flow__node")
            page.wait_for_timeout(2500)  # the diagram assembles itself
            page.keyboard.press("f")
            page.wait_for_timeout(1000)
            take(page, DOCS / "pictures" / f"{name}_pathview.png")
            page.close()
        if REPORT in names:
            take_report(browser)
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1:] or drawn_in_pathview())
