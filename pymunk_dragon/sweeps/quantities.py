"""What a sweep computes at each of its points.

A quantity is a function of a march, or a study, that returns names and values. Its keyword-only parameters can be axes
beside those of a scenario.
"""

from __future__ import annotations

import hashlib
import re
import sys
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from importlib import import_module
from inspect import Parameter, getdoc, getsourcefile, signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pymunk_dragon._checks import word
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves import Curve
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.scenario import Scenario

if TYPE_CHECKING:
    from pymunk_dragon.model.march import March
    from pymunk_dragon.model.run import Run

Values = Mapping[str, Any]

# Parameters of a scenario that are numbers, and those of curves that are flags; and their types.
SCENARIO: Mapping[str, type] = {
    each.name: int if each.type == "int" else float
    for each in fields(Scenario)
    if re.match("int|float|Sizes|Speeds", str(each.type))
} | {name: float for curve in Curve.kinds.values() for name in curve.flags}
# What a quantity may be, in messages.
ALLOWED = "one of {}, or an importable function as module:function"


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """What a sweep computes.

    Attributes
    ----------
    name : str
        Name of the quantity, or `module:function`.
    summary : str
        What is computed, in one line.
    columns : tuple of str
        Names of its values; empty if they are known only from its results.
    parameters : mapping
        Parameters that can be axes, and their types.
    evaluate : callable
        Function of the values of these parameters, by name, that returns values by name.
    base : callable
        Function of a scenario's values that returns them complete and plain, or raises an error.
    """

    name: str
    summary: str
    columns: tuple[str, ...] = ()
    parameters: Mapping[str, type]
    evaluate: Callable[[Values], Values] = field(repr=False)
    base: Callable[[Values], dict[str, Any]] = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """Name and, for a user's function, a digest of the file that defines it."""
        if ":" not in self.name:
            return {"name": self.name}
        try:
            path = getsourcefile(_function(self.name))
        except TypeError:  # Such as a function of C, or an object that can be called.
            path = None
        digest = hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16] if path and Path(path).exists() else None
        return {"name": self.name, "source": digest}


def quantity_of(name: str) -> Quantity:
    """The quantity of a name: one of `QUANTITIES`, or the function `module:function` of a march.

    Raises
    ------
    ParameterError
        If there is none.
    """
    if ":" in name:
        return _of_march(name, _function(name))
    return QUANTITIES[word("quantity", name, [*QUANTITIES, "module:function"])]


def name_of(quantity: str | Callable[..., Any]) -> str:
    """The name of a quantity that is given as itself.

    Raises
    ------
    ParameterError
        If it is a function that other processes cannot import.
    """
    if isinstance(quantity, str):
        return quantity
    module, name = getattr(quantity, "__module__", None), getattr(quantity, "__qualname__", "")
    found: Any = sys.modules.get(str(module))
    for part in name.split("."):
        found = getattr(found, part, None)
    # Other processes import the main program from its file.
    is_importable = module != "__main__" or Path(getattr(found and sys.modules["__main__"], "__file__", "")).is_file()
    if found is None or found is not quantity or not is_importable:
        raise ParameterError("quantity", quantity, ALLOWED.format(", ".join(QUANTITIES)))
    return f"{module}:{name}"


def _function(name: str) -> Callable[..., Values]:
    """The function `module:function`."""
    module, _, path = name.partition(":")
    try:
        # A module of the user's.
        found: Any = import_module(module)
        for part in path.split("."):
            found = getattr(found, part)
    except (Exception, SystemExit) as error:  # The module may raise any.
        raise ParameterError("quantity", name, f"an importable function ({type(error).__name__}: {error})") from error
    if not callable(found):
        raise ParameterError("quantity", name, "a function")
    return found  # type: ignore[no-any-return]  # A function of a march, or its result says otherwise.


def _of_march(name: str, function: Callable[..., Values], columns: tuple[str, ...] = ()) -> Quantity:
    """The quantity that is a function of a march and of keyword-only parameters."""
    try:
        parameters = signature(function).parameters.values()
    except (ValueError, TypeError) as error:  # Such as a class of C.
        raise ParameterError("quantity", name, "a function of a march") from error
    own = {each.name: _type_of(each) for each in parameters if each.kind is Parameter.KEYWORD_ONLY}
    kept = threading.local()

    def evaluate(values: Values) -> Values:
        chosen = {each: value for each, value in values.items() if each in own}
        rest = {each: value for each, value in values.items() if each not in own}
        march = Scenario.from_dict(rest, files=False).march()
        # Points that differ in width only, for example, have the same states.
        previous, kept.march = getattr(kept, "march", None), None
        if previous is not None:
            march.share_states(previous)
        found = function(march, **chosen)
        # Not after an exception: the time limit may have stopped the computation of the states.
        kept.march = march
        return found

    def base(values: Values) -> dict[str, Any]:
        rest = {each: value for each, value in values.items() if each not in own}
        return Scenario.from_dict(rest).values() | {each: _plain(each, values[each]) for each in own if each in values}

    summary = (getdoc(function) or name).partition("\n")[0].rstrip(".")
    return Quantity(
        name=name, summary=summary, columns=columns, parameters={**SCENARIO, **own}, evaluate=evaluate, base=base
    )


