"""Curves on which a dragon marches: one module per kind.

A curve is given by its arc length: `Line`, `Arc`, `Spiral`, `UTurn` (the contest's question 4),
`Sampled` (a smooth path through points), and `Composite`, `Section` and `Reversed`, which are made
of other curves. Marches, certified first contacts and the engine work on each of them, and on any
class derived from `Curve`.

![The dragon turns in a circle of 9 m and comes out again](renders/u-turn.gif)

```console
$ pymunk-dragon positions --curve u-turn --times -100:100:1 -o result4.xlsx
$ pymunk-dragon simulate --curve u-turn --from 10 --until 16 -o u-turn.npz
$ pymunk-dragon render u-turn.npz -o u-turn.gif
```

`pymunk_dragon.model.scenario` describes files of curves. Check a curve of your own, a class derived
from `Curve`, with `check_curve`; scenario files and saved runs can contain it if it has a ``kind``.
"""

from pymunk_dragon.model.curves.arc import Arc
from pymunk_dragon.model.curves.base import Curve
from pymunk_dragon.model.curves.check import check_curve
from pymunk_dragon.model.curves.composite import Composite, Reversed, Section
from pymunk_dragon.model.curves.line import Line
from pymunk_dragon.model.curves.sampled import Sampled
from pymunk_dragon.model.curves.spiral import Spiral
from pymunk_dragon.model.curves.u_turn import UTurn

__all__ = [
    "Arc",
    "Composite",
    "Curve",
    "Line",
    "Reversed",
    "Sampled",
    "Section",
    "Spiral",
    "UTurn",
    "check_curve",
]
