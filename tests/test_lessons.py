"""Lessons as teachers and students use them: run, copied, translated, as notebooks."""

from __future__ import annotations

import ast
import json
import os
import re
import subprocess
import sys
import tempfile
from base64 import b64encode
from io import BytesIO
from pathlib import Path

import matplotlib
import nbclient
import nbformat
import pytest
from conftest import assert_says
from lesson_runs import played
from PIL import Image

from pymunk_dragon._display import width
from pymunk_dragon.errors import MissingExtraError, ParameterError
from pymunk_dragon.lessons import LANGUAGES, LESSONS, LessonFile, Terminal, play, record, write_lessons
from pymunk_dragon.lessons._framework import PARTS, lesson_file, make_notebook
from pymunk_dragon.lessons._framework.lines import wrapped
from pymunk_dragon.lessons._framework.markup import in_mathml, in_unicode, pieces, plain

# In the order in which a class hears them.
ORDER = ["question", "predict", "code", "picture", "answer", "check", "change"]
# A lesson of a student's own, with everything that a page shows.
OWN = """from pymunk_dragon.lessons import Lesson
lesson = Lesson("own", "My own")
lesson.question("Why?")
lesson.predict("So?", ("How many?", "one", "two"))
print(6 * 7)
figure, axes = lesson.subplots()
lesson.show(figure)
lesson.answer("Because.", ("two", "2"))
"""


def figures(text):
    """Numbers of a text as they are written."""
    return re.findall(r"\d+(?:\.\d+)?", text)


def flat(text):
    """A text without its line ends and indents."""
    return re.sub(r"\s+", "", text)


def said(lesson):
    """All that a lesson says in a terminal."""
    texts = [lesson.text(part) for part in PARTS]
    texts += [text for each in lesson.guesses for text in (each.question, *each.lettered(), each.result())]
    return [flat(plain(text)) for text in texts]


@pytest.fixture
def own(tmp_path):
    path = tmp_path / "own.py"
    path.write_text(OWN, encoding="utf-8")
    return LessonFile.read(path)


def test_lesson_is_added_by_one_file_at_the_place_of_its_order(tmp_path, monkeypatch):
    for name, order in (("last", 20), ("first", 10), ("between", 15.5)):
        text = f'from pymunk_dragon.lessons import Lesson\n\nlesson = Lesson("{name}", "Of its own", order={order})\n'
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
    (tmp_path / "_helper.py").write_text("")
    monkeypatch.setattr(lesson_file, "FOLDER", tmp_path)
    assert list(lesson_file.lesson_files.__wrapped__()) == ["first", "between", "last"]


def test_lesson_without_translations_is_english_everywhere(own, tmp_path, capsys):
    play(own, Terminal(tmp_path, language="zh"))
    printed = capsys.readouterr().out
    assert all(flat(text) in flat(printed) for text in ("My own", "Why?", "b) two (2)", "Because.", "42", "问题"))
    for ending in (".html", ".ipynb", ".py"):
        write_lessons([own], tmp_path / f"out{ending}", language="zh")
        text = (tmp_path / f"out{ending}").read_text(encoding="utf-8")
        assert "My own" in text
        assert "Because." in text


def test_guess_whose_translation_has_other_choices_is_english(own, monkeypatch):
    [guess] = own.guesses
    for texts in ([["几个？", "一", "二", "三"]], [], [["几个？", "一", "二"]]):
        monkeypatch.setattr(
            "pymunk_dragon.lessons._framework.translations.translations", lambda *_, texts=texts: {"guesses": texts}
        )
        [found] = own.in_language("zh").guesses
        assert (found.question == "几个？") == (texts == [["几个？", "一", "二"]])
        assert (found.right, found.measured) == (guess.right, guess.measured)


def test_each_lesson_asks_before_it_runs_and_has_formulas_that_can_be_read():
    for name, lesson in LESSONS.items():
        kinds = [kind for kind, text in lesson.blocks if text.split("\n")[-1][:9] != "lesson = "]
        assert kinds == ORDER, name
        assert lesson.guesses, name
        for language in LANGUAGES:
            found = lesson.in_language(language)
            for each in found.guesses:
                assert len(set(each.choices)) == len(each.choices) >= 2, name
            for kind, piece in (each for part in PARTS for each in pieces(found.text(part))):
                shown = in_unicode(piece) if kind == "formula" else piece
                assert kind == "code" or not re.search(r"[\\{}$]", shown), (name, piece)
                assert kind != "formula" or in_mathml(piece).startswith("<math"), (name, piece)


@pytest.mark.thorough
def test_picture_of_each_lesson_is_small_and_its_number_to_check_is_printed():
    for name, lesson in LESSONS.items():
        found = played(name)
        with Image.open(BytesIO(found.picture)) as picture:
            assert min(picture.size) >= 200, name
            assert (getattr(picture, "n_frames", 1) > 10) == (found.file.suffix == ".gif"), name
        assert len(found.picture) < 900_000, name
        printed = figures(found.printed)
        for language in LANGUAGES:
            texts = lesson.in_language(language)
            assert set(figures(texts.text("check"))) & set(printed), name
            for each in texts.guesses:
                assert set(figures(each.measured)) <= {*printed, *figures(lesson.text("answer"))}, name


