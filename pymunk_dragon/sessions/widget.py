"""A live session as a widget of a notebook, without a port.

Frames and messages go over the kernel's own channel.
"""

from collections.abc import Sequence
from contextvars import copy_context
from time import perf_counter
from typing import Any

from anywidget import AnyWidget
from IPython.display import display
from traitlets import Unicode

from pymunk_dragon._language import language
from pymunk_dragon.sessions.client import PostedClient
from pymunk_dragon.sessions.page import live_page
from pymunk_dragon.sessions.session import Session
from pymunk_dragon.web.html import asset, data_address

# Time without a message from the page, s, after which nothing is sent, as queues have no bound. A
# page sends a message every 5 s.
SILENCE = 15.0
# What the widget sends for the page.
REQUEST = "page"


class LiveWidget(PostedClient, AnyWidget):
    """The page of a session, in a frame.

    The notebook stores the traits that are synchronized: the page is not one of them, and is sent
    when the widget requests it.
    """

    _esm = asset(__package__, "assets/widget.js")
    # Class of the picture that the page replaces.
    still = Unicode().tag(sync=True)

    def __init__(self, session: Session) -> None:
        AnyWidget.__init__(self)
        PostedClient.__init__(self, session)
        self.still = f"live-{self.model_id}"
        # The page has the language of the caller, which other threads do not have.
        self._page, _ = live_page(session.source.title, language())
        self._heard = 0.0
        # The context of the page's newest message.
        self._context = copy_context()
        self.on_msg(self._receive)

    def shown(self) -> Any:
        """Display a picture of the present state, and return the page as a bundle.

        The picture remains in the notebook.
        """
        with self.session.held:
            content = self.session.scene.picture()
        source = data_address(content, "image/png")
        picture = f'<img class="{self.still}" alt="A live session" src="{source}">'
        # The picture has an output of its own: JupyterLab shows nothing else of an output whose
        # widget is gone.
        display({"text/html": picture, "text/plain": self.session.source.title}, raw=True)
        return self._repr_mimebundle_()

    def stop(self) -> None:
        """Take no more messages, and have the page say so."""
        self.on_msg(self._receive, remove=True)
        super().stop()

    def show(self, frame: bytes, outlines: bytes) -> None:
        """Send a frame, unless the page has to draw those before it."""
        if perf_counter() - self._heard > SILENCE:
            self.session.leave(self)
        else:
            super().show(frame, outlines)

    def post(self, content: dict[str, Any], buffers: Sequence[bytes] = ()) -> None:
        """Send in the context of the page's newest message.

        ipykernel 7.4 has an answer taken by the thread that took the message in whose context the
        question was sent. A page's messages may have a thread of their own; the cells' one takes
        none while a cell runs.
        """
        # A copy, as other threads may send at the same time.
        self._context.copy().run(self.send, content, list(buffers))

    def _receive(self, widget: object, content: object, buffers: object) -> None:
        self._context = copy_context()
        if content == REQUEST:
            self.post({"page": self._page})
            return
        self._heard = perf_counter()
        self.take_post(content)
