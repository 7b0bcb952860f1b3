"""Live sessions: a Pymunk space that is stepped in real time, and touched in a browser.

`live` starts a session. A `Scene` (`scenes/`) is a space with what a hand may do to it; a `Session` steps it in a
thread, logs every input with the number of the step before which it took effect, and makes frames; a `Server` sends
them to browsers. Physics never waits for a browser: a client that takes frames slowly gets fewer of them.
"""

from __future__ import annotations

from pymunk_dragon.sessions.handle import Live, live

__all__ = ["Live", "live"]
