"""Parameter studies over many marches, and optimisation: the contest's questions.

## The questions and their answers

```console
$ pymunk-dragon positions --times 300 --handles 223
     t (s)  handle       x (m)       y (m)  speed (m/s)
       300     223    1.785033    9.301164     0.996478
$ pymunk-dragon study min-pitch
smallest pitch 0.450337393027 m: handle 0 reaches the circle of 4.5 m after 220.934 s
limit:     benches 0 and 19 touch without overlapping as the head passes, t = 216.338214 s at (-0.346485, 4.841505) m
certified: no contact at 0.450337394027 m, but one at 0.450337392027 m
map:       20 pitches from 0.3 to 0.6321 m; the smallest gap grows from each to the next
$ pymunk-dragon study u-turn --no-search
the turn:  13.621245 m on arcs of 3.005418 and 1.502709 m,
           each of 173.118444 degrees, about (-0.760009, -1.305726), (1.735932, 2.448402) m,
           which touch at (-2.711856, -3.591078), (0.903952, 1.197026), (2.711856, 3.591078) m
contact:   none from -100 to 100 s, nor a gap below a thirtieth of the width: certified
fastest:   handle 3, 1.604793 times as fast as the head, as that is 14.480 m in: certified to 1e-11
two arcs:  always as long: 13.621244906821 to 13.621244906821 m where the radii are
           as 0.25 to 1 up to 4 to 1. Both turn by the same angle, and their chords
           make up the circle's diameter
$ pymunk-dragon study max-speed
largest speed of the head 1.2462663582 m/s: no handle exceeds 2 m/s
limit:     handles 3 to 7 go 1.6047933790 times as fast as the head 11.6187 s after it entered
           the circle, 14.4800 m into it
then:      handles 0, 1, 2, ... go 1.246  1.937  1.937  2.000  2.000  2.000  2.000  2.000  1.978  1.978 m/s
certified: no handle exceeds that by more than 1e-11 of it (548 evaluations)
```

Beside each answer of the contest the one of an independent method, from formulas alone and in 34 to 50 digits
(`python tests/bench/bench.py answers`; the tests compare more with it):

| question | answer | independently | decimals that agree | s | method, s |
| --- | --- | --- | --- | --- | --- |
| 1, x of handle 223 at 300 s, m | 1.785032733733 | 1.785032733733 | 13 | 0.02 | 50 digits, 0.7 |
| 2, first contact, s | 412.4738376821 | 412.4738376821 | 12 | 0.18 | root in 50 digits, 0.4 |
| 3, smallest pitch, m | 0.4503373930273 | 0.4503373930272 | 12 | 0.53 | grazing moment in 50 digits, 0.6 |
| 4, length of the turn, m | 13.62124490682 | 13.62124490682 | 15 | 0.00 | tangency in 34 digits, 0.0 |
| 5, largest speed, m/s | 1.246266358158 | 1.246266358157 | 13 | 0.17 | its maximum in 34 digits, 3.6 |

The contest's own sheets are written by `positions --times 0:300:1 -o result1.xlsx`, `contact -o result2.xlsx` and
`study u-turn --no-search -o result4.xlsx`.

## What each answer rests on

- **The smallest pitch.** The zero of the smallest gap of the whole march, with `first_contact` on both sides, because
  the time intervals in which benches touch are short: a scan every second finds a pitch that is too small (0.450274 m).
  At 20 pitches, up to one at which turns are too far apart for benches to touch, the smallest gap grows with the pitch:
  no other limit shows.
- **The turn.** Two arcs that touch both spirals and each other turn by the same angle, so the length does not depend
  on the ratio of their radii. More arcs make the turn shorter. `study u-turn`, without `--no-search`, searches turns
  on five arcs by sequential linear programming with SciPy (`pip install 'pymunk-dragon[studies]'`), such that no handle
  goes faster, relative to the head, than on the contest's own turn, and certifies the largest speed and the first
  contact of the result. The problem is not convex: the result, 10.4947 m if no radius is below 0.5 m, is the best turn
  that was found, and no proof shows that there is no shorter one. The straight line across is 9 m.
- **The largest speed.** Branch and bound over the distance of the head, with derivatives from interval arithmetic: no
  handle is faster at any time, sampled or not.
- **The sensitivity.** `study sensitivity` prints how much a millimetre of each size moves the first contact and the
  smallest pitch, from central differences of the exact answers, and where other benches touch.

![The smallest gap over the pitch, and the two benches that touch](renders/figures/min-pitch.png)

![The turn on two arcs, the shortest one, and the speeds of the handles](renders/figures/u-turn.png)

![Speeds of the handles in the turn, and where they are at the limit](renders/figures/max-speed.png)

## A study of your own

A study is a module with a function, its result, and an entry `STUDY`. The result's class has the text, the JSON
values and, if there is one, the figure; the command line takes the options from `STUDIES`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pymunk_dragon._checks import word
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.studies._study import DRAGON, Progress, Result, Study, silent
from pymunk_dragon.studies.max_speed import STUDY as MAX_SPEED
from pymunk_dragon.studies.max_speed import MaxSpeed, max_speed
from pymunk_dragon.studies.min_pitch import STUDY as MIN_PITCH
from pymunk_dragon.studies.min_pitch import MinPitch, min_pitch
from pymunk_dragon.studies.sensitivity import STUDY as SENSITIVITY
from pymunk_dragon.studies.sensitivity import Sensitivity, Slope, sensitivity
from pymunk_dragon.studies.u_turn import STUDY as U_TURN
from pymunk_dragon.studies.u_turn import TurnResult, u_turn

__all__ = [
    "STUDIES",
    "MaxSpeed",
    "MinPitch",
    "Result",
    "Sensitivity",
    "Slope",
    "Study",
    "TurnResult",
    "max_speed",
    "min_pitch",
    "sensitivity",
    "study",
    "u_turn",
]

# All studies by name.
STUDIES: Mapping[str, Study] = {study.name: study for study in (MIN_PITCH, MAX_SPEED, SENSITIVITY, U_TURN)}


def study(name: str, values: Mapping[str, Any], progress: Progress = silent) -> Any:
    """Run one of `STUDIES` with `values` of its `parameters` by name; a wrong name or value is a `ParameterError`.

    Examples
    --------
    >>> round(study("max-speed", {"limit": 1.5}).speed, 6)
    0.9347
    """
    chosen = STUDIES[word("study", name, STUDIES)]
    for given, value in values.items():
        if given not in chosen.parameters:
            raise ParameterError(given, value, f"left out: {name} takes " + ", ".join(chosen.parameters))
    sizes = {given: value for given, value in values.items() if given in DRAGON}
    rest = {given: value for given, value in values.items() if given not in DRAGON}
    return chosen.run(Dragon(**sizes), **rest, progress=progress)
