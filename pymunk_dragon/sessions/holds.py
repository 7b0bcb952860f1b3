"""What clients hold: a body, keys, and buttons of the pointer; released when the clients leave."""

from collections import defaultdict
from dataclasses import replace

from pymunk_dragon.sessions.messages import Drop, Grab, Input, Pointer, Press

_Thing = tuple[object, ...]

_HAND = ("hand",)


class Holds:
    """What each client holds, noted as its messages take effect."""

    def __init__(self) -> None:
        # For each thing the clients that hold it, with the messages that let go of it.
        self._holders: defaultdict[_Thing | None, dict[object, Input]] = defaultdict(dict)

    def allows(self, client: object, message: Input) -> bool:
        """Whether a message takes effect: what two hold is released when the second lets go."""
        thing, release = _taken(message)
        holders = self._holders[thing]
        return release is not None or len(holders) < 2 or client not in holders

    def note(self, client: object, message: Input) -> None:
        """Note what a message of a client takes hold of, or lets go of."""
        if isinstance(message, Pointer):
            self._move(client, message)
        thing, release = _taken(message)
        holders = self._holders[thing]

        # A client that releases a key or a button without holding it releases it for all. There is
        # one hand: a client that grabs another body takes it over.
        if thing != _HAND and (release is not None or client in holders):
            holders.pop(client, None)
        else:
            holders.clear()
        if release is not None:
            holders[client] = release

    def leave(self, client: object) -> list[Input]:
        """Forget a client; return the messages that let go of what nobody else holds."""
        releases = []
        for holders in self._holders.values():
            release = holders.pop(client, None)
            if release is not None and not holders:
                releases.append(release)
        return releases

    def _move(self, client: object, pointer: Pointer) -> None:
        """Have buttons released where the pointer was last."""
        for holders in self._holders.values():
            release = holders.get(client)
            if isinstance(release, Pointer):
                holders[client] = replace(release, x=pointer.x, y=pointer.y)


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
