"""A bench dragon coils inward until it runs into itself: Pymunk plays it, an exact model checks it."""

from __future__ import annotations

__version__ = "0.1.0"

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from pymunk_dragon.collision import FirstContact, Grid, NearMiss, Separation, first_contact, scan, separation
    from pymunk_dragon.drawing import Camera, Film, Palette, render, write_film
    from pymunk_dragon.drawing.debug_draw import PillowDrawOptions
    from pymunk_dragon.errors import (
        DragonError,
        FileFormatError,
        MissingExtraError,
        OutputError,
        ParameterError,
        UnreachableError,
    )
    from pymunk_dragon.model.contact import Contact, ContactEvent, ContactLog
    from pymunk_dragon.model.curves import (
        Arc,
        Composite,
        Curve,
        Line,
        Reversed,
        Sampled,
        Section,
        Spiral,
        UTurn,
        check_curve,
    )
    from pymunk_dragon.model.dragon import Dragon, outlines
    from pymunk_dragon.model.march import March, States
    from pymunk_dragon.model.run import Run, check_saveable
    from pymunk_dragon.model.scenario import Scenario
    from pymunk_dragon.model.speed import SpeedTable
    from pymunk_dragon.physics import EngineSettings, PathGuide, World, simulate
    from pymunk_dragon.player import player_page, write_player
    from pymunk_dragon.reports import report
    from pymunk_dragon.sessions import live
    from pymunk_dragon.studies import max_speed, min_pitch, sensitivity, u_turn
    from pymunk_dragon.sweeps import Sweep, sweep

__all__ = [
    "Arc", "Camera", "Composite", "Contact", "ContactEvent", "ContactLog", "Curve", "Dragon", "DragonError",
    "EngineSettings", "FileFormatError", "Film", "FirstContact", "Grid", "Line", "March", "MissingExtraError",
    "NearMiss", "OutputError", "Palette", "ParameterError", "PathGuide", "PillowDrawOptions", "Reversed", "Run",
    "Sampled", "Scenario", "Section", "Separation", "SpeedTable", "Spiral", "States", "Sweep", "UTurn",
    "UnreachableError", "World", "check_curve", "check_saveable", "first_contact", "live", "max_speed",
    "min_pitch", "outlines", "player_page", "render", "report", "scan", "sensitivity", "separation", "simulate",
    "sweep", "u_turn", "write_film", "write_player",
]  # fmt: skip

# Names are loaded when they are first used: NumPy, Pymunk and Pillow together take longer to import than
# `pymunk-dragon --help` may take to answer. `drawing` does not import its `debug_draw`, which needs Pymunk.
_MODULES = {
    "collision": "FirstContact Grid NearMiss Separation first_contact scan separation",
    "drawing": "Camera Film Palette render write_film",
    "drawing.debug_draw": "PillowDrawOptions",
    "errors": "DragonError FileFormatError MissingExtraError OutputError ParameterError UnreachableError",
    "model.contact": "Contact ContactEvent ContactLog",
    "model.curves": "Arc Composite Curve Line Reversed Sampled Section Spiral UTurn check_curve",
    "model.dragon": "Dragon outlines",
    "model.march": "March States",
    "model.run": "Run check_saveable",
    "model.scenario": "Scenario",
    "model.speed": "SpeedTable",
    "physics": "EngineSettings PathGuide World simulate",
    "player": "player_page write_player",
    "reports": "report",
    "sessions": "live",
    "studies": "max_speed min_pitch sensitivity u_turn",
    "sweeps": "Sweep sweep",
}


def __getattr__(name: str) -> Any:
    from importlib import import_module

    # This package is above all those that it imports by name.
    for module, names in _MODULES.items():
        if name in names.split():
            return getattr(import_module(f"pymunk_dragon.{module}"), name)
    raise AttributeError(f"module 'pymunk_dragon' has no attribute '{name}'")


def __dir__() -> list[str]:
    return __all__
