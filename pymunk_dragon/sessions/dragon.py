"""The dragon, played live beside its exact model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pymunk

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import word
from pymunk_dragon.drawing.debug_draw import DrawRecorder
from pymunk_dragon.drawing.scene import hole_diameter
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import position_errors
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.model.settings import MAX_STRIDE, EngineSettings
from pymunk_dragon.physics.readings import arbiter_rows, impulse_of, joint_at
from pymunk_dragon.physics.world import World, top_speed
from pymunk_dragon.player.data import CURVE_ERROR, curve_points
from pymunk_dragon.sessions.controls import Slider, slider_around
from pymunk_dragon.sessions.scene import PlaySettings, Scene

Values = Mapping[str, float]

# Distance from its exact pose, in widths, at which the head counts as blocked: its motor has to
# follow without reaching it. And share of its full speed that the march then loses in a metre.
_HEAD_LAG, _BRAKING = 1 / 50, 10.0
# mm that the head travels in a step, twice as many as in `simulate` where contacts are resolved,
# and half its iterations: 223 benches take a tenth of real time. With the most benches two cores
# keep up with real time.
_STRIDE, _ITERATIONS, _MAX_BENCHES = 10.0, 30, 500
# Number of all obstacles among those of benches: the static body is older than they are.
_OBSTACLE = -1


class DragonScene(Scene):
    """A dragon whose head is pulled along a march; see `Scene` and `World`."""

    # Not the joints of the dancers.
    drawn = DrawRecorder.DRAW_SHAPES

    def __init__(
        self, march: March, values: Values, *, contacts: str = "resolve", start: float = 0.0
    ) -> None:
        changes = {name: values[name] for name in ("pitch", "width", "benches") if name in values}
        if changes:
            march = Scenario.from_dict(Scenario.of(march).values() | changes, files=False).march()
        self.march = march
        speed = top_speed(march, start, None)
        usual = {
            "step": _STRIDE / speed,
            "iterations": _ITERATIONS,
            "drag": EngineSettings.drag,
            "speed": speed,
        }
        self._given = usual | dict(values)
        self.world = World(march, contacts="resolve", start=start, **_settings(self._given))
        self._curve = curve_points(march, start, start)
        low, high = self._curve.min(axis=0), self._curve.max(axis=0)
        (x, y), (width, height) = (low + high) / 2, high - low + march.dragon.lengths.max()
        super().__init__(
            self.world.space, PlaySettings(step=self.world.substep, field=(x, y, width, height))
        )
        self.time = start
        self._numbers: dict[pymunk.Shape, int] = {
            shape: number for number, shape in enumerate(self.world.shapes)
        }
        # Rows of the contacts of pairs that touch, and of those in the step before.
        self._touching: dict[tuple[int, ...], list[tuple[float, ...]]] = {}
        self._touched = self._touching
        # Impulses of pairs at `pre_solve`, which belong to earlier steps, and this step's length
        # over that of the last.
        self._earlier: dict[tuple[pymunk.Shape, ...], pymunk.Vec2d] = {}
        self._ratio = 1.0
        self.space.on_collision(pre_solve=self._touch, data=False)
        self.space.on_collision(post_solve=self._touch, data=True)
        self.contacts(contacts)

    def _sliders(self) -> list[Slider]:
        """The sliders of a dragon; sizes that differ from bench to bench have none."""
        dragon, values, speed = self.march.dragon, self._given, self.world.top_speed
        engine: dict[str, Any] = {"action": self._apply, "logarithmic": True}
        longest = 1e3 * MAX_STRIDE / speed
        found = [
            slider_around(
                "step", 0.5, longest, values["step"], label="Time step", unit="ms", **engine
            ),
            slider_around(
                "iterations", 1, 200, values["iterations"], label="Iterations", whole=True, **engine
            ),
            slider_around(
                "drag", 0.5, 50, values["drag"], label="Ground drag", unit="1/m", **engine
            ),
            Slider(
                "speed",
                0,
                2 * speed,
                values["speed"],
                label="Speed of the head",
                unit="m/s",
                action=self._apply,
            ),
        ]
        if pitch := getattr(self.march.curve, "pitch", None):
            low, high = float(dragon.widths.max()) * 1.05, 3 * max(pitch, 0.55)
            found.append(Slider("pitch", low, high, pitch, label="Pitch", unit="m", rebuilds=True))
        if dragon.has_equal_benches and isinstance(dragon.width, float):
            high = min(pitch or 0.6, 0.6) * 0.95
            found.append(
                slider_around(
                    "width", 0.05, high, dragon.width, label="Width", unit="m", rebuilds=True
                )
            )
            found.append(
                slider_around(
                    "benches",
                    2,
                    _MAX_BENCHES,
                    dragon.benches,
                    label="Benches",
                    whole=True,
                    rebuilds=True,
                )
            )
        return found

    def _apply(self, *_: object) -> None:
        """Give the engine the values of the sliders."""
        self.world.change(**_settings(self.values))

    def _next_length(self) -> float:
        return self.world.substep

    def advance(self) -> None:
        """Make a step of the dragon."""
        world = self.world
        if not world.follow(
            _HEAD_LAG, _BRAKING, self.values["speed"] / world.top_speed, recovers=self._held is None
        ):
            self.events.append("the head is at the end of its path")
            self.stops = True
        self._touched, self._touching = self._touching, {}
        self._earlier.clear()
        self._ratio = world.substep / world.space.current_time_step
        super().advance()
        world.read()

    def _touch(self, arbiter: pymunk.Arbiter, space: pymunk.Space, solved: bool) -> None:
        """Record a contact of this step; one that begins is an event, and stops the session if `contacts` says so."""
        if not solved:
            arbiter.process_collision = self._contacts_do == "resolve" and not self.world.returning
            if arbiter.process_collision:
                self._earlier[arbiter.shapes] = arbiter.total_impulse
                return
        numbers = [self._numbers.get(shape, _OBSTACLE) for shape in arbiter.shapes]
        pair = min(numbers), max(numbers)
        if pair not in self._touched and pair not in self._touching:
            self.events.append(_touch_text(*pair))
            self.stops |= self._contacts_do == "stop"
        impulse = (
            impulse_of(arbiter, self._earlier[arbiter.shapes], self._ratio).length
            if solved
            else 0.0
        )
        self._touching.setdefault(pair, []).extend(
            arbiter_rows(arbiter, numbers[0] == pair[1], impulse)
        )

    def contacts(self, value: str) -> None:
        """Choose what contacts do."""
        self._contacts_do = word("contacts", value, ("stop", "report", "resolve"))

    def drop(self) -> None:
        """Let go of the body that is held. Dancers who guide all benches carry them back if some are far off."""
        world, held = self.world, self._held
        super().drop()
        if held is not None and world.free_from is None and len(self.joints()) == len(world.pivots):
            errors = position_errors(
                self.march.dragon, world.poses, self.march.at(world.time).positions[0]
            )
            if errors.max() > self.march.dragon.widths.min():
                world.release(1)
                world.hold()

    def release(self, bench: int) -> None:
        """Let the dancers of `bench` and of all behind it go."""
        self.world.release(bench)

    def hold(self) -> None:
        """Bring the dancers back."""
        self.world.hold()

    def cut(self, x: float, y: float, slip: float) -> None:
        """Cut the joint within `slip` of a point: it transmits no force any more."""
        found = joint_at(self.joints(), x, y, slip)
        self.world.cut([pivot is found for pivot in self.world.pivots].index(True))

    def shapes(self) -> list[pymunk.Shape]:
        """The shapes of the benches: where two overlap, the page points at the one of the lower number."""
        self.space.debug_draw(self._recorder)
        return [*reversed(self.world.shapes)]

    def joints(self) -> list[pymunk.Constraint]:
        """The joints between benches that were not cut; those of guide and motor are not shown."""
        return [pivot for pivot in self.world.pivots if pivot.max_force > 0]

    def to_dict(self) -> dict[str, Any]:
        """What the page gets once: the sizes of the benches, and the curve."""
        dragon = self.march.dragon
        sizes = {name: getattr(dragon, name).tolist() for name in ("lengths", "widths", "spacings")}
        curve = {
            "curve": self._curve.round(4).ravel().tolist(),
            "curve_error": CURVE_ERROR * min(sizes["widths"]),
        }
        return super().to_dict() | {"dragon": {**sizes, "hole": hole_diameter(dragon), **curve}}

    def state(self) -> dict[str, Any]:
        """What changes now and then."""
        cuts = [number for number, pivot in enumerate(self.world.pivots) if pivot.max_force == 0]
        return super().state() | {
            "contacts": self._contacts_do,
            "free_from": self.world.free_from,
            "cuts": cuts,
        }

    def poses(self) -> Array:
        """The poses (N, 3) of the benches: m, m, rad."""
        return self.world.poses

    def _parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        states, poses = self.march.at(self.world.time), self.world.poses
        arrays = {
            "poses": poses,
            "exact": states.poses[0],
            "errors": position_errors(self.march.dragon, poses, states.positions[0]),
            "forces": self.world.joint_forces,
            "contacts": np.array([row for rows in self._touching.values() for row in rows]).reshape(
                -1, 5
            ),
        }
        touching = sorted({number for pair in self._touching for number in pair} - {_OBSTACLE})
        return {
            "march_time": self.world.time,
            "touching": touching,
            "waits": self.world.share < 1,
        }, arrays


def _settings(values: Values) -> dict[str, Any]:
    """The settings of the engine for values of the sliders."""
    return {
        "substep": values["step"] / 1e3,
        "iterations": int(values["iterations"]),
        "drag": values["drag"],
    }


def _touch_text(first: int, i: int) -> str:
    """The event of a pair that begins to touch; the first number may be that of obstacles."""
    if first == _OBSTACLE:
        return f"bench {i} and an obstacle touch"
    i, j = first, i
    return f"benches {i} and {j} touch"
