"""No command line and no file makes the program fail in a way that it should not.

`make fuzz CASES=5000` runs that many cases of each kind, different ones each time, and lists the
kinds with their numbers of cases and findings; the suite runs a few, always the same.
"""

import io
import json
import os
import re
import signal
import warnings
from collections import Counter
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from pymunk_dragon import Arc, Composite, Dragon, Line, March, Run, simulate
from pymunk_dragon.cli import status
from pymunk_dragon.drawing.figures import FIGURES

# Number of cases that were run of each kind.
counted = Counter()
CASES = int(os.environ.get("FUZZ_CASES", "0"))
# s of processor time, after which a case is ended.
MAX_SECONDS = 60.0

# What stands where a number should: no number, none of its range, or one in a way of writing that
# Python knows as well.
BAD_NUMBERS = [
    "nan",
    "inf",
    "-inf",
    "1e309",
    "1e-320",
    "0",
    "-0.0",
    "-1",
    "-1e9",
    "9" * 400,
    "0x10",
    "1_0",
    "",
    " ",
]
BAD_NUMBERS += [
    "abc",
    "None",
    "true",
    "1,5",
    "1:2",
    "½",
    "٣",
    "1e",
    "--",
    "-",
    "é",
    "\n",
    "a\nb",
    "\x1b[31m",
    "%s",
]
BAD_NUMBERS += ["{}", "$HOME", "*", "~", "../x", "'", '"', "\\", "\udcff", "1" * 5000]
# Names of files to read or to write, of which some are there and some cannot be.
FILES = {
    "s.toml": b"benches = 6\npitch = 0.6\n",
    "bad.toml": b"benches = 'six'\n",
    "speed.csv": b"0,1\n5,2\n",
}
FILES |= {"t.csv": b"x,y\n0,0\n15,1\n30,0\n45,-8\n", "junk.npz": b"PK\x03\x04 no archive"}
FILES |= {"old.json": b"{}", "old.gif": b"GIF", "old.npz": b"old"}
NAMES = [
    *FILES,
    "folder",
    "folder/new.json",
    "none/new.json",
    ".",
    "..",
    "../up.json",
    "new",
    "x" * 300 + ".json",
]
NAMES += ["é.json", "a b.csv", "a\nb.json", "-.json", ".json", "/dev/null", "\udcff.npz"]
NAMES += [
    f"new.{ending}" for ending in ("json", "csv", "npz", "gif", "svg", "html", "md", "xlsx", "mp4")
]
# Endings of the files that commands write without -o.
DEFAULT_ENDINGS = {"figure": ".png", "render": ".gif", "report": ".html"}
# Right command lines that take little work. Every value is replaced now and then.
COMMANDS = [
    "positions --benches 5 --times 0,1:3:1 --handles 0:3:1",
    "positions --benches 5 --times 0,1 -o new.csv",
    "contact --until 5 --benches 5",
    "contact --until 5 --method grid --step 0.5 --benches 5 -o old.json",
    "simulate --until 0.1 --substep 0.01 --iterations 20 --frame-interval 0.05 --benches 4"
    " -o new.npz",
    "simulate --until 0.1 --from -0.1 --guide none --contacts report --iterations 60 --benches 4",
    "render run.npz --size 64x80 --fps 2 --speedup 5 --camera head --span 3 --hold 1 -o old.gif",
    "render exact.npz run.npz --size 64 --velocities --grid --contacts --title T --caption C"
    " --lang zh -o new.png",
    "render --until 1 --size 64 --fps 2 --exact --benches 4 -o new.gif",
    "render run.npz -o new.html",
    "render run.npz run.npz --exact -o new.png --size 64x64",
    "report run.npz -o old.json",
    "report run.npz -o folder/new.md --json",
    "report exact.npz -o new.html",
    "figure drift run.npz -o new.png",
    *(f"figure {name} --benches 5 --turns 3 -o new.png" for name in FIGURES),
    "study max-speed --limit 1.5 --benches 5 -o new.json",
    "study min-pitch --benches 5",
    "sweep --axis pitch=0.5,0.6 --quantity max-speed --workers 1 --benches 5 -o new.csv",
    "sweep --axis pitch=0.5:0.6:0.1 --workers 1 --benches 5 -o new.png",
    "demo none --lang zh --save folder",
]
EXTRAS = [
    *(
        "--head-spacing 2",
        "--body-spacing 1",
        "--overhang 0.1",
        "--width 0.2",
        "--curve u-turn",
        "--curve t.csv",
    ),
    *(
        "--pitch 0.6",
        "--turns 8",
        "--radius 5",
        "--ratio 2",
        "--speed 2",
        "--speed speed.csv",
        "--scenario s.toml",
    ),
    *("--json", "--json", "--help", "--none", "-x", "--", "extra", "--json=1", "--ben=3", "-o"),
]
# Values at the ends of their ranges and beyond, but none that asks for hours of work.
LENGTHS = "0.001 0.30001 0.5 1 100 1000 1e-300 1e300"
EXTREMES = {
    **dict.fromkeys(
        ["--head-spacing", "--body-spacing", "--overhang", "--width", "--pitch", "--turns"], LENGTHS
    ),
    **dict.fromkeys(["--speed", "--speedup", "--substep"], "1e-6 1e-5 0.1 20 1e6 1e-300 1e300"),
    "--times": "1e300 -1e5 0:1:1e-4 0:1e-300:1e-303 0:1e300:1e297 442.59 1e16 0,0",
    "--handles": "0:2:0.5 0,0,0 4:0:1 1e300 0:1e300:1e300",
    "--from": "-1e5 442.59 1e300 1e-300 -1e300",
    "--until": "1e-8 1e-300 5e-324 -1e300",
    "--step": "1e-300 1e-12 1e300",
    "--size": "63 1024 64x1024 1e3 64x64x64 2049",
    "--axis": "pitch= none=1 pitch width=0.1,0.2,x benches=2:4:1 benches=2.5 = pitch=0.5,0.5",
    "--quantity": "contact-time min-pitch none math:pi none:none",
}
# Whole scenarios and tables, and commands that read them.
CURVES = [
    '{kind = "line", start = [0, 0], stop = [40, 0]}',
    '{kind = "arc", radius = 9, sweep = 3, centre = [1, 2], begin_angle = 0.5}',
    '{kind = "spiral", pitch = 0.6, rotation = 1, outward = false}',
    '{kind = "u-turn", pitch = 1.7, radius = 4.5, ratio = 2}',
    '{kind = "reversed", curve = {kind = "section", begin = 1, end = 30,'
    ' curve = {kind = "line", stop = [40, 0]}}}',
    '{kind = "composite", pieces = [{kind = "line", stop = [9, 0]},'
    ' {kind = "line", start = [9, 0], stop = [30, 0]}]}',
    '{kind = "sampled", points = [[0, 0], [10, 0], [20, 4], [30, 5]]}',
    '"t.csv"',
]
SCENARIOS = [
    *(f"benches = 3\nhead_spacing = 1\nbody_spacing = 1.5\ncurve = {curve}\n" for curve in CURVES),
    "benches = 4\noverhang = [0.1, 0.2]\nwidth = 0.2\npitch = 0.6\nturns = 9\n"
    "speed = [[0, 1], [5, 2]]\n",
    "benches = 5\nbody_spacing = [1.5, 2]\ncurve = 'u-turn'\nradius = 5\nratio = 2\n"
    "start_s = -9\nspeed = 2\n",
]
TABLES = ["x,y\n0,0\n10,0\n20,4\n30,5\n", "0,1\n5,2\n10,1.5\n"]
TABLES += ["t;v\r\n0;1\r\n5;2\r\n", "\ufeff1 , 2\n\n3 ,4\n5, 6\n8,1"]
ODD_TOML = [
    "nan",
    "-inf",
    "1979-05-27",
    "true",
    "''",
    '"spiral"',
    "[]",
    "{}",
    "[[]]",
    "1e400",
    "-1",
    "0",
    "9" * 400,
]
ODD_TOML += ["[nan, 1]", '"\\u001b[31m"', "{kind = 3}", "[1" + ", 1" * 300 + "]", '"t.csv"']
ODD_JSON = [
    "null",
    "true",
    "[]",
    "{}",
    '""',
    '"\\u001b[2J"',
    '"/dev/zero"',
    "NaN",
    "-1",
    "0",
    "1e308",
    "1" + "0" * 400,
]
FROM_SCENARIO = [
    *("positions --times 0,1 --json --scenario s.toml", "contact --until 1 --scenario s.toml"),
    "simulate --until 0.03 -o old.npz --scenario s.toml",
    "render --until 0.1 --size 64 -o new.png --scenario s.toml",
]
FROM_TABLE = [
    f"{command} --{option} t.csv --benches 3 --head-spacing 1 --body-spacing 1"
    for option in ("curve", "speed")
    for command in (
        "positions --times 0,1 --json",
        "contact --until 2",
        "simulate --until 0.05 -o old.npz",
    )
]
FROM_RUN = [command for command in COMMANDS if " run.npz" in command and "exact.npz" not in command]


