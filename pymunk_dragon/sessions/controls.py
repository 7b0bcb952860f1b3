"""Sliders, buttons and keys by which a page changes a space."""

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
_NAMED_KEYS = (
    "ArrowLeft ArrowRight ArrowUp ArrowDown Enter Tab Escape Backspace Delete Insert Home End "
    "PageUp PageDown Shift Control Alt Meta CapsLock F1 F2 F3 F4 F5 F6 F7 F8 F9 F10 F11 F12"
)
_MODIFIERS = ("LSHIFT", "LCTRL", "LALT", "LMETA")


@dataclass(frozen=True)
class Slider:
    """A number that the page changes.

    Parameters
    ----------
    name : str
        Name of an argument of the function that builds the space; or "step", "gravity", "damping"
        or "iterations", a property of the space; or any name of a slider with an action.
    low : float
        Lowest value.
    high : float
        Highest value.
    value : float, optional
        Value at the start. By default, that of the argument or the property of this name.
    rebuilds : bool
        Whether a change builds the space again, with the value as the argument `name`. Otherwise
        `action` is called or, without one, the property is set. The "step", in ms, changes by 1 % a
        step until it has the new value, so that the joints are not jolted.
    action : callable, optional
        Called as ``action(space, value)`` at each change.
    label : str
        Text on the page. By default, the name.
    unit : str
        Unit of the values, which the page shows behind them.
    logarithmic : bool
        Whether the scale is logarithmic.
    whole : bool
        Whether values are whole numbers.

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
        finite("low", self.low, unit=self.unit)
        if not finite("high", self.high, unit=self.unit) > self.low:
            raise ParameterError("high", self.high, f"a number above {self.low:g}")
        if self.logarithmic and self.low <= 0:
            raise ParameterError("low", self.low, "above 0 on a logarithmic scale")
        if self.value is not None:
            self._checked("value", self.value)

    def checked(self, value: object) -> float:
        """The value, if it is in the range, and whole if it has to be."""
        return self._checked(self.name, value)

    def _checked(self, name: str, value: object) -> float:
        number = finite(name, value, self.low, self.high, self.unit)
        if not self.whole:
            return number
        if not number.is_integer():
            raise ParameterError(name, value, "a whole number")
        return int(number)


def slider_around(
    name: str, low: float, high: float, value: float, text: str, **options: Any
) -> Slider:
    """A slider with a text, whose range is wide enough for its value, wherever a space has it."""
    return Slider(name, min(low, value), max(high, value), value, label=text, **options)


@dataclass(frozen=True)
class Button:
    """A button with a text that calls a function.

    Parameters
    ----------
    name : str
        Text of the button.
    action : callable
        Called as ``action(space)`` when the button is pressed.

    Examples
    --------
    >>> from pymunk_dragon import Button
    >>> Button("Float", lambda space: setattr(space, "gravity", (0, 0))).name
    'Float'
    """

    name: str
    action: _Action

    def __post_init__(self) -> None:
        label("name", self.name)
        function("action", self.action)


@dataclass(frozen=True)
class Key(Button):
    """A key that calls a function, and does nothing else on the page.

    The page also has a button for it, which a finger can hold.

    Parameters
    ----------
    name : str
        Name of the key, that of `KeyboardEvent.key` in browsers: a character as " " or "x", or
        "ArrowLeft", "Enter", "Escape", "Shift", "F5" and the like.
    action : callable
        Called as ``action(space)`` when the key is pressed.
    up : callable, optional
        Called as ``up(space)`` when the key is released.

    Examples
    --------
    >>> from pymunk_dragon import Key
    >>> Key("ArrowUp", lambda space: setattr(space, "gravity", (0, 900))).name
    'ArrowUp'
    """

    up: _Action | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        is_character = len(self.name) == 1 and self.name.isprintable()
        if not is_character and self.name not in _NAMED_KEYS.split():
            raise ParameterError("name", self.name, f"a character, or one of {_NAMED_KEYS}")
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
        self._place = (0, 0)
        # Position at the last call of `get_rel`.
        self._place_before = (0, 0)
        # Left, middle and right; a mouse with five has two more, which the page does not send.
        self._buttons = [False] * 3
        # Parts of notches that are not posted yet.
        self._right = 0.0
        self._up = 0.0

        pygame.key.get_pressed = lambda: self._keys
        pygame.key.get_mods = self._mods
        pygame.mouse.get_pos = lambda: self._place
        pygame.mouse.get_rel = self._moved
        pygame.mouse.get_pressed = self._pressed

    @property
    def view(self) -> tuple[float, float, float, float] | None:
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
        """Move the pointer to a pixel of the window; `kind` is "move", or what a button does."""
        before = self._place
        self._place = (round(x), round(y))
        if self._place != before:
            moved = _difference(self._place, before)
            buttons = tuple(map(int, self._buttons))
            self._post("MOUSEMOTION", pos=self._place, rel=moved, buttons=buttons, touch=False)
        if kind != "move":
            self._buttons[button - 1] = kind == "down"
            self._click(kind, button)

    def wheel(self, right: float, up: float) -> None:
        """Turn the wheel by notches; as in pygame, whole ones are posted, also as buttons."""
        self._right += right
        self._up += up
        x = math.trunc(self._right)
        y = math.trunc(self._up)
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
        """The number of a key in pygame, which is that of the character if the key has one."""
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
        moved = _difference(self._place, self._place_before)
        self._place_before = self._place
        return moved

    def _pressed(self, num_buttons: int = 3, desktop: bool = False) -> tuple[bool, ...]:
        """Which buttons are down, of three or five."""
        return (*self._buttons, False, False)[:num_buttons]


def _difference(place: tuple[int, int], before: tuple[int, int]) -> tuple[int, int]:
    return place[0] - before[0], place[1] - before[1]
