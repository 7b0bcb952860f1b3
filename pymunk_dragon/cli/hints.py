"""Hints at what was probably meant: an option of another name, and a length in another unit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import click

# Words for options in other programs, and the options here.
OTHER_WORDS = {
    "--dt": "--substep",
    "--timestep": "--substep",
    "--to": "--until",
    "--duration": "--until",
    "--end": "--until",
    "--start": "--from",
    "--out": "--output",
    "--language": "--lang",
}
# m: usual lengths of a dragon and its curve. The pitch is between those of the contest, 0.55 and 1.7 m.
USUAL = {"head_spacing": 2.86, "body_spacing": 1.65, "overhang": 0.275, "width": 0.3, "pitch": 1.0, "radius": 4.5}
# How many times the usual length a number in cm or mm is, at least: the geometric means of 1 and 100, and 100 and 1000.
CENTIMETRES, MILLIMETRES = 10.0, 316.0


def option_hint(error: click.NoSuchOption) -> str:
    """Message about an option that does not exist: the one that was probably meant."""
    flags = (
        []
        if error.ctx is None
        else [flag for option in error.ctx.command.get_params(error.ctx) for flag in option.opts]
    )
    same = OTHER_WORDS.get(error.option_name)
    if same in flags:
        return f"there is no option {error.option_name}: use {same}"
    if error.ctx is not None and isinstance(error.ctx.command, click.Group):
        return f"there is no option {error.option_name} here: options of a command stand after its name"
    similar = f": did you mean {error.possibilities[0]}?" if error.possibilities and same is None else ""
    return f"there is no option {error.option_name}{similar}"


def unit_hint(chosen: Mapping[str, Any]) -> str:
    """Hint at lengths among the options of a scenario that are probably not in m; empty if there are none."""
    meant = []
    for name, usual in USUAL.items():
        length = chosen.get(name)
        if isinstance(length, float) and length >= CENTIMETRES * usual:
            metres = length / (1000 if length >= MILLIMETRES * usual else 100)
            meant.append(f"--{name.replace('_', '-')} {metres:.6g}")
    return f"lengths are in m: did you mean {' '.join(meant)}?" if meant else ""
