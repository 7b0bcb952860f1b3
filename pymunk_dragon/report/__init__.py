"""A run as tables and documents."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pymunk_dragon.extras import library
from pymunk_dragon.files import check_destination, written_in_place
from pymunk_dragon.report.contest import TABLE_ENDINGS, write_contact_table, write_tables
from pymunk_dragon.report.exact import exact_impact, with_exact_contact
from pymunk_dragon.report.page import as_html
from pymunk_dragon.report.paper import paper_tables
from pymunk_dragon.report.picture import Picture, pictures
from pymunk_dragon.report.summary import contents, json_schema, told
from pymunk_dragon.report.text import as_csv, as_json, as_markdown
from pymunk_dragon.report.workbook import write_workbook
from pymunk_dragon.run import Run

__all__ = [
    "REPORT_ENDINGS",
    "TABLE_ENDINGS",
    "contents",
    "json_schema",
    "paper_tables",
    "report",
    "write_contact_table",
    "write_tables",
]

Progress = Callable[[int, int], None]

REPORT_ENDINGS = (".json", ".csv", ".md", ".html", ".xlsx")
# The ones that are nothing but text: no picture is drawn for them, and nothing but the core is needed.
PLAIN: Mapping[str, Callable[[Mapping[str, Any]], str]] = {".json": as_json, ".csv": as_csv, ".md": as_markdown}
LIBRARIES = {".html": "jinja2", ".xlsx": "xlsxwriter"}


def report(run: Run, path: str | Path, progress: Progress | None = None) -> None:
    """Write a report on a run.

    Parameters
    ----------
    run : Run
        What is reported on.
    path : path
        File to write; its ending chooses the format: .json (all there is; see `json_schema`), .csv (near misses,
        contacts and callbacks, by time), .md, .html (one file with everything in it) or .xlsx. HTML and XLSX have
        pictures. An interrupted report leaves the old file or none.
    progress : callable, optional
        Told the number of steps done, and of all steps, after each one.

    Raises
    ------
    ParameterError
        If the file cannot be made.
    MissingExtraError
        If HTML or XLSX is wanted and its library is not installed.
    OutputError
        If writing fails.

    Examples
    --------
    >>> report(Run.load("run.npz"), "report.html")  # doctest: +SKIP
    """
    destination = check_destination(path, REPORT_ENDINGS)
    ending = destination.suffix.lower()
    if ending in LIBRARIES:
        # Before the work, not after it.
        library(LIBRARIES[ending])
    steps = 2 if ending in PLAIN else 3
    tell = progress or (lambda done, total: None)
    impact = exact_impact(run)
    run = with_exact_contact(run, impact)
    found = told(run, impact)
    tell(1, steps)
    drawn: list[Picture] = []
    if ending not in PLAIN:
        drawn = pictures(run)
        tell(2, steps)
    if ending == ".xlsx":
        write_workbook(found, drawn, destination)
    else:
        text = PLAIN[ending](found) if ending in PLAIN else as_html(found, drawn)
        with written_in_place(destination) as draft:
            # As bytes: a text file would get the line ends of the machine, and CSV has its own.
            draft.write_bytes(text.encode("utf-8"))
    tell(steps, steps)
