"""Layout of a film's frames: scenes side by side, texts above and below, and a legend."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import accumulate

import numpy as np
from PIL import Image, ImageDraw

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import text
from pymunk_dragon.drawing import lettering
from pymunk_dragon.drawing.camera import Camera
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.drawing.film.take import Take
from pymunk_dragon.drawing.film.timing import cut_time
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
    """Scenes of a film side by side, with texts around them.

    Frames of the `size` are drawn from it, pixels. Pictures side by side are compared, so they have
    one scale. A long title or caption is wrapped, a long heading cropped. A `ParameterError` is
    raised if a source has no data for an overlay, or the font lacks a character.
    """

    def __init__(self, takes: Sequence[Take], times: Array, film: Film) -> None:
        width, height = film.shape
        letters = text_height(film.shape)
        self._lefts = range(0, len(takes) * (width + _GUTTER), width + _GUTTER)
        total = self._lefts[-1] + width
        sampled = np.linspace(times[0], times[-1], min(_SAMPLES, len(times)))
        samples = [list(take.at(sampled)) for take in takes]
        self._times = times
        self._fps = film.fps
        self.scenes = _scenes(takes, samples, times, film)
        # Scenes before the cut, and its time.
        self._before = self.scenes
        self._cut = -math.inf
        if film.camera.follow == "cut":
            whole = replace(film, camera=Camera())
            self._before = _scenes(takes, samples, times, whole)
            self._cut = cut_time(takes)

        headings = _headings(takes, film)
        texts = film.texts(headings)
        for name, given in texts:
            lettering.check(name, given)
        above = lettering.wrapped(film.title, round(_TITLE_SCALE * letters), total)
        if headings:
            lines = [lettering.line(heading, letters) for heading in headings]
            cells = [_row([line], width + _GUTTER) for line in lines]
            above.append(_row(cells, total))
        below = lettering.wrapped(film.caption, letters, total)
        if film.legend and total >= _LEGEND_WIDTH:
            one = self._before is self.scenes
            below = [*_legend(self._before, samples, total, letters, has_one_scale=one), *below]

        # What the scenes leave free is the line between them.
        middle = Image.new("RGB", (total, height), COLOURS.curve)
        parts = [*above, middle, *below]
        *tops, bottom = accumulate((part.height for part in parts), initial=0)
        self._top = tops[len(above)]
        self.size = total, bottom
        if bottom > _MAX_HEIGHT:
            name, longest = max(texts, key=lambda each: len(each[1]))
            bound = f"shorter: the film is {bottom} pixels high, and at most {_MAX_HEIGHT}"
            raise ParameterError(name, longest, bound)

        self._frame = Image.new("RGB", self.size, COLOURS.background)
        for part, top in zip(parts, tops, strict=True):
            self._frame.paste(part, (0, top))

    def frames(self) -> Iterator[Image.Image]:
        """Draw the frames (mode RGB)."""
        states = [scene.source.at(self._times) for scene in self.scenes]
        # Simulated time in a second of film; the last frame stays, and a still has no speed.
        rates = (self._fps * np.diff(self._times)).tolist()
        rates += rates[-1:] or [None]
        for rate, *shown in zip(rates, *states, strict=True):
            frame = self._frame.copy()
            scenes = self._before if shown[0][0] < self._cut else self.scenes
            for scene, (time, poses), left in zip(scenes, shown, self._lefts, strict=True):
                # No name for the picture: it would keep its memory while the next one is drawn.
                frame.paste(scene.draw(time, poses, rate), (left, self._top))
            yield frame

    def pictures(self, progress: Callable[[int, int], None] | None) -> Iterator[Image.Image]:
        """Draw the frames with the table of colours (mode P); `progress` is called after each."""
        colours = Image.new("P", (1, 1))
        colours.putpalette(colour_table().tobytes())
        for done, frame in enumerate(self.frames(), start=1):
            yield frame.quantize(palette=colours, dither=Image.Dither.NONE)
            if progress is not None:
                progress(done, len(self._times))


def _scenes(
    takes: Sequence[Take], samples: Sequence[_Samples], times: Array, film: Film
) -> list[Scene]:
    """Scene of each take. A march beside its run shows the position errors of the run."""
    scenes = []
    centre, span = _field(takes, samples, film)
    follow = "field" if film.camera.follow == "field" else "head"
    for take in takes:
        check_overlays(film.show, take)
        run = take.run or take.beside
        shown = times if run is None else run.times
        scene = Scene(
            source=take,
            follow=follow,
            centre=centre,
            span=span,
            size=film.shape,
            show=film.show,
            times=(float(shown[0]), float(shown[-1])),
            contact=take.contact,
            beside=take.beside,
            factor=None if take.beside is None else _magnification(take.beside, follow),
        )
        scenes.append(scene)
    return scenes


def _magnification(run: Run, follow: str) -> float | None:
    """Factor with which errors are as long as a bench is wide, or as a bench.

    It is 1 for larger errors, and None without errors. If the camera follows the head, only the
    first benches count.
    """
    dragon = run.march.dragon
    length, error = dragon.spacings.min(), run.max_drift
    if follow == "head":
        length, error = dragon.widths.min(), run.head_drift
    return max(1.0, float(f"{length / error:.0e}")) if error > 0 else None


def _field(
    takes: Sequence[Take], samples: Sequence[_Samples], film: Film
) -> tuple[tuple[float, float], float]:
    """Centre, m, and width, m, of the ground in view, with two lines free for texts."""
    given = film.camera.span
    if film.camera.follow != "field":
        widest = max(float(take.march.dragon.widths[0]) for take in takes)
        return (0.0, 0.0), given or _HEAD_SPAN * widest

    outlines = []
    for take, sampled in zip(takes, samples, strict=True):
        outlines += [take.march.dragon.outlines(poses).reshape(-1, 2) for _, poses in sampled]
    corners = np.concatenate(outlines)
    left, bottom = corners.min(axis=0).tolist()
    right, top = corners.max(axis=0).tolist()
    width, height = film.shape
    line = lettering.line("", text_height(film.shape))
    free = max(height - 2 * line.height, height / 2)
    span = (1 + 2 * _FIELD_BORDER) * max(right - left, (top - bottom) * width / free)
    return ((left + right) / 2, (bottom + top) / 2), given or span


def _headings(takes: Sequence[Take], film: Film) -> Sequence[str]:
    """Headings of a film: one for each of several pictures, or none."""
    if not film.headings:
        return [_model(take.run) for take in takes] if len(takes) > 1 else []
    if len(film.headings) != len(takes):
        raise ParameterError("headings", film.headings, f"one for each picture, so {len(takes)}")
    return film.headings


def _model(run: Run | None) -> str:
    """Name of the model that computed a run, with what its guide does."""
    if run is None or run.is_exact_march:
        return text("exact model")
    # A guide of the user's own has no other name.
    guide = run.guide
    if run.free_from == 1:
        guide = text("only the head is guided")
    elif run.free_from is not None:
        guide = text("benches are free from bench {bench} on", bench=run.free_from)
    elif guide == "rails":
        guide = text("dancers guide every bench")
    model = text("exact model") if run.player == "exact" else text("engine")
    return text(": ").join(filter(None, (model, guide)))


def _row(parts: Sequence[Image.Image], width: int) -> Image.Image:
    """Pictures side by side, cropped or filled to a width."""
    row = Image.new("RGB", (width, parts[0].height), COLOURS.background)
    left = 0
    for part in parts:
        row.paste(part, (left, 0))
        left += part.width
    return row


def _legend(
    scenes: Sequence[Scene],
    samples: Sequence[_Samples],
    width: int,
    letters: int,
    *,
    has_one_scale: bool,
) -> list[Image.Image]:
    """Lines of a legend of what is in view, and a scale bar where all frames have one scale."""
    names = {
        "head": text("head"),
        "body": text("body"),
        "tail": text("tail"),
        "contact": text("in contact"),
    }
    seen = set[str]().union(*map(Scene.parts, scenes, samples))
    entries = []
    for part, name in names.items():
        if part in seen:
            colour = getattr(COLOURS, part)
            entries.append(_entry(colour, letters, letters // 2, name, letters))
    for scene in scenes:
        if scene.factor:
            name = text("position error x {factor:,.0f}", factor=scene.factor)
            entries.append(_entry(COLOURS.motion, letters, 1, name, letters))

    if has_one_scale:
        entries.append(_scale_bar(scenes[0], letters))

    lines = list[list[Image.Image]]([[]])
    left = 0
    for entry in entries:
        if left + entry.width > width:
            lines.append([])
            left = 0
        lines[-1].append(entry)
        left += entry.width
    return [_row(line, width) for line in lines]


def _scale_bar(scene: Scene, letters: int) -> Image.Image:
    """Entry with a scale bar, which is 1, 2 or 5 times a power of ten long, m."""
    longest = _MAX_SCALE_BAR * scene.span
    power = 10.0 ** math.floor(math.log10(longest))
    most = longest * (1 + 1e-9)
    metres = power * max(step for step in (1, 2, 5) if step * power <= most)
    return _entry(COLOURS.ink, round(metres * scene.scale), 1, f"{metres:g} m", letters)


def _entry(colour: str, width: int, height: int, name: str, letters: int) -> Image.Image:
    """Entry of a legend: its name, and a sample of its colour.

    The sample has a width and half a height, pixels.
    """
    label = lettering.line(name, letters)
    left = letters // 3
    top = (label.height - height) // 2
    entry = Image.new("RGB", (width + label.width, label.height), COLOURS.background)
    entry.paste(label, (width + left // 2, 0))
    ImageDraw.Draw(entry).rectangle((left, top, left + width, top + height), fill=colour)
    return entry
