"""Canvas of a film frame: one scene or several side by side, a title above and a caption below."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PIL import Image

from pymunk_dragon.drawing.lettering import Lettering
from pymunk_dragon.drawing.moments import Moment
from pymunk_dragon.drawing.palette import CODES
from pymunk_dragon.drawing.scene import Scene

__all__ = ["Canvas"]

# Ratio of the title's type size to that of the other text.
TITLE_SCALE = 1.25
# Pixels between two scenes: just enough for a visible line.
GUTTER = 2


class Canvas:
    """Frame layout that draws several scenes as one picture.

    Parameters
    ----------
    scenes : sequence of Scene
        Scenes from left to right, all of the same size.
    headings : sequence of str
        Text above each scene: none, or one for each scene.
    title, caption : str
        Text above and below all scenes. An empty text takes no space; a long text is wrapped.
    font : str or Path, optional
        Font file of title, caption and headings.

    Raises
    ------
    ParameterError
        If the font lacks a character, or its file cannot be read.

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
        text_renderer = Lettering((width, height), font=font)
        large = Lettering((width, height), TITLE_SCALE, font=font)
        for name, text in (("title", title), ("caption", caption), *(("headings", heading) for heading in headings)):
            text_renderer.check(name, text)
        # Images of text lines, with x and y of their upper left corners.
        lines: list[tuple[Image.Image, int, int]] = []
        top = 0
        for text in large.wrapped(title, total):
            lines.append((large.line(text), 0, top))
            top += lines[-1][0].height
        for i, heading in enumerate(headings):
            # A heading that is too long is cropped at the width of its scene.
            line = text_renderer.line(heading)
            lines.append((line.crop((0, 0, min(line.width, width), line.height)), i * (width + GUTTER), top))
        if headings:
            top += text_renderer.line("").height
        self._top, bottom = top, top + height
        for text in text_renderer.wrapped(caption, total):
            lines.append((text_renderer.line(text), 0, bottom))
            bottom += lines[-1][0].height
        self.size = total, bottom
        self._frame = Image.new("L", self.size, CODES["background"])
        for i in range(1, len(scenes)):
            left = i * (width + GUTTER) - GUTTER
            self._frame.paste(CODES["curve"], (left, top, left + GUTTER, top + height))
        for image, left, upper in lines:
            self._frame.paste(image, (left, upper))

    def draw(self, moments: Sequence[Moment]) -> Image.Image:
        """Draw one frame (mode L, palette indices), given a moment for each scene."""
        pictures = [scene.draw(moment) for scene, moment in zip(self.scenes, moments, strict=True)]
        if pictures[0].size == self.size:
            return pictures[0]
        frame = self._frame.copy()
        for i, picture in enumerate(pictures):
            frame.paste(picture, (i * (picture.width + GUTTER), self._top))
        return frame
