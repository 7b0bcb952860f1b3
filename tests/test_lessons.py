"""Lessons as teachers and students use them: run, copied, translated, as notebooks."""

from __future__ import annotations

import ast
import doctest
import json
import os
import pty
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import tomllib
import unicodedata
from base64 import b64encode
from collections import Counter
from contextlib import suppress
from dataclasses import asdict
from io import BytesIO
from pathlib import Path

import matplotlib
import nbclient
import nbformat
import pytest
from conftest import assert_says
from hypothesis import given
from hypothesis import strategies as st
from lesson_runs import played
from PIL import Image

from pymunk_dragon._language import in_language
from pymunk_dragon.errors import MissingExtraError, ParameterError
from pymunk_dragon.lessons import LANGUAGES, LESSONS, LessonFile, Terminal, play, record, write_lessons
from pymunk_dragon.lessons._framework import (
    PARTS,
    guess,
    lesson_file,
    make_notebook,
    make_page,
    markup,
    notebook,
    terminal,
)
from pymunk_dragon.lessons._framework.markup import in_mathml, in_unicode, pieces, plain
from pymunk_dragon.lessons._framework.notes import notes

FOLDER = Path(terminal.__file__).parent
CATALOGUES = {each: tomllib.loads((FOLDER / f"{each}.toml").read_text(encoding="utf-8")) for each in LANGUAGES}
# In the order in which a class hears them.
ORDER = ["question", "predict", "code", "picture", "answer", "check", "change"]

every_lesson = pytest.mark.parametrize("name", LESSONS)
every_language = pytest.mark.parametrize("language", LANGUAGES)


def figures(text):
    """Numbers of a text as they are written."""
    return re.findall(r"\d+(?:\.\d+)?", text)


def flat(text):
    """A text without its line ends and indents."""
    return re.sub(r"\s+", "", text)


def said(lesson, language="en"):
    """All that a lesson says in a terminal."""
    lesson = lesson.in_language(language)
    texts = [lesson.text(part) for part in PARTS]
    texts += [text for each in lesson.guesses for text in (each.question, *each.lettered(), each.result())]
    return [flat(plain(text)) for text in texts]


def run_program(path, *arguments, **options):
    """Run a lesson's own program where there is no screen."""
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "MPLBACKEND")}
    command = [sys.executable, str(path), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=environment, check=False, **options)


def test_lessons_are_the_fifteen_in_their_order():
    assert list(LESSONS) == [
        *("spiral", "chain", "velocity", "sat", "grid", "near-miss", "missed-window", "unguided", "engine"),
        *("callbacks", "tension", "pitch", "u-turn", "speed-limit", "robot"),
    ]


def test_a_lesson_is_added_by_one_file_at_the_place_of_its_order(tmp_path, monkeypatch):
    for name, order in (("last", 20), ("first", 10), ("between", 15.5)):
        text = f'from pymunk_dragon.lessons import Lesson\n\nlesson = Lesson("{name}", "Of its own", order={order})\n'
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
    (tmp_path / "_helper.py").write_text("")
    monkeypatch.setattr(lesson_file, "FOLDER", tmp_path)
    assert list(lesson_file.lesson_files.__wrapped__()) == ["first", "between", "last"]


@pytest.mark.parametrize("module", [guess, lesson_file, markup, notebook])
def test_examples_run(module):
    assert doctest.testmod(module).failed == 0
    assert doctest.testmod(module).attempted > 2


@every_lesson
def test_lesson_reads_like_one(name):
    """Short; asks before it runs, and answers afterwards, in two sentences."""
    lesson = LESSONS[name]
    assert len(lesson.code.splitlines()) < 60
    assert len(lesson.source.splitlines()) < 85
    assert ast.get_docstring(ast.parse(lesson.source))
    kinds = [kind for kind, text in lesson.blocks if text.split("\n")[-1][:9] != "lesson = "]
    assert kinds == ORDER
    assert lesson.name == name
    assert all(lesson.text(part) for part in PARTS)
    assert len(re.findall(r"[.?!](?= [A-Z`]|$)", lesson.text("answer"))) == 2


