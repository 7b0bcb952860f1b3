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

## Where the head only pulls

The continuous model is a chain of rigid benches on viscous ground. With c = drag times the head's
top speed, joints and guide give each bench the force m (v' + c v) and the torque I (w' + c w); the
head has its exact motion. Pymunk's `damping` of exp(-c) is this decay.

Pymunk's own step is of first order. It is exact for momenta, but takes the lever arm of a joint's
force at the end of the step, where the force acts during the step. The world adds the missing
torque from the forces of the step before: the force along the bench times half the distance of its
holes times its turn since the mean time of the force. Poses come from the Adams-Bashforth method,
and are corrected by the Adams-Moulton method of order 3. The method is of second order then;
`EngineSettings(order=1)` leaves Pymunk's step as it is.

In the exact dynamics, benches 1 and 28 of the reference march touch first, at 10.892178138 s. Error
of this contact, ms, and of the worst hole before it, mm, by substep and iterations
(`python tests/bench/order.py`):

| substep | order 1, 10 iterations | order 2, 10 iterations | order 2, 20 | order 2, 100 |
| --- | --- | --- | --- | --- |
| 40 ms | +4.054, 6.161 | -0.791, 2.258 | -0.164, 1.162 | +0.261, 0.611 |
| 25 ms | +2.502, 4.108 | -0.360, 0.841 | -0.107, 0.446 (default) | +0.065, 0.240 |
| 20 ms | +1.995, 3.173 | -0.242, 0.525 | -0.078, 0.275 | +0.033, 0.138 |
| 10 ms | +0.993, 1.490 | -0.066, 0.128 | -0.025, 0.062 | +0.004, 0.026 |
| 5 ms | +0.496, 0.724 | -0.017, 0.032 | -0.007, 0.015 | +0.000, 0.006 |

![The error over the step, with slopes 1 and 2](renders/figures/order.png)

At the default settings the contact is at 10.892071 s, and until then every bench is within 0.36 mm
of the exact dynamics.

In forty other runs order 2 is nearly always more exact than order 1
(`python tests/bench/order.py scenarios`): turns, speeds that change, unequal benches, 1,000
benches, ice. Where a force changes within a few steps, or in long chains, ten iterations can leave
the same error in both. In a step in which contacts or a hand push, the forces of joints are not
known, and the next step is one of order 1.

Forces in the joints are those that act (`World.joint_forces`): on rails within 0.01 % of the
largest force; without a guide within 0.95 % (0.1 s after the start; 0.06 % at 10.8 s). That force
is a mean over the step, so it is half a step late. In a substep in which the curvature jumps, it is
between those before and after. The frame of a contact that ends a run has the forces before the
impact.

Impulses over the step are lower: by 10.7 % in steps of 20 ms without a guide, because the drag
reduces within the step what a force adds; and by 15 to 22 % on rails, because dancers push along
the new heading, and the drag has taken speed along the old one.

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
- **Drag.** Pymunk corrects joint errors with ordinary velocity, 6.3 per second (an `error_bias` of
  0.9 ** 60). A chain on rails whose solver has not converged turns that into growing oscillations,
  unless ground drag is about as fast. With dancers who make up for it, any drag from 5 to 20 a
  second gives a drift of 24 to 34 µm from 400 s on, a drag of 2 a second 9 mm. A faster correction
  (`error_bias` 1e-6) halves the drift of the whole march, 19.2 to 9.3 µm. But in the turn of
  question 4 the drift grows from 133 to 191 µm, and with a drag of 5 a second the chain flies
  apart.
- **Warm start.** The solver starts each step with the impulses of the step before. Before the first
  step they are those in balance, which elimination finds in a time that grows with the number of
  benches (0.07 s for 1,000).

## After the first contact

With `--contacts resolve` the run goes on after the first contact. The head is then pulled along its
path by a motor of finite force (`--head-force`, in N), the march waits for a head that cannot
follow it, and the dancers brake with it. The head slides on for 105 mm with substeps of 5 ms, and
for 72 mm with 2 ms, nearly all of it in the first 5 s. The default force is
twice the ground drag on the head. From the first contact to 10 s after it
(`python tests/bench/bench.py pile-up`), with the largest distance of any bench in the last 5 s:

| substep | force, N | largest joint gap, mm | deepest overlap, mm | last 5 s, mm |
| --- | --- | --- | --- | --- |
| 1/100 s | 471 | 0.087 | 0.493 | 1.33 |
| 1/200 s (default) | 471 (default) | 0.032 | 0.180 | 0.43 |
| 1/400 s | 471 | 0.011 | 0.073 | 0.09 |
"""

from pymunk_dragon.model.settings import EngineSettings
from pymunk_dragon.physics.assembly import GUIDES
from pymunk_dragon.physics.guide import PathGuide
from pymunk_dragon.physics.rails import Rails
from pymunk_dragon.physics.simulation import simulate
from pymunk_dragon.physics.world import World

__all__ = ["GUIDES", "EngineSettings", "PathGuide", "Rails", "World", "simulate"]
