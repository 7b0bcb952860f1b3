"""What a dragon marches on."""

from pymunk_dragon.curves.base import Curve
from pymunk_dragon.curves.spiral import Spiral

__all__ = ["Curve", "Spiral"]
