"""A state as a picture, pictures as a film."""

from pymunk_dragon.render.camera import Camera
from pymunk_dragon.render.film import FILM_ENDINGS, FPS, STILL_ENDINGS, Film, render, write_film, write_still
from pymunk_dragon.render.palette import Palette
from pymunk_dragon.render.scene import Scene

__all__ = [
    "FILM_ENDINGS",
    "FPS",
    "STILL_ENDINGS",
    "Camera",
    "Film",
    "Palette",
    "Scene",
    "render",
    "write_film",
    "write_still",
]
