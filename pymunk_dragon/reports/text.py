"""Reports as JSON, CSV and Markdown, with the standard library only."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

from pymunk_dragon.reports import sections, tables
from pymunk_dragon.reports.sections import Section
from pymunk_dragon.reports.tables import Table

__all__ = ["as_csv", "as_json", "as_markdown"]

Contents = Mapping[str, Any]

# Characters with a meaning in Markdown, embedded HTML or GitHub's dialect.
MARKUP = re.compile(r"[\\`*_{}\[\]<>|&~$#@!]")


def as_json(contents: Contents) -> str:
    """Contents as JSON; `schema.json` describes the keys."""
    parts = [f"{json.dumps(name)}: {_lines(value)}" for name, value in contents.items()]
    return "{\n" + ",\n".join(parts) + "\n}\n"


def as_csv(contents: Contents) -> str:
    """All events by time as CSV (RFC 4180): a header line, CR LF line ends, SI units."""
    table = tables.all_events(contents)
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow([column.key for column in table.columns])
    writer.writerows(table.rows)
    return text.getvalue()


def as_markdown(contents: Contents) -> str:
    """Report as Markdown."""
    parts = [f"# {_escaped(sections.headline(contents))}", _escaped(sections.subtitle(contents)) + "."]
    parts.append(_facts(sections.key_figures(contents)))
    for section in sections.sections(contents):
        parts += _section(section)
    return "\n\n".join(part for part in parts if part) + "\n"


def _lines(value: Any) -> str:
    """JSON with one line for each entry of a list of objects, for readability."""
    if isinstance(value, list) and value and isinstance(value[0], Mapping):
        return "[\n" + ",\n".join(json.dumps(item, allow_nan=False) for item in value) + "\n]"
    return json.dumps(value, allow_nan=False)


def _section(section: Section) -> list[str]:
    parts = [f"## {section.title}", _escaped(" ".join(section.notes))]
    for heading, facts in section.facts.items():
        parts += [heading and f"### {heading}", _facts(facts)]
    for heading, table in section.tables.items():
        if table.rows:
            parts += [heading and f"### {heading}", _table(table), table.truncation_note]
    return parts


def _facts(facts: Iterable[tuple[str, str]]) -> str:
    # Markdown requires a header row; this one is empty.
    return "\n".join(["|  |  |", "| --- | --- |", *(_row(fact) for fact in facts)])


def _table(table: Table) -> str:
    alignments = ["---" if column.text else "---:" for column in table.columns]
    lines = [_row(column.label for column in table.columns), "| " + " | ".join(alignments) + " |"]
    return "\n".join(lines + [_row(row) for row in table.text_rows])


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(_escaped(cell) for cell in cells) + " |"


def _escaped(text: str) -> str:
    """`text` on one line, with Markdown characters escaped by backslashes."""
    return MARKUP.sub(r"\\\g<0>", " ".join(text.split()))
