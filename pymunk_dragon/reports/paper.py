"""All five answers as one HTML page, with figures and the derivation in formulas."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from pymunk_dragon._checks import instance
from pymunk_dragon._files import check_destination, write_text
from pymunk_dragon._language import language, text
from pymunk_dragon.drawing.figures import figure, svg_of
from pymunk_dragon.model.run import Run
from pymunk_dragon.reports.document import Table, near_miss_table
from pymunk_dragon.reports.formats import contact_pictures
from pymunk_dragon.studies import Paper
from pymunk_dragon.web.html import asset, data_address, filled
from pymunk_dragon.web.markup import html, mathml

# Answers in the table of errors: the name, the unit of the error, and that of a change. The first
# one, without a name here, has the handle in its name.
_ANSWERS = (
    ("", "m", "mm"),
    ("first contact", "m", "ms"),
    ("smallest pitch", "m", "mm"),
    ("length of the turn", "m", "mm"),
    ("largest speed", "m/s", "mm/s"),
)


def write_paper(found: Paper, path: str | Path) -> None:
    """Write all five answers as one self-contained HTML page.

    Raises a `MissingExtraError` without the libraries of `pip install 'pymunk-dragon[demos]'`.

    Examples
    --------
    >>> from pymunk_dragon import Dragon
    >>> from pymunk_dragon.studies import paper
    >>> write_paper(paper(Dragon(benches=25)), "answers.html")
    """
    destination = check_destination(path, (".html",))
    instance("found", found, Paper, "a Paper")
    heads = [*map(text, ("t (s)", "handle", "x (m)", "y (m)", "speed (m/s)"))]
    states = found.states.rows(found.march.dragon.representatives)
    page = filled(
        __package__,
        "paper.html.j2",
        language=language(),
        text=text,
        html=html,
        mathml=mathml,
        degrees=math.degrees,
        colours=asset("pymunk_dragon.web", "assets/colours.css"),
        found=found,
        states=Table([*map(_state, states)], heads, left=()),
        near_misses=near_miss_table(found.contact.near_misses or ()),
        figures=_figures(found),
        sensitivities=_sensitivities(found),
    )
    write_text(destination, page)


def _state(row: Sequence[float]) -> list[str]:
    """Cells of the time, handle, position and speed of a state."""
    time, handle, *values = row
    return [f"{time:g}", str(handle), *(f"{value:z.6f}" for value in values)]


def _sensitivities(found: Paper) -> Table:
    """A row for each answer: its error, and its change for a millimetre more of each size."""
    last = text(
        "handle {i} at {time:g} s, along the path",
        i=found.march.dragon.handles - 1,
        time=found.states.times[-1],
    )
    answers = zip(_ANSWERS, found.errors, found.slopes, strict=True)
    rows: list[tuple[str, ...]] = []
    for (name, unit, change), error, slopes in answers:
        cells = [_change(slope, change) for slope in slopes.values()]
        answer = f"{len(rows) + 1}. {text(name) or last}"
        rows.append((answer, f"{error:.1e} {unit}", *cells))
    sizes = (name.replace("_", " ") for name in found.speed_slopes)
    return Table(rows, [*map(text, ("answer", "error", *sizes))], left=(0,))


def _change(slope: float | None, unit: str) -> str:
    """A change for a millimetre; none where other benches touch."""
    if slope is None:
        return "\u2013"
    return f"{slope:+.4f} {unit}" if slope else "0"


def _figures(found: Paper) -> dict[str, str]:
    """Addresses of the figures by name."""
    contact = found.contact.contact
    run = replace(Run.exact(found.march, [found.contact.time]), first_contact=contact)
    (_, head), *_ = contact_pictures(run)
    drawn = {name: figure(name, found.march) for name in ("spiral", "gap")}
    drawn["min-pitch"] = found.smallest.plot()
    drawn["u-turn"] = found.turn.plot()
    drawn["max-speed"] = found.fastest.plot()
    addresses = {"contact": head}
    for name, each in drawn.items():
        addresses[name] = data_address(svg_of(each), "image/svg+xml")
    return addresses
