"""Reports on runs: JSON, CSV, Markdown, HTML and XLSX files, and the contest's tables.

`report` and `pymunk-dragon report` take the format from the file's ending. A report has the scenario, the first
contact, the near misses, the contacts of the run in the order of time, speeds, and the drift from the exact model.
The JSON follows a schema (`json_schema`). Pages and sheets need `pip install 'pymunk-dragon[report]'`.

```console
$ pymunk-dragon simulate --from 405 --until 416 --contacts report -o windows.npz
$ pymunk-dragon report windows.npz -o report.html
$ pymunk-dragon report windows.npz -o report.md
```

With `--contacts report` the benches pass through each other, and the run shows every contact that follows the first
one. `make report` makes [such a report](renders/report.html).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from pymunk_dragon._extras import library
from pymunk_dragon._files import check_destination, written_in_place
from pymunk_dragon.model.run import Run
from pymunk_dragon.reports.contest_tables import TABLE_ENDINGS, paper_tables, write_contact_table, write_tables
from pymunk_dragon.reports.csv_report import csv_text
from pymunk_dragon.reports.html_report import html
from pymunk_dragon.reports.json_report import json_text
from pymunk_dragon.reports.markdown_report import markdown
from pymunk_dragon.reports.summary import Summary, json_schema, summarize
from pymunk_dragon.reports.xlsx_report import xlsx

__all__ = [
    "REPORT_ENDINGS",
    "TABLE_ENDINGS",
    "Summary",
    "json_schema",
    "paper_tables",
    "report",
    "summarize",
    "write_contact_table",
    "write_tables",
]


class Format(NamedTuple):
    """A format of reports: the function that makes the file's content, and the optional library that it needs."""

    render: Callable[[Summary], str | bytes]
    library: str | None = None


# Registry of the formats by file ending.
FORMATS: Mapping[str, Format] = {
    ".json": Format(json_text),
    ".csv": Format(csv_text),
    ".md": Format(markdown),
    ".html": Format(html, "jinja2"),
    ".xlsx": Format(xlsx, "xlsxwriter"),
}
REPORT_ENDINGS = tuple(FORMATS)
# Steps of `report`: the summary, the content, and the file.
STEPS = 3


def report(run: Run, path: str | Path, *, progress: Callable[[int, int], None] | None = None) -> None:
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
        If the file cannot be created, or `run` is not a Run.
    MissingExtraError
        If the library for HTML or XLSX is not installed.
    OutputError
        If writing fails.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March, report, simulate
    >>> run = simulate(March(Dragon(benches=16)), start=411, contacts="report", until=412.6)
    >>> report(run, "report.html")
    """
    destination = check_destination(path, REPORT_ENDINGS)
    chosen = FORMATS[destination.suffix.lower()]
    if chosen.library is not None:
        # A missing library is reported before the computation.
        library(chosen.library)
    notify = progress or (lambda done, total: None)
    summary = summarize(run)
    notify(1, STEPS)
    with written_in_place(destination) as draft:
        content = chosen.render(summary)
        notify(2, STEPS)
        # Bytes, since text mode would convert line ends, and CSV requires CR LF.
        draft.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
    notify(STEPS, STEPS)
