"""Reports on runs: JSON, CSV, Markdown, HTML and XLSX files, and the contest's tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pymunk_dragon._extras import library
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.model.run import Run
from pymunk_dragon.reports.contest import TABLE_ENDINGS, write_contact_table, write_tables
from pymunk_dragon.reports.exact import exact_first_contact, with_exact_contact
from pymunk_dragon.reports.page import as_html
from pymunk_dragon.reports.paper import paper_tables
from pymunk_dragon.reports.picture import Picture, pictures
from pymunk_dragon.reports.summary import contents, json_schema, summarize
from pymunk_dragon.reports.text import as_csv, as_json, as_markdown
from pymunk_dragon.reports.workbook import write_workbook

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
# Formatters of the text formats, which have no pictures and need no optional library.
TEXT_FORMATTERS: Mapping[str, Callable[[Mapping[str, Any]], str]] = {
    ".json": as_json,
    ".csv": as_csv,
    ".md": as_markdown,
}
# Optional libraries that the other formats need.
REQUIRED_LIBRARIES = {".html": "jinja2", ".xlsx": "xlsxwriter"}


def report(run: Run, path: str | Path, progress: Progress | None = None) -> None:
    """Write a report on a run.

    Parameters
    ----------
    run : Run
        Run to report on.
    path : path
        File to write; the ending selects the format: .json (all contents; see `json_schema`), .csv (near misses,
        contacts and callbacks, by time), .md, .html (one self-contained file) or .xlsx. HTML and XLSX have pictures.
        An interrupted report leaves the old file or none.
    progress : callable, optional
        Called after each step with the number of completed steps and the total number of steps.

    Raises
    ------
    ParameterError
        If the file cannot be created.
    MissingExtraError
        If the library for HTML or XLSX is not installed.
    OutputError
        If writing fails.

    Examples
    --------
    >>> report(Run.load("run.npz"), "report.html")  # doctest: +SKIP
    """
    destination = check_destination(path, REPORT_ENDINGS)
    ending = destination.suffix.lower()
    if ending in REQUIRED_LIBRARIES:
        # A missing library is reported before the computation.
        library(REQUIRED_LIBRARIES[ending])
    steps = 2 if ending in TEXT_FORMATTERS else 3
    notify = progress or (lambda done, total: None)
    exact = exact_first_contact(run)
    run = with_exact_contact(run, exact)
    summary = summarize(run, exact)
    notify(1, steps)
    images: list[Picture] = []
    if ending not in TEXT_FORMATTERS:
        images = pictures(run)
        notify(2, steps)
    if ending == ".xlsx":
        write_workbook(summary, images, destination)
    else:
        text = TEXT_FORMATTERS[ending](summary) if ending in TEXT_FORMATTERS else as_html(summary, images)
        with written_in_place(destination) as draft:
            # Bytes, since text mode would convert line ends, and CSV requires CR LF.
            draft.write_bytes(text.encode("utf-8"))
    notify(steps, steps)
