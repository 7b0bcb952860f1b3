"""Help and errors of the program in Chinese."""

from __future__ import annotations

import ast
import re
import tomllib
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from string import Formatter

import pytest

import pymunk_dragon
from pymunk_dragon._extras import FEATURES
from pymunk_dragon._language import in_language, texts
from pymunk_dragon._text import width
from pymunk_dragon.cli import COMMANDS, PROGRAM, cli
from pymunk_dragon.cli.messages import CAUSE, PARTS, message

# Two English words, one behind the other.
ENGLISH = re.compile(r"(?<![\w-])[a-z]{2,}[,;:]? [a-z]{2,}")
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


# Errors

FOLDER = Path(pymunk_dragon.__file__).parent
# Position of the message among the arguments of an error.
MESSAGE_OF = {
    "ParameterError": 2,
    "UnreachableError": 2,
    "FileFormatError": 1,
    "OutputError": 1,
    "DragonError": 0,
    "UsageError": 0,
    "BadParameter": 0,
}
# Modules whose errors a user of the program does not meet: arguments of functions in Python, curves and functions of
# one's own, messages of the page of a live session, values in the column of errors of a table, and parts of "a damaged
# run".
ONLY_IN_PYTHON = (
    "collision/grid.py",
    "collision/outlines.py",
    "collision/sat.py",
    "drawing/debug_draw/__init__.py",
    "drawing/palette.py",
    "model/curves/_checked.py",
    "model/speed/__init__.py",
    "model/speed/base.py",
    "model/speed/function.py",
    "notebook.py",
    "sessions/handle.py",
    "sessions/messages.py",
    "sessions/scenes/base.py",
    "sessions/session.py",
    "sweeps/evaluation.py",
)
# And single messages, most of which are about types.
ONLY_OF_ARGUMENTS = {
    "77 for arguments of shape 7",
    "a 7",
    "a Curve",
    "a Dragon",
    "a March",
    "a Run",
    "a Scenario, a March, or a mapping of their values",
    "a concurrent.futures.Executor",
    "a curve of the package (7) to be written down, or of a class with a kind of its own",
    "a list or tuple of pymunk.7",
    "a run or a march",
    "a text that no other class has; this is the kind of 7",
    "a tuple of texts",
    "a worker of the executor was lost; a sweep restarts only workers of its own",
    "absent where an executor is given",
    "absent where settings are given as keywords",
    "an EngineSettings",
    "an array of numbers of shape 77 for arguments of shape 7",
    "one for each picture, so 7",
    "one with axes, or written by `write_figure`",
    "the lesson 7 shows no picture",
    'worker processes end as soon as they are started; a script calls sweep under `if __name__ == "__main__":`',
}
# Messages that contain another one, or one of few words, in place of 7.
CONTAINING = {
    "7 has no 7: leave it out, or write a film",
    "7 must be 7",
    "7; 7",
    "line 7: 7",
    "of another sweep: 7",
}


def strings_of(node, module, function):
    """The texts that an expression can be, with 7 in place of values; none if they cannot be read off the code."""
    if isinstance(node, ast.Constant):
        return [node.value] if isinstance(node.value, str) else ["7"]
    if isinstance(node, ast.FormattedValue):
        return strings_of(node.value, module, function) if isinstance(node.value, ast.Name) else ["7"]
    if isinstance(node, ast.IfExp):
        return strings_of(node.body, module, function) + strings_of(node.orelse, module, function)
    if isinstance(node, ast.JoinedStr | ast.BinOp):
        parts = node.values if isinstance(node, ast.JoinedStr) else [node.left, node.right]
        found = [""]
        for part in parts:
            found = [before + more for before in found for more in strings_of(part, module, function) or ["7"]]
        return found
    if isinstance(node, ast.Call):
        name = getattr(node.func, "id", getattr(node.func, "attr", ""))
        return [""] if name == "did_you_mean" else strings_of(node.func.value, module, function) if name == "rstrip" else []
    if isinstance(node, ast.Name):
        known = getattr(import_module(module), node.id, None)
        if isinstance(known, str):
            return [known]
        return [
            each
            for assigned in ast.walk(function)
            if isinstance(assigned, ast.Assign) and getattr(assigned.targets[0], "id", "") == node.id
            for each in strings_of(assigned.value, module, function)
        ]
    return []


def messages_of_the_code():
    """Messages of the errors that the code raises, with their modules."""
    for path in sorted(FOLDER.rglob("*.py")):
        name = path.relative_to(FOLDER).as_posix()
        if name in ONLY_IN_PYTHON:
            continue
        module = ".".join(("pymunk_dragon", *path.relative_to(FOLDER).with_suffix("").parts)).removesuffix(".__init__")
        tree = ast.parse(path.read_text())
        functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
        for function in functions:
            for node in ast.walk(function):
                if isinstance(node, ast.Call):
                    kind = getattr(node.func, "id", getattr(node.func, "attr", ""))
                    if kind in MESSAGE_OF and len(node.args) > MESSAGE_OF[kind]:
                        for english in strings_of(node.args[MESSAGE_OF[kind]], module, function):
                            yield name, english


def test_each_message_of_the_code_is_translated():
    found = {english for _, english in messages_of_the_code()}
    assert found > ONLY_OF_ARGUMENTS | CONTAINING
    with in_language("zh"):
        chinese = {english: message(english) for english in found - ONLY_OF_ARGUMENTS - CONTAINING}
        extras = [feature for feature, _ in FEATURES.values() if message(feature) == feature]
    assert len(chinese) > 150
    assert {english for english, said in chinese.items() if not re.search("[\u4e00-\u9fff]", said)} == set()
    assert {english: said for english, said in chinese.items() if ENGLISH.search(said)} == {}
    assert extras == []


def test_templates_of_messages_have_the_same_fields():
    table = tomllib.loads(files("pymunk_dragon.cli").joinpath("zh.toml").read_text(encoding="utf-8"))["messages"]

    def fields(template):
        return sorted(field for _, field, _, _ in Formatter().parse(template) if field is not None)

    assert {english for english, chinese in table.items() if fields(english) != fields(chinese)} == set()


def test_message_without_a_translation_of_a_part_stays_english():
    with in_language("zh"):
        for english in ("no such message", "pitch is 3, but must be no such bound", "run.npz: no such reason"):
            assert message(english) == english
