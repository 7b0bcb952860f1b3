"""Settings of the Pymunk engine."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, get_args

from pymunk_dragon._checks import finite, flag, positive, whole, word
from pymunk_dragon.errors import ParameterError

# Response to contacts: end the run, go on and record them, or let the engine push the benches
# apart.
_Contacts = Literal["stop", "report", "resolve"]

# m that the head travels in one substep; `physics` has the drift of other values.
_STRIDE = 1 / 50
# Solver iterations in a substep.
_ITERATIONS = 10
# m that the head travels in one substep where benches are only pulled. The first contact of the
# reference march is 0.107 ms early; with 1/50 m and 10 iterations, which take longer, 0.242 ms.
_PULL_STRIDE = 1 / 40
# Iterations there: the joints carry the drag on all benches behind.
_PULL_ITERATIONS = 20
# m that the head travels in one substep where contacts are resolved.
_RESOLVE_STRIDE = 1 / 200
# Iterations there: with 10, gaps in the loaded joints are five times as wide.
_RESOLVE_ITERATIONS = 60
# m. Longer substeps skip over a bench.
MAX_STRIDE = 0.1
# m. Shorter substeps take days for a march.
_MIN_STRIDE = 1e-5
# Ground drag, per metre marched (per second at 1 m/s): faster than Pymunk's correction of joint
# errors, 6.3 per second (its error_bias, 0.9 ** 60). The docstring of `physics` says why.
_DRAG = 11.5
# Largest force of the head's motor, in units of the ground drag on what the head has to pull.
_HEAD_FORCE = 2.0
# More sweeps per substep than any chain needs to converge.
_MAX_ITERATIONS = 100_000
# Largest values, and units. With the largest drag a body keeps nothing of its velocity in a substep
# of 10 mm.
_LIMITS = {
    "substep": (1e9, "s"),
    "drag": (1e4, "per metre"),
    "frame_interval": (1e9, "s"),
    "head_force": (1e9, "N"),
}


@dataclass(frozen=True, kw_only=True)
class EngineSettings:
    """Settings of the engine; the defaults are those of `simulate`.

    Parameters
    ----------
    contacts : {"stop", "report", "resolve"}
        At the first contact of benches that are not neighbours: end the run, go on and only record
        contacts, or go on and let the engine push the benches apart. Resolved, the head is pulled
        along the march by a motor of finite force, and the dancers stop where the head cannot go
        on.
    substep : float, optional
        Length of a step, s. By default the time in which the head travels 20 mm; 25 mm with a
        guide that does not hold all benches, as "none"; 5 mm where contacts are resolved.
    iterations : int, optional
        Solver iterations in a step. By default 10; 20 with such a guide; 60 where contacts are
        resolved.
    drag : float
        Ground drag on the benches, per metre marched: velocities decay at this rate times the
        head's top speed.
    order : {2, 1}
        Order of the method for benches that are only pulled: halving the substep leaves a quarter
        of the error, or half of it, as in Pymunk's own step.
    frame_interval : float, optional
        Time between recorded frames, s, rounded to whole substeps; by default the time in which the
        head travels 0.1 m.
    head_force : float, optional
        Largest force of the head's motor, N, where contacts are resolved. By default twice the
        ground drag on what the head pulls: on itself where dancers walk (0.47 kN for the contest's
        at 1 m/s), on all benches without a guide.

    Examples
    --------
    >>> from dataclasses import replace
    >>> coarse = EngineSettings(substep=0.05, iterations=5)
    >>> replace(coarse, contacts="report").iterations
    5
    """

    contacts: _Contacts = "stop"
    substep: float | None = None
    iterations: int | None = None
    drag: float = _DRAG
    order: int = 2
    frame_interval: float | None = None
    head_force: float | None = None

    def __post_init__(self) -> None:
        word("contacts", self.contacts, get_args(_Contacts))
        if self.head_force is not None and self.contacts != "resolve":
            bound = "absent unless contacts are resolved"
            raise ParameterError("head_force", self.head_force, bound)
        for name, (high, unit) in _LIMITS.items():
            if (value := getattr(self, name)) is not None or name == "drag":
                vars(self)[name] = positive(name, value, high, unit)
        vars(self)["order"] = whole("order", self.order, 1, 2)
        if self.iterations is not None:
            vars(self)["iterations"] = whole("iterations", self.iterations, 1, _MAX_ITERATIONS)

    def resolved(
        self, *, top_speed: float, pulled_mass: float, holds_all: bool = True
    ) -> EngineSettings:
        """The settings with numbers in place of None, apart from a `head_force` without a use.

        `top_speed` is the highest one of the head, m/s, and `pulled_mass` that of the benches on
        which the head has to balance the ground drag, kg; `holds_all` says whether the guide holds
        all benches on the path. In a substep the head may travel from 0.01 mm to 0.1 m.
        """
        top_speed = positive("top_speed", top_speed, math.inf, "m/s")
        pulled_mass = positive("pulled_mass", pulled_mass, math.inf, "kg")
        holds_all = flag("holds_all", holds_all)
        stride = _STRIDE if holds_all else _PULL_STRIDE
        iterations = _ITERATIONS if holds_all else _PULL_ITERATIONS
        force = None
        if self.contacts == "resolve":
            stride, iterations = _RESOLVE_STRIDE, _RESOLVE_ITERATIONS
            force = self.head_force or _HEAD_FORCE * self.drag * top_speed**2 * pulled_mass

        substep = self.substep or stride / top_speed
        iterations = self.iterations or iterations
        finite("substep", substep, _MIN_STRIDE / top_speed, MAX_STRIDE / top_speed, "s")
        return replace(self, substep=substep, iterations=iterations, head_force=force)
