"""Report as Markdown with GitHub's tables."""

from __future__ import annotations

import re
from collections.abc import Iterable

from pymunk_dragon._language import text
from pymunk_dragon.reports.document import headline, key_figures, sections, subtitle
from pymunk_dragon.reports.summary import Summary
from pymunk_dragon.reports.tables import Table

# Characters with a meaning in Markdown, embedded HTML or GitHub's dialect.
MARKUP = re.compile(r"[\\`*_{}\[\]<>|&~$#@!]")


def markdown(summary: Summary) -> str:
    """Report as Markdown."""
    parts = [f"# {_escaped(headline(summary))}", _escaped(subtitle(summary) + text(".")), _facts(key_figures(summary))]
    for section in sections(summary):
        parts += [f"## {section.title}", _escaped(" ".join(section.notes))]
        for heading, facts in section.facts.items():
            parts += [heading and f"### {heading}", _facts(facts)]
        for heading, table in section.tables.items():
            if table.rows:
                parts += [heading and f"### {heading}", _table(table), table.truncation_note]
    return "\n\n".join(part for part in parts if part) + "\n"


def _facts(facts: Iterable[tuple[str, str]]) -> str:
    # Markdown requires a header row; this one is empty.
    return "\n".join(["|  |  |", "| --- | --- |", *map(_row, facts)])


def _table(table: Table) -> str:
    alignments = " | ".join("---" if column.is_text else "---:" for column in table.columns)
    return "\n".join([_row(column.label for column in table.columns), f"| {alignments} |", *map(_row, table.text_rows)])


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(map(_escaped, cells)) + " |"


def _escaped(text: str) -> str:
    """`text` on one line, with Markdown characters escaped by backslashes."""
    return MARKUP.sub(r"\\\g<0>", " ".join(text.split()))
