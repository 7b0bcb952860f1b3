"""A guess that a class makes before a lesson runs, and what the run shows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from string import ascii_lowercase

from pymunk_dragon._checks import word


@dataclass(frozen=True)
class Guess:
    """A question with choices, one of which the run of the lesson shows to be right.

    Attributes
    ----------
    question : str
        The question.
    choices : tuple of str
        The choices.
    right : int
        Index of the right choice; -1 until it is known.
    measured : str
        What the run shows in a few words, as "17.1 s".
    """

    question: str
    choices: tuple[str, ...]
    right: int = -1
    measured: str = ""

    @classmethod
    def of_texts(cls, guesses: Iterable[tuple[str, ...]]) -> tuple[Guess, ...]:
        """Guesses from tuples of a question and its choices."""
        return tuple(cls(question, tuple(choices)) for question, *choices in guesses)

    def with_result(self, right: str, measured: str) -> Guess:
        """The guess with its right choice, and what the run shows.

        Raises
        ------
        ParameterError
            If it is not one of the choices.

        Examples
        --------
        >>> Guess("How long?", ("one second", "two seconds")).with_result("two seconds", "2.006 s").right
        1
        """
        return replace(self, right=self.choices.index(word("right", right, self.choices)), measured=measured)

    def lettered(self) -> list[str]:
        """The choices with a letter before each.

        Examples
        --------
        >>> Guess("How long?", ("one second", "two seconds")).lettered()
        ['a) one second', 'b) two seconds']
        """
        return [f"{letter}) {choice}" for letter, choice in zip(ascii_lowercase, self.choices, strict=False)]

    def result(self) -> str:
        """The right choice and what the run shows.

        Examples
        --------
        >>> Guess("How long?", ("one second", "two seconds")).with_result("two seconds", "2.006 s").result()
        'b) two seconds (2.006 s)'
        """
        return f"{self.lettered()[self.right]} ({self.measured})"
