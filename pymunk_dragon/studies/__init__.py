"""Parameter studies over many marches, and optimisation: the contest's questions.

## The questions and their answers

```console
$ pymunk-dragon positions --times 300 --handles 223
     t (s)  handle       x (m)       y (m)  speed (m/s)
       300     223    1.785033    9.301164     0.996478
$ pymunk-dragon study min-pitch
smallest pitch 0.450337393027 m: handle 0 reaches the circle of 4.5 m
           after 220.934 s
limit:     benches 0 and 19 touch at t = 216.3382 s at (-0.3465, 4.8415) m
certified: no contact at 0.450337394027 m, but one at 0.450337392027 m
           none at 6 larger pitches up to 0.6177 m
$ pymunk-dragon study u-turn --no-search
the turn:  13.621245 m on arcs of 3.005418 and 1.502709 m,
           each of 173.118444 degrees,
           about (-0.760009, -1.305726) and (1.735932, 2.448402) m;
           as long with any other ratio of the radii
certified: no contact until t = 100 s
           the fastest handle is 1.6048 times as fast as the head
$ pymunk-dragon study max-speed
largest speed of the head 1.2462663582 m/s: no handle exceeds 2 m/s
limit:     handles 3 to 7 go 1.6047933790 times as fast as the head
           11.6187 s after it entered the circle, 14.4800 m into it
certified: no handle exceeds that by more than 1e-11 of it
```

An independent method, from formulas alone and in 34 to 50 digits, agrees with all five answers to
12 decimals and more; `python tests/bench/bench.py answers` prints both beside each other.

The contest's own sheets are written by `positions --times 0:300:1 -o result1.xlsx`,
`contact -o result2.xlsx` and `study u-turn --no-search -o result4.xlsx`.

## What each answer rests on

- **The smallest pitch.** The zero of the gap of the two benches that touch, over the pitch, with
  `first_contact` on both sides, because the time intervals in which benches touch are short: a scan
  every second finds a pitch that is too small (0.450274 m). Larger pitches 6 % apart, up to one at
  which turns are too far apart for benches to touch, have no contact either.
- **The turn.** Two arcs that touch both spirals and each other turn by the same angle, so the
  length does not depend on the ratio of their radii. More arcs make the turn shorter.
  `study u-turn`, without `--no-search`, searches turns on five arcs by sequential linear
  programming with SciPy (`pip install 'pymunk-dragon[studies]'`), such that no handle goes faster,
  relative to the head, than on the contest's own turn. The first contact and the largest speed of
  the result are certified. The problem is not convex: the result, 10.4947 m if no radius is below
  0.5 m, is the best turn that was found, and no proof shows that there is no shorter one. The
  straight line across is 9 m.
- **The largest speed.** Branch and bound over the distance of the head, with derivatives from
  interval arithmetic: no handle is faster at any time, sampled or not.
- **The sensitivity.** `study sensitivity` prints how much a millimetre of each size moves the first
  contact and the smallest pitch, from central differences of the exact answers.

## All of it on a page

`study paper -o answers.html` writes one page with all five answers as a paper has them: figures,
the derivation in formulas, where each certificate comes from, and errors and sensitivities in a
table (`pip install 'pymunk-dragon[demos]'`). It opens without a network and prints on A4; `--lang
zh` writes it in Chinese. `positions -o table.tex` writes the tables of question 1 for LaTeX.

![The head touches the bench that it passes, at the smallest pitch](renders/figures/min-pitch.png)

![The turn on two arcs, and the shortest one found](renders/figures/u-turn.png)

![Speeds of the foremost handles in the turn, and the limit](renders/figures/max-speed.png)

## A study of your own

A study is a module with a function and its result, and a `Study` in `STUDIES`, from which the
command line takes the flags. The result's class has the text, the JSON values and, if there is one,
the figure.
"""

from __future__ import annotations

from collections.abc import Mapping

from pymunk_dragon.studies._study import Result, Study
from pymunk_dragon.studies.max_speed import MaxSpeed, max_speed
from pymunk_dragon.studies.min_pitch import MinPitch, min_pitch
from pymunk_dragon.studies.paper import Paper, paper
from pymunk_dragon.studies.sensitivity import Sensitivity, sensitivity
from pymunk_dragon.studies.u_turn import TurnResult, u_turn

__all__ = [
    "STUDIES",
    "MaxSpeed",
    "MinPitch",
    "Paper",
    "Result",
    "Sensitivity",
    "Study",
    "TurnResult",
    "max_speed",
    "min_pitch",
    "paper",
    "sensitivity",
    "u_turn",
]

_STUDIES = (
    Study(
        name="min-pitch",
        summary="smallest pitch at which the head reaches the circle (question 3)",
        run=min_pitch,
    ),
    Study(
        name="max-speed",
        summary="largest speed of the head in the U-turn (question 5)",
        run=max_speed,
        flags={"limit": "no handle shall be faster, m/s.  [2]"},
    ),
    Study(
        name="paper",
        summary="all five answers, with errors and sensitivities, as a page",
        run=paper,
        formats=(".json", ".html"),
    ),
    Study(
        name="sensitivity",
        summary="effect of each size of the benches on first contact and that pitch",
        run=sensitivity,
        formats=(".json",),
    ),
    Study(
        name="u-turn",
        summary="turn inside the circle, and the shortest one found (question 4)",
        run=u_turn,
        flags={"search": "search for a shorter turn on five arcs.  [search]"},
        formats=(".json", ".png", ".svg", ".pdf", ".xlsx"),
    ),
)
# All studies by name.
STUDIES: Mapping[str, Study] = {study.name: study for study in _STUDIES}
