"""Sweeps: a quantity of a dragon at many values of its parameters, in parallel.

The points come from `axes`, and what is computed at each of them from `quantities`. `computation` sends batches of
points to `workers`, which call `evaluation`, and writes what they return to a `journal`. A `table` or a `figure` is
made of the journal in the end. `refinement` adds points where what is discrete changes.

A million points on a cluster
-----------------------------
This arithmetic begins with 0.16 s of one core for a contact time, at most 5 ms of the process that sweeps for a batch
on Dask (3.2 ms measured; `python tests/bench/bench_sweep.py` measures both), 93 bytes of the journal and 8 bytes of
memory for a point.

- Work: 1e6 x 0.16 s = 44 hours of one core, 27 minutes of 100 workers.
- Batches: one should take 0.5 s, and all workers should end at most 50 batches a second. So 100 workers get batches of
  2 s, or 12 points: 83,000 batches. They take 83,000 x 5 ms = 7 minutes of the process that sweeps, a quarter of its
  time. At most 400 batches are in flight, and at most as many are lost if the sweep is killed.
- Scheduler: 50 tasks a second. Its documentation gives about 1 ms for a task, so it works a twentieth of the time.
- Bytes: 0.4 kB to a worker and 55 bytes a point back, so 83,000 x 1.1 kB = 90 MB in all, 55 kB a second, and as much
  again for what Dask says of a task. The scenario is in every batch: a path through 50,000 points would be 1 MB each
  time, and should rather be a function that makes it.
- Journal: 93 MB, in 83,000 writes that wait for the disk. The table is written from it in a minute.

What breaks first is the process that sweeps. A batch ends after 10 s, so 2,000 workers end 200 batches a second, for
5 ms each: from there on workers wait. Then come pictures, for which all points are in memory, about 1 kB each.
"""

from __future__ import annotations

from pymunk_dragon.sweeps.quantities import QUANTITIES
from pymunk_dragon.sweeps.result import Sweep
from pymunk_dragon.sweeps.sweep import sweep

__all__ = ["QUANTITIES", "Sweep", "sweep"]
