"""Representations of runs and marches in notebooks: a picture, a figure, and a player for small runs.

In a notebook a `Run` shows itself as a player, or as a picture if it is long; a `March` and a figure, as `plot` of a
result returns it, as pictures; and results as their text.
"""

from __future__ import annotations

from html import escape
from typing import Any

from pymunk_dragon.drawing import Film, still_png
from pymunk_dragon.drawing.figures import figure
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.player import player_page

# Handle positions over all frames up to which a run is played in the notebook, which keeps the page in its file: some
# 400 kB. That is the last two minutes of the paper's 223 benches, or twenty minutes of 16.
_MAX_POSITIONS = 250_000
# Pixels: height of a player, and the side of a picture, shown at half of it on screens with two pixels to the point.
SIZE = 640


def as_html(shown: Run | March) -> str | None:
    """A frame, which keeps its script from the notebook's, with the player of a small run; None for anything else."""
    if isinstance(shown, March) or len(shown.times) * shown.march.dragon.handles > _MAX_POSITIONS:
        return None
    return (
        f'<iframe srcdoc="{escape(player_page(shown))}" title="A run of the bench dragon" width="100%" '
        f'height="{SIZE}" style="border: 0" sandbox="allow-scripts allow-downloads"></iframe>'
    )


def as_png(shown: Run | March) -> bytes:
    """A run as it ended, or a march as it begins, as the bytes of a PNG."""
    return still_png(shown, float(shown.times[-1]) if isinstance(shown, Run) else 0.0, Film(size=SIZE))


def plot(shown: Run | March) -> Any:
    """Paths of seven handles of a run or a march, as a matplotlib figure."""
    return figure("trajectories", shown)
