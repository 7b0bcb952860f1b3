"""The examples in the package's docstrings give what they show."""

from __future__ import annotations

import doctest
import re
import sys
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import pytest

import pymunk_dragon

MODULES = [
    found.name
    for found in walk_packages(pymunk_dragon.__path__, "pymunk_dragon.")
    # Lessons are programs: importing one runs it.
    if not re.match(r"pymunk_dragon\.(__main__|lessons\.(?!_framework))", found.name)
]


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_a_module_work_as_written(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    # Lessons read the options of the program that plays them.
    monkeypatch.setattr(sys, "argv", ["example"])
    assert doctest.testmod(import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE).failed == 0


@pytest.mark.parametrize("name", pymunk_dragon.__all__)
def test_every_public_name_has_an_example(name):
    examples = (getattr(pymunk_dragon, name).__doc__ or "").partition("Examples\n")[2]
    assert ">>> " in examples


def test_no_example_is_skipped():
    found = [name for name in MODULES if "SKIP" in Path(import_module(name).__file__).read_text(encoding="utf-8")]
    assert found == []
