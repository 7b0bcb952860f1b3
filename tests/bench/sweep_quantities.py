"""A quantity of no work, for `bench_sweep.py`: workers import it by its name."""

from __future__ import annotations

from pymunk_dragon import March


def nothing(march: March) -> dict[str, float]:
    return {"length": march.dragon.head_spacing}
