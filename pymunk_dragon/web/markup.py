r"""Markup of texts: `code`, **bold**, and formulas, in simple LaTeX between $."""

import re
from html import escape

from pymunk_dragon._extras import library

# Code, or a formula with the stops behind it, before which browsers would end a line.
MARKED = re.compile(r"(`[^`]*`|\$[^$]*\$[,.;:?!)，。；：？！）]*)")  # noqa: RUF001  # Chinese marks.
BOLD = re.compile(r"\*\*(.*?)\*\*")
# Name of a function in MathML, unless a bracket follows.
FUNCTION = re.compile(r"(<mi>(?:arc)?(?:sin|cos|tan|ln)</mi>)(?!<mo)")
# LaTeX in a terminal; the commands of functions, as \cos, are their own names.
UNICODE = [
    (r"\\mathrm\{(\w+)\}", r"\1"),
    (r"\\sqrt\{([^{}]*)\}", r"√(\1)"),
    (r"\^\\circ", "°"),
    (r"\\cdot", "·"),
    (r"\\theta", "θ"),
    (r"\\pi", "π"),
    (r"\\,", " "),
    (r"\^2", "²"),
    (r"[\\{}]", ""),
]


def html(text: str) -> str:
    """A text as HTML, with formulas as MathML."""
    return BOLD.sub(r"<strong>\1</strong>", "".join(map(_part, MARKED.split(text))))


def _part(part: str) -> str:
    """Code, a formula with stops, or text, in which a number and its unit stay on one line."""
    if part.startswith("`"):
        return f"<code>{escape(part[1:-1])}</code>"
    if part.startswith("$"):
        _, formula, stops = part.split("$")
        return f'<span class="formula">{mathml(formula)}{stops}</span>'
    return re.sub(r"(?<=\d) (?=\w)", "\u00a0", escape(part, quote=False))


def mathml(formula: str, display: str = "inline") -> str:
    """A formula in LaTeX as MathML, "inline" or as a "block" of its own."""
    made = library("latex2mathml.converter").convert(formula, display=display)
    # Browsers leave out the thin space behind the name of a function, which is added here.
    return FUNCTION.sub(r'\1<mspace width="0.167em" />', made)


def plain(text: str) -> str:
    """A text for a terminal, with formulas in Unicode."""
    return re.sub(r"\$([^$]*)\$", lambda found: _unicode(found[1]), text)


def _unicode(formula: str) -> str:
    """A formula in characters of Unicode."""
    for pattern, character in UNICODE:
        formula = re.sub(pattern, character, formula)
    return formula
