r"""The markup of the lessons' texts: `code` between backticks and formulas between dollar signs, in simple LaTeX.

A page has formulas as MathML, a notebook as they stand, a terminal in Unicode.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Literal

from pymunk_dragon._extras import library

Kind = Literal["text", "code", "formula"]
# Code or a formula with the marks around it.
MARKED = re.compile(r"`[^`]*`|\$[^$]*\$")
KINDS: dict[str, Kind] = {"`": "code", "$": "formula"}
# Name of a function in MathML, unless a bracket follows.
FUNCTION = re.compile(r"(<mi>(?:arc)?(?:sin|cos|tan)</mi>)(?!<mo)")
# LaTeX commands of the formulas as characters; those of functions, as \cos, are their own names.
SYMBOLS = {
    r"\theta": "θ",
    r"\pi": "π",
    r"\cdot": "·",
    r"\approx": "≈",
    r"\circ": "°",
    r"\,": " ",
}
SUPERSCRIPTS = str.maketrans("0123456789+-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻")
SUBSCRIPTS = str.maketrans("0123456789+-", "₀₁₂₃₄₅₆₇₈₉₊₋")


def pieces(text: str) -> Iterator[tuple[Kind, str]]:
    """Kind and content of the parts of a text, without the marks around code and formulas.

    Examples
    --------
    >>> list(pieces("Set `t` to $2 k$."))
    [('text', 'Set '), ('code', 't'), ('text', ' to '), ('formula', '2 k'), ('text', '.')]
    """
    begin = 0
    for marked in MARKED.finditer(text):
        if begin < marked.start():
            yield "text", text[begin : marked.start()]
        yield KINDS[marked[0][0]], marked[0][1:-1]
        begin = marked.end()
    if begin < len(text):
        yield "text", text[begin:]


def plain(text: str) -> str:
    r"""A text with its formulas in Unicode; code keeps its backticks.

    Examples
    --------
    >>> plain(r"`s` is $k \sqrt{\theta^2 + 1}$")
    '`s` is k √(θ² + 1)'
    """
    written: dict[Kind, Callable[[str], str]] = {"text": str, "code": "`{}`".format, "formula": in_unicode}
    return "".join(written[kind](piece) for kind, piece in pieces(text))


def in_unicode(formula: str) -> str:
    r"""A LaTeX formula as plain text.

    Examples
    --------
    >>> in_unicode(r"\mathrm{d}s = k \sqrt{\theta^2 + 1}\,\mathrm{d}\theta")
    'ds = k √(θ² + 1) dθ'
    >>> in_unicode(r"x_A \cos 30^\circ / 0.5^{0.01}")
    'x_A cos 30° / 0.5^0.01'
    """
    text = re.sub(r"\\mathrm\{(\w+)\}", r"\1", formula)
    text = re.sub(r"\\sqrt\{([^{}]*)\}", r"√(\1)", text)
    text = text.replace(r"^\circ", "°")
    for command, symbol in SYMBOLS.items():
        text = text.replace(command, symbol)
    text = re.sub(r"\\([a-z]+)", r"\1", text)
    text = re.sub(r"\^(?:\{([\d+-]+)\}|(\d))", lambda power: (power[1] or power[2]).translate(SUPERSCRIPTS), text)
    text = re.sub(r"_(\d)", lambda index: index[1].translate(SUBSCRIPTS), text)
    return re.sub(r"[{}]", "", text)


def in_mathml(formula: str) -> str:
    """A LaTeX formula as MathML, with a thin space behind the name of a function, which browsers leave out.

    Raises
    ------
    MissingExtraError
        If latex2mathml is not installed.
    """
    made = str(library("latex2mathml.converter").convert(formula))
    return FUNCTION.sub(r'\1<mspace width="0.167em" />', made)
