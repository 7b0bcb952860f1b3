"""The axes of a sweep, and the values that a scenario has beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import product
from typing import Any

import numpy as np

from pymunk_dragon._checks import number, word
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.scenario import Scenario
from pymunk_dragon.sweeps.quantities import Quantity, Values

# Values of each axis.
Axes = Mapping[str, tuple[float, ...]]


def axes_of(given: Mapping[str, Sequence[float]] | None, parameters: Sequence[str]) -> Axes:
    """The axes of a sweep: parameters and their values."""
    if not isinstance(given, Mapping) or not given:
        raise ParameterError("axis", given, "a parameter and its values, or several of them")
    return {word("axis", name, parameters): _axis(name, values) for name, values in given.items()}


def _axis(name: str, values: Sequence[float]) -> tuple[float, ...]:
    """The values of an axis, which are all integers if all are whole numbers."""
    try:
        numbers = np.array(values, dtype=float).ravel()
    except (TypeError, ValueError):
        numbers = np.array([])
    if not numbers.size or not np.isfinite(numbers).all():
        raise ParameterError("axis", f"{name}={values}", "finite numbers, at least one")
    whole = numbers % 1 == 0
    # Larger doubles have no digits after the point.
    if np.all(whole & (np.abs(numbers) < 2**53)):
        numbers = numbers.astype(int)
    return tuple(numbers.tolist())


def given_values(
    scenario: Scenario | March | Mapping[str, Any] | None, axes: Axes
) -> dict[str, Any]:
    """Values of parameters of a scenario in any form."""
    if isinstance(scenario, March):
        scenario = Scenario.of(scenario)
    if isinstance(scenario, Scenario):
        values = scenario.values()
    else:
        values = Scenario.flat({} if scenario is None else scenario)
    if "start_s" in axes:
        values.pop("turns", None)
    return values


def base_values(quantity: Quantity, given: Values, axes: Axes) -> dict[str, Any]:
    """Complete values of parameters that are not axes.

    They are those at the first corner of the axes that is a scenario.
    """
    errors = []
    ends = [(min(values), max(values)) for values in axes.values()]
    for corner in product(*ends):
        at = dict(zip(axes, corner, strict=True))
        try:
            found = quantity.complete_values({**given, **at})
            return {name: value for name, value in found.items() if name not in axes}
        except ParameterError as error:
            errors.append(error)
    first = errors[0]
    if first.name in axes:
        raise ParameterError("axis", f"{first.name}={first.value}", first.bound)
    raise first


def reference_values(quantity: Quantity, given: Values, axes: Axes) -> dict[str, float]:
    """The scenario's own values of axes, or nan where it has none."""
    known = {}
    with suppress(ParameterError):  # It may be no scenario without the axes.
        known = quantity.complete_values(given)
    return {name: number(known.get(name)) for name in axes}


def varied(axes: Axes) -> list[str]:
    """Names of the axes with more than one value."""
    return [name for name, values in axes.items() if len(set(values)) > 1]
