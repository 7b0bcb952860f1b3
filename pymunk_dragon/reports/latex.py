"""Tables of a dragon's states for papers in LaTeX."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import instance
from pymunk_dragon._files import check_destination, write_text
from pymunk_dragon._language import text
from pymunk_dragon.model.march import States
from pymunk_dragon.web.html import substituted

# Times in one table: as many as fit between the margins of an article.
_COLUMNS = 6
# The first lines of a file.
_HEAD = r"""
% \usepackage{booktabs,longtable}, and ctex for Chinese; \input this file.
\begingroup\footnotesize\setlength{\tabcolsep}{4pt}
"""
_TABLE = r"""
\begin{longtable}{@{}l*{{{columns}}}{r}@{}}
\caption{{{title}}} \\
\toprule
{{head}} \\
\midrule
\endhead
\bottomrule
\endfoot
{{rows}} \\
\end{longtable}
"""


def write_latex(states: States, handles: Sequence[int], path: str | Path) -> None:
    """Write positions and speeds of the `handles` as tables for LaTeX, which break over pages.

    The file, to be input in a document, has a table of positions and one of speeds for each six
    times, with six decimals. It needs the packages booktabs and longtable.

    Examples
    --------
    >>> from pymunk_dragon import March
    >>> write_latex(March().at([0, 60, 120]), [0, 1, 223], "table.tex")
    """
    destination = check_destination(path, (".tex",))
    instance("states", states, States, "states of a march")
    times, chosen, positions, speeds = states.to_dict(handles).values()
    rows = np.reshape(positions, (len(times), -1)).T
    names = [f"{axis}_{{{handle}}}" for handle in chosen for axis in "xy"]
    speed_names = [f"v_{{{handle}}}" for handle in chosen]

    parts = [_HEAD]
    for first in range(0, len(times), _COLUMNS):
        block = slice(first, first + _COLUMNS)
        title = text("Position of handle $i$, m")
        parts.append(_table(title, times[block], names, rows[:, block]))
        title = text("Speed of handle $i$, m/s")
        parts.append(_table(title, times[block], speed_names, np.transpose(speeds[block])))
    write_text(destination, "".join([*parts, "\\endgroup\n"]).lstrip())


def _table(title: str, times: Sequence[float], names: Sequence[str], values: Array) -> str:
    """A table with a column for each time, s, and a row for each name."""
    head = [rf"{time:.12g}\,s" for time in times]
    rows = []
    for name, row in zip(names, values, strict=True):
        cells = [name, *(f"{value:z.6f}" for value in row)]
        rows.append(" & ".join(f"${cell}$" for cell in cells))
    return substituted(
        _TABLE,
        columns=str(len(head)),
        title=title,
        head=" & ".join(["", *head]),
        rows=" \\\\\n".join(rows),
    )
