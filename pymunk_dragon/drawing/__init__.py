"""Rendering: pictures of a dragon's state, films, figures and debug drawing."""

from pymunk_dragon.drawing.camera import Camera
from pymunk_dragon.drawing.film import FILM_ENDINGS, render, write_film
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.drawing.film.stills import STILL_ENDINGS, still, still_png, write_still
from pymunk_dragon.drawing.palette import Palette
from pymunk_dragon.drawing.scene import Scene
from pymunk_dragon.drawing.snapshots import Mark, Snapshot

__all__ = [
    "FILM_ENDINGS",
    "STILL_ENDINGS",
    "Camera",
    "Film",
    "Mark",
    "Palette",
    "Scene",
    "Snapshot",
    "render",
    "still",
    "still_png",
    "write_film",
    "write_still",
]
