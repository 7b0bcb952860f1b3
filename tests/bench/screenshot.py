"""Pictures of pages, by Chromium: `screenshot.py march.html "#t=409.8" player.png`.

What the address's second half says is shown: a moment of a run, or a lesson with its experiment, in
which sliders may get values, as `time_step=-3`. Chinese characters have the font of the extra
`chinese`.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).parents[1]))
from browser import chromium, opened

from pymunk_dragon._language import font, in_language

# Size of the window, pixels.
WIDTH = 1200
HEIGHT = 750

if __name__ == "__main__":
    page_file, shown, picture, *sliders = sys.argv[1:]
    with TemporaryDirectory() as data, in_language("zh"):
        face = font()
        assert face is not None
        Path(data, "fonts").symlink_to(face.parent)
        os.environ["XDG_DATA_HOME"] = data
        address = Path(page_file).resolve().as_uri() + shown
        with chromium() as started, opened(started, address, WIDTH, HEIGHT) as found:
            page = found.page
            page.evaluate("window.dragon")  # of a player: once it has drawn
            page.evaluate("document.querySelector(':target .cover .open-unguessed')?.click()")
            for name, value in (each.replace("_", " ").split("=") for each in sliders):
                page.get_by_label(name, exact=True).fill(value)
                page.get_by_label(name, exact=True).blur()
            page.wait_for_timeout(500)
            if height := page.evaluate(
                "document.querySelector('section:target')?.getBoundingClientRect().height"
            ):
                page.set_viewport_size(
                    {"width": WIDTH, "height": round(height) + 16}
                )  # A lesson has a margin.
            page.screenshot(path=picture)
