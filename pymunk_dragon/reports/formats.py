"""Formats of reports: each is a function from a summary to the text of a file.

`FORMATS` has an entry for each of them.
"""

import csv
import io
import json
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from pymunk_dragon._extras import is_installed
from pymunk_dragon._files import check_destination, write_text
from pymunk_dragon._language import language, text
from pymunk_dragon.drawing import Camera, Film, still_png
from pymunk_dragon.drawing.figures import figure, svg_of
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.run import Run
from pymunk_dragon.reports import document
from pymunk_dragon.reports.summary import Summary, summarize
from pymunk_dragon.web.html import asset, data_address, filled

# Characters with a meaning in Markdown, embedded HTML or GitHub's dialect.
_MARKUP = re.compile(r"[\\`*_{}\[\]<>|&~$#@!]")
# Names of columns with the units of their values.
_CSV_COLUMNS = [
    "time_s",
    "what",
    "bench_i",
    "bench_j",
    "point1_x_m",
    "point1_y_m",
    "point2_x_m",
    "point2_y_m",
    "normal_x",
    "normal_y",
    "depth_m",
    "relative_velocity_x_m_s",
    "relative_velocity_y_m_s",
    "impulse_x_N_s",
    "impulse_y_N_s",
    "gap_m",
]
# Pixels: width and height of a still, twice the displayed size for screens with a pixel ratio of
# two.
_STILL_SIZE = 880
# m: least width of the close-up around the head.
_CLOSE_SPAN = 6.0
# Least width of the close-up over the distance of the contact from the head, where an unguided run
# may have its contact far from the head.
_CLOSE_MARGIN = 3.0


def report(run: Run, path: str | Path) -> None:
    """Write a report on a run.

    Parameters
    ----------
    run : Run
        Run to report on.
    path : path
        File to write; the ending selects the format: .json (all contents; see `Summary.to_dict`),
        .csv (near misses, contacts and callbacks, by time), .md or .html (one self-contained file
        with pictures, and with a chart if matplotlib is installed).

    Raises
    ------
    ParameterError, MissingExtraError, OutputError
        If the file cannot be created or `run` is not a Run, Jinja2 is not installed (HTML), or
        writing fails.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March, report, simulate
    >>> run = simulate(March(Dragon(benches=16)), start=411, contacts="report", until=412.6)
    >>> report(run, "report.html")
    """
    destination = check_destination(path, FORMATS)
    write_text(destination, FORMATS[destination.suffix.lower()](summarize(run)))


def _csv_text(summary: Summary) -> str:
    """Near misses, first contacts and callbacks by time as CSV (RFC 4180), in SI units.

    Each coordinate has a column.
    """
    values = summary.to_dict()
    found = [("near_miss", miss) for miss in values["near_misses"] or ()]
    if summary.exact_contact:
        found.append(("exact_contact", values["exact"]))
    if summary.run.first_contact:
        found.append(("first_contact", values["first_contact"]))
    found += [(event["phase"], event) for event in values["events"]]
    found.sort(key=lambda entry: entry[1]["time"])

    content = io.StringIO(newline="")
    writer = csv.writer(content)
    writer.writerow(_CSV_COLUMNS)
    writer.writerows(_csv_row(what, entry) for what, entry in found)
    return content.getvalue()


def _markdown(summary: Summary) -> str:
    """Report as Markdown with GitHub's tables."""
    title = _escaped(document.headline(summary))
    parts = [f"# {title}", _escaped(document.subtitle(summary) + text("."))]
    for section in document.sections(summary):
        parts += [f"## {section.title}", _escaped(section.note)]
        for heading, table in section.tables.items():
            parts += _markdown_table(heading, table)
    return "\n\n".join(filter(None, parts)) + "\n"


def _html(summary: Summary) -> str:
    """Report as one HTML document without network access or scripts; all values are escaped."""
    return filled(
        __package__,
        "report.html.j2",
        language=language(),
        text=text,
        document=document,
        summary=summary,
        pictures=contact_pictures(summary.run),
        chart=_chart(summary.run),
        colours=asset("pymunk_dragon.web", "assets/colours.css"),
    )


# Registry of the formats by file ending.
FORMATS: dict[str, Callable[[Summary], str]] = {
    ".json": lambda summary: json.dumps(summary.to_dict(), allow_nan=False) + "\n",
    ".csv": _csv_text,
    ".md": _markdown,
    ".html": _html,
}


def _csv_row(what: str, entry: Mapping[str, Any]) -> list[Any]:
    """Cells of an entry, which lacks some of the values; the engine reports at most two points."""
    none = (None, None)
    points: list[Any] = entry.get("points", [entry.get("point", none)])
    first, second, *_ = [*points, none, none]
    row = [entry["time"], what, *entry["benches"], *first, *second]
    row += entry.get("normal") or none
    row.append(entry.get("depth"))
    row += entry.get("relative_velocity") or none
    row += entry.get("impulse") or none
    row.append(entry.get("gap"))
    return row


def _markdown_table(heading: str, table: document.Table) -> list[str]:
    """Blocks of a table: its heading, its lines, and its note."""
    if not table.rows:
        return [text("None.")]
    # Markdown requires a header row, which is empty above names and values, and below it a row with
    # the alignment of each column.
    columns = range(len(table.heads))
    alignment = ["---" if column in table.left else "---:" for column in columns]
    lines = []
    for row in (table.heads, alignment, *table.rows):
        cells = " | ".join(map(_escaped, row))
        lines.append(f"| {cells} |")
    return [heading and f"### {heading}", "\n".join(lines), table.note]


def _escaped(content: str) -> str:
    """`content` on one line, with Markdown characters escaped by backslashes."""
    return _MARKUP.sub(r"\\\g<0>", " ".join(content.split()))


def contact_pictures(run: Run) -> list[tuple[str, str]]:
    """Captions and addresses of pictures of the head and of the whole dragon.

    They show the first contact, or else the end of the run.
    """
    contact = run.first_contact
    begin, time = run.interval
    span = _CLOSE_SPAN
    if contact is not None:
        time = min(max(contact.time, begin), time)
        head = run.poses_at(time)[0, 0, :2]
        distance = float(np.abs(contact.point - head).max())
        span = max(span, _CLOSE_MARGIN * distance)

    cameras = {
        text("The head at {time:.2f} s", time=time): Camera(follow="head", span=span),
        text("The whole dragon at {time:.2f} s", time=time): Camera(),
    }
    pictures = []
    for caption, camera in cameras.items():
        png = still_png(run, time, Film(size=_STILL_SIZE, camera=camera))
        address = data_address(png, "image/png")
        pictures.append((caption, address))
    return pictures


def _chart(run: Run) -> str | None:
    """Address of the figure of the position errors as SVG.

    None if matplotlib is not installed or the run has no errors.
    """
    needed = ["matplotlib"]
    # Characters of other languages need a font.
    if language() != "en":
        needed.append("zhplot")
    if not all(map(is_installed, needed)):
        return None

    with suppress(ParameterError):
        return data_address(svg_of(figure("drift", run)), "image/svg+xml")
    return None
