"""Box2D 3 by the bindings pyb2d3, with the number of substeps that its header names."""

from __future__ import annotations

import math
from importlib.metadata import version
from itertools import pairwise

import numpy as np
import pyb2d3

from adapters import DENSITY, DRIVES, Scene
from pymunk_dragon._arrays import Array


class Engine:
    """The dragon in Box2D 3. Its contacts act, but only where benches would overlap."""

    name = f"Box2D 3.1 (pyb2d3 {version('pyb2d3')})"
    settings = "4 substeps"
    substeps = dict.fromkeys(DRIVES, 1 / 60)

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.touched: list[tuple[int, int]] = []
        self.world = pyb2d3.World(gravity=(0, 0))
        self.world.sleeping_enabled = False
        dragon = scene.dragon
        self.benches = []
        for number, ((x, y, angle), (u, v, spin)) in enumerate(scene.start.swapaxes(0, 1).tolist()):
            create = self.world.create_dynamic_body if number else self.world.create_kinematic_body
            body = create(
                position=(x, y),
                rotation=angle,
                linear_velocity=(u, v),
                angular_velocity=spin,
                linear_damping=scene.drag,
                angular_damping=scene.drag,
                user_data=number,
            )
            box = pyb2d3.box(dragon.lengths[number] / 2, dragon.widths[number] / 2)
            body.create_shape(pyb2d3.shape_def(density=DENSITY, enable_contact_events=True), box)
            self.benches.append(body)
        self.anchors = [
            self.world.create_kinematic_body(position=(x, y)) for x, y in scene.anchors[0].tolist()
        ]
        half = (dragon.spacings / 2).tolist()
        for number, (before, body) in enumerate(pairwise(self.benches)):
            ends = {"local_anchor_a": (-half[number], 0), "local_anchor_b": (half[number + 1], 0)}
            self.world.create_revolute_joint(body_a=before, body_b=body, **ends)
            if self.anchors:
                ends = {"local_anchor_a": (0, 0), "local_anchor_b": (-half[number + 1], 0)}
                bodies = {"body_a": self.anchors[number], "body_b": body}
                if scene.rail:
                    self.world.create_distance_joint(length=scene.rail, **bodies, **ends)
                else:
                    self.world.create_revolute_joint(**bodies, **ends)

    def move(self, number: int) -> None:
        x, y, angle = self.scene.head[number].tolist()
        rate = 1 / self.scene.step
        head = self.benches[0]
        here, turned = head.position, head.rotation
        head.linear_velocity = (x - here[0]) * rate, (y - here[1]) * rate
        turn = math.remainder(angle - math.atan2(turned.s, turned.c), 2 * math.pi)
        head.angular_velocity = turn * rate
        for body, (x, y) in zip(self.anchors, self.scene.anchors[number].tolist(), strict=True):
            here = body.position
            body.linear_velocity = (x - here[0]) * rate, (y - here[1]) * rate

    def step(self) -> None:
        self.touched.clear()
        self.world.step(self.scene.step, self.scene.iterations or 4)
        contacts = self.world.get_contact_events()
        if contacts.begin_count:
            for event in contacts.begin_events():
                pair = event.shape_a.body.user_data, event.shape_b.body.user_data
                self.touched.append((min(pair), max(pair)))

    def poses(self) -> Array:
        # Body.angle is an approximation, right to 4e-5 rad.
        rows = []
        for body in self.benches:
            turned = body.rotation
            rows.append((*body.position, math.atan2(turned.s, turned.c)))
        return np.array(rows)
