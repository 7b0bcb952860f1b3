"""Speed profiles of the head: a number, a table over time, or a function of time."""

from __future__ import annotations

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.model.speed.base import MAX_SPEED, MIN_SPEED, ConstantSpeed, OwnSpeed, Speed
from pymunk_dragon.model.speed.table import SpeedTable

__all__ = ["MAX_SPEED", "MIN_SPEED", "ConstantSpeed", "Speed", "SpeedTable", "speed_of"]


def speed_of(value: object) -> Speed:
    """`value` as a `Speed`: a number in m/s, a `SpeedTable`, a function from s to m/s, or what is a `Speed` already.

    Raises
    ------
    ParameterError
        If it is none of them, or a number that is not from 1e-6 to 20 m/s.
    """
    if isinstance(value, type):
        raise ParameterError("speed", value, "an object with the members of Speed, not a class")
    if isinstance(value, Speed):
        return value if type(value).__module__.startswith(__name__) else OwnSpeed(value)
    if callable(value):
        # Imported only here, with NumPy's polynomials: few marches have such a speed.
        from pymunk_dragon.model.speed.function import SpeedFunction

        return SpeedFunction(value)
    return ConstantSpeed(value)  # type: ignore[arg-type]  # ConstantSpeed refuses what is no number.
