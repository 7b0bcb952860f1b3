"""What pictures and films are drawn from: runs and exact marches, at any times."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from pymunk_dragon._arguments import Array
from pymunk_dragon.collision import FirstContact, first_contact
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

Source = Run | March

# Frames whose poses are computed at once: enough to amortise the cost of a call, few enough to limit memory.
_CHUNK_FRAMES = 32
# s: margin by which the search for a contact at the end of a film extends beyond the end.
_CONTACT_MARGIN = 1e-6
# Times at which the extent of a dragon, and the benches in view, are sampled.
SAMPLES = 64


def march_of(source: Source) -> March:
    """Return the march of a run, or a march itself."""
    return source.march if isinstance(source, Run) else source


def first_contact_until(march: March, start: float, until: float) -> FirstContact:
    """Search for the first contact of the exact model from `start` to `until`, s, including a contact at `until`."""
    found = first_contact(march, start=start, until=min(until + _CONTACT_MARGIN, march.end))
    return replace(found, time=min(found.time, until))


def states(source: Source, times: Array) -> Iterator[tuple[float, Array]]:
    """Yield each of the `times` (F,), s, and the poses (N, 3) then; before and after a run, its first and last time."""
    for chunk in np.split(times, range(_CHUNK_FRAMES, len(times), _CHUNK_FRAMES)):
        if isinstance(source, Run):
            chunk = np.clip(chunk, source.times[0], source.times[-1])
        poses = source.poses_at(chunk) if isinstance(source, Run) else source.at(chunk).poses
        yield from zip(chunk.tolist(), poses, strict=True)
