"""Layout of a film's frames: one scene or several side by side, texts above and below, and a legend."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from PIL import Image, ImageDraw

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import font, text
from pymunk_dragon.drawing.camera import HEAD_SPAN
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.drawing.lettering import Lettering
from pymunk_dragon.drawing.overlay import OVERLAYS
from pymunk_dragon.drawing.palette import Palette
from pymunk_dragon.drawing.scene import CIRCLE_DASH, Scene
from pymunk_dragon.drawing.snapshots import Clip, Snapshot, Source, first_contact_until, sample, with_errors
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

# Ratio of the title's type size to that of the other text.
TITLE_SCALE = 1.25
# Pixels between two scenes: just enough for a visible line.
GUTTER = 2
# Free border on each side of the field of view, as a fraction of its size.
FIELD_BORDER = 0.01
# Pixels: a narrower picture has no legend, nor has one whose legend would take more lines.
LEGEND_WIDTH, LEGEND_LINES = 300, 2
# Height of a sample of a colour, as a fraction of the text height, which is its width.
SAMPLE_HEIGHT = 0.7
# Largest length of a scale bar, as a fraction of the width of a scene.
MAX_SCALE_BAR = 0.2
# Half the height of the ends of a scale bar, as a fraction of that of a sample.
TICK = 0.4


class Canvas:
    """Surface on which the scenes of a frame are drawn, with the texts around them; `size` is its size in pixels.

    There is one of `headings` for each of the scenes, or none. A long title or caption is wrapped, a long heading
    cropped. A `ParameterError` is raised if the font lacks a character or cannot be read.
    """

    def __init__(self, scenes: Sequence[Scene], headings: Sequence[str], film: Film) -> None:
        self.scenes = scenes
        width, height = scenes[0].size
        face, palette = film.font or font(), film.palette
        self._lefts = [i * (width + GUTTER) for i in range(len(scenes))]
        total = self._lefts[-1] + width
        lettering = Lettering((width, height), palette, font=face)
        large = Lettering((width, height), palette, TITLE_SCALE, font=face)
        for name, given in (("title", film.title), ("caption", film.caption), *(("headings", h) for h in headings)):
            lettering.check(name, given)
        above = [large.line(line) for line in large.wrapped(film.title, total)]
        if headings:
            above.append(Image.new("RGB", (total, lettering.line("").height), palette.rgb("background")))
            for left, heading in zip(self._lefts, headings, strict=True):
                line = lettering.line(heading)
                above[-1].paste(line.crop((0, 0, min(line.width, width), line.height)), (left, 0))
        below = _legend(scenes, total, lettering, palette) if film.legend and total >= LEGEND_WIDTH else []
        below += [lettering.line(line) for line in lettering.wrapped(film.caption, total)]
        self._top = sum(line.height for line in above)
        self.size = total, self._top + height + sum(line.height for line in below)
        self._frame = Image.new("RGB", self.size, palette.rgb("background"))
        # What the scenes leave free is the line between them.
        self._frame.paste(palette.rgb("curve"), (0, self._top, total, self._top + height))
        top = 0
        for line in [*above, Image.new("RGB", (0, height)), *below]:
            self._frame.paste(line, (0, top))
            top += line.height

    def draw(self, snapshots: Sequence[Snapshot]) -> Image.Image:
        """Draw one frame (mode RGB), given a snapshot for each scene."""
        frame = self._frame.copy()
        for scene, snapshot, left in zip(self.scenes, snapshots, self._lefts, strict=True):
            frame.paste(scene.draw(snapshot), (left, self._top))
        return frame


def _legend(scenes: Sequence[Scene], width: int, lettering: Lettering, palette: Palette) -> list[Image.Image]:
    """Return the lines of a legend, with a scale bar at the right end; none if they do not fit."""
    entries = _entries(scenes, lettering.height)
    places: list[tuple[int, int]] = []
    line, left = 0, 0
    for _, swatch, name in entries:
        room = swatch + lettering.line(name).width
        if left + room > width:
            line, left = line + 1, 0
        if room > width or line >= LEGEND_LINES:
            return []
        places.append((line, width - room if len(places) == len(entries) - 1 else left))
        left += room
    height = lettering.line("").height
    lines = [Image.new("RGB", (width, height), palette.rgb("background")) for _ in range(line + 1)]
    top, bottom = (round((height + side * SAMPLE_HEIGHT * lettering.height) / 2) for side in (-1, 1))
    for (kind, swatch, name), (line, left) in zip(entries, places, strict=True):
        lines[line].paste(lettering.line(name), (left + lettering.margin // 2 + swatch, 0))
        first = left + lettering.margin
        _draw_sample(ImageDraw.Draw(lines[line]), kind, (first, top, first + swatch, bottom), palette)
    return lines


def _entries(scenes: Sequence[Scene], height: int) -> list[tuple[str, int, str]]:
    """Return the kind, the width in pixels and the name of each sample of a legend; the scale bar is last."""
    entries = [("head", height, text("head")), ("body", height, text("body")), ("tail", height, text("tail"))]
    if any(scene.contact for scene in scenes):
        entries.append(("contact", height, text("in contact")))
    if any(scene.march.curve.circles for scene in scenes):
        entries.append(("circle", height, text("turning circle")))
    for factor in {scene.magnification for scene in scenes} - {None}:
        entries.append(("error", height, text("position error x {factor:,.0f}").format(factor=factor)))
    scale = scenes[0].scale
    longest = MAX_SCALE_BAR * scenes[0].size[0] / scale
    power = 10.0 ** math.floor(math.log10(longest))
    metres = next(step * power for step in (5, 2, 1) if step * power <= longest * (1 + 1e-9))
    return [*entries, ("scale", round(metres * scale), f"{metres:g} m")]


def _draw_sample(draw: ImageDraw.ImageDraw, kind: str, box: tuple[int, int, int, int], palette: Palette) -> None:
    left, top, right, bottom = box
    middle, half, ink = (top + bottom) // 2, round(TICK * (bottom - top)), palette.rgb("ink")
    if kind == "circle":
        for x in range(left, right, 2 * CIRCLE_DASH):
            draw.line((x, middle, x + CIRCLE_DASH - 1, middle), fill=ink)
    elif kind == "error":
        draw.line((left, middle, right, middle), fill=palette.rgb("motion"), width=2)
    elif kind == "scale":
        draw.line((left, middle, right, middle), fill=ink)
        for x in (left, right):
            draw.line((x, middle - half, x, middle + half), fill=ink)
    else:
        draw.rectangle(box, fill=palette.rgb(kind), outline=ink)


def sampled(sources: Sequence[Source], times: Array, film: Film) -> list[Clip]:
    """Sample `sources` at the `times` (F,), s, of a film. A march beside its run shows the position errors of the run.

    A `ParameterError` is raised if a source has no data for an overlay.
    """
    needs = {need: name for name in film.show if (need := OVERLAYS[name].needs)}
    clips = []
    for source in sources:
        _check_data(source, needs)
        clip = sample(source, times, needs, extent=film.camera.follow == "field")
        run = next((other for other in sources if isinstance(other, Run) and other.march is source), None)
        if run is not None:
            clip = _beside(clip, run, times, film)
        elif isinstance(source, March) and times[0] < times[-1]:
            clip = replace(clip, contact=first_contact_until(source, float(times[0]), float(times[-1])).contact)
        clips.append(clip)
    return clips


def _check_data(source: Source, needs: Mapping[str, str]) -> None:
    """Raise a ParameterError if a source has no data for one of the overlays, the values of `needs`."""
    if "impulses" in needs and (isinstance(source, March) or source.joint_impulses is None):
        raise ParameterError("show", needs["impulses"], "left out: only runs of the engine have joint impulses")
    if "touches" in needs and isinstance(source, March):
        raise ParameterError("show", needs["touches"], "left out: a march has no contacts, a run does")


def _beside(clip: Clip, run: Run, times: Array, film: Film) -> Clip:
    """Return the clip of a march beside its run, with errors."""
    widths, spacings = run.march.dragon.widths, run.march.dragon.spacings
    if film.camera.follow == "field":
        # Arrows as long as a bench.
        return with_errors(clip, run, times, math.inf, float(spacings.min()))
    # Outlines that are displaced by the width of a bench.
    reach = (film.camera.span or HEAD_SPAN * float(widths[0])) / 2
    return with_errors(clip, run, times, reach, float(widths.min()))


def lay_out(clips: Sequence[Clip], film: Film, since: float | None = None) -> Canvas:
    """Create the canvas of a film of `clips`. All scenes have one scale, because pictures side by side are compared.

    The pictures display the first time of the film, `since`, s, if it is given.
    """
    headings = film.headings or (tuple(clip.model for clip in clips) if len(clips) > 1 else ())
    if headings and len(headings) != len(clips):
        raise ParameterError("headings", headings, f"one for each picture, so {len(clips)}")
    face = font() or film.font
    centre, span = _field(clips, film, Lettering(film.shape, film.palette, font=face).line("").height)
    scenes = [
        Scene(
            clip.march,
            film.camera,
            centre=centre,
            span=film.camera.span or span,
            size=film.shape,
            palette=film.palette,
            times=clip.window,
            contact=clip.contact,
            gap=film.gap,
            show=film.show,
            largest_impulse=max(clip.largest_impulse for clip in clips),
            magnification=clip.magnification,
            since=since,
            font=face,
        )
        for clip in clips
    ]
    return Canvas(scenes, headings, film)


def _field(clips: Sequence[Clip], film: Film, text_height: int) -> tuple[tuple[float, float], float]:
    """Return the centre, m, and the width, m, of the ground in view, with `text_height` pixels free for texts."""
    extents = [clip.extent for clip in clips if clip.extent is not None]
    if not extents:
        return (0.0, 0.0), HEAD_SPAN * max(float(clip.march.dragon.widths[0]) for clip in clips)
    low, high = np.min(extents, axis=0)[0], np.max(extents, axis=0)[1]
    width, height = film.shape
    free = max(height - 2 * text_height, height / 2)
    span = (1 + 2 * FIELD_BORDER) * float(max(high[0] - low[0], (high[1] - low[1]) * width / free))
    return (float(low[0] + high[0]) / 2, float(low[1] + high[1]) / 2), span
