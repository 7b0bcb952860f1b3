"""Sweeps: a quantity of a dragon at many values of its parameters, in parallel.

When does the dragon run into itself if the spiral is wider, or the benches? `sweep` computes a quantity at many
values of the parameters, on all cores, and draws a map of it:

```console
$ pymunk-dragon sweep --axis pitch=0.50:0.60:0.02 -o pitch.csv
$ pymunk-dragon sweep --benches 40 --axis pitch=0.5:0.6:0.02 --axis width=0.25:0.35:0.05 --refine 9 -o a.csv -o a.png
$ pymunk-dragon sweep --quantity max-speed --axis ratio=1:2:0.25
$ pymunk-dragon sweep --quantity engine-error --axis start=405 --axis substep=0.01,0.02 --axis iterations=5,10
```

![The time of the first contact over pitch and width](renders/figures/contact-map.png)

This map of 2,786 points is made by `make map`, which is one command:

```sh
pymunk-dragon sweep --axis pitch=0.50:0.60:0.004 --axis width=0.25:0.35:0.01 --refine 2500 -o contact-map.png
```

At each line the dragon changes the benches that touch first: on a slightly wider spiral the head slips past one
bench, and meets the next one seconds later. `--refine` puts nine of ten points where that happens, in the middles of
cells whose corners differ, and again in the middles of those.

- **Axes** are parameters of the dragon and of its curve, and the parameters of the quantity (`start`, `until`,
  `substep`, `iterations`, `limit`): ranges with both ends, `0.4:0.8:0.01`, lists, `50,100,200`, or with `--samples N`
  intervals, `0.4:0.8`, of which a Sobol sequence or random points are taken (`--sampling`, `--seed`).
- **Quantities** are `contact-time`, `nearest-gap`, `min-pitch`, `max-speed`, `engine-contact-time` and
  `engine-error`, or a function of yours of a march that returns names and numbers: `--quantity mine:longest_gap` of
  `mine.py` in this folder.
- **The table** has a row for each point, in the order of the grid: the axes, the values, and `error`. A point that
  has no values, such as a spiral narrower than the benches, or that takes longer than `--timeout`, has the reason
  there, and the exit code is 1. `-o` writes CSV, Parquet (`pip install 'pymunk-dragon[parquet]'`) or a picture, and
  may be repeated.
- **Nothing is lost.** Finished points are in a journal beside the table, `map.csv.journal`. After Ctrl-C, a power cut
  or a full disk the same command with `--resume` computes the others, and writes the same bytes. It refuses to mix
  points of another scenario, axis, quantity or version.
- **Where it runs.** By default a process for each core. `--scheduler tcp://HOST:8786` runs on the workers of a Dask
  scheduler, and `--scheduler local` starts one here (`pip install 'pymunk-dragon[cluster]'`); in Python any executor
  of `concurrent.futures` does. The table is the same, byte for byte.

## In Python

```python
from concurrent.futures import ThreadPoolExecutor

from pymunk_dragon import Scenario, sweep

# Threads, as this is no file; `sweep` starts processes by itself, under `if __name__ == "__main__":`.
found = sweep(Scenario(benches=20), {"pitch": [0.5, 0.55, 0.6]}, "contact-time", executor=ThreadPoolExecutor(2))
print(found.column("contact_time"))  # [336.5..., 412.4..., 466.5...]
found.plot()  # a matplotlib figure, which notebooks show
```

## Measurements

On two cores, `python tests/bench/bench_sweep.py overhead efficiency memory map` measures:

| what | measured |
| --- | --- |
| two workers over twice one worker, 200 contact times | 0.94 |
| overhead of a point on processes, one point a batch; in batches | 0.5 ms; 0.03 ms or less |
| the same on Dask | 3.2 ms; 0.08 ms |
| 10,000 contact times, pitch 0.4 to 0.8 m and width 0.2 to 0.4 m | 14.5 minutes |
| memory of the process that sweeps, for 1,000, 10,000 and 100,000 points | 39, 39 and 42 MB |

## How it works

The points come from `axes`, and what is computed at each of them from `quantities`. `computation` sends batches of
points to `workers`, which call `evaluation`, and writes what they return to a `journal`. A `table` or a `figure` is
made of the journal in the end. `refinement` adds points where what is discrete changes.

## A million points on a cluster

This arithmetic begins with 0.16 s of one core for a contact time, at most 5 ms of the process that sweeps for a batch
on Dask (3.2 ms measured; `python tests/bench/bench_sweep.py` measures both), 93 bytes of the journal and 8 bytes of
memory for a point.

- Work: 1e6 x 0.16 s = 44 hours of one core, 27 minutes of 100 workers.
- Batches: one should take 0.5 s, and all workers should end at most 50 batches a second. So 100 workers get batches
  of 2 s, or 12 points: 83,000 batches. They take 83,000 x 5 ms = 7 minutes of the process that sweeps, a quarter of
  its time. At most 400 batches are in flight, and at most as many are lost if the sweep is killed.
- Scheduler: 50 tasks a second. Its documentation gives about 1 ms for a task, so it works a twentieth of the time.
- Bytes: 0.4 kB to a worker and 55 bytes a point back, so 83,000 x 1.1 kB = 90 MB in all, 55 kB a second, and as much
  again for Dask's own data about a task. The scenario is in every batch: a path through 50,000 points would be 1 MB
  each time, and should rather be a function that makes it.
- Journal: 93 MB, in 83,000 writes that wait for the disk. The table is written from it in a minute.

What breaks first is the process that sweeps. A batch ends after 10 s, so 2,000 workers end 200 batches a second, for
5 ms each: from there on workers wait. Then come pictures, for which all points are in memory, about 1 kB each.
"""

from __future__ import annotations

from pymunk_dragon.sweeps.quantities import QUANTITIES
from pymunk_dragon.sweeps.result import Sweep
from pymunk_dragon.sweeps.sweep import sweep

__all__ = ["QUANTITIES", "Sweep", "sweep"]
