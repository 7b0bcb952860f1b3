"""Rendering: pictures of a dragon's state, films, figures and debug drawing.

`render` and `pymunk-dragon render` take the format from the file's ending: a GIF, an animated WebP,
an MP4 (with `pip install 'pymunk-dragon[mp4]'`), or a PNG of one moment. The program also writes
the page of `pymunk_dragon.player`, `.html`. Several runs stand side by side, and `--exact` puts the
exact model beside a run.

```console
$ pymunk-dragon simulate --from 405 -o run.npz
$ pymunk-dragon render run.npz -o head.gif --camera head --speedup 2 --from 409
$ pymunk-dragon render run.npz --exact -o both.gif --camera head --from 411 --speedup 1
$ pymunk-dragon render run.npz -o marks.png --camera head --velocities --grid --forces --contacts
```

![The head passes benches 9 and 11; its first contact is with bench 8](renders/first_contact.gif)

![The engine, and the exact model with the engine's position error magnified](renders/exact.gif)

Without options a film shows what a class should see. It slows down towards near misses and
contacts, shows at most 0.66 m of march a frame, lasts at least 8 s at 20 frames a second, and holds
its last frame for 2.5 s. The reference march is shown from t = 338 s in 11 s; `--from 0` shows all
of it in 37 s. `--speedup`, `--fps`, `--from`, `--until` and `--hold` override this. `--lang zh`
writes in Chinese (`pip install 'pymunk-dragon[chinese]'`).

Flags lay marks over the benches: velocities, the grid, forces in the joints, contacts and their
normals. `--title` and `--caption` stand above and below:

![Arrows, discs and cells laid over the benches at the first contact](renders/marks.png)

A frame of a GIF of 640 x 640 pixels takes `render` 5.4 ms, imageio 26.2 ms and matplotlib 41.7 ms
(`python tests/bench/bench.py film`).
"""

from pymunk_dragon.drawing.camera import Camera
from pymunk_dragon.drawing.film import FILM_ENDINGS, STILL_ENDINGS, render, still_png
from pymunk_dragon.drawing.film.settings import Film
from pymunk_dragon.drawing.marks import OVERLAYS

__all__ = ["FILM_ENDINGS", "OVERLAYS", "STILL_ENDINGS", "Camera", "Film", "render", "still_png"]
