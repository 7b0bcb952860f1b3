"""Rendering: pictures of a dragon's state, films, figures and debug drawing."""

from pymunk_dragon.drawing.camera import Camera
from pymunk_dragon.drawing.film import Film
from pymunk_dragon.drawing.moments import Mark, Moment
from pymunk_dragon.drawing.output import STILL_ENDINGS, render, still, still_png, write_film, write_still
from pymunk_dragon.drawing.palette import Palette
from pymunk_dragon.drawing.scene import Scene
from pymunk_dragon.drawing.streams import FILM_ENDINGS

__all__ = [
    "FILM_ENDINGS",
    "STILL_ENDINGS",
    "Camera",
    "Film",
    "Mark",
    "Moment",
    "Palette",
    "Scene",
    "render",
    "still",
    "still_png",
    "write_film",
    "write_still",
]
