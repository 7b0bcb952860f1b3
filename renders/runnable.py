"""Which programs of a guide run in the page, and what each needs of those above it."""

from __future__ import annotations

import ast
import builtins
import re
from dataclasses import dataclass

from pymunk_dragon.publish.program import missing_import

# A block of Python in Markdown.
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
# Calls by which a program shows something: a text, a picture or a live page.
SHOWING = {"print", "live", "save", "render"}


@dataclass(frozen=True)
class Block:
    """A block of a guide: the blocks above that it needs, and whether it runs in a page."""

    needs: list[int]
    runs: bool


def _bound(tree: ast.Module) -> set[str]:
    """The names that a block gives to those below it."""
    names = {
        node.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    }
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            names |= {each.asname or each.name.partition(".")[0] for each in node.names}
    return names


def _loaded(tree: ast.Module) -> set[str]:
    """The names that a block reads, without Python's own and parameters of its functions."""
    names = {
        node.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)
    }
    parameters = {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)}
    return names - parameters - set(dir(builtins))


def _shows(tree: ast.Module) -> bool:
    """Whether a block prints, calls `live` or writes a picture."""
    calls = [node.func for node in ast.walk(tree) if isinstance(node, ast.Call)]
    return any({getattr(each, "id", ""), getattr(each, "attr", "")} & SHOWING for each in calls)


def blocks(text: str) -> list[Block]:
    """The blocks of Python of a guide, in their order.

    Each name that a block reads and does not bind is of the last block above that binds it.
    """
    trees = [ast.parse(found) for found in BLOCK.findall(text)]
    made: list[Block] = []
    able: list[bool] = []
    for place, tree in enumerate(trees):
        needs: set[int] = set()
        for name in _loaded(tree) - _bound(tree):
            above = [i for i in range(place) if name in _bound(trees[i])]
            needs |= {*above[-1:], *(need for i in above[-1:] for need in made[i].needs)}
        able.append(missing_import(tree) is None and all(able[i] for i in needs))
        made.append(Block(sorted(needs), able[-1] and _shows(tree)))
    return made


def marked(text: str) -> str:
    """A guide with an element before each block that runs, or that one needs that runs."""
    found = blocks(text)
    used = {i for each in found if each.runs for i in each.needs}
    places = iter(range(len(found)))

    def element(match: re.Match[str]) -> str:
        place = next(places)
        block = found[place]
        if not block.runs and place not in used:
            return match[0]
        needs = " ".join(map(str, block.needs))
        runs = " data-runs" if block.runs else ""
        return (
            f'<div class="program" data-place="{place}" data-needs="{needs}"{runs}></div>\n\n'
            + (match[0])
        )

    return BLOCK.sub(element, text)
