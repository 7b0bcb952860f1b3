"""The films' colours, their counterparts on a dark ground, and both as variables of the page's style."""

from __future__ import annotations

from dataclasses import asdict

from pymunk_dragon.drawing import Palette

__all__ = ["DARK", "LIGHT", "variables"]

LIGHT = Palette()
# Bright benches with dark outlines have the same contrast on a dark ground as dark outlines on a bright one.
DARK = Palette(
    background="#171b22",
    curve="#4b5361",
    head="#f5b02e",
    body="#7ea9cf",
    tail="#3dbfae",
    contact="#ff6b7d",
    ink="#0e1217",
    motion="#a6e69a",
    force="#e3d0ff",
    grid="#cfd6e2",
)


def variables() -> str:
    """Style that names each colour `--canvas-...`, by the scheme that the reader prefers."""
    light, dark = (
        "".join(f" --canvas-{name}: {colour};" for name, colour in asdict(palette).items()) for palette in (LIGHT, DARK)
    )
    return f":root {{{light} }}\n@media (prefers-color-scheme: dark) {{ :root {{{dark} }} }}\n"
