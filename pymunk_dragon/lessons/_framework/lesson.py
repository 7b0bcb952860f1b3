"""A lesson as its file describes it, read without running it."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from pymunk_dragon._checks import word
from pymunk_dragon._language import LANGUAGES

FOLDER = Path(__file__).parent.parent
# A line that begins a cell of a percent file.
CELL = re.compile(r"^# %%(.*)\n", re.MULTILINE)
# An option in such a line.
OPTION = re.compile(r'(\w+)=("[^"]*"|\S+)')
# A heading of Markdown.
HEADING = re.compile(r"^##? (.+)\n", re.MULTILINE)


class Block(NamedTuple):
    """A paragraph, and the items of the list below it.

    Below a question there is an item for each choice: what the run shows, or why it tempts. The
    right one is bold.
    """

    text: str
    items: tuple[str, ...]

    @property
    def choices(self) -> list[str]:
        """The choices: what stands before the colon."""
        colons = "[:：]"  # noqa: RUF001  # The second one is Chinese.
        return [re.split(colons, item)[0].strip("*") for item in self.items]

    @property
    def right(self) -> int:
        """Number of the right choice."""
        return [item.startswith("**") for item in self.items].index(True)


@dataclass(frozen=True)
class Lesson:
    """The file of a lesson: a program in Jupytext's percent format, with texts in Markdown.

    Attributes
    ----------
    path : Path
        The file.
    texts : mapping of str to str
        The Markdown of each section in English: "Title", "Question", and those below headings, as
        "Answer".
    cells : tuple of str
        The code of each cell.
    options : mapping of str to Any
        Options of the first cell: `order`, by which lessons are sorted; `scene`, the name of a live
        scene; `view`, the centre, width and height of one that the program builds; and `axes`, on
        which the class draws its guess: two labels with "|" between.

    Examples
    --------
    >>> from pymunk_dragon.lessons import LESSONS
    >>> lesson = LESSONS["near-miss"]
    >>> lesson.path.name, lesson.options["order"]
    ('near_miss.py', 60)
    >>> lesson.sections("zh")["Title"]
    '碰上了，还是擦肩而过？'
    >>> lesson.guesses()[0].choices
    ['Bench 9', 'Bench 11', 'Bench 8']
    """

    path: Path
    texts: Mapping[str, str]
    cells: tuple[str, ...]
    options: Mapping[str, Any]

    @classmethod
    def read(cls, path: Path) -> Lesson:
        """The lesson in a file."""
        _, *parts = CELL.split(path.read_text("utf-8"))
        markdown = ""
        cells = []
        for mark, content in zip(parts[::2], parts[1::2], strict=True):
            if "[markdown]" in mark:
                markdown += re.sub("^# ?", "", content, flags=re.MULTILINE)
            else:
                cells.append(content.strip("\n"))

        _, title, question, *more = HEADING.split(markdown)
        texts = {"Title": title, "Question": question.strip()}
        for heading, text in zip(more[::2], more[1::2], strict=True):
            texts[heading] = text.strip()

        written = OPTION.findall(parts[0])
        options = {name: json.loads(value) for name, value in written}
        return cls(path, texts, tuple(cells), options)

    @property
    def name(self) -> str:
        """Name of the lesson on the command line."""
        return self.path.stem.replace("_", "-")

    @property
    def source(self) -> str:
        """The whole program."""
        return self.path.read_text("utf-8")

    @property
    def builds_scene(self) -> bool:
        """Whether the first cell has `build` for a live scene, and keywords `LIVE` for `live`."""
        return "view" in self.options

    def scene(self) -> dict[str, Any]:
        """What the first cell builds: its function, its texts on the page, and how it is played."""
        found: dict[str, Any] = {}
        exec(self.cells[0], found)
        return {
            "build": found["build"],
            "view": tuple(self.options["view"]),
            "name": self.options["scene"],
            "title": self.texts["Title"],
            "lesson": self.name,
            **found["LIVE"],
        }

    def sections(self, language: str = "en") -> Mapping[str, str]:
        """The Markdown of each section; one without a translation is English."""
        word("language", language, LANGUAGES)
        chinese = _chinese().get(self.name, {}) if language == "zh" else {}
        return {**self.texts, **chinese}

    def guesses(self, language: str = "en") -> list[Block]:
        """The questions that the class guesses: those in "Answer" with a list below."""
        answer = self.sections(language).get("Answer", "")
        return [block for block in blocks(answer) if block.items]

    def guess(self, language: str = "en") -> str:
        """The questions and their choices, without what comes of them."""
        asked = self.guesses(language)
        return "\n\n".join("\n- ".join([each.text, *each.choices]) for each in asked)


def blocks(markdown: str) -> list[Block]:
    """Paragraphs and lists, each text on one line."""
    found = []
    for block in markdown.split("\n\n"):
        parts = re.split("^- ", block, flags=re.MULTILINE)
        text, *items = (" ".join(part.split()) for part in parts)
        found.append(Block(text, tuple(items)))
    return found


@cache
def lessons() -> Mapping[str, Lesson]:
    """The lessons of the package by name, in their order."""
    found = [Lesson.read(path) for path in FOLDER.glob("[!_]*.py")]
    found.sort(key=lambda lesson: lesson.options["order"])
    return {lesson.name: lesson for lesson in found}


@cache
def _chinese() -> dict[str, dict[str, str]]:
    """Sections of each lesson in Chinese; a line that is no list item is a paragraph."""
    file = FOLDER / "zh.toml"
    found: dict[str, dict[str, str]] = tomllib.loads(file.read_text("utf-8"))["lessons"]
    for sections in found.values():
        for name, text in sections.items():
            sections[name] = re.sub(r"\n(?!- )", "\n\n", text)
    return found
