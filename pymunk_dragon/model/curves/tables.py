"""Curves as tables of plain values: the form that scenario files and saved runs share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import Any

import numpy as np

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.curves.arc import Arc
from pymunk_dragon.model.curves.base import Curve
from pymunk_dragon.model.curves.composite import Composite
from pymunk_dragon.model.curves.line import Line
from pymunk_dragon.model.curves.reversed import Reversed
from pymunk_dragon.model.curves.sampled import Sampled
from pymunk_dragon.model.curves.section import Section
from pymunk_dragon.model.curves.spiral import Spiral
from pymunk_dragon.model.curves.u_turn import UTurn

__all__ = ["KINDS", "from_table", "to_table"]

# Each class is a dataclass whose `init` fields hold plain values, curves or sequences of curves. A new curve needs an
# entry here and nothing else to be saved and read.
KINDS: dict[str, type[Any]] = {
    "arc": Arc,
    "composite": Composite,
    "line": Line,
    "reversed": Reversed,
    "sampled": Sampled,
    "section": Section,
    "spiral": Spiral,
    "u-turn": UTurn,
}
# Levels of curves inside curves. A level takes up to 4 of Python's 1000 nested calls in an evaluation.
MAX_DEPTH = 32


def to_table(curve: Curve) -> dict[str, Any]:
    """Table that describes a curve; `from_table` makes an equal curve of it.

    Parameters
    ----------
    curve : Curve
        A curve of the package. The class has to match exactly: a derived class may override anything.

    Returns
    -------
    dict
        The `kind` and the parameters: numbers, lists, and tables for the curves inside.

    Raises
    ------
    ParameterError
        If the curve, or a curve inside it, is of another class, or more than 32 levels are nested.

    Examples
    --------
    >>> from pymunk_dragon.model.curves import Arc, Reversed
    >>> to_table(Reversed(Arc(radius=2, sweep=1)))["curve"]
    {'kind': 'arc', 'centre': [0.0, 0.0], 'radius': 2.0, 'begin_angle': 0.0, 'sweep': 1.0}
    """
    return _table(curve, "curve", 1)


def from_table(table: Mapping[str, Any]) -> Curve:
    """Curve that a table describes.

    Parameters
    ----------
    table : mapping
        The `kind` of the curve and the parameters of its class. A parameter that is a curve is a table as well.

    Raises
    ------
    ParameterError
        If the kind is unknown, a parameter is missing, unknown or refused by the class, or more than 32 levels are
        nested. The error names the path to the parameter, as in ``curve.pieces[1].radius``.

    Examples
    --------
    >>> from_table({"kind": "line", "stop": [3, 4]})
    Line(start=(0.0, 0.0), stop=(3.0, 4.0))
    """
    return _curve(table, "curve", 1)


def _table(curve: Any, where: str, depth: int) -> dict[str, Any]:
    kind = next((kind for kind, made in KINDS.items() if made is type(curve)), None)
    if kind is None:
        bound = f"a curve of the package ({', '.join(KINDS)}) to be written down: a class of your own has no table"
        raise ParameterError(where, type(curve).__name__, bound)
    _check_depth(type(curve).__name__, depth)

    def plain(value: Any, where: str) -> Any:
        if isinstance(value, Curve):
            return _table(value, where, depth + 1)
        if isinstance(value, tuple):
            return [plain(item, f"{where}[{i}]") for i, item in enumerate(value)]
        return value.tolist() if isinstance(value, np.ndarray) else value

    return {"kind": kind} | {name: plain(getattr(curve, name), f"{where}.{name}") for name in _parameters(kind)}


def _curve(table: Mapping[str, Any], where: str, depth: int) -> Curve:
    _check_depth(table, depth)
    given = dict(table)
    kind = given.pop("kind", None)
    if not (isinstance(kind, str) and kind in KINDS):
        raise ParameterError(f"{where}.kind", kind, "one of " + ", ".join(KINDS))
    parameters = _parameters(kind)
    for name, value in given.items():
        if name not in parameters:
            raise ParameterError(f"{where}.{name}", value, f"absent: the parameters are {', '.join(parameters)}")
    for name, required in parameters.items():
        if required and name not in given:
            raise ParameterError(f"{where}.{name}", None, f"given: the kind {kind} has no default for it")

    def made(value: Any, where: str) -> Any:
        if isinstance(value, Mapping):
            return _curve(value, where, depth + 1)
        if isinstance(value, list | tuple) and any(isinstance(item, Mapping) for item in value):
            return [made(item, f"{where}[{i}]") for i, item in enumerate(value)]
        return value

    values = {name: made(value, f"{where}.{name}") for name, value in given.items()}
    try:
        curve: Curve = KINDS[kind](**values)
    except ParameterError as error:
        raise ParameterError(f"{where}.{error.name}", error.value, error.bound) from error
    return curve


def _parameters(kind: str) -> dict[str, bool]:
    """Names of the parameters of a kind, and whether each is required."""
    return {f.name: f.default is MISSING for f in fields(KINDS[kind]) if f.init}


def _check_depth(value: object, depth: int) -> None:
    if depth > MAX_DEPTH:
        raise ParameterError("curve", value, f"nested in at most {MAX_DEPTH - 1} other curves")
