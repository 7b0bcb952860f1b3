"""The walls between the rooms, as far as they can be read off the source."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path

import pytest

import pymunk_dragon
from pymunk_dragon.demos import DEMOS

ROOT = Path(pymunk_dragon.__file__).parent
# Lessons are programs, not modules: to import one is to play it.
LESSONS = {demo.path for demo in DEMOS.values()}
MODULES = sorted(set(ROOT.rglob("*.py")) - LESSONS)
GROUND_FLOOR = {"errors", "checks", "dragon", "speed", "march", "scenario", "contact", "run", "files"}

every_module = pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))


def room(path):
    return path.relative_to(ROOT).parts[0].removesuffix(".py")


def imported(path):
    """First names of all modules that a file imports, wherever in the file."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add((node.module or "").split(".")[0] if node.level == 0 else "pymunk_dragon")
    return found


def calls(path, name):
    tree = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    return [
        node.lineno
        for node in tree
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == name
    ]


def test_all_of_the_ground_floor_is_looked_at():
    assert {room(path) for path in MODULES} >= GROUND_FLOOR | {"curves"}


@every_module
def test_only_the_command_line_and_lessons_in_a_terminal_print(path):
    assert room(path) == "cli" or path == ROOT / "demos" / "telling" / "terminal.py" or calls(path, "print") == []


@every_module
def test_only_physics_and_debug_draw_import_pymunk(path):
    allowed = room(path) == "physics" or path == ROOT / "render" / "debug_draw.py"
    assert allowed or "pymunk" not in imported(path)


@every_module
def test_only_render_imports_pictures(path):
    assert room(path) == "render" or not imported(path) & {"PIL", "imageio", "matplotlib"}


@every_module
def test_only_the_command_line_imports_click(path):
    assert room(path) == "cli" or "click" not in imported(path)


@every_module
def test_nothing_reads_pickles(path):
    assert not imported(path) & {"pickle", "marshal", "shelve", "dill"}
    assert "allow_pickle=True" not in path.read_text(encoding="utf-8")


@every_module
def test_module_says_what_it_is_and_which_names_it_offers(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    assert ast.get_docstring(tree)
    if path.name == "__main__.py":
        return
    parts = path.relative_to(ROOT.parent).with_suffix("").parts
    module = importlib.import_module(".".join(part for part in parts if part != "__init__"))
    assert isinstance(module.__all__, list | tuple)
    assert len(set(module.__all__)) == len(module.__all__)
    assert [name for name in module.__all__ if not hasattr(module, name)] == []


@every_module
def test_public_functions_and_classes_are_documented(path):
    bare = [
        node.name
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef | ast.ClassDef)
        and not node.name.startswith("_")
        and not ast.get_docstring(node)
    ]
    assert bare == []