@pytest.mark.thorough
@every_lesson
@every_language
def test_program_copied_out_runs_alone_and_does_the_same(name, language, tmp_path):
    copy = tmp_path / "copied.py"
    copy.write_text(LESSONS[name].in_language(language).source, encoding="utf-8")
    done = run_program(copy, "--save", tmp_path / "kept" / "here", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    found = played(name, language)
    [picture] = (tmp_path / "kept" / "here").iterdir()
    assert picture.name in (f"{name}.png", f"{name}.gif")
    assert picture.read_bytes() == found.picture
    assert found.printed in done.stdout
    assert "\x1b" not in done.stdout
    assert all(text in flat(done.stdout) for text in said(LESSONS[name], language))


@every_lesson
def test_chinese_program_differs_only_in_its_texts(name):
    def structure(source):
        tree = ast.parse(source)
        for node in ast.walk(tree):
            match node:
                case ast.Constant(str()):
                    node.value = ""
                case ast.Call(ast.Name("Lesson")):
                    node.keywords = [each for each in node.keywords if each.arg != "language"]
                case ast.JoinedStr():
                    fields = [each for each in node.values if isinstance(each, ast.FormattedValue)]
                    node.values = sorted(fields, key=lambda each: ast.dump(each.value))
        return ast.dump(tree)

    assert structure(LESSONS[name].in_language("zh").source) == structure(LESSONS[name].source)


@every_lesson
def test_fragments_of_translations_are_in_the_program(name):
    assert [english for english, _ in CATALOGUES["zh"][name]["program"] if english not in LESSONS[name].code] == []


# What is left in Chinese output: units, symbols, names in Python, and a message of Python's own.
KEPT = re.compile(
    "m|mm|µm|s|kg|N|rad|e|r|t|x|y|A|B|C|cos|March|Grid|walk|scan|first_contact|separation|GrooveJoint|PinJoint"
    "|begin|pre_solve|post_solve|separate|division|by|zero"
)


@every_lesson
def test_chinese_output_has_the_same_numbers_and_no_english_words(name):
    english, chinese = played(name).printed, played(name, "zh").printed
    assert Counter(figures(english)) == Counter(figures(chinese))
    assert [word for word in re.findall(r"[A-Za-zµ_]+", chinese) if not KEPT.fullmatch(word)] == []
    assert re.search("[\u4e00-\u9fff]", chinese)
    assert max(map(width, chinese.splitlines())) <= max(110, *map(len, english.splitlines()))


def test_comments_of_chinese_programs_are_chinese():
    for lesson in LESSONS.values():
        comments = re.findall(r"# ([^\n]+)", lesson.in_language("zh").code)
        assert [
            each for each in comments if not re.search("[\u4e00-\u9fff]", each) and re.search("[a-z]{4}", each)
        ] == []


def test_picture_is_in_the_language_of_the_lesson():
    assert played("tension").picture != played("tension", "zh").picture
    assert played("unguided").picture != played("unguided", "zh").picture


def test_without_a_chinese_font_one_line_names_the_extra(monkeypatch, tmp_path, call):
    monkeypatch.setattr("pymunk_dragon._language.find_spec", lambda name: None)
    code, out, err = call("demo", "tension", "--lang", "zh", "--save", tmp_path)
    assert (code, out) == (2, "")
    assert_says(Exception(err.strip()), "pymunk-dragon[chinese]")
    # A page has the lessons in English then.
    assert call("demo", "tension", "-o", tmp_path / "page.html")[0] == 0
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == make_page([[played("tension")]])


@pytest.mark.parametrize("name", ["spiral", "sat"])  # a picture with axes, and a film of them
def test_lesson_leaves_the_settings_of_matplotlib_alone(name):
    before = dict(matplotlib.rcParams)
    record(LESSONS[name])
    assert dict(matplotlib.rcParams) == before


@every_lesson
def test_picture_is_small_in_bytes_and_large_enough_to_see(name):
    with Image.open(BytesIO(played(name).picture)) as picture:
        assert min(picture.size) >= 200
        assert len(picture.convert("RGB").getcolors(maxcolors=2**24)) > 3
        frames = getattr(picture, "n_frames", 1)
    assert (frames > 10) == (played(name).file.suffix == ".gif")
    assert len(played(name).picture) < 900_000


@every_lesson
@every_language
def test_number_to_check_is_one_that_the_lesson_prints(name, language):
    printed = figures(played(name).printed)
    assert [number for number in figures(LESSONS[name].in_language(language).text("check")) if number in printed]


@every_language
def test_catalogue_has_every_word(language):
    words = CATALOGUES[language]["words"]
    assert set(words) == set(CATALOGUES["en"]["words"])
    assert all(words.values())


@pytest.mark.parametrize("language", [each for each in LANGUAGES if each != "en"])
def test_no_entry_of_a_catalogue_is_missing_or_left_over(language):
    catalogue = {name: set(texts) for name, texts in CATALOGUES[language].items() if name != "words"}
    assert catalogue == {name: {*PARTS, "guesses", "measured", "program"} for name in LESSONS}


@every_language
def test_notes_for_teachers_are_on_every_lesson(language):
    found = notes(language)
    assert list(found.lessons) == list(LESSONS)
    assert all(20 <= each.minutes <= 60 and each.level and each.needs and each.idea for each in found.lessons.values())
    assert list(found.glossary) == list(notes("en").glossary)
    assert list(found.references) == list(notes("en").references)
    assert [each.minutes for each in found.lessons.values()] == [each.minutes for each in notes("en").lessons.values()]


@every_lesson
@every_language
def test_every_lesson_has_guesses_of_which_one_choice_is_right(name, language):
    lesson = LESSONS[name]
    assert lesson.guesses
    for each in lesson.in_language(language).guesses:
        assert len(set(each.choices)) == len(each.choices) >= 2
        assert 0 <= each.right < len(each.choices)
        assert set(figures(each.measured)) <= {*figures(played(name).printed), *figures(lesson.text("answer"))}


@every_lesson
def test_program_does_not_give_the_result_away(name):
    """No number that is only known from the run, and no words of the right choices, outside the question."""
    lesson = LESSONS[name]
    known = "\n".join(lesson.text(part) for part in ("title", "question", "predict"))
    known += "\n".join(text for each in lesson.guesses for text in (each.question, *each.choices))
    measured = {number for each in lesson.guesses for number in figures(each.measured) if "." in number}
    assert not (measured - set(figures(known))) & set(figures(lesson.code))
    for each in lesson.guesses:
        right = each.choices[each.right]
        assert len(right) < 8 or right not in lesson.code


def test_a_result_is_one_of_the_choices(tmp_path):
    own = tmp_path / "own.py"
    own.write_text('lesson.predict("Count.", ("How many?", "one", "two"))\nlesson.answer("Three.", ("three", "3"))\n')
    with pytest.raises(ParameterError) as caught:
        LessonFile.read(own)
    assert_says(caught.value, "right is 'three'", "one, two")


@every_lesson
@pytest.mark.parametrize("part", PARTS)
def test_chinese_says_the_same_numbers_and_names(name, part):
    english, chinese = (LESSONS[name].in_language(each).text(part) for each in LANGUAGES)
    assert any("\u4e00" <= character <= "\u9fff" for character in chinese)
    assert Counter(figures(english)) == Counter(figures(chinese))
    assert Counter(re.findall("`[^`]+`", english)) == Counter(re.findall("`[^`]+`", chinese))
    assert Counter(re.findall(r"\$[^$]+\$", english)) == Counter(re.findall(r"\$[^$]+\$", chinese))


@every_lesson
def test_chinese_guesses_have_the_same_numbers(name):
    lesson = LESSONS[name]
    for english, chinese in zip(lesson.guesses, lesson.in_language("zh").guesses, strict=True):
        assert (len(english.choices), english.right) == (len(chinese.choices), chinese.right)
        for part in ("question", "choices", "measured"):
            assert Counter(figures(str(getattr(english, part)))) == Counter(figures(str(getattr(chinese, part))))


@every_lesson
@every_language
def test_formulas_are_readable_everywhere(name, language):
    texts = [LESSONS[name].in_language(language).text(part) for part in PARTS]
    texts += asdict(notes(language).lessons[name]).values()
    for text in map(str, texts):
        assert not re.search(r"[\\{}$]", "".join(piece if kind == "text" else "" for kind, piece in pieces(text)))
        for kind, formula in pieces(text):
            if kind == "formula":
                assert not re.search(r"[\\{}$]", in_unicode(formula))
                assert in_mathml(formula).startswith("<math")


def cells(name, language="en"):
    return nbformat.reads(make_notebook(LESSONS[name].in_language(language)), as_version=4).cells


@every_lesson
@every_language
def test_notebook_has_the_lessons_code_and_words(name, language):
    lesson = LESSONS[name].in_language(language)
    found = cells(name, language)
    install, *programs = [cell.source for cell in found if cell.cell_type == "code"]
    assert '%pip install --quiet "pymunk-dragon[demos]"' in install
    code = "\n\n".join(programs)
    assert ast.dump(ast.parse(code)) == ast.dump(
        ast.parse("\n".join(text for kind, text in lesson.blocks if kind == "code"))
    )
    prose = "\n".join(cell.source for cell in found if cell.cell_type == "markdown")
    prose = "".join(
        re.sub(r"\\([^\w\s])", r"\1", piece) if kind == "text" else f"`{piece}`" if kind == "code" else f"${piece}$"
        for kind, piece in pieces(prose)
    )
    assert all(lesson.text(part) in prose for part in PARTS)
    assert all(choice in prose for each in lesson.guesses for choice in each.lettered())
    assert make_notebook(lesson) == make_notebook(lesson)


@pytest.mark.thorough
@every_lesson
@every_language
def test_notebook_runs_and_shows_what_the_lesson_shows(name, language, tmp_path):
    made = nbformat.reads(make_notebook(LESSONS[name].in_language(language)), as_version=4)
    nbclient.NotebookClient(made, timeout=120, resources={"metadata": {"path": tmp_path}}).execute()
    outputs = [output for cell in made.cells if cell.cell_type == "code" for output in cell.outputs]
    assert (
        "".join(output.text for output in outputs if output.get("name") == "stdout") == played(name, language).printed
    )
    [picture] = tmp_path.iterdir()
    assert picture.read_bytes() == played(name, language).picture
    # As HTML, which also a page has that is made from the notebook.
    [html] = [output.data["text/html"] for output in outputs if "text/html" in output.get("data", {})]
    assert b64encode(picture.read_bytes()).decode() in html


def test_the_answer_of_a_notebook_is_folded():
    *_, last, following = cells("spiral")
    assert last.source.startswith("<details><summary>Answer</summary>\n\n")
    assert "`pymunk-dragon demo chain -o chain.ipynb`" in following.source


@every_language
def test_program_lists_the_lessons(call, language):
    code, out, _ = call("demo", "--lang", language)
    assert code == 0
    lines = out.splitlines()
    assert len(lines) == 15
    for number, (line, lesson) in enumerate(zip(lines, LESSONS.values(), strict=True), start=1):
        assert line.split(maxsplit=2) == [str(number), lesson.name, lesson.in_language(language).title]
    _, out, _ = call("demo", "--lang", language, "--json")
    assert json.loads(out) == {
        "lessons": {lesson.name: lesson.in_language(language).title for lesson in LESSONS.values()}
    }


def test_program_plays_a_lesson_and_names_the_next(call, tmp_path):
    code, out, err = call("demo", "spiral", "--save", tmp_path)
    assert (code, err) == (0, "")
    assert all(text in flat(out) for text in said(LESSONS["spiral"]))
    assert str(tmp_path / played("spiral").file.name) in out
    *_, heading, following = out.splitlines()
    assert heading == "Next"
    assert following.endswith(" demo chain")


def test_commands_after_a_lesson_are_in_the_same_language(capsys):
    with in_language("zh"):
        Terminal().say("callbacks", "change", "")
    printed = capsys.readouterr().out
    assert " live jam --lang zh\n" in printed
    assert " demo tension --lang zh\n" in printed
    *_, live, following = cells("callbacks", "zh")
    assert "`pymunk-dragon live jam --lang zh`" in live.source
    assert "`pymunk-dragon demo tension -o tension.ipynb --lang zh`" in following.source


def test_the_last_lesson_has_no_next_one(capsys):
    for name, names_a_lesson in (("speed-limit", True), ("robot", False)):
        Terminal().say(name, "change", "")
        assert ("\nNext\n" in capsys.readouterr().out) == names_a_lesson


def test_without_a_folder_the_picture_is_among_the_temporary_files(call, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    _, out, _ = call("demo", "spiral")
    [picture] = tmp_path.glob("*/spiral.png")
    assert str(picture) in out


def test_program_gives_a_lesson_as_json(call, tmp_path):
    code, out, _ = call("demo", "spiral", "--json", "--save", tmp_path, "--lang", "zh")
    assert code == 0
    found = json.loads(out)
    assert found["said"] == {part: LESSONS["spiral"].in_language("zh").text(part) for part in PARTS}
    [guess] = found["guesses"]
    assert (guess["choices"][guess["right"]], guess["measured"]) == ("约 17 s", "17.1 s")
    assert found["printed"] == played("spiral", "zh").printed
    assert Path(found["picture"]).read_bytes() == played("spiral", "zh").picture
    assert json.loads(call("demo", "spiral", "--json")[1])["picture"] is None


def test_program_writes_notebooks_and_programs(call, tmp_path):
    assert call("demo", "chain", "-o", tmp_path / "a.ipynb", "--lang", "zh")[0] == 0
    assert (tmp_path / "a.ipynb").read_text(encoding="utf-8") == make_notebook(LESSONS["chain"].in_language("zh"))
    assert call("demo", "chain", "-o", tmp_path / "a.py")[0] == 0
    assert (tmp_path / "a.py").read_bytes() == LESSONS["chain"].path.read_bytes()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["dragon"], ["lesson is 'dragon'", "spiral", "robot"]),
        (["spiral", "--lang", "fr"], ["lang is 'fr'", "en, zh"]),
        (["spiral", "--save", __file__], ["save is", "a folder that can be written"]),
        (["spiral", "--save", ""], ["save is ''", "a folder that can be written"]),
        (["--save", "pictures"], ["--save", "a lesson that is played"]),
        (["spiral", "--pause", "-o", "spiral.html"], ["--pause", "a lesson that is played"]),
        (["-o", "all.ipynb"], ["-o is 'all.ipynb'", ".html"]),
        (["spiral", "-o", "spiral.pdf"], ["-o is 'spiral.pdf'", ".html or .ipynb or .py"]),
    ],
)
def test_bad_input_is_one_line(call, arguments, words):
    code, out, err = call("demo", *arguments)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert_says(Exception(err.strip()), "pymunk-dragon: ", *words)


