"""Figures on a slide: text is large, has contrast, and covers neither lines nor other text; in English and Chinese."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from marches import ARM, TRACTOR, U_TURN

from pymunk_dragon._language import LANGUAGES, in_language
from pymunk_dragon.drawing import Palette
from pymunk_dragon.drawing.figures import FIGURES, figure
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.physics import simulate
from pymunk_dragon.studies import max_speed, min_pitch, sensitivity, u_turn
from pymunk_dragon.sweeps import sweep

# Height of a slide in lines of its smallest text.
LINES = 40
# Least contrast of text, and of lines.
TEXT_CONTRAST, LINE_CONTRAST = 4.5, 3.0
# Points: width of a line that a label may touch by its empty border.
BORDER = 1.5

CHARTS = [name for name, kind in FIGURES.items() if kind.still is None]
OTHERS = {"u-turn": Run.exact(U_TURN, np.linspace(-20, 20, 5)), "tractor": TRACTOR, "arm": ARM}


@cache
def played() -> Run:
    return simulate(March(Dragon(benches=40)), start=400, substep=0.02, iterations=15)


@cache
def result(name: str) -> Any:
    short = Dragon(benches=25)
    return {
        "min-pitch": min_pitch,
        "min-pitch of a wide circle": lambda: min_pitch(radius=8.0),
        "max-speed": max_speed,
        "max-speed of another circle": lambda: max_speed(radius=6.0, limit=3.0),
        "sensitivity": lambda: sensitivity(short),
        "u-turn": lambda: u_turn(short, arcs=3),
        "u-turn without search": lambda: u_turn(short, search=False),
    }[name]()


STUDIES = ["min-pitch", "min-pitch of a wide circle", "max-speed", "max-speed of another circle", "sensitivity"]
STUDIES += ["u-turn", "u-turn without search"]


@cache
def drawing(name: str, lang: str = "en") -> Any:
    with in_language(lang):
        if name in FIGURES:
            return figure(name, played() if FIGURES[name].needs_run else None)
        return result(name).plot()


@pytest.fixture
def texts(monkeypatch: pytest.MonkeyPatch) -> Callable[[Any], list[tuple[Any, Any]]]:
    """A function that gives all texts that are drawn, with their boxes in pixels."""
    from matplotlib.text import Text

    draw, seen = Text.draw, []

    def draw_and_note(text: Any, *arguments: Any, **options: Any) -> None:
        draw(text, *arguments, **options)
        if text.get_visible() and text.get_text().strip():
            # Of an annotation, the box of the text without its leader.
            seen.append((text, Text.get_window_extent(text)))

    monkeypatch.setattr(Text, "draw", draw_and_note)

    def drawn(drawing: Any) -> list[tuple[Any, Any]]:
        seen.clear()
        drawing.savefig(io.BytesIO(), format="png")
        return list(seen)

    return drawn


def crossing(box: Any, path: Any) -> bool:
    """Whether a path in pixels crosses the inner part of a box."""
    inner = type(box)([[box.x0 + BORDER, box.y0 + BORDER], [box.x1 - BORDER, box.y1 - BORDER]])
    return bool(len(path.vertices) > 1 and path.intersects_bbox(inner, filled=False))


def lines(drawing: Any) -> Iterator[tuple[Any, Any]]:
    """Curves and straight lines in the axes, without ticks and grids, as paths in pixels, cut off at their frames."""
    from matplotlib.path import Path

    for axes in drawing.axes:
        for line in axes.get_lines():
            if line.get_linestyle() != "None":
                path = Path(line.get_transform().transform(line.get_xydata()))
                clipped = path.cleaned(clip=axes.get_window_extent().extents, remove_nans=True)
                yield line, Path(clipped.vertices[:-1], clipped.codes[:-1])  # Without the code that ends it.


def luminance(colour: Any) -> float:
    from matplotlib.colors import to_rgb

    parts = np.array(to_rgb(colour))
    return float(np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4) @ (0.2126, 0.7152, 0.0722))


def contrast(one: Any, other: Any) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def check_texts(drawing: Any, boxes: list[tuple[Any, Any]]) -> None:
    """No text is cut off, or overlaps other text, or covers a line without hiding it."""
    width, height = drawing.canvas.get_width_height()
    for text, box in boxes:
        assert 10 < box.x0 < box.x1 < width - 10, text
        assert 10 < box.y0 < box.y1 < height - 10, text
        # Numbers in discs and on benches are on the lines that they number.
        if text.get_bbox_patch() is None and not text.get_text().isdigit():
            for line, path in lines(drawing):
                assert not crossing(box, path), (text, line)
    for (one, first), (other, second) in combinations(boxes, 2):
        assert not first.overlaps(second), (one, other)


@pytest.mark.parametrize("lang", LANGUAGES)
@pytest.mark.parametrize("name", CHARTS + STUDIES)
def test_labels_are_clear_of_lines_and_of_each_other(name: str, lang: str, texts: Any) -> None:
    shown = drawing(name, lang)
    boxes = texts(shown)
    assert len(boxes) > 5
    check_texts(shown, boxes)


@pytest.mark.parametrize("name", [name for name in CHARTS if not FIGURES[name].needs_run and name != "spiral"])
@pytest.mark.parametrize("source", OTHERS)
def test_labels_of_other_curves_do_not_overlap(name: str, source: str, texts: Any) -> None:
    boxes = texts(figure(name, OTHERS[source]))
    for (one, first), (other, second) in combinations(boxes, 2):
        assert not first.overlaps(second), (one, other)


@pytest.mark.parametrize("name", CHARTS + STUDIES)
def test_a_slide_is_filled_and_its_text_is_large(name: str, texts: Any) -> None:
    shown = drawing(name)
    width, height = shown.get_size_inches()
    assert width / height == pytest.approx(16 / 9)
    assert min(text.get_size() for text, _ in texts(shown)) >= 72 * height / LINES


@pytest.mark.parametrize("name", CHARTS + STUDIES)
def test_text_and_lines_have_contrast(name: str, texts: Any) -> None:
    from matplotlib.patheffects import withStroke

    shown, ground = drawing(name), Palette().background
    for text, _ in texts(shown):
        patch = text.get_bbox_patch()
        behind = ground if patch is None else patch.get_facecolor()
        assert contrast(text.get_color(), behind) >= TEXT_CONTRAST, text
        for effect in text.get_path_effects():
            assert isinstance(effect, withStroke)
    for line, _ in lines(shown):
        assert contrast(line.get_color(), ground) >= LINE_CONTRAST, line


@pytest.mark.parametrize("lang", LANGUAGES)
@pytest.mark.parametrize(
    "axes", [{"pitch": [0.4, 0.45, 0.5, 0.55]}, {"pitch": [0.45, 0.5, 0.55], "width": [0.25, 0.3]}]
)
def test_labels_of_a_sweep_are_in_the_language_and_do_not_overlap(axes: Any, lang: str, texts: Any) -> None:
    from concurrent.futures import ThreadPoolExecutor

    found = sweep({"benches": 20}, axes, "contact-time", executor=ThreadPoolExecutor(2))
    with in_language(lang):
        boxes = texts(found.plot())
    for (one, first), (other, second) in combinations(boxes, 2):
        assert not first.overlaps(second), (one, other)
    written = [text.get_text() for text, _ in boxes]
    assert {"en": "pitch, m", "zh": "螺距，m"}[lang] in written
    assert {"en": "Time of the first contact", "zh": "首次碰撞的时刻"}[lang] in written


@pytest.mark.parametrize("name", CHARTS + STUDIES)
def test_chinese_figures_have_no_english_words_and_all_glyphs(name: str, texts: Any, recwarn: Any) -> None:
    boxes = texts(drawing(name, "zh"))
    assert not [warning for warning in recwarn if "Glyph" in str(warning.message)]
    units = {"m", "mm", "ms", "s", "N", "x", "y", "i", "j"}
    for text, _ in boxes:
        words = "".join(c if c.isascii() and c.isalpha() else " " for c in text.get_text()).split()
        assert set(words) <= units, text
        assert text.get_fontfamily()[0] == "Noto Sans SC"


@pytest.mark.parametrize(("name", "source"), [("impulses", None), ("gap", "tractor"), ("gap", "arm")])
def test_logarithmic_scales_fit_their_data(name: str, source: str | None) -> None:
    shown = drawing(name) if source is None else figure(name, OTHERS[source])
    axes = shown.axes[0]
    values = np.concatenate([line.get_ydata() for line in axes.get_lines()])
    low, high = axes.get_ylim()
    assert low < values.min() < values.max() < high
    assert np.log10(high / low) < np.log10(values.max() / values.min()) + 0.4
    assert len([tick for tick in axes.get_yticks() if low <= tick <= high]) >= 2


def test_negative_times_have_minus_signs() -> None:
    [axes] = figure("speeds", OTHERS["u-turn"]).axes
    assert [text.get_text() for text in axes.texts][:2] == ["\N{MINUS SIGN}20 s", "\N{MINUS SIGN}10 s"]
