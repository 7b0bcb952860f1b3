"""What a dragon marches on."""

from pymunk_dragon.curves.base import Curve
from pymunk_dragon.curves.chain import chain, foot
from pymunk_dragon.curves.reversed import Reversed
from pymunk_dragon.curves.spiral import Spiral

__all__ = ["Curve", "Reversed", "Spiral", "chain", "foot"]
