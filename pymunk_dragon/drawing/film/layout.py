"""Layout of a film's frames: one scene or several side by side, texts above and below, and a legend."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import accumulate

import numpy as np
from PIL import Image, ImageDraw

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.drawing import lettering
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.drawing.film.take import Take
from pymunk_dragon.drawing.marks import check_overlays
from pymunk_dragon.drawing.palette import COLOURS, colour_table
from pymunk_dragon.drawing.scene import Scene, text_height
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.run import Run

# Widths of the head bench in a view that follows it: 6 m for the paper's 0.3 m, which shows the
# head's turn of the spiral and both adjacent turns, where near misses occur.
_HEAD_SPAN = 20.0
# Ratio of the title's type size to that of the other text.
_TITLE_SCALE = 1.25
# Pixels between two scenes: just enough for a visible line.
_GUTTER = 2
# Free border on each side of the field of view, as a fraction of its size.
_FIELD_BORDER = 0.01
# Times at which the extent of a dragon, and the benches in view, are sampled.
_SAMPLES = 64
# Pixels: a narrower picture has no legend.
_LEGEND_WIDTH = 300
# Pixels: largest height of an H.264 stream that FFmpeg writes. Only texts in hundreds of lines are
# higher.
_MAX_HEIGHT = 16_384
# Largest length of a scale bar, as a fraction of the width of a scene.
_MAX_SCALE_BAR = 0.2

# Some times, s, and the poses (N, 3) then.
_Samples = list[tuple[float, Array]]


class Layout:
    """Scenes of a film side by side, with texts around them, from which frames of the `size` are drawn, pixels.

    Pictures side by side are compared, so they have one scale. A long title or caption is wrapped,
    a long heading cropped. A `ParameterError` is raised if a source has no data for an overlay, or
    the font lacks a character.
    """

    def __init__(self, takes: Sequence[Take], times: Array, film: Film) -> None:
        (width, height), letters = film.shape, text_height(film.shape)
        self._lefts = range(0, len(takes) * (width + _GUTTER), width + _GUTTER)
        total = self._lefts[-1] + width
        has_legend = film.legend and total >= _LEGEND_WIDTH
        # The extent of the field and the legend need them.
        sampled = has_legend or film.camera.follow == "field"
        samples = [_sampled(take, times) if sampled else [] for take in takes]
        self._times = times
        self.scenes = _scenes(takes, samples, times, film)
        headings = _headings(takes, film)
        for name, given in film.texts(headings):
            lettering.check(name, given)
        above = lettering.wrapped(film.title, round(_TITLE_SCALE * letters), total)
        if headings:
            cells = [
                _row([lettering.line(heading, letters)], width + _GUTTER) for heading in headings
            ]
            above.append(_row(cells, total))
        below = _legend(self.scenes, samples, total, letters) if has_legend else []
        below += lettering.wrapped(film.caption, letters, total)
        # What the scenes leave free is the line between them.
        parts = [*above, Image.new("RGB", (total, height), COLOURS.curve), *below]
        *tops, bottom = accumulate((part.height for part in parts), initial=0)
        self._top, self.size = tops[len(above)], (total, bottom)
        if bottom > _MAX_HEIGHT:
            name, longest = max(film.texts(headings), key=lambda each: len(each[1]))
            raise ParameterError(
                name,
                longest,
                f"shorter: the film is {bottom} pixels high, and at most {_MAX_HEIGHT}",
            )
        self._frame = Image.new("RGB", self.size, COLOURS.background)
        for part, top in zip(parts, tops, strict=True):
            self._frame.paste(part, (0, top))

    def frames(self) -> Iterator[Image.Image]:
        """Draw the frames (mode RGB)."""
        for shown in zip(*(scene.source.at(self._times) for scene in self.scenes), strict=True):
            frame = self._frame.copy()
            for scene, (time, poses), left in zip(self.scenes, shown, self._lefts, strict=True):
                frame.paste(scene.draw(time, poses), (left, self._top))
            yield frame

    def pictures(self, progress: Callable[[int, int], None] | None) -> Iterator[Image.Image]:
        """Draw the frames with the table of colours (mode P); `progress` is called after each."""
        colours = Image.new("P", (1, 1))
        colours.putpalette(colour_table().tobytes())
        for done, frame in enumerate(self.frames(), start=1):
            yield frame.quantize(palette=colours, dither=Image.Dither.NONE)
            if progress is not None:
                progress(done, len(self._times))


def _sampled(take: Take, times: Array) -> _Samples:
    """Return samples of the states of a take over `times` (F,)."""
    return list(take.at(np.linspace(times[0], times[-1], min(_SAMPLES, len(times)))))


def _scenes(
    takes: Sequence[Take], samples: Sequence[_Samples], times: Array, film: Film
) -> list[Scene]:
    """Return the scene of each take. A march beside its run shows the position errors of the run."""
    scenes = []
    centre, span = _field(takes, samples, film)
    follow = film.camera.follow
    for take in takes:
        check_overlays(film.show, take)
        run = take.run or take.beside
        first, last = (times if run is None else run.times)[[0, -1]].tolist()
        scene = Scene(
            source=take,
            follow=follow,
            centre=centre,
            span=span,
            size=film.shape,
            show=film.show,
            times=(first, last),
            contact=take.contact,
            beside=take.beside,
            factor=None if take.beside is None else _magnification(take.beside, follow),
        )
        scenes.append(scene)
    return scenes


def _magnification(run: Run, follow: str) -> float | None:
    """Return the factor with which errors are as long as a bench is wide, or as a bench; None without errors.

    It is 1 for larger errors. If the camera follows the head, only the first benches count.
    """
    dragon, head = run.march.dragon, follow == "head"
    length, error = (dragon.widths, run.head_drift) if head else (dragon.spacings, run.max_drift)
    return max(1.0, float(f"{length.min() / error:.0e}")) if error > 0 else None


def _field(
    takes: Sequence[Take], samples: Sequence[_Samples], film: Film
) -> tuple[tuple[float, float], float]:
    """Return the centre, m, and the width, m, of the ground in view, with two lines free for texts."""
    if film.camera.follow == "head":
        widest = max(float(take.march.dragon.widths[0]) for take in takes)
        return (0.0, 0.0), film.camera.span or _HEAD_SPAN * widest
    lows, highs = zip(*map(_extent, takes, samples), strict=True)
    (left, bottom), (right, top) = np.min(lows, axis=0).tolist(), np.max(highs, axis=0).tolist()
    width, height = film.shape
    free = max(height - 2 * lettering.line("", text_height(film.shape)).height, height / 2)
    span = (1 + 2 * _FIELD_BORDER) * max(right - left, (top - bottom) * width / free)
    return ((left + right) / 2, (bottom + top) / 2), film.camera.span or span


def _extent(take: Take, samples: _Samples) -> tuple[Array, Array]:
    """Return the lower left and upper right corner (2,), m, of the dragon's bounding box in samples."""
    corners = np.concatenate(
        [take.march.dragon.outlines(poses).reshape(-1, 2) for _, poses in samples]
    )
    return corners.min(axis=0), corners.max(axis=0)


