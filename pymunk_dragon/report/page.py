"""A report as one HTML file: no network, no script, every value escaped."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Mapping
from importlib.resources import files
from typing import Any

from pymunk_dragon.extras import library
from pymunk_dragon.report import charts, sections
from pymunk_dragon.report.picture import Picture

__all__ = ["as_html"]

Contents = Mapping[str, Any]

# Rows of a table on paper, which nobody scrolls through: a page of them.
PAPER_ROWS = 60


def as_html(contents: Contents, pictures: Iterable[Picture] = ()) -> str:
    """The whole page.

    Raises
    ------
    MissingExtraError
        If Jinja2 is not installed.
    """
    jinja2 = library("jinja2")
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(_source),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    text: str = environment.get_template("report.html.j2").render(
        headline=sections.headline(contents),
        subtitle=sections.subtitle(contents),
        key_figures=sections.key_figures(contents),
        pictures=[{"caption": picture.caption, "png": b64encode(picture.png).decode("ascii")} for picture in pictures],
        sections=sections.sections(contents),
        timeline=charts.timeline(contents),
        drift_chart=charts.drift_chart(contents),
        paper_rows=PAPER_ROWS,
    )
    return text


def _source(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
