"""Pages that show a session: what the session needs of each, and what all were sent."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.sessions.messages import Ping, Show, read_message

if TYPE_CHECKING:
    from pymunk_dragon.sessions.session import Session


# Frames on the way to a page to which they are posted, at most; the page acknowledges every third.
MOST_FRAMES = 6


class Client:
    """A page that shows a session and, if it `controls` the session, changes it.

    Subclasses send texts and pictures by `send_text`, `show` and `stop`, which any thread may call.
    """

    session: Session
    controls = True
    # The shapes that the page was sent last.
    outlines = b""
    # Whether frames need the contacts.
    shows_contacts = True

    def take(self, text: str) -> None:
        """Take a text of the page; an answer follows if it is no message that the page may send."""
        try:
            message = read_message(json.loads(text))
            if isinstance(message, Ping):
                self.tell({"kind": "pong", "id": message.id})
            elif isinstance(message, Show):
                self.shows_contacts = message.contacts
            elif self.controls:
                self.session.receive(self, message)
            else:
                raise ParameterError(
                    "message", message.do, "ping or show, as this page only watches"
                )
        except (ValueError, RecursionError) as error:
            self.tell({"kind": "error", "text": str(error)})

    def tell(self, message: dict[str, Any]) -> None:
        """Send a message, also with numbers of NumPy."""
        if message["kind"] == "scene" and not self.controls:
            message = message | {"role": "watch"}
        self.send_text(json.dumps(message, allow_nan=False, default=float))

    def send_text(self, text: str) -> None:
        """Send a text to the page."""
        raise NotImplementedError

    def show(self, frame: bytes, outlines: bytes) -> None:
        """Send a picture to the page, unless it cannot take one now.

        The shapes in it come first if the page does not have them.
        """
        raise NotImplementedError

    def stop(self) -> None:
        """End the connection with the page."""
        raise NotImplementedError


class PostedClient(Client):
    """A page to which content is posted: that of a notebook, or one whose worker has the session.

    A text from the page is a message; a number is that of a frame that the page has drawn, and 0
    that of a page that begins anew.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self._sent = 0
        self._drawn = 0

    def post(self, content: dict[str, Any], buffers: Sequence[bytes] = ()) -> None:
        """Post an object, and bytes beside it."""
        raise NotImplementedError

    def take_post(self, content: object) -> None:
        """Take what the page posted."""
        if content == 0 or self not in self.session.clients:
            # A page that begins anew has none of the frames that were sent before, and holds no
            # body.
            self.session.leave(self)
            self._drawn = self._sent
            self.outlines = b""
            self.session.join(self)
        if isinstance(content, str):
            self.take(content)
        elif isinstance(content, int):
            self._drawn = max(self._drawn, content)

    def send_text(self, text: str) -> None:
        """Post a text."""
        self.post({"text": text})

    def show(self, frame: bytes, outlines: bytes) -> None:
        """Post a frame, unless the page has to draw those before it."""
        if self._sent - self._drawn >= MOST_FRAMES:
            return
        if outlines not in (b"", self.outlines):
            self.outlines = outlines
            self.post({}, [outlines])
        self._sent += 1
        self.post({"frame": self._sent}, [frame])

    def stop(self) -> None:
        """Have the page say that the session has ended."""
        self.session.leave(self)
        self.post({"closed": True})


class Clients:
    """The clients of a session, and what those that join are sent first.

    There is a lock of its own.
    """

    def __init__(self) -> None:
        # Replaced and not changed, so that it may be read without the lock.
        self._all: tuple[Client, ...] = ()
        self._lock = threading.Lock()
        self._description: dict[str, Any] = {}
        self._state: dict[str, Any] | None = None
        self._failure: dict[str, Any] | None = None

    def __iter__(self) -> Iterator[Client]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    def join(self, client: Client) -> None:
        """Send a client all messages from now on.

        First come the scene, and the error by which the session is paused.
        """
        with self._lock:
            self._all = (*self._all, client)
            self._state = None
            client.tell(self._description)
            if self._failure is not None:
                client.tell(self._failure)

    def leave(self, client: Client) -> None:
        """Forget a client."""
        with self._lock:
            self._all = tuple(each for each in self._all if each is not client)

    def tell(self, message: dict[str, Any]) -> None:
        """Send a message to all clients."""
        with self._lock:
            for client in self._all:
                client.tell(message)

    def tell_scene(self, description: dict[str, Any] | None = None) -> None:
        """Send what describes the scene, also to those that join later; by default, again."""
        self._state = None
        self._description = description or self._description
        self.tell(self._description)

    def tell_state(self, state: dict[str, Any]) -> None:
        """Send a state, unless it was sent last."""
        if state != self._state:
            self._state = state
            self.tell(state)

    def tell_failure(self, failure: dict[str, Any], *, again: bool) -> bool:
        """Send an error, also to those that join later; whether it was sent.

        The error that was sent last is only sent `again` if it has to be.
        """
        is_new = again or failure != self._failure
        if is_new:
            self._failure = failure
            self.tell(failure)
        return is_new

    def forget_failure(self) -> None:
        """Send the next error, also if it is the same as the last one."""
        self._failure = None
