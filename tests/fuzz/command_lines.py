"""Command lines: right ones that take little work, and ones with words changed, left out, added and out of order."""

from __future__ import annotations

from damage import BAD_NUMBERS, rarely
from harness import Case
from hypothesis import strategies as st
from run_files import whole_runs

from pymunk_dragon.drawing.figures import FIGURES
from pymunk_dragon.studies import STUDIES

__all__ = ["cases"]

FILES = {
    "s.toml": b"benches = 6\npitch = 0.6\n",
    "line.toml": b'benches = 3\ncurve = {kind = "line", stop = [40, 0]}\n',
    "bad.toml": b"benches = 'six'\n",
    "path.csv": b"x,y\n0,0\n15,1\n30,0\n45,-8\n",
    "speed.csv": b"0,1\n5,2\n",
    "junk.npz": b"PK\x03\x04 no archive",
    "old.json": b"{}",
    "old.npz": b"old",
    "old.gif": b"GIF",
    "old.png": b"PNG",
    "old.csv": b"old",
    "old.html": b"old",
}
ENDINGS = [
    "json",
    "csv",
    "npz",
    "gif",
    "png",
    "svg",
    "html",
    "md",
    "xlsx",
    "apng",
    "webp",
    "toml",
    "mp4",
    "txt",
    "PNG",
    "",
]
# Names of files to read or to write, of which some are there and some cannot be.
NAMES = [
    *FILES,
    "run.npz",
    "exact.npz",
    "folder",
    "folder/new.json",
    "none/new.json",
    "",
    ".",
    "..",
    "../up.json",
    "new",
]
NAMES += ["x" * 300 + ".json", "é.json", "a b.csv", "a\nb.json", "-.json", "-", ".json", "/dev/null", "\udcff.npz"]


def one_of(*words: str) -> st.SearchStrategy[str]:
    """One of some words."""
    return st.sampled_from(words)


def number(low: float, high: float) -> st.SearchStrategy[str]:
    """A number as text, with few digits."""
    return st.floats(low, high).map(lambda value: f"{value:.3g}")


def whole(low: int, high: int) -> st.SearchStrategy[str]:
    """A whole number as text."""
    return st.integers(low, high).map(str)


