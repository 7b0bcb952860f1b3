"""What clients hold: a body, keys, and buttons of the pointer; released when the clients leave."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pymunk_dragon.sessions.messages import Drop, Grab, Input, Pointer, Press

_Thing = tuple[object, ...]

_HAND = ("hand",)


@dataclass
class _Hold:
    """What a client holds, and the message that lets go of it."""

    client: object
    thing: _Thing
    release: Input


class Holds:
    """What each client holds, noted as its messages take effect."""

    def __init__(self) -> None:
        self._all: list[_Hold] = []

    def allows(self, client: object, message: Input) -> bool:
        """Whether a message takes effect: what two hold is released when the second lets go."""
        thing, release = _taken(message)
        if thing is None or release is not None:
            return True
        holders = self._holders(thing)
        return len(holders) < 2 or client not in holders

    def note(self, client: object, message: Input) -> None:
        """Note what a message of a client takes hold of, or lets go of."""
        if isinstance(message, Pointer):
            self._move(client, message)
        thing, release = _taken(message)
        if thing is None:
            return

        # A client that releases a key or a button without holding it releases it for all. There is
        # one hand: a client that grabs another body takes it over.
        shared = thing != _HAND and (release is not None or client in self._holders(thing))
        gone = [client] if shared else self._holders(thing)
        self._all = [each for each in self._all if each.thing != thing or each.client not in gone]
        if release is not None:
            self._all.append(_Hold(client, thing, release))

    def leave(self, client: object) -> list[Input]:
        """Forget a client; return the messages that let go of what nobody else holds."""
        gone = [each for each in self._all if each.client is client]
        self._all = [each for each in self._all if each.client is not client]
        return [each.release for each in gone if not self._holders(each.thing)]

    def _holders(self, thing: _Thing) -> list[object]:
        return [each.client for each in self._all if each.thing == thing]

    def _move(self, client: object, pointer: Pointer) -> None:
        """Have buttons released where the pointer was last."""
        for each in self._all:
            if each.client is client and isinstance(each.release, Pointer):
                each.release = replace(each.release, x=pointer.x, y=pointer.y)


def _taken(message: Input) -> tuple[_Thing | None, Input | None]:
    """What a message takes or lets go of, or None, and the message that lets go of what it takes.

    The message is None if nothing is taken.
    """
    match message:
        case Grab():
            return _HAND, Drop()
        case Drop():
            return _HAND, None
        case Press():
            release = replace(message, down=False) if message.down else None
            return ("key", message.name), release
        case Pointer(kind="down"):
            return ("button", message.button), replace(message, kind="up")
        case Pointer(kind="up"):
            return ("button", message.button), None
    return None, None
