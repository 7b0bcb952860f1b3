"""Help of the commands: what it says in a terminal of 80 columns, hints after mistakes, and what a shell completes."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete

from pymunk_dragon.cli import COMMANDS, COMPLETE_VARIABLE, PROGRAM, cli
from pymunk_dragon.cli.options import SCENARIO_OPTIONS
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run


def examples_of(text):
    """The commands in the examples of a help, each as its arguments."""
    lines = text.partition("Examples:\n")[2].splitlines()
    assert all(line.startswith(f"  {PROGRAM}") for line in lines)
    return [shlex.split(line)[1:] for line in lines]


@pytest.fixture
def help_of(call, monkeypatch):
    """The help of a command in a terminal of 80 columns."""
    monkeypatch.setenv("COLUMNS", "80")

    def shown(*command):
        code, out, err = call(*command, "--help")
        assert (code, err) == (0, "")
        return out

    return shown


def test_help_fits_80_columns_and_has_examples_that_the_command_takes(help_of):
    for command in ("", *COMMANDS):
        out = help_of(*command.split())
        assert max(map(len, out.splitlines())) <= 80
        examples = examples_of(out)
        assert examples
        for name, *arguments in examples:
            assert name == command or not command
            cli.get_command(None, name).make_context(name, arguments)
        if command not in ("", "report", "demo"):
            # The command's own options stand before those of the dragon.
            own, _, shared = out.partition("\nDragon:\n")
            flags = [f"  --{name.replace('_', '-')} " for name in SCENARIO_OPTIONS]
            assert [flag in own for flag in flags] == [False] * len(flags)
            assert [flag in shared for flag in flags] == [True] * len(flags)
            assert "  --lang " in own
    listed = help_of().partition("Commands:\n")[2].partition("\n\n")[0].splitlines()
    assert [line.split()[0] for line in listed] == list(COMMANDS)


def test_program_without_a_command_shows_its_help_and_version(call):
    code, out, err = call()
    assert (code, out) == (2, "")
    assert "Commands:" in err
    assert call("-V") == call("--version")


@pytest.mark.thorough
@pytest.mark.parametrize("command", ["positions", "contact", "render", "report"])
def test_examples_of_the_help_run(help_of, call, late_run, command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    late_run.save("run.npz")
    for arguments in examples_of(help_of(command)):
        assert call(*arguments)[0] == 0, arguments


# Did you mean

# Mistakes, and the end of the message.
MEANT = {
    "figure spirl": "spiral",
    "study minpitch": "min-pitch",
    "demo spirall": "spiral",
    "live nearmiss": "near-miss",
    "sweep --axis pitch=0.4,0.5 --quantity contact-tim": "contact-time",
    "sweep --axis pich=0.4,0.5": "pitch",
    "simulate --guide rail": "rails",
    "simulate --contacts reports": "report",
    "contact --method exat": "exact",
    "render --camera heads": "head",
    "positions --curve uturn": "u-turn",
    "positions --scenario s.toml": "pitch",
    "simulate --pich 3": "--pitch",
    "simulat": "simulate",
    "positions --width 30": "--width 0.3",
    "positions --body-spacing 165": "--body-spacing 1.65",
    "positions --body-spacing 1650": "--body-spacing 1.65",
    "positions --curve u-turn --radius 450": "--radius 4.5",
    "contact --step 2 --pitch 55": "--pitch 0.55",
}
OTHERS = {
    # Options of a command stand after its name.
    "--pitch 0.5 contact": "--pitch",
    # Other programs' words for an option, which a command may have or not.
    "simulate --dt 0.1": "use --substep",
    "simulate --to 3": "use --until",
    "render --dt 0.1": "--dt",
    "simulate --guide xyz": "rails, none",
}


def test_mistake_gets_the_word_or_the_length_that_was_meant(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("s.toml").write_text("pich = 0.6\n")
    for command, words in (MEANT | OTHERS).items():
        code, out, err = call(*command.split())
        assert (code, out, err.count("\n")) == (2, "", 1), command
        assert words in err, command
        assert err.endswith(f"did you mean {words}?\n") == (command in MEANT), err
    assert os.listdir(tmp_path) == ["s.toml"]


def test_long_pitch_is_allowed_and_noted_on_a_terminal_only(call, terminal):
    large = ["positions", "--pitch", "55", "--times", "0", "--handles", "0"]
    assert call(*large)[::2] == (0, "")
    assert "did you mean --pitch 0.55?" in terminal(*large)


# Files that are written

# What a terminal says of the file beside its size.
WRITTEN = {
    "render run.npz --size 64": ("run.gif", r"\d+ frames, \d+\.\d s, from t = 79 s, "),
    "positions --times 0 -o p.csv": ("p.csv", ""),
    "contact --from 412 -o c.json": ("c.json", ""),
    "simulate --until 1 --benches 9 -o r.npz": ("r.npz", r"\d+ frames, "),
    "report run.npz -o r.json": ("r.json", ""),
    "figure grid": ("grid.png", ""),
    "study max-speed --benches 9 -o s.json": ("s.json", ""),
    "sweep --axis turns=8,9 --benches 9 -o s.csv": ("s.csv", ""),
    "demo spiral -o l.py": ("l.py", ""),
}


@pytest.mark.parametrize(
    "commands",
    [
        pytest.param([*WRITTEN][:1], id="render"),
        pytest.param([*WRITTEN][1:], id="others", marks=pytest.mark.thorough),
    ],
)
def test_terminal_says_which_file_was_written(terminal, commands, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Run.exact(March(turns=8), [79, 80, 81]).save("run.npz")
    for arguments in commands:
        name, facts = WRITTEN[arguments]
        said = terminal(*arguments.split())
        assert re.search(rf"^wrote {re.escape(name)}: {facts}\d+(\.\d)? [kM]B$", said, re.MULTILINE), said
        assert Path(name).stat().st_size


def test_terminal_says_that_a_simulation_is_not_saved_and_nothing_of_a_device(terminal):
    small = ["simulate", "--until", "0.1", "--benches", "9"]
    assert "-o RUN.npz" in terminal(*small)
    said = terminal(*small, "-o", "/dev/null")
    assert "-o RUN.npz" not in said
    assert "wrote" not in said


# Completion


def completed(line):
    *arguments, incomplete = line.split(" ")
    return ShellComplete(cli, {}, PROGRAM, COMPLETE_VARIABLE).get_completions(arguments, incomplete)


def test_shell_completes_names_values_and_files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("runs").mkdir()
    files = ("b.npz", "a.npz", "path.csv", "speed.csv", "dragon.toml", "text.txt", "runs/c.npz")
    for name in files:
        Path(name).touch()
    for line, found in {
        "sim": ["simulate"],
        "demo sp": ["spiral", "speed-limit"],
        "demo al": ["all"],
        "figure col": ["collision"],
        "study m": ["min-pitch", "max-speed"],
        "study --min": ["--min-radius"],
        "live n": ["near-miss"],
        "contact --curve ": ["spiral", "u-turn", "path.csv", "speed.csv"],
        "contact --method e": ["exact", "engine"],
        "simulate --guide ": ["rails", "none"],
        "simulate --contacts re": ["report", "resolve"],
        "render --camera ": ["field", "head"],
        "sweep --quantity engine": ["engine-contact-time", "engine-error"],
        "sweep --sampling ": ["sobol", "random"],
        "sweep --axis p": ["pitch="],
        "positions --lang ": ["en", "zh"],
        "report ": ["a.npz", "b.npz"],
        "render a.npz ": ["a.npz", "b.npz"],
        "figure drift ": ["a.npz", "b.npz"],
        "report runs/": ["runs/c.npz"],
        "live --replay b": ["b.npz"],
        "contact --scenario ": ["dragon.toml"],
        "contact --speed s": ["speed.csv"],
    }.items():
        values = [item.value for item in completed(line)]
        # Registries may have more names; of files only those are listed that fit.
        assert [value for value in values if value in (*found, *files)] == found, line
    # The shell completes folders, and names of files to write.
    for line in ("report ru", "report nowhere/", "contact -o t"):
        [item] = completed(line)
        assert (item.type, item.value) == ("file", line.split(" ")[-1])


@pytest.mark.thorough
def test_program_answers_the_shell():
    def answered(shell, **variables):
        environment = os.environ | {COMPLETE_VARIABLE: shell} | variables
        command = [sys.executable, "-m", "pymunk_dragon"]
        told = subprocess.run(command, env=environment, capture_output=True, text=True)
        assert (told.returncode, told.stderr) == (0, "")
        return told.stdout

    words = {"COMP_WORDS": "pymunk-dragon demo near", "COMP_CWORD": "2"}
    assert answered("bash_complete", **words) == "plain,near-miss\n"
    assert "complete -o nosort -F" in answered("bash_source")
    assert PROGRAM in answered("zsh_source")
