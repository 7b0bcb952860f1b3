"""Messages that a page sends to a session, one class each, and those that wait for the session."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from pymunk_dragon._checks import MAX_COORDINATE, finite, flag, label, positive, whole, word
from pymunk_dragon.errors import ParameterError
from pymunk_dragon.sessions.dragon import DragonScene
from pymunk_dragon.sessions.scene import Scene

# Largest whole number of a page: the last one that JavaScript tells from its neighbours.
_MAX_WHOLE = 2**53
# Single steps of a message: a few minutes of simulated time.
_MAX_COUNT = 100_000
# Least and largest simulated time over real time.
_MIN_SPEED = 0.1
_MAX_SPEED = 20.0
# Largest turn of the wheel in a message, in notches: more than a hand makes between two pictures.
_MAX_NOTCHES = 100.0


# Classes of messages by their names in JSON.
KINDS: dict[str, type[Message]] = {}


@dataclass(frozen=True, kw_only=True)
class Message:
    """A message of a page; its fields are the arguments in JSON, beside the name `do`."""

    do: ClassVar[str]

    def __init_subclass__(cls) -> None:
        """Register a class that has a name of its own."""
        if "do" in vars(cls):
            KINDS[cls.do] = cls

    def key(self) -> object:
        """Key by which a later message replaces this one while it waits, or None."""
        return None

    def to_dict(self) -> dict[str, Any]:
        """The message as JSON has it."""
        return {"do": self.do, **vars(self)}

    def _check(self, limit: float, *names: str) -> None:
        """Raise an error if one of these fields is no number from `-limit` to `limit`."""
        for name in names:
            finite(name, getattr(self, name), -limit, limit)


class Input(Message):
    """A message that changes a scene. Recordings consist of inputs."""

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        raise NotImplementedError


# ---- messages to the session


class Play(Message):
    """Make steps in real time."""

    do = "play"


class UntilContact(Play):
    """Make steps in real time until two bodies touch."""

    do = "until_contact"


class Pause(Message):
    """Make no steps."""

    do = "pause"


class Reset(Message):
    """Build the scene again, with the first values of all sliders."""

    do = "reset"

    def key(self) -> object:
        """One key for all: of many resets that wait, one is enough."""
        return self.do


@dataclass(frozen=True, kw_only=True)
class Step(Message):
    """Pause, and make `count` steps as fast as possible."""

    do = "step"

    count: int

    def __post_init__(self) -> None:
        whole("count", self.count, 1, _MAX_COUNT)


@dataclass(frozen=True, kw_only=True)
class Speed(Message):
    """Set the simulated time over real time."""

    do = "speed"

    value: float

    def __post_init__(self) -> None:
        finite("speed", self.value, _MIN_SPEED, _MAX_SPEED, "times")


@dataclass(frozen=True, kw_only=True)
class ChangeScene(Message):
    """Build another scene, by its name."""

    do = "scene"

    name: str

    def __post_init__(self) -> None:
        label("name", self.name)

    def key(self) -> object:
        """One key for each scene: of many messages that wait for it, one is enough."""
        return self.do, self.name


@dataclass(frozen=True, kw_only=True)
class Ping(Message):
    """Have `id` sent back, as a sign that the connection works."""

    do = "ping"

    id: int

    def __post_init__(self) -> None:
        whole("id", self.id, -_MAX_WHOLE, _MAX_WHOLE)


@dataclass(frozen=True, kw_only=True)
class Show(Message):
    """Have frames with the contacts, or without them: a page gets no others than it shows."""

    do = "show"

    contacts: bool

    def __post_init__(self) -> None:
        flag("contacts", self.contacts)


# ---- inputs


@dataclass(frozen=True, kw_only=True)
class Set(Input):
    """Set a slider."""

    do = "set"

    name: str
    value: float

    def __post_init__(self) -> None:
        label("name", self.name)
        # The scene checks the range of the slider.
        self._check(math.inf, "value")

    def key(self) -> object:
        """One key for each slider: of many values that wait for it, the last is set."""
        return self.do, self.name

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        scene.set(self.name, self.value)


@dataclass(frozen=True, kw_only=True)
class _At(Input):
    """An input at a point."""

    x: float
    y: float

    def __post_init__(self) -> None:
        self._check(MAX_COORDINATE, "x", "y")


@dataclass(frozen=True, kw_only=True)
class _Near(_At):
    """An input at a point, which may miss its target by `slip`."""

    slip: float

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check(MAX_COORDINATE, "slip")


class Grab(_Near):
    """Hold the body that is drawn on top at a point, or the nearest within `slip`."""

    do = "grab"

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        scene.grab(self.x, self.y, self.slip)


class Drag(_At):
    """Pull the body that is held towards a point."""

    do = "drag"

    def key(self) -> object:
        """One key for all: of many points that wait, the last is the pointer's."""
        return self.do

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        scene.drag(self.x, self.y)


class Drop(Input):
    """Let go of the body that is held."""

    do = "drop"

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        scene.drop()


