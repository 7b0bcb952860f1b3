"""English and Chinese: texts that are translated, texts that are not, and missing translations."""

from __future__ import annotations

import re

import pytest
from PIL import ImageFont

from pymunk_dragon import Dragon, March
from pymunk_dragon._language import font, in_language, language, text, texts
from pymunk_dragon.drawing.figures import figure
from pymunk_dragon.errors import MissingExtraError, ParameterError
from pymunk_dragon.lessons import LESSONS, play
from pymunk_dragon.lessons._framework import lesson

CHINESE = re.compile("[\u4e00-\u9fff]")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]\d+)?")


def outputs(call, capsys, language):
    """A command's result, the text of a figure, and a lesson in a terminal, in a language."""
    with in_language(language):
        drawn = figure("speeds", March(Dragon(benches=9), turns=8)).axes[0].get_xlabel()
    play(LESSONS["spiral"], language=language)
    played = capsys.readouterr().out
    return {
        "result": call("contact", "--benches", "9", "--until", "9", "--lang", language)[1],
        "figure": drawn,
        "lesson": re.sub("/.*png", "", played),
    }


def test_main_outputs_are_chinese_where_there_is_a_translation_or_english(
    call, capsys, tmp_path, monkeypatch
):
    english, chinese = (outputs(call, capsys, each) for each in ("en", "zh"))
    for name in english:
        assert not CHINESE.search(english[name]), name
        assert CHINESE.search(chinese[name]), name
    # The program of a lesson, and so what it prints, is English.
    assert "turning 0.114 rad/s" in chinese["lesson"]
    assert call("demo", "spiral", "-o", tmp_path / "page.html", "--lang", "zh")[0] == 0
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert '<html lang="zh">' in page
    assert LESSONS["spiral"].sections("zh")["Title"] in page
    monkeypatch.setattr("pymunk_dragon._language.texts", lambda name: {})
    monkeypatch.setattr(lesson, "_chinese", dict)
    without = outputs(call, capsys, "zh")
    assert without["lesson"].replace(" --lang zh", "") == english["lesson"]
    assert without | {"lesson": ""} == english | {"lesson": ""}


def test_result_in_chinese_has_the_numbers_of_the_english_one_and_the_same_json(call, tmp_path):
    for command in (
        *(
            "positions --times 0,60",
            "positions --paper",
            "contact --from 412.3",
            "study",
            "figure",
            "demo",
        ),
        "simulate --from 412.3 --until 412.6 --contacts report",
        *("study max-speed --benches 9", "study u-turn --benches 9 --no-search"),
    ):
        english, chinese = (call(*command.split(), "--lang", each)[1] for each in ("en", "zh"))
        assert CHINESE.search(chinese), command
        assert "{" not in chinese
        if command != "demo":  # Titles have numbers.
            found = [
                NUMBER.findall(re.sub(r"\b\d+\.\d (times|倍)", "", out))
                for out in (english, chinese)
            ]
            assert sorted(found[0]) == sorted(found[1]), command
    for command in ("positions --times 0", "contact --until 10", "study", "figure"):
        assert call(*command.split(), "--json", "--lang", "zh") == call(
            *command.split(), "--json"
        ), command
    assert call("positions", "--times", "0", "-o", tmp_path / "p.csv", "--lang", "zh")[0] == 0
    assert (tmp_path / "p.csv").read_text().startswith("time_s,handle,x_m,y_m,speed_m_s\n")


def test_errors_and_help_are_english(call):
    for arguments in ("contact --zzz", "contact --pitch 0", "report none.npz", "contact --help"):
        assert call(*arguments.split(), "--lang", "zh") == call(*arguments.split())
    with in_language("zh"), pytest.raises(ParameterError, match="must be a number above 0"):
        March(turns=-1)


def test_language_is_an_option_or_of_the_environment(call, monkeypatch):
    english, chinese = call("study"), call("study", "--lang", "zh")
    assert english != chinese == call("study", "--lang", "en", "--lang", "zh")
    monkeypatch.setenv("PYMUNK_DRAGON_LANG", "zh")
    assert call("study") == chinese
    assert call("study", "--lang", "en") == english
    assert language() == "en"
    monkeypatch.setenv("PYMUNK_DRAGON_LANG", "fr")
    code, _, err = call("positions")
    assert code == 2
    assert "PYMUNK_DRAGON_LANG is 'fr', but must be one of en, zh" in err
    assert "--lang" not in err


def test_messages_on_a_terminal_are_chinese(terminal, tmp_path):
    shown = terminal("positions", "--times", "0", "-o", tmp_path / "p.json", "--lang", "zh")
    assert re.search(r"^已写入 .*p.json$", shown, re.MULTILINE)


def test_font_has_the_characters_of_all_translations(monkeypatch):
    assert font() is None
    with in_language("zh"):
        assert text("no such text") == "no such text"
        face = ImageFont.truetype(font(), 20)
        missing = bytes(face.getmask("\U0010ffff"))
        used = {
            character
            for chinese in texts("zh").values()
            for character in chinese
            if not character.isspace()
        }
        assert {
            character for character in used if bytes(face.getmask(character)) == missing
        } == set()
        monkeypatch.setattr("pymunk_dragon._language.find_spec", lambda name: None)
        with pytest.raises(MissingExtraError, match="chinese"):
            font()
