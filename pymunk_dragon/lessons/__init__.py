"""The lessons: one file each, which is a program of its own. `_framework` plays and writes them."""

from collections.abc import Mapping
from pathlib import Path

from pymunk_dragon.lessons._framework import LANGUAGES, Demo, Lesson, Performance, Terminal, perform, write_lessons
from pymunk_dragon.lessons._framework.order import LESSONS

__all__ = ["DEMOS", "LANGUAGES", "Demo", "Lesson", "Performance", "Terminal", "perform", "write_lessons"]

# By name, in the order in which they are read.
DEMOS: Mapping[str, Demo] = {
    name: Demo.read(Path(__file__).parent / f"{name.replace('-', '_')}.py") for name in LESSONS
}
