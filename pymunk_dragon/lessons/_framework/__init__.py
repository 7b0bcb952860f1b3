"""The code behind the lessons: reading and running them; terminal, page and notebook."""

from pymunk_dragon.lessons._framework.lesson import Lesson, lessons
from pymunk_dragon.lessons._framework.notebook import make_notebook
from pymunk_dragon.lessons._framework.page import endings, make_page, run_page, write_lessons
from pymunk_dragon.lessons._framework.recording import Recording, record
from pymunk_dragon.lessons._framework.terminal import play

__all__ = [
    "Lesson",
    "Recording",
    "endings",
    "lessons",
    "make_notebook",
    "make_page",
    "play",
    "record",
    "run_page",
    "write_lessons",
]
