"""CSV files of points and of speeds: whole ones of many dialects, and damaged ones."""

from __future__ import annotations

from damage import BAD_NUMBERS, damaged, rarely
from harness import Case
from hypothesis import strategies as st

__all__ = ["cases"]

DRAGON = ("--benches", "3", "--head-spacing", "1", "--body-spacing", "1")
CURVES = [
    ("positions", "--curve", "t.csv", *DRAGON, "--times", "0,1", "--json"),
    ("contact", "--curve", "t.csv", *DRAGON, "--until", "2"),
    ("simulate", "--curve", "t.csv", *DRAGON, "--until", "0.05", "-o", "out.npz"),
    ("render", "--curve", "t.csv", *DRAGON, "--until", "0.5", "-o", "out.png", "--size", "64"),
]
SPEEDS = [
    ("positions", "--speed", "t.csv", *DRAGON, "--times", "0,1", "-o", "out.csv"),
    ("contact", "--speed", "t.csv", *DRAGON, "--until", "2", "--json"),
    ("simulate", "--speed", "t.csv", *DRAGON, "--until", "0.02", "--substep", "0.005", "-o", "out.npz"),
]
numbers = st.floats(-40, 40).map(lambda value: f"{value:.3g}")
odd = st.sampled_from(BAD_NUMBERS)


@st.composite
def tables(draw: st.DrawFn, speeds: bool) -> bytes:
    """A table in a dialect of CSV, most of it right."""
    count = draw(st.integers(0, 9))
    first = draw(st.sampled_from(["", "", "x,y", "x,y", "t;v", "1,2,3", "a,1"]))
    rows = [first] if first else []
    separator = draw(st.sampled_from([",", ",", ",", ", ", " ,", ";", "\t"]))
    for i in range(count):
        pair = [f"{5 * i}", f"{draw(st.floats(0.1, 5)):.3g}" if speeds else draw(numbers)]
        if rarely(draw, 40):
            pair[draw(st.integers(0, 1))] = draw(odd)
        rows.append(separator.join(pair))
    ending = draw(st.sampled_from(["\n", "\n", "\n", "\n", "\r\n", "\r", "\n\n", "\x0b", "\u2028"]))
    return ending.join(rows).encode(
        draw(st.sampled_from(["utf-8", "utf-8", "utf-8", "utf-8-sig", "utf-16"])), errors="replace"
    )


@st.composite
def cases(draw: st.DrawFn) -> Case:
    """A command that reads a table."""
    speeds = draw(st.booleans())
    content = draw(tables(speeds))
    if draw(st.booleans()):
        content = draw(damaged(content))
    command = draw(st.sampled_from(SPEEDS if speeds else CURVES))
    return Case(command, {"t.csv": content, "out.npz": b"old"})
