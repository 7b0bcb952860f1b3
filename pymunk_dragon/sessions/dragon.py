"""The dragon, played live beside its exact model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pymunk

from pymunk_dragon._arguments import Array, word
from pymunk_dragon.drawing.debug_draw import DrawRecorder
from pymunk_dragon.drawing.scene import hole_diameter
from pymunk_dragon.errors import UnreachableError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import position_errors
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.model.settings import MAX_STRIDE, EngineSettings
from pymunk_dragon.physics.world import World, top_speed
from pymunk_dragon.player.data import CURVE_ERROR, curve_points
from pymunk_dragon.sessions.controls import Slider
from pymunk_dragon.sessions.scene import NO_ARROW, Play, Scene

# Distance from its exact pose, in widths, at which the head counts as blocked.
_HEAD_LAG = 1 / 50
# Share of its full speed that the march then loses in a metre at full speed, and that it regains afterwards. The motor
# of the head has to follow without reaching that distance.
_BRAKING = 10.0
_RESUMING = 1.0
# 1/s: rate at which the time of a march that stands goes to where the head is, so that it goes on from there.
_RECOVERING = 5.0
# What contacts do.
CONTACTS = ("stop", "report", "resolve")
# Metres that the head travels in a step, twice as many as in `simulate` where contacts are resolved, and half its
# iterations: 223 benches take a tenth of real time.
STRIDE = 1 / 100
ITERATIONS = 30
# Most benches with which two cores keep up with real time.
MAX_BENCHES = 500


class DragonScene(Scene):
    """A dragon whose head is pulled along a march; see `Scene` and `World`."""

    abilities = ("dancers", "cut", "obstacles", "contacts", "ghost")
    # Not the joints of the dancers.
    drawn = DrawRecorder.DRAW_SHAPES

    def __init__(
        self,
        march: March,
        values: Mapping[str, float] | None = None,
        *,
        contacts: str = "resolve",
        start: float = 0.0,
    ) -> None:
        values = values or {}
        self.march = _changed(march, values)
        stride = {"substep": STRIDE / top_speed(self.march, start, None), "iterations": ITERATIONS}
        settings = EngineSettings(contacts="resolve", **stride | _settings(values))
        self.world = World(self.march, settings=settings, start=start)
        self._curve = curve_points(self.march, start, start)
        low, high = self._curve.min(axis=0), self._curve.max(axis=0)
        (x, y), (width, height) = (low + high) / 2, high - low + self.march.dragon.lengths.max()
        self._speed = values.get("speed", self.world.top_speed)
        super().__init__(self.world.space, Play(step=self.world.substep, field=(x, y, width, height)))
        self._numbers: dict[Any, int] = {body: number for number, body in enumerate(self.world.bodies)}
        self.march_time, self._share = start, 1.0
        self.time = start
        self._lag = _HEAD_LAG * float(self.march.dragon.widths.min())
        # Contacts of the last step, each with points, normal, and impulse in N s; and the pairs that touched before.
        self._touching: dict[tuple[pymunk.Shape, pymunk.Shape], tuple[Any, Any, float]] = {}
        self._touched: set[tuple[int, int]] = set()
        self._cuts: list[int] = []
        self.world.space.on_collision(pre_solve=self._pre_solve, post_solve=self._post_solve)
        self._ended = False
        self.contacts(contacts)

    def advance(self) -> None:
        """Make a step; the march waits while the head cannot follow."""
        world = self.world
        change = -_BRAKING if world.head_lag > self._lag else _RESUMING
        self._share = min(max(self._share + change * world.top_speed * world.substep, 0.0), 1.0)
        share = self._share * self._speed / world.top_speed
        try:
            states = self.march.at(self.march_time + share * world.substep, handles=2)
            self.march_time += share * world.substep
        except UnreachableError:
            if not self._ended:
                self.events.append("the head is at the end of its path")
            self._ended = self.stops = True
            states, share = self.march.at(self.march_time, handles=2), 0.0
        if share == 0 and self._held is None:
            # A motor alone would push a long chain back along its path for minutes.
            pose = states.poses[0, 0].tolist()
            ahead = (world.bodies[0].position - pymunk.Vec2d(*pose[:2])).dot(pymunk.Vec2d.from_polar(1, pose[2]))
            shift = _RECOVERING * world.substep * ahead / world.top_speed
            self.march_time = max(self.march_time + shift, world.start)
        if world.returning:
            world.carry(self.march.at(self.march_time), share)
        world.prepare(states, share=share)
        self._touching.clear()
        world.space.step(world.substep)
        world.read()
        self.steps += 1
        self.time += world.substep
        self._note_contacts()
        self.check()

    def _pre_solve(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        contact = arbiter.contact_point_set
        arbiter.process_collision = self._contacts_do == "resolve" and not self.world.returning
        self._touching[arbiter.shapes] = [point.point_a for point in contact.points], contact.normal, 0.0

    def _post_solve(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        points, normal, _ = self._touching[arbiter.shapes]
        self._touching[arbiter.shapes] = points, normal, arbiter.total_impulse.length

    def _note_contacts(self) -> None:
        """Tell of contacts that begin, and stop at them if they do so."""
        # An obstacle has the number -1, and comes first.
        pairs = (sorted(self._numbers.get(shape.body, -1) for shape in shapes) for shapes in self._touching)
        touching = {(i, j) for i, j in pairs}
        for first, second in sorted(touching - self._touched):
            i, j = (second, first) if first < 0 else (first, second)
            self.events.append(f"bench {i} and an obstacle touch" if j < 0 else f"benches {i} and {j} touch")
            self.stops |= self._contacts_do == "stop"
        self._touched = touching

    # ---- what a slider changes

    def _sliders(self) -> list[Slider]:
        """Return the sliders of a dragon; sizes that differ from bench to bench have none."""
        dragon, curve, settings, speed = self.march.dragon, self.march.curve, self.world.settings, self.world.top_speed
        step, longest = 1e3 * self.world.substep, 1e3 * MAX_STRIDE / speed
        found = [
            Slider("step", 0.5, longest, step, label="Time step", unit="ms", logarithmic=True),
            Slider("iterations", 1, 200, settings.iterations, label="Iterations", logarithmic=True, whole=True),
            Slider("drag", 0.5, 50, settings.drag, label="Ground drag", unit="1/m", logarithmic=True),
            Slider("speed", 0, 2 * speed, self._speed, label="Speed of the head", unit="m/s"),
        ]
        pitch = getattr(curve, "pitch", None)
        if pitch is not None:
            low, high = float(dragon.widths.max()) * 1.05, 3 * max(pitch, 0.55)
            found.append(Slider("pitch", low, high, pitch, label="Pitch", unit="m", rebuilds=True))
        if dragon.alike and isinstance(dragon.width, float):
            high = min(pitch or 0.6, 0.6) * 0.95
            found.append(Slider("width", 0.05, high, dragon.width, label="Width", unit="m", rebuilds=True))
            many = Slider("benches", 2, MAX_BENCHES, dragon.benches, label="Benches", whole=True, rebuilds=True)
            found.append(many)
        return found

    def _change(self, name: str, value: float) -> None:
        """Change the speed of the head, or a setting of the engine."""
        if name == "speed":
            self._speed = value
        else:
            self.world.change(**_settings({name: value}))
            self.step_length = self.world.substep

    # ---- dancers, joints, contacts

    def contacts(self, value: str) -> None:
        """Choose what contacts do."""
        self._contacts_do = word("contacts", value, CONTACTS)

    def release(self, bench: int) -> None:
        """Let the dancers of `bench` and of all behind it go."""
        self.world.release(bench)

    def hold(self) -> None:
        """Bring the dancers back."""
        self.world.hold()

    def cut(self, x: float, y: float, slip: float) -> None:
        """Cut the joint within `slip` of a point: it transmits no force any more."""
        found = self._joint_at(x, y, slip)
        joint = [pivot is found for pivot in self.world.pivots].index(True)
        self._cuts.append(joint)
        self.world.cut(joint)

    def joints(self) -> list[pymunk.Constraint]:
        """Return the joints between benches that were not cut; those of guide and motor are not shown."""
        return [joint for number, joint in enumerate(self.world.pivots) if number not in self._cuts]

    # ---- what is shown

    def to_dict(self) -> dict[str, Any]:
        """Return what the page gets once: the sizes of the benches, and the curve."""
        dragon = self.march.dragon
        sizes = {name: getattr(dragon, name).tolist() for name in ("lengths", "widths", "spacings")}
        curve = {"curve": self._curve.round(4).ravel().tolist(), "curve_error": CURVE_ERROR * min(sizes["widths"])}
        return super().to_dict() | {"dragon": {**sizes, "hole": hole_diameter(dragon), **curve}}

    def state(self) -> dict[str, Any]:
        """Return what changes now and then."""
        more = {"contacts": self._contacts_do, "free_from": self.world.free_from, "cuts": list(self._cuts)}
        return super().state() | more

    def plots(self) -> dict[str, float]:
        """Return nothing: the page has charts of the position error and the tension."""
        return {}

    def poses(self) -> Array:
        """Return the poses (N, 3) of the benches: m, m, rad."""
        return self.world.poses

    def _parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        states, poses = self.march.at(self.march_time), self.world.poses
        errors = position_errors(self.march.dragon, poses, states.positions[0])
        rows = [
            (*point, *normal, impulse if first else NO_ARROW)
            for points, normal, impulse in self._touching.values()
            for first, point in zip((True, False), points, strict=False)
        ]
        forces = np.array([joint.impulse for joint in self.world.pivots]) / self.step_length
        forces[self._cuts] = 0.0
        touching = sorted({number for pair in self._touched for number in pair if number >= 0})
        contacts = np.array(rows).reshape(-1, 5)
        parts = {"poses": poses, "exact": states.poses[0], "errors": errors, "forces": forces, "contacts": contacts}
        waits = self._share < 1 and not self._ended
        header = {"march_time": self.march_time, "touching": touching, "waits": waits}
        return header, parts


def _settings(values: Mapping[str, float]) -> dict[str, Any]:
    """Return those of the values that are settings of the engine."""
    found: dict[str, Any] = {"drag": values["drag"]} if "drag" in values else {}
    found |= {"substep": values["step"] / 1e3} if "step" in values else {}
    return found | ({"iterations": int(values["iterations"])} if "iterations" in values else {})


def _changed(march: March, values: Mapping[str, float]) -> March:
    """Return the march with other values of what a slider rebuilds."""
    kinds = {"pitch": float, "width": float, "benches": int}
    changes = {name: kind(values[name]) for name, kind in kinds.items() if name in values}
    known = Scenario.of(march).values() if changes else {}
    same = all(known[name] == value for name, value in changes.items())
    return march if same else Scenario.from_dict(known | changes, files=False).march()
