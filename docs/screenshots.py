"""Take the gallery's screenshots: every diagram as PathView shows it. Needs Chromium.

    python docs/screenshots.py
"""

import shutil
import tempfile
import threading
from pathlib import Path

from generate import DOCS, shrink
from playwright.sync_api import sync_playwright

from pathsim_jsbsim_blocks.catalogue import diagram_folder, diagram_names
from pathsim_jsbsim_blocks.pathview import pvm
from pathsim_jsbsim_blocks.pathview.server import Server

# offline, without KaTeX's style sheet, each formula would be shown twice; the browser draws MathML
ONE_FORMULA = ".katex-html { display: none }"


def main():
    models = {f"{n}.pvm": pvm.read(diagram_folder() / f"{n}.pvm") for n in diagram_names()}
    with Server(models, 0) as server, sync_playwright() as playwright, \
            tempfile.TemporaryDirectory() as folder:
        threading.Thread(target=server.run, daemon=True).start()
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"),
                                             args=["--no-sandbox", "--disable-gpu"])
        context = browser.new_context(viewport={"width": 1600, "height": 1000})
        for name in diagram_names():
            page = context.new_page()
            page.goto(server.url(f"{name}.pvm"))
            page.wait_for_selector("button[aria-label='Run']:not([disabled])", timeout=60_000)
            page.wait_for_selector(".svelte-flow__node")
            page.add_style_tag(content=ONE_FORMULA)
            page.wait_for_timeout(2500)  # the diagram assembles itself
            page.keyboard.press("f")
            page.wait_for_timeout(1000)
            shot = Path(folder) / "shot.png"
            page.screenshot(path=shot)
            shrink(shot, DOCS / "pictures" / f"{name}_pathview.png", width=1100)
            page.close()
        browser.close()


if __name__ == "__main__":
    main()
