"""Live sessions: a Pymunk space that is stepped in real time, and touched in a browser.

`pip install 'pymunk-dragon[live]'`, and then

```sh
pymunk-dragon live              # the dragon; or live unguided, near-miss, jam, pendulum, cradle, boxes ...
pymunk-dragon live --benches 40 --pitch 0.45 --record session.json
```

opens a page on which Pymunk plays in real time. Drag any bench with the mouse or a finger, cut joints, let the
dancers go and have them come back, add obstacles, and move the sliders: time step, iterations, drag, speed, pitch,
width, number of benches. The exact dragon is drawn beside the engine's, with the position error, the tension and the
time of a step as charts.

![A pointer pulls a bench aside, the dancers carry it back, and a slider makes the head faster](renders/live.gif)

## Any Pymunk space

In Python and notebooks, any space plays in the same page, drawn as Pymunk's debug drawing draws it, with sliders,
buttons and keys of yours. Give a function that builds the space, so that it can begin anew: `live` has an example.
`on_step` is called before each step, `plots` are shown as charts beside energy and momentum, and an exception in a
function of yours pauses the session and shows its line on the page.

In a notebook such a session is shown where a cell ends with it. With `pip install 'pymunk-dragon[notebook]'` it is a
widget: no port is opened until `session.address` is read, and a picture remains when the notebook is opened later.

## A program with a loop of its own

A pygame program plays on the page with its keys and its mouse when three of its lines change: it imports
`from pymunk_dragon import PygameEvents, live`, opens a session after its space,
`session = live(space, step=None, y_down=True, units="px", controls=[PygameEvents()])`, and makes its steps by
`session.step(dt)` in place of `space.step(dt)`. So do these examples of Pymunk's (`python -m pymunk.examples`); those
whose y points up have no `y_down`:

| examples | after the line | in place of | y points |
| --- | --- | --- | --- |
| arrows, camera, flipper, planet, point_query | `space = pymunk.Space()` | `space.step` | down |
| collisions, constraints, damped_rotary_spring_pointer | `space = pymunk.Space()` | `space.step` | down |
| deformable, index_video | `space = pymunk.Space()` | `space.step` | down |
| balls_and_lines, breakout, contact_with_friction | `space = pymunk.Space()` | `space.step` | up |
| platformer, slide_and_pinjoint, using_sprites | `space = pymunk.Space()` | `space.step` | up |
| bouncing_balls | `self._space = pymunk.Space()` | `self._space.step` | down |
| box2d_pyramid | `self.space = pymunk.Space()` | `self.space.step` | up |
| contact_and_no_flipy | `space = pm.Space()` | `space.step` | down |
| newtons_cradle | `space = pm.Space()` | `space.step` | up |
| playground | `self.space = pm.Space()` | `self.space.step` | up |

## Recordings

**Film** in the page films the picture. `--record FILE` writes the inputs at the end. Each has the number of the step
before which it took effect, so `--replay FILE` repeats a session: to the bit on the same machine and versions;
elsewhere the program says by how much the last poses differ. Of a dragon's recording one makes a run, which `render`
films:

```sh
pymunk-dragon live --replay renders/live.json --exit -o replay.npz
```

## A class

The program prints two addresses: one to control the session, and one to watch it. The server listens on this machine
only; with `--host 0.0.0.0` others can connect, and need one of the addresses, which have a token. Behind a proxy,
`--allow-host NAME` gives the name that browsers see.

## Measurements

On two cores, the first frame of 223 benches is there 0.39 s after the start of the process, and Chromium shows 60
pictures a second of 223 benches, 58 of a pyramid of 325 boxes and 21 of 3,000 circles. 20 clients, one of which
drags, get 60 frames a second at 1.00 times real time, and the process has 92 MB after 5 minutes, 8 more than after 2,
as it keeps the inputs. A body follows the mouse after 50 ms (`tests/bench/bench_live.py`). A client that takes
frames slowly gets fewer of them.
"""

from __future__ import annotations

from pymunk_dragon.sessions.controls import Button, Key, PygameEvents, Slider
from pymunk_dragon.sessions.handle import Live, live

__all__ = ["Button", "Key", "Live", "PygameEvents", "Slider", "live"]
