"""Scenario files (TOML): whole ones of every curve, ones with wrong values, and damaged ones."""

from __future__ import annotations

import json
from typing import Any

from damage import BAD_NUMBERS, damaged, rarely
from harness import Case
from hypothesis import strategies as st

__all__ = ["cases"]

COMMANDS = [
    ("positions", "--scenario", "s.toml", "--times", "0,1", "--json"),
    ("positions", "--scenario", "s.toml", "--benches", "4", "--times", "0", "-o", "out.csv"),
    ("contact", "--scenario", "s.toml", "--until", "1"),
    ("simulate", "--scenario", "s.toml", "--until", "0.03", "-o", "out.npz"),
    ("render", "--scenario", "s.toml", "--until", "0.1", "-o", "out.png", "--size", "64"),
    ("study", "min-pitch", "--scenario", "s.toml", "--radius", "-1"),
]
# TOML knows values that no parameter takes.
ODD = [
    "nan",
    "-inf",
    "1979-05-27",
    "07:32:00",
    "true",
    "''",
    '"spiral"',
    "[]",
    "{}",
    "[[]]",
    "0x10",
    "1e400",
    "-1",
    "0",
]
ODD += ["9" * 400, "[nan, 1]", "[[0, 1], [0, 1]]", '"\\u001b[31m"', "{kind = 3}", "[1" + ", 1" * 300 + "]", '"t.csv"']
numbers = st.floats(-30, 30).map(lambda value: round(value, 3))
points = st.tuples(numbers, numbers).map(list)


def text(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{name} = {text(part)}" for name, part in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(text, value)) + "]"
    return value.odd if isinstance(value, Odd) else json.dumps(value)


class Odd:
    """A value that is TOML already."""

    def __init__(self, odd: str) -> None:
        self.odd = odd


odd = st.sampled_from(ODD).map(Odd)
lengths = st.floats(0.5, 30).map(lambda value: round(value, 3))
# Parameters of each kind of curve that is made of numbers; those that it needs come first.
NEEDED: dict[str, dict[str, st.SearchStrategy]] = {
    "line": {"stop": points},
    "arc": {"radius": lengths, "sweep": numbers},
    "spiral": {},
    "u-turn": {},
    "sampled": {"points": st.lists(points, min_size=3, max_size=8)},
}
OTHERS: dict[str, dict[str, st.SearchStrategy]] = {
    "line": {"start": points},
    "arc": {"centre": points, "begin_angle": numbers},
    "spiral": {"pitch": lengths, "rotation": numbers, "mirrored": st.booleans(), "outward": st.booleans()},
    "u-turn": {"pitch": lengths, "radius": lengths, "ratio": lengths},
    "sampled": {},
}


@st.composite
def tables(draw: st.DrawFn, depth: int = 0) -> Any:
    """A table of a curve, which may have other curves in it."""
    kind = draw(st.sampled_from([*NEEDED, *["reversed", "section", "composite"] * (depth < 4)]))
    table: dict[str, Any] = {"kind": kind}
    match kind:
        case "composite" if draw(st.booleans()):
            # A line and another that goes on from its end.
            length = draw(lengths)
            line, other = ({"kind": "line", "start": [x, 0], "stop": [y, 0]} for x, y in ((0, length), (length, 99)))
            table["pieces"] = [line, other]
        case "composite":
            table["pieces"] = [draw(tables(depth + 1)) for _ in range(draw(st.integers(0, 3)))]
        case "reversed" | "section":
            table["curve"] = draw(tables(depth + 1))
        case _:
            table |= {name: draw(value) for name, value in NEEDED[kind].items()}
            table |= {name: draw(value) for name, value in OTHERS[kind].items() if draw(st.booleans())}
    if kind == "section":
        table["begin"], table["end"] = sorted(draw(st.tuples(numbers, numbers)))
    return draw(perhaps_odd(table))


@st.composite
def perhaps_odd(draw: st.DrawFn, table: dict[str, Any]) -> dict[str, Any]:
    """A table with one odd value, or one left out, now and then."""
    if table and rarely(draw, 10):
        name = draw(st.sampled_from(sorted(table)))
        if draw(st.booleans()):
            return table | {name: draw(odd)}
        return {other: value for other, value in table.items() if other != name}
    return table


flat = {
    "benches": st.integers(2, 8),
    "head_spacing": st.floats(0.6, 4).map(lambda value: round(value, 3)),
    "body_spacing": st.one_of(st.floats(0.6, 2), st.lists(st.floats(0.6, 2), min_size=1, max_size=7)),
    "overhang": st.one_of(st.floats(0.01, 0.3), st.lists(st.floats(0.01, 0.3), min_size=2, max_size=8)),
    "width": st.floats(0.05, 0.4),
    "curve": st.one_of(st.sampled_from(["spiral", "u-turn", "sampled", "t.csv"]), tables(), tables()),
    "pitch": st.floats(0.2, 2),
    "turns": st.floats(1, 30),
    "radius": lengths,
    "ratio": lengths,
    "points": st.lists(points, min_size=3, max_size=8),
    "start_s": st.floats(-100, 20),
    "speed": st.one_of(
        st.floats(0.1, 5), st.lists(st.tuples(st.integers(0, 9), st.floats(0.1, 3)).map(list), max_size=4)
    ),
}


@st.composite
def scenarios(draw: st.DrawFn) -> bytes:
    """A scenario as text, with a few values."""
    names = draw(st.lists(st.sampled_from(sorted(flat)), max_size=4, unique=True))
    values = draw(perhaps_odd({"benches": 5} | {name: draw(flat[name]) for name in names}))
    if rarely(draw, 10):
        values[draw(st.sampled_from(["kind", "pich", "dragon", "kurve"]))] = draw(odd)
    lines = [f"{name} = {text(value)}" for name, value in values.items()]
    if rarely(draw, 10):
        lines.append(
            draw(st.sampled_from(["[curve]", "[[points]]", "# é", "benches = 6", "= 3", draw(st.text(max_size=9))]))
        )
    return "\n".join(lines).encode(errors="replace")


@st.composite
def cases(draw: st.DrawFn) -> Case:
    """A command that reads a scenario."""
    content = draw(scenarios())
    if draw(st.booleans()):
        content = draw(damaged(content))
    elif rarely(draw, 20):
        content = draw(st.sampled_from(BAD_NUMBERS)).encode(errors="replace") * draw(st.integers(1, 2000))
    table = b"0,0\n10,0\n20,4\n30,5\n"
    return Case(draw(st.sampled_from(COMMANDS)), {"s.toml": content, "t.csv": table, "out.csv": b"old"})
