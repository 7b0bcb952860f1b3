"""Help and errors of the program in Chinese."""

from __future__ import annotations

import ast
import json
import os
import re
import subprocess
import sys
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
from pymunk_dragon.cli.messages import message
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run

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
    for arguments in (["--lang", "zh", "--help"], ["--lang=zh", "--help"], ["--lang", "en", "--help", "--lang", "zh"]):
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
    "line 7 must hold 7, but has a 7",
    "line 7 must hold 7, not 7",
    "line 7: 7",
    "no line holds 7",
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
        if isinstance(node.func, ast.Attribute) and node.func.attr == "rstrip":
            return strings_of(node.func.value, module, function)
        return [""] if getattr(node.func, "id", "") == "did_you_mean" else []
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


@pytest.mark.parametrize(
    ("english", "chinese"),
    [
        (
            "interrupted: 3 of 9 points are in s.csv.journal, from where the sweep can be resumed",
            "已中断：9 个点中的 3 个已记录在 s.csv.journal，可以从那里继续",
        ),
        (
            "the Dask scheduler x has no workers; 3 of 9 points are in j, from where the sweep can be resumed",
            "Dask 调度器 x 没有工作进程；9 个点中的 3 个已记录在 j，可以从那里继续",
        ),
        ("cannot write b.gif: No space left on device", "无法写入 b.gif：磁盘空间不足"),
        ("cannot read or write: c.csv: Permission denied", "无法读写：c.csv：没有权限"),
        ("cannot read or write: Input/output error", "无法读写：Input/output error"),
        (
            "j: of another sweep: axes pitch was [1], but is [2]",
            "j：属于另一个 sweep：axes pitch 原来是 [1]，现在是 [2]",
        ),
        ("r.npz: a damaged run: its times are not finite numbers", "r.npz：运行文件已损坏：其中的 times 不是有限的数"),
        (
            "point 3 is [nan, 0.0], but must be at least 0.1 m from the one before",
            "第 3 个点为 [nan, 0.0]，但必须离前一个点至少 0.1 m",
        ),
        (
            "v.csv: line 2 must hold a time in s and a speed in m/s, not 'x'",
            "v.csv：第 2 行必须是时刻（s）和速度（m/s），而不是 'x'",
        ),
        ("note: lengths are in m: did you mean --pitch 0.55?", "注意：长度的单位是 m：是否想用 --pitch 0.55？"),
    ],
)
def test_parts_of_a_message_are_translated(english, chinese):
    with in_language("zh"):
        assert message(english) == chinese


