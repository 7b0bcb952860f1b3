"""Help of the commands, messages on files, completion in a shell, and answers to bad input."""

import os
import re
import shlex
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete
from conftest import assert_one_line, linux_only

from pymunk_dragon import Dragon, March, Run
from pymunk_dragon.cli import COMMANDS, PROGRAM, cli, command, options, output


@pytest.fixture
def complaint(call):
    """The message of the program on bad input, which is one line; its exit code is 2."""

    def complained(*arguments):
        code, out, err = call(*arguments)
        assert (code, out) == (2, ""), arguments
        assert_one_line(err)
        return err

    return complained


def examples_of(text):
    """The commands in the examples of a help, each as its arguments."""
    return [shlex.split(line)[1:] for line in text.partition("Examples:\n")[2].splitlines()]


def help_of(call, *command):
    """The help of a command, or of the program."""
    code, out, err = call(*command, "--help")
    assert code == 0
    assert err == ""
    return out


def test_help_of_the_program_lists_all_commands_and_has_examples_of_them(call):
    out = help_of(call)
    listed = out.partition("Commands:\n")[2].partition("\n\n")[0].splitlines()
    assert [line.split()[0] for line in listed] == list(COMMANDS)
    assert examples_of(out)
    for name, *arguments in examples_of(out):
        command(name).make_context(name, arguments)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_has_examples_that_the_command_takes(call, name):
    out = help_of(call, name)
    assert examples_of(out)
    for first, *arguments in examples_of(out):
        assert first == name
        command(name).make_context(name, arguments)


@pytest.mark.parametrize(
    "name", [name for name in COMMANDS if name not in ("report", "demo", "publish")]
)
def test_help_has_the_commands_own_options_before_those_of_the_dragon(call, name):
    out = help_of(call, name)
    flags = [f"  --{option.replace('_', '-')} " for option in options.SCENARIO_OPTIONS]
    for flag in flags:
        assert flag in out
    for own in ("--scenario", "--from", "--json"):
        assert out.find(f"  {own} ") < out.index(flags[0])
    assert COMMANDS[name] in " ".join(out.split())


def test_program_without_a_command_shows_its_help_and_version(call):
    code, out, err = call()
    assert (code, out) == (2, "")
    assert "Commands:" in err
    assert call("-V") == call("--version")


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["positions", "contact", "render", "report"])
def test_examples_of_the_help_run(call, late_run, name, here):
    late_run.save("run.npz")
    for arguments in examples_of(call(name, "--help")[1]):
        assert call(*arguments)[0] == 0, arguments


@pytest.mark.thorough
def test_time_left_leaves_out_what_comes_before_the_first_step(monkeypatch):
    now = [0.0]
    bars = []
    made = output.click.progressbar
    monkeypatch.setattr("time.time", lambda: now[0])
    monkeypatch.setattr("click.progressbar", lambda **given: bars.append(made(**given)) or bars[0])
    with output.progress("work") as show:
        for now[0], done in ((90.0, 1.0), (99.0, 10.0)):
            show(done, 100.0)
        assert bars[0].eta == pytest.approx(81.0)


def test_terminal_says_which_file_was_written(terminal, here):
    Run.exact(March(turns=8), [79, 80, 81]).save("run.npz")
    for arguments, name in {
        "render run.npz --size 64": "run.gif",
        "simulate --until 1 --benches 9 -o r.npz": "r.npz",
        "report run.npz -o r.json": "r.json",
        "sweep --axis turns=8,9 --benches 9 -o s.csv": "s.csv",
    }.items():
        said = terminal(*arguments.split())
        assert re.search(rf"^wrote {re.escape(name)}$", said, re.MULTILINE), said
        assert Path(name).stat().st_size
    # Of a device it says nothing.
    assert "wrote" not in terminal(
        "simulate", "--until", "0.1", "--benches", "9", "-o", "/dev/null"
    )


def completed(line):
    *arguments, incomplete = line.split(" ")
    return ShellComplete(cli, {}, PROGRAM, "_PYMUNK_DRAGON_COMPLETE").get_completions(
        arguments, incomplete
    )


