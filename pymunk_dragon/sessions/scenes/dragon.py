"""The dragon, played live beside its exact model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pymunk

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import word
from pymunk_dragon.drawing.scene import hole_diameter
from pymunk_dragon.errors import UnreachableError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.model.settings import MAX_STRIDE, EngineSettings
from pymunk_dragon.physics.world import World, top_speed
from pymunk_dragon.player.data import CURVE_ERROR, curve_points
from pymunk_dragon.sessions.scenes.base import Parameter, Scene

# Distance from its exact pose, in widths, at which the head counts as blocked.
HEAD_LAG = 1 / 50
# Share of its full speed that the march then loses in a metre at full speed, and that it regains afterwards. The motor
# of the head has to follow without reaching that distance.
BRAKING = 10.0
RESUMING = 1.0
# What contacts do.
CONTACTS = ("stop", "report", "resolve")
# Metres that the head travels in a step, twice as many as in `simulate` where contacts are resolved, and half its
# iterations: 223 benches take a tenth of real time.
STRIDE = 1 / 100
ITERATIONS = 30
# Most benches with which two cores keep up with real time.
MAX_BENCHES = 500


class DragonScene(Scene):
    """A dragon whose head is pulled along a march; see `Scene` and `World`.

    Parameters
    ----------
    march : March
        The march.
    values : mapping, optional
        Values of parameters.
    contacts : {"stop", "report", "resolve"}
        What contacts do.
    free_from : int, optional
        First bench without dancers from the start on.
    start : float
        First time, s.
    """

    abilities = ("dancers", "cut", "obstacles", "contacts", "ghost", "speed")

    def __init__(
        self,
        march: March,
        values: Mapping[str, float] | None = None,
        *,
        contacts: str = "resolve",
        free_from: int | None = None,
        start: float = 0.0,
    ) -> None:
        values = values or {}
        self.march = _changed(march, values)
        settings = {
            "substep": STRIDE / top_speed(self.march, start, None),
            "iterations": ITERATIONS,
            **_settings(values),
        }
        self.world = World(self.march, settings=EngineSettings(contacts="resolve", **settings), start=start)
        super().__init__(self.world.space, self.world.substep)
        # Joint j is pivot j; joints of guide and motor are not shown.
        self.joints = list(self.world.pivots)
        self.bodies = list(self.world.bodies)
        self._numbers = {body: number for number, body in enumerate(self.bodies)}
        self._start, self._march_time, self._share = start, start, 1.0
        self._speed = values.get("speed", self.world.top_speed)
        self._time = start
        self._lag = HEAD_LAG * float(self.march.dragon.widths.min())
        # Contacts of the last step, each with point, normal, and impulse in N s; and the pairs that touched before.
        self._touching: dict[tuple[pymunk.Shape, pymunk.Shape], tuple[Any, Any, float]] = {}
        self._touched: set[tuple[int, int]] = set()
        self.world.space.on_collision(pre_solve=self._pre_solve, post_solve=self._post_solve)
        self.ended = False
        self.contacts(contacts)
        if free_from is not None:
            self.release(free_from)

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._time

    @property
    def march_time(self) -> float:
        """Time of the exact model, s: it stops where the head is blocked."""
        return self._march_time

    def advance(self) -> None:
        """Make a step; the march waits while the head cannot follow."""
        world = self.world
        change = -BRAKING if world.head_lag > self._lag else RESUMING
        self._share = min(max(self._share + change * world.top_speed * world.substep, 0.0), 1.0)
        share = self._share * self._speed / world.top_speed
        try:
            states = self.march.at(self._march_time + share * world.substep, handles=2)
            self._march_time += share * world.substep
        except UnreachableError:
            if not self.ended:
                self.events.append("the head is at the end of its path")
            self.ended = self.stops = True
            states, share = self.march.at(self._march_time, handles=2), 0.0
        if world.returning:
            world.carry(self.march.at(self._march_time), share)
        world.prepare(states, share=share)
        self._touching.clear()
        world.space.step(world.substep)
        world.read()
        self.steps += 1
        self._time += world.substep
        self._note_contacts()

    def _pre_solve(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        contact = arbiter.contact_point_set
        arbiter.process_collision = self._contacts_do == "resolve" and not self.world.returning
        self._touching[arbiter.shapes] = contact.points[0].point_a, contact.normal, 0.0

    def _post_solve(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        point, normal, _ = self._touching[arbiter.shapes]
        self._touching[arbiter.shapes] = point, normal, arbiter.total_impulse.length

    def _note_contacts(self) -> None:
        """Tell of contacts that begin, and stop at them if they do so."""
        touching = set()
        for shapes in self._touching:
            first, second = sorted(self._number(shape.body) for shape in shapes)
            touching.add((first, second))
        for first, second in sorted(touching - self._touched):
            i, j = (second, first) if first < 0 else (first, second)
            self.events.append(f"bench {i} and an obstacle touch" if j < 0 else f"benches {i} and {j} touch")
            self.stops |= self._contacts_do == "stop"
        self._touched = touching

    # ---- what a slider changes

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The sliders; sizes that differ from bench to bench have none."""
        dragon, curve, speed = self.march.dragon, self.march.curve, self.world.top_speed
        found = [
            Parameter(
                name="step", label="Time step", unit="ms", low=0.5, high=1e3 * MAX_STRIDE / speed, logarithmic=True
            ),
            Parameter(name="iterations", label="Iterations", unit="", low=1, high=200, logarithmic=True, whole=True),
            Parameter(name="drag", label="Ground drag", unit="1/m", low=0.5, high=50.0, logarithmic=True),
            Parameter(name="speed", label="Speed of the head", unit="m/s", low=0.0, high=2 * speed),
        ]
        pitch = getattr(curve, "pitch", None)
        if pitch is not None:
            low, high = float(dragon.widths.max()) * 1.05, 3 * max(pitch, 0.55)
            found.append(Parameter(name="pitch", label="Pitch", unit="m", low=low, high=high, rebuilds=True))
        if dragon.alike and isinstance(dragon.width, float):
            high = min(pitch or 0.6, 0.6) * 0.95
            found.append(Parameter(name="width", label="Width", unit="m", low=0.05, high=high, rebuilds=True))
            benches = Parameter(
                name="benches", label="Benches", unit="", low=2, high=MAX_BENCHES, whole=True, rebuilds=True
            )
            found.append(benches)
        return tuple(found)

    @property
    def values(self) -> dict[str, float]:
        """Values of the parameters."""
        dragon, settings = self.march.dragon, self.world.settings
        found: dict[str, Any] = {
            "step": 1e3 * self.world.substep,
            "iterations": settings.iterations,
            "drag": settings.drag,
            "speed": self._speed,
            "pitch": getattr(self.march.curve, "pitch", None),
            "width": dragon.width,
            "benches": dragon.benches,
        }
        return {each.name: found[each.name] for each in self.parameters}

    def set(self, name: str, value: float) -> None:
        """Change a parameter that does not rebuild."""
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

    def cut(self, joint: int) -> None:
        """Cut the joint between the benches `joint` and `joint` + 1."""
        super().cut(joint)
        self.world.cut(joint)

    # ---- what is shown

    def to_dict(self) -> dict[str, Any]:
        """As `Scene.to_dict`, with the sizes of the benches and the curve instead of shapes."""
        dragon = self.march.dragon
        points = curve_points(self.march, self._start, self._start)
        low, high = points.min(axis=0), points.max(axis=0)
        return {
            **super().to_dict(),
            "dragon": {
                "lengths": dragon.lengths.tolist(),
                "widths": dragon.widths.tolist(),
                "spacings": dragon.spacings.tolist(),
                "hole": hole_diameter(dragon),
                "curve": points.round(4).ravel().tolist(),
                "curve_error": CURVE_ERROR * float(dragon.widths.min()),
            },
            "bodies": [{"type": "dynamic", "shapes": []} for _ in self.bodies],
            "static": [],
            "field": {"centre": ((low + high) / 2).tolist(), "size": (high - low + dragon.lengths.max()).tolist()},
        }

    def state(self) -> dict[str, Any]:
        """As `Scene.state`."""
        return {**super().state(), "contacts": self._contacts_do, "free_from": self.world.free_from}

    def poses(self) -> Array:
        """Poses (N, 3) of the benches: m, m, rad."""
        return self.world.poses

    def _exact(self) -> tuple[Array, Array]:
        states = self.march.at(self._march_time)
        front, rear = self.march.dragon.holes(self.world.poses)
        exact = states.positions[0]
        errors = np.maximum(np.hypot(*(front - exact[:-1]).T), np.hypot(*(rear - exact[1:]).T))
        return states.poses[0], errors

    def _contacts(self) -> Iterator[tuple[float, ...]]:
        for shapes, contact in self._touching.items():
            yield self._contact(shapes, *contact)


def _settings(values: Mapping[str, float]) -> dict[str, Any]:
    """Those of the values that are settings of the engine."""
    found: dict[str, Any] = {}
    if "step" in values:
        found["substep"] = values["step"] / 1e3
    if "iterations" in values:
        found["iterations"] = int(values["iterations"])
    if "drag" in values:
        found["drag"] = values["drag"]
    return found


def _changed(march: March, values: Mapping[str, float]) -> March:
    """The march with other values of what a slider rebuilds."""
    changes: dict[str, float] = {name: values[name] for name in ("pitch", "width") if name in values}
    if "benches" in values:
        changes["benches"] = int(values["benches"])
    known = Scenario.of(march).values() if changes else {}
    same = all(known[name] == value for name, value in changes.items())
    return march if same else Scenario.from_dict(known | changes, files=False).march()
