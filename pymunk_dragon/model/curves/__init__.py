"""Curves on which a dragon marches: one module per kind."""

from pymunk_dragon.model.curves.arc import Arc
from pymunk_dragon.model.curves.base import Curve
from pymunk_dragon.model.curves.composite import Composite
from pymunk_dragon.model.curves.line import Line
from pymunk_dragon.model.curves.reversed import Reversed
from pymunk_dragon.model.curves.section import Section
from pymunk_dragon.model.curves.spiral import Spiral
from pymunk_dragon.model.curves.spline import Sampled
from pymunk_dragon.model.curves.u_turn import UTurn

__all__ = ["Arc", "Composite", "Curve", "Line", "Reversed", "Sampled", "Section", "Spiral", "UTurn"]
