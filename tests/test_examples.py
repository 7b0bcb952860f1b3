"""The examples in the package's docstrings give what they show."""

from __future__ import annotations

import doctest
import re
import sys
from importlib import import_module
from pkgutil import walk_packages

import pytest

import pymunk_dragon

MODULES = [
    found.name
    for found in walk_packages(pymunk_dragon.__path__, "pymunk_dragon.")
    # Lessons are programs: importing one runs it.
    if not re.match(r"pymunk_dragon\.(__main__|lessons\.(?!_framework))", found.name)
]
PACKAGES = sorted({".".join(name.split(".")[:2]) for name in MODULES})


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
            assert doctest.testmod(import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE).failed == 0, name


def test_every_public_name_has_an_example():
    for name in pymunk_dragon.__all__:
        if not name.endswith("Error"):
            assert ">>> " in (getattr(pymunk_dragon, name).__doc__ or "").partition("Examples\n")[2], name