def test_result_is_one_of_the_choices(tmp_path):
    own = tmp_path / "own.py"
    own.write_text('lesson.predict("Count.", ("How many?", "one", "two"))\nlesson.answer("Three.", ("three", "3"))\n')
    with pytest.raises(ParameterError) as caught:
        LessonFile.read(own)
    assert_says(caught.value, "right is 'three'", "one, two")


def test_lesson_leaves_the_settings_of_matplotlib_alone():
    before = dict(matplotlib.rcParams)
    for name in ("spiral", "sat"):  # a picture with axes, and a film of them
        record(LESSONS[name])
        assert dict(matplotlib.rcParams) == before


def run_program(path, *arguments, **options):
    """Run a lesson's own program where there is no screen."""
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "MPLBACKEND")}
    command = [sys.executable, str(path), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=environment, check=False, **options)


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["spiral", "callbacks", "robot"])
def test_program_copied_out_and_notebook_do_the_same_as_the_lesson(name, tmp_path):
    found, lesson, copy = played(name), LESSONS[name], tmp_path / "copied.py"
    write_lessons([lesson], copy)
    done = run_program(copy, "--save", tmp_path / "kept", "--lang", "zh", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    [picture] = (tmp_path / "kept").iterdir()
    assert picture.read_bytes() == found.picture
    assert found.printed in done.stdout
    assert all(text in flat(done.stdout) for text in said(lesson.in_language("zh")))
    made = nbformat.reads(make_notebook(lesson), as_version=4)
    nbclient.NotebookClient(made, timeout=300, resources={"metadata": {"path": tmp_path / "kept"}}).execute()
    outputs = [output for cell in made.cells if cell.cell_type == "code" for output in cell.outputs]
    assert "".join(output.text for output in outputs if output.get("name") == "stdout") == found.printed
    # As HTML, which also a page has that is made from the notebook.
    [html] = [output.data["text/html"] for output in outputs if "text/html" in output.get("data", {})]
    assert b64encode(found.picture).decode() in html


def test_notebook_has_the_lessons_code_and_words_and_folds_the_answer():
    lesson = LESSONS["callbacks"].in_language("zh")
    found = nbformat.reads(make_notebook(lesson), as_version=4).cells
    install, *programs = [cell.source for cell in found if cell.cell_type == "code"]
    assert '%pip install --quiet "pymunk-dragon[demos]"' in install
    assert ast.dump(ast.parse("\n\n".join(programs))) == ast.dump(ast.parse(lesson.code))
    prose = re.sub(r"\\([^\w\s])", r"\1", "\n".join(cell.source for cell in found if cell.cell_type == "markdown"))
    assert all(lesson.text(part) in prose for part in PARTS)
    assert all(choice in prose for each in lesson.guesses for choice in each.lettered())
    *_, answer, live, following = found
    assert answer.source.startswith("<details><summary>")
    assert f"`pymunk-dragon live {lesson.live} --lang zh`" in live.source
    assert " --lang zh`" in following.source


def test_program_lists_plays_and_writes_lessons(call, tmp_path):
    lesson = LESSONS["spiral"].in_language("zh")
    titles = {each.name: each.in_language("zh").title for each in LESSONS.values()}
    assert json.loads(call("demo", "--lang", "zh", "--json")[1]) == {"lessons": titles}
    assert all(title in call("demo", "--lang", "zh")[1] for title in titles.values())
    code, out, err = call("demo", "1", "--save", tmp_path, "--lang", "zh")
    assert (code, err) == (0, "")
    assert all(text in flat(out) for text in said(lesson))
    assert str(tmp_path / "spiral.png") in out
    assert out.endswith(f" demo {list(LESSONS)[1]} --lang zh\n")
    found = json.loads(call("demo", "spiral", "--json", "--save", tmp_path, "--lang", "zh")[1])
    assert found["said"] == {part: lesson.text(part) for part in PARTS}
    [guess] = found["guesses"]
    assert guess["measured"] == "17.1 s"
    assert found["printed"] == played("spiral").printed
    assert Path(found["picture"]).read_bytes() == played("spiral").picture
    assert call("demo", "chain", "-o", tmp_path / "a.py", "--lang", "zh")[0] == 0
    assert (tmp_path / "a.py").read_bytes() == LESSONS["chain"].path.read_bytes()


def test_bad_input_is_one_line(call, monkeypatch, tmp_path):
    for arguments, *words in (
        (["dragon"], "'dragon'", "spiral"),
        (["spiral", "--lang", "fr"], "lang is 'fr'", "en, zh"),
        (["spiral", "--save", __file__], "save is", "a folder that can be written"),
        (["spiral", "--save", ""], "save is ''"),
        (["--save", "pictures"], "--save"),
        (["spiral", "--pause", "-o", "spiral.html"], "--pause"),
        (["-o", "all.ipynb"], "-o is 'all.ipynb'", ".html"),
        (["spiral", "-o", "spiral.pdf"], "-o is 'spiral.pdf'", ".html or .ipynb or .py"),
    ):
        code, out, err = call("demo", *arguments)
        assert (code, out, err.count("\n")) == (2, "", 1), arguments
        assert_says(Exception(err.strip()), "pymunk-dragon: ", *words)
    for arguments in (["--lang", "fr"], ["--save", __file__], ["x"]):
        done = run_program(LESSONS["spiral"].path, *arguments)
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), arguments
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    done = run_program("-m", "pymunk_dragon", "demo", "spiral", "--lang", "zh")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert_says(Exception(done.stderr.strip()), "lang is 'zh'", "ascii", "PYTHONIOENCODING=utf-8")

    def refused(dir):
        raise PermissionError(13, "Permission denied")

    # Nothing is refused to whoever runs the tests as root.
    monkeypatch.setattr(tempfile, "TemporaryFile", refused)
    code, out, err = call("demo", "spiral", "--save", tmp_path)
    assert (code, out) == (2, "")
    assert_says(Exception(err.strip()), "save is", str(tmp_path), "Permission denied")


