"""What a sweep consists of: the quantity, the axes, and all other values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.march import March
from pymunk_dragon.model.scenario import Scenario, flat_values
from pymunk_dragon.sweeps.axes import Axes, Point, Sampling, axes_of
from pymunk_dragon.sweeps.evaluation import Task, program_version
from pymunk_dragon.sweeps.quantities import Quantity, Values, name_of, quantity_of

# Version of the lines of a journal.
JOURNAL_VERSION = 1


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What determines all outcomes of a sweep: `base` has the values of parameters that are not axes.

    `reference` has the scenario's values of parameters that are axes.
    """

    quantity: Quantity
    axes: Axes
    base: Mapping[str, Any]
    reference: Mapping[str, float]

    @classmethod
    def of(
        cls,
        scenario: Scenario | March | Mapping[str, Any] | None,
        axes: Mapping[str, Sequence[float]],
        quantity: str | Callable[..., Values],
        samples: int | None,
        seed: int,
        sampling: Sampling,
    ) -> Plan:
        """The plan of the arguments of `sweep`.

        Raises
        ------
        ParameterError, FileFormatError, MissingExtraError
            As `sweep` does.
        """
        chosen = quantity_of(name_of(quantity))
        points = axes_of(axes, chosen.parameters, samples, seed, sampling)
        if isinstance(scenario, March):
            scenario = Scenario.of(scenario)
        if not isinstance(scenario, Scenario | Mapping | None):
            raise ParameterError("scenario", scenario, "a Scenario, a March, or a mapping of their values")
        given = scenario.values() if isinstance(scenario, Scenario) else flat_values(scenario or {})
        if "start_s" in points.names:
            given.pop("turns", None)
        base = _base(chosen, given, points)
        reference = {name: value for name, value in _reference(given).items() if name in points.names}
        return cls(quantity=chosen, axes=points, base=base, reference=reference)

    @property
    def integers(self) -> frozenset[str]:
        """Axes with whole numbers."""
        return frozenset(name for name in self.axes.names if self.quantity.parameters[name] is int)

    def task(self, timeout: float | None) -> Task:
        """What workers need beside the points."""
        return Task(
            version=program_version(),
            quantity=self.quantity.name,
            base=self.base,
            names=self.axes.names,
            timeout=timeout,
        )

    def to_dict(self, refine: int) -> dict[str, Any]:
        """Plain values that determine all outcomes, for the journal."""
        return {
            "journal": JOURNAL_VERSION,
            "version": program_version(),
            "quantity": self.quantity.to_dict(),
            "scenario": dict(self.base),
            "axis": self.axes.to_dict(),
            "refine": refine,
        }


class Points:
    """The points of a sweep by their numbers: those of the axes, and then those of a refinement."""

    def __init__(self, axes: Axes) -> None:
        self._axes = axes
        self._count = len(axes)
        self._new: list[Point] = []

    def __len__(self) -> int:
        return self._count + len(self._new)

    def __getitem__(self, index: int) -> Point:
        return self._axes[index] if index < self._count else self._new[index - self._count]

    def extend(self, points: Iterable[Point]) -> None:
        """Add points."""
        self._new.extend(points)


def _base(quantity: Quantity, given: Mapping[str, Any], axes: Axes) -> dict[str, Any]:
    """Complete and plain values of the parameters that are not axes, from a corner of the axes that is a scenario."""
    first: ParameterError | None = None
    for corner in axes.corners():
        try:
            found = quantity.base({**given, **dict(zip(axes.names, corner, strict=True))})
        except ParameterError as error:
            on_axis = error.name in axes.names
            first = first or (ParameterError("axis", f"{error.name}={error.value}", error.bound) if on_axis else error)
        else:
            return {name: value for name, value in found.items() if name not in axes.names}
    assert first is not None  # There is at least one corner, and each failed.
    raise first


def _reference(given: Mapping[str, Any]) -> dict[str, float]:
    """The numbers of the scenario without the axes, if it is one."""
    try:
        values = Scenario.from_dict(given).values()
    except ParameterError:
        values = dict(given)
    return {name: float(value) for name, value in values.items() if isinstance(value, int | float)}
