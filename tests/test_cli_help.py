"""Help of the commands: what it says in a terminal of 80 columns, hints after mistakes, and what a shell completes."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys

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


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help_fits_80_columns_and_has_examples_that_the_command_takes(help_of, command):
    out = help_of(*command.split())
    assert max(map(len, out.splitlines())) <= 80
    examples = examples_of(out)
    assert examples
    for name, *arguments in examples:
        assert name == command or not command
        cli.get_command(None, name).make_context(name, arguments)


@pytest.mark.parametrize("command", ["positions", "contact", "simulate", "render", "figure", "study", "sweep", "live"])
def test_help_has_the_commands_own_options_before_those_of_the_dragon(help_of, command):
    own, _, shared = help_of(command).partition("\nDragon:\n")
    for name in SCENARIO_OPTIONS:
        flag = "  --" + name.replace("_", "-") + " "
        assert flag in shared
        assert flag not in own
    assert "  --lang " in own
    assert "\nCurve and speed:\n" in shared


def test_commands_are_listed_with_whole_sentences(help_of):
    listed = help_of().partition("Commands:\n")[2].partition("\n\n")[0].splitlines()
    assert [line.split()[0] for line in listed] == list(COMMANDS)
    assert all(re.search(r"\w\.$", line) for line in listed)


@pytest.mark.thorough
@pytest.mark.parametrize("command", [name for name in COMMANDS if name != "live"])
def test_examples_of_the_help_run(help_of, call, command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert call("simulate", "--from", "412", "-o", "run.npz")[0] == 0
    for arguments in examples_of(help_of(command)):
        assert call(*arguments)[0] == 0, arguments


# Did you mean


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        (["figure", "spirl"], "spiral"),
        (["study", "minpitch"], "min-pitch"),
        (["demo", "spirall"], "spiral"),
        (["live", "nearmiss"], "near-miss"),
        (["sweep", "--axis", "pitch=0.4,0.5", "--quantity", "contact-tim"], "contact-time"),
        (["sweep", "--axis", "pich=0.4,0.5"], "pitch"),
        (["simulate", "--guide", "rail"], "rails"),
        (["simulate", "--contacts", "reports"], "report"),
        (["contact", "--method", "exat"], "exact"),
        (["render", "--camera", "heads"], "head"),
        (["positions", "--curve", "uturn"], "u-turn"),
        (["simulate", "--pich", "3"], "--pitch"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else None,
)
def test_misspelt_word_gets_the_similar_one(call, arguments, meant, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, err = call(*arguments)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert err.endswith(f": did you mean {meant}?\n")
    assert not list(tmp_path.iterdir())


def test_misspelt_parameter_of_a_scenario_file_gets_the_similar_one(call, tmp_path):
    scenario = tmp_path / "s.toml"
    scenario.write_text("pich = 0.6\n")
    assert "did you mean pitch?" in call("positions", "--scenario", scenario)[2]


def test_option_before_the_command_is_sent_behind_it(call):
    code, _, err = call("--pitch", "0.5", "contact")
    assert code == 2
    assert err == "pymunk-dragon: there is no option --pitch here: options of a command stand after its name\n"


def test_word_that_is_not_similar_gets_no_hint(call):
    assert call("simulate", "--guide", "xyz")[2].endswith("must be one of rails, none\n")
    # Another program's word for --substep, which this command does not have; its letters are in --width.
    assert call("render", "--dt", "0.1")[2].endswith("there is no option --dt\n")


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        ("positions --width 30", "--width 0.3"),
        ("positions --body-spacing 165", "--body-spacing 1.65"),
        ("positions --body-spacing 1650", "--body-spacing 1.65"),
        ("positions --overhang 27.5", "--overhang 0.275"),
        ("positions --curve u-turn --radius 450", "--radius 4.5"),
        ("contact --step 2 --pitch 55", "--pitch 0.55"),
        ("study min-pitch --width 30", "--width 0.3"),
    ],
)
def test_error_after_a_length_in_centimetres_or_millimetres_suggests_metres(call, arguments, meant):
    code, _, err = call(*arguments.split())
    assert code == 2
    assert err.endswith(f"; lengths are in m: did you mean {meant}?\n")


def test_long_pitch_is_allowed_and_noted_on_a_terminal_only(call, terminal):
    large = ["positions", "--pitch", "55", "--times", "0", "--handles", "0"]
    assert call(*large)[::2] == (0, "")
    assert "lengths are in m: did you mean --pitch 0.55?" in terminal(*large)
    assert "lengths are in m" not in terminal("positions", "--pitch", "5", "--times", "0", "--handles", "0")


# Files that are written


@pytest.mark.parametrize(
    ("arguments", "name", "facts"),
    [
        ("positions --times 0 -o p.csv", "p.csv", ""),
        ("contact --from 412 -o c.json", "c.json", ""),
        ("simulate --until 1 --benches 9 -o r.npz", "r.npz", r"\d+ frames, "),
        ("render run.npz --size 64", "run.gif", r"\d+ frames, \d+\.\d s, from t = 79 s, "),
        ("report run.npz -o r.json", "r.json", ""),
        ("figure grid", "grid.png", ""),
        ("study max-speed --benches 9 -o s.json", "s.json", ""),
        ("sweep --axis turns=8,9 --benches 9 -o s.csv", "s.csv", ""),
        ("demo spiral -o l.py", "l.py", ""),
    ],
)
def test_terminal_says_which_file_was_written(terminal, arguments, name, facts, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Run.exact(March(turns=8), [79, 80, 81]).save("run.npz")
    said = terminal(*arguments.split())
    assert re.search(rf"^wrote {re.escape(name)}: {facts}\d+(\.\d)? [kM]B$", said, re.MULTILINE)
    assert (tmp_path / name).stat().st_size


def test_simulation_that_is_not_saved_says_so(terminal):
    assert "the run is not kept: -o RUN.npz saves it" in terminal("simulate", "--until", "1", "--benches", "9")


def test_nothing_is_said_of_a_device(terminal):
    assert "wrote" not in terminal("simulate", "--until", "0.1", "--benches", "9", "-o", "/dev/null")


# Completion


def completions(line):
    *arguments, incomplete = line.split(" ")
    return [
        item.value for item in ShellComplete(cli, {}, PROGRAM, COMPLETE_VARIABLE).get_completions(arguments, incomplete)
    ]


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("sim", ["simulate"]),
        ("demo sp", ["spiral", "speed-limit"]),
        ("demo al", ["all"]),
        ("figure col", ["collision"]),
        ("study m", ["min-pitch", "max-speed"]),
        ("live n", ["near-miss"]),
        ("contact --curve ", ["spiral", "u-turn"]),
        ("contact --method e", ["exact", "engine"]),
        ("simulate --guide ", ["rails", "none"]),
        ("simulate --contacts re", ["report", "resolve"]),
        ("render --camera ", ["field", "head"]),
        ("sweep --quantity engine", ["engine-contact-time", "engine-error"]),
        ("sweep --sampling ", ["sobol", "random"]),
        ("sweep --axis p", ["pitch="]),
        ("sweep --axis l", ["limit="]),
        ("positions --lang ", ["en", "zh"]),
        ("study --min", ["--min-radius"]),
        ("frobnicate --x", []),
    ],
)
def test_shell_completes_names_and_values(line, found):
    assert completions(line) == found


def test_shell_completes_files_by_their_ending(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    for name in ("b.npz", "a.npz", "path.csv", "speed.csv", "dragon.toml", "text.txt", "runs/c.npz"):
        (tmp_path / name).touch()
    for command in ("report ", "render ", "render a.npz ", "figure drift "):
        assert completions(command) == ["a.npz", "b.npz"]
    assert completions("report runs/") == ["runs/c.npz"]
    assert completions("live --replay b") == ["b.npz"]
    assert completions("contact --scenario ") == ["dragon.toml"]
    assert completions("contact --speed s") == ["speed.csv"]
    assert completions("contact --curve p") == ["path.csv"]
    # The shell completes folders, and names of files to write.
    for line in ("report ru", "report nowhere/", "contact -o t"):
        *arguments, incomplete = line.split(" ")
        [item] = ShellComplete(cli, {}, PROGRAM, COMPLETE_VARIABLE).get_completions(arguments, incomplete)
        assert (item.type, item.value) == ("file", incomplete)


def test_program_answers_the_shell():
    def answered(**variables):
        told = subprocess.run(
            [sys.executable, "-m", "pymunk_dragon"], env=os.environ | variables, capture_output=True, text=True
        )
        assert (told.returncode, told.stderr) == (0, "")
        return told.stdout

    words = {"COMP_WORDS": "pymunk-dragon demo near", "COMP_CWORD": "2"}
    assert answered(**{COMPLETE_VARIABLE: "bash_complete"}, **words) == "plain,near-miss\n"
    assert "complete -o nosort -F" in answered(**{COMPLETE_VARIABLE: "zsh_source"}) + answered(
        **{COMPLETE_VARIABLE: "bash_source"}
    )
