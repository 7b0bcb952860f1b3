"""Runs the program of a lesson, whose figure is also saved with Chinese labels, as `NAME.zh.png`.

`python program.py FILE`: as a file, so that it imports no more of the package than the lesson does.
Without the font of the extra `chinese` there is no such figure.
"""

import re
import runpy
import sys
import tomllib
from pathlib import Path
from typing import Any

from pymunk_dragon._extras import is_installed
from pymunk_dragon._language import chinese_font

# A number in a label.
NUMBER = re.compile(r"\d+(?:\.\d+)?")


def chinese(label: str, labels: dict[str, str]) -> str | None:
    """A label in Chinese, with its numbers, if `labels` have it with {} in their place."""
    found = labels.get(NUMBER.sub("{}", label))
    return found and found.format(*NUMBER.findall(label))


def save_in_chinese_too() -> None:
    """Let matplotlib save each figure twice."""
    from matplotlib.figure import Figure
    from matplotlib.font_manager import FontProperties
    from matplotlib.text import Text

    texts = Path(__file__).parents[1] / "zh.toml"
    labels = tomllib.loads(texts.read_text(encoding="utf-8"))["labels"]
    save = Figure.savefig

    def save_twice(figure: Figure, name: Any, **options: Any) -> None:
        save(figure, name, **options)
        for each in figure.findobj(Text):
            if found := chinese(each.get_text(), labels):
                each.set_text(found)
                font = FontProperties(fname=str(chinese_font()), size=each.get_fontsize())
                each.set_fontproperties(font)
        save(figure, Path(name).with_suffix(".zh.png"), **options)

    # The program calls it.
    Figure.savefig = save_twice  # type: ignore[assignment, method-assign]  # Replaces a method.


if __name__ == "__main__":
    program = Path(sys.argv[1])
    draws = "plt." in program.read_text(encoding="utf-8") and is_installed("matplotlib")
    if draws and chinese_font():
        save_in_chinese_too()
    runpy.run_path(str(program), run_name="__main__")
