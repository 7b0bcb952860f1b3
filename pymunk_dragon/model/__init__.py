"""The exact model: dragons, curves, speeds, marches, and the runs that are played of them.

A `March` is a `Dragon` on a curve at a speed. `March.at` returns the positions and velocities of
all handles, and the poses of all benches, at any times. Every handle is on the curve to 1e-10 m,
which is 0.0000001 mm.

```console
$ pymunk-dragon positions --times 0,60,120 --handles 0,1,51,223
$ pymunk-dragon positions --paper
```

The second command prints tables 1 to 3 of the paper, all 147 entries, cut after three decimals as
the paper cuts them.

Positions, velocities and poses for 224 handles and 301 times take 4.0 ms of a processor, and
positions and speeds 11.9 ms by the fastest plain recursion known with NumPy
(`python tests/bench/bench.py march`, medians).
"""
