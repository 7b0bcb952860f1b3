"""Sliders, buttons and keys by which a page changes a space."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass
from typing import Any

import pymunk

from pymunk_dragon._checks import finite, flag, function, label
from pymunk_dragon._extras import library
from pymunk_dragon.errors import ParameterError

_Action = Callable[[pymunk.Space], object]
# Names of keys in browsers, and those of pygame's constants where they differ.
_KEY_NAMES = {
    "Enter": "RETURN",
    "Shift": "LSHIFT",
    "Control": "LCTRL",
    "Alt": "LALT",
    "Meta": "LMETA",
}
_MODIFIERS = "LSHIFT", "LCTRL", "LALT", "LMETA"


@dataclass(frozen=True)
class Slider:
    """A number that the page changes.

    Parameters
    ----------
    name, low, high, value : str, float, float, float, optional
        Name, range, and value at the start, by default that of the argument of this name, or of the
        space.
    rebuilds, action : bool, callable, optional
        Whether a change builds the space again, with the value as the argument `name` of the
        function; otherwise ``action(space, value)`` is called, or "step", ms, "gravity", "damping"
        or "iterations" is set. The lengths of steps approach a new "step" by 1 % each, so that the
        change does not jolt the joints.
    label, unit, logarithmic, whole : str, str, bool, bool
        Text on the page in place of the name, unit, kind of the scale, and whether values are whole
        numbers.

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
        """The value, if it is in the range, and whole if it has to be."""
        number = finite(self.name, value, self.low, self.high, self.unit)
        if self.whole and not number.is_integer():
            raise ParameterError(self.name, value, "a whole number")
        return int(number) if self.whole else number


def slider_around(name: str, low: float, high: float, value: float, **options: Any) -> Slider:
    """A slider whose range also has its value, as that of a space may lie anywhere."""
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
    """Keys and mouse of the page as pygame's events, for a pygame program that uses `Live.step`.

    pygame's ``key.get_pressed``, ``key.get_mods``, ``mouse.get_pos``, ``mouse.get_rel`` and
    ``mouse.get_pressed`` then have the state of the page, also before the program opens a window
    and without one. Events are posted only while there is a window, as pygame takes no others.
    The page shows the area of the window. With ``SDL_VIDEODRIVER=dummy`` no screen is needed. A
    `MissingExtraError` is raised if pygame is not installed.

    Examples
    --------
    >>> session = live(space, step=None, y_down=True, controls=[PygameEvents()])  # doctest: +SKIP
    >>> session.step(1 / 60)  # doctest: +SKIP
    """

    def __init__(self) -> None:
        self._pygame = pygame = library("pygame")
        self._keys: defaultdict[int, bool] = defaultdict(bool)
        self._place = self._place_before = (0, 0)
        # Left, middle and right; a mouse with five has two more, which the page does not send.
        self._buttons = [False] * 3
        # Parts of notches, to the right and up, that are not posted yet.
        self._right = self._up = 0.0
        pygame.key.get_pressed = lambda: self._keys
        pygame.key.get_mods = self._mods
        pygame.mouse.get_pos = lambda: self._place
        pygame.mouse.get_rel = self._moved
        pygame.mouse.get_pressed = self._pressed

    @property
    def field(self) -> tuple[float, float, float, float] | None:
        """Centre, width and height of pygame's window, if it has one."""
        surface = self._pygame.display.get_surface()
        if surface is None:
            return None
        width, height = surface.get_size()
        return width / 2, height / 2, width, height

    def key(self, name: str, down: bool) -> None:
        """Press or release a key with a name of the browser's, if pygame has that key."""
        code = self._code(name)
        if code is None:
            return
        self._keys[code] = down
        kind = "KEYDOWN" if down else "KEYUP"
        text = name if len(name) == 1 else ""
        self._post(kind, key=code, mod=self._mods(), unicode=text, scancode=0)

    def pointer(self, x: float, y: float, kind: str, button: int) -> None:
        """Move the pointer to a pixel of the window; a button goes "down" or "up", or none: "move"."""
        before, self._place = self._place, (round(x), round(y))
        if self._place != before:
            moved = self._place[0] - before[0], self._place[1] - before[1]
            buttons = tuple(map(int, self._buttons))
            self._post("MOUSEMOTION", pos=self._place, rel=moved, buttons=buttons, touch=False)
        if kind != "move":
            self._buttons[button - 1] = kind == "down"
            self._click(kind, button)

    def wheel(self, right: float, up: float) -> None:
        """Turn the wheel by notches: as in pygame itself, whole ones, also as buttons 4 and 5."""
        self._right += right
        self._up += up
        x, y = math.trunc(self._right), math.trunc(self._up)
        if x == y == 0:
            return
        for _ in range(abs(y)):
            for kind in ("down", "up"):
                self._click(kind, 4 if y > 0 else 5)
        turned = {"x": x, "y": y, "precise_x": self._right, "precise_y": self._up}
        self._post("MOUSEWHEEL", **turned, flipped=False, which=0, touch=False)
        self._right -= x
        self._up -= y

    def _click(self, kind: str, button: int) -> None:
        self._post(f"MOUSEBUTTON{kind.upper()}", pos=self._place, button=button, touch=False)

    def _post(self, kind: str, **values: object) -> None:
        """Post an event; without a window, or when its queue is full, pygame takes none."""
        pygame = self._pygame
        with suppress(pygame.error):
            pygame.event.post(pygame.event.Event(getattr(pygame, kind), values))

    def _code(self, name: str) -> int | None:
        """Pygame's number of a key, which is that of the character if it has one."""
        if len(name) == 1:
            return ord(name.lower()[0])
        name = _KEY_NAMES.get(name, name.removeprefix("Arrow").upper())
        code: int | None = getattr(self._pygame, f"K_{name}", None)
        return code

    def _mods(self) -> int:
        """The modifier keys that are down."""
        pygame = self._pygame
        names = [name for name in _MODIFIERS if self._keys[getattr(pygame, f"K_{name}")]]
        return sum(getattr(pygame, f"KMOD_{name}") for name in names)

    def _moved(self) -> tuple[int, int]:
        """How far the pointer has moved since the last call."""
        before, self._place_before = self._place_before, self._place
        return self._place[0] - before[0], self._place[1] - before[1]

    def _pressed(self, num_buttons: int = 3, desktop: bool = False) -> tuple[bool, ...]:
        """Which buttons are down, of three or five."""
        return (*self._buttons, False, False)[:num_buttons]
