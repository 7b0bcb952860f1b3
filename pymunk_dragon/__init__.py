"""A bench dragon coils inward until it runs into itself, in Pymunk and in an exact model."""

# ruff: noqa: F403  # For type checkers only; `__all__` has the names.

from __future__ import annotations

import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

# Names are loaded when they are first used: NumPy, Pymunk and Pillow together take longer to import
# than `pymunk-dragon --help` may take to answer. `drawing` does not import its `debug_draw`, which
# needs Pymunk.
_NAMES = {
    "collision": "FirstContact Grid NearMiss Separation first_contact scan separation",
    "drawing": "Camera Film render",
    "drawing.debug_draw": "PillowDrawOptions",
    "dynamics": "joint_forces pull",
    "errors": (
        "DragonError FileFormatError MissingExtraError OutputError ParameterError UnreachableError"
    ),
    "model.contact": "Contact ContactEvent ContactLog",
    "model.curves": "Arc Composite Curve Line Reversed Sampled Section Spiral UTurn check_curve",
    "model.dragon": "Dragon outlines",
    "model.march": "March States",
    "model.run": "Run",
    "model.scenario": "Scenario",
    "model.speed": "SpeedTable",
    "physics": "EngineSettings PathGuide World simulate",
    "player": "player_page write_player",
    "reports": "report",
    "sessions": "Button Draw Key PygameEvents Slider live",
    "studies": "max_speed min_pitch sensitivity u_turn",
    "sweeps": "Sweep sweep",
}
_MODULES = {name: module for module, names in _NAMES.items() for name in names.split()}

# Classes that notebooks show as pictures, and their modules.
_SHOWN = {"March": "pymunk_dragon.model.march", "Run": "pymunk_dragon.model.run"}


def _picture(source: Any) -> bytes:
    """Picture of a march or run, with which the drawing is loaded."""
    from pymunk_dragon.drawing.notebook import picture

    return picture(source)


def _register_pictures() -> None:
    """Register the pictures with IPython if this is one of its shells or notebooks."""
    python = sys.modules.get("IPython")
    shell = python and python.get_ipython()
    if shell is None:
        return

    formatter = shell.display_formatter.formatters["image/png"]
    for name, module in _SHOWN.items():
        formatter.for_type_by_name(module, name, _picture)


_register_pictures()

if TYPE_CHECKING:
    from pymunk_dragon.collision import *
    from pymunk_dragon.drawing import *
    from pymunk_dragon.drawing.debug_draw import *
    from pymunk_dragon.dynamics import *
    from pymunk_dragon.errors import *
    from pymunk_dragon.model.contact import *
    from pymunk_dragon.model.curves import *
    from pymunk_dragon.model.dragon import *
    from pymunk_dragon.model.march import *
    from pymunk_dragon.model.run import *
    from pymunk_dragon.model.scenario import *
    from pymunk_dragon.model.speed import *
    from pymunk_dragon.physics import *
    from pymunk_dragon.player import *
    from pymunk_dragon.reports import *
    from pymunk_dragon.sessions import *
    from pymunk_dragon.studies import *
    from pymunk_dragon.sweeps import *
else:
    __all__ = sorted(_MODULES)

    def __getattr__(name):
        if name in _MODULES:
            return getattr(import_module(f"pymunk_dragon.{_MODULES[name]}"), name)
        raise AttributeError(f"module 'pymunk_dragon' has no attribute '{name}'")

    def __dir__():
        return __all__
