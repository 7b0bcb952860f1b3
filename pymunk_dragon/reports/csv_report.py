"""Report as CSV (RFC 4180): a header line, CR LF line ends, SI units."""

from __future__ import annotations

import csv
import io

from pymunk_dragon.reports.summary import Summary
from pymunk_dragon.reports.tables import all_events


def csv_text(summary: Summary) -> str:
    """All events by time as CSV."""
    table = all_events(summary)
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(column.key for column in table.columns)
    writer.writerows(table.rows)
    return text.getvalue()
