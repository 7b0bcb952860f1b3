"""The lessons: one file each, which is also a program of its own. `_framework` runs and writes them.

Short programs for a class, or for yourself, from the spiral to a robot's arm. Each asks a question, lets you guess,
runs for one to five seconds (`python tests/bench/bench_lessons.py`), and then gives the answer, a number to check by
hand and something to change. `make demos` runs all of them and writes [one page](renders/lessons.html), which needs
no network, reads on a phone as well as on paper, and holds the films, the code and the notebooks, in English and
Chinese.

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
the guesses, a check and a change. `order` sorts the lessons; a value between those of two others puts it there. Its
Chinese texts go to `_framework/zh.toml`, with the Chinese of the strings and comments in its program, and notes for
teachers to `_framework/notes.en.toml` and `notes.zh.toml`. Formulas are LaTeX between dollar signs.

`LessonFile.in_language` gives a lesson in another language: its program, what that prints, and its picture.
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