def test_message_without_a_translation_of_a_part_stays_english():
    with in_language("zh"):
        for english in ("no such message", "pitch is 3, but must be no such bound", "run.npz: no such reason"):
            assert message(english) == english


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, with a run of the exact model and files that are none."""
    monkeypatch.chdir(tmp_path)
    Run.exact(March(turns=8), [79, 80]).save("run.npz")
    Path("text.npz").write_text("no run")
    Path("bad.toml").write_text("pitch =")
    Path("keys.toml").write_text("pich = 0.6")
    Path("letters.csv").write_text("0,0\na,b\n")
    return tmp_path


MISTAKES = {
    # Click
    "contact --pitch abc": "--pitch 的值无效：'abc' 不是数。",
    "contact --benches 1.5": "--benches 的值无效：'1.5' 不是整数。",
    "contact --speed fast": "--speed 的值无效：'fast' 既不是数，也不是以 .csv 结尾的表格文件",
    "contact --pitch": "选项 --pitch 需要一个值。",
    "contact --json=3": "选项 --json 不接受值。",
    "contact more": "多余的参数：more",
    "contact much more": "多余的参数：much more",
    "report": "缺少参数 RUN.npz。",
    "--lang zh": "缺少命令。",
    # Names
    "contct": "没有命令 'contct'：是否想用 contact？",
    "--pitch 3 contact": "这里没有选项 --pitch：命令的选项要写在命令名称之后",
    "contact --zzz": "没有选项 --zzz",
    "contact --pich 3": "没有选项 --pich：是否想用 --pitch？",
    "contact --duration 3": "没有选项 --duration：请用 --until",
    "simulate --guide rail": "--guide 为 'rail'，但必须是 rails, none 之一：是否想用 rails？",
    "study minpitch": "study 为 'minpitch'，但必须是 min-pitch, max-speed, sensitivity, u-turn 之一："
    "是否想用 min-pitch？",
    "contact --curve uturn": "--curve 为 'uturn'，但必须是名称 spiral 或 u-turn、以 .csv 结尾的点的文件，"
    "或者含有 kind 的表：是否想用 u-turn？",
    # Numbers
    "contact --pitch 0": "--pitch 为 0.0，但必须是 0.001 到 1000 m 之间的数",
    "contact --pitch 0.2": "--pitch 为 0.2，但必须大于板凳的宽度 0.3 m",
    "contact --width 30": "pitch 为 0.55，但必须大于板凳的宽度 30 m；长度的单位是 m：是否想用 --width 0.3？",
    "contact --benches 1": "--benches 为 1，但必须是 2 到 10000 之间的整数",
    "simulate --substep 0": "--substep 为 0.0，但必须是大于 0、不超过 1e+09 s 的数",
    "contact --from 20 --until 10": "--until 为 10.0，但必须晚于开始时刻 20 s",
    "positions --times a": "--times 为 'a'，但必须是若干个数，例如 0,60,120，或者 起:止:步长，例如 0:300:1",
    "positions --times 2000": "0 号把手在 t = 2000 s 时没有位置：曲线到 t = 442.59 s 为止",
    "sweep --axis pitch": "--axis 为 'pitch'，但必须是 名称=值，例如 pitch=0.4:0.8:0.01 或 benches=50,100；"
    "有 --samples 时是区间 pitch=0.4:0.8",
    "sweep": "没有给出 --axis，但它必须至少有一个：参数和它的值",
    # Files
    "report none.npz": "run 为 'none.npz'，但必须是可以读取的文件（没有这个文件或文件夹）",
    "report text.npz": "text.npz：不是 pymunk_dragon 的运行文件，或者已损坏",
    "report run.npz -o r.txt": "-o 为 'r.txt'，但必须是以 .json 或 .csv 或 .md 或 .html 或 .xlsx 结尾的文件名",
    "contact -o none/c.json": "-o 为 'none/c.json'，但必须位于可以写入的文件夹中（没有这个文件或文件夹）",
    "contact --scenario none.toml": "--scenario 为 'none.toml'，但必须是可以读取的文件（没有这个文件或文件夹）",
    "contact --scenario bad.toml": "--scenario bad.toml：不是 TOML 文件：",
    "contact --scenario keys.toml": "pich 为 0.6，但必须省略：可用的参数有 benches, ",
    "contact --curve letters.csv": "--curve letters.csv：第 2 行必须是 x（m）和 y（m），而不是 'a,b'",
    # Options that do not go together
    "contact --step 2": "--step 用于 grid 方法：请加上 --method grid",
    "simulate --fine --substep 1": "--fine 已经选定子步和迭代次数：请去掉 --substep 和 --iterations",
    "render run.npz --pitch 1": "运行文件已含有自己的场景：请去掉板凳龙和曲线的选项",
    "render run.npz -o r.html --fps 9": "网页没有 --fps：请去掉它，或者写成动画",
    "render --impulses --until 3": "--impulses 必须去掉：只有物理引擎的运行才有铰接的冲量",
    "study min-pitch --arcs 3": "--arcs 为 3，但必须去掉：min-pitch 的参数是 benches, ",
    "figure drift": "没有给出 run，但它必须是物理引擎的运行：插图 drift 由它绘制",
    "figure drift run.npz": "run 是精确模型的运行，但必须是物理引擎的运行，只有它才有位置误差",
    "demo --pause": "--save 和 --pause 用于运行一课：请给出课程的名称，并去掉 -o",
    "live --exit": "--exit 用于回放：请用 --replay 给出录制文件",
}


@pytest.mark.parametrize("arguments", MISTAKES)
def test_mistake_is_answered_in_chinese_in_one_line(call, folder, monkeypatch, arguments):
    monkeypatch.setenv("PYMUNK_DRAGON_LANG", "zh")
    code, out, err = call(*arguments.split())
    assert (code, out) == (2, "")
    assert err.startswith(f"pymunk-dragon: {MISTAKES[arguments]}")
    assert err.count("\n") == 1


def test_missing_extra_is_named_in_chinese(call, folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "aiohttp", None)
    code, _, err = call("live", "near-miss", "--lang", "zh")
    assert (code, err) == (2, "pymunk-dragon: 实时操作需要先运行：pip install 'pymunk-dragon[live]'\n")


def test_failure_and_interruption_are_chinese(call, monkeypatch, tmp_path):
    monkeypatch.setenv("PYMUNK_DRAGON_LANG", "zh")
    code, _, err = call("contact", "--until", "9", "-o", tmp_path / "c.xlsx")
    assert (code, err) == (1, f"pymunk-dragon: 到 t = 9 s 为止没有碰撞，所以没有写入 {tmp_path / 'c.xlsx'}\n")

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("pymunk_dragon.cli.positions.march_of", interrupted)
    assert call("positions") == (130, "", "pymunk-dragon: 已中断\n")


@pytest.mark.parametrize(("encoding", "said"), [("gbk", "没有选项 --zzz"), ("latin-1", "there is no option --zzz")])
def test_error_is_english_where_stderr_cannot_encode_chinese(encoding, said):
    done = subprocess.run(
        [sys.executable, "-m", "pymunk_dragon", "contact", "--zzz", "--lang", "zh"],
        capture_output=True,
        encoding=encoding,
        env=os.environ | {"PYTHONIOENCODING": encoding},
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"pymunk-dragon: {said}\n")


def test_error_in_an_option_before_the_language_is_chinese(call):
    assert call("contact", "--zzz", "--lang", "zh")[2] == "pymunk-dragon: 没有选项 --zzz\n"
    assert call("contact", "--zzz", "--lang", "en")[2] == "pymunk-dragon: there is no option --zzz\n"


def test_exceptions_stay_english(monkeypatch):
    monkeypatch.setenv("PYMUNK_DRAGON_LANG", "zh")
    with in_language("zh"), pytest.raises(ParameterError, match="must be a number above 0"):
        March(turns=-1)


def test_figures_that_are_left_out_are_named_in_chinese_but_in_english_in_json(call, folder):
    code, out, err = call("figure", "all", "run.npz", "--json", "--lang", "zh")
    assert code == 0
    assert "未绘制 drift：run 是精确模型的运行，但必须是" in err
    assert "one of the exact model" in json.loads(out)["left_out"]["drift"]
