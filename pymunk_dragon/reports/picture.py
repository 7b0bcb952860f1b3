"""Pictures of a report as PNG data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymunk_dragon.drawing import Camera, Film, still_png
from pymunk_dragon.model.run import Run

__all__ = ["Picture", "pictures"]

# Pixels: width and height, twice the displayed size for screens with a pixel ratio of two.
SIZE = 880
# m: least width of the close-up around the head.
CLOSE_SPAN = 6.0
# Ratio of the close-up's half width to the distance of the contact from the head: keeps the contact of an unguided run,
# which may be far from the head, within the picture.
CLOSE_MARGIN = 1.5


@dataclass(frozen=True)
class Picture:
    """A picture of a report.

    Attributes
    ----------
    name : str
        File name without an ending.
    caption : str
        Caption.
    png : bytes
        Content of the PNG file.
    """

    name: str
    caption: str
    png: bytes


def pictures(run: Run) -> list[Picture]:
    """A close-up of the first contact, if any, and the whole dragon at the contact or at the end of the run."""
    first = run.first_contact
    if first is None:
        end = float(run.times[-1])
        return [Picture("dragon", f"The whole dragon at {end:.2f} s", _still(run, end, Camera()))]
    time = float(np.clip(first.time, run.times[0], run.times[-1]))
    distance = float(np.max(np.abs(np.array(first.point) - run.poses_at(time)[0, 0, :2])))
    close = Camera(follow="head", span=max(CLOSE_SPAN, 2 * CLOSE_MARGIN * distance))
    i, j = first.benches
    return [
        Picture("first_contact", f"Benches {i} and {j} touch", _still(run, time, close)),
        Picture("dragon", "The whole dragon at that moment", _still(run, time, Camera())),
    ]


def _still(run: Run, time: float, camera: Camera) -> bytes:
    return still_png(run, time, Film(size=SIZE, camera=camera, gap=False))