@cache
def whole_runs():
    """Run files of the engine up to a contact, and of the exact model on a curve of pieces."""
    bend = Composite(
        [Line(stop=(30, 0)), Arc(centre=(30, 3), radius=3, begin_angle=-np.pi / 2, sweep=3)]
    )
    contact = March(Dragon(benches=10), turns=2.6, speed=2.0)
    runs = {
        "run.npz": simulate(contact, until=contact.end, frame_interval=0.5),
        "exact.npz": Run.exact(March(Dragon(benches=4), bend, speed=2), [0.0, 1.5]),
    }
    with TemporaryDirectory() as folder:
        for name, run in runs.items():
            run.save(Path(folder) / name)
        return {name: (Path(folder) / name).read_bytes() for name in runs}


@st.composite
def command_lines(draw):
    """A right command line with words changed, left out, added and out of order."""
    words = draw(st.sampled_from(COMMANDS)).split()
    at = 2 if words[0] in ("figure", "study") else 1
    for extra in draw(st.lists(st.sampled_from(EXTRAS), max_size=2)):
        words[at:at] = extra.split()
    for _ in range(draw(st.sampled_from([0, 0, 1, 1, 2, 3]))):
        at = draw(st.integers(1, len(words) - 1))
        odd = [*EXTREMES.get(words[at - 1], "").split() * 5, *NAMES, *BAD_NUMBERS]
        match draw(st.integers(0, 9)):
            case 0:
                words = draw(st.permutations(words))
            case 1:
                # The option that bounds the work is the last but one.
                del words[at : at + 1]
                words += ["--benches", "5"]
            case _:
                words[at] = draw(st.sampled_from(odd))
    return words, FILES | whole_runs()