@pytest.mark.parametrize("arguments", [["demo", "spiral"], ["demo"]])
def test_output_that_cannot_write_chinese_is_one_line(arguments):
    command = [sys.executable, "-m", "pymunk_dragon", *arguments, "--lang", "zh"]
    environment = os.environ | {"PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert_says(Exception(done.stderr.strip()), "lang is 'zh'", "ascii", "PYTHONIOENCODING=utf-8")


def test_folder_that_cannot_be_written_is_reported_before_the_lesson(call, monkeypatch, tmp_path):
    def refused(dir):
        raise PermissionError(13, "Permission denied")

    # Nothing is refused to whoever runs the tests as root.
    monkeypatch.setattr(tempfile, "TemporaryFile", refused)
    code, out, err = call("demo", "spiral", "--save", tmp_path)
    assert (code, out) == (2, "")
    assert_says(Exception(err.strip()), "save is", str(tmp_path), "Permission denied")


@pytest.mark.parametrize("arguments", [["--lang", "zh"], ["--save", __file__], ["--sav"], ["x"]])
def test_bad_input_of_a_program_copied_out_is_one_line(tmp_path, arguments):
    copy = shutil.copy(LESSONS["spiral"].path, tmp_path / "copied.py")
    done = run_program(copy, *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("copied.py: ")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("missing", "ending", "extra"),
    [
        (["nbformat"], ".ipynb", "demos"),
        (["pygments"], ".html", "demos"),
        (["latex2mathml.converter", "latex2mathml"], ".html", "demos"),
        (["jinja2"], ".html", "report"),
        (["jinja2", "pygments", "nbformat"], ".html", "demos"),
    ],
)
def test_without_a_library_one_line_names_the_extra(missing, ending, extra, tmp_path, monkeypatch):
    for library in missing:
        monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(MissingExtraError) as caught:
        write_lessons([LESSONS["spiral"]], tmp_path / f"out{ending}")
    assert_says(caught.value, f"pymunk-dragon[{extra}]")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.thorough
@every_lesson
def test_without_the_extras_a_lesson_is_played_or_names_one(name, tmp_path):
    """As where only the core is installed."""
    blocked = "import sys; sys.modules |= dict.fromkeys(['matplotlib', 'scipy']); sys.argv[0] = 'pymunk-dragon'; "
    command = [sys.executable, "-c", blocked + "from pymunk_dragon.cli import main; main()"]
    done = subprocess.run([*command, "demo", name, "--save", tmp_path], capture_output=True, text=True, check=False)
    if done.returncode:
        assert (done.returncode, done.stderr.count("\n")) == (2, 1)
        extra = "curves" if name == "robot" else "figures"
        assert_says(Exception(done.stderr.strip()), f"pymunk-dragon[{extra}]")
        assert list(tmp_path.iterdir()) == []
    else:
        assert [file.name for file in tmp_path.iterdir()] == [f"{name}.gif"]


def test_a_library_that_no_extra_brings_is_missed_as_ever(tmp_path):
    own = tmp_path / "own.py"
    own.write_text("import there_is_none\n", encoding="utf-8")
    with pytest.raises(ModuleNotFoundError, match="there_is_none"):
        play(LessonFile.read(own), Terminal())


def on_terminal(*arguments, answer):
    """What the program writes on a terminal, and its exit code; `answer` is called once it asks for Enter."""
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "pymunk_dragon", *map(str, arguments)]
    process = subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, env=os.environ | {"COLUMNS": "60"})
    os.close(theirs)
    written, asked = b"", False
    # Where a terminal's last user has left, Linux reports an error, and others the end.
    with suppress(OSError):
        while chunk := os.read(ours, 4096):
            written += chunk
            if b"Press Enter" in written and not asked:
                asked = True
                answer(process, ours)
    os.close(ours)
    return written.decode(), process.wait()


