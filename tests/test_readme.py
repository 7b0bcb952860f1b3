"""The programs of README, guides and docstrings run as they stand."""

from __future__ import annotations

import doctest
import re
import shlex
import sys
from contextlib import redirect_stdout
from dataclasses import replace
from importlib import import_module
from io import StringIO
from pathlib import Path
from pkgutil import walk_packages

import pytest
from documents import CHINESE, DOCUMENTS, GUIDES, README, ROOT
from PIL import Image

import pymunk_dragon
from pymunk_dragon import first_contact
from pymunk_dragon.cli import command, status
from pymunk_dragon.sessions import Live

# README in Chinese has the commands and the code of README.
by_other_document = pytest.mark.parametrize(
    "document", [each for each in DOCUMENTS if each != CHINESE], ids=lambda document: document.name
)
# A pile falls otherwise where doubles are rounded otherwise; most of the picture stays as it is,
# and of what a program of a guide measures, the size.
PILE_SHARE = MEASURED = 0.3
# What no run repeats: seconds, and how many times as fast as real time. The engine's errors depend
# on rounding.
VARIES = re.compile(r"[\d.]+ times as fast|\d+\.\d\d$|drift .*;", re.MULTILINE)
# mm: 1e-10 m in the documentation.
EXACT = "0.0000001"

MODULES = [
    found.name
    for found in walk_packages(pymunk_dragon.__path__, "pymunk_dragon.")
    # Lessons are programs: importing one runs it.
    if not re.match(r"pymunk_dragon\.(__main__|lessons\.(?!_framework))", found.name)
]
PACKAGES = sorted({".".join(name.split(".")[:2]) for name in MODULES})


def assert_same_words_and_numbers(printed, shown, rel=1e-4, digit=1e-6):
    """Word for word, and number for number to a few last digits, or to what is given."""
    for one, other in zip(
        VARIES.sub("", printed).split(), VARIES.sub("", shown).split(), strict=True
    ):
        number = re.fullmatch(r"\(?([-+]?\d[\d.]*)[,);:]*", other)
        if number is None:
            assert one == other
        else:
            assert float(one.strip("(),;:")) == pytest.approx(float(number[1]), rel=rel, abs=digit)


@pytest.mark.thorough
@by_other_document
def test_snippets_run_and_print_what_they_say(document, tmp_path, monkeypatch, capsys, golden):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("builtins.input", lambda prompt: "")
    monkeypatch.setattr("webbrowser.open", lambda address: True)
    monkeypatch.setattr(Live, "wait", Live.stop)
    names = {}
    for snippet, shown in document.snippets:
        exec(compile(snippet, document.name, "exec"), names)
        out = capsys.readouterr().out
        if shown:
            assert_same_words_and_numbers(out, shown, MEASURED, 2e-3)
        if document.name == "recursion":
            assert out == shown
        if "near_misses" in snippet:
            assert "[ 5.79920903 -5.77109234]" in out
            assert "412.4738376821" in out
            assert (tmp_path / "last_seconds.gif").exists()
    for path in tmp_path.glob("*.png"):
        if (ROOT / "renders" / path.name).exists():
            with Image.open(path) as picture:
                golden(picture, str(ROOT / "renders" / path.stem), share=PILE_SHARE)


def test_sixty_lines_without_the_package_print_its_numbers(seed_march):
    [(program, shown)] = GUIDES["recursion"].snippets
    assert program.count("\n") <= 60
    assert re.findall(r"^(?:import|from) .*", program, re.MULTILINE) == ["import numpy as np"]
    *states, contact = shown.splitlines()
    now = seed_march.at(300.0)
    for row, handle in zip(states, seed_march.dragon.representatives, strict=True):
        x, y = now.positions[0, handle]
        speed = now.speeds[0, handle]
        assert row == f"300 s, handle {handle}: ({x:.6f}, {y:.6f}) m, {speed:.6f} m/s"
    hit = first_contact(seed_march)
    assert contact == f"benches [{hit.benches[0]} {hit.benches[1]}] touch at {hit.time:.9f} s"


def test_the_contact_that_sixty_lines_miss_is_the_first(seed_march):
    wide = replace(seed_march, dragon=replace(seed_march.dragon, width=0.301))
    text = GUIDES["recursion"].text
    for start in (0.0, 411.0):
        assert f"{first_contact(wide, start=start).time:.9f} s" in text


@pytest.mark.thorough
@by_other_document
def test_commands_run_in_their_order_and_print_what_is_shown(document, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in document.scenarios.items():
        Path(name).write_text(text, encoding="utf-8")
    for arguments, shown in document.program:
        with redirect_stdout(StringIO()) as out:
            assert status(list(arguments)) == 0, shlex.join(arguments)
        if shown:
            assert_same_words_and_numbers(out.getvalue(), shown)


def test_commands_and_make_targets_exist():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for document in DOCUMENTS:
        for (name, *arguments), _ in document.program:
            command(name).make_context(name, list(arguments))
        commands = [shlex.split(line, comments=True) for line, _ in document.shown]
        targets = [words[1] for words in commands if words[0] == "make"]
        targets += [
            word
            for found in re.findall(r"`make ([a-z -]+)`", document.text)
            for word in found.split()
        ]
        for target in targets:
            assert re.search(rf"^{target}:", makefile, re.MULTILINE), (document.name, target)


def test_figures_of_the_readme_are_those_of_the_documentation():
    """The documentation has the command that measures them; a program's outputs are compared."""
    decimal = re.compile(r"(?<![\d.])\d+\.\d+(?![\d.])")
    known = {EXACT}
    for document in DOCUMENTS:
        if document not in (README, CHINESE):
            known.update(decimal.findall(document.text))
    for row in re.findall(r"^\|.*\|$", README.text, re.MULTILINE):
        assert set(decimal.findall(row)) <= known, row


def test_readme_is_the_same_in_chinese():
    """The same commands, code, pictures, addresses and numbers."""
    lines = [
        [line.split("#")[0].replace(" --lang zh", "").strip() for line, _ in each.shown]
        for each in (README, CHINESE)
    ]
    assert lines[0] == lines[1]
    for language in ("python", "toml", "powershell"):
        uncommented = [
            [re.sub(r"\s*#.*", "", block) for block in document.blocks(language)]
            for document in (README, CHINESE)
        ]
        assert uncommented[0] == uncommented[1]
    for pattern in (
        r"\((renders/[^)]+)\)",
        r"src=\"([^\"]+)\"",
        r"\((https?:[^)]+)\)",
        r"\d+\.\d+",
    ):
        found = [sorted(re.findall(pattern, document.text)) for document in (README, CHINESE)]
        assert found[0] == found[1], pattern
    assert "README.zh.md" in README.text
    assert "README.md" in CHINESE.text


@pytest.mark.thorough
@pytest.mark.parametrize("package", PACKAGES)
def test_examples_of_a_package_work_as_written(package, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    # Lessons read the options of the program that plays them.
    monkeypatch.setattr(sys, "argv", ["example"])
    # Lessons print for a notebook where a test of notebooks has imported this.
    monkeypatch.delitem(sys.modules, "ipykernel", raising=False)
    for name in MODULES:
        if f"{name}.".startswith(f"{package}."):
            assert (
                doctest.testmod(
                    import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE
                ).failed
                == 0
            ), name


def test_every_public_name_has_an_example():
    for name in pymunk_dragon.__all__:
        if not name.endswith("Error"):
            assert (
                ">>> " in (getattr(pymunk_dragon, name).__doc__ or "").partition("Examples\n")[2]
            ), name
