"""Scenes that are shown live: the dragon, and any Pymunk space."""

from __future__ import annotations

from pymunk_dragon.sessions.scenes.base import Parameter, Scene
from pymunk_dragon.sessions.scenes.dragon import DragonScene
from pymunk_dragon.sessions.scenes.ready import SCENES, Ready, dragon, planned, ready

__all__ = ["SCENES", "DragonScene", "Parameter", "Ready", "Scene", "dragon", "planned", "ready"]
