"""Composites anti-aliased convex polygons onto an image; the cost depends only on the covered pixels."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from PIL import Image, ImageDraw

from pymunk_dragon.drawing.debug_draw.convex import Box, Point, clipped, covers

# Samples per pixel along each axis: 4 x 4 samples give 17 levels of coverage.
OVERSAMPLING = 4
# Pixels by which a polygon must be inset before it is drawn. ImageDraw also fills the pixels on a polygon's edge, which
# enlarges a polygon by 0.35 (circles) to 0.5 (upright squares) samples on every side.
EDGE_INSET = 0.38 / OVERSAMPLING
# Pixels of a tile, the part of an image that is drawn at once: small enough that the empty area beside a slanted line
# costs little, large enough that there are few tiles.
TILE_AREA = 96 * 96
# Pixels by which a clipped polygon extends beyond its tile, so that the clipped edge is not visible.
TILE_BORDER = 1.0


def composite(image: Image.Image, colour: Sequence[float], polygons: Sequence[list[Point]]) -> None:
    """Fill polygons in one colour on an RGB or RGBA image.

    The first polygon is filled, the second is a hole in it, the third is filled again, and so on. The first polygon
    contains all others. The colour is red, green, blue and alpha from 0 to 255; Pillow clips values out of this range.
    """
    red, green, blue, alpha = (round(part) for part in colour)
    if alpha <= 0 or len(polygons[0]) < 3:
        return
    for tile in _tiles(polygons[0], (0, 0, *image.size)):
        mask = _coverage_mask(tile, polygons, alpha)
        if mask is None:
            continue
        if image.mode == "RGB":
            image.paste((red, green, blue), tile, mask)
        else:
            # `paste` would blend with the undefined colour of transparent pixels.
            layer = Image.new("RGBA", mask.size, (red, green, blue))
            layer.putalpha(mask)
            image.alpha_composite(layer, tile[:2])


def _tiles(polygon: list[Point], box: tuple[int, int, int, int]) -> Iterator[tuple[int, int, int, int]]:
    """Yield disjoint tiles of whole pixels that cover the part of a polygon inside `box`."""
    part = clipped(polygon, box)
    if len(part) < 3:
        return
    xs, ys = [x for x, _ in part], [y for _, y in part]
    left, top, right, bottom = math.floor(min(xs)), math.floor(min(ys)), math.ceil(max(xs)), math.ceil(max(ys))
    width, height = right - left, bottom - top
    if width * height <= TILE_AREA:
        if width and height:
            yield left, top, right, bottom
    elif width > height:
        middle = left + width // 2
        yield from _tiles(part, (left, top, middle, bottom))
        yield from _tiles(part, (middle, top, right, bottom))
    else:
        middle = top + height // 2
        yield from _tiles(part, (left, top, right, middle))
        yield from _tiles(part, (left, middle, right, bottom))


def _coverage_mask(tile: tuple[int, int, int, int], polygons: Sequence[list[Point]], alpha: int) -> Image.Image | None:
    """Return the coverage of each pixel of a tile, times `alpha`, or None if nothing is covered."""
    left, top, right, bottom = tile
    edge: Box = (left - TILE_BORDER, top - TILE_BORDER, right + TILE_BORDER, bottom + TILE_BORDER)
    base = 0
    visible: list[tuple[int, list[Point]]] = []
    for index, polygon in enumerate(polygons):
        level = 0 if index % 2 else alpha
        part = clipped(polygon, edge) if polygon else []
        if covers(part, edge):
            base, visible = level, []
        elif len(part) >= 3:
            visible.append((level, part))
    size = (right - left, bottom - top)
    if not visible:
        return Image.new("L", size, base) if base else None
    oversampled = Image.new("L", (OVERSAMPLING * size[0], OVERSAMPLING * size[1]), base)
    draw = ImageDraw.Draw(oversampled)
    # The origin of ImageDraw is the centre of the first pixel.
    x0, y0 = OVERSAMPLING * left + 0.5, OVERSAMPLING * top + 0.5
    for level, part in visible:
        draw.polygon([round(c) for x, y in part for c in (OVERSAMPLING * x - x0, OVERSAMPLING * y - y0)], fill=level)
    return oversampled.reduce(OVERSAMPLING)
