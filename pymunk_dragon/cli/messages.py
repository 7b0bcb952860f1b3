"""Messages about errors in the present language.

The exceptions of the package, of Click and of the operating system have English messages. The table `messages` of
``zh.toml`` has their templates, in which fields stand for numbers, names and parts of the message.
"""

from __future__ import annotations

import re
from functools import cache
from string import Formatter

from pymunk_dragon._language import language, text

# Fields that are messages themselves. Without a translation of one, the whole message stays English.
PARTS = ("bound", "columns", "feature", "message", "reason")
# Field for words of the operating system or of another library, which may stay English.
CAUSE = "cause"
# Field for words between which is "or".
CHOICES = "choices"


def message(english: str) -> str:
    """A message in the present language, or in English if the table does not have it.

    Examples
    --------
    >>> from pymunk_dragon._language import in_language
    >>> with in_language("zh"):
    ...     print(message("benches is 1, but must be a whole number from 2 to 10000"))
    benches 为 1，但必须是 2 到 10000 之间的整数
    """
    return english if language() == "en" else _found(english) or english


def _found(english: str) -> str | None:
    """The translation of a message; None if the table does not have it or a part of it."""
    for pattern, template in _templates(language()):
        if matched := pattern.fullmatch(english):
            values = {name: _value(name, value) for name, value in matched.groupdict().items()}
            if None not in values.values():
                return template.format(**values)
    return None


def _value(name: str, english: str) -> str | None:
    """The value of a field in the present language; None if it is a message without a translation."""
    if name in PARTS:
        return _found(english)
    if name == CHOICES:
        return english.replace(" or ", text(" or "))
    return message(english) if name == CAUSE else english


@cache
def _templates(name: str) -> list[tuple[re.Pattern[str], str]]:
    """Patterns of messages with their translations.

    First those with parts, because other fields could match whole parts; then those with more characters of their own.
    """
    import tomllib
    from importlib.resources import files

    table = tomllib.loads(files(__package__).joinpath(f"{name}.toml").read_text(encoding="utf-8"))["messages"]
    parsed = {english: list(Formatter().parse(english)) for english in table}

    def rank(english: str) -> tuple[bool, int]:
        whole = not any(field in (*PARTS, CAUSE) for _, field, *_ in parsed[english])
        return whole, -sum(len(literal) for literal, *_ in parsed[english])

    return [(_pattern(parsed[english]), table[english]) for english in sorted(table, key=rank)]


def _pattern(parsed: list[tuple[str, str | None, str | None, str | None]]) -> re.Pattern[str]:
    """The pattern of a parsed template. A name has no colon, behind which would be a part."""
    any_of = {field: f"(?P<{field}>{'[^:]' if field == 'name' else '.'}+?)" for _, field, *_ in parsed if field}
    return re.compile("".join(re.escape(literal) + any_of.get(field or "", "") for literal, field, *_ in parsed))