def _type_of(parameter: Parameter) -> type:
    """The type of a parameter's values: the annotated one or, if there is none, that of the default."""
    numbers = re.findall(r"\b(?:int|float)\b", str(parameter.annotation)) or [type(parameter.default).__name__]
    return int if {"int", "bool"}.issuperset(numbers) else float


def _plain(name: str, value: object) -> object:
    """A value that is the same for all points, as it is written to a journal."""
    plain = value.item() if isinstance(value, np.generic) else value
    if not isinstance(plain, bool | int | float | str | None):
        raise ParameterError(name, value, "a number or a text")
    return plain


def _of_study(name: str, columns: tuple[str, ...], values_of: Callable[[Any], Values]) -> Quantity:
    """The quantity that consists of values of a study's result."""
    from pymunk_dragon.studies import STUDIES, study

    parameters = {each: SCENARIO.get(each, float) for each in STUDIES[name].parameters}

    def base(values: Values) -> dict[str, Any]:
        for each, value in values.items():
            if each not in parameters and each not in Scenario.__dataclass_fields__:
                raise ParameterError(each, value, "absent: the parameters are " + ", ".join(parameters))
        sizes = {each: values[each] for each in parameters if each in values and each in Dragon.__dataclass_fields__}
        rest = {each: _plain(each, values[each]) for each in parameters if each in values and each not in sizes}
        dragon = Dragon(**sizes)
        return {each: getattr(dragon, each) for each in sizes} | rest

    def evaluate(values: Values) -> Values:
        return values_of(study(name, values))

    summary = STUDIES[name].summary.partition(" (")[0]
    summary = summary[0].upper() + summary[1:]
    return Quantity(name=name, summary=summary, columns=columns, parameters=parameters, evaluate=evaluate, base=base)


def _benches(benches: tuple[int, int] | None) -> dict[str, int | None]:
    first, second = benches or (None, None)
    return {"bench_a": first, "bench_b": second}


def contact_time(march: March, *, start: float = 0.0, until: float | None = None) -> Values:
    """Time of the first contact.

    In s, with its benches and the status of the search.
    """
    from pymunk_dragon.collision import first_contact

    hit = first_contact(march, start=start, until=until)
    time = hit.time if hit.status == "contact" else None
    return {"contact_time": time, **_benches(hit.benches), "status": hit.status}


def nearest_gap(march: March, *, start: float = 0.0, until: float | None = None) -> Values:
    """Gap of the nearest miss before the first contact.

    In m, with its time in s and its benches.
    """
    from pymunk_dragon.collision import first_contact

    hit = first_contact(march, start=start, until=until)
    nearest = min(hit.near_misses or (), key=lambda miss: miss.gap, default=None)
    if nearest is None:
        return {"nearest_gap": None, "time": None, **_benches(None), "status": hit.status}
    return {"nearest_gap": nearest.gap, "time": nearest.time, **_benches(nearest.benches), "status": hit.status}


def _played(march: March, start: float, until: float | None, substep: float | None, iterations: int | None) -> Run:
    from pymunk_dragon.physics import simulate

    return simulate(march, start=start, until=until, substep=substep, iterations=iterations)


def engine_contact_time(
    march: March,
    *,
    start: float = 0.0,
    until: float | None = None,
    substep: float | None = None,
    iterations: int | None = None,
) -> Values:
    """Time of the first contact in Pymunk.

    In s, with its benches and the outcome of the run.
    """
    run = _played(march, start, until, substep, iterations)
    time, benches = (run.first_contact.time, run.first_contact.benches) if run.first_contact else (None, None)
    return {"engine_contact_time": time, **_benches(benches), "status": run.outcome}


def engine_error(
    march: March,
    *,
    start: float = 0.0,
    until: float | None = None,
    substep: float | None = None,
    iterations: int | None = None,
) -> Values:
    """Error of the time of the first contact in Pymunk.

    In s, with position errors in m.
    """
    from pymunk_dragon.collision import first_contact

    run = _played(march, start, until, substep, iterations)
    exact = first_contact(march, start=start, until=until).contact
    error = run.first_contact.time - exact.time if run.first_contact and exact else None
    return {"time_error": error, "head_drift": run.head_drift, "max_drift": run.max_drift, "status": run.outcome}


CONTACT = ("bench_a", "bench_b", "status")
# All quantities with a name of their own.
QUANTITIES: Mapping[str, Quantity] = {
    quantity.name: quantity
    for quantity in (
        _of_march("contact-time", contact_time, ("contact_time", *CONTACT)),
        _of_march("nearest-gap", nearest_gap, ("nearest_gap", "time", *CONTACT)),
        _of_study(
            "min-pitch",
            ("min_pitch", "bench_a", "bench_b", "limit"),
            lambda found: {"min_pitch": found.pitch, **_benches(found.benches), "limit": found.limit},
        ),
        _of_study(
            "max-speed",
            ("max_speed", "handle", "speed_ratio"),
            lambda found: {"max_speed": found.speed, "handle": found.handle, "speed_ratio": found.ratio},
        ),
        _of_march("engine-contact-time", engine_contact_time, ("engine_contact_time", *CONTACT)),
        _of_march("engine-error", engine_error, ("time_error", "head_drift", "max_drift", "status")),
    )
}
