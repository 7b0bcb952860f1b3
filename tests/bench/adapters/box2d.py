"""Box2D 2.3 by its old bindings, with the numbers of iterations that its manual names."""

from __future__ import annotations

from itertools import pairwise

import Box2D
import numpy as np

from adapters import DENSITY, DRIVES, Scene
from pymunk_dragon._arrays import Array


class Engine(Box2D.b2ContactListener):  # type: ignore[misc]  # Box2D has no types.
    """The dragon in Box2D 2.3; it listens to contacts, and switches them off."""

    name = f"Box2D {Box2D.__version__}"
    settings = "8 and 3 iterations"
    substeps = dict.fromkeys(DRIVES, 1 / 60)

    def __init__(self, scene: Scene) -> None:
        super().__init__()
        self.scene = scene
        self.touched: list[tuple[int, int]] = []
        self.world = Box2D.b2World(gravity=(0, 0), doSleep=False, contactListener=self)
        dragon = scene.dragon
        self.benches = []
        for number, ((x, y, angle), (u, v, spin)) in enumerate(scene.start.swapaxes(0, 1).tolist()):
            create = self.world.CreateDynamicBody if number else self.world.CreateKinematicBody
            motion = {"linearVelocity": (u, v), "angularVelocity": spin}
            drag = {"linearDamping": scene.drag, "angularDamping": scene.drag}
            body = create(position=(x, y), angle=angle, userData=number, **motion, **drag)
            sides = dragon.lengths[number] / 2, dragon.widths[number] / 2
            body.CreatePolygonFixture(box=sides, density=DENSITY)
            self.benches.append(body)
        self.anchors = [
            self.world.CreateKinematicBody(position=place) for place in scene.anchors[0].tolist()
        ]
        half = (dragon.spacings / 2).tolist()
        for number, (before, body) in enumerate(pairwise(self.benches)):
            ends = {"localAnchorA": (-half[number], 0), "localAnchorB": (half[number + 1], 0)}
            self.world.CreateRevoluteJoint(bodyA=before, bodyB=body, **ends)
            if self.anchors:
                ends = {"localAnchorA": (0, 0), "localAnchorB": (-half[number + 1], 0)}
                bodies = {"bodyA": self.anchors[number], "bodyB": body}
                if scene.rail:
                    self.world.CreateDistanceJoint(length=scene.rail, **bodies, **ends)
                else:
                    self.world.CreateRevoluteJoint(**bodies, **ends)

    def BeginContact(self, contact: Box2D.b2Contact) -> None:  # noqa: N802  # Box2D's name.
        first, second = contact.fixtureA.body.userData, contact.fixtureB.body.userData
        self.touched.append((min(first, second), max(first, second)))

    def PreSolve(self, contact: Box2D.b2Contact, old: object) -> None:  # noqa: N802  # Box2D's name.
        contact.enabled = False

    def move(self, number: int) -> None:
        x, y, angle = self.scene.head[number].tolist()
        rate = 1 / self.scene.step
        head = self.benches[0]
        head.linearVelocity = (x - head.position[0]) * rate, (y - head.position[1]) * rate
        head.angularVelocity = rate * (angle - head.angle)
        for body, (x, y) in zip(self.anchors, self.scene.anchors[number].tolist(), strict=True):
            here = body.position
            body.linearVelocity = (x - here[0]) * rate, (y - here[1]) * rate

    def step(self) -> None:
        self.touched.clear()
        self.world.Step(self.scene.step, 8, 3)

    def poses(self) -> Array:
        return np.array([(*body.position, body.angle) for body in self.benches])
