"""Pymunk as this package drives it, at its default settings."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pymunk

from adapters import Scene
from pymunk_dragon import EngineSettings, March, World
from pymunk_dragon._arrays import Array


class Engine:
    """The dragon in a `World`."""

    name = f"Pymunk {pymunk.version}, this package"
    settings = "10 iterations; 20 head only"
    substeps: ClassVar = {"head": 1 / 40, "rails": 1 / 50}

    def __init__(self, scene: Scene) -> None:
        self.touched: list[tuple[int, int]] = []
        march = March(scene.dragon)
        times = scene.begin + scene.step * np.arange(scene.steps + 1)
        self.heads = march.at(times, handles=2)
        guide = "rails" if scene.rail else "none"
        changes = {"iterations": scene.iterations} if scene.iterations else {}
        span = {"start": times[0], "until": times[-1]}
        settings = EngineSettings(contacts="report", substep=scene.step, **changes)
        self.world = World(march, guide, settings, **span)
        self.numbers: dict[pymunk.Shape, int] = {}
        self.numbers.update((shape, number) for number, shape in enumerate(self.world.shapes))
        self.world.space.on_collision(begin=self._begin)

    def _begin(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        first, second = (self.numbers[shape] for shape in arbiter.shapes)
        self.touched.append((min(first, second), max(first, second)))
        arbiter.process_collision = False

    def move(self, number: int) -> None:
        self.world.prepare(self.heads, number)

    def step(self) -> None:
        self.touched.clear()
        self.world.space.step(self.world.substep)

    def poses(self) -> Array:
        self.world.read()
        return self.world.poses
