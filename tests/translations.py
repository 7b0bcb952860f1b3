"""For `make lint`: a warning for each text without a translation, and for each unused one."""

from __future__ import annotations

import ast
import json
import re
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path

from bs4 import BeautifulSoup, Tag

from pymunk_dragon._language import texts
from pymunk_dragon.drawing.figures import FIGURES
from pymunk_dragon.lessons import LESSONS
from pymunk_dragon.sessions.scenes import SCENES
from pymunk_dragon.studies import STUDIES
from pymunk_dragon.sweeps.quantities import QUANTITIES

PACKAGE = Path(__file__).parent.parent / "pymunk_dragon"
UNTRANSLATED = {"script", "style", "svg", "canvas", "kbd", "code"}
LETTER = re.compile(r"[^\W\d_]")
# A literal, or a sum of them, as the first argument of `localized` in a script.
LOCALIZED = re.compile(r'\blocalized\(\s*("(?:[^"\\]|\\.)*"(?:\s*\+\s*"(?:[^"\\]|\\.)*")*)?')


def sources(ending: str) -> list[str]:
    """Contents of the files of the package with an ending; templates with whole strings."""
    found = [path.read_text() for path in PACKAGE.rglob(f"*{ending}")]
    if ending != ".j2":
        return found
    return [re.sub(r'"\s*\n\s*"', "", source) for source in found]


def report(what: str, wanted: Iterable[str], found: Iterable[str]) -> None:
    """Print keys that are wanted and not found, and the other way round."""
    for key in sorted(set(wanted) - set(found)):
        print(f"warning: no Chinese {what} {key!r}")
    for key in sorted(set(found) - set(wanted)):
        print(f"warning: unused Chinese {what} {key!r}")


def strings(node: ast.AST) -> set[str]:
    """The string literals in a part of a program; f-strings have the names of their fields."""
    nodes = list(ast.walk(node))
    found = {
        each.value
        for each in nodes
        if isinstance(each, ast.Constant) and isinstance(each.value, str)
    }
    return found | {ast.unparse(each)[2:-1] for each in nodes if isinstance(each, ast.JoinedStr)}


def script_texts(source: str) -> set[str]:
    """First arguments of all calls of `localized`."""
    return {
        json.loads(re.sub(r'"\s*\+\s*"', "", found)) for found in LOCALIZED.findall(source) if found
    }


def blocks(element: Tag) -> Iterator[str]:
    """Contents of the elements with texts of their own, as texts.js finds them."""
    for child in element.find_all(True, recursive=False):
        if child.name in UNTRANSLATED or child.get("translate") == "no":
            continue
        if LETTER.search("".join(child.find_all(string=True, recursive=False))):
            yield " ".join(child.decode_contents().split())
        else:
            yield from blocks(child)


def html_texts(page: str) -> set[str]:
    """Texts of a page's elements and attributes without a {{placeholder}}."""
    parts = {path.stem: path.read_text() for path in (PACKAGE / "web/assets").glob("*.html")}
    whole = re.sub(r"\{\{(\w+)\}\}", lambda found: parts.get(found[1], found[0]), page)
    soup = BeautifulSoup(whole[whole.index("<body") :], "html.parser")
    found = {
        str(each[name])
        for name in ("aria-label", "title")
        for each in soup.find_all(attrs={name: True})
    }
    return {text for text in found.union(blocks(soup)) if LETTER.search(text) and "{{" not in text}


trees = [ast.parse(source) for source in sources(".py")]
calls = [
    node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Call) and node.args
]
wanted = set().union(
    *(strings(call.args[0]) for call in calls if getattr(call.func, "id", "") == "text")
)
wanted = wanted.union(
    *(re.findall(r'\b(?:text|name|words)\("([^"]+)"\)', source) for source in sources(".j2"))
)
wanted = wanted.union(*map(script_texts, sources(".js")))
wanted = wanted.union(*(html_texts(page) for page in sources(".html") if "<body" in page))
wanted |= {lesson.texts["Title"] for lesson in LESSONS.values() if lesson.builds_scene}
wanted |= {words for scene in SCENES.values() for words in (scene.title, scene.text)}
wanted |= {known.summary for known in (*STUDIES.values(), *QUANTITIES.values())}
wanted |= {kind.shows for kind in FIGURES.values()}
wanted = wanted.union(*(lesson.options.get("axes", "").split("|") for lesson in LESSONS.values()))
wanted -= {"", "x (m)", "y (m)"}
# Texts that are looked up by a variable: other strings of the code, and names of columns and
# parameters.
names = {name for quantity in QUANTITIES.values() for name in quantity.parameters}.union(
    *map(strings, trees)
)
others = names | {name.replace("_", mark) for name in names for mark in " -"}
templates = [*sources(".j2"), *sources(".js")]
others = others.union(
    *(re.findall('"([^"\n]*)"', source.replace(r"\\", "\\")) for source in templates)
)
report("text", wanted | (others & set(texts("zh"))), texts("zh"))

translated = tomllib.loads((PACKAGE / "lessons" / "zh.toml").read_text(encoding="utf-8"))["lessons"]
report("texts of lesson", LESSONS, translated)
for name, found in translated.items():
    report(f"text of lesson {name}", LESSONS[name].texts, found)
