"""Sliders, buttons and keys by which a page changes a space."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass
from typing import Any

import pymunk

from pymunk_dragon._arguments import finite, flag, function, label
from pymunk_dragon._extras import library
from pymunk_dragon.errors import ParameterError

_Action = Callable[[pymunk.Space], object]
# Names of keys in browsers that pygame names otherwise.
_KEY_NAMES = {"Enter": "return", "Shift": "left shift", "Control": "left ctrl", "Alt": "left alt", " ": "space"}


@dataclass(frozen=True)
class Slider:
    """A number that the page changes.

    Parameters
    ----------
    name, low, high, value : str, float, float, float, optional
        Name, range, and value at the start, by default that of the argument of this name, or of the space.
    rebuilds, action : bool, callable, optional
        Whether a change builds the space again, with the value as the argument `name` of the function; otherwise
        ``action(space, value)`` is called, or "step", ms, "gravity", "damping" or "iterations" is set.
    label, unit, logarithmic, whole : str, str, bool, bool
        Text on the page in place of the name, unit, kind of the scale, and whether values are whole numbers.

    Examples
    --------
    >>> from pymunk_dragon import Slider
    >>> Slider("links", 2, 40, 12, rebuilds=True, whole=True).checked(7.0)
    7
    """

    name: str
    low: float
    high: float
    value: float | None = None
    _: KW_ONLY
    rebuilds: bool = False
    action: Callable[[pymunk.Space, float], object] | None = None
    label: str = ""
    unit: str = ""
    logarithmic: bool = False
    whole: bool = False

    def __post_init__(self) -> None:
        for name in ("name", "label", "unit"):
            label(name, getattr(self, name))
        for name in ("rebuilds", "logarithmic", "whole"):
            flag(name, getattr(self, name))
        if self.action is not None:
            function("action", self.action)
        finite("low", self.low, -math.inf, math.inf, self.unit)
        if not finite("high", self.high, -math.inf, math.inf, self.unit) > self.low:
            raise ParameterError("high", self.high, f"a number above {self.low:g}")
        if self.logarithmic and self.low <= 0:
            raise ParameterError("low", self.low, "above 0 on a logarithmic scale")
        if self.value is not None:
            value = finite("value", self.value, self.low, self.high, self.unit)
            if self.whole and not value.is_integer():
                raise ParameterError("value", self.value, "a whole number")

    def checked(self, value: object) -> float:
        """Return the value, if it is in the range, and whole if it has to be."""
        number = finite(self.name, value, self.low, self.high, self.unit)
        if self.whole and not number.is_integer():
            raise ParameterError(self.name, value, "a whole number")
        return int(number) if self.whole else number


def slider_around(name: str, low: float, high: float, value: float, **options: Any) -> Slider:
    """Return a slider whose range also has its value, as that of a space may lie anywhere."""
    return Slider(name, min(low, value), max(high, value), value, **options)


@dataclass(frozen=True)
class Button:
    """A button with a text that calls ``action(space)``.

    Examples
    --------
    >>> from pymunk_dragon import Button
    >>> Button("Stop all", lambda space: [setattr(body, "velocity", (0, 0)) for body in space.bodies]).name
    'Stop all'
    """

    name: str
    action: _Action

    def __post_init__(self) -> None:
        label("name", self.name)
        function("action", self.action)


@dataclass(frozen=True)
class Key(Button):
    """A key that calls ``action(space)``, and ``up(space)`` when it is released; it does nothing else on the page.

    Its name is that of `KeyboardEvent.key` in browsers, as "ArrowLeft", " " or "x".

    Examples
    --------
    >>> from pymunk_dragon import Key
    >>> Key("ArrowUp", lambda space: setattr(space, "gravity", (0, 900))).name
    'ArrowUp'
    """

    up: _Action | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.up is not None:
            function("up", self.up)


class PygameEvents:
    """Keys and the pointer of the page as pygame's events, for a pygame program that steps its space by `Live.step`.

    pygame's ``key.get_pressed``, ``key.get_mods``, ``mouse.get_pos`` and ``mouse.get_pressed`` then have the state of
    the page, which shows the area of pygame's window; with ``SDL_VIDEODRIVER=dummy`` the program needs no screen. A
    `MissingExtraError` is raised if pygame is not installed.

    Examples
    --------
    >>> session = live(space, step=None, y_down=True, controls=[PygameEvents()])  # doctest: +SKIP
    >>> session.step(1 / 60)  # doctest: +SKIP
    """

    def __init__(self) -> None:
        self._pygame = pygame = library("pygame")
        self._keys: defaultdict[int, bool] = defaultdict(bool)
        self._place, self._button = (0, 0), False
        pygame.key.get_pressed = lambda: self._keys
        pygame.mouse.get_pos = lambda: self._place
        pygame.mouse.get_pressed = lambda num_buttons=3: (self._button, False, False)

    @property
    def field(self) -> tuple[float, float, float, float] | None:
        """Centre, width and height of pygame's window, if it has one."""
        surface = self._pygame.display.get_surface()
        return surface and (surface.width / 2, surface.height / 2, surface.width, surface.height)

    def key(self, name: str, down: bool) -> None:
        """Post the event of a key with a name of the browser's, if pygame has that key."""
        pygame, keys = self._pygame, self._keys
        with suppress(ValueError):
            code = pygame.key.key_code(_KEY_NAMES.get(name, name.removeprefix("Arrow")))
            keys[code] = down
            mods = pygame.KMOD_SHIFT * keys[pygame.K_LSHIFT] | pygame.KMOD_CTRL * keys[pygame.K_LCTRL]
            pygame.key.set_mods(mods)
            kind, text = pygame.KEYDOWN if down else pygame.KEYUP, name if len(name) == 1 else ""
            pygame.event.post(pygame.event.Event(kind, key=code, mod=mods, unicode=text, scancode=0))

    def pointer(self, x: float, y: float, kind: str) -> None:
        """Post the event of the pointer at a pixel of pygame's window: "down", "up" or "move"."""
        event, before, self._place = self._pygame.event, self._place, (round(x), round(y))
        self._button = kind == "down" or (kind == "move" and self._button)
        moved = self._place[0] - before[0], self._place[1] - before[1]
        name = {"down": "MOUSEBUTTONDOWN", "up": "MOUSEBUTTONUP", "move": "MOUSEMOTION"}[kind]
        buttons = int(self._button), 0, 0
        # Each event has the attributes of all three.
        values = {"pos": self._place, "rel": moved, "button": 1, "buttons": buttons}
        event.post(event.Event(getattr(self._pygame, name), values))
