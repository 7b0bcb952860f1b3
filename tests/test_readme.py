"""What README shows runs as it stands."""

from __future__ import annotations

import re
import shlex
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
from PIL import Image

from pymunk_dragon.cli import cli, main

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", README, re.DOTALL)
SNIPPETS = [text for language, text in BLOCKS if language == "python"]
# By the names in their first lines.
SCENARIOS = {text.splitlines()[0].removeprefix("# "): text for language, text in BLOCKS if language == "toml"}
COMMANDS = [
    line.removeprefix("$ ")
    for language, text in BLOCKS
    if language == "console"
    for line in text.splitlines()
    if line.startswith("$ ")
]
PROGRAM = [shlex.split(command, comments=True) for command in COMMANDS if command.startswith("pymunk-dragon ")]


# A pile falls otherwise where doubles are rounded otherwise; most of the picture stays as it is.
PILE_SHARE = 0.3


@pytest.mark.thorough
def test_snippets_run_and_print_what_they_say(tmp_path, monkeypatch, capsys, golden):
    monkeypatch.chdir(tmp_path)
    for snippet in SNIPPETS:
        exec(compile(snippet, "README.md", "exec"), {})
    out = capsys.readouterr().out
    assert "[ 5.79920903 -5.77109234]" in out
    assert "benches=(0, 8)" in out
    assert "time=412.4738" in out
    assert (tmp_path / "last_seconds.gif").exists()
    with Image.open(tmp_path / "debug_draw.png") as picture:
        golden(picture, str(ROOT / "renders" / "debug_draw"), share=PILE_SHARE)


def test_commands_are_ones_that_the_program_understands():
    for _, name, *arguments in PROGRAM:
        cli.commands[name].make_context(name, arguments)


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """What each command prints, run once and in the order of README; every one has to succeed."""
    outputs = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("readme"))
        for name, text in SCENARIOS.items():
            Path(name).write_text(text, encoding="utf-8")
        for command in dict.fromkeys(shlex.join(words[1:]) for words in PROGRAM):
            with redirect_stdout(StringIO()) as out, pytest.raises(SystemExit) as stopped:
                main(shlex.split(command))
            assert stopped.value.code == 0, command
            outputs[command] = out.getvalue()
    return outputs


@pytest.mark.thorough
def test_commands_run_in_the_order_in_which_they_stand(printed):
    assert len(printed) > 20
    assert "benches 0 and 8" in printed["contact"]


@pytest.mark.thorough
def test_the_five_answers_are_those_that_the_commands_print(printed):
    """Word for word, and number for number to a few last digits."""
    [block] = [text for language, text in BLOCKS if language == "console" and "study min-pitch" in text]
    shown = re.split(r"^\$ pymunk-dragon ", block, flags=re.MULTILINE)[1:]
    assert len(shown) == 5
    for each in shown:
        command, _, expected = each.partition("\n")
        for one, other in zip(printed[command].split(), expected.split(), strict=True):
            number = re.fullmatch(r"\(?(-?\d[\d.]*)[,);:]*", other)
            if number is None:
                assert one == other
            else:
                assert float(one.strip("(),;:")) == pytest.approx(float(number[1]), rel=1e-4, abs=1e-6)


def test_make_targets_of_the_readme_exist():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = [shlex.split(command, comments=True)[1] for command in COMMANDS if command.startswith("make ")]
    assert {"render", "test"} <= set(targets)
    for target in targets:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE)


def test_readme_lists_the_lessons_as_the_program_does(capsys):
    with pytest.raises(SystemExit):
        main(["demo"])
    assert "```console\n$ pymunk-dragon demo\n" + capsys.readouterr().out + "```" in README
