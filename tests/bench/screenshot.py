"""Pictures of pages: `python tests/bench/screenshot.py march.html "#t=409.8" player.png`.

What the address's second half says is shown: a moment of a run, or a lesson with what it prints. Needs a Chromium on
the path. Chinese characters have the font of the extra `chinese`.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from playwright.sync_api import ViewportSize, sync_playwright

from pymunk_dragon._language import font, in_language

SIZE: ViewportSize = {"width": 1200, "height": 750}
# Pixels above a lesson.
MARGIN = 16
ARGUMENTS = ["--no-sandbox", "--disable-background-networking"]


def main() -> None:
    """Open the page, wait until it has drawn, and take a picture."""
    page_file, shown, picture = sys.argv[1:]
    with TemporaryDirectory() as data, sync_playwright() as playwright, in_language("zh"):
        face = font()
        assert face is not None
        Path(data, "fonts").symlink_to(face.parent)
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=ARGUMENTS, env={**os.environ, "XDG_DATA_HOME": data}
        )
        page = browser.new_page(viewport=SIZE, device_scale_factor=1)
        page.goto(Path(page_file).resolve().as_uri() + shown)
        page.evaluate("window.dragon")  # of a player: once it has drawn
        page.evaluate("document.querySelectorAll(':target details.run').forEach((folded) => folded.open = true)")
        page.wait_for_timeout(500)
        box = page.evaluate("document.querySelector('section:target')?.getBoundingClientRect().height")
        if box is not None:
            page.set_viewport_size({"width": SIZE["width"], "height": round(box) + MARGIN})
        page.screenshot(path=picture)
        browser.close()


if __name__ == "__main__":
    main()
