"""What a sweep computes at each point: a function of a march and of keyword-only parameters.

These parameters can be axes, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from inspect import getdoc, signature
from pkgutil import resolve_name
from threading import local
from typing import Any

import numpy as np

from pymunk_dragon._checks import word
from pymunk_dragon.collision import first_contact
from pymunk_dragon.errors import DragonError, ParameterError, one_line
from pymunk_dragon.model.march import March
from pymunk_dragon.model.scenario import Scenario, parameters
from pymunk_dragon.studies import max_speed, min_pitch

Values = Mapping[str, Any]
# Values of one point by name, or None and the reason.
Outcome = tuple[Values | None, str | None]

# Parameters of a scenario that are numbers.
_SCENARIO = [name for name in parameters() if name not in ("curve", "outward", "points")]
# States of handles that marches of equal motion share, of about 70 bytes: twice those of the
# paper's march.
_ROOM = 400_000
# The key and the continuation of the march before, by thread.
_BEFORE = local()
# Characters of an error message in a table.
_MAX_MESSAGE = 300


class Quantity:
    """What a sweep computes: a function of a `March` and of keyword-only parameters.

    The name is one of `QUANTITIES` or ``"module:function"``; `summary` is what is computed, in one
    line. `parameters` are names of parameters that can be axes, of which `own_parameters` are the
    function's.
    """

    def __init__(self, name: str, function: Callable[..., Values]) -> None:
        self.name = name
        self.function = function
        self.summary = (getdoc(function) or name).partition("\n")[0].rstrip(".")
        declared = signature(function).parameters.values()
        self.own_parameters = [each.name for each in declared if each.kind is each.KEYWORD_ONLY]
        self.parameters = [*_SCENARIO, *self.own_parameters]

    def complete_values(self, values: Values) -> dict[str, Any]:
        """Complete and plain values of parameters.

        Raises a `ParameterError` if one is out of range, or no parameter.
        """
        scenario, own = self.scenario(values)
        found = scenario.values()
        for name in self.own_parameters:
            found.pop(name, None)
        return found | own

    def scenario(self, values: Values) -> tuple[Scenario, dict[str, Any]]:
        """The scenario of values of parameters, and the function's own ones."""
        others = dict(values)
        names = [name for name in self.own_parameters if name in others]
        own = {name: _plain(name, others.pop(name)) for name in names}
        return Scenario.from_dict(others), own


def quantity_of(quantity: str | Callable[..., Values]) -> Quantity:
    """The quantity of a name, or of a function that has one.

    Raises a `ParameterError` if the function cannot be imported by its name.
    """
    named = f"{getattr(quantity, '__module__', '')}:{getattr(quantity, '__qualname__', quantity)}"
    name = quantity if isinstance(quantity, str) else named
    if ":" not in name:
        return QUANTITIES[word("quantity", name, [*QUANTITIES, "module:function"])]
    try:
        found: Any = resolve_name(name)
        if not callable(found):
            reason = "it cannot be called"
        elif quantity in (found, name):
            return Quantity(name, found)
        else:
            reason = "another object has this name"
    except (Exception, SystemExit) as error:  # The module is the user's, and may raise any.
        reason = f"{type(error).__name__}, {error}"
    raise ParameterError("quantity", name, f"an importable function ({reason})")


def evaluate(name: str, base: Values, point: Values) -> Outcome:
    """The outcome of a quantity at one point of its axes, as plain data; an error is a message."""
    quantity = quantity_of(name)
    try:
        scenario, own = quantity.scenario({**base, **point})
        found = dict(quantity.function(_sharing_march(scenario), **own))
        values = {_column(key, point): _plain(key, value) for key, value in found.items()}
    except BaseException as error:
        kind = "" if isinstance(error, DragonError) else f"{type(error).__name__}: "
        return None, one_line(f"{kind}{error}")[:_MAX_MESSAGE]
    return values, None


def kind(cells: Sequence[Any]) -> list[Any]:
    """What cannot change continuously in values, and their error: whole numbers, or else texts."""
    if cells[-1] is not None:
        return ["failed"]
    whole = [each for each in cells if isinstance(each, int)]
    return whole or [each for each in cells if isinstance(each, str)]


def _sharing_march(scenario: Scenario) -> March:
    """The march of a scenario; equal motion has the continuation of this thread's march before.

    That has no result that depends on earlier calls.
    """
    march = scenario.march()
    key = march.curve, march.head_start, march.dragon.spacings.tolist()
    if getattr(_BEFORE, "key", None) == key:
        vars(march)["continuation"] = _BEFORE.continuation
    else:
        march.continuation.room = _ROOM
        _BEFORE.key = key
        _BEFORE.continuation = march.continuation
    return march


def _column(name: object, axes: Values) -> str:
    """The name of one of a quantity's values, if a column beside the axes can have it."""
    if isinstance(name, str) and name.isprintable() and name not in {"", "error", *axes}:
        return name
    bound = "printable, and that of no other column"
    raise ParameterError("a name of the quantity's values", name, bound)


def _plain(name: str, value: object) -> float | str | None:
    """A value of a parameter or of a quantity as a plain number, a text or None."""
    plain = value.item() if isinstance(value, np.generic) else value
    if isinstance(plain, str):
        return one_line(plain)
    if isinstance(plain, float | None) or (isinstance(plain, int) and abs(plain) < 2**63):
        return plain
    raise ParameterError(name, value, "a number of at most 64 bits, or a text")


def _benches(benches: tuple[int, int] | None) -> dict[str, int | None]:
    return dict(zip(("bench_a", "bench_b"), benches or (None, None), strict=True))


def contact_time(march: March, *, start: float = 0.0, until: float | None = None) -> Values:
    """Time of the first contact."""
    hit = first_contact(march, start=start, until=until)
    time = hit.time if hit.status == "contact" else None
    return {"contact_time": time, **_benches(hit.benches), "status": hit.status}


def _min_pitch(
    march: March, *, turns: float = 16.0, speed: float = 1.0, radius: float = 4.5
) -> Values:
    """Smallest pitch at which the head reaches the circle."""
    found = min_pitch(march.dragon, turns=turns, speed=speed, radius=radius)
    return {"min_pitch": found.pitch, **_benches(found.benches)}


def _max_speed(
    march: March, *, limit: float = 2.0, pitch: float = 1.7, radius: float = 4.5, ratio: float = 2.0
) -> Values:
    """Largest speed of the head in the U-turn."""
    found = max_speed(march.dragon, limit=limit, pitch=pitch, radius=radius, ratio=ratio)
    return {"max_speed": found.speed, "handle": found.handle, "speed_ratio": found.ratio}


# All quantities with a name of their own. Their values are in SI units.
_FUNCTIONS: Any = {"contact-time": contact_time, "min-pitch": _min_pitch, "max-speed": _max_speed}
QUANTITIES = {name: Quantity(name, function) for name, function in _FUNCTIONS.items()}