def listed(part: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """A list of numbers as text."""
    span = st.tuples(number(-5, 20), number(20, 60), number(5, 9)).map(":".join)
    return st.lists(st.one_of(part, span), min_size=1, max_size=4).map(",".join)


DRAGON = {
    "--benches": whole(2, 9),
    "--head-spacing": number(0.7, 3),
    "--body-spacing": number(0.7, 2),
    "--overhang": number(0.01, 0.3),
    "--width": number(0.05, 0.4),
    "--curve": one_of("spiral", "u-turn", "path.csv", "sampled"),
    "--pitch": number(0.3, 2),
    "--turns": number(2, 20),
    "--radius": number(2, 9),
    "--ratio": number(0.5, 3),
    "--speed": st.one_of(number(0.1, 5), one_of("speed.csv")),
    "--scenario": one_of("s.toml", "line.toml", "bad.toml", "none.toml"),
}
FLAG = st.none()


def to_file(*endings: str) -> st.SearchStrategy[str]:
    """A file to write: of one of `endings` as a rule, new, there already, or in a folder."""
    ending = st.sampled_from([*endings * 10, *ENDINGS])
    return st.builds(lambda name, ending: f"{name}.{ending}", one_of("new", "old", "folder/new"), ending)


# What each command writes.
WRITTEN = {
    "positions": to_file("csv", "json", "xlsx"),
    "contact": to_file("json", "xlsx"),
    "simulate": to_file("npz"),
    "render": to_file("gif", "png", "html", "apng", "webp"),
    "report": to_file("json", "csv", "md", "html", "xlsx"),
    "figure": to_file("png", "svg"),
    "study": to_file("json"),
    "sweep": to_file("csv", "parquet"),
    "demo": to_file("py", "ipynb"),
}
SHOWN = dict.fromkeys(("--velocities", "--grid", "--contacts", "--normals", "--impulses", "--exact"), FLAG)
# For each command: its words, options that bound the work and are there always, and options that may be there.
Options = dict[str, st.SearchStrategy]
COMMANDS: dict[str, tuple[list[st.SearchStrategy], Options, Options]] = {
    "positions": ([], {}, DRAGON | {"--times": listed(number(-50, 100)), "--handles": listed(whole(0, 4))}),
    "contact": (
        [],
        {"--benches": whole(2, 9), "--until": number(1, 9)},
        DRAGON
        | {"--method": one_of("exact", "exact", "grid"), "--from": number(-9, 5), "--step": number(0.2, 2)}
        | {"--tolerance": number(1e-9, 0.1)},
    ),
    "simulate": (
        [],
        {"--benches": whole(2, 9), "--until": number(0.01, 0.2)},
        DRAGON
        | {"--guide": one_of("rails", "none"), "--contacts": one_of("stop", "report", "resolve"), "--fine": FLAG}
        | {"--substep": number(0.001, 0.05), "--iterations": whole(1, 60), "--frame-interval": number(0.01, 1)}
        | {"--from": number(-0.1, 0)},
    ),
    "render": (
        [one_of("run.npz", "exact.npz", "junk.npz")],
        {
            "-o": WRITTEN["render"],
            "--size": one_of("64", "64x80", "100"),
            "--fps": whole(1, 4),
            "--workers": one_of("0"),
        },
        SHOWN
        | {"--from": number(-1, 1), "--until": number(0, 2), "--speedup": number(0.5, 20), "--hold": number(0, 3)}
        | {"--camera": one_of("field", "head"), "--span": number(1, 20), "--title": one_of("T", "é\n龍", "x" * 90)}
        | {"--caption": one_of("C", "a\nb"), "--font": one_of("none.ttf", "old.png")}
        | {"--lang": one_of("en", "zh", "de"), "--legend": FLAG, "--no-legend": FLAG},
    ),
    "render of a march": (
        [],
        {"-o": WRITTEN["render"], "--size": one_of("64"), "--fps": whole(1, 4), "--workers": one_of("0")}
        | {"--benches": whole(2, 9), "--until": number(0.1, 2)},
        DRAGON | SHOWN | {"--speedup": number(0.5, 20), "--camera": one_of("field", "head"), "--from": number(-1, 1)},
    ),
    "report": ([one_of("run.npz", "exact.npz", "junk.npz", "old.json")], {"-o": WRITTEN["report"]}, {}),
    "figure": (
        [st.sampled_from([*FIGURES, "drift", "impulses", "none"]), one_of("run.npz", "exact.npz")],
        {"-o": WRITTEN["figure"]},
        {},
    ),
    "figure of a march": (
        [st.sampled_from([*FIGURES, "none"])],
        {"-o": WRITTEN["figure"], "--benches": whole(2, 9), "--turns": number(2, 4)},
        DRAGON,
    ),
    "study": (
        # The u-turn takes seconds whatever its options are; most of its lines are refused.
        [st.sampled_from([*(name for name in STUDIES if name != "u-turn"), "none", ""])],
        {"--benches": whole(3, 9)},
        DRAGON | {"--limit": number(1.1, 3), "--fastest": number(1, 2), "-o": WRITTEN["study"]},
    ),
    "sweep": (
        [],
        {
            "--benches": whole(2, 9),
            "--workers": one_of("1", "1", "2", "0"),
            "--axis": st.one_of(
                st.tuples(one_of("pitch=", "turns=", "head-spacing=", "none="), listed(number(0.7, 2))).map("".join),
                one_of("pitch=0.5:0.6", "pitch", "width=0.1,0.2,x", "benches=2:4:1", "benches=2.5", "=", ""),
            ),
        },
        {
            "--quantity": one_of("contact-time", "nearest-gap", "max-speed", "none", "math:pi", "none:none"),
            "--samples": whole(0, 5),
            "--seed": whole(-1, 9),
            "--sampling": one_of("sobol", "random", "none"),
            "--refine": whole(-1, 5),
            "--timeout": number(0, 9),
            "--resume": FLAG,
        },
    ),
    "demo": (
        [st.sampled_from(["", "none", "Spiral", "../spiral"])],
        {},
        {
            "--lang": one_of("en", "zh", "de", "EN"),
            "--save": one_of("folder", "none/none"),
            "--pause": FLAG,
            "-o": WRITTEN["demo"],
        },
    ),
}
# Values at the ends of their ranges and beyond, but none that asks for hours of work.
EXTREMES = {
    "--head-spacing": ["0.001", "100", "1e-300", "1e300"],
    "--body-spacing": ["0.001", "100", "1e-300", "1e300"],
    "--overhang": ["0.001", "0.5", "100", "1e-300"],
    "--width": ["0.001", "1", "100", "1e-300"],
    "--pitch": ["0.001", "0.30001", "1000", "1e300"],
    "--turns": ["1e-300", "0.001", "1", "1000", "1e300"],
    "--radius": ["0.1", "100", "1e300"],
    "--ratio": ["0.02", "50", "1e-300"],
    "--speed": ["1e-6", "20", "1e-300", "1e300"],
    "--times": ["1e300", "-1e5", "-99999", "0:1:1e-4", "0:1e-300:1e-303", "0:1e300:1e297", "442.59", "1e16", "0,0"],
    "--handles": ["0:2:0.5", "0,0,0", "4:0:1", "1e300", "0:1e300:1e300"],
    "--from": ["-1e5", "442.59", "1e300", "1e-300", "-1e300"],
    "--until": ["1e-8", "1e-300", "5e-324", "-1e300"],
    "--step": ["1e-300", "1e-12", "1e300"],
    "--tolerance": ["5e-324", "1e-300", "1e-17", "1e300"],
    "--substep": ["1e-5", "0.1", "1e-300", "1e300"],
    "--iterations": ["1000", "1" + "0" * 30],
    "--frame-interval": ["1e-300", "1e-12", "1e9", "1e300"],
    "--speedup": ["1e6", "1e-6", "1e-300"],
    "--hold": ["60", "1e-300"],
    "--span": ["0.1", "1e5", "1e300"],
    "--size": ["63", "1024", "64x1024", "1024x64", "1e3", "64x64x64", "2049"],
    "--fps": ["50", "51", "60", "1" + "0" * 30],
    "--limit": ["1", "1.0000001", "20", "1e9", "1e-300"],
    "--fastest": ["1", "1e-300", "1e300"],
    "--title": ["x" * 500, "x" * 501, "\x1b[31m", "\u202e", " " * 99],
}


@st.composite
def cases(draw: st.DrawFn) -> Case:
    """A command line, in a folder with files for it."""
    name = draw(st.sampled_from([*COMMANDS, "positions", "contact", "simulate", "render", "positions", "contact"]))
    words, always, perhaps = COMMANDS[name]
    rare = draw(st.sampled_from(["-o", "--json", "--json"]))
    parts: list[list[str]] = [[draw(word)] for word in words if not rarely(draw, 20)]
    chosen = draw(st.lists(st.sampled_from(sorted(perhaps)), max_size=3, unique=True)) if perhaps else []
    # The last of two values wins: what bounds the work comes last.
    for option in [*chosen, *always]:
        value = draw((always if option in always else perhaps)[option])
        parts.append([option] if value is None else [option, value])
    if rare == "--json":
        parts.insert(0, ["--json"])
    elif not any(part[0] == "-o" for part in parts):
        parts.append(["-o", draw(WRITTEN[name.split()[0]])])
    for _ in range(draw(st.sampled_from([0, 0, 0, 1, 1, 2, 3]))):
        draw(changed(parts))
    arguments = [word for part in [[name.split()[0]], *parts] for word in part]
    if rarely(draw, 50):
        arguments = draw(st.permutations(arguments))
    if rarely(draw, 50):
        arguments.insert(0, draw(st.sampled_from(["--version", "--help", "-h", "--none", "", "-", "--", "é"])))
    return Case(tuple(arguments), FILES | {f"{kind}.npz": whole_runs()[made] for kind, made in RUNS.items()})


RUNS = {"run": "contact", "exact": "exact"}


@st.composite
def changed(draw: st.DrawFn, parts: list[list[str]]) -> None:
    """Change a command line in one place."""
    if not parts:
        return
    part = parts[draw(st.integers(0, len(parts) - 1))]
    match draw(st.integers(0, 9)):
        case 0 | 1:
            part[-1] = draw(st.sampled_from(BAD_NUMBERS))
        case 2 | 3:
            part[-1] = draw(st.sampled_from(EXTREMES.get(part[0], BAD_NUMBERS)))
        case 4 | 5:
            part[-1] = draw(st.sampled_from(NAMES))
        case 6:
            parts.insert(0, list(part))
        case 7:
            parts.insert(
                0, [draw(st.sampled_from(["--help", "--none", "-x", "--", "extra", "--json=1", "--ben=3", "-o"]))]
            )
        case 8:
            # An option without its value, or a value without its option.
            if len(part) > 1:
                del part[draw(st.integers(0, 1))]
            else:
                parts.remove(part)
        case 9:
            part[0] = draw(st.sampled_from(sorted(DRAGON)))
