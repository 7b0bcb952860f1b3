"""The Pymunk engine: bodies, shapes and joints, path constraints, collision callbacks and the stepping loop."""

from pymunk_dragon.model.settings import EngineSettings
from pymunk_dragon.physics.guides import GUIDES, GuidedChain, PathGuide, Rails
from pymunk_dragon.physics.simulation import simulate
from pymunk_dragon.physics.world import World

__all__ = ["GUIDES", "EngineSettings", "GuidedChain", "PathGuide", "Rails", "World", "simulate"]