def test_a_terminal_gets_bold_heads_and_waits_for_the_class(tmp_path):
    def press(process, keyboard):
        os.write(keyboard, b"\n")

    written, code = on_terminal("demo", "spiral", "--save", tmp_path, "--pause", answer=press)
    assert code == 0
    assert "\x1b[1mQuestion\x1b[0m" in written
    assert written.index("Predict") < written.index("Press Enter to see what happens.") < written.index("Answer")


def test_a_pause_can_be_interrupted(tmp_path):
    def leave(process, keyboard):
        # Python does not notice a signal between writing the prompt and reading from the terminal until Enter comes, so
        # one may have no effect; people press again.
        while process.poll() is None:
            process.send_signal(signal.SIGINT)
            with suppress(subprocess.TimeoutExpired):
                process.wait(timeout=3)

    written, code = on_terminal("demo", "spiral", "--save", tmp_path, "--pause", answer=leave)
    assert code == 130
    assert "Answer" not in written


@pytest.mark.parametrize("where", ["</dev/null", "<&-"])
def test_without_a_keyboard_the_lesson_goes_on(where, tmp_path):
    command = [sys.executable, "-m", "pymunk_dragon", "demo", "spiral", "--pause", "--save", tmp_path]
    done = subprocess.run(["sh", "-c", f'"$@" {where}', "sh", *command], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "Answer" in done.stdout


def test_the_next_lesson_is_started_as_this_one_was(tmp_path):
    """Where the program is not on the path."""
    (tmp_path / "a room").mkdir()
    program = tmp_path / "a room" / "pymunk-dragon"
    program.write_text(f"#!{sys.executable}\nfrom pymunk_dragon.cli import main\n\nmain()\n", encoding="utf-8")
    program.chmod(0o755)
    done = subprocess.run(
        [program, "demo", "spiral", "--save", tmp_path],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PATH": os.defpath},
    )
    assert done.stdout.splitlines()[-1] == f"  '{program}' demo chain"


def width(text):
    return sum(2 if unicodedata.east_asian_width(character) in "WF" else 1 for character in text)


@given(st.lists(st.text("ab ，。（）龙头螺线1.", min_size=1, max_size=30), max_size=9), st.integers(10, 40))
def test_lines_are_no_wider_than_asked_where_they_can_be_broken(words, columns):
    text = " ".join(" ".join(words).split())
    lines = list(terminal.wrapped(text, columns))
    assert flat("".join(lines)) == flat(text)
    for line in lines:
        # Longer only where there is nothing to break: one word, a number and its unit, or a character among stops and
        # brackets.
        if width(line) > columns:
            assert " " not in re.sub(r"(?<=\d) (?=\w)", "", line)
            assert len(re.findall("[\u4e00-\u9fff]", line)) <= 1


def test_a_number_and_its_unit_are_on_one_line():
    text = "The head goes at 1 m/s, for 412 s. 龙头的速度是 1 m/s，长 3 米。" * 5
    for columns in range(12, 60):
        for line in terminal.wrapped(text, columns):
            assert not line[-1].isdigit()


def test_no_line_of_chinese_begins_with_a_stop_or_ends_with_an_opening_bracket():
    text = "龙头沿螺线（等距螺线）前进，速度是 1 m/s。把手呢？" * 20
    for columns in range(12, 60):
        for line in terminal.wrapped(text, columns):
            assert line[0] not in "，。）？ "
            assert line[-1] not in "（ "


@every_lesson
@every_language
def test_terminal_text_fits_its_width(name, language, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "60")
    lesson = LESSONS[name].in_language(language)
    with in_language(language):
        for part in PARTS[:-1]:
            Terminal().say(name, part, lesson.text(part), lesson.guesses if part in ("predict", "answer") else ())
    assert all(width(line) <= 60 for line in capsys.readouterr().out.splitlines())


def test_a_students_own_lesson_speaks_english_and_needs_no_catalogue(tmp_path, capsys):
    own = tmp_path / "own.py"
    own.write_text(
        'from pymunk_dragon.lessons import Lesson\nlesson = Lesson("own", "My own")\nlesson.question("Why?")\n'
        'lesson.predict("So?")\nprint(6 * 7)\n'
        "from unittest.mock import Mock as Window\nwindow = Window()\nwindow.show()\n"
        'lesson.answer("Because.")\nlesson.check("42")\nlesson.change("6")\n',
        encoding="utf-8",
    )
    lesson = LessonFile.read(own)
    chinese = lesson.in_language("zh")
    assert (lesson.name, chinese.title, chinese.text("question")) == ("own", "My own", "Why?")
    play(chinese, Terminal())
    out = capsys.readouterr().out
    assert "Why?" in out
    assert "42" in out


def test_unknown_language_is_refused():
    with pytest.raises(ParameterError) as caught:
        LESSONS["spiral"].in_language("xx")
    assert_says(caught.value, "language is 'xx'", "en, zh")
