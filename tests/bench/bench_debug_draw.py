"""Processor time of a picture of debug drawing: `python tests/bench/bench_debug_draw.py`.

A chain of 223 boxes with a pivot between any two, laid on a spiral, and a settled pile of 100 boxes, each drawn as
640 x 640 pixels. Medians over the repeats. With matplotlib installed, `pymunk.matplotlib_util` draws the same beside
it, canvas included.
"""

from __future__ import annotations

import math
import random
import time
import warnings
from collections.abc import Callable
from statistics import median

import pymunk
from measure import durations, sized
from PIL import Image

from pymunk_dragon.drawing.debug_draw import PillowDrawOptions
from pymunk_dragon.model.march import March

SIZE = 640
REPEATS, MATPLOTLIB_REPEATS = sized((21, 5), (1, 1))


def chain() -> pymunk.Space:
    """The seed's dragon at 300 s, without the head's drive."""
    space = pymunk.Space()
    march = March()
    previous = None
    dragon, poses = march.dragon, march.at([300.0]).poses[0].tolist()
    sizes = zip(poses, dragon.lengths, dragon.widths, dragon.spacings, strict=True)
    for (x, y, angle), length, width, spacing in sizes:
        body = pymunk.Body(1, 1)
        body.position, body.angle = (x, y), angle
        space.add(body, pymunk.Poly.create_box(body, (length, width)))
        if previous is not None:
            space.add(pymunk.PivotJoint(previous, body, body.local_to_world((spacing / 2, 0))))
        previous = body
    return space


def pile() -> pymunk.Space:
    """A hundred boxes that have fallen between walls."""
    space = pymunk.Space()
    space.gravity = 0, -1000
    for a, b in (((0, 0), (640, 0)), ((0, 0), (0, 900)), ((640, 0), (640, 900))):
        space.add(pymunk.Segment(space.static_body, a, b, 5))
    chance = random.Random(1)
    for i in range(100):
        body = pymunk.Body()
        body.position, body.angle = (50 + 60 * (i % 10), 50 + 60 * (i // 10)), chance.uniform(0, 3)
        box = pymunk.Poly.create_box(body, (chance.uniform(25, 55), chance.uniform(25, 55)), 2 * (i % 3))
        box.mass, box.friction = 1, 0.5
        space.add(body, box)
    for _ in range(600):
        space.step(1 / 200)
    return space


def milliseconds(draw: Callable[[], None], repeats: int) -> float:
    """Median processor time of a call, after one that is not counted."""
    draw()
    return 1000 * median(durations(draw, repeats, time.process_time))


def with_pillow(space: pymunk.Space) -> float:
    """Milliseconds for a new image and the drawing on it."""
    options = PillowDrawOptions(Image.new("RGB", (SIZE, SIZE)), positive_y_is_up=True)
    options.fit(space)

    def draw() -> None:
        options.image = Image.new("RGB", (SIZE, SIZE), "white")
        space.debug_draw(options)

    return milliseconds(draw, REPEATS)


def with_matplotlib(space: pymunk.Space) -> float:
    """Milliseconds for the same with Pymunk's own utility; nan where matplotlib is not installed."""
    try:
        import matplotlib
    except ImportError:
        return math.nan
    matplotlib.use("agg")
    import matplotlib.pyplot as plt
    from pymunk import matplotlib_util

    boxes = [shape.bb for shape in space.shapes]

    def draw() -> None:
        figure = plt.figure(figsize=(SIZE / 100, SIZE / 100), dpi=100)
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set(
            xlim=(min(box.left for box in boxes), max(box.right for box in boxes)),
            ylim=(min(box.bottom for box in boxes), max(box.top for box in boxes)),
            aspect="equal",
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            space.debug_draw(matplotlib_util.DrawOptions(axes))
        figure.canvas.draw()
        plt.close(figure)

    return milliseconds(draw, MATPLOTLIB_REPEATS)


def main() -> None:
    """Print one line for each space."""
    for space, name in ((chain(), "223 benches on a spiral"), (pile(), "pile of 100 boxes")):
        line = f"{name}: {with_pillow(space):.1f} ms"
        other = with_matplotlib(space)
        print(line if math.isnan(other) else f"{line}; pymunk.matplotlib_util {other:.0f} ms")


if __name__ == "__main__":
    main()
