"""The Pymunk engine: bodies, joints, path constraints, collision callbacks and stepping loop.

`simulate` plays a march in Pymunk. Each bench is a rigid body with the shape of the bench, and a
`PivotJoint` at each hole chains it to the next one. The head is moved along its path; the dancers
(`guide="rails"`) keep every hole on the path. With a head that only pulls (`--guide none`) the
dragon straightens, and bench 1 runs into bench 28 after 10.9 s. A guide of your own is derived from
`PathGuide`.

```console
$ pymunk-dragon simulate --from 400 -o run.npz
first contact at t = 412.473851 s: benches 0 and 8 at (1.474407, 2.110656) m
drift 0.003 mm in the first twelve benches, 0.028 mm anywhere
79.7 times as fast as real time
```

![With a guide the dragon stays on its path; without one it straightens, and benches
touch](renders/guides.gif)

## How exact the engine is

Pymunk has only bodies, joints and small steps of time, so position errors grow. The head passes
bench 11 with a gap of 0.9 mm: an engine with an error of a millimetre reports a collision that
never happens.

From t = 0 to its first contact at the default settings (a substep of 20 ms, 10 iterations), benches
0 and 8 of the reference scenario touch at 412.473850 s, none before; the exact time is 412.473838
s. The drift is 0.0026 mm in the first twelve benches and 0.0192 mm anywhere. The run is 90 times as
fast as real time, and the driver takes 0.68 of the time of the bare steps on top
(`pymunk-dragon simulate --json` and `python tests/bench/bench.py engine` on two cores).

![Drift over time](renders/figures/drift.png)

Drift and error of the contact time by substep and iterations, from 400 s on
(`python tests/bench/bench.py drift`; `--substep` and `--iterations` choose others):

| substep | iterations | drift of the first 12, µm | of any, µm | error of the contact time, ms |
| --- | --- | --- | --- | --- |
| 1/25 s | 10 | 8.06 | 80.89 | +0.027 |
| 1/50 s | 10 (default) | 3.00 | 27.91 | +0.013 |
| 1/50 s | 60 | 1.45 | 5.90 | +0.002 |
| 1/100 s | 10 | 1.00 | 8.40 | +0.004 |
| 1/400 s | 60 | 0.01 | 0.07 | +0.000 |

In the turn of question 4 the drift is larger, because the curvature of the path jumps there, and
with it every acceleration: 128 µm in the first twelve benches and 133 µm anywhere; with a substep
of 1/400 s and 60 iterations, 2 and 4 µm
(`pymunk-dragon simulate --curve u-turn --from -100 --until 100`).

## What makes the engine exact

In the order of their effect:

- **Dancers walk and turn their benches** at the speed and the rate that follow from the bench
  before, so that the head need not pull the whole dragon against the ground. Otherwise the tension
  in the joints rotates with the benches at every step, and the solver cannot follow it.
- **Poses of second order.** Pymunk moves bodies with the velocities of the step before, which is
  Euler's method, and 223 benches add up its errors. The driver shifts the poses before each step by
  half a step times the change of velocity: the Adams-Bashforth method, from nothing but the
  engine's own velocities. After the step it corrects them by the velocities that the step has
  found, the Adams-Moulton method, whose error in a step is a fifth of that. Where the curvature
  jumps, in the turn of question 4, this leaves 133 µm of a drift of 352 µm.
- **Rails after pivots.** The solver takes the joints in the order in which they were added. With
  ten iterations, from 400 s on, rails after both pivots of their benches leave a drift of 28 µm,
  rails between the two 62 µm, and rails before both 92 µm; the pivots among themselves may stand in
  any order (28 to 30 µm). Where contact forces load the joints, rails between the two pivots are
  better: in the pile below the largest gap is 0.032 mm, with all rails last 0.039 mm.
- **Drag.** Pymunk corrects joint errors with ordinary velocity. A chain whose solver has not
  converged turns that into growing oscillations, unless ground drag is faster. With dancers who
  make up for it, any drag from 5 to 20 a second gives a drift of 24 to 34 µm.
- **Warm start.** The solver starts each step with the impulses of the step before. Before the first
  step they are those in balance, which elimination finds in a time that grows with the number of
  benches (0.07 s for 1,000).

## After the first contact

With `--contacts resolve` the run goes on after the first contact. The head is then pulled along its
path by a motor of finite force (`--head-force`, in N), the march waits for a head that cannot
follow it, and the dancers brake with it, so the dragon comes to rest where it hit itself. The
default force is twice the ground drag on the head. From the first contact to 10 s after it
(`python tests/bench/bench.py pile-up`), with the largest distance of any bench in the last 5 s:

| substep | force, N | largest joint gap, mm | deepest overlap, mm | last 5 s, mm |
| --- | --- | --- | --- | --- |
| 1/100 s | 471 | 0.087 | 0.493 | 1.33 |
| 1/200 s (default) | 471 (default) | 0.032 | 0.180 | 0.43 |
| 1/400 s | 471 | 0.011 | 0.073 | 0.09 |
"""

from pymunk_dragon.model.settings import EngineSettings
from pymunk_dragon.physics.guide import PathGuide
from pymunk_dragon.physics.rails import Rails
from pymunk_dragon.physics.simulation import simulate
from pymunk_dragon.physics.world import GUIDES, World

__all__ = ["GUIDES", "EngineSettings", "PathGuide", "Rails", "World", "simulate"]
