"""A world whose dancers, joints, contacts and settings can be changed between two steps."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np
import pymunk

from pymunk_dragon._arrays import Array
from pymunk_dragon.model.march import March, States
from pymunk_dragon.model.settings import HEAD_FORCE, EngineSettings
from pymunk_dragon.physics.world import World

# Seconds per metre of the head: length of a step, 10 mm. Twice the one of `simulate` where contacts are resolved, and
# half its iterations, so that 223 benches take a tenth of real time.
STRIDE = 1 / 100
ITERATIONS = 30
# Speed at which dancers who come back carry a bench, over the head's top speed; rate of the approach, per metre.
RETURN = 4.0
CARRYING = 20.0
# Position error at which a bench is back, in widths.
CLOSE = 0.1
# Largest force of a dancer, over the ground drag on the bench at the head's top speed, and torque at 1 m.
MOST_FORCE = 20.0


class SteeredWorld(World):
    """A world with a head that a motor pulls, in which dancers let go, joints are cut, and settings change.

    Parameters
    ----------
    march : March
        The motion to play.
    settings : EngineSettings, optional
        Step, iterations and drag; contacts are those of `World` with "resolve", whatever is given.
    start : float
        Time of the first state, s.

    Attributes
    ----------
    contact : str
        What contacts do: "resolve" pushes the benches apart, with "report" and "stop" they pass through each other.
    touching : dict
        Contacts of the last step: pairs of shapes, each with point, normal, and impulse in N s.
    free_from : int or None
        First bench whose dancers have let go, as have those of all behind it.

    Examples
    --------
    >>> from pymunk_dragon import Dragon, March
    >>> world = SteeredWorld(March(Dragon(benches=4)))
    >>> world.cut(1)
    >>> [pivot.max_force for pivot in world.pivots]
    [inf, 0.0, inf]
    """

    def __init__(self, march: March, settings: EngineSettings | None = None, *, start: float = 0.0) -> None:
        settings = EngineSettings() if settings is None else settings
        fastest = float(march.speed_profile.fastest(start, max(start, march.end)))
        self.free_from: int | None = None
        self._carriers: list[pymunk.PivotJoint] = []
        self._unpushed = march.dragon.benches
        self._limits: Array = np.array(np.inf)
        super().__init__(
            march,
            "rails",
            replace(
                settings,
                contacts="resolve",
                substep=STRIDE / fastest if settings.substep is None else settings.substep,
                iterations=ITERATIONS if settings.iterations is None else settings.iterations,
            ),
            start=start,
        )
        self.contact = "resolve"
        self.touching: dict[tuple[pymunk.Shape, pymunk.Shape], tuple[Any, Any, float]] = {}
        self._limits = MOST_FORCE * np.array(self._masses)[:, None] * self.settings.drag * fastest**2
        self.space.on_collision(pre_solve=self._pre_solve, post_solve=self._post_solve)

    def step(self, head_pose: Array, head_velocity: Array, hinge_velocity: Array) -> None:
        """Make a step that ends with the head's motor at a given pose; the parameters are those of `prepare`."""
        self.prepare(head_pose, head_velocity, hinge_velocity)
        self.touching.clear()
        self.space.step(self.substep)
        self.read()

    def retune(self, *, substep: float | None = None, iterations: int | None = None, drag: float | None = None) -> None:
        """Change settings from the next step on.

        Raises
        ------
        ParameterError
            If one is out of its range.
        """
        changes = {"substep": substep, "iterations": iterations, "drag": drag}
        given: dict[str, Any] = {name: value for name, value in changes.items() if value is not None}
        chosen = replace(self.settings, **given)
        self.settings = chosen.resolved(top_speed=self.top_speed, pulled_mass=self._pulled_mass)
        assert self.settings.substep is not None  # Set by `resolved`.
        assert self.settings.iterations is not None  # Set by `resolved`.
        self.substep = self.settings.substep
        self.space.iterations = self.settings.iterations
        drag_rate = self.settings.drag * self.top_speed
        self.space.damping = math.exp(-drag_rate)
        self.guide.retune(self.substep, drag_rate)
        self._set_head_force(self._head_force)

    def release(self, bench: int) -> None:
        """Let the dancers of `bench`, from 1 on, and of all behind it go."""
        self._stop_carrying()
        # Removed and added again, joints would be solved in another order, which converges more slowly.
        for joint in chain.from_iterable(self._guiding[bench - 1 :]):
            joint.max_force = 0.0
        self.free_from = min(bench, self._first_free)
        self._unpushed = min(self._unpushed, self.free_from)
        self._set_head_force(self._head_force)

    def hold(self) -> None:
        """Have the dancers come back: they carry the free benches, over all others, to their exact positions."""
        if self.returning or self.free_from is None:
            return
        ground, half = self.space.static_body, self.march.dragon.spacings / 2
        for bench in range(self.free_from, len(self.bodies)):
            body = self.bodies[bench]
            carrier = pymunk.PivotJoint(ground, body, body.position, (-half[bench], 0.0))
            carrier.max_bias = RETURN * self.top_speed
            carrier.error_bias = math.exp(-CARRYING * self.top_speed)
            carrier.max_force = float(self._limits[bench, 0])
            self._carriers.append(carrier)
        self.space.add(*self._carriers)
        self._set_head_force(self._head_force)

    def carry(self, states: States, share: float) -> None:
        """Carry benches to their positions in the exact `states` (one time), whose velocities apply by a `share`.

        When all have arrived, dancers guide them again. To be called before each step while benches are `returning`.
        """
        assert self.free_from is not None  # Benches return only if some were free.
        exact, first = states.positions[0], self.free_from + 1
        # A carrier follows a moving target with a delay of this time, so its target is as far ahead: otherwise it would
        # brake the chain, whose tension would tear it apart when the carriers let go.
        ahead = self.substep / (1 - math.exp(-CARRYING * self.top_speed * self.substep))
        targets = exact[first:] + ahead * share * states.velocities[0, first:]
        for carrier, (x, y) in zip(self._carriers, targets.tolist(), strict=True):
            carrier.anchor_a = x, y
        distances = np.hypot(*(self.poses[:, :2] - states.poses[0, :, :2]).T)
        if distances.max() < CLOSE * self.march.dragon.widths.min():
            self._arrive(states.handles_s[0])

    def _arrive(self, handles_s: Array) -> None:
        self._stop_carrying()
        self.guide.relocate(handles_s)
        for joint in chain.from_iterable(self._guiding[self._first_free - 1 :]):
            joint.max_force = math.inf
        self.free_from = None
        cut = [joint for joint, pivot in enumerate(self.pivots) if pivot.max_force == 0]
        self._unpushed = cut[0] + 1 if cut else len(self.bodies)
        self._set_head_force(self._head_force)

    def _stop_carrying(self) -> None:
        self.space.remove(*self._carriers)
        self._carriers.clear()

    @property
    def returning(self) -> bool:
        """Whether dancers carry benches back."""
        return bool(self._carriers)

    def cut(self, joint: int) -> None:
        """Cut the joint between the benches `joint` and `joint` + 1; dancers behind it no longer walk.

        The benches still pass over each other there: they overlap, and would be thrown apart.
        """
        self.pivots[joint].max_force = 0.0
        self._unpushed = min(self._unpushed, joint + 1)

    @property
    def _first_free(self) -> int:
        return len(self.bodies) if self.free_from is None else self.free_from

    @property
    def _pulled_mass(self) -> float:
        """Mass of the benches on which the head balances the ground drag, kg."""
        free = self._masses[:1] + self._masses[self._first_free :]
        return math.fsum(self._masses if self.returning else free)

    @property
    def _head_force(self) -> float:
        return HEAD_FORCE * self.settings.drag * self.top_speed**2 * self._pulled_mass

    def _fixed_bodies(self) -> list[pymunk.Body]:
        # Pymunk adds this body to the space when it is first used, as for the shape of an obstacle.
        return [self.space.static_body]

    def _limit_forces(self) -> None:
        forces = self._out_forces
        forces[self._unpushed :] = 0.0
        # A bench that comes back across the path would get forces without limit.
        np.nan_to_num(forces, copy=False)
        np.clip(forces, -self._limits, self._limits, out=forces)

    def _pre_solve(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        contact = arbiter.contact_point_set
        arbiter.process_collision = self.contact == "resolve" and not self.returning
        self.touching[arbiter.shapes] = contact.points[0].point_a, contact.normal, 0.0

    def _post_solve(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        point, normal, _ = self.touching[arbiter.shapes]
        self.touching[arbiter.shapes] = point, normal, arbiter.total_impulse.length
