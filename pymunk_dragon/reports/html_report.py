"""Report as one HTML file without network access or scripts; all values are escaped."""

from __future__ import annotations

from pymunk_dragon._html import data_address, filled
from pymunk_dragon._language import language, text
from pymunk_dragon.reports.document import headline, key_figures, sections, subtitle
from pymunk_dragon.reports.graphics import drift_chart, stills, timeline
from pymunk_dragon.reports.summary import Summary

# Rows of a table in print, where tables do not scroll: about a page.
PRINT_ROWS = 60


def html(summary: Summary) -> str:
    """Report as one HTML document."""
    return filled(
        __package__,
        "report.html.j2",
        language=language(),
        text=text,
        headline=headline(summary),
        subtitle=subtitle(summary),
        key_figures=key_figures(summary),
        pictures=[(caption, data_address(png, "image/png")) for caption, png in stills(summary)],
        sections=sections(summary),
        timeline=timeline(summary),
        drift_chart=drift_chart(summary),
        print_rows=PRINT_ROWS,
    )
