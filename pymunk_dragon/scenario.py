"""What a user chooses, from flags or a TOML file; makes the march."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from pymunk_dragon.curves import Spiral
from pymunk_dragon.dragon import Dragon
from pymunk_dragon.errors import DragonError, FileFormatError, ParameterError
from pymunk_dragon.march import March

__all__ = ["Scenario"]


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """A dragon on a spiral, as plain numbers; the defaults are the paper's.

    Parameters
    ----------
    benches, head_spacing, body_spacing, overhang, width
        As in `Dragon`: a count, then m.
    pitch : float
        As in `Spiral`, m.
    turns, speed : float
        As in `March`: turns, m/s.

    Raises
    ------
    ParameterError
        If `march` cannot be made of it.
    """

    benches: int = 223
    head_spacing: float = 2.86
    body_spacing: float = 1.65
    overhang: float = 0.275
    width: float = 0.30
    pitch: float = 0.55
    turns: float = 16.0
    speed: float = 1.0

    def __post_init__(self) -> None:
        for name, value in _numbers(self.march()).items():
            object.__setattr__(self, name, value)

    @classmethod
    def from_mapping(cls, values: Mapping[str, Any]) -> Scenario:
        """Scenario from names and values; what is not named keeps its default."""
        known = [f.name for f in fields(cls)]
        for name, value in values.items():
            if name not in known:
                raise ParameterError(name, value, "absent: the parameters are " + ", ".join(known))
        return cls(**values)

    @classmethod
    def read(cls, path: str | Path) -> dict[str, Any]:
        """Names and values in a TOML file of a scenario, checked by `from_mapping` once flags are laid over them.

        Raises
        ------
        ParameterError
            If the file cannot be read.
        FileFormatError
            If it is no TOML.
        """
        try:
            return tomllib.loads(Path(path).read_text(encoding="utf-8"))
        except OSError as error:
            raise ParameterError("scenario", str(path), f"a readable file ({error.strerror})") from error
        except (ValueError, RecursionError) as error:
            # Beside its own error, tomllib lets through those of a wrong encoding, a number of thousands of digits and
            # brackets in thousands of brackets.
            raise FileFormatError(path, f"no TOML file: {error}") from error

    @classmethod
    def of(cls, march: March) -> Scenario:
        """The scenario of a march on a spiral."""
        return cls(**_numbers(march))

    def march(self) -> March:
        """The march that these numbers describe."""
        dragon = Dragon(
            benches=self.benches,
            head_spacing=self.head_spacing,
            body_spacing=self.body_spacing,
            overhang=self.overhang,
            width=self.width,
        )
        return March(dragon, Spiral(pitch=self.pitch), turns=self.turns, speed=self.speed)


def _numbers(march: March) -> dict[str, Any]:
    if not isinstance(march.curve, Spiral):
        raise DragonError(f"a scenario describes a march on a Spiral, not on a {type(march.curve).__name__}")
    return asdict(march.dragon) | {"pitch": march.curve.pitch, "turns": march.turns, "speed": march.speed}
