"""A lesson as a Jupyter notebook."""

from __future__ import annotations

from pymunk_dragon._extras import library
from pymunk_dragon._language import in_language, text
from pymunk_dragon.lessons._framework.lesson import Lesson


def make_notebook(lesson: Lesson, language: str = "en") -> str:
    """The JSON text of a notebook: program in cells, live scene, and the answer folded."""
    nbformat = library("nbformat")
    v4 = nbformat.v4
    texts = lesson.sections(language)
    with in_language(language):
        needs = text(
            "The kernel needs the package with its extras: pymunk-dragon[demos,live,notebook]."
        )
        title, question = f"# {texts['Title']}", texts["Question"]
        opening = [title, question, f"**{text('Guess')}**", lesson.guess(language), f"*{needs}*"]
        cells = [v4.new_markdown_cell("\n\n".join(opening)), *map(v4.new_code_cell, lesson.cells)]
        if scene := lesson.options.get("scene"):
            arguments = "build, **LIVE" if lesson.builds_scene else f'"{scene}"'
            cells += [
                v4.new_markdown_cell(text("Touch it:")),
                v4.new_code_cell(f"from pymunk_dragon import live\n\nlive({arguments})"),
            ]
        closing = [
            f"**{text(name)}**\n\n{texts[name]}" for name in ("Check", "Change") if name in texts
        ]
        answer = texts.get("Answer", "")
        summary = f"<summary>{text('Answer')}</summary>"
        folded = f"<details>{summary}\n\n{answer}\n\n</details>"
        cells.append(v4.new_markdown_cell("\n\n".join([folded, *closing])))
    for number, cell in enumerate(cells):
        cell["id"] = f"{lesson.name}-{number}"
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    made = v4.new_notebook(
        cells=cells, metadata={"kernelspec": kernel, "language_info": {"name": "python"}}
    )
    nbformat.validate(made)
    return f"{nbformat.writes(made)}\n"
