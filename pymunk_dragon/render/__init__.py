"""Rendering: pictures of a dragon's state, films, figures and debug drawing."""

from pymunk_dragon.render.camera import Camera
from pymunk_dragon.render.film import Film
from pymunk_dragon.render.moments import Mark, Moment
from pymunk_dragon.render.output import STILL_ENDINGS, render, still, still_png, write_film, write_still
from pymunk_dragon.render.palette import Palette
from pymunk_dragon.render.scene import Scene
from pymunk_dragon.render.streams import FILM_ENDINGS

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
