"""Line below the scenes of a film: what the colours mean, and a scale bar."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from PIL import Image, ImageDraw

from pymunk_dragon._language import text
from pymunk_dragon.drawing.lettering import Lettering
from pymunk_dragon.drawing.palette import BLENDS, CODES
from pymunk_dragon.drawing.scene import CIRCLE_DASH, Scene

# Pixels: a narrower picture has no legend.
MIN_WIDTH = 300
# Lines: a longer legend is omitted.
MAX_LINES = 2
# Width and height of a sample of a colour, as fractions of the text height.
SAMPLE = (1.0, 0.7)
# Lengths of scale bars, up to a power of ten.
STEPS = (5, 2, 1)
# Largest length of a scale bar, as a fraction of the width of a scene.
MAX_SCALE_BAR = 0.2
# Height of the ends of a scale bar, as a fraction of the text height.
TICK = 0.4

# Draws a sample into a rectangle: left, top, right, bottom.
Sample = Callable[[ImageDraw.ImageDraw, tuple[int, int, int, int]], None]


def legend_lines(scenes: Sequence[Scene], width: int, lettering: Lettering) -> list[Image.Image]:
    """Images of the lines of a legend (mode L, palette indices), `width` pixels wide; none if they do not fit."""
    if width < MIN_WIDTH:
        return []
    height = lettering.height
    entries = [_entry(sample, round(SAMPLE[0] * height), name, lettering) for sample, name in _samples(scenes)]
    metres = _round_down(MAX_SCALE_BAR * scenes[0].size[0] / scenes[0].scale)
    bar = _entry(_draw_scale_bar, round(metres * scenes[0].scale), f"{metres:g} m", lettering)
    lines: list[list[Image.Image]] = [[]]
    for entry in [*entries, bar]:
        if entry.width > width:
            return []
        if sum(image.width for image in lines[-1]) + entry.width > width:
            lines.append([])
        lines[-1].append(entry)
    if len(lines) > MAX_LINES:
        return []
    return [_joined(line, width, bar) for line in lines]


def _samples(scenes: Sequence[Scene]) -> list[tuple[Sample, str]]:
    """Samples of the colours that the scenes have, with their names."""
    found = [(_filled("head"), text("head")), (_filled("body"), text("body")), (_filled("tail"), text("tail"))]
    if any(scene.contact for scene in scenes):
        found.append((_filled("contact"), text("in contact")))
    if any(scene.march.curve.circles for scene in scenes):
        found.append((_draw_dashes, text("turning circle")))
    for factor in {scene.magnification for scene in scenes} - {None}:
        found.append((_draw_error, text("position error x {factor:,.0f}").format(factor=factor)))
    return found


def _filled(name: str) -> Sample:
    return lambda draw, box: draw.rectangle(box, fill=CODES[name], outline=CODES["ink"])


def _draw_error(draw: ImageDraw.ImageDraw, box: tuple[int, int, int, int]) -> None:
    left, top, right, bottom = box
    draw.line(
        (left, (top + bottom) // 2, right, (top + bottom) // 2), fill=BLENDS["motion", "background", 1.0], width=2
    )


def _draw_dashes(draw: ImageDraw.ImageDraw, box: tuple[int, int, int, int]) -> None:
    left, top, right, bottom = box
    for x in range(left, right, 2 * CIRCLE_DASH):
        draw.line((x, (top + bottom) // 2, x + CIRCLE_DASH - 1, (top + bottom) // 2), fill=CODES["ink"])


def _draw_scale_bar(draw: ImageDraw.ImageDraw, box: tuple[int, int, int, int]) -> None:
    left, top, right, bottom = box
    middle, half = (top + bottom) // 2, round(TICK * (bottom - top))
    draw.line((left, middle, right, middle), fill=CODES["ink"])
    for x in (left, right):
        draw.line((x, middle - half, x, middle + half), fill=CODES["ink"])


def _entry(sample: Sample, sample_width: int, name: str, lettering: Lettering) -> Image.Image:
    """Image of a sample with its name to the right."""
    label = lettering.line(name)
    margin = lettering.margin
    # The name is half a margin from its sample.
    left = margin // 2 + sample_width
    image = Image.new("L", (left + label.width - margin // 2, label.height), CODES["background"])
    image.paste(label, (left, 0))
    top = round((label.height - SAMPLE[1] * lettering.height) / 2)
    draw = ImageDraw.Draw(image)
    sample(draw, (margin, top, margin + sample_width, top + round(SAMPLE[1] * lettering.height)))
    return image


def _joined(entries: Sequence[Image.Image], width: int, bar: Image.Image) -> Image.Image:
    """Image of a line of entries from left to right; the scale bar is at the right edge."""
    line = Image.new("L", (width, bar.height), CODES["background"])
    left = 0
    for entry in entries:
        line.paste(entry, (width - entry.width if entry is bar else left, 0))
        left += entry.width
    return line


def _round_down(length: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is at most `length`."""
    power = 10.0 ** math.floor(math.log10(length))
    return next(step * power for step in STEPS if step * power <= length * (1 + 1e-9))