def test_shell_completes_names_flags_and_files():
    for line, found in {
        "sim": ["simulate"],
        "demo sp": ["spiral", "speed-limit"],
        "figure col": ["collision"],
        "study m": ["min-pitch", "max-speed"],
        "study --lim": ["--limit"],
        "live n": ["near-miss"],
        "contact --pit": ["--pitch"],
        "contact --method e": ["exact", "engine"],
        "simulate --contacts re": ["report", "resolve"],
    }.items():
        values = [item.value for item in completed(line)]
        assert [value for value in values if value in found] == found, (
            line
        )  # Registries may have more names.
    for line in ("report ru", "render a.npz b", "contact -o t", "positions --scenario d"):
        [item] = completed(line)
        assert (item.type, item.value) == ("file", line.split(" ")[-1])


@pytest.mark.thorough
def test_program_answers_the_shell():
    def answered(shell, **variables):
        environment = os.environ | {"_PYMUNK_DRAGON_COMPLETE": shell} | variables
        told = subprocess.run(
            [sys.executable, "-m", "pymunk_dragon"], env=environment, capture_output=True, text=True
        )
        assert (told.returncode, told.stderr) == (0, "")
        return told.stdout

    words = {"COMP_WORDS": "pymunk-dragon demo near", "COMP_CWORD": "2"}
    assert answered("bash_complete", **words) == "plain,near-miss\n"
    assert "complete -o nosort -F" in answered("bash_source")
    assert PROGRAM in answered("zsh_source")


# Bad input

# Command lines, and words that the message has: the value or name, and what is allowed or was
# meant.
ONE = "sweep --axis pitch=0.5"
SCENARIOS = {
    "pich.toml": "pich = 0.6\n",
    "small.toml": "benches = -1\n",
    "turn.toml": "curve = 'u-turn'\n",
}
BAD_INPUT = {
    "positions --pitch 0.25": "pitch 0.25 width",
    "positions --ratio 1": "--ratio u-turn",
    "positions --curve uturn": "--curve 'uturn' spiral u-turn .csv",
    "positions --speed nowhere.csv": "--speed 'nowhere.csv'",
    "positions --times 0:1": "--times '0:1' 0:300:1",
    "positions --times 0:1e9:0.001": "times",
    "positions --times 443": "443 handle",
    "positions --handles 224": "--handles '224' 223",
    "positions --handles 0 -o r.xlsx": "--handles",
    "positions --scenario /dev/zero": "/dev/zero 4",
    "positions -o f.txt": "-o 'f.txt'",
    "positions --paper --times 3": "--paper --times",
    "simulate --from 2 --until 1": "--until 1.0",
    "simulate --guide rail": "--guide 'rail' rails",
    "contact --from 1e300": "--from 1e+300",
    "contact --method exat": "method exat exact",
    "contact --step 2": "--step grid",
    "demo --lang fr": "--lang 'fr'",
    "render nowhere.npz -o f.gif": "nowhere.npz",
    "render run.npz --pitch 1 -o f.gif": "scenario",
    "render -o f.png --from 5": "--from",
    "render -o f.html --speedup 2": "--speedup",
    "render -o f.html": "a page plays one run",
    "render -o f.gif --exact": "--exact run",
    "render -o f.gif --size big": "--size 'big'",
    "render -o f.gif --camera tail": "--camera 'tail' head",
    "report -o r.html": "RUN.npz",
    "figure spirl -o f.png": "'spirl' spiral",
    "simulat": "'simulat' simulate",
    "simulate --pich 3": "--pich --pitch",
    "positions --scenario pich.toml": "pich pich.toml pitch",
    "positions --scenario small.toml": "benches small.toml -1",
    "positions --curve line": "--scenario stop line",
    "positions --head-spacing 0.5": "--overhang 0.275 0.25",
    "contact --curve u-turn": "--until time",
    "contact --curve u-turn --method grid": "--until time",
    "simulate --scenario turn.toml": "--until time",
    "contact --until 1 --from=-1e9": "--from -100000",
    "render --benches 5 --until 1 --contacts -o f.png": "--contacts march",
    "render --curve u-turn --from 1e300 -o f.gif": "--from 1e+300 1e+09",
    "figure drift": "RUN.npz simulate",
    "report nowhere.npz": "RUN.npz 'nowhere.npz'",
    "demo spirall": "'spirall' spiral",
    "live nearmiss": "'nearmiss' near-miss",
    "study minpitch": "'minpitch' min-pitch",
    "study min-pitch --radius many": "radius many",
    "study min-pitch --pitch 0.5": "pitch",
    "study min-pitch -o answer.gif": "-o answer.gif .json .png .svg .pdf",
    "study max-speed --limit 21": "limit 21",
    "sweep": "Missing --axis",
    **{f"sweep --axis pitch={bad}": f"'pitch={bad}'" for bad in ("wide", "0.6:0.5:0.1", "", "nan")},
    "sweep --axis pitch=-2,-1": "'pitch=-2'",
    "sweep --axis pich=0.4,0.5": "pitch",
    "sweep --axis benches=2.5": "'benches=2.5'",
    "sweep --axis pitch=5,6 --axis width=0.1,0.2 --axis turns=8,9 -o map.png": "-o 'map.png'",
    **{
        f"{ONE} --quantity {name}": f"--quantity '{name}'"
        for name in ("math:none", "math:pi", "failing:f", "broken:f", "f:")
    },
    f"{ONE} --quantity contact-tim": "contact-time",
    f"{ONE} --workers 0": "--workers 0",
    f"{ONE} --scheduler localhost": "--scheduler 'localhost'",
    **{f"{ONE} -o {name}": f"-o '{name}'" for name in ("map.txt", "folder.csv")},
    f"{ONE} --resume": "--resume",
}


