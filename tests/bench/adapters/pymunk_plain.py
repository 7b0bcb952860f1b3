"""Pymunk with the plain driver: its own step and defaults, without this package."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pymunk

from adapters import DENSITY, DRIVES, Scene
from pymunk_dragon._arrays import Array

# 1/s: drag on rails, without which the correction of errors makes the chain oscillate.
RAIL_DRAG = 11.5


class Engine:
    """The dragon in Pymunk."""

    name = f"Pymunk {pymunk.version}, plain driver"
    settings = "10 iterations; drag on rails"
    substeps = dict.fromkeys(DRIVES, 1 / 60)

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.touched: list[tuple[int, int]] = []
        self.space = pymunk.Space()
        drag = RAIL_DRAG if scene.rail else scene.drag
        self.space.damping = math.exp(-drag)
        self.space.on_collision(begin=self._begin)
        dragon = scene.dragon
        self.benches = [pymunk.Body(body_type=pymunk.Body.KINEMATIC)]
        self.benches += [pymunk.Body() for _ in dragon.lengths[1:]]
        self.anchors = [
            pymunk.Body(body_type=pymunk.Body.KINEMATIC) for _ in range(scene.anchors.shape[1])
        ]
        self.numbers: dict[pymunk.Shape, int] = {}
        for number, body in enumerate(self.benches):
            x, y, body.angle = scene.start[0, number].tolist()
            body.position = x, y
            u, v, body.angular_velocity = scene.start[1, number].tolist()
            body.velocity = u, v
            shape = pymunk.Poly.create_box(body, (dragon.lengths[number], dragon.widths[number]))
            shape.density = DENSITY
            self.numbers[shape] = number
            self.space.add(body, shape)
        for body, anchor in zip(self.anchors, scene.anchors[0].tolist(), strict=True):
            body.position = anchor
        half = (dragon.spacings / 2).tolist()
        for number, (before, body) in enumerate(pairwise(self.benches)):
            rear = -half[number + 1], 0
            hinge = pymunk.PivotJoint(before, body, (-half[number], 0), (half[number + 1], 0))
            hinge.collide_bodies = False
            self.space.add(hinge)
            if self.anchors:
                anchor = self.anchors[number]
                joint = pymunk.PinJoint if scene.rail else pymunk.PivotJoint
                self.space.add(anchor, joint(body, anchor, rear, (0, 0)))

    def _begin(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        first, second = (self.numbers[shape] for shape in arbiter.shapes)
        self.touched.append((min(first, second), max(first, second)))
        arbiter.process_collision = False

    def move(self, number: int) -> None:
        x, y, angle = self.scene.head[number].tolist()
        rate = 1 / self.scene.step
        head = self.benches[0]
        head.velocity = ((x, y) - head.position) * rate
        head.angular_velocity = (angle - head.angle) * rate
        for body, place in zip(self.anchors, self.scene.anchors[number].tolist(), strict=True):
            body.velocity = (place - body.position) * rate

    def step(self) -> None:
        self.touched.clear()
        self.space.step(self.scene.step)

    def poses(self) -> Array:
        return np.array([(*body.position, body.angle) for body in self.benches])
