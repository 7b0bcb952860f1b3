"""All five answers as one HTML page, with figures and the derivation in formulas."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from pymunk_dragon._checks import instance
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon._language import language, text
from pymunk_dragon.drawing.figures import figure, svg_of
from pymunk_dragon.model.run import Run
from pymunk_dragon.reports.document import Table, near_miss_table
from pymunk_dragon.reports.formats import contact_pictures
from pymunk_dragon.studies import Paper
from pymunk_dragon.web.html import asset, data_address, filled
from pymunk_dragon.web.markup import html, mathml


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
    page = filled(
        __package__,
        "paper.html.j2",
        language=language(),
        text=text,
        html=html,
        mathml=mathml,
        colours=asset("pymunk_dragon.web", "assets/colours.css"),
        found=found,
        answers=_answers(found),
        states=_states(found),
        near_misses=near_miss_table(found.contact.near_misses or ()),
        angle=f"{math.degrees(abs(found.turn.turn.sweeps[0])):.6f}",
        figures=_figures(found),
        sensitivities=_sensitivities(found),
    )
    with written_in_place(destination) as draft:
        draft.write_text(page, encoding="utf-8")


def _answers(found: Paper) -> list[tuple[str, str]]:
    """The five questions and answers in a line each."""
    states = found.states
    x, y = states.positions[-1, -1]
    place = text("handle {i} at {time:g} s at ({x:.6f}, {y:.6f}) m, {speed:.6f} m/s")
    place = place.format(
        i=found.march.dragon.handles - 1,
        time=states.times[-1],
        x=x,
        y=y,
        speed=states.speeds[-1, -1],
    )
    time = text("at {time:.9f} s: benches {i} and {j}")
    i, j = found.contact.benches or (0, 0)
    return [
        (text("Where the handles are, and how fast"), place),
        (
            text("When the dragon first touches itself"),
            time.format(time=found.contact.time, i=i, j=j),
        ),
        (text("The smallest pitch"), f"{found.smallest.pitch:.12f} m"),
        (text("The turn"), f"{found.turn.turn.length:.6f} m"),
        (text("The largest speed of the head"), f"{found.fastest.speed:.10f} m/s"),
    ]


def _states(found: Paper) -> Table:
    """Positions and speeds of the paper's handles."""
    heads = ("t (s)", text("handle"), "x (m)", "y (m)", text("speed (m/s)"))
    rows = []
    for time, handle, *values in found.states.rows(found.march.dragon.representatives):
        # Adding 0 turns the -0.0 of a rounded tiny number into 0.0.
        numbers = [f"{round(value, 6) + 0.0:.6f}" for value in values]
        rows.append((f"{time:g}", str(handle), *numbers))
    return Table(rows, heads, left=())


def _sensitivities(found: Paper) -> Table:
    """A row for each answer: its error, and its change for a millimetre more of each size."""
    last = text("handle {i} at {time:g} s, along the path")
    none = dict.fromkeys(found.speed_slopes, 0.0)
    answers: list[tuple[str, str, str, Mapping[str, float | None]]] = [
        (
            last.format(i=found.march.dragon.handles - 1, time=found.states.times[-1]),
            "m",
            "mm",
            found.last_slopes,
        ),
        (text("first contact"), "m", "ms", found.sensitivity.times),
        (text("smallest pitch"), "m", "mm", found.sensitivity.pitches),
        (text("length of the turn"), "m", "mm", none),
        (text("largest speed"), "m/s", "mm/s", found.speed_slopes),
    ]
    rows = []
    for number, (name, unit, change, slopes) in enumerate(answers, 1):
        error = f"{found.errors[number - 1]:.1e} {unit}"
        cells = [_change(slope, change) for slope in slopes.values()]
        rows.append((f"{number}. {name}", error, *cells))
    sizes = (name.replace("_", " ") for name in none)
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
