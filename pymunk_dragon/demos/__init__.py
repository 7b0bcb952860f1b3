"""The lessons: one file each, which runs by itself."""

from collections.abc import Mapping
from pathlib import Path

from pymunk_dragon.demos.telling import LANGUAGES, Demo, Lesson, Stage, Terminal
from pymunk_dragon.demos.telling.order import LESSONS

__all__ = ["DEMOS", "LANGUAGES", "Demo", "Lesson", "Stage", "Terminal"]

FOLDER = Path(__file__).parent
DEMOS: Mapping[str, Demo] = {
    name: Demo.read(FOLDER / f"{name.replace('-', '_')}.py")
    for name in LESSONS
    if (FOLDER / f"{name.replace('-', '_')}.py").exists()
}
