"""Which benches touch, and when: broad phase, narrow phase, first contact (paper, section 2.2).

Benches are rectangles, and neighbouring benches, which share a hole, always overlap. So a contact
means two benches that are not neighbours. `first_contact` finds the first one and proves that there
is none before; `scan` is the paper's method; `Grid` and `separation` are the two phases of both.

## Three methods

`contact --method NAME` runs the exact search, the paper's search or the engine (`--json` prints
these numbers):

| method | first contact, s | samples | pairs of benches |
| --- | --- | --- | --- |
| `exact` | 412.473837682 | 3054 | 6109 |
| `grid` | 412.473837852 | 434 | 224489 |
| `engine` | 412.473849741 | 20624 | - |

- **exact** clears every time interval by a bound on the motion of the benches in it, or divides it.
- **grid** samples every second (`--step`). It files the benches under the cells of a grid, tests
  the pairs that share a cell with the separating axis theorem, and bisects once two benches
  overlap.
- **engine** is Pymunk's collision callback, refined inside the substep.

![The grid leaves 13 of 105 pairs of benches to test](renders/figures/grid.png)

## Why a proof

The head passes bench 9 with a gap of 3.0 mm and bench 11 with 0.9 mm before it meets bench 8. With
benches one millimetre wider it touches bench 11, for a tenth of a second. A scan steps over that
contact, and reports another one, 2.7 s later:

```console
$ pymunk-dragon contact --width 0.301
first contact at t = 409.775927738 s: benches 0 and 11 at (-2.647929, -0.875085) m
near miss at t = 406.8478 s: benches 0 and 9, 2.056 mm apart
$ pymunk-dragon contact --width 0.301 --method grid
first contact at t = 412.442193 s: benches 0 and 8 at (1.445751, 2.132263) m
```

![The gap before the head over time, with its near misses](renders/figures/gap.png)

## How the certificate works

1. **Time is distance.** The state of the chain depends only on the distance that the head has
   travelled. So the search runs over this distance, and converts it to times at the end, whatever
   the speed of the head.
2. **An interval is cleared by a bound.** The gap of each pair is computed at the midpoint of an
   interval. Bounds on the curvature of the path and on the angles of the benches bound the second
   derivative of every corner, and so, by Taylor's theorem, the displacement of each bench within
   the interval. A pair is clear if its gap is larger than the two displacements together. This is
   conservative advancement (B. Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems",
   1996), applied to all pairs at once.
3. **An interval that is not cleared is divided**, down to a picosecond. The first interval that
   stays is the contact.
4. **Rounding is included.** The bound also covers the error of the computed coordinates, from the
   points of the curve through the chain to the corners. `FirstContact.resolution` is the largest
   overlap that the proof does not rule out.
5. **Few pairs need tests.** If all benches behind the head are equal, they pass through the same
   poses one after the other. On a spiral, a circle about its centre separates most others: the
   distance of a bench from there changes slowly. `collision/first_contact.py` says which pairs
   remain, and proves it; `collision/bounds.py` has the bounds.

The result has a status, as the time-of-impact queries of physics engines have: `contact`, `clear`,
`overlapping` (at the start) or `unreachable` (the chain cannot follow the path any farther).

The certified answer for 223 benches takes 0.09 s (`python tests/bench/bench.py contact`, median on
two cores).
"""

from pymunk_dragon.collision.first_contact import first_contact
from pymunk_dragon.collision.grid import Grid
from pymunk_dragon.collision.result import FirstContact, NearMiss
from pymunk_dragon.collision.sat import Separation, separation
from pymunk_dragon.collision.scan import scan

__all__ = ["FirstContact", "Grid", "NearMiss", "Separation", "first_contact", "scan", "separation"]