def _headings(takes: Sequence[Take], film: Film) -> Sequence[str]:
    """Return the headings of a film: one for each of several pictures, or none."""
    if not film.headings:
        return [_model(take.run) for take in takes] if len(takes) > 1 else []
    if len(film.headings) != len(takes):
        raise ParameterError("headings", film.headings, f"one for each picture, so {len(takes)}")
    return film.headings


def _model(run: Run | None) -> str:
    """Return the name of the model that computed a run, with what its guide does, or of the exact model."""
    if run is None or run.player == "exact":
        return text("exact model")
    # A guide of the user's own has no other name.
    guide = run.guide
    if run.free_from == 1:
        guide = text("only the head is guided")
    elif guide == "rails":
        guide = text("dancers guide every bench")
    return text(": ").join(filter(None, (text("engine"), guide)))


def _row(parts: Sequence[Image.Image], width: int) -> Image.Image:
    """Return pictures side by side, cropped or filled to a width."""
    row, left = Image.new("RGB", (width, parts[0].height), COLOURS.background), 0
    for part in parts:
        row.paste(part, (left, 0))
        left += part.width
    return row


def _legend(
    scenes: Sequence[Scene], samples: Sequence[_Samples], width: int, letters: int
) -> list[Image.Image]:
    """Return the lines of a legend of what is in view, and a scale bar: 1, 2 or 5 times a power of ten, m."""
    names = {
        "head": text("head"),
        "body": text("body"),
        "tail": text("tail"),
        "contact": text("in contact"),
    }
    seen = set[str]().union(*map(Scene.parts, scenes, samples))
    shown = [(name, getattr(COLOURS, part)) for part, name in names.items() if part in seen]
    entries = [_entry(colour, letters, letters // 2, name, letters) for name, colour in shown]
    for factor in filter(None, (scene.factor for scene in scenes)):
        name = text("position error x {factor:,.0f}").format(factor=factor)
        entries.append(_entry(COLOURS.motion, letters, 1, name, letters))
    scale, longest = scenes[0].scale, _MAX_SCALE_BAR * scenes[0].size[0] / scenes[0].scale
    power = 10.0 ** math.floor(math.log10(longest))
    metres = power * max(step for step in (1, 2, 5) if step * power <= longest * (1 + 1e-9))
    entries.append(_entry(COLOURS.ink, round(metres * scale), 1, f"{metres:g} m", letters))
    lines, left = list[list[Image.Image]]([[]]), 0
    for entry in entries:
        if left + entry.width > width:
            lines, left = [*lines, []], 0
        lines[-1].append(entry)
        left += entry.width
    return [_row(line, width) for line in lines]


def _entry(colour: str, width: int, height: int, name: str, letters: int) -> Image.Image:
    """Return an entry of a legend: a sample of a colour with a width and half a height, pixels, and its name."""
    label, left = lettering.line(name, letters), letters // 3
    entry = Image.new("RGB", (width + label.width, label.height), COLOURS.background)
    entry.paste(label, (width + left // 2, 0))
    top = (label.height - height) // 2
    ImageDraw.Draw(entry).rectangle((left, top, left + width, top + height), fill=colour)
    return entry
