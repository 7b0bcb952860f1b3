"""Scenarios: what a user chooses, by flags or in a TOML file, and from which the march is made.

Every command takes a dragon, a curve and a speed as flags, or as a file (`--scenario FILE.toml`;
flags win). In a file, sizes may be lists with one value for each bench, the speed a table or the
name of a CSV file, and the curve a path through points or their CSV file:

```toml
# tractor.toml
head_spacing = 2.6
body_spacing = [4.5, 3.0, 6.0]
overhang = [0.6, 0.5, 0.4, 0.7]
width = [1.8, 2.2, 1.6, 2.4]
speed = [[0, 0.5], [5, 2.0], [20, 1.5]]  # at which second how many m/s
# m
points = [[-30, 0], [-10, 0], [6, 2], [13, 12], [8, 22], [-4, 22], [-9, 12], [-8, 0], [-8, -20]]
```

```console
$ pymunk-dragon contact --scenario tractor.toml
```

Any curve is a table with its kind and its parameters, and the dragon may be one. This curve is
`Composite([Line(...), Arc(...), Line(...)])` in Python:

```toml
# hairpin.toml
[dragon]
benches = 12
[curve]
kind = "composite"
[[curve.pieces]]
kind = "line"
stop = [30, 0]
[[curve.pieces]]
kind = "arc"
centre = [30, 3]
radius = 3
begin_angle = -1.5707963267948966
sweep = 3.141592653589793
[[curve.pieces]]
kind = "line"
start = [30, 6]
stop = [0, 6]
```

```console
$ pymunk-dragon contact --scenario hairpin.toml
```
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from pymunk_dragon._checks import flag, instance, label, numbers
from pymunk_dragon._files import read_text
from pymunk_dragon.errors import FileFormatError, ParameterError
from pymunk_dragon.model.curves import Curve, Sampled
from pymunk_dragon.model.curves.base import parameters_of
from pymunk_dragon.model.dragon import Dragon
from pymunk_dragon.model.march import March, check_march
from pymunk_dragon.model.speed import SpeedTable

# A key such as a.b.c of so many parts that tomllib, whose time grows with their square, would take
# minutes.
_LONG_KEY = re.compile(r"""(?<![\w-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){20}""")
# What a file of points or of speeds is called.
_CSV = ".csv"
# Names of the dragon's parameters: in the table `dragon` of a file, or at its top level.
_DRAGON = tuple(f.name for f in fields(Dragon))
# Kind of the curve of a scenario that names none.
_DEFAULT_CURVE = "spiral"
# Parameters of curves that may stand at the top level of a file, beside the name of the curve.
_SHORT = ("pitch", "rotation", "outward", "radius", "ratio", "points")


@dataclass(frozen=True, init=False)
class Scenario:
    """A dragon on a curve, as plain values.

    A parameter that is not given has the paper's value, or the curve's default.

    Parameters
    ----------
    benches : int
        Number of benches, as of a `Dragon`; so are the next four.
    head_spacing : float
    body_spacing : float or sequence of float
    overhang : float or sequence of float
    width : float or sequence of float
    turns : float
        Where the march starts, as of a `March`; so is `start_s`.
    start_s : float
    curve : str, Curve or mapping
        "spiral", "u-turn", "sampled" for a `Sampled` path through `points`, or a CSV file of these
        points. Any other registered curve is given as itself or as a table,
        ``{kind = "line", start = [0, 0], stop = [40, 0]}`` in TOML; the tables of a `Composite` are
        its ``pieces``.
    pitch : float
        Of a `Spiral` or a `UTurn`.
    rotation : float
        Of a `Spiral`.
    outward : bool
        Of a `Spiral`.
    radius : float
        Of a `UTurn`.
    ratio : float
        Of a `UTurn`.
    points : array_like
        Of a `Sampled` path.
    speed : float, sequence of (float, float) or str
        In m/s, as in `March`, or a table of times in s and speeds in m/s, or a CSV file of it.

    Examples
    --------
    >>> Scenario(pitch=0.45, turns=20).march().curve.pitch
    0.45
    """

    _march: March

    def __init__(self, **values: Any) -> None:
        known = parameters()
        for name, value in values.items():
            if name not in known:
                raise ParameterError(name, value, f"absent; known are {', '.join(known)}")
        dragon = Dragon(**{name: values[name] for name in _DRAGON if name in values})
        speed = values.get("speed", 1.0)
        if _is_file(speed):
            speed = SpeedTable.read(speed)
        elif isinstance(speed, list | tuple):
            speed = SpeedTable(*numbers("speed", speed, len(speed), 2).T)
        start = {name: values.get(name) for name in ("turns", "start_s")}

        # The other values are parameters of the curve.
        given = {name: value for name, value in values.items() if value is not None}
        for name in (*_DRAGON, *start, "curve", "speed"):
            given.pop(name, None)
        curve = _curve(values.get("curve"), given)
        vars(self)["_march"] = March(dragon, curve, **start, speed=speed)

    @classmethod
    def of(cls, march: March) -> Scenario:
        """Scenario of a march; an error if its curve is of a class of your own without a kind."""
        check_march(march)
        return cls.from_dict(_tables(march))

    @classmethod
    def from_dict(cls, values: Mapping[str, Any], *, files: bool = True) -> Scenario:
        """Scenario from the names of all parameters, or from tables `dragon` and `curve`.

        `to_dict` returns such tables. Parameters at the top level have precedence. `files` is
        whether a curve or a speed may be the name of a file.

        Examples
        --------
        >>> tables = {"dragon": {"benches": 5}, "curve": {"kind": "u-turn", "ratio": 3}}
        >>> Scenario.from_dict(tables).values()["radius"]
        4.5
        """
        flag("files", files)
        flat = Scenario.flat(values)
        for name, value in {} if files else flat.items():
            if _is_file(value):
                raise ParameterError(name, value, "something else than the name of another file")
        return cls(**flat)

    @classmethod
    def read(cls, path: str | Path) -> dict[str, Any]:
        """Names and values in a TOML file, for `from_dict`; a file that it names lies beside it."""
        import tomllib

        content = read_text(path, "scenario")
        try:
            if _LONG_KEY.search(content):
                raise ValueError("a key has more parts than that of any parameter")
            nested = tomllib.loads(content)
        except (ValueError, RecursionError) as error:
            # Also of thousands of digits, or of nested brackets.
            raise FileFormatError(path, f"no TOML file: {error}") from error
        values = Scenario.flat(nested)
        files = [name for name in ("curve", "speed") if _is_file(values.get(name))]
        return values | {name: str(Path(path).parent / values[name]) for name in files}

    def march(self) -> March:
        """The march that these values describe."""
        return self._march

    def to_dict(self) -> dict[str, Any]:
        """Nested tables of plain values, of which `from_dict` makes the same scenario."""
        return _tables(self._march)

    def values(self) -> dict[str, Any]:
        """Values by the names of all parameters, without those that the curve does not have."""
        return Scenario.flat(self.to_dict())

    @staticmethod
    def flat(values: Mapping[str, Any]) -> dict[str, Any]:
        """Values by the names of the parameters of a `Scenario`, from nested tables or values."""
        instance("scenario", values, Mapping, "a mapping of names and values")
        for name in values:
            label("name of a value", name)
        flat = {name: value for name, value in values.items() if name != "dragon"}
        dragon = values.get("dragon", {})
        instance("dragon", dragon, Mapping, "a table with parameters of the dragon")
        for name, value in dragon.items():
            if name not in _DRAGON:
                bound = f"absent; known are {', '.join(_DRAGON)}"
                raise ParameterError(f"dragon.{name}", value, bound)

        # Parameters of the curve move to the top level if all of them may stand there.
        curve = flat.get("curve")
        if isinstance(curve, Mapping) and set(curve) <= {"kind", *_SHORT}:
            parameters = dict(curve)
            kind = parameters.pop("kind", None)
            if isinstance(kind, str) and not _is_file(kind):
                return {**dragon, **parameters, **flat, "curve": kind}
        return {**dragon, **flat}


def parameters() -> list[str]:
    """Names of all parameters of a `Scenario`, with those of curves of your own that are flags."""
    flags = [flag for kind in Curve.kinds.values() for flag in kind.flags]
    names = (*_DRAGON, "curve", *_SHORT, *flags, "turns", "start_s", "speed")
    return [*dict.fromkeys(names)]


def named_curves() -> list[str]:
    """Kinds of curves whose parameters all have defaults, the default kind first."""
    kinds = Curve.kinds.items()
    named = [kind for kind, cls in kinds if not any(parameters_of(cls).values())]
    return sorted(named, key=lambda kind: kind != _DEFAULT_CURVE)


def _tables(march: March) -> dict[str, Any]:
    """Tables of a march, as `Scenario.to_dict` returns them."""
    tables: dict[str, Any] = {"dragon": asdict(march.dragon), "curve": march.curve.to_dict()}
    for name in ("turns", "start_s"):
        if getattr(march, name) is not None:
            tables[name] = getattr(march, name)
    speed: Any = march.speed
    if isinstance(speed, SpeedTable):
        speed = tuple(zip(speed.times, speed.speeds, strict=True))
    return tables | {"speed": speed}


def _curve(curve: Any, given: Mapping[str, Any]) -> Curve:
    """The curve of a name, a file, a table or a curve, and of parameters given beside it."""
    for name, value in given.items():
        if isinstance(curve, Curve) or (name == "points" and _is_file(curve)):
            bound = "absent where the curve is one already, or a file of points"
            raise ParameterError(name, value, bound)
    if isinstance(curve, Curve):
        return curve
    if isinstance(curve, Mapping):
        table = {**curve, **given}
    elif _is_file(curve):
        table = {"kind": "sampled", **given, "points": Sampled.read(curve).points}
    elif curve is None:
        table = {"kind": "sampled" if "points" in given else _DEFAULT_CURVE, **given}
    elif isinstance(curve, str) and curve in Curve.kinds:
        table = {"kind": curve, **given}
    else:
        names = " or ".join(named_curves())
        file = f"a file of points, which ends in {_CSV}"
        raise ParameterError("curve", curve, f"a name, {names}, {file}, or a table with its kind")

    try:
        return Curve.from_dict(table)
    except ParameterError as error:
        short = error.name.removeprefix("curve.")
        name = error.name if isinstance(curve, Mapping) and short not in given else short
        raise ParameterError(name, error.value, error.bound) from error


def _is_file(value: object) -> bool:
    return isinstance(value, str | Path) and Path(value).suffix.lower() == _CSV
