"""Take the screenshots: every diagram as PathView shows it, and a flight report. Needs Chromium.

python docs/screenshots.py [NAME ...]
"""

import io
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

PAGE = 896  # px: as wide as the site shows a picture, so that the editor's labels keep their 8 px
MARGIN = 12  # px, round the diagram
SHARPNESS = 1.6  # px of the picture by px of the editor
PANEL = 292  # px: the plots below a diagram that has run
RUN = ("pitch_hold",)  # diagrams that are shown with their results
# the page around the picture has the text, and a picture needs no buttons
PLAIN = """
    .editor-nav, .panel-toggles, .breadcrumb { display: none !important }
    .svelte-flow__node-annotation { display: none !important }
    .svelte-flow__background { visibility: hidden }
    g.legend { transform: translate(300px, 25px) }  /* off the curves of pitch_hold */
"""

WIRES = 24  # of a picture: more cannot be followed by eye; the editor itself shows where one leads

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
MOVE = """([x, y]) => {
    const pane = document.querySelector('.svelte-flow').getBoundingClientRect()
    document.querySelector('.svelte-flow__viewport').style.transform =
        `translate(${x - pane.left}px, ${y - pane.top}px)`
}"""
# the subsystems of what is shown, one of each kind: those of a kind have the same blocks and ports
SUBSYSTEMS = """() => {
    const kinds = new Map()
    for (const node of document.querySelectorAll('.svelte-flow__node')) {
        if (node.querySelector('.node-type')?.textContent !== 'Subsystem') continue
        const ports = [...node.querySelectorAll('.port-label')].map(e => e.textContent).join()
        if (!kinds.has(ports)) kinds.set(ports, node.querySelector('.node-name').textContent)
    }
    return [...kinds.values()]
}"""


def take(page, target, below=0):
    """A picture of the whole diagram as it is shown, with room below for panels; not of a maze."""
    if page.locator(".svelte-flow__edge").count() > WIRES:
        target.unlink(missing_ok=True)
        return
    left, top, right, bottom = page.evaluate(BOUNDS)
    width = max(PAGE, round(right - left) + 2 * MARGIN)
    page.set_viewport_size({"width": width, "height": round(bottom - top) + 2 * MARGIN + below})
    page.wait_for_timeout(500)
    page.evaluate(MOVE, [(width - right - left) / 2, MARGIN - top])
    page.mouse.move(0, 0)  # a wire under the mouse has another colour
    page.wait_for_timeout(300)
    shrink(io.BytesIO(page.screenshot()), target, width=round(SHARPNESS * width))


def take_diagram(page, name):
    """A diagram, what is inside its subsystems, and the plots of one that has run."""
    page.wait_for_selector("button[aria-label='Run']:not([disabled])", timeout=180_000)
    page.wait_for_selector(".svelte-flow__node")
    page.wait_for_timeout(2500)  # the diagram assembles itself
    if name in RUN:
        page.click("button[aria-label='Run']")
        page.get_by_text("Simulation completed successfully").wait_for(timeout=180_000)
        page.click("button[aria-label='Console']")
        page.locator(".js-plotly-plot .trace path").first.wait_for(state="attached")
        page.click("button[aria-label='Plot options']")
        for legend in page.get_by_title("Show legend").all():
            legend.click()
        page.click(".dialog-backdrop", position={"x": 5, "y": 5})
    page.keyboard.press("f")
    page.wait_for_timeout(1000)
    page.add_style_tag(content=PLAIN)
    pictures = DOCS / "pictures"
    take(page, pictures / f"{name}_pathview.png", PANEL if name in RUN else 0)
    for subsystem in page.evaluate(SUBSYSTEMS):
        page.locator(".node-name").get_by_text(subsystem, exact=True).dblclick()
        page.wait_for_timeout(1500)
        inside = subsystem.replace(" ", "_")
        take(page, pictures / f"{name}_pathview_{inside}.png")
        page.keyboard.press("h")  # to the whole diagram
        page.wait_for_timeout(1500)


def take_report(browser):
    """A flight report, halfway into the flight's turn."""
    with tempfile.TemporaryDirectory() as folder:
        file, figure = Path(folder) / "flight.html", Path(folder) / "figure.png"
        cli.main(["run", REPORT, "--track", str(file), "--save", str(figure)])
        page = browser.new_page(viewport={"width": 1280, "height": 860})
        page.set_default_timeout(180_000)  # plotly is large, a busy machine slow
        page.goto(file.as_uri())
        page.wait_for_selector("body[data-ready]", timeout=180_000)
        page.evaluate(
            "t => { const s = document.getElementById('time'); s.value = t; s.oninput() }", 80
        )
        page.wait_for_timeout(2000)
        # four panels: the report goes on below
        shot = page.screenshot(clip={"x": 0, "y": 0, "width": 1280, "height": 775})
        page.close()
        shrink(io.BytesIO(shot), DOCS / "pictures" / "flight_report.png", width=1280)


def main(names):
    models = {f"{n}.pvm": pvm.read(find_diagram(n).with_suffix(".pvm")) for n in names}
    with Server(models, 0) as server, sync_playwright() as playwright:
        threading.Thread(target=server.run, daemon=True).start()
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        context = browser.new_context(
            viewport={"width": 1600, "height": 1000}, device_scale_factor=SHARPNESS
        )
        for name in names:
            page = context.new_page()
            page.goto(server.url(f"{name}.pvm"))
            take_diagram(page, name)
            page.close()
        if REPORT in names:
            take_report(browser)
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1:] or drawn_in_pathview())
