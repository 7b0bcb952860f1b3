"""Text in lines, also in Chinese, where a line ends behind nearly any character."""

from __future__ import annotations

import re
from collections.abc import Iterator

from pymunk_dragon._display import width

# A space at which no line is broken.
NO_BREAK = "\u00a0"
# Characters that do not end a line, and such that do not begin one.
OPENING, CLOSING = "([{“‘（《「【", "!%),./:;?]}”’、。，；：？！）》」】"  # noqa: RUF001  # Those of Chinese.
# What is not broken: a Chinese character or a word, with the brackets and stops around and the spaces behind it.
WIDE = "\u2e80-\uffef"
PIECE = re.compile(
    rf"[{re.escape(OPENING)}]*(?:[^ {WIDE}]*{NO_BREAK})*(?:[{WIDE}]|[^ {WIDE}]*)[{re.escape(CLOSING)}]* *"
)


def wrapped(text: str, columns: int) -> Iterator[str]:
    """Lines of `text`, at most `columns` wide where they can be broken; `textwrap` breaks at spaces only."""
    line = ""
    for piece in PIECE.findall(unbroken(re.sub(r"\s*\n\s*", " ", text.strip()))):
        if line and width(line) + width(piece.rstrip(" ")) > columns:
            yield line.rstrip(" ").replace(NO_BREAK, " ")
            line = ""
        line += piece
    yield line.rstrip(" ").replace(NO_BREAK, " ")


def unbroken(text: str) -> str:
    """`text` with a space that does not break behind each number, so that 1 m/s stays on one line."""
    return re.sub(r"(?<=\d) (?=\w)", NO_BREAK, text)


def closing(text: str) -> str:
    """The characters with which `text` begins that do not begin a line."""
    return text[: len(text) - len(text.lstrip(CLOSING))]
