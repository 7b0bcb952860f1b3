"""The Pymunk side: bodies, shapes and joints, dancers on rails, collision callbacks and the stepping loop."""

from pymunk_dragon.physics.guides import Guide
from pymunk_dragon.physics.simulation import simulate
from pymunk_dragon.physics.world import World

__all__ = ["Guide", "World", "simulate"]
