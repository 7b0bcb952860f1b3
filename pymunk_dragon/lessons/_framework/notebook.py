"""A lesson as a Jupyter notebook."""

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
        title = f"# {texts['Title']}"
        heading = f"**{text('Guess')}**"
        opening = [title, texts["Question"], heading, lesson.guess(language), f"*{needs}*"]
        cells = [v4.new_markdown_cell("\n\n".join(opening))]
        cells += map(v4.new_code_cell, lesson.cells)

        if scene := lesson.options.get("scene"):
            arguments = "build, **LIVE" if lesson.builds_scene else f'"{scene}"'
            program = f"from pymunk_dragon import live\n\nlive({arguments})"
            cells.append(v4.new_markdown_cell(text("Touch it:")))
            cells.append(v4.new_code_cell(program))

        answer = texts.get("Answer", "")
        summary = f"<summary>{text('Answer')}</summary>"
        closing = [f"<details>{summary}\n\n{answer}\n\n</details>"]
        for name in ("Check", "Change"):
            if name in texts:
                closing.append(f"**{text(name)}**\n\n{texts[name]}")
        cells.append(v4.new_markdown_cell("\n\n".join(closing)))

    for number, cell in enumerate(cells):
        cell["id"] = f"{lesson.name}-{number}"
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    metadata = {"kernelspec": kernel, "language_info": {"name": "python"}}
    made = v4.new_notebook(cells=cells, metadata=metadata)
    return f"{nbformat.writes(made)}\n"
