"""How lessons are told: in a terminal, on a page, in a notebook, and in which language."""

from pymunk_dragon.demos.telling.catalogue import LANGUAGES, PARTS, check_language
from pymunk_dragon.demos.telling.demo import Demo
from pymunk_dragon.demos.telling.lesson import Lesson
from pymunk_dragon.demos.telling.notebook import notebook
from pymunk_dragon.demos.telling.page import page
from pymunk_dragon.demos.telling.performance import Performance, perform
from pymunk_dragon.demos.telling.terminal import Terminal, check_output
from pymunk_dragon.demos.telling.writing import endings, write_lessons

__all__ = [
    "LANGUAGES",
    "PARTS",
    "Demo",
    "Lesson",
    "Performance",
    "Terminal",
    "check_language",
    "check_output",
    "endings",
    "notebook",
    "page",
    "perform",
    "write_lessons",
]