@st.composite
def damaged(draw, content):
    """The bytes of a file with one to three faults."""
    for _ in range(draw(st.integers(1, 3))):
        begin = draw(st.integers(0, len(content)))
        end = min(len(content), begin + draw(st.integers(0, 40)))
        new = [
            b"",
            content[begin:end] * 30,
            b"\0",
            b"\xff" * 8,
            b"\n",
            b",",
            b"[" * 50,
            b"\r\r\n",
            b"=",
        ]
        part = draw(st.sampled_from(new) | st.binary(max_size=20))
        content = (
            content[:begin] + part + draw(st.sampled_from([content[begin:], content[end:], b""]))
        )
    return content


@st.composite
def text_with_odd_numbers(draw, text, odd):
    """A text with one to three of its numbers replaced, or damaged."""
    for _ in range(draw(st.integers(0, 3))):
        found = draw(st.sampled_from([*re.finditer(r"-?[\d.]+(?:e-?\d+)?|$", text)]))
        text = text[: found.start()] + draw(st.sampled_from(odd)) + text[found.end() :]
    content = text.encode(errors="replace")
    return draw(damaged(content)) if draw(st.integers(0, 3)) == 1 else content


@st.composite
def file_cases(draw, commands, texts, odd, name):
    """A command that reads a changed file."""
    content = draw(text_with_odd_numbers(draw(st.sampled_from(texts)), odd))
    return draw(st.sampled_from(commands)).split(), FILES | {name: content}


@st.composite
def run_files(draw):
    """A command that reads a run with damaged bytes, other notes or other arrays."""
    content = draw(st.sampled_from([*whole_runs().values()]))
    if draw(st.integers(0, 4)) == 1:
        content = draw(damaged(content))
    else:
        arrays = dict(np.load(io.BytesIO(content)))
        notes = draw(text_with_odd_numbers(arrays.pop("notes").tobytes().decode(), ODD_JSON))
        name = draw(st.sampled_from(sorted(arrays)))
        array, factor = arrays.pop(name), draw(st.floats())
        kind = draw(st.sampled_from(["f4", "i8", "c16", "U5", "?", "M8[s]", ">f8"]))
        with np.errstate(all="ignore"):
            others = [
                array,
                array,
                array[:1],
                array[:0],
                array.ravel(),
                np.repeat(array, 3, axis=0),
                array[::-1],
                None,
            ]
            other = draw(
                st.sampled_from([*others, array * factor, array + factor, array.astype(kind)])
            )
        buffer = io.BytesIO()
        arrays |= {} if other is None else {name: other}
        np.savez_compressed(buffer, notes=np.frombuffer(notes, dtype=np.uint8), **arrays)
        content = buffer.getvalue()
    return draw(st.sampled_from(FROM_RUN)).split(), FILES | {"run.npz": content}


