"""The examples in the package's docstrings give what they show."""

from __future__ import annotations

import doctest
from importlib import import_module
from pkgutil import walk_packages

import pytest

import pymunk_dragon

MODULES = [
    found.name
    for found in walk_packages(pymunk_dragon.__path__, "pymunk_dragon.")
    # Lessons are programs: importing one runs it.
    if not found.name.startswith("pymunk_dragon.lessons.") and not found.name.endswith("__main__")
]


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_a_module_work_as_written(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert doctest.testmod(import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE).failed == 0


@pytest.mark.parametrize("name", pymunk_dragon.__all__)
def test_every_public_name_has_an_example(name):
    examples = (getattr(pymunk_dragon, name).__doc__ or "").partition("Examples\n")[2]
    assert ">>> " in examples
