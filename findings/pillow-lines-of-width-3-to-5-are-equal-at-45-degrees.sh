#!/usr/bin/env bash
# Pillow: slanted lines of `ImageDraw.line` with widths of 3, 4 and 5 have the same pixels.
#
# Expected: a line that is one pixel wider covers about one more pixel across, at every angle.
# Seen: at 45 degrees the widths 3, 4 and 5 give identical images, 3.55 pixels thick on average, while a
# horizontal line of these widths is 3, 4 and 5 pixels thick.
# Versions: Pillow 13.0.0, CPython 3.11.7, Linux on x86-64.
# Source: measurement; the line is drawn as a polygon whose corners are rounded to whole pixels, and
# the polygon includes its edges.
# Why it matters: in debug drawing, outlines change their thickness as bodies turn, and a thin wall
# looks heavier on a slope. Drawing at twice the size does not help. Polygons whose corners are
# chosen for the wanted distance of their edges do.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pillow==13.0.0

"$folder/venv/bin/python" - <<'PROGRAM'
import math
import sys

from PIL import Image, ImageDraw


def drawn(end, width):
    """Bytes of a picture with a line, and its mean thickness in pixels."""
    begin = 50, 50
    image = Image.new("L", (300, 300))
    ImageDraw.Draw(image).line([begin, end], 1, width)
    content = image.tobytes()
    return content, sum(content) / math.dist(begin, end)


found = {}
for name, end in (("0 degrees", (250, 50)), ("45 degrees", (250, 250))):
    found[name] = [drawn(end, width) for width in (3, 4, 5)]
    print(name, [round(thickness, 2) for _, thickness in found[name]])
slanted = {content for content, _ in found["45 degrees"]}
straight = {content for content, _ in found["0 degrees"]}
print("different pictures:", len(straight), "at 0 degrees,", len(slanted), "at 45 degrees")
sys.exit(0 if (len(straight), len(slanted)) == (3, 1) else "this is no longer what was found")
PROGRAM
