"""Texts of a matplotlib figure as they are drawn."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import matplotlib.text
import pytest

# Points: smallest size of text on a slide of 4.5 inches.
SMALLEST = 8.0


def check_texts(drawing: Any, border: int = 10) -> list[str]:
    """Return all texts of a figure, after a check that they are within the page, large, and clear of each other."""
    draw, seen = matplotlib.text.Text.draw, []

    def draw_and_note(text: Any, *arguments: Any, **options: Any) -> None:
        draw(text, *arguments, **options)
        if text.get_visible() and text.get_text().strip():
            # Of an annotation without its leader.
            seen.append((text, matplotlib.text.Text.get_window_extent(text)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(matplotlib.text.Text, "draw", draw_and_note)
        drawing.draw_without_rendering()
    width, height = drawing.canvas.get_width_height()
    for (one, first), (other, second) in combinations(seen, 2):
        assert not first.overlaps(second), (one, other)
    for text, box in seen:
        assert border < box.x0 < box.x1 < width - border, text
        assert border < box.y0 < box.y1 < height - border, text
        assert text.get_size() >= SMALLEST, text
    return [text.get_text() for text, _ in seen]
