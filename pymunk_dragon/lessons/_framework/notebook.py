"""A lesson as a Jupyter notebook, and the output of a lesson that runs in one."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from pymunk_dragon._extras import optional_imports
from pymunk_dragon._html import data_address
from pymunk_dragon.lessons._framework.lesson_file import CODE, LessonFile, next_lesson
from pymunk_dragon.lessons._framework.markup import pieces
from pymunk_dragon.lessons._framework.play import MEDIA_TYPES, Output
from pymunk_dragon.lessons._framework.translations import heading, option

MARKDOWN = "markdown"
# End of a cell: an empty line before a paragraph of code that begins with a comment.
END_OF_CELL = re.compile(r"\n{2,}(?=# )")
# First code cell, for services on which nothing is installed.
INSTALL = """\
# {comment}
from importlib.util import find_spec

if not all(map(find_spec, {libraries})):
    %pip install --quiet "pymunk-dragon[demos]"
"""


def make_notebook(lesson: LessonFile) -> str:
    """A lesson as the JSON text of a notebook.

    Parameters
    ----------
    lesson : LessonFile
        The lesson, which is not run.

    Returns
    -------
    str
        The notebook: question and prediction, the code in cells, and the answer, which is folded.

    Raises
    ------
    MissingExtraError
        If nbformat is not installed.

    Examples
    --------
    >>> import json
    >>> from pymunk_dragon.lessons import LESSONS
    >>> cells = json.loads(make_notebook(LESSONS["spiral"]))["cells"]
    >>> cells[0]["source"][0].strip()
    '# How fast do you turn to watch the head?'
    """
    with optional_imports():
        import nbformat
        from nbformat import v4
    cells = []
    for number, (kind, text) in enumerate(_cells(lesson)):
        name = f"{lesson.name}-{number}"
        cells.append(v4.new_code_cell(text, id=name) if kind == CODE else v4.new_markdown_cell(text, id=name))
    metadata = {
        "kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"},
        "language_info": {"name": "python"},
    }
    made = v4.new_notebook(cells=cells, metadata=metadata)
    nbformat.validate(made)
    return f"{nbformat.writes(made)}\n"


def _cells(lesson: LessonFile) -> Iterator[tuple[str, str]]:
    """Kind and text of each cell."""
    language = lesson.language

    def section(part: str) -> str:
        return f"**{heading(part, language)}**\n\n{_escaped(lesson.text(part))}"

    choices = ["\n".join([f"{_escaped(guess.question)}\n", *_items(guess.lettered())]) for guess in lesson.guesses]
    title = f"# {_escaped(lesson.text('title'))}"
    yield MARKDOWN, "\n\n".join([title, section("question"), section("predict"), *choices])
    yield CODE, INSTALL.format(comment=heading("install", language), libraries=["pymunk_dragon", *lesson.libraries])
    for kind, text in lesson.blocks:
        if kind == CODE:
            yield from ((CODE, cell) for cell in END_OF_CELL.split(text))
    results = "\n".join(_items([f"{guess.question} {guess.result()}" for guess in lesson.guesses]))
    answer = "\n\n".join([section("picture"), section("answer"), results, section("check"), section("change")])
    yield MARKDOWN, f"<details><summary>{heading('answer', language)}</summary>\n\n{answer}\n\n</details>"
    if lesson.live:
        command = f"pymunk-dragon live {lesson.live}{option(language)}"
        yield MARKDOWN, f"**{heading('live', language)}**\n\n`{command}`"
    if (after := next_lesson(lesson.name)) is not None:
        command = f"pymunk-dragon demo {after} -o {after}.ipynb{option(language)}"
        yield MARKDOWN, f"**{heading('next', language)}**\n\n`{command}`"


def _items(lines: Iterable[str]) -> list[str]:
    """Items of a list in Markdown."""
    return [f"- {_escaped(line)}" for line in lines]


def _escaped(text: str) -> str:
    """`text` as Markdown that shows it as it is, with code between backticks and formulas between dollar signs."""
    written: dict[str, Callable[[str], str]] = {
        "text": lambda piece: re.sub(r"([\\*_{}\[\]<>#$|~&])", r"\\\1", piece),
        "code": "`{}`".format,
        "formula": "${}$".format,
    }
    return "".join(written[kind](piece) for kind, piece in pieces(text))


class NotebookOutput(Output):
    """Output of a lesson in the notebook in which it runs, which has the texts already: shows the picture."""

    def show(self, lesson: str, picture: Path) -> None:
        """Show the picture below the cell."""
        from IPython.display import display  # There is IPython where a notebook runs.

        # As HTML: notebooks that are converted to a page leave out the type image/gif of a film.
        address = data_address(picture.read_bytes(), MEDIA_TYPES[picture.suffix])
        html = f'<img src="{address}" alt="{picture.name}" style="max-width: min(100%, 640px)">'
        display({"text/html": html, "text/plain": picture.name}, raw=True)
