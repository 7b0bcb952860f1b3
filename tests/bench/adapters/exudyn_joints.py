"""Exudyn, which solves the joints and the motion of a step together, until both converge."""

from __future__ import annotations

from typing import ClassVar

import exudyn
import exudyn.itemInterface as items  # noqa: N813  # A module with a name of its own kind.
import numpy as np

from adapters import Scene
from pymunk_dragon._arrays import Array


class Engine:
    """The dragon in Exudyn; the head is left out, and its rear hole is a point of the ground.

    Contacts are not modelled. There is no pinned drive, as its joints would hold each bench twice.
    """

    name = f"Exudyn {exudyn.__version__}"
    settings = "generalised alpha, index 3; no contacts"
    substeps: ClassVar = dict.fromkeys(("head", "rails"), 1 / 60)

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.touched: list[tuple[int, int]] = []
        self.half = scene.dragon.spacings / 2
        self.container = exudyn.SystemContainer()
        self.system = self.container.AddSystem()
        self.hinge, before = self._ground(self._rear_hole(0))
        self.anchors = []
        for number in range(1, scene.dragon.benches):
            front, rear = self._bench(number)
            self.system.AddObject(items.ObjectJointRevolute2D(markerNumbers=[before, front]))
            before = rear
            if scene.rail:
                anchor, marker = self._ground(scene.anchors[0, number - 1])
                self.anchors.append(anchor)
                ends = {"markerNumbers": [marker, rear], "distance": scene.rail}
                self.system.AddObject(items.ObjectConnectorDistance(**ends))
        self.system.Assemble()
        self.given = exudyn.SimulationSettings()
        self.given.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
        self.given.timeIntegration.endTime = scene.step * scene.steps
        self.given.timeIntegration.numberOfSteps = scene.steps
        self.given.timeIntegration.verboseMode = 0
        self.given.solution.file.write = False
        self.solver = exudyn.MainSolverImplicitSecondOrder()
        self.solver.InitializeSolver(self.system, self.given)
        self.solver.it.currentStepSize = scene.step

    def _ground(self, place: Array) -> tuple[int, int]:
        """A point of the ground, and its marker."""
        point = self.system.AddObject(items.ObjectGround(referencePosition=[*place, 0]))
        return point, self.system.AddMarker(items.MarkerBodyPosition(bodyNumber=point))

    def _bench(self, number: int) -> tuple[int, int]:
        """Add a bench with its drag; returns the markers of its two holes."""
        system = self.system
        mass = self.scene.dragon.masses[number]
        moment = self.scene.dragon.moments[number]
        pose, velocity = self.scene.start[:, number]
        motion = items.NodeRigidBody2D(referenceCoordinates=pose, initialVelocities=velocity)
        node = system.AddNode(motion)
        body = system.AddObject(items.ObjectRigidBody2D(mass=mass, inertia=moment, nodeNumber=node))
        if self.scene.drag:
            ground = system.AddNode(items.NodePointGround())
            fixed = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
            for coordinate, inertia in enumerate((mass, mass, moment)):
                moved = items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate)
                ends = {"markerNumbers": [fixed, system.AddMarker(moved)]}
                damper = items.ObjectConnectorCoordinateSpringDamper
                system.AddObject(damper(damping=inertia * self.scene.drag, **ends))
        front, rear = (
            system.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[along, 0, 0]))
            for along in (self.half[number], -self.half[number])
        )
        return front, rear

    def _rear_hole(self, number: int) -> Array:
        """The rear hole of the head at a number of its places."""
        x, y, angle = self.scene.head[number]
        hole: Array = (x, y) - self.half[0] * np.array([np.cos(angle), np.sin(angle)])
        return hole

    def move(self, number: int) -> None:
        self.number = number
        places = [self._rear_hole(number), *self.scene.anchors[number]]
        for point, place in zip([self.hinge, *self.anchors], places, strict=True):
            self.system.SetObjectParameter(point, "referencePosition", [*place, 0])

    def step(self) -> None:
        self.solver.InitializeStep(self.system, self.given)
        if not self.solver.DiscontinuousIteration(self.system, self.given):
            raise RuntimeError("Exudyn's step does not converge")
        self.solver.FinishStep(self.system, self.given)

    def poses(self) -> Array:
        moved: Array = self.system.systemData.GetODE2Coordinates()
        poses: Array = self.scene.start[0].copy()
        poses[0] = self.scene.head[self.number]
        poses[1:] += moved.reshape(-1, 3)
        return poses
