"""Help and errors of the program in Chinese."""

from __future__ import annotations

import re

import pytest

from pymunk_dragon._language import texts
from pymunk_dragon._text import width
from pymunk_dragon.cli import COMMANDS, PROGRAM, cli

# Two English words, one behind the other.
ENGLISH = re.compile(r"[a-z]{2,}[,;:]? [a-z]{2,}")
every_command = pytest.mark.parametrize("command", ["", *COMMANDS])


def command_of(name):
    return cli.get_command(None, name) if name else cli


@pytest.fixture
def help_of(call, monkeypatch):
    """The help of a command in a terminal of 80 columns."""
    monkeypatch.setenv("COLUMNS", "80")

    def shown(*arguments):
        code, out, err = call(*arguments)
        assert (code, err) == (0, "")
        return out

    return shown


@every_command
def test_each_text_of_the_help_is_translated(command):
    found = command_of(command)
    context = found.make_context(command or PROGRAM, [], resilient_parsing=True)
    records = [parameter.get_help_record(context) for parameter in found.get_params(context)]
    english = [" ".join(paragraph.split()) for paragraph in found.help.split("\n\n")]
    english += [explained for _, explained in filter(None, records) if explained]
    assert len(english) > 3
    assert [each for each in english if each not in texts("zh")] == []


@every_command
def test_chinese_help_has_no_english_sentence_and_fits_80_columns(help_of, command):
    out = help_of(*command.split(), "--help", "--lang", "zh")
    assert max(map(width, out.splitlines())) <= 80
    said, _, examples = out.partition("\n示例：\n")
    assert said.startswith(f"用法：{PROGRAM}")
    # But for names of choices, each of which is one word.
    assert ENGLISH.findall(said.partition("\n")[2]) == []
    assert examples == help_of(*command.split(), "--help").partition("\nExamples:\n")[2]


@every_command
def test_explanations_of_the_help_begin_in_one_column(help_of, command):
    for out in (help_of(*command.split(), "--help", "--lang", lang) for lang in ("en", "zh")):
        for section in out.split("\n\n"):
            begins = [re.match(r"  (?:-| {10}).*?  +(?=\S)|  +", line) for line in section.splitlines()[1:]]
            if "  -" in section:
                assert len({begin.end() for begin in begins}) == 1


@pytest.mark.parametrize("command", ["", "report", "study"])
def test_language_of_the_help_may_stand_anywhere(help_of, monkeypatch, command):
    chinese = help_of(*command.split(), "--help", "--lang", "zh")
    assert "选项：" in chinese
    for arguments in (["--lang", "zh", "--help"], ["--lang=zh", "-h"], ["--lang", "en", "-h", "--lang", "zh"]):
        assert help_of(*command.split(), *arguments) == chinese
    assert help_of("--lang", "zh", *command.split(), "--help") == chinese
    monkeypatch.setenv("PYMUNK_DRAGON_LANG", "zh")
    assert help_of(*command.split(), "--help") == chinese
    assert "Options:" in help_of(*command.split(), "--help", "--lang", "en")


def test_program_without_a_command_shows_its_help(call, monkeypatch):
    monkeypatch.setenv("PYMUNK_DRAGON_LANG", "zh")
    code, out, err = call()
    assert (code, out) == (2, "")
    assert "选项：" in err


def test_language_before_the_command_is_that_of_the_command(call):
    assert call("--lang", "zh", "figure") == call("figure", "--lang", "zh")
