"""The Pymunk engine: bodies, shapes and joints, path constraints, collision callbacks and the stepping loop.

`simulate` plays a march in Pymunk. Each bench is a rigid body with the shape of the bench, and a `PivotJoint` at each
hole chains it to the next one. The head is moved along its path; the dancers (`guide="rails"`) keep every hole on the
path.

```console
$ pymunk-dragon simulate --from 400 -o run.npz
first contact at t = 412.473851 s: benches 0 and 8 at (1.474407, 2.110656) m
drift 0.003 mm in the first twelve benches, 0.028 mm anywhere
79.7 times as fast as real time
```

## How exact the engine is

The exact model places every handle on the path to 1e-10 m. Pymunk only knows bodies, joints and small steps of time,
so it drifts. The drift matters: the head passes bench 9 with a gap of 3.0 mm and bench 11 with 0.9 mm, and an engine
with an error of a millimetre reports a collision that never happens.

The reference scenario from t = 0 to its first contact, at the default settings (a substep of 20 ms, 10 iterations),
as `pymunk-dragon simulate --json` and `python tests/bench/bench_speed.py` measure it on two cores:

| what | measured |
| --- | --- |
| first contact | benches 0 and 8, none before |
| its time | 412.473850 s; the exact one is 412.473838 s |
| drift of the first twelve benches | 0.0026 mm |
| drift of any bench | 0.0192 mm |
| speed | 80 times real time |
| driver on top of the bare steps | 0.70 |

The drift grows towards the tail and with the curvature: it is what ten iterations leave of the errors of the joints.

![Drift over time and along the dragon](renders/figures/drift.png)

Drift and error of the contact time by substep and iterations, from 400 s on (`python tests/bench/bench_drift.py`);
`--fine` takes an eighth of the default substep and 60 iterations:

| substep | iterations | drift of the first twelve, µm | of any, µm | error of the contact time, ms |
| --- | --- | --- | --- | --- |
| 1/25 s | 10 | 8.06 | 80.89 | +0.027 |
| 1/25 s | 60 | 8.51 | 23.41 | +0.002 |
| 1/50 s | 10 (default) | 3.00 | 27.91 | +0.013 |
| 1/50 s | 60 | 1.45 | 5.90 | +0.002 |
| 1/100 s | 10 | 1.00 | 8.40 | +0.004 |
| 1/100 s | 60 | 0.28 | 1.47 | +0.001 |
| 1/400 s | 10 | 0.07 | 0.51 | +0.000 |
| 1/400 s | 60 | 0.01 | 0.07 | +0.000 |

In the turn of question 4 the drift is larger, because the curvature of the path jumps there, and with it every
acceleration. From -100 to 100 s it is 128 µm in the first twelve benches and 133 µm anywhere; with `--fine`, 2 and 4
µm:

```sh
pymunk-dragon simulate --curve u-turn --from -100 --until 100
```

## What makes the engine exact

In the order of their effect:

- **Dancers walk.** Each dancer pushes the bench along at the speed that follows from the bench before, so that the
  head need not pull the whole dragon against the ground. Otherwise the tension in the joints rotates with the benches
  at every step, and the solver cannot follow it.
- **Dancers turn their benches.** If the joints have to turn them against the ground, that pulls at the chain as well.
- **Poses of second order.** Pymunk moves bodies with the velocities of the step before, which is Euler's method, and
  223 benches add up its errors. The driver shifts the poses before each step by half a step times the change of
  velocity: the Adams-Bashforth method, from nothing but the engine's own velocities. After the step it corrects them
  by the velocities that the step has found, the Adams-Moulton method, which has a fifth of the error, and where the
  curvature jumps, a third of the drift.
- **Pivots before rails.** The solver takes the joints in the order in which they were added. If each pivot is
  followed by its bench's rail, ten iterations leave twice the error. Where contact forces load the joints,
  interleaved joints have the smaller error.
- **Drag.** Pymunk corrects joint errors with ordinary velocity. A chain whose solver has not converged turns that
  into growing oscillations, unless ground drag is faster. With dancers who make up for it, any drag from 5 to 20 a
  second gives a drift of 24 to 34 µm.
- **Warm start.** The solver starts each step with the impulses of the step before. Before the first step they are
  those in balance, which elimination finds in a time that grows with the number of benches (0.13 s for 1,000).

## After the first contact

With `--contacts resolve` the run goes on after the first contact. The head is then pulled along its path by a motor
of finite force (`--head-force`, in N), the march waits for a head that cannot follow it, and the dancers brake with
it, so the dragon comes to rest where it hit itself. The default force is twice the ground drag on the head. From the
first contact to 10 s after it (`python tests/bench/bench_pile_up.py`):

| substep | force, N | largest joint gap, mm | deepest overlap, mm | distance of any bench in the last 5 s, mm |
| --- | --- | --- | --- | --- |
| 1/100 s | 471 | 0.087 | 0.493 | 1.33 |
| 1/200 s (default) | 300 | 0.028 | 0.175 | 1.03 |
| 1/200 s (default) | 471 (default) | 0.032 | 0.180 | 0.43 |
| 1/200 s (default) | 3000 | 0.089 | 0.343 | 0.18 |
| 1/400 s | 471 | 0.011 | 0.073 | 0.09 |

## Without dancers

With a head that only pulls (`--guide none`) the dragon straightens, and bench 1 runs into bench 28 after 10.9 s:

![With a guide the dragon stays on its path; without one it straightens, and benches touch](renders/guides.gif)

`simulate(guide=...)` also takes a guide of your own, derived from `PathGuide`.
"""

from pymunk_dragon.model.settings import EngineSettings
from pymunk_dragon.physics.guides import GUIDES, GuidedChain, PathGuide, Rails
from pymunk_dragon.physics.simulation import simulate
from pymunk_dragon.physics.world import World

__all__ = ["GUIDES", "EngineSettings", "GuidedChain", "PathGuide", "Rails", "World", "simulate"]
