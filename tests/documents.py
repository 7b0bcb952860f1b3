"""Texts for users (README, guides, long docstrings of modules), and the code in them."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from documentation import GUIDES as NAMES
from documentation import MODULES

ROOT = Path(__file__).parent.parent


@dataclass(frozen=True)
class Document:
    """A text in Markdown, and the blocks of code in it."""

    name: str
    text: str

    def blocks(self, language: str) -> list[str]:
        """The blocks of code of a language."""
        return [
            text
            for found, text in re.findall(r"```(\w+)\n(.*?)```", self.text, re.DOTALL)
            if found == language
        ]

    @property
    def snippets(self) -> list[tuple[str, str]]:
        """Each block of Python, and the output that stands below it."""
        return re.findall(r"```python\n(.*?)```(?:\n\n```text\n(.*?)```)?", self.text, re.DOTALL)

    @property
    def shown(self) -> list[tuple[str, str]]:
        """Each command, without the prompt, and the output that stands below it."""
        found = []
        for block in self.blocks("console"):
            for command in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
                line, _, output = command.partition("\n")
                found.append((line, output))
        return found

    @property
    def program(self) -> list[tuple[list[str], str]]:
        """The arguments of each command of the program, and the output that stands below it."""
        split = [(shlex.split(line, comments=True), output) for line, output in self.shown]
        return [(words[1:], output) for words, output in split if words[0] == "pymunk-dragon"]

    @property
    def scenarios(self) -> dict[str, str]:
        """The scenario files by the names in their first lines."""
        return {text.splitlines()[0].removeprefix("# "): text for text in self.blocks("toml")}


README, CHINESE = (
    Document(name, (ROOT / name).read_text(encoding="utf-8"))
    for name in ("README.md", "README.zh.md")
)
GUIDES = {
    name: Document(
        name,
        (ROOT / f"renders/guides/{name}.md")
        .read_text(encoding="utf-8")
        .replace("](../", "](renders/"),
    )
    for name in NAMES
}
MODULE_TEXTS = [
    Document(name, import_module(name).__doc__ or "")
    for name in map("pymunk_dragon.{}".format, MODULES)
]
DOCUMENTS = [README, CHINESE, *GUIDES.values(), *MODULE_TEXTS]
