"""Tables of a dragon's states for papers in LaTeX."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pymunk_dragon._checks import instance
from pymunk_dragon._files import check_destination, write_text
from pymunk_dragon._language import text
from pymunk_dragon.model.march import States
from pymunk_dragon.web.html import filled


def write_latex(states: States, handles: Sequence[int], path: str | Path) -> None:
    """Write positions and speeds of the `handles` as tables for LaTeX, which break over pages.

    The file, to be input in a document, has a table of positions and one of speeds for each six
    times, with six decimals. It needs the packages booktabs and longtable.

    Raises a `MissingExtraError` without Jinja2, of `pip install 'pymunk-dragon[report]'`.

    Examples
    --------
    >>> from pymunk_dragon import March
    >>> write_latex(March().at([0, 60, 120]), [0, 1, 223], "table.tex")
    """
    destination = check_destination(path, (".tex",))
    instance("states", states, States, "states of a march")
    times, chosen, positions, speeds = states.to_dict(handles).values()
    positions = np.reshape(positions, (len(times), -1)).T.tolist()
    names = [f"{axis}_{{{handle}}}" for handle in chosen for axis in "xy"]
    speed_names = [f"v_{{{handle}}}" for handle in chosen]
    tables = {
        text("Position of handle $i$, m"): [*zip(names, positions, strict=True)],
        text("Speed of handle $i$, m/s"): [*zip(speed_names, np.transpose(speeds), strict=True)],
    }
    write_text(destination, filled(__package__, "table.tex.j2", times=times, tables=tables))
