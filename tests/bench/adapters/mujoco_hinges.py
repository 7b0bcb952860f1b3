"""MuJoCo, whose coordinates are the angles in the hinges, so that these cannot open."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from adapters import DENSITY, DRIVES, Scene
from pymunk_dragon._arrays import Array

# kg and kg m^2: inertia that is added to the head's coordinates, so that nothing but the driver
# moves it.
ARMATURE = 1e7

# m: half of the height of the benches.
HALF_HEIGHT = 0.5

# Impedance of a rail or a pin, at no error and at a large one: as hard as MuJoCo allows.
IMPEDANCE = 0.9999, 0.9999, 0.001, 0.5, 2


class Engine:
    """The dragon in MuJoCo. Its contacts act, but only where benches overlap."""

    name = f"MuJoCo {mujoco.__version__}"
    settings = "implicitfast, Newton"
    substeps = dict.fromkeys(DRIVES, 1 / 60)

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.touched: list[tuple[int, int]] = []
        self.known: set[tuple[int, int]] = set()
        self.model = self._spec().compile()
        self.data = mujoco.MjData(self.model)
        spins = scene.start[1, :, 2]
        self.data.qvel[:] = [*scene.start[1, 0], *np.diff(spins)]
        mujoco.mj_forward(self.model, self.data)

    def _spec(self) -> Any:
        """The model, whose coordinates are 0 at the start."""
        scene = self.scene
        spec = mujoco.MjSpec()
        spec.option.gravity = 0, 0, 0
        spec.option.timestep = scene.step
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        half = scene.dragon.spacings / 2
        body, before = spec.worldbody, 0.0
        for number, (x, y, angle) in enumerate(scene.start[0].tolist()):
            turn = angle - before
            # From the rear hole of the bench before to the centre, in its directions.
            arm = -half[number] * np.array([math.cos(turn), math.sin(turn)])
            place = (arm - (half[number - 1], 0)) if number else (x, y)
            quaternion = math.cos(turn / 2), 0, 0, math.sin(turn / 2)
            body = body.add_body(name=f"bench{number}", pos=(*place, 0), quat=quaternion)
            if number:
                body.add_joint(axis=(0, 0, 1), pos=(half[number], 0, 0))
            else:
                self._add_head(body, angle)
            sides = scene.dragon.lengths[number] / 2, scene.dragon.widths[number] / 2, HALF_HEIGHT
            box = mujoco.mjtGeom.mjGEOM_BOX
            density = DENSITY / (2 * HALF_HEIGHT)
            body.add_geom(type=box, size=sides, density=density, condim=1)
            body.add_site(name=f"hole{number}", pos=(-half[number], 0, 0))
            before = angle
        for number, (x, y) in enumerate(scene.anchors[0].tolist(), start=1):
            anchor = spec.worldbody.add_body(name=f"anchor{number}", pos=(x, y, 0), mocap=True)
            anchor.add_site(name=f"anchor{number}")
            self._hold(spec, f"hole{number}", f"anchor{number}")
        return spec

    def _add_head(self, body: Any, angle: float) -> None:
        """Add the coordinates of the head: x, y and its turn."""
        slide = mujoco.mjtJoint.mjJNT_SLIDE
        for turn in (angle, angle - math.pi / 2):
            axis = math.cos(turn), -math.sin(turn), 0
            body.add_joint(type=slide, axis=axis, armature=ARMATURE)
        body.add_joint(axis=(0, 0, 1), armature=ARMATURE)

    def _hold(self, spec: Any, hole: str, anchor: str) -> None:
        """Keep a hole at its anchor, or at the distance of a rail from it."""
        # As stiff as the manual allows: two steps, critically damped.
        stiff: dict[str, Any] = {"solref": (2 * self.scene.step, 1), "solimp": IMPEDANCE}
        if self.scene.rail:
            tendon = spec.add_tendon(name=f"rail of {hole}")
            tendon.wrap_site(hole)
            tendon.wrap_site(anchor)
            kind = mujoco.mjtEq.mjEQ_TENDON
            spec.add_equality(type=kind, name1=tendon.name, **stiff)
        else:
            kind, site = mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtObj.mjOBJ_SITE
            ends: dict[str, Any] = {"objtype": site, "name1": hole, "name2": anchor}
            spec.add_equality(type=kind, **ends, **stiff)

    def move(self, number: int) -> None:
        # Anchors have no velocity in MuJoCo. A rail is evaluated where the step begins; a pin would
        # lag even more.
        place = number - 1 if self.scene.rail else number
        self.data.mocap_pos[:, :2] = self.scene.anchors[place]
        self.target = self.scene.head[number] - self.scene.start[0, 0]

    def step(self) -> None:
        data, rate = self.data, 1 / self.scene.step
        mujoco.mj_step1(self.model, data)
        if self.scene.drag:
            mujoco.mj_mulM(self.model, data, data.qfrc_applied, data.qvel)
            data.qfrc_applied *= -self.scene.drag
        needed = (self.target - data.qpos[:3]) * rate - data.qvel[:3]
        data.qfrc_applied[:3] = ARMATURE * rate * needed
        mujoco.mj_step2(self.model, data)
        touching = data.contact.geom[data.contact.dist < 0]
        pairs = {(int(min(pair)), int(max(pair))) for pair in touching}
        self.touched = sorted(pairs - self.known)
        self.known = pairs

    def poses(self) -> Array:
        # A step leaves the places of the bodies as they were before it.
        mujoco.mj_kinematics(self.model, self.data)
        directions = self.data.xmat[1 : self.scene.dragon.benches + 1]
        angles = np.arctan2(directions[:, 3], directions[:, 0])
        return np.column_stack([self.data.xpos[1 : len(angles) + 1, :2], angles])
