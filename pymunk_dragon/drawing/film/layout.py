"""Layout of a film's frames: one scene or several side by side, a title above and a caption below."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import font
from pymunk_dragon.drawing.camera import HEAD_SPAN
from pymunk_dragon.drawing.film.legend import legend_lines
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.drawing.lettering import Lettering
from pymunk_dragon.drawing.palette import CODES
from pymunk_dragon.drawing.scene import Scene
from pymunk_dragon.drawing.snapshot import Snapshot
from pymunk_dragon.drawing.snapshots import Clip, Source, first_contact_until, sample, with_errors
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

# Ratio of the title's type size to that of the other text.
TITLE_SCALE = 1.25
# Pixels between two scenes: just enough for a visible line.
GUTTER = 2
# Free border on each side of the field of view, as a fraction of its size.
FIELD_BORDER = 0.01


class Canvas:
    """Surface on which the scenes of a frame are drawn, with the texts around them.

    Parameters
    ----------
    scenes : sequence of Scene
        Scenes from left to right, all of the same size.
    headings : sequence of str
        Text above each scene: none, or one for each scene.
    title, caption : str
        Text above and below all scenes. An empty text takes no space; a long text is wrapped.
    legend : bool
        Whether a legend and a scale bar are drawn between the scenes and the caption.
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
        *,
        legend: bool = False,
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
        for line in legend_lines(scenes, total, text_renderer) if legend else ():
            lines.append((line, 0, bottom))
            bottom += line.height
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

    def draw(self, snapshots: Sequence[Snapshot]) -> Image.Image:
        """Draw one frame (mode L, palette indices), given a snapshot for each scene."""
        pictures = [scene.draw(snapshot) for scene, snapshot in zip(self.scenes, snapshots, strict=True)]
        if pictures[0].size == self.size:
            return pictures[0]
        frame = self._frame.copy()
        for i, picture in enumerate(pictures):
            frame.paste(picture, (i * (picture.width + GUTTER), self._top))
        return frame


def sampled(sources: Sequence[Source], times: Array, film: Film) -> list[Clip]:
    """Sample `sources` at the `times` (F,), s, of a film. A march beside its run shows the position errors of the run.

    Raises
    ------
    ParameterError
        If an overlay is unknown, or a source has no data for it.
    """
    whole = film.camera.follow == "field"
    clips = []
    for source in sources:
        clip = sample(source, times, film.show, extent=whole)
        run = next((other for other in sources if isinstance(other, Run) and other.march is source), None)
        if run is not None:
            dragon = run.march.dragon
            # Arrows as long as a bench, or outlines that are displaced by their width: see `OVERLAYS`.
            length = float(dragon.spacings.min() if whole else dragon.widths.min())
            reach = np.inf if whole else (film.camera.span or HEAD_SPAN * float(dragon.widths[0])) / 2
            clip = with_errors(clip, run, times, reach, length)
        elif isinstance(source, March) and times[0] < times[-1]:
            clip = replace(clip, contact=first_contact_until(source, float(times[0]), float(times[-1])).contact)
        clips.append(clip)
    return clips


def lay_out(clips: Sequence[Clip], film: Film, since: float | None = None) -> Canvas:
    """Create the canvas of a film of `clips`. All scenes have one scale, because pictures side by side are compared.

    The pictures display the first time of the film, `since`, s, if it is given.

    Raises
    ------
    ParameterError
        If the number of headings is wrong, or the font cannot be used.
    """
    headings = film.headings or (tuple(clip.model for clip in clips) if len(clips) > 1 else ())
    if headings and len(headings) != len(clips):
        raise ParameterError("headings", headings, f"one for each picture, so {len(clips)}")
    centre, span = (0.0, 0.0), HEAD_SPAN * max(float(clip.march.dragon.widths[0]) for clip in clips)
    face = font() or film.font
    text_height = Lettering(film.shape, font=face).line("").height
    extents = [clip.extent for clip in clips if clip.extent is not None]
    if extents:
        low, high = np.min(extents, axis=0)[0], np.max(extents, axis=0)[1]
        centre = (float(low[0] + high[0]) / 2, float(low[1] + high[1]) / 2)
        width, height = film.shape
        # Between the texts at the top and those at the bottom.
        free = max(height - 2 * text_height, height / 2)
        span = (1 + 2 * FIELD_BORDER) * float(max(high[0] - low[0], (high[1] - low[1]) * width / free))
    scenes = [
        Scene(
            clip.march,
            film.camera,
            centre=centre,
            span=film.camera.span or span,
            size=film.shape,
            times=clip.window,
            contact=clip.contact,
            gap=film.gap,
            marks=film.show,
            largest_impulse=max(clip.largest_impulse for clip in clips),
            magnification=clip.magnification,
            since=since,
            font=face,
        )
        for clip in clips
    ]
    return Canvas(scenes, headings, film.title, film.caption, legend=film.legend, font=film.font or font())
