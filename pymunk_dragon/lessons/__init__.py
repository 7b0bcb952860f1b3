"""The lessons: one file each, which is also a program of its own. `_framework` runs and writes them.

A new lesson is one file in this folder, in the form of the others: `Lesson` with a name, a title and an order, a
question, a prediction, code that shows one picture, an answer, a check and a change. `order` sorts the lessons; a value
between those of two others puts it there. Its Chinese texts go to `_framework/zh.toml`.
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
