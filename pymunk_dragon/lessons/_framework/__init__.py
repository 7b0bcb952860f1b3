"""The code behind the lessons: reading, running and translating them; terminal, page and notebook."""

from pymunk_dragon.lessons._framework.export import endings, write_lessons
from pymunk_dragon.lessons._framework.guess import Guess
from pymunk_dragon.lessons._framework.lesson import Lesson
from pymunk_dragon.lessons._framework.lesson_file import LessonFile, lesson_files
from pymunk_dragon.lessons._framework.notebook import make_notebook
from pymunk_dragon.lessons._framework.page import make_page
from pymunk_dragon.lessons._framework.play import Output, Recording, play, record
from pymunk_dragon.lessons._framework.terminal import Terminal, check_output
from pymunk_dragon.lessons._framework.translations import LANGUAGES, PARTS, check_language

__all__ = [
    "LANGUAGES",
    "PARTS",
    "Guess",
    "Lesson",
    "LessonFile",
    "Output",
    "Recording",
    "Terminal",
    "check_language",
    "check_output",
    "endings",
    "lesson_files",
    "make_notebook",
    "make_page",
    "play",
    "record",
    "write_lessons",
]
