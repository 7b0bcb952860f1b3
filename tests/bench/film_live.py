"""Film the live page in use, in Chromium: `python tests/bench/film_live.py renders/live.gif`."""

from __future__ import annotations

import io
import math
import sys
import time
from base64 import b64decode
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw
from playwright.sync_api import Page

sys.path.insert(0, str(Path(__file__).parents[1]))
from browser import chromium, opened

from pymunk_dragon import live

# The bench that is pulled.
BENCH = 190
# How far outward, m.
PULL = 7.0
ARROW = np.array([(0, 0), (0, 17), (4, 13), (7, 20), (10, 19), (7, 12), (12, 12)])  # pixels
PLACE = """([bench, out]) => {
  const [x, y] = live.frame.poses.slice(3 * bench, 3 * bench + 2);
  const share = 1 + out / Math.hypot(x, y);
  const { left, top } = document.getElementById("field").getBoundingClientRect();
  const at = live.view.toScreen(share * x, share * y);
  return [left + at[0], top + at[1]];
}"""


def act(page: Page, moves: list[Any]) -> None:
    """Let the dancers go, and pull a bench away; note time, place and button of each move."""

    def glide(to: list[float], seconds: float, down: bool = False) -> None:
        begin = time.time()
        start = moves[-1][1]
        share = 0.0
        while share < 1:
            share = min((time.time() - begin) / seconds, 1.0)
            place = start + (1 - math.cos(math.pi * share)) / 2 * (np.array(to) - start)
            page.mouse.move(*place)
            moves.append((time.time(), place, down))
            page.wait_for_timeout(15)

    box: Any = page.locator("#release").bounding_box()
    x, y, width, height = box.values()
    glide([x + width / 2, y + height / 2], 1.0)
    page.mouse.down()
    glide([*moves[-1][1]], 0.2, down=True)
    page.mouse.up()
    for seconds in (0.9, 0.1):  # The bench moves on meanwhile.
        glide(page.evaluate(PLACE, [BENCH, 0]), seconds)
    page.mouse.down()
    glide(page.evaluate(PLACE, [BENCH, PULL]), 1.4, down=True)
    glide(page.evaluate(PLACE, [BENCH, -PULL]), 2.0, down=True)
    page.mouse.up()
    glide([*moves[-1][1] + 80], 2.0)


def main() -> None:
    """Film the page, draw the pointer, and write the film."""
    pictures: list[Any] = []
    with (
        live("dragon", browser=False) as session,
        chromium() as started,
        opened(started, session.address, 960, 640) as found,
    ):
        page = found.page
        page.wait_for_timeout(2000)
        client = page.context.new_cdp_session(page)

        def keep(event: Any) -> None:
            pictures.append((event["metadata"]["timestamp"], event["data"]))
            client.send("Page.screencastFrameAck", {"sessionId": event["sessionId"]})

        client.on("Page.screencastFrame", keep)
        client.send("Page.startScreencast", {"format": "png", "everyNthFrame": 3})
        act(page, moves := [(time.time(), np.array([180.0, 540.0]), False)])
        client.send("Page.stopScreencast")
        page.wait_for_timeout(300)
    frames = []
    for moment in np.arange(pictures[0][0], moves[-1][0], 1 / 10):
        picture = next(data for taken, data in reversed(pictures) if taken <= moment)
        _, place, down = next((move for move in reversed(moves) if move[0] <= moment), moves[0])
        frames.append(Image.open(io.BytesIO(b64decode(picture))).convert("RGB"))
        draw = ImageDraw.Draw(frames[-1])
        draw.circle(tuple(place), 12 if down else 0, outline="#b00d27", width=3)
        draw.polygon([tuple(corner) for corner in ARROW + place], fill="black", outline="white")
    # The last one has all colours, also those of contacts.
    palette = frames[-1].quantize(200, Image.Quantize.FASTOCTREE)
    first, *rest = (each.quantize(palette=palette, dither=Image.Dither.NONE) for each in frames)
    first.save(sys.argv[1], save_all=True, append_images=rest, duration=100, loop=0, optimize=True)


if __name__ == "__main__":
    main()
