"""Lessons as teachers and students use them: run, copied, translated, as notebooks."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from io import BytesIO

import nbclient
import nbformat
import pytest
from conftest import LIMIT, assert_says
from lesson_runs import played
from PIL import Image

from pymunk_dragon.errors import DragonError, MissingExtraError
from pymunk_dragon.lessons import LESSONS, Lesson, play, record, write_lessons
from pymunk_dragon.lessons._framework import lesson, page
from pymunk_dragon.lessons._framework.lesson import blocks
from pymunk_dragon.lessons._framework.notebook import make_notebook
from pymunk_dragon.lessons._framework.page import make_page
from pymunk_dragon.lessons._framework.program import chinese
from pymunk_dragon.web.markup import html, plain

LANGUAGES = ("en", "zh")
SECTIONS = ["Title", "Question", "Answer", "Check", "Try", "Change", "Teacher"]
# A lesson of a student's own.
OWN = """# %% [markdown] order=1
# # My own
# Why?
# %%
import matplotlib.pyplot as plt
print(6 * 7)
plt.savefig("own.png")
# %% [markdown]
# ## Answer
# Because.
#
# How many?
# - One: it is the first number.
# - **Two**: 2.
"""


def figures(text):
    """Numbers of a text as they are written, without the commas of English ones."""
    return re.findall(r"\d+(?:\.\d+)?", re.sub(r"(\d),(\d{3})\b", r"\1\2", text))


def flat(text):
    """A text without its line ends and indents."""
    return re.sub(r"\s+", "", text)


def lines(lesson, name, language="en"):
    """Paragraphs and items of a section."""
    return [
        line
        for text, items in blocks(lesson.sections(language)[name])
        for line in (text, *items)
        if line
    ]


@pytest.fixture
def own(tmp_path):
    path = tmp_path / "own.py"
    path.write_text(OWN, encoding="utf-8")
    return Lesson.read(path)


def test_lesson_is_added_by_one_file_at_the_place_of_its_order(tmp_path, monkeypatch):
    for name, order in (("last", 20), ("first", 10), ("between", 15.5)):
        (tmp_path / f"{name}.py").write_text(
            f"# %% [markdown] order={order}\n# # Title\n", encoding="utf-8"
        )
    (tmp_path / "_helper.py").write_text("")
    monkeypatch.setattr(lesson, "FOLDER", tmp_path)
    assert list(lesson.lessons.__wrapped__()) == ["first", "between", "last"]


def test_lesson_without_translations_is_english_everywhere(own, tmp_path, capsys):
    play(own, tmp_path, language="zh")
    printed = capsys.readouterr().out
    assert all(
        text in printed for text in ("My own", "Why?", "- **Two**: 2.", "Because.", "42", "答案")
    )
    for ending in (".html", ".ipynb", ".py"):
        write_lessons([own], tmp_path / f"out{ending}", language="zh")
        text = (tmp_path / f"out{ending}").read_text(encoding="utf-8")
        assert "My own" in text
        assert "Because." in text


def test_each_lesson_has_all_sections_in_both_languages_with_the_same_choices_and_numbers():
    for name, each in LESSONS.items():
        assert list(each.sections("en")) == list(each.sections("zh")) == SECTIONS, name
        english, chinese = each.guesses("en"), each.guesses("zh")
        assert len(english) == len(chinese) >= 1, name
        for one, other in zip(english, chinese, strict=True):
            assert (one.right, len(one.choices)) == (other.right, len(other.choices)), name
            for guess in (one, other):
                assert len(set(guess.choices)) == len(guess.choices) >= 2, name
                # Each choice has what comes of it.
                assert all(
                    len(item) > len(choice) + 3
                    for choice, item in zip(guess.choices, guess.items, strict=True)
                )
        for section in ("Answer", "Check"):
            found = [set(figures(each.sections(language)[section])) for language in LANGUAGES]
            assert {number for number in found[0] ^ found[1] if "." in number} == set(), (
                name,
                section,
            )
        for language in LANGUAGES:
            for line in (
                line for section in SECTIONS[1:] for line in lines(each, section, language)
            ):
                assert not re.search(r"[\\${}]|\*\*", re.sub("<code>.*?</code>", "", html(line))), (
                    line
                )
                assert not re.search(r"[\\${}]", re.sub("`[^`]*`", "", plain(line))), line


def test_few_words_stand_before_a_stage_and_the_reason_behind_it_is_short():
    for name, each in LESSONS.items():
        before = {
            language: f"{each.sections(language)['Question']} {each.guess(language)}"
            for language in LANGUAGES
        }
        assert len(each.guesses()) == 1, name
        assert len(re.sub(r"^- ", "", before["en"], flags=re.MULTILINE).split()) <= 40, name
        assert len(re.sub(r"^- |[\s`*]", "", before["zh"], flags=re.MULTILINE)) <= 80, name
        reason = re.sub(r"^- ", "", each.sections()["Answer"], flags=re.MULTILINE)
        assert len(reason.split()) <= 120, name


@pytest.mark.thorough
def test_picture_of_each_lesson_is_small_and_its_numbers_to_check_are_printed():
    for name, each in LESSONS.items():
        found = played(name)
        with Image.open(BytesIO(found.picture)) as picture:
            assert min(picture.size) >= 200, name
        assert len(found.picture) < 900_000, name
        assert any(
            number in found.printed for number in figures(each.sections()["Check"]) if "." in number
        ), name


def test_change_of_the_lesson_on_separating_axes_is_drawn(here):
    source = LESSONS["sat"].source
    changed = source.replace("begins[0] - ends[1]))", "begins[0] - ends[1])[:2])")
    assert changed != source
    exec(changed, {})
    with Image.open("sat.png") as picture:
        assert min(picture.size) >= 200


def test_labels_of_a_picture_are_chinese_on_the_chinese_page():
    labels = {"order {}, {} iterations": "{} 阶，迭代 {} 次", "time (s)": "时间（s）"}
    assert chinese("order 2, 80 iterations", labels) == "2 阶，迭代 80 次"
    assert chinese("time (s)", labels) == "时间（s）"
    assert chinese("0.5", labels) is None
    found = played("spiral")
    pictures = [Image.open(BytesIO(each)) for each in (found.picture, found.chinese)]
    assert pictures[0].convert("RGB").tobytes() != pictures[1].convert("RGB").tobytes()


def test_program_that_fails_or_has_no_picture_is_one_line(own):
    for old, new, words in (
        ("6 * 7", "1 / 0", "ZeroDivisionError"),
        ('plt.savefig("own.png")', "", "own.gif or .png"),
    ):
        own.path.write_text(OWN.replace(old, new), encoding="utf-8")
        with pytest.raises(DragonError) as caught:
            record(Lesson.read(own.path))
        assert_says(caught.value, words)


@pytest.mark.thorough
def test_program_copied_out_and_notebook_with_a_live_scene_do_the_same_as_the_lesson(tmp_path):
    found, copy = played("near-miss"), tmp_path / "copied.py"
    write_lessons([LESSONS["near-miss"]], copy)
    done = subprocess.run(
        [sys.executable, copy], capture_output=True, text=True, cwd=tmp_path, check=True
    )
    assert (done.stdout, done.stderr) == (found.printed, "")
    assert (tmp_path / "near-miss.png").exists()
    made = nbformat.reads(make_notebook(LESSONS["near-miss"]), as_version=4)
    limits = dict.fromkeys(("timeout", "startup_timeout", "iopub_timeout"), LIMIT)
    nbclient.NotebookClient(made, **limits, resources={"metadata": {"path": tmp_path}}).execute()
    outputs = [output for cell in made.cells if cell.cell_type == "code" for output in cell.outputs]
    assert (
        "".join(output.text for output in outputs if output.get("name") == "stdout")
        == found.printed
    )
    assert any("image/png" in output.get("data", {}) for output in outputs)
    # The live scene shows itself.
    assert outputs[-1].data


def test_notebook_has_the_lessons_code_and_words_and_folds_the_answer():
    each = LESSONS["unguided"]
    found = nbformat.reads(make_notebook(each, "zh"), as_version=4).cells
    *programs, live = [cell.source for cell in found if cell.cell_type == "code"]
    assert tuple(programs) == each.cells
    assert live == 'from pymunk_dragon import live\n\nlive("unguided")'
    opening, *_, ending = [cell.source for cell in found if cell.cell_type == "markdown"]
    said = each.sections("zh")
    assert all(
        text in opening
        for text in (said["Title"], said["Question"], *each.guesses("zh")[0].choices)
    )
    answer, rest = ending.split("</details>")
    assert answer.startswith("<details><summary>")
    assert said["Answer"] in answer
    assert all(said[name] in rest for name in ("Check", "Change"))


def test_program_lists_plays_and_writes_lessons(call, tmp_path):
    titles = {name: each.sections("zh")["Title"] for name, each in LESSONS.items()}
    assert json.loads(call("demo", "--lang", "zh", "--json")[1]) == {"lessons": titles}
    assert all(title in call("demo", "--lang", "zh")[1] for title in titles.values())
    code, out, err = call("demo", "spiral", "--save", tmp_path, "--lang", "zh")
    assert (code, err) == (0, "")
    for name in ("Question", "Answer", "Check", "Change"):
        assert all(flat(plain(line)) in flat(out) for line in lines(LESSONS["spiral"], name, "zh"))
    assert played("spiral").printed in out
    assert str(tmp_path / "spiral.png") in out
    assert f" demo {list(LESSONS)[1]} --lang zh\n" in out
    assert json.loads(call("demo", "spiral", "--json")[1]) == {"printed": played("spiral").printed}
    assert call("demo", "chain", "-o", tmp_path / "a.py", "--lang", "zh")[0] == 0
    assert (tmp_path / "a.py").read_bytes() == LESSONS["chain"].path.read_bytes()


def test_bad_input_is_one_line(call, monkeypatch, tmp_path):
    for arguments, *words in (
        (["dragon"], "'dragon'", "spiral"),
        (["spiral", "--lang", "fr"], "lang is 'fr'", "en, zh"),
        (["spiral", "--save", __file__], "save is", "a folder that can be written"),
        (["--save", "pictures"], "--save"),
        (["spiral", "--save", "pictures", "--json"], "--save"),
        (["-o", "all.ipynb"], "-o is 'all.ipynb'", ".html"),
        (["spiral", "-o", "spiral.pdf"], "-o is 'spiral.pdf'", ".html or .ipynb or .py"),
    ):
        code, out, err = call("demo", *arguments)
        assert (code, out, err.count("\n")) == (2, "", 1), arguments
        assert_says(Exception(err.strip()), "pymunk-dragon: ", *words)

    def refused(dir):
        raise PermissionError(13, "Permission denied")

    # Nothing is refused to whoever runs the tests as root.
    monkeypatch.setattr(tempfile, "TemporaryFile", refused)
    code, out, err = call("demo", "spiral", "--save", tmp_path)
    assert (code, out) == (2, "")
    assert_says(Exception(err.strip()), "save is", str(tmp_path), "Permission denied")


def test_without_a_library_one_line_names_the_extra(call, monkeypatch, tmp_path):
    for missing, ending, extra in (
        (["nbformat"], ".ipynb", "demos"),
        (["latex2mathml.converter", "latex2mathml"], ".html", "demos"),
        (["jinja2"], ".html", "report"),
    ):
        with pytest.MonkeyPatch.context() as patch:
            for library in missing:
                patch.setitem(sys.modules, library, None)
            with pytest.raises(MissingExtraError) as caught:
                write_lessons([LESSONS["spiral"]], tmp_path / f"out{ending}")
        assert_says(caught.value, f"pymunk-dragon[{extra}]")
    assert list(tmp_path.iterdir()) == []
    # In a program of a lesson, which runs in a process of its own.
    (tmp_path / "matplotlib.py").write_text(
        """raise ModuleNotFoundError("No module named 'matplotlib'")"""
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=":")
    code, out, err = call("demo", "spiral")
    assert (code, err.count("\n"), "pip install" in err) == (1, 1, False)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    code, out, err = call("demo", "spiral")
    assert (code, err.count("\n"), "pymunk-dragon[demos]" in err) == (2, 1, True)
    assert out == ""  # A library that is not found is named before the texts.


def test_heads_are_bold_in_a_terminal_and_lines_are_short(terminal, call, tmp_path):
    assert "\x1b[1mAnswer\x1b[0m" in terminal("demo", "spiral", "--save", tmp_path)
    out = call("demo", "spiral", "--save", tmp_path)[1]
    assert "\x1b" not in out
    assert max(map(len, out.splitlines())) <= 88


def test_page_is_written_with_progress_the_same_every_time_or_not_at_all(tmp_path, monkeypatch):
    told, path = [], tmp_path / "two.html"
    chosen = [LESSONS["spiral"], LESSONS["chain"]]
    write_lessons(chosen, path, progress=lambda *steps: told.append(steps))
    assert told == [(1, 2), (2, 2)]
    written = path.read_text(encoding="utf-8")
    assert written == make_page([played("spiral"), played("chain")])

    def interrupted(lesson):
        raise KeyboardInterrupt

    monkeypatch.setattr(page, "record", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_lessons(chosen, path)
    assert [(file.name, file.read_text(encoding="utf-8")) for file in tmp_path.iterdir()] == [
        ("two.html", written)
    ]
