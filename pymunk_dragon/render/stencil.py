"""Smooth convex polygons laid over a picture, without touching more of it than they cover."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from PIL import Image, ImageDraw

from pymunk_dragon.render.convex import Box, Point, clipped, covers

__all__ = ["FRINGE", "lay"]

# Pixels drawn for every pixel shown, along each side: 17 levels of coverage.
FINENESS = 4
# Pixels: ImageDraw also fills the pixels that a polygon's edge runs through, which makes it fatter by 0.35 (circles) to
# 0.5 (upright squares) of its pixels on every side. So much less gives the true area.
FRINGE = 0.38 / FINENESS
# Pixels of a tile, the piece of a picture that is drawn at once: small, so that the empty ground beside a slanting line
# costs little, and large, so that there are few of them.
TILE_AREA = 96 * 96
# Pixels by which a polygon may reach over its tile, to keep the edge of the cut out of sight.
OVERLAP = 1.0


def lay(image: Image.Image, colour: Sequence[float], polygons: Sequence[list[Point]]) -> None:
    """Fill polygons in one colour on an RGB or RGBA image, over what it shows.

    The first polygon is filled, the second cut out of it, the third filled again, and so on; the first one holds them
    all. The colour is red, green, blue and alpha, from 0 to 255; Pillow takes what is beyond for the end of the range.
    """
    red, green, blue, alpha = (round(part) for part in colour)
    if alpha <= 0 or len(polygons[0]) < 3:
        return
    for tile in _tiles(polygons[0], (0, 0, *image.size)):
        stencil = _stencil(tile, polygons, alpha)
        if stencil is None:
            continue
        if image.mode == "RGB":
            image.paste((red, green, blue), tile, stencil)
        else:
            # To paste would mix the colour with that of transparent pixels, which have none.
            layer = Image.new("RGBA", stencil.size, (red, green, blue))
            layer.putalpha(stencil)
            image.alpha_composite(layer, tile[:2])


def _tiles(polygon: list[Point], box: tuple[int, int, int, int]) -> Iterator[tuple[int, int, int, int]]:
    """Boxes of whole pixels, none twice, that hold all of a polygon that lies in `box`."""
    seen = clipped(polygon, box)
    if len(seen) < 3:
        return
    xs, ys = [x for x, _ in seen], [y for _, y in seen]
    left, top, right, bottom = math.floor(min(xs)), math.floor(min(ys)), math.ceil(max(xs)), math.ceil(max(ys))
    width, height = right - left, bottom - top
    if width * height <= TILE_AREA:
        if width and height:
            yield left, top, right, bottom
    elif width > height:
        middle = left + width // 2
        yield from _tiles(seen, (left, top, middle, bottom))
        yield from _tiles(seen, (middle, top, right, bottom))
    else:
        middle = top + height // 2
        yield from _tiles(seen, (left, top, right, middle))
        yield from _tiles(seen, (left, middle, right, bottom))


def _stencil(tile: tuple[int, int, int, int], polygons: Sequence[list[Point]], alpha: int) -> Image.Image | None:
    """How much of each pixel of a tile is filled, times `alpha`; None where nothing is."""
    left, top, right, bottom = tile
    edge: Box = (left - OVERLAP, top - OVERLAP, right + OVERLAP, bottom + OVERLAP)
    ground = 0
    figures: list[tuple[int, list[Point]]] = []
    for index, polygon in enumerate(polygons):
        level = 0 if index % 2 else alpha
        seen = clipped(polygon, edge) if polygon else []
        if covers(seen, edge):
            ground, figures = level, []
        elif len(seen) >= 3:
            figures.append((level, seen))
    size = (right - left, bottom - top)
    if not figures:
        return Image.new("L", size, ground) if ground else None
    sheet = Image.new("L", (FINENESS * size[0], FINENESS * size[1]), ground)
    draw = ImageDraw.Draw(sheet)
    # ImageDraw counts from the middle of the first pixel.
    x0, y0 = FINENESS * left + 0.5, FINENESS * top + 0.5
    for level, seen in figures:
        draw.polygon([round(c) for x, y in seen for c in (FINENESS * x - x0, FINENESS * y - y0)], fill=level)
    return sheet.reduce(FINENESS)
