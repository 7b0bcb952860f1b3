"""Pictures for a report, as the bytes of PNG files."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pymunk_dragon.render import Camera, Film, still_png
from pymunk_dragon.run import Run

__all__ = ["Picture", "pictures"]

# Pixels a side: twice the width at which a page shows it, for screens with two pixels to the point.
SIZE = 880
# Metres of ground around the head, and how much further away than half of that the contact may be: pictures of 16
# benches that nobody guides shall still have their contact in view.
CLOSE_SPAN, CLOSE_BORDER = 6.0, 1.5


@dataclass(frozen=True)
class Picture:
    """One picture.

    Attributes
    ----------
    name : str
        What it may be called as a file, without an ending.
    caption : str
        What it shows.
    png : bytes
        The file.
    """

    name: str
    caption: str
    png: bytes


def pictures(run: Run) -> list[Picture]:
    """The first contact from close by, where there was one, and the whole dragon then or at the end of the run."""
    first = run.first_contact
    if first is None:
        end = float(run.times[-1])
        return [Picture("dragon", f"The whole dragon at {end:.2f} s", _still(run, end, Camera()))]
    time = float(np.clip(first.time, run.times[0], run.times[-1]))
    away = float(np.max(np.abs(np.array(first.point) - run.poses_at(time)[0, 0, :2])))
    close = Camera(follow="head", span=max(CLOSE_SPAN, 2 * CLOSE_BORDER * away))
    i, j = first.benches
    return [
        Picture("first_contact", f"Benches {i} and {j} touch", _still(run, time, close)),
        Picture("dragon", "The whole dragon at that moment", _still(run, time, Camera())),
    ]


def _still(run: Run, time: float, camera: Camera) -> bytes:
    return still_png(run, time, Film(size=SIZE, camera=camera, gap=False))
