"""Printed output in Chinese: the same numbers in the same columns, and files and JSON as in English."""

from __future__ import annotations

import re

import pytest

from pymunk_dragon._language import LANGUAGES, texts
from pymunk_dragon._text import width
from pymunk_dragon.drawing.figures import FIGURES
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.studies import STUDIES

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]\d+)?")
SHORT = ["--from", "412.3"]


@pytest.fixture
def both(call):
    """Output of a command in English and in Chinese, which has no other digits."""

    def called(*arguments):
        found = []
        for lang in ("en", "zh"):
            code, out, err = call(*arguments, "--lang", lang)
            assert (code, err) == (0, "")
            found.append(out)
        return found

    return called


def numbers(text):
    """Numbers in a text, but for those of the wall clock."""
    return sorted(NUMBER.findall(re.sub(r"\b\d+\.\d (times|倍)", "", text)))


@pytest.mark.parametrize(
    "arguments",
    [
        ["contact", "--from", "406"],
        ["contact", "--until", "10"],
        ["contact", "--benches", "3", "--turns", "8"],
        ["contact", "--pitch", "0.31"],
        ["positions", "--times", "0,60", "--handles", "0,223"],
        ["simulate", *SHORT, "--until", "412.6", "--contacts", "report"],
        ["simulate", "--until", "0.2"],
        ["positions", "--paper"],
        ["study", "min-pitch", "--benches", "60"],
        ["study", "max-speed", "--benches", "9"],
        ["study", "sensitivity", "--benches", "60"],
        ["study", "u-turn", "--benches", "9", "--no-search"],
    ],
    ids=" ".join,
)
def test_chinese_output_has_the_numbers_of_the_english_one(both, arguments):
    english, chinese = both(*arguments)
    assert re.search("[\u4e00-\u9fff]", chinese)
    assert numbers(chinese) == numbers(english)
    assert "{" not in chinese


@pytest.mark.parametrize("arguments", [["positions", "--times", "0"], ["contact", "--compare", *SHORT]], ids=" ".join)
def test_columns_of_a_table_end_where_their_heads_end(both, arguments):
    for out in both(*arguments):
        lines = out.splitlines()
        assert max(map(width, lines)) <= 80
        assert len(set(map(width, lines))) == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ["positions", "--times", "0"],
        ["contact", "--until", "10"],
        ["simulate", "--until", "0.1", "--benches", "9", "--guide", "none"],
        ["study"],
        ["figure"],
        ["study", "max-speed", "--benches", "9"],
    ],
    ids=" ".join,
)
def test_json_is_the_same_in_both_languages(both, arguments):
    english, chinese = (re.sub(r'"(wall|real|driver)\w+": [^,}]+', "", out) for out in both(*arguments, "--json"))
    assert english == chinese


def test_csv_is_the_same_in_both_languages(both, tmp_path):
    both("positions", "--times", "0", "-o", tmp_path / "p.csv")
    assert (tmp_path / "p.csv").read_text().startswith("time_s,handle,x_m,y_m,speed_m_s\n")
    english, chinese = both("sweep", "--axis", "turns=8,9", "--benches", "9")
    assert english == chinese


def test_lists_of_studies_and_figures_are_translated():
    chinese = texts("zh")
    assert [study.summary for study in STUDIES.values() if study.summary not in chinese] == []
    assert [kind.shows for kind in FIGURES.values() if kind.shows not in chinese] == []


def test_messages_on_a_terminal_are_chinese(terminal, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYMUNK_DRAGON_LANG", "zh")
    Run.exact(March(turns=8), [79, 80]).save("run.npz")
    assert "运行结果没有保存：加上 -o RUN.npz 即可保存" in terminal("simulate", "--until", "1", "--benches", "9")
    assert re.search(r"^已写入 run.json：\d+(\.\d)? kB$", terminal("report", "run.npz", "-o", "run.json"), re.MULTILINE)


@pytest.mark.parametrize("command", [["simulate", "--until", "30"], ["contact"]], ids=" ".join)
@pytest.mark.parametrize("lang", ["en", "zh"])
def test_lines_of_a_terminal_have_at_most_80_columns(terminal, command, lang):
    shown = re.sub(r"\x1b\[[?\d]*\w", "", terminal(*command, "--lang", lang))
    assert max(map(width, re.split(r"[\r\n]", shown))) <= 80


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(
    "arguments",
    [
        ["positions", "--paper"],
        ["contact"],
        ["contact", "--compare", "--benches", "20", "--from", "405"],
        ["simulate", "--from", "411", "--benches", "20"],
        ["study"],
        ["study", "min-pitch", "--benches", "60"],
        ["study", "max-speed"],
        ["study", "u-turn", "--no-search"],
        ["study", "sensitivity"],
        ["figure"],
        ["demo"],
    ],
    ids=" ".join,
)
def test_printed_lines_fit_a_terminal_of_80_columns(call, arguments, language):
    code, out, err = call(*arguments, "--lang", language)
    assert code == 0
    assert max(map(width, (out + err).splitlines())) <= 80
