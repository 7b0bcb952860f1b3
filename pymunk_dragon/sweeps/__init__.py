"""Sweeps: a quantity of a dragon at many values of its parameters, in parallel.

When does the dragon run into itself if the spiral is wider, or the benches? `sweep` computes a
quantity at many values of the parameters, on all cores, and draws a line or a map of it:

```console
$ pymunk-dragon sweep --axis pitch=0.50:0.60:0.02 -o pitch.csv
$ pymunk-dragon sweep --quantity max-speed --axis ratio=1:2:0.25 --axis radius=4.5:6:0.5 \
    -o a.csv -o a.png
```

![The time of the first contact over pitch and width](renders/figures/contact-map.png)

- **Axes** are parameters of the dragon, its curve and the quantity, as `start`, `until` or `limit`:
  ranges with both ends, `0.4:0.8:0.01`, or lists, `50,100,200`.
- **Quantities** are `contact-time`, `min-pitch` and `max-speed`, or a function of yours of a march
  that returns names and numbers: `--quantity mine:longest_gap` of `mine.py` in this folder.
- **Borders** between points where other benches touch are found on the lines of the grid: with
  `--refine 4` to a sixteenth of the distance of its points. The map in the README has 2,326 points
  (`--axis pitch=0.50:0.60:0.004 --axis width=0.25:0.35:0.005 --refine 4`), a grid as fine 128,721.
  A band that lies between two neighbours of the same kind is not found.
- **The table** has a row for each point, in the order of the grid: the axes, the values, and
  `error`, the reason why a point has no values, as on a spiral narrower than the benches; the exit
  code is then 1.
- **Nothing is lost.** After Ctrl-C, a power cut or a full disk `--resume` goes on from
  `a.csv.partial`.
- **Where it runs.** In a process for each core, on the workers of a Dask scheduler with
  `--scheduler tcp://HOST:8786` (`pip install 'pymunk-dragon[cluster]'`), or in Python on any
  executor of `concurrent.futures`.

On two cores (`python tests/bench/bench.py sweep-overhead sweep-efficiency sweep-map`) a point of no
work takes 0.8 ms on processes and 2.9 ms on Dask, two workers do 0.94 of twice the work of one, and
a contact time in a map of pitch and width takes 84 to 90 ms of processor time (`sweep-points`).
"""

from __future__ import annotations

from pymunk_dragon.sweeps.quantities import QUANTITIES
from pymunk_dragon.sweeps.result import Sweep
from pymunk_dragon.sweeps.sweep import sweep

__all__ = ["QUANTITIES", "Sweep", "sweep"]
