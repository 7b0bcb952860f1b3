"""Exact dynamics: a dragon that only its head pulls, and the forces in the joints of a march.

The exact model knows the dragon only where dancers keep it on its path. Without them the motion
follows from forces: `pull` solves its equations of motion, and says what the engine's
``simulate(guide="none")`` is compared with. `joint_forces` has the forces in the joints of a march
with dancers. SciPy's integrators do the steps: `pip install 'pymunk-dragon[studies]'`.

```console
$ pymunk-dragon simulate --guide none --exact --until 11 -o pulled.npz
first contact at t = 10.892178 s: benches 1 and 28 at (5.421809, -7.207448) m
at most 10.526 m from the march with all benches on the path
```

## The model

A bench has the mass m and the moment of inertia I of a plank. Ground drag reduces its velocity v
and its angular rate w at the same rate c: m (v' + c v) and I (w' + c w) are the force and the
torque of the joints. This is the continuous model of Pymunk's ``damping = exp(-c)``. The rate is
the drag per metre times the head's top speed: 11.5 per second at 1 m/s. The head, or the first
benches (`free_from`), move as in the march, at any force that this takes.

The unknowns are the angles of the free benches. In each evaluation the forces in all joints follow
from one banded system of equations, in a time that grows with the number of benches
(`dynamics/equations.py`).

- The motion of the head jumps where a handle passes a joint of two arcs and where the table of
  speeds has a corner. These times are known before, and the integration is cut there. A curve of
  your own names its jumps in `curvature_jumps`; those that it does not name cost time, and some
  exactness. So does each entry of a table of speeds: 1,000 of them take 3 s in 11 s of march.
- The first contact is searched by the rates at which pairs of benches close at both ends of each
  step. Its time is confirmed by a step that ends there, because the interpolation within a step is
  less exact than its ends. The search is not certified, unlike `first_contact`.

## How exact it is

Largest error of a position in a frame, and error of the time of the first contact, beside a
tolerance of 1e-12 (`python tests/bench/bench.py errors-of-tolerances`): the reference march until
11 s, and 100 benches in the turn of question 4.

| tolerance | march, m | contact, s | turn, m | contact, s |
| --- | --- | --- | --- | --- |
| 1e-4 | 1.2e-4 | 3.9e-5 | 1.6e-4 | 6.1e-6 |
| 1e-6 | 1.1e-6 | 1.9e-7 | 9.4e-7 | 5.4e-7 |
| 1e-9 (default) | 3.9e-10 | 5.2e-13 | 3.6e-9 | 4.6e-12 |
| 1e-11 | 7.3e-12 | 8.7e-13 | 4.6e-11 | 5.1e-13 |

By default all positions in these runs are within 0.000005 mm of the exact ones.

With a tolerance of 1e-6 `pull` takes 0.54 of the processor time of `simulate` for 1,000 benches and
10.8 s (`python tests/bench/bench.py pull-speed`, median on two cores).

## What it says

First contacts of the reference march without a guide (`python tests/bench/bench.py pulled`):

| drag, per metre | benches | time, s |
| --- | --- | --- |
| 0 (ice) | 162 and 206 | 11.731364914 |
| 0.25 | 1 and 29 | 12.536484436 |
| 0.5 | 1 and 29 | 11.182013483 |
| 1 | 1 and 28 | 11.584524571 |
| 11.5 (default) | 1 and 28 | 10.892178138 |
| 200 | 1 and 28 | 10.830403778 |

On ice the chain stays on its path without a guide: a tension of m v^2 over the spacing in all
joints is the centripetal force, whatever the curvature. Only the last benches, whose tension is
less, swing out.

The joint of the head carries at most 1,105 N, and 1,007.43 N after 5 s. With dancers, who give each
bench the force along it, it carries 0.753 N after 5 s, 0.851 N after 100 s and 2.376 N after 400 s;
if they only keep the holes on the path, and the head pulls all benches over the ground along the
spiral, 33.7, 33.7 and 34.0 kN.
"""

from pymunk_dragon.dynamics.forces import joint_forces
from pymunk_dragon.dynamics.pull import pull

__all__ = ["joint_forces", "pull"]
