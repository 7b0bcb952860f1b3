"""The whole frame of a film: one scene or several side by side, a title above and a caption below."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PIL import Image

from pymunk_dragon.render.lettering import Lettering
from pymunk_dragon.render.moments import Moment
from pymunk_dragon.render.palette import CODES
from pymunk_dragon.render.scene import Scene

__all__ = ["Sheet"]

# How much larger than the type in the picture the title is.
TITLE = 1.25
# Pixels between two scenes.
GUTTER = 2


class Sheet:
    """Draws scenes as one picture.

    Parameters
    ----------
    scenes : sequence of Scene
        What stands side by side, all of one size.
    headings : sequence of str
        What stands above each of them; none, or one for each scene.
    title, caption : str
        Lines above and below all; an empty one takes no room, a long one several lines.
    font : str or Path, optional
        File of the face of these words.

    Raises
    ------
    ParameterError
        If the face lacks a character, or its file cannot be read.

    Attributes
    ----------
    scenes : sequence of Scene
        As given.
    size : tuple of int
        Width and height of a picture, pixels.
    """

    def __init__(
        self,
        scenes: Sequence[Scene],
        headings: Sequence[str] = (),
        title: str = "",
        caption: str = "",
        font: str | Path | None = None,
    ) -> None:
        self.scenes = scenes
        width, height = scenes[0].size
        total = len(scenes) * (width + GUTTER) - GUTTER
        type_ = Lettering((width, height), font=font)
        large = Lettering((width, height), TITLE, font=font)
        for name, text in (("title", title), ("caption", caption), *(("headings", heading) for heading in headings)):
            type_.check(name, text)
        # What stands where: patches of type at their upper left corners.
        lines: list[tuple[Image.Image, int, int]] = []
        top = 0
        for text in large.wrapped(title, total):
            lines.append((large.line(text), 0, top))
            top += lines[-1][0].height
        for i, heading in enumerate(headings):
            # One that is too long is cut, and does not run into the next.
            line = type_.line(heading)
            lines.append((line.crop((0, 0, min(line.width, width), line.height)), i * (width + GUTTER), top))
        if headings:
            top += type_.line("").height
        self._top, bottom = top, top + height
        for text in type_.wrapped(caption, total):
            lines.append((type_.line(text), 0, bottom))
            bottom += lines[-1][0].height
        self.size = total, bottom
        self._frame = Image.new("L", self.size, CODES["background"])
        for i in range(1, len(scenes)):
            left = i * (width + GUTTER) - GUTTER
            self._frame.paste(CODES["curve"], (left, top, left + GUTTER, top + height))
        for patch, left, upper in lines:
            self._frame.paste(patch, (left, upper))

    def draw(self, moments: Sequence[Moment]) -> Image.Image:
        """Picture (mode L, palette indices) of a moment for each scene."""
        pictures = [scene.draw(moment) for scene, moment in zip(self.scenes, moments, strict=True)]
        if pictures[0].size == self.size:
            return pictures[0]
        sheet = self._frame.copy()
        for i, picture in enumerate(pictures):
            sheet.paste(picture, (i * (picture.width + GUTTER), self._top))
        return sheet
