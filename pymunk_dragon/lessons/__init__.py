"""The lessons, one file each, which is also a program; `_framework` runs and writes them.

Short experiments for a class, or for yourself, from the spiral to a robot's arm. Each asks a
question, lets you guess, opens a stage on which you try, and then gives the answer and a number to
check by hand. `make demos` puts all of them on [one page](renders/lessons.html), which needs no
network, reads on a phone as well as on paper, and holds sheets to print, programs and notebooks.
The texts are in English and Chinese; programs and what they print are English.

```console
$ pymunk-dragon demo
$ pymunk-dragon demo near-miss --save pictures --lang zh
$ pymunk-dragon demo near-miss -o near-miss.py
$ pymunk-dragon demo near-miss -o near-miss.ipynb
```

![The first lesson on the page: you drag the head](renders/lessons.png)
![Where the next handle goes: you drag it](renders/lesson-chain.png)
![Shadows of two benches on four walls](renders/lesson-sat.png)
![The gap of the head, with coordinates that can be cut](renders/lesson-near-miss.png)
![Speeds in the turn, as colours](renders/lesson-speed-limit.png)

## A lesson of your own

A lesson is one file in this folder, in the percent format of Jupytext: texts in cells of Markdown,
and a program that prints and writes a picture `NAME.png` or `NAME.gif`, where NAME is that of the
file with hyphens. Its first line has `order`, by which lessons are sorted, and may have `axes` for
the sheet of the class and `scene`, a scene of `pymunk-dragon live`; with a `view`, the first cell
has a function `build` for that scene, which ``live(build, **LIVE)`` plays.

The texts begin with the title and the question. The headings that follow are "Answer", "Check",
"Try", "Change" and "Teacher", in this order. "Answer" ends with what the class guesses: a question
and a list of its choices with what comes of them; the right one is bold. What stands before the
stage, the question and the choices, has at most 40 words, and the answer 120. "Check" has a number
with decimals that the program prints. "Teacher" is a list, which begins with "- From grade 11; what
the class knows. 45 minutes: how they are spent." and "- Goal: what the lesson teaches.". Formulas
are LaTeX between dollar signs. A lesson without a `scene` has a stage: a file of JavaScript beside
it that sets `stages["NAME"]`, as `web/assets/lab.js` says. Chinese texts, in `zh.toml`, are
optional.
"""

from collections.abc import Mapping

from pymunk_dragon.lessons._framework.lesson import Lesson, lessons
from pymunk_dragon.lessons._framework.page import write_lessons
from pymunk_dragon.lessons._framework.recording import Recording, record
from pymunk_dragon.lessons._framework.terminal import play

__all__ = ["LESSONS", "Lesson", "Recording", "play", "record", "write_lessons"]

# The lessons of the package by name, in their order.
LESSONS: Mapping[str, Lesson] = lessons()
