"""Texts in other languages: each that the code has is translated, and none is left over."""

from __future__ import annotations

import ast
import re
import tomllib
from pathlib import Path
from string import Formatter

import pytest
from PIL import ImageFont

import pymunk_dragon
from pymunk_dragon._language import font, in_language, language, text, texts
from pymunk_dragon.errors import MissingExtraError, ParameterError

FOLDER = Path(pymunk_dragon.__file__).parent


def used():
    """English texts in the code."""
    found = set()
    for path in FOLDER.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "text" and node.args:
                for part in ast.walk(node.args[0]):
                    if isinstance(part, ast.Constant) and isinstance(part.value, str):
                        found.add(part.value)
    for path in FOLDER.rglob("*.j2"):
        found |= set(re.findall(r'\btext\("([^"]+)"\)', path.read_text(encoding="utf-8")))
    return found


def fields(template):
    return sorted((name, spec) for _, name, spec, _ in Formatter().parse(template) if name is not None)


def test_each_text_of_the_code_is_translated():
    assert used() - set(texts("zh")) == set()


def test_packages_translate_the_same_text_alike():
    found = {}
    for path in FOLDER.glob("*/zh.toml"):
        for english, chinese in tomllib.loads(path.read_text(encoding="utf-8"))["texts"].items():
            assert found.setdefault(english, chinese) == chinese


def test_translations_have_the_same_values_to_fill_in():
    assert {english for english, chinese in texts("zh").items() if fields(english) != fields(chinese)} == set()


def test_language_is_that_of_the_context():
    assert language() == "en"
    with in_language("zh"):
        assert language() == "zh"
        assert text("no such text") == "no such text"
    assert language() == "en"


def test_other_languages_are_refused():
    with pytest.raises(ParameterError, match=r"one of en, zh$"), in_language("de"):
        pass


def test_font_has_the_characters_of_all_translations():
    assert font() is None
    with in_language("zh"):
        face = ImageFont.truetype(font(), 20)
    missing = bytes(face.getmask("\U0010ffff"))
    characters = {character for chinese in texts("zh").values() for character in chinese if not character.isspace()}
    assert {character for character in characters if bytes(face.getmask(character)) == missing} == set()


def test_without_the_font_the_extra_is_named(monkeypatch):
    monkeypatch.setattr("pymunk_dragon._language.find_spec", lambda name: None)
    with in_language("zh"), pytest.raises(MissingExtraError, match="chinese"):
        font()


def test_language_of_a_command_is_an_option_or_of_the_environment(call, monkeypatch):
    english, chinese = (call("demo", *arguments)[1] for arguments in ([], ["--lang", "zh"]))
    assert english != chinese
    monkeypatch.setenv("PYMUNK_DRAGON_LANG", "zh")
    assert call("demo")[1] == chinese
    assert call("demo", "--lang", "en")[1] == english
    assert language() == "en"
    monkeypatch.setenv("PYMUNK_DRAGON_LANG", "fr")
    code, _, err = call("positions")
    assert code == 2
    assert "PYMUNK_DRAGON_LANG is 'fr', but must be one of en, zh" in err