def test_without_a_library_one_line_names_the_extra(tmp_path):
    for missing, ending, extra in (
        (["nbformat"], ".ipynb", "demos"),
        (["latex2mathml.converter", "latex2mathml"], ".html", "demos"),
        (["jinja2"], ".html", "report"),
        (["jinja2", "pygments", "nbformat"], ".html", "demos"),
    ):
        with pytest.MonkeyPatch.context() as patch:
            for library in missing:
                patch.setitem(sys.modules, library, None)
            with pytest.raises(MissingExtraError) as caught:
                write_lessons([LESSONS["spiral"]], tmp_path / f"out{ending}")
        assert_says(caught.value, f"pymunk-dragon[{extra}]")
    assert list(tmp_path.iterdir()) == []
    own = tmp_path / "own.py"
    own.write_text("import there_is_none\n", encoding="utf-8")
    with pytest.raises(ModuleNotFoundError, match="there_is_none"):
        play(LessonFile.read(own), Terminal())


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["tension", "robot", "u-turn"])
def test_without_the_extras_a_lesson_is_played_or_names_one(name, tmp_path):
    """As where only the core is installed."""
    blocked = "import sys; sys.modules |= dict.fromkeys(['matplotlib', 'scipy']); sys.argv[0] = 'pymunk-dragon'; "
    done = run_program("-c", f"{blocked}from pymunk_dragon.cli import main; main()", "demo", name, "--save", tmp_path)
    if name == "u-turn":
        assert [file.name for file in tmp_path.iterdir()] == ["u-turn.gif"]
    else:
        assert (done.returncode, done.stderr.count("\n")) == (2, 1)
        assert f"pymunk-dragon[{'curves' if name == 'robot' else 'figures'}]" in done.stderr


def test_lesson_waits_for_the_class_and_can_be_interrupted(call, monkeypatch, tmp_path):
    command = ["demo", "spiral", "--save", tmp_path, "--pause"]
    waited = []
    monkeypatch.setattr("builtins.input", waited.append)
    assert "Answer" in call(*command)[1]
    assert waited == ["Press Enter to see what happens. "]
    for error, code, answers in ((KeyboardInterrupt, 130, False), (EOFError, 0, True)):

        def pressed(prompt, error=error):
            raise error

        monkeypatch.setattr("builtins.input", pressed)
        found, out, _ = call(*command)
        assert (found, "Answer" in out) == (code, answers)
    monkeypatch.setattr(sys, "stdin", None)
    assert call(*command)[0] == 0


def test_heads_are_bold_in_a_terminal(terminal, tmp_path):
    assert "\x1b[1mQuestion\x1b[0m" in terminal("demo", "spiral", "--save", tmp_path)
    assert "\x1b" not in run_program("-m", "pymunk_dragon", "demo", "spiral", "--save", tmp_path).stdout


def test_terminal_text_fits_its_width(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "60")
    for language in LANGUAGES:
        for name, lesson in LESSONS.items():
            for part in PARTS[:-1]:
                guesses = lesson.guesses if part in ("predict", "answer") else ()
                Terminal(language=language).say(name, part, lesson.text(part), guesses)
    assert all(width(line) <= 60 for line in capsys.readouterr().out.splitlines())
    text = "龙头沿螺线（等距螺线）前进，速度是 1 m/s。The head goes at 1 m/s, for 412 s. 把手呢？" * 9
    for columns in range(12, 60, 5):
        lines = list(wrapped(text, columns))
        assert flat("".join(lines)) == flat(text)
        for line in lines:
            assert line[0] not in "，。）？ "
            assert line[-1] not in "（ "
            assert not line[-1].isdigit()
