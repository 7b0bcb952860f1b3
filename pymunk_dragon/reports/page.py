"""Report as one HTML file without network access or scripts; all values are escaped."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Mapping
from typing import Any

from pymunk_dragon._html import filled
from pymunk_dragon.reports import charts, sections
from pymunk_dragon.reports.picture import Picture

__all__ = ["as_html"]

Contents = Mapping[str, Any]

# Rows of a table in print, where tables do not scroll: about a page.
PRINT_ROWS = 60


def as_html(contents: Contents, pictures: Iterable[Picture] = ()) -> str:
    """Report as one HTML document.

    Raises
    ------
    MissingExtraError
        If Jinja2 is not installed.
    """
    return filled(
        __package__,
        "report.html.j2",
        headline=sections.headline(contents),
        subtitle=sections.subtitle(contents),
        key_figures=sections.key_figures(contents),
        pictures=[{"caption": picture.caption, "png": b64encode(picture.png).decode("ascii")} for picture in pictures],
        sections=sections.sections(contents),
        timeline=charts.timeline(contents),
        drift_chart=charts.drift_chart(contents),
        print_rows=PRINT_ROWS,
    )