@linux_only
def test_bad_input_is_named_in_one_line_and_nothing_is_written(complaint, here, monkeypatch):
    monkeypatch.setattr(sys, "path", list(sys.path))
    for name, content in {**SCENARIOS, "failing.py": "1 / 0\n", "broken.py": "def f(:\n"}.items():
        Path(name).write_text(content)
    Path("folder.csv").mkdir()
    before = sorted(os.listdir())
    for line, words in BAD_INPUT.items():
        said = complaint(*line.split())
        missing = [word for word in words.split() if word not in said]
        assert (missing, "None" in said) == ([], False), (line, said)
    for name in options.SCENARIO_OPTIONS:
        for value in ("nan", "-inf", "1e300", "abc", ""):
            said = complaint("positions", "--" + name.replace("_", "-"), value)
            assert name in said.replace("-", "_")
    assert sorted(os.listdir()) == before


def test_output_that_cannot_be_written_is_refused_before_the_work(complaint, here, monkeypatch):
    monkeypatch.setattr(March, "at", None)  # Any work would fail on it.
    for name, ending in (
        ("positions", "csv"),
        ("contact", "json"),
        ("simulate", "npz"),
        ("render", "gif"),
    ):
        assert "nowhere" in complaint(name, "-o", f"nowhere/x.{ending}")
        assert ".docx" in complaint(name, "-o", "x.docx")
        Path(f"folder.{ending}").mkdir()
        assert "folder" in complaint(name, "-o", f"folder.{ending}")
    assert not [path for path in here.rglob("*") if path.is_file()]


def test_missing_library_is_named_and_by_studies_before_any_work(complaint, here, monkeypatch):
    Run.exact(March(Dragon(benches=16), turns=8), [79, 82]).save("run.npz")
    Path("path.csv").write_text("0,0\n50,0\n100,9\n200,0\n400,9\n")
    monkeypatch.setattr("imageio_ffmpeg._io.get_ffmpeg_exe", lambda: "nothing")
    # Libraries that are absent, commands that need them, and the extra that the message names.
    for library, line, extra in (
        ("xlsxwriter", "contact -o c.xlsx", "report"),
        ("xlsxwriter", "positions -o p.xlsx", "report"),
        ("jinja2", "report run.npz -o r.html", "report"),
        ("scipy", "positions --curve path.csv", "curves"),
        ("scipy", "study u-turn", "studies"),
        ("matplotlib", "study min-pitch -o answer.png", "figures"),
        ("matplotlib", f"{ONE} -o map.png", "figures"),
        ("matplotlib", "figure gap run.npz", "figures"),
        ("distributed", f"{ONE} --scheduler tcp://a:1", "cluster"),
        ("no library", "render -o film.mp4", "mp4"),
    ):
        with monkeypatch.context() as without:
            without.setitem(sys.modules, library, None)
            if line.startswith("study"):
                module = import_module(f"pymunk_dragon.studies.{line.split()[1].replace('-', '_')}")
                without.setattr(module, "March", None)  # Any work would fail on it.
            assert f"pymunk-dragon[{extra}]" in complaint(*line.split()), line
    assert sorted(os.listdir()) == ["path.csv", "run.npz"]
