"""How lessons are told: in a terminal, on a page, in a notebook, and in which language."""

from pymunk_dragon.lessons._framework.catalogue import LANGUAGES, PARTS, check_language
from pymunk_dragon.lessons._framework.demo import Demo
from pymunk_dragon.lessons._framework.lesson import Lesson
from pymunk_dragon.lessons._framework.notebook import notebook
from pymunk_dragon.lessons._framework.page import page
from pymunk_dragon.lessons._framework.performance import Performance, perform
from pymunk_dragon.lessons._framework.terminal import Terminal, check_output
from pymunk_dragon.lessons._framework.writing import endings, write_lessons

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
