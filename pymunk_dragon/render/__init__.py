"""A state as a picture, pictures as a film."""

from pymunk_dragon.render.camera import Camera
from pymunk_dragon.render.film import Film
from pymunk_dragon.render.moments import Mark, Moment
from pymunk_dragon.render.palette import Palette
from pymunk_dragon.render.scene import Scene
from pymunk_dragon.render.streams import FILM_ENDINGS
from pymunk_dragon.render.writing import STILL_ENDINGS, render, still, still_png, write_film, write_still

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
