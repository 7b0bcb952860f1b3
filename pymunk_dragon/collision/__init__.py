"""Which benches touch, and when: broad phase, narrow phase, first contact (paper, section 2.2)."""

from pymunk_dragon.collision.first_contact import FirstContact, first_contact
from pymunk_dragon.collision.grid import Grid
from pymunk_dragon.collision.near_misses import NearMiss
from pymunk_dragon.collision.sat import Separation, separation
from pymunk_dragon.collision.scan import scan

__all__ = ["FirstContact", "Grid", "NearMiss", "Separation", "first_contact", "scan", "separation"]
