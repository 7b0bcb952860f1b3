"""The dragon, played live beside its exact model."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pymunk

from pymunk_dragon._arrays import Array
from pymunk_dragon._checks import word
from pymunk_dragon.model.dragon import hole_diameter
from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import position_errors
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.model.settings import MAX_STRIDE, EngineSettings
from pymunk_dragon.physics.assembly import top_speed
from pymunk_dragon.physics.readings import arbiter_rows, impulse_of, joint_at
from pymunk_dragon.physics.world import World
from pymunk_dragon.sessions.controls import Slider, slider_around
from pymunk_dragon.sessions.scene import PlaySettings, Scene
from pymunk_dragon.web.curve import CURVE_ERROR, curve_points

Values = Mapping[str, float]

# Distance of the head from its exact pose, in widths, at which it counts as blocked: the motor has
# to follow without reaching this distance.
_HEAD_LAG = 1 / 50
# Share of its full speed that the march of a blocked head loses in a metre, 1/m.
_BRAKING = 10.0
# Distance that the head travels in a step, mm: twice that of `simulate` where contacts are
# resolved, so that 223 benches take a tenth of real time.
_STRIDE = 10.0
# Iterations of the solver in a step: half those of `simulate`, for the same reason.
_ITERATIONS = 30
# Most benches: with these, two cores keep up with real time.
_MAX_BENCHES = 500
# Number of all obstacles among those of benches: the static body is older than they are.
_OBSTACLE = -1


class DragonScene(Scene):
    """A dragon whose head is pulled along a march; see `Scene` and `World`."""

    # The joints of the dancers are not drawn.
    draws_joints = False
    shown = ("curve", "exact", "contacts")

    def __init__(
        self, march: March, values: Values, *, contacts: str = "resolve", start: float = 0.0
    ) -> None:
        changes = {name: values[name] for name in ("pitch", "width", "benches") if name in values}
        if changes:
            scenario = Scenario.of(march).values() | changes
            march = Scenario.from_dict(scenario, files=False).march()
        self.march = march

        speed = top_speed(march, start, None)
        self._given = {
            "step": _STRIDE / speed,
            "iterations": _ITERATIONS,
            "drag": EngineSettings.drag,
            "speed": speed,
            **values,
        }
        self.world = World(march, contacts="resolve", start=start, **_settings(self._given))

        self._curve = curve_points(march, start, start)
        low = self._curve.min(axis=0)
        high = self._curve.max(axis=0)
        centre = (low + high) / 2
        size = high - low + march.dragon.lengths.max()
        settings = PlaySettings(step=self.world.substep, view=(*centre, *size))
        super().__init__(self.world.space, settings)
        self.time = start

        self._numbers: dict[pymunk.Shape, int] = {
            shape: number for number, shape in enumerate(self.world.shapes)
        }
        # Rows of the contacts of pairs that touch, and of those in the step before.
        self._touching: dict[tuple[int, ...], list[tuple[float, ...]]] = {}
        self._touched = self._touching
        # Impulses of pairs at `pre_solve`, which belong to earlier steps.
        self._earlier: dict[tuple[pymunk.Shape, ...], pymunk.Vec2d] = {}
        # This step's length over that of the last.
        self._ratio = 1.0
        self.space.on_collision(pre_solve=self._touch, data=False)
        self.space.on_collision(post_solve=self._touch, data=True)
        self.contacts(contacts)

    def _sliders(self) -> Iterator[Slider]:
        """The sliders of a dragon; sizes that differ from bench to bench have none."""
        # Properties of the engine.
        given = self._given
        engine: dict[str, Any] = {"action": self._apply, "logarithmic": True}
        speed = self.world.top_speed
        longest = 1e3 * MAX_STRIDE / speed
        count = given["iterations"]
        yield slider_around("step", 0.5, longest, given["step"], "Time step", unit="ms", **engine)
        yield slider_around("iterations", 1, 200, count, "Iterations", whole=True, **engine)
        yield slider_around("drag", 0.5, 50, given["drag"], "Ground drag", unit="1/m", **engine)
        yield Slider(
            "speed",
            0,
            2 * speed,
            given["speed"],
            label="Speed of the head",
            unit="m/s",
            action=self._apply,
        )

        # Sizes, for which the dragon is built again.
        dragon = self.march.dragon
        size: dict[str, Any] = {"unit": "m", "rebuilds": True}
        pitch = getattr(self.march.curve, "pitch", None)
        if pitch:
            low = float(dragon.widths.max()) * 1.05
            high = 3 * max(pitch, 0.55)
            yield slider_around("pitch", low, high, pitch, "Pitch", **size)
        if dragon.has_equal_benches and isinstance(dragon.width, float):
            high = min(pitch or 0.6, 0.6) * 0.95
            yield slider_around("width", 0.05, high, dragon.width, "Width", **size)
            count = dragon.benches
            yield slider_around(
                "benches", 2, _MAX_BENCHES, count, "Benches", whole=True, rebuilds=True
            )

    def _apply(self, *_: object) -> None:
        """Give the engine the values of the sliders."""
        self.world.change(**_settings(self.values))

    def _next_length(self) -> float:
        return self.world.substep

    def advance(self) -> None:
        """Make a step of the dragon."""
        world = self.world
        share = self.values["speed"] / world.top_speed
        if not world.follow(_HEAD_LAG, _BRAKING, share, recovers=self._held is None):
            self.events.append("the head is at the end of its path")
            self.stops = True

        self._touched = self._touching
        self._touching = {}
        self._earlier.clear()
        self._ratio = world.substep / world.space.current_time_step
        super().advance()
        world.read()

    def _touch(self, arbiter: pymunk.Arbiter, space: pymunk.Space, solved: bool) -> None:
        """Record a contact of this step, before it is `solved` or, if it is resolved, afterwards.

        A contact that begins is an event, and stops the session if `contacts` says so.
        """
        impulse = 0.0
        if solved:
            earlier = self._earlier[arbiter.shapes]
            impulse = impulse_of(arbiter, earlier, self._ratio).length
        else:
            arbiter.process_collision = self._contacts_do == "resolve" and not self.world.returning
            if arbiter.process_collision:
                # The contact is recorded when it is solved, with its impulse.
                self._earlier[arbiter.shapes] = arbiter.total_impulse
                return

        numbers = [self._numbers.get(shape, _OBSTACLE) for shape in arbiter.shapes]
        i, j = sorted(numbers)
        pair = i, j
        if pair not in self._touched and pair not in self._touching:
            self.events.append(_touch_text(i, j))
            self.stops |= self._contacts_do == "stop"
        rows = arbiter_rows(arbiter, numbers[0] == j, impulse)
        self._touching.setdefault(pair, []).extend(rows)

    def contacts(self, value: str) -> None:
        """Choose what contacts do."""
        self._contacts_do = word("contacts", value, ("stop", "report", "resolve"))

    def drop(self) -> None:
        """Let go of the body that is held.

        Dancers who guide all benches carry them back if some are far off.
        """
        was_held = self._held is not None
        super().drop()
        world = self.world
        is_whole = len(self.joints()) == len(world.pivots)
        if was_held and is_whole and world.free_from is None:
            exact = self.march.at(world.time).positions[0]
            errors = position_errors(self.march.dragon, world.poses, exact)
            if errors.max() > self.march.dragon.widths.min():
                world.release(1)
                world.hold()

    def cut(self, x: float, y: float, slip: float) -> None:
        """Cut the joint within `slip` of a point: it transmits no force any more."""
        found = joint_at(self.joints(), x, y, slip)
        pivots: Sequence[pymunk.Constraint] = self.world.pivots
        self.world.cut(pivots.index(found))

    def shapes(self) -> list[pymunk.Shape]:
        """The shapes of the benches; where two overlap, that of the lower number is on top."""
        self.space.debug_draw(self._recorder)
        return [*reversed(self.world.shapes)]

    def joints(self) -> list[pymunk.Constraint]:
        """The joints between benches that were not cut; those of guide and motor are not shown."""
        return [pivot for pivot in self.world.pivots if pivot.max_force > 0]

    def to_dict(self) -> dict[str, Any]:
        """What the page gets once: the sizes of the benches, and the curve."""
        dragon = self.march.dragon
        about = {
            "lengths": dragon.lengths.tolist(),
            "widths": dragon.widths.tolist(),
            "spacings": dragon.spacings.tolist(),
            "hole": hole_diameter(dragon),
            "curve": self._curve.round(4).ravel().tolist(),
            "curve_error": CURVE_ERROR * float(dragon.widths.min()),
        }
        return super().to_dict() | {"dragon": about}

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
        world = self.world
        states = self.march.at(world.time)
        contacts = [row for rows in self._touching.values() for row in rows]
        arrays = {
            "poses": world.poses,
            "exact": states.poses[0],
            "errors": position_errors(self.march.dragon, world.poses, states.positions[0]),
            "forces": world.joint_forces,
            "contacts": np.array(contacts).reshape(-1, 5),
        }
        touching = sorted(set().union(*self._touching) - {_OBSTACLE})
        more = {"march_time": world.time, "touching": touching, "waits": world.share < 1}
        return more, arrays


def _settings(values: Values) -> dict[str, Any]:
    """The settings of the engine for values of the sliders."""
    return {
        "substep": values["step"] / 1e3,
        "iterations": int(values["iterations"]),
        "drag": values["drag"],
    }


def _touch_text(i: int, j: int) -> str:
    """The event of a pair that begins to touch; the first number may be that of obstacles."""
    if i == _OBSTACLE:
        # The catalogue of translations has the name {i} for the bench.
        i = j
        return f"bench {i} and an obstacle touch"
    return f"benches {i} and {j} touch"
