"""Exact dynamics."""

from pymunk_dragon.dynamics.forces import joint_forces
from pymunk_dragon.dynamics.pull import pull

__all__ = ["joint_forces", "pull"]