KINDS = {
    "command-lines": command_lines(),
    "scenario-files": file_cases(FROM_SCENARIO, SCENARIOS, ODD_TOML, "s.toml"),
    "csv-files": file_cases(FROM_TABLE, TABLES, BAD_NUMBERS, "t.csv"),
    "run-files": run_files(),
}


def outcome(arguments):
    """Exit code, stdout and stderr of a command line; other exceptions and warnings are errors."""

    def stop(*_):
        raise RuntimeError(f"more than {MAX_SECONDS} s of processor time")

    out = io.TextIOWrapper(io.BytesIO(), "utf-8")
    err = io.TextIOWrapper(io.BytesIO(), "utf-8", "backslashreplace")
    signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, MAX_SECONDS)
    try:
        with redirect_stdout(out), redirect_stderr(err), warnings.catch_warnings(action="error"):
            # As in a process of its own, in which Python hides the deprecations of libraries.
            warnings.filterwarnings("ignore", category=DeprecationWarning)
            code = status(arguments)
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    out.flush()
    err.flush()
    return code, out.buffer.getvalue(), err.buffer.getvalue().decode()


def contents(base, folder):
    """The content of each file below `base`, by its name seen from `folder`."""
    return {
        os.path.relpath(path, folder): path.read_bytes()
        for path in base.rglob("*")
        if path.is_file()
    }


def check(arguments, files):
    """Run a command line in a folder with files, and check what it says and leaves."""
    with TemporaryDirectory() as base:
        # Names such as "../x" stay within the temporary folder.
        folder = Path(base) / "one" / "two"
        (folder / "folder").mkdir(parents=True)
        for name, content in files.items():
            (folder / name).write_bytes(content)
        before = contents(Path(base), folder)
        with chdir(folder):
            code, out, err = outcome(arguments)
        after = contents(Path(base), folder)
    assert code in (0, 1, 2)
    assert len(err.splitlines()) == (code != 0), err
    assert not re.search("Traceback|Error:|Warning:", err)
    assert code != 2 or not out
    if (
        code == 0
        and "--json" in arguments
        and not {"-h", "--help", "--version", "-o"} & {*arguments}
    ):
        assert isinstance(json.loads(out), dict)
    assert not before.keys() - after.keys(), "lost files"
    touched = {name for name, content in after.items() if before.get(name) != content}
    # A sweep writes its table even if points failed.
    if code == 0 or (code == 1 and "sweep" in arguments):
        named = "\n".join(arguments)
        # Without -o, the file has the name of the run or of the figure, and a film without a run
        # that of a march.
        stems = ["march", *(Path(word).stem for word in arguments)]
        for command in DEFAULT_ENDINGS.keys() & {*arguments}:
            named += "\n".join(f"{stem}{DEFAULT_ENDINGS[command]}" for stem in stems)
        touched = {
            name for name in touched if name not in named and os.path.dirname(name) not in arguments
        }
    assert not touched, "files were changed or left behind"


@contextmanager
def listed(kind):
    """Print the numbers of cases and of findings of a kind at the end."""
    findings = 0
    try:
        yield
    except BaseException as error:
        # Several ones that differ come as a group.
        findings = len(getattr(error, "exceptions", [error]))
        raise
    finally:
        print(f"\n{kind}: {counted[kind]} cases, {findings} findings")


@pytest.mark.parametrize("kind", KINDS)
def test_no_case_fails_in_a_way_that_it_should_not(kind):
    @hypothesis.settings(
        max_examples=CASES or 12,
        derandomize=not CASES,
        database=None,
        deadline=None,
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(KINDS[kind])
    def run(case):
        counted[kind] += 1
        check(*case)

    with listed(kind):
        run()
