"""Layout of a film's frames: one scene or several side by side, texts above and below, and a legend."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from pymunk_dragon._arrays import Array
from pymunk_dragon._language import font, text
from pymunk_dragon.drawing import snapshots
from pymunk_dragon.drawing.camera import HEAD_SPAN
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.drawing.lettering import Lettering
from pymunk_dragon.drawing.overlay import OVERLAYS
from pymunk_dragon.drawing.palette import Palette
from pymunk_dragon.drawing.scene import CIRCLE_DASH, Scene
from pymunk_dragon.drawing.snapshots import Snapshot, Source, march_of
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.contact import Contact
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

# Ratio of the title's type size to that of the other text.
_TITLE_SCALE = 1.25
# Pixels between two scenes: just enough for a visible line.
_GUTTER = 2
# Free border on each side of the field of view, as a fraction of its size.
_FIELD_BORDER = 0.01
# Pixels: a narrower picture has no legend.
_LEGEND_WIDTH = 300
# Height of a sample of a colour, as a fraction of the text height, which is its width.
_SAMPLE_HEIGHT = 0.7
# Largest length of a scale bar, as a fraction of the width of a scene.
_MAX_SCALE_BAR = 0.2
# Half the height of the ends of a scale bar, as a fraction of that of a sample.
_TICK = 0.4


class Canvas:
    """Surface on which the frames of a film are drawn: scenes, and texts around them; `size` is its size in pixels.

    Pictures side by side are compared, so they have one scale. They display the first time of the film, `since`, s, if
    it is given. A long title or caption is wrapped, a long heading cropped. A `ParameterError` is raised if a source
    has no data for an overlay, or the font lacks a character.
    """

    def __init__(self, sources: Sequence[Source], times: Array, film: Film, since: float | None = None) -> None:
        width, height = film.shape
        lettering = Lettering(film.shape, film.palette, font=font())
        self.scenes, self._states = _scenes(sources, times, film, since, lettering.line("").height)
        self._lefts = range(0, len(sources) * (width + _GUTTER), width + _GUTTER)
        total = self._lefts[-1] + width
        above = _lines_above(_headings(sources, film), total, lettering, film)
        legend = film.legend and total >= _LEGEND_WIDTH
        below = _legend(self.scenes, total, lettering, film.palette) if legend else []
        below += [lettering.line(line) for line in lettering.wrapped(film.caption, total)]
        # What the scenes leave free is the line between them.
        parts = [*above, Image.new("RGB", (total, height), film.palette.rgb("curve")), *below]
        *tops, bottom = accumulate((part.height for part in parts), initial=0)
        self._top, self.size = tops[len(above)], (total, bottom)
        self._frame = Image.new("RGB", self.size, film.palette.rgb("background"))
        for part, top in zip(parts, tops, strict=True):
            self._frame.paste(part, (0, top))

    def frames(self) -> Iterator[Image.Image]:
        """Draw the frames (mode RGB), once."""
        for states in zip(*self._states, strict=True):
            frame = self._frame.copy()
            for scene, state, left in zip(self.scenes, states, self._lefts, strict=True):
                frame.paste(scene.draw(state), (left, self._top))
            yield frame


def _scenes(
    sources: Sequence[Source], times: Array, film: Film, since: float | None, text_height: int
) -> tuple[list[Scene], list[Iterator[Snapshot]]]:
    """Return the scene of each source and its states. A march beside its run shows the position errors of the run."""
    scenes, all_states = [], []
    centre, span = _field(sources, times, film, text_height)
    shared: dict[str, Any] = {"size": film.shape, "palette": film.palette, "gap": film.gap, "show": film.show}
    shared |= {"centre": centre, "span": span, "since": since, "font": font()}
    shared["largest_impulse"] = max(snapshots.largest_impulse(source, times) for source in sources)
    for source in sources:
        states, factor = snapshots.snapshots(source, times, _needs(source, film)), None
        run = _run_of(source, sources)
        if run is not None and run is not source:
            reach = span / 2 if film.camera.follow == "head" else math.inf
            states, factor = snapshots.with_errors(states, run, times, reach)
        window = first, last = (times if run is None else run.times)[[0, -1]].tolist()
        own: dict[str, Any] = {"times": window, "contact": _contact(source, first, last), "magnification": factor}
        scenes.append(Scene(march_of(source), film.camera, **own, **shared))
        all_states.append(states)
    return scenes, all_states


def _run_of(source: Source, sources: Sequence[Source]) -> Run | None:
    """Return a run itself, and of a march the run beside it."""
    runs = (other for other in sources if isinstance(other, Run))
    return next((run for run in runs if source is run or source is run.march), None)


def _needs(source: Source, film: Film) -> set[str]:
    """Return the fields of `Snapshot` that overlays need; a ParameterError if the source has no data for one."""
    needs = {need: name for name in film.show if (need := OVERLAYS[name].needs)}
    absent = {"impulses", "touches"} if isinstance(source, March) else {"impulses"}
    if isinstance(source, Run) and source.joint_impulses is not None:
        absent = set()
    for need in absent & needs.keys():
        raise ParameterError("show", needs[need], "left out: a march has no contacts, and only the engine has impulses")
    return set(needs)


def _contact(source: Source, first: float, last: float) -> Contact | None:
    """Return the first contact of a run, or of a march between two times, s."""
    if isinstance(source, Run):
        return source.first_contact
    return snapshots.first_contact_until(source, first, last).contact if first < last else None


def _field(sources: Sequence[Source], times: Array, film: Film, text_height: int) -> tuple[tuple[float, float], float]:
    """Return the centre, m, and the width, m, of the ground in view, with `text_height` pixels free for texts."""
    if film.camera.follow == "head":
        widest = max(float(march_of(source).dragon.widths[0]) for source in sources)
        return (0.0, 0.0), film.camera.span or HEAD_SPAN * widest
    lows, highs = zip(*(snapshots.extent(source, times) for source in sources), strict=True)
    (left, bottom), (right, top) = np.min(lows, axis=0).tolist(), np.max(highs, axis=0).tolist()
    width, height = film.shape
    free = max(height - 2 * text_height, height / 2)
    span = (1 + 2 * _FIELD_BORDER) * max(right - left, (top - bottom) * width / free)
    return ((left + right) / 2, (bottom + top) / 2), film.camera.span or span


def _headings(sources: Sequence[Source], film: Film) -> Sequence[str]:
    """Return the headings of a film: one for each of several pictures, or none."""
    if not film.headings:
        return [_model(source) for source in sources] if len(sources) > 1 else []
    if len(film.headings) != len(sources):
        raise ParameterError("headings", film.headings, f"one for each picture, so {len(sources)}")
    return film.headings


def _model(source: Source) -> str:
    """Return the name of the model that computed a source, with its options."""
    if isinstance(source, March) or source.player == "exact":
        return text("exact model")
    # A guide of the user's own has no other name.
    words = [text("engine"), {"none": text("no guide"), "rails": text("rails")}.get(source.guide or "", source.guide)]
    if source.settings is not None and source.settings.contacts == "resolve":
        words.append(text("contacts resolved"))
    return text(", ").join(filter(None, words))


def _lines_above(headings: Sequence[str], width: int, lettering: Lettering, film: Film) -> list[Image.Image]:
    """Return the lines above the scenes, title and headings."""
    for name, given in film.texts(headings):
        lettering.check(name, given)
    large = Lettering(film.shape, film.palette, _TITLE_SCALE, font=font())
    above = [large.line(line) for line in large.wrapped(film.title, width)]
    if headings:
        cells = [_row([lettering.line(heading)], film.shape[0], film.palette) for heading in headings]
        above.append(_row(cells, width, film.palette, _GUTTER))
    return above


def _row(parts: Sequence[Image.Image], width: int, palette: Palette, gap: int = 0) -> Image.Image:
    """Return pictures of one height side by side, cropped or filled to a width."""
    row, left = Image.new("RGB", (width, parts[0].height), palette.rgb("background")), 0
    for part in parts:
        row.paste(part, (left, 0))
        left += part.width + gap
    return row


def _legend(scenes: Sequence[Scene], width: int, lettering: Lettering, palette: Palette) -> list[Image.Image]:
    """Return the lines of a legend, with a scale bar at the right end."""
    names = {kind: name for scene in scenes for kind, name in _names(scene).items()}
    samples = [(kind, lettering.height, name) for kind, name in names.items()]
    lines, left = list[list[Image.Image]]([[]]), 0
    for kind, swatch, name in [*samples, _scale_bar(scenes[0])]:
        entry = _entry(kind, swatch, lettering.line(name), lettering, palette)
        if left + entry.width > width:
            lines, left = [*lines, []], 0
        lines[-1].append(entry)
        left += entry.width
    lines[-1].insert(-1, Image.new("RGB", (width - left, lines[-1][-1].height), palette.rgb("background")))
    return [_row(line, width, palette) for line in lines]


def _names(scene: Scene) -> dict[str, str]:
    """Return the kind and the name of each sample in the legend of a scene."""
    names = {"head": text("head"), "body": text("body"), "tail": text("tail")}
    if scene.contact:
        names["contact"] = text("in contact")
    if scene.march.curve.circles:
        names["circle"] = text("turning circle")
    if scene.magnification:
        names["error"] = text("position error x {factor:,.0f}").format(factor=scene.magnification)
    return names


def _scale_bar(scene: Scene) -> tuple[str, int, str]:
    """Return kind, width in pixels and name of a scale bar: the longest of 1, 2 or 5 times a power of ten, m."""
    longest = _MAX_SCALE_BAR * scene.size[0] / scene.scale
    power = 10.0 ** math.floor(math.log10(longest))
    metres = power * max(step for step in (1, 2, 5) if step * power <= longest * (1 + 1e-9))
    return "scale", round(metres * scene.scale), f"{metres:g} m"


def _entry(kind: str, swatch: int, name: Image.Image, lettering: Lettering, palette: Palette) -> Image.Image:
    """Return an entry of a legend: a sample, `swatch` pixels wide, and its name."""
    entry = Image.new("RGB", (swatch + name.width, name.height), palette.rgb("background"))
    entry.paste(name, (lettering.margin // 2 + swatch, 0))
    draw, left, right = ImageDraw.Draw(entry), lettering.margin, lettering.margin + swatch
    top, bottom = (round((name.height + side * _SAMPLE_HEIGHT * lettering.height) / 2) for side in (-1, 1))
    middle, half, ink = (top + bottom) // 2, round(_TICK * (bottom - top)), palette.rgb("ink")
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
        draw.rectangle((left, top, right, bottom), fill=palette.rgb(kind), outline=ink)
    return entry
