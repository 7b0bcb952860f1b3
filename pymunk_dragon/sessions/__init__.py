"""Live sessions: a Pymunk space that is stepped in real time, and touched in a browser.

`pip install 'pymunk-dragon[live]'`, and then

```sh
pymunk-dragon live              # the dragon; or live unguided, near-miss, jam, pendulum, cradle, boxes ...
pymunk-dragon live --benches 40 --pitch 0.45 --record session.npz
```

opens a page on which Pymunk plays in real time. Drag any bench with the mouse or a finger, cut joints, let the
dancers go and have them come back, add obstacles, and move the sliders: time step, iterations, drag, speed, pitch,
width, number of benches. The exact dragon is drawn beside the engine's, with the position error, the tension and the
time of a step as charts.

![Dancers let go of bench 30 and all behind it, bench 80 is pulled aside, and they return](renders/live.gif)

## Any Pymunk space

In Python and notebooks, any space of yours plays in the same page:

```python
import pymunk

from pymunk_dragon import live

space = pymunk.Space()
space.gravity = 0, -9.8
body = pymunk.Body(1, 1)
space.add(body, pymunk.Circle(body, 0.5), pymunk.PinJoint(space.static_body, body, (0, 3)))
with live(space, step=1 / 240, browser=False) as session:
    print(session.address)  # http://127.0.0.1:.../?token=...
```

## Recordings

**Record** in the page films the picture and keeps a run, which can be saved afterwards. `--record FILE` writes .npz,
or a film, at the end. Every input is logged with the number of the step before which it took effect, so
`--replay FILE` repeats a session: to the bit on the same machine and versions; elsewhere processors and libraries may
round differently, and the program says by how much the last poses differ. The film above is

```sh
pymunk-dragon live --replay renders/live.json --exit -o renders/live.gif
```

## A class

The program prints two addresses: one to control the session, and one to watch it. The server listens on this machine
only; with `--host 0.0.0.0` others can connect, and need one of the addresses, which have a token. Behind a proxy,
`--allow-host NAME` gives the name that browsers see.

## Measurements

On two cores, `python tests/bench/bench_live.py` measures:

| what | measured |
| --- | --- |
| first frame of 223 benches, after the start of the process | 1.44 s (1.38 to 1.62) |
| physics, and pictures in Chromium, of 223 benches | 1.00 times real time, 59 a second |
| the same with 20 clients | 1.00 times real time, 60 frames a second each |
| from a movement of the mouse to the moved body | 33 ms |
| memory while a client only watches, 9,000 s simulated | constant, 64 MB |
| memory while a client drags without a pause: 415,000 inputs, those of two hours | 64.2 to 64.8 MB |

## How it works

`live` starts a session. A `Scene` (`scenes/`) is a space with the actions that a user may take on it; a `Session`
steps it in a thread, logs every input with the number of the step before which it took effect, and makes frames; a
`Server` sends them to browsers. Physics never waits for a browser: a client that takes frames slowly gets fewer of
them.
"""

from __future__ import annotations

from pymunk_dragon.sessions.handle import Live, live

__all__ = ["Live", "live"]
