"""Reports on runs: JSON, CSV, Markdown and HTML files, and the contest's tables.

`report` and `pymunk-dragon report` take the format from the file's ending. A report has the
scenario, the first contact, the near misses, the contacts of the run in the order of time, speeds,
and the drift from the exact model. Pages, sheets and tables for LaTeX need `pip install
'pymunk-dragon[report]'`; a page has a chart if matplotlib is installed (`pymunk-dragon[figures]`).

```console
$ pymunk-dragon simulate --from 405 --until 416 --contacts report -o windows.npz
$ pymunk-dragon report windows.npz -o report.html
$ pymunk-dragon report windows.npz -o report.md
```

With `--contacts report` the benches pass through each other, and the run shows every contact that
follows the first one. `make report` makes [such a report](renders/report.html).
"""

from pymunk_dragon.reports.contest_tables import paper_tables, write_contact_table, write_tables
from pymunk_dragon.reports.formats import FORMATS, report
from pymunk_dragon.reports.latex import write_latex
from pymunk_dragon.reports.summary import Summary, summarize

__all__ = [
    "FORMATS",
    "Summary",
    "paper_tables",
    "report",
    "summarize",
    "write_contact_table",
    "write_latex",
    "write_tables",
]
