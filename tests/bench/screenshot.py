"""The picture of the player that README shows: `python tests/bench/screenshot.py march.html player.png`.

Needs a Chromium on the path.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

# The head passes bench 11.
MOMENT = "#t=409.8&follow=head"
SIZE = {"width": 1200, "height": 750}
ARGUMENTS = ["--no-sandbox", "--disable-background-networking"]


def main() -> None:
    """Open the page, wait until it has drawn, and take a picture."""
    page_file, picture = map(Path, sys.argv[1:])
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=ARGUMENTS)
        page = browser.new_page(viewport=SIZE, device_scale_factor=1)
        page.goto(page_file.resolve().as_uri() + MOMENT)
        page.evaluate("dragon")
        page.wait_for_timeout(500)
        page.screenshot(path=picture)
        browser.close()


if __name__ == "__main__":
    main()
