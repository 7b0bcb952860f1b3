"""Live sessions: a Pymunk space that is stepped in real time, and touched in a browser.

`pip install 'pymunk-dragon[live]'`, and then

```sh
pymunk-dragon live  # the dragon; or live unguided, near-miss, jam, pendulum, cradle, boxes ...
pymunk-dragon live --benches 40 --pitch 0.45 --record session.json
```

opens a page on which Pymunk plays in real time. Drag any bench with the mouse or a finger, cut
joints, let the dancers go and have them come back, add obstacles, and move the sliders. The exact
dragon is drawn beside the engine's, with the position error, the tension and the time of a step as
charts.

![A pointer pulls a bench aside, the dancers carry it back, and a slider makes the head
faster](renders/live.gif)

In Python and notebooks, any space plays in the same page: `live(build)` for a function that builds
the space. [A guide](renders/guides/live.md) has a whole program with sliders, buttons, keys and
charts, pygame programs that play on the page, 21 of Pymunk's own examples among them, recordings,
sessions for a class, and how fast all this is.
"""

from __future__ import annotations

from pymunk_dragon.sessions.controls import Button, Key, PygameEvents, Slider
from pymunk_dragon.sessions.draw import Draw
from pymunk_dragon.sessions.live import Live, live

__all__ = ["Button", "Draw", "Key", "Live", "PygameEvents", "Slider", "live"]
