"""The scripts of the pages: the list beside them against what each declares and uses."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import pymunk_dragon.lessons
import pymunk_dragon.web
from pymunk_dragon.web.page import scripts

ASSETS = Path(pymunk_dragon.web.__file__).parent / "assets"
LESSONS = Path(pymunk_dragon.lessons.__file__).parent
GROUPS = json.loads((ASSETS / "scripts.json").read_text("utf-8"))

STAGES = [path.read_text("utf-8") for path in sorted(LESSONS.glob("*.js"))]
# The scripts of each page, in the order in which they stand there.
PAGES = {
    "player": scripts("viewer", "player"),
    "live": scripts("viewer", "live"),
    "lessons": [*scripts("lab", "played"), *STAGES, *scripts("lessons")],
}

DECLARED = re.compile(r"^(?:async )?(?:const|let|class|function\*?) ([\w$]+)", re.MULTILINE)
# Comments and literal strings; what stands in the fields of templates is code.
NOT_CODE = re.compile(r"\"[^\"\n]*\"|'[^'\n]*'|//[^\n]*|/\*.*?\*/", re.DOTALL)
# Names that are no properties: neither after a point nor before a colon.
NAME = re.compile(r"(?<![\w$.])(?:\.\.\.)?([A-Za-z_$][\w$]*)(?!\s*:)")


def declared_in(script: str) -> set[str]:
    return set(DECLARED.findall(script))


def names_in(script: str) -> set[str]:
    return set(NAME.findall(NOT_CODE.sub("", script)))


@pytest.mark.parametrize("page", PAGES)
def test_scripts_use_only_what_stands_before_them(page):
    order = PAGES[page]
    for place, script in enumerate(order):
        later = set().union(*map(declared_in, order[place + 1 :]))
        assert names_in(script) & later - declared_in(script) == set()


@pytest.mark.parametrize("page", PAGES)
def test_no_two_scripts_of_a_page_declare_the_same_name(page):
    names = [name for script in PAGES[page] for name in DECLARED.findall(script)]
    assert sorted(names) == sorted(set(names))


def test_every_script_is_on_a_page():
    assert {path.stem for path in ASSETS.glob("*.js")} == set().union(*GROUPS.values())
