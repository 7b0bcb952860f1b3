"""What a dragon marches on."""

from pymunk_dragon.model.curves.arc import Arc
from pymunk_dragon.model.curves.base import Curve, frame
from pymunk_dragon.model.curves.chain import chain, foot
from pymunk_dragon.model.curves.composite import Composite
from pymunk_dragon.model.curves.line import Line
from pymunk_dragon.model.curves.reversed import Reversed
from pymunk_dragon.model.curves.sampled import Sampled
from pymunk_dragon.model.curves.section import Section
from pymunk_dragon.model.curves.spiral import Spiral
from pymunk_dragon.model.curves.tables import KINDS, from_table, to_table
from pymunk_dragon.model.curves.u_turn import UTurn

__all__ = [
    "KINDS",
    "Arc",
    "Composite",
    "Curve",
    "Line",
    "Reversed",
    "Sampled",
    "Section",
    "Spiral",
    "UTurn",
    "chain",
    "foot",
    "frame",
    "from_table",
    "to_table",
]
