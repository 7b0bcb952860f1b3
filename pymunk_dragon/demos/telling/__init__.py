"""How lessons are told: in a terminal, on a page, in a notebook, and in which language."""

from pymunk_dragon.demos.telling.catalogue import LANGUAGES
from pymunk_dragon.demos.telling.demo import Demo
from pymunk_dragon.demos.telling.lesson import Lesson
from pymunk_dragon.demos.telling.performance import Performance, perform
from pymunk_dragon.demos.telling.stage import Stage
from pymunk_dragon.demos.telling.terminal import Terminal

__all__ = ["LANGUAGES", "Demo", "Lesson", "Performance", "Stage", "Terminal", "perform"]
