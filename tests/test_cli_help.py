"""Help of the commands, hints after mistakes, what a terminal says of files, and what a shell completes."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete

from pymunk_dragon import March, Run
from pymunk_dragon.cli import COMMANDS, COMPLETE_VARIABLE, PROGRAM, cli, command
from pymunk_dragon.cli.common import SCENARIO_OPTIONS


def examples_of(text):
    """The commands in the examples of a help, each as its arguments."""
    return [shlex.split(line)[1:] for line in text.partition("Examples:\n")[2].splitlines()]


def test_help_fits_80_columns_and_has_examples_that_the_command_takes(call, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    for each in ("", *COMMANDS):
        code, out, err = call(*each.split(), "--help")
        assert (code, err) == (0, "")
        assert max(map(len, out.splitlines())) <= 80
        assert examples_of(out)
        for name, *arguments in examples_of(out):
            assert name == each or not each
            command(name).make_context(name, arguments)
        if each not in ("", "report", "demo"):
            # The command's own options stand before those of the dragon.
            flags = [f"  --{name.replace('_', '-')} " for name in SCENARIO_OPTIONS]
            assert out.index(flags[0]) > max(out.index("  --scenario "), out.find("  --from "), out.find("  --json "))
            assert all(flag in out for flag in flags)
            assert COMMANDS[each] in " ".join(out.split())
    listed = call("--help")[1].partition("Commands:\n")[2].partition("\n\n")[0].splitlines()
    assert [line.split()[0] for line in listed] == list(COMMANDS)


def test_program_without_a_command_shows_its_help_and_version(call):
    code, out, err = call()
    assert (code, out) == (2, "")
    assert "Commands:" in err
    assert call("-V") == call("--version")


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["positions", "contact", "render", "report"])
def test_examples_of_the_help_run(call, late_run, name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    late_run.save("run.npz")
    for arguments in examples_of(call(name, "--help")[1]):
        assert call(*arguments)[0] == 0, arguments


# Mistakes, and what was meant.
MEANT = {
    "figure spirl": "spiral",
    "study minpitch": "min-pitch",
    "demo spirall": "spiral",
    "sweep --axis pitch=0.4,0.5 --quantity contact-tim": "contact-time",
    "sweep --axis pich=0.4,0.5": "pitch",
    "positions --curve uturn": "u-turn",
    "positions --scenario s.toml": "pitch",
    "simulate --pich 3": "--pitch",
    "simulat": "simulate",
    "simulate --guide rail": "rails",
    "contact --method exat": "exact",
    "live nearmiss": "near-miss",
}


def test_mistake_gets_the_word_that_was_meant(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("s.toml").write_text("pich = 0.6\n")
    for arguments, meant in MEANT.items():
        code, out, err = call(*arguments.split())
        assert (code, out, err.count("\n")) == (2, "", 1), arguments
        assert meant in err, arguments
    assert os.listdir(tmp_path) == ["s.toml"]


# What a terminal says of the file beside its size.
WRITTEN = {
    "render run.npz --size 64": "run.gif",
    "simulate --until 1 --benches 9 -o r.npz": "r.npz",
    "report run.npz -o r.json": "r.json",
    "sweep --axis turns=8,9 --benches 9 -o s.csv": "s.csv",
}


@pytest.mark.thorough
def test_terminal_says_which_file_was_written(terminal, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Run.exact(March(turns=8), [79, 80, 81]).save("run.npz")
    for arguments, name in WRITTEN.items():
        said = terminal(*arguments.split())
        assert re.search(rf"^wrote {re.escape(name)}: \d+\.\d [kM]B$", said, re.MULTILINE), said
        assert Path(name).stat().st_size


def test_terminal_says_nothing_of_a_device(terminal):
    assert "wrote" not in terminal("simulate", "--until", "0.1", "--benches", "9", "-o", "/dev/null")


def completed(line):
    *arguments, incomplete = line.split(" ")
    return ShellComplete(cli, {}, PROGRAM, COMPLETE_VARIABLE).get_completions(arguments, incomplete)


def test_shell_completes_names_flags_and_files():
    for line, found in {
        "sim": ["simulate"],
        "demo sp": ["spiral", "speed-limit"],
        "demo al": ["all"],
        "figure col": ["collision"],
        "study m": ["min-pitch", "max-speed"],
        "study --lim": ["--limit"],
        "live n": ["near-miss"],
        "contact --pit": ["--pitch"],
        "contact --method e": ["exact", "engine"],
        "simulate --guide ": ["rails", "none"],
        "simulate --contacts re": ["report", "resolve"],
        "render --camera ": ["field", "head"],
    }.items():
        values = [item.value for item in completed(line)]
        assert [value for value in values if value in found] == found, line  # Registries may have more names.
    for line in ("report ru", "render a.npz b", "contact -o t", "positions --scenario d"):
        [item] = completed(line)
        assert (item.type, item.value) == ("file", line.split(" ")[-1])


@pytest.mark.thorough
def test_program_answers_the_shell():
    def answered(shell, **variables):
        environment = os.environ | {COMPLETE_VARIABLE: shell} | variables
        told = subprocess.run([sys.executable, "-m", "pymunk_dragon"], env=environment, capture_output=True, text=True)
        assert (told.returncode, told.stderr) == (0, "")
        return told.stdout

    words = {"COMP_WORDS": "pymunk-dragon demo near", "COMP_CWORD": "2"}
    assert answered("bash_complete", **words) == "plain,near-miss\n"
    assert "complete -o nosort -F" in answered("bash_source")
    assert PROGRAM in answered("zsh_source")
