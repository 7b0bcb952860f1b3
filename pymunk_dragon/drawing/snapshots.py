"""What pictures and films are drawn from: the states of runs and exact marches at any times."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

Source = Run | March

# Frames whose poses are computed at once: enough to amortise the cost of a call, few enough to
# limit memory.
_CHUNK_FRAMES = 32


@dataclass(frozen=True, kw_only=True)
class Snapshots:
    """States of a march at any times: those of `run`, or exact ones if it is None."""

    march: March
    run: Run | None = None

    def at(self, times: Array) -> Iterator[tuple[float, Array]]:
        """Yield each of the `times` (F,), s, and the poses (N, 3) then.

        Before and after a run, these are its first and last time.
        """
        borders = range(_CHUNK_FRAMES, len(times), _CHUNK_FRAMES)
        for chunk in np.split(times, borders):
            if self.run is None:
                poses = self.march.at(chunk).poses
            else:
                chunk = np.clip(chunk, *self.run.interval)
                poses = self.run.poses_at(chunk)
            yield from zip(chunk.tolist(), poses, strict=True)

    def velocities(self, time: float, poses: Array) -> Array:
        """Velocities (N + 1, 2) of the handles, m/s, at a time, s, with its `poses` (N, 3)."""
        if self.run is None:
            return np.asarray(self.march.at([time]).velocities[0])
        velocities = self.run.pose_velocities_at([time])[0]
        front, rear = self.march.dragon.hole_velocities(poses, velocities)
        return np.concatenate([front, rear[-1:]])
