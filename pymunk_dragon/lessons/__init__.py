"""The lessons: one file each, which is also a program of its own. `_framework` runs and writes them.

Short programs for a class, or for yourself, from the spiral to a robot's arm. Each asks a question, lets you guess,
runs for one to five seconds (`python tests/bench/bench.py lessons`), and then gives the answer, a number to check by
hand and something to change. `make demos` runs all of them and writes [one page](renders/lessons.html), which needs
no network, reads on a phone as well as on paper, and holds the films, the code and the notebooks. The texts are in
English and Chinese; programs, and what they print and draw, are English.

```console
$ pymunk-dragon demo
$ pymunk-dragon demo near-miss --save pictures --lang zh
$ pymunk-dragon demo near-miss -o near_miss.py
$ pymunk-dragon demo near-miss -o near-miss.ipynb
```

![The first lesson on the page, with what it prints](renders/lessons.png)

## A lesson of your own

A new lesson is one file in this folder, in the form of the others: `Lesson` with a name, a title and an order, a
question, a prediction with guesses, code that shows one picture, what the picture shows, an answer with the results of
the guesses, a check and a change. `order` sorts the lessons; a value between those of two others puts it there.
Formulas are LaTeX between dollar signs. Chinese texts in `_framework/zh.toml`, and notes for teachers in
`_framework/notes.en.toml` and `notes.zh.toml`, are optional.
"""

from collections.abc import Mapping

from pymunk_dragon.lessons._framework import (
    LANGUAGES,
    Lesson,
    LessonFile,
    Recording,
    Terminal,
    lesson_files,
    play,
    record,
    write_lessons,
)

__all__ = ["LANGUAGES", "LESSONS", "Lesson", "LessonFile", "Recording", "Terminal", "play", "record", "write_lessons"]

# The lessons of the package by name, in their order.
LESSONS: Mapping[str, LessonFile] = lesson_files()
