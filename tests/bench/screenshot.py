"""Pictures of pages: `python tests/bench/screenshot.py march.html "#t=409.8" player.png`.

What the address's second half says is shown: a moment of a run, or a lesson, unfolded. Needs a Chromium on the path.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from playwright.sync_api import ViewportSize, sync_playwright

SIZE: ViewportSize = {"width": 1200, "height": 750}
# Pixels above a lesson.
MARGIN = 16
ARGUMENTS = ["--no-sandbox", "--disable-background-networking"]


def main() -> None:
    """Open the page, wait until it has drawn, and take a picture."""
    page_file, shown, picture = sys.argv[1:]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=ARGUMENTS)
        page = browser.new_page(viewport=SIZE, device_scale_factor=1)
        page.goto(Path(page_file).resolve().as_uri() + shown)
        page.evaluate("window.dragon")  # of a player: once it has drawn
        page.evaluate("document.querySelectorAll(':target details').forEach((folded) => folded.open = true)")
        page.wait_for_timeout(500)
        box = page.evaluate("document.querySelector('section:target')?.getBoundingClientRect().height")
        if box is not None:
            page.set_viewport_size({"width": SIZE["width"], "height": round(box) + MARGIN})
        page.screenshot(path=picture)
        browser.close()


if __name__ == "__main__":
    main()
