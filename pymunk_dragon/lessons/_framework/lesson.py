"""The class whose methods the file of a lesson calls."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pymunk_dragon._extras import optional_imports
from pymunk_dragon._files import written_in_place
from pymunk_dragon.drawing.lettering import pillow_font
from pymunk_dragon.lessons._framework.guess import Guess
from pymunk_dragon.lessons._framework.notebook import NotebookOutput
from pymunk_dragon.lessons._framework.play import current_output
from pymunk_dragon.lessons._framework.terminal import Terminal

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Inches. Default size of a figure: small enough for its text to be legible on a phone.
FIGURE_SIZE = (5.2, 3.7)


class Lesson:
    """A lesson that is running: its file calls a method for each text, and runs its code between them.

    Run as a program, ``python near_miss.py --save pictures``, it prints to the terminal. In a notebook it
    shows its picture.

    Parameters
    ----------
    name : str
        Name of the lesson on the command line and in the files of translations.
    title : str
        Title.
    order : float, optional
        The lessons of the package are listed by increasing order; steps of ten leave room for more. It has no effect
        while the lesson runs.
    live : str, optional
        Name of the ready scene of `pymunk-dragon live` on the lesson.

    Notes
    -----
    Name, title, order, scene and texts must be literals: they are also read from the file without running it.

    Examples
    --------
    The file of a lesson in short, without a figure. Each call with a text prints it:

    >>> import math
    >>> lesson = Lesson("pendulum", "The period of a pendulum", order=160)
    The period of a pendulum
    >>> lesson.question("How long does a pendulum of 1 m take?")
    <BLANKLINE>
    Question
      How long does a pendulum of 1 m take?
    >>> lesson.predict("Count aloud.", ("How long?", "one second", "two seconds"))
    <BLANKLINE>
    Predict
      Count aloud.
    <BLANKLINE>
      How long?
      a) one second
      b) two seconds
    <BLANKLINE>
    >>> print(f"{2 * math.pi * (1 / 9.81) ** 0.5:.3f} s")
    2.006 s
    >>> lesson.answer("The mass does not matter.", ("two seconds", "2.006 s"))
    <BLANKLINE>
    Answer
      The mass does not matter.
    <BLANKLINE>
      How long?
      b) two seconds (2.006 s)
    >>> lesson.check("2.006 s: count ten periods.")
    <BLANKLINE>
    Check
      2.006 s: count ten periods.
    >>> lesson.change("Make it four times as long.")
    <BLANKLINE>
    Change and try
      Make it four times as long.
    """

    def __init__(self, name: str, title: str, *, order: float | None = None, live: str | None = None) -> None:
        self.name = name
        self.order = order
        self.live = live
        self._style = ExitStack()
        self._output = current_output.get() or (
            NotebookOutput() if "ipykernel" in sys.modules else Terminal.of_program()
        )
        self._guesses: tuple[Guess, ...] = ()
        self._output.say(name, "title", title)

    def question(self, text: str) -> None:
        """Print the question of the lesson."""
        self._output.say(self.name, "question", text)

    def predict(self, text: str, *guesses: tuple[str, ...]) -> None:
        """Print what the class guesses before the code runs: a text, and questions, each a tuple with its choices."""
        self._guesses = Guess.of_texts(guesses)
        self._output.say(self.name, "predict", text, self._guesses)

    def picture(self, text: str) -> None:
        """Print what the picture shows."""
        self._output.say(self.name, "picture", text)

    def answer(self, text: str, *results: tuple[str, str]) -> None:
        """Print the answer, two sentences, and for each guess a tuple of its right choice and what the run shows.

        Raises
        ------
        ParameterError
            If it is not one of the choices.
        """
        guesses = [guess.with_result(*result) for guess, result in zip(self._guesses, results, strict=True)]
        self._output.say(self.name, "answer", text, guesses)

    def check(self, text: str) -> None:
        """Print how to check one of the printed numbers by hand."""
        self._output.say(self.name, "check", text)

    def change(self, text: str) -> None:
        """Print what to change in the code and try; the last text of the lesson."""
        self._output.say(self.name, "change", text)

    def file(self, ending: str) -> Path:
        """File for the lesson's picture or film: the name of the lesson with an ending, as ".gif"."""
        return self._output.folder() / f"{self.name}{ending}"

    def font(self, size: float) -> Any:
        """A font of Pillow, `size` pixels high."""
        return pillow_font(size)

    def subplots(
        self,
        rows: int = 1,
        columns: int = 1,
        *,
        figsize: tuple[float, float] = FIGURE_SIZE,
        sharex: bool = False,
        sharey: bool = False,
        width_ratios: Sequence[float] | None = None,
        height_ratios: Sequence[float] | None = None,
        subplot_kw: dict[str, Any] | None = None,
    ) -> tuple[Any, Any]:
        """A new figure and its axes, as of `matplotlib.pyplot.subplots`, in the colours and fonts of the figures.

        Parameters
        ----------
        rows, columns : int
            Numbers of rows and columns of axes.
        figsize : (float, float)
            Width and height, inches.
        sharex, sharey, width_ratios, height_ratios, subplot_kw
            As in `matplotlib.pyplot.subplots`.

        Returns
        -------
        figure : matplotlib.figure.Figure
        axes : matplotlib.axes.Axes or array of them

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        from pymunk_dragon.drawing.figures.style import chart, styled

        self._style.enter_context(styled())
        with optional_imports():
            import matplotlib
        # The font has no minus sign for powers of ten, which a student's axes may have.
        matplotlib.rcParams["axes.unicode_minus"] = False
        figure = chart(*figsize)
        axes = figure.subplots(
            rows,
            columns,
            sharex=sharex,
            sharey=sharey,
            width_ratios=width_ratios,
            height_ratios=height_ratios,
            subplot_kw=subplot_kw,
        )
        return figure, axes

    def show(self, picture: Path | Figure) -> None:
        """Show the picture of the lesson: a film written to `file`, or a figure."""
        # The style of `subplots` also applies to a film of a figure. It ends here: what is drawn next has its own.
        with self._style:
            if not isinstance(picture, Path):
                figure, picture = picture, self.file(".png")
                with written_in_place(picture) as draft:
                    figure.savefig(draft)
            self._output.show(self.name, picture)
