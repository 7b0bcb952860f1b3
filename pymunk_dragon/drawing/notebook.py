"""The picture of a march or run in a notebook; `pymunk_dragon` registers it with IPython."""

from pymunk_dragon.drawing.film import still_png
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

# Pixels: width and height, twice those on a screen with two pixels to the point.
_SIZE = 640


def picture(source: March | Run) -> bytes:
    """Content of a PNG file of a run as it ended, or of a march as it begins."""
    time = source.interval[1] if isinstance(source, Run) else 0.0
    return still_png(source, time, Film(size=_SIZE))
