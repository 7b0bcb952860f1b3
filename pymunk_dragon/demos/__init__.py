"""The lessons: one file each, which is a program of its own. How they are told is in `telling`."""

from collections.abc import Mapping
from pathlib import Path

from pymunk_dragon.demos.telling import LANGUAGES, Demo, Lesson, Performance, Terminal, perform, write_lessons
from pymunk_dragon.demos.telling.order import LESSONS

__all__ = ["DEMOS", "LANGUAGES", "Demo", "Lesson", "Performance", "Terminal", "perform", "write_lessons"]

# By name, in the order in which they are read.
DEMOS: Mapping[str, Demo] = {
    name: Demo.read(Path(__file__).parent / f"{name.replace('-', '_')}.py") for name in LESSONS
}
