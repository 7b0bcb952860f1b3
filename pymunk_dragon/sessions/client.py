"""What a session needs of each page that shows it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from pymunk_dragon.errors import ParameterError
from pymunk_dragon.sessions.messages import Ping, read_message

if TYPE_CHECKING:
    from pymunk_dragon.sessions.session import Session


class Client:
    """A page that shows a session and, if it `controls` the session, changes it.

    Subclasses send texts and pictures by `send_text`, `show` and `stop`, which any thread may call.
    """

    session: Session
    controls = True

    def take(self, text: str) -> None:
        """Take a text of the page, which gets an answer if the text is no message that it may send."""
        try:
            message = read_message(json.loads(text))
            if isinstance(message, Ping):
                self.tell({"kind": "pong", "id": message.id})
            elif self.controls:
                self.session.receive(self, message)
            else:
                raise ParameterError("message", message.do, "ping, as this page only watches")
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

    def show(self, frame: bytes) -> None:
        """Send a picture to the page, unless it cannot take one now."""
        raise NotImplementedError

    def stop(self) -> None:
        """End the connection with the page."""
        raise NotImplementedError