class Cut(_Near):
    """Cut the joint within `slip` of a point."""

    do = "cut"

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        scene.cut(self.x, self.y, self.slip)


@dataclass(frozen=True, kw_only=True)
class Obstacle(_At):
    """Add an obstacle, "round" or "square", `size` in diameter or side."""

    do = "obstacle"

    shape: str
    size: float

    def __post_init__(self) -> None:
        super().__post_init__()
        word("shape", self.shape, ("round", "square"))
        positive("size", self.size, MAX_COORDINATE, "")

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        scene.obstacle(self.shape, self.x, self.y, self.size)


@dataclass(frozen=True, kw_only=True)
class Remove(Input):
    """Remove the obstacle of a number."""

    do = "remove"

    obstacle: int

    def __post_init__(self) -> None:
        whole("obstacle", self.obstacle, 0, _MAX_WHOLE)

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        scene.remove(self.obstacle)


@dataclass(frozen=True, kw_only=True)
class Press(Input):
    """Press a button or a key, or release a key."""

    do = "press"

    name: str
    down: bool

    def __post_init__(self) -> None:
        label("name", self.name)
        flag("down", self.down)

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        scene.press(self.name, self.down)


@dataclass(frozen=True, kw_only=True)
class Click(_At):
    """Click at a point, for a program with `on_click`."""

    do = "click"

    button: int

    def __post_init__(self) -> None:
        super().__post_init__()
        whole("button", self.button, 1, 3)

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        scene.click(self.x, self.y, self.button)


@dataclass(frozen=True, kw_only=True)
class Pointer(_At):
    """Move the pointer of a pygame program; a button goes "down" or "up", or none: "move"."""

    do = "pointer"

    kind: str
    button: int

    def __post_init__(self) -> None:
        super().__post_init__()
        word("kind", self.kind, ("down", "move", "up"))
        whole("button", self.button, 1, 3)

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        scene.pointer(self.x, self.y, self.kind, self.button)


@dataclass(frozen=True, kw_only=True)
class Wheel(Input):
    """Turn the wheel of a pygame program by notches to the right, and up."""

    do = "wheel"

    right: float
    up: float

    def __post_init__(self) -> None:
        self._check(_MAX_NOTCHES, "right", "up")

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        scene.pygame_events().wheel(self.right, self.up)


@dataclass(frozen=True, kw_only=True)
class Contacts(Input):
    """Choose what contacts of a dragon do."""

    do = "contacts"

    value: str

    def __post_init__(self) -> None:
        label("value", self.value)

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        _dragon_of(scene, self).contacts(self.value)


@dataclass(frozen=True, kw_only=True)
class Release(Input):
    """Let the dancers of a bench and of all behind it go."""

    do = "release"

    bench: int

    def __post_init__(self) -> None:
        whole("bench", self.bench, 0, _MAX_WHOLE)

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        _dragon_of(scene, self).world.release(self.bench)


class Hold(Input):
    """Bring the dancers back."""

    do = "hold"

    def apply(self, scene: Scene) -> None:
        """Change a scene."""
        _dragon_of(scene, self).world.hold()


def read_message(found: object) -> Message:
    """The message of a JSON object, which has an action, all its arguments, and nothing else."""
    if isinstance(found, dict):
        kind = KINDS.get(str(found.get("do")))
        arguments = {name: value for name, value in found.items() if name != "do"}
        if kind is not None and arguments.keys() == {each.name for each in fields(kind)}:
            return kind(**arguments)

    actions = ", ".join(KINDS)
    raise ParameterError("message", found, f"an action with its arguments: do is one of {actions}")


def read_input(found: object) -> Input:
    """The input of a JSON object."""
    message = read_message(found)
    if isinstance(message, Input):
        return message
    raise ParameterError("message", found, "an action that changes a scene")


class Waiting:
    """Actions that wait for the next turn of a session.

    Any thread may add actions; there is a lock of its own.
    """

    def __init__(self) -> None:
        self._actions: dict[object, Callable[[], object]] = {}
        self._added = threading.Condition()

    def __len__(self) -> int:
        return len(self._actions)

    def add(self, action: Callable[[], object], key: object = None) -> None:
        """Add an action, in place of one that waits with the same key."""
        with self._added:
            self._actions.pop(key, None)
            self._actions[object() if key is None else key] = action
            self._added.notify()

    def take(self) -> list[Callable[[], object]]:
        """Take all actions, in their order."""
        with self._added:
            actions = [*self._actions.values()]
            self._actions.clear()
        return actions

    def wait(self, seconds: float) -> None:
        """Return when an action waits, at the latest after `seconds`."""
        with self._added:
            self._added.wait_for(lambda: self._actions, seconds)


def _dragon_of(scene: Scene, message: Input) -> DragonScene:
    """The scene, if it has dancers."""
    if isinstance(scene, DragonScene):
        return scene
    raise ParameterError("message", message.do, "an action that this scene has")
